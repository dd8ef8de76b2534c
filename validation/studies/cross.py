"""Do finite elements and boundary elements agree on the same surface and grid, and ever better with refinement?"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field

from validation.measures.block import BlockMeasurement
from validation.measures.common import BASE_SOLID, Rising, base_case, base_surface, results_of
from validation.measures.measurement import grid_for
from validation.measures.statistics import order_of_convergence
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.scene import SolidSpec
from validation.solves.bench import Bench
from validation.studies._options import Bandwidth, Element, Hurst, Periods, ReducedPressure, Seed
from validation.studies._study import StudyOptions

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["Options", "figures", "findings", "run", "table"]


class Options(StudyOptions):
    """What is pressed by both methods, and on which grids."""

    reduced_pressure: ReducedPressure = 0.05
    hurst: Hurst = 0.8
    periods: Periods = 2.0
    bandwidth: Bandwidth = 4.0
    poisson: Annotated[float, Field(gt=-1, le=0.49, description="Poisson ratio of the solid")] = 0.3
    surfaces: Annotated[int, Field(ge=1, description="how many realisations")] = 2
    seed: Seed = 2006
    full_points_per_wave: Rising = Field(
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


@dataclass(frozen=True, kw_only=True)
class _Leg:
    """One way through the finite elements on one grid."""

    method: Literal["full", "reduced"]
    element: str
    per_wave: float

    @property
    def name(self) -> str:
        """Method and element."""
        return f"{self.method} {self.element}"


_NAMES = {
    "pressure_half_space": "||p_fem - p_bem|| / ||p_bem||",
    "pressure_inside": "the same, 1.5 cells and more from the edges",
    "area": "A_fem/A_bem - 1, points counted",
    "area_corrected": "A_fem/A_bem - 1, each with its perimeter correction",
    "gap": "(mean gap_fem - mean gap_bem) / h_rms: the offsets less C(0) p0",
    "residual": "largest contact residual of the finite elements",
    "seconds": "wall time of the finite elements [s]",
    "seconds_bem": "wall time of the boundary elements [s]",
}


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press the same heights by both methods.

    Returns
    -------
    xarray.Dataset
        Differences with dimensions (case, surface); cases are labelled by leg.
    """
    legs = tuple(_legs_of(options))
    found = results_of(bench, _cases(options, legs))
    differences = {case: _differences(data) for case, data in found.items()}
    return _dataset(differences, legs, options)


def _legs_of(options: Options) -> Iterator[_Leg]:
    for n in options.full_points_per_wave:
        yield _Leg(method="full", element="Hex1", per_wave=n)
    for element, n in itertools.product(options.elements, options.reduced_points_per_wave):
        yield _Leg(method="reduced", element=element, per_wave=n)


def _cases(options: Options, legs: tuple[_Leg, ...]) -> dict[tuple[_Leg, int], BlockMeasurement]:
    """List the solves: every leg on every surface."""
    surface = base_surface(
        hurst=options.hurst, periods=options.periods, bandwidth=options.bandwidth, seed=options.seed
    )
    solid = SolidSpec(young=BASE_SOLID.young, poisson=options.poisson)
    first = base_case(surface, reduced_pressure=options.reduced_pressure, solid=solid)
    pressed = [first.further(k) for k in range(options.surfaces)]
    return {
        (leg, k): BlockMeasurement(
            realised=pressed[k],
            points=grid_for(first, leg.per_wave)[0],
            method=leg.method,
            element=leg.element,
        )
        for leg, k in itertools.product(legs, range(options.surfaces))
    }


def _differences(data: xr.Dataset) -> dict[str, float]:
    """Return what is compared of one solve, by the names of the dataset."""
    numbers = {name: float(data[name]) for name in _NAMES if name in data}
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
            "methods": "bem fem perimeter",
        },
    )


def _legs(dataset: xr.Dataset) -> list[str]:
    return list(dict.fromkeys(dataset.leg.values.tolist()))


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each leg and grid, means over surfaces."""
    names = (
        "pressure_half_space",
        "pressure_inside",
        "area",
        "area_corrected",
        "gap",
        "residual",
        "seconds",
        "seconds_bem",
    )
    rows: list[tuple[float | str, ...]] = [
        (
            str(dataset.leg.values[i]),
            float(dataset.points_per_wave[i]),
            *(float(dataset[name][i].mean()) for name in names),
        )
        for i in range(dataset.sizes["case"])
    ]
    return ResultTable.of(("leg", "lambda_short/dx", *(_NAMES[name] for name in names)), rows)


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
        sentences.append(text + ".")
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
            caption="Difference of pressure (left) and of counted area (right) between finite and boundary elements on the "
            "same surface and points, by leg; dots, surfaces.",
        ),
    )


def _fem_against_bem(dataset: xr.Dataset) -> Figure:
    """Pressure and area differences between finite and boundary elements against the grid, by leg."""
    from validation.report.figure import COLOURS, new_figure, plain_look

    figure, panels = new_figure(width=9.0, columns=2)
    for axes, name, label in zip(
        panels,
        ("pressure_half_space", "area"),
        (r"$\|p_{FEM}-p_{BEM}\|/\|p_{BEM}\|$ [%]", r"$|A_{FEM}/A_{BEM}-1|$, counted [%]"),
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
