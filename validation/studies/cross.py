"""Do finite elements, or other solvers, and boundary elements agree on the same surface and grid, and ever better with refinement?"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from validation.effects.base import SlotName
from validation.measures.block import BlockMeasurement
from validation.measures.common import BASE_SOLID, Rising, RisingOrNone, each, results_of
from validation.measures.measurement import grid_for
from validation.measures.side_by_side import ByMethod
from validation.measures.statistics import order_of_convergence
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.realised import Realised
from validation.scenes.scene import Scene, SolidSpec
from validation.solves.bench import Bench
from validation.studies._options import Bandwidth, Element, Methods, Periods, ReducedPressure
from validation.studies._scene import PressedOptions
from validation.units import wrong

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from validation.solves.solve import NumbersSolve

__all__ = ["Options", "figures", "findings", "run", "table"]


class Options(PressedOptions):
    """What is pressed by both methods, and on which grids."""

    grids_of: ClassVar[Mapping[str, str]] = {}
    off: ClassVar[Mapping[str, Any]] = {"full_points_per_wave": (), "elements": ()}
    slots: ClassVar[frozenset[SlotName]] = frozenset({"response", "pressure bound", "gap law"})

    methods: Methods = ("bem", "fem")
    reduced_pressure: ReducedPressure = 0.05
    periods: Periods = 2.0
    bandwidth: Bandwidth = 4.0
    poisson: Annotated[float, Field(gt=-1, le=0.49, description="Poisson ratio of the solid")] = 0.3
    surfaces: Annotated[int, Field(ge=1, description="how many realisations")] = 2
    full_points_per_wave: RisingOrNone = Field(
        default=(3.0, 4.0, 6.0),
        description="grids of the full Hex1 system, as lambda_short/dx: the independent leg, which shares no contact "
        "algorithm with the boundary elements",
    )
    reduced_points_per_wave: Rising = Field(
        default=(3.0, 4.0, 6.0, 8.0, 16.0, 32.0),
        description="grids of the exact reduction, which shares it: agreement there checks the discretisation only",
    )
    elements: tuple[Element, ...] = Field(
        default=("Hex1", "Hex2"), description="elements of the reduction; none to leave it out"
    )
    method_points_per_wave: Rising = Field(
        default=(3.0, 4.0, 6.0, 8.0), description="grids of any other of the methods, as lambda_short/dx"
    )

    @model_validator(mode="after")
    def _two_methods(self) -> Self:
        if set(self.methods) <= {"bem"}:
            raise wrong("methods = bem: must name another solver beside bem, such as fem or tamaas")
        return self

    @property
    def _solid(self) -> dict[str, SolidSpec]:
        return {"solid": SolidSpec(young=BASE_SOLID.young, poisson=self.poisson)}

    @classmethod
    def taken(cls, scene: Scene, first: Realised) -> dict[str, Any]:
        """Return the options that a scene says, its Poisson ratio among them."""
        return {**super().taken(scene, first), "poisson": scene.solid.poisson}


@dataclass(frozen=True, kw_only=True)
class _Leg:
    """One way beside the boundary elements on one grid.

    Attributes
    ----------
    name : str
        What it is called.
    per_wave : float
        lambda_short / dx.
    solve : callable
        From `realised` to its solve.
    """

    name: str
    per_wave: float
    solve: Callable[..., NumbersSolve]


_NAMES = {
    "pressure_half_space": "||p - p_bem|| / ||p_bem||",
    "pressure_inside": "the same, 1.5 cells and more from the edges",
    "area": "A/A_bem - 1, points counted",
    "area_corrected": "A/A_bem - 1, each with its perimeter correction",
    "gap": "(mean gap - mean gap_bem) / h_rms: the offsets less C(0) p0",
    "residual": "largest contact residual of the method",
    "converged": "1 where its residuals are what it was asked for",
    "seconds": "processor time of the method [s]",
    "seconds_bem": "processor time of the boundary elements [s]",
}


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press the same heights by both methods.

    Returns
    -------
    xarray.Dataset
        Differences with dimensions (case, surface); cases are labelled by leg.
    """
    legs = (*_block_legs(options), *_other_legs(options))
    found = results_of(
        bench, {(leg, k): leg.solve(realised=own) for leg in legs for k, own in enumerate(options.pressed)}
    )
    differences = {case: _differences(data) for case, data in found.items()}
    return _dataset(differences, legs, options)


def _block_legs(options: Options) -> Iterator[_Leg]:
    """Yield the ways through the finite elements: the full system, and its exact reduction."""
    if options.scene is not None or "fem" not in options.methods:
        return
    ways: list[tuple[Literal["full", "reduced"], Element, float]] = [
        *(("full", "Hex1", n) for n in options.full_points_per_wave),
        *(("reduced", e, n) for e in options.elements for n in options.reduced_points_per_wave),
    ]
    for method, element, n in ways:
        solve = partial(BlockMeasurement, grid=grid_for(options.first, n), method=method, element=element)
        yield _Leg(name=f"{method} {element}", per_wave=n, solve=solve)


def _other_legs(options: Options) -> Iterator[_Leg]:
    """Yield all other solvers that are asked for; on a scene the finite elements as its table has them."""
    own = ("bem",) if options.scene is not None else ("bem", "fem")
    for asked in options.others(options.method_points_per_wave, without=own):
        for grid in asked.grids:
            solve = partial(
                ByMethod,
                grid=grid,
                method=asked.method,
                settings=asked.settings,
                effects=options.effects,
            )
            yield _Leg(name=asked.name, per_wave=options.first.points_per_wave(grid), solve=solve)


def _differences(data: xr.Dataset) -> dict[str, float]:
    """Return what is compared of one solve, by the names of the dataset."""
    numbers = {"converged": 1.0} | {name: float(data[name]) for name in _NAMES if name in data}
    area, corrected = data.pixel / data.pixel_bem, data.perimeter / data.perimeter_bem
    return numbers | {"area": float(area) - 1, "area_corrected": float(corrected) - 1}


def _dataset(
    differences: Mapping[tuple[_Leg, int], Mapping[str, float]], legs: tuple[_Leg, ...], options: Options
) -> xr.Dataset:
    import xarray as xr

    def rows(name: str) -> list[list[float]]:
        return [[differences[leg, k][name] for k in range(options.surfaces)] for leg in legs]

    return xr.Dataset(
        {
            name: (("case", "surface"), np.array(rows(name)), {"long_name": words})
            for name, words in _NAMES.items()
        },
        coords={
            "leg": ("case", [leg.name for leg in legs]),
            "points_per_wave": ("case", [leg.per_wave for leg in legs], {"long_name": "lambda_short / dx"}),
        },
        attrs={
            "study": "cross",
            "reduced_pressure": options.reduced_pressure,
            "methods": " ".join(["bem", *_listed(options), "perimeter"]),
        },
    )


def _listed(options: Options) -> list[str]:
    """Name the methods and effects whose papers are to be cited."""
    asked = [one.method for one in options.others((), without=("bem",))]
    return [*asked, *(effect.kind for effect in options.effects)]


def _legs(dataset: xr.Dataset) -> list[str]:
    return list(dict.fromkeys(dataset.leg.values.tolist()))


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each leg and grid, means over surfaces."""
    return ResultTable.of_rows(
        {
            "leg": str(case.leg.item()),
            "lambda_short/dx": float(case.points_per_wave),
            **{words: float(case[name].mean()) for name, words in _NAMES.items() if name != "converged"},
        }
        for case in each(dataset, "case")
    )


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return how the differences fall for each leg, and what the agreement means."""
    sentences = []
    for leg in _legs(dataset):
        part = dataset.isel(case=np.flatnonzero(dataset.leg.values == leg))
        spacing = 1 / part.points_per_wave.values
        pressure = part.pressure_half_space.mean("surface").values
        area = np.abs(part.area.mean("surface").values)
        text = (
            f"{leg}: the pressures differ by {100 * pressure[0]:.2g} % at {part.points_per_wave.values[0]:g} points per shortest wave and by "
            f"{100 * pressure[-1]:.2g} % at {part.points_per_wave.values[-1]:g}, the counted areas by {100 * area[0]:.2g} % and {100 * area[-1]:.2g} %"
        )
        if spacing.size > 1:
            text += f" (fitted order of the pressure difference in dx: {order_of_convergence(spacing, pressure):.2f})"
        missed = int((part.converged < 1).sum())
        if missed:
            text += f"; {missed} of its {part.converged.size} answers do not have the residuals asked for, the worst {float(part.residual.max()):.2g}"
        sentences.append(text + ".")
    if any(leg.startswith(("full ", "reduced ")) for leg in _legs(dataset)):
        sentences.append(
            "The full system shares no contact algorithm with the boundary elements: its agreement verifies both codes. The reduced one shares "
            "it: its agreement verifies the discretisation. What remains in the finest reduced rows includes the finite depth of the block."
        )
    return tuple(sentences)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw the differences against the grid."""
    return (
        Drawing(
            name="fem-against-bem",
            figure=_fem_against_bem(dataset),
            data=dataset[["pressure_half_space", "area", "area_corrected"]],
            caption="Difference of pressure (left) and of counted area (right) between other methods and boundary elements on "
            "the same surface and points, by leg; dots, surfaces.",
        ),
    )


def _fem_against_bem(dataset: xr.Dataset) -> Figure:
    """Pressure and area differences from boundary elements against the grid, by leg."""
    from validation.report.figure import COLOURS, new_figure, plain_look

    figure, panels = new_figure(width=9.0, columns=2)
    for axes, name, label in zip(
        panels,
        ("pressure_half_space", "area"),
        (r"$\|p-p_{BEM}\|/\|p_{BEM}\|$ [%]", r"$|A/A_{BEM}-1|$, counted [%]"),
        strict=True,
    ):
        for k, leg in enumerate(_legs(dataset)):
            part = dataset.isel(case=np.flatnonzero(dataset.leg.values == leg))
            mean = 100 * np.abs(part[name].mean("surface"))
            axes.plot(part.points_per_wave, mean, label=leg, **plain_look(k))
            axes.plot(
                part.points_per_wave, 100 * np.abs(part[name]), ls="", marker=".", ms=3, color=COLOURS[k]
            )
        axes.set_xscale("log", base=2)
        axes.set_yscale("log")
        axes.set_xlabel(r"$\lambda_{short}/\Delta x$")
        axes.set_ylabel(label)
    panels[0].legend(fontsize=8)
    return figure
