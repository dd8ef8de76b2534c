"""How does the contact area grow with load, when the whole field of every solve is kept?

Boundary elements on surfaces of several seeds, from light load upwards, each surface and load on a ladder of grids; the
limit over the grids beside Persson's theory with the gradient of the same surface. Its solves are those of scenes, so that
the two share stored solves. It is the smallest study, and the one to copy for a new one; `pressure` answers the question
in depth, from numbers alone.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from fem_contact.area import ContactAreas, contact_areas
from validation.arrays import Array
from validation.effects.base import SlotName
from validation.errors import UsageError
from validation.measures.common import LEAST_POINTS_PER_WAVE
from validation.measures.measurement import Grid, has_square_cells, limit_over
from validation.measures.statistics import combined
from validation.methods import find_solver
from validation.methods.theory import predict
from validation.scenes.realised import Realised
from validation.scenes.scene import Load, Scene
from validation.solves.bench import Bench
from validation.solves.press import Press
from validation.studies._options import Bandwidth, Periods, Seed, Surfaces
from validation.studies._scene import PressedOptions
from validation.units import Positive

if TYPE_CHECKING:
    import xarray as xr

    from fem_contact.contact import ContactResult
    from validation.report.drawing import Drawing

__all__ = ["Options", "figures", "findings", "run", "solve_of"]


class Options(PressedOptions):
    """What is pressed, and how often."""

    grids_of: ClassVar[Mapping[str, str]] = {}
    slots: ClassVar[frozenset[SlotName]] = frozenset({"response", "pressure bound", "gap law"})

    reduced_pressures: Annotated[tuple[Positive, ...], Field(min_length=1)] = Field(
        default=(0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0),
        description="p* = p0 / (E* h'_rms) with the realised gradient",
    )
    seed: Seed = 11
    surfaces: Surfaces = 4
    grids: tuple[int, ...] = Field(
        default=(64, 96, 128),
        description="points along a side; at least two with 3 points per shortest wave or more, coarser ones are "
        "run, labelled and left out of the limit",
    )
    periods: Periods = 2.0
    bandwidth: Bandwidth = 4.0

    @classmethod
    def taken(cls, scene: Scene, first: Realised) -> dict[str, Any]:
        """Return the options that a scene says, its grids among them."""
        grids = sorted(scene.methods.options("bem").grids, key=first.points_per_wave)
        return {**super().taken(scene, first), "grids": tuple(nx for nx, _ in grids)}

    @property
    def ladder(self) -> tuple[Grid, ...]:
        """Grids, coarse first."""
        return tuple((n, n) for n in self.grids) if self.scene is None else self.grids_for(())


def solve_of(options: Options, *, surface: int, reduced_pressure: float, points: int | Grid) -> Press:
    """Return one solve: a surface at a load on a grid, as a run of the scene does it where there is one."""
    first, scene = options.first, options.scene
    load = Load(reduced_pressure=reduced_pressure)
    if scene is not None and abs(reduced_pressure / first.reduced_pressure - 1) < 1e-12:
        load = scene.load
    return Press(
        method="bem",
        grid=(points, points) if isinstance(points, int) else points,
        realised=replace(first, load=load).further(surface),
        settings=() if scene is None else find_solver("bem").settings(scene.methods.options("bem")),
        effects=options.effects,
    )


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Solve every surface at every load on every grid, and take the limit over the grids.

    Returns
    -------
    xarray.Dataset
        Over `reduced_pressure`: mean limit of A/A0 over the surfaces, its standard error (surfaces and grids), the
        uncertainty of a single limit, kappa, and Persson's A/A0; NaN where a contact is too small for a limit.

    Raises
    ------
    UsageError
        For grids that give no limit.
    """
    resolved = _resolved(options)
    cases = list(itertools.product(options.reduced_pressures, range(options.surfaces)))
    wanted = {
        (load, k, n): solve_of(options, reduced_pressure=load, surface=k, points=n)
        for (load, k), n in itertools.product(cases, options.ladder)
    }
    solved = bench.solve(wanted.values())
    area = np.zeros((len(options.reduced_pressures), options.surfaces))
    error, theory = np.zeros_like(area), np.zeros_like(area)
    for position, (load, k) in zip(np.ndindex(area.shape), cases, strict=True):
        own = [wanted[load, k, n] for n in resolved]
        limit = limit_over([_area(solve, solved[solve]) for solve in own])
        area[position], error[position] = limit.value, limit.uncertainty
        theory[position] = _persson(own[0])
    attributes = {
        "methods": " ".join(["theory", "bem", *(effect.kind for effect in options.effects)]),
        "surfaces": options.surfaces,
        "grids": _names(resolved),
        "left_out": _names(grid for grid in options.ladder if grid not in resolved),
    }
    return _dataset(area, error, theory, loads=np.asarray(options.reduced_pressures), attributes=attributes)


def _area(solve: Press, result: ContactResult) -> ContactAreas:
    """Return the areas of a solve; its edges are located inside the cells where their law is known."""
    located = not solve.effects and has_square_cells(solve.realised, solve.grid)
    return contact_areas(result, subcell=located)


def _persson(solve: Press) -> float:
    """A/A0 of the theory, told the realised surface and the effects; NaN where it does not know them."""
    if not all(type(effect).has_theory() for effect in solve.effects):
        return math.nan
    return predict(solve.realised, solve.effects).area


def _dataset(
    area: Array, error: Array, theory: Array, *, loads: Array, attributes: dict[str, Any]
) -> xr.Dataset:
    """Average over the surfaces, the second axis of all arrays."""
    import xarray as xr

    mean, count = area.mean(axis=1), area.shape[1]
    # One surface, such as a measured one, stands for itself: it has no scatter.
    spread = area.std(axis=1, ddof=1) / np.sqrt(count) if count > 1 else np.zeros_like(mean)
    grid_error = np.sqrt(np.mean(error**2, axis=1))
    # Grids are off to the same side on all surfaces of a spectrum: their error does not average out.
    both = np.array([combined(*pair) for pair in zip(spread, grid_error, strict=True)])
    columns = {
        "area": (mean, "A/A0, limit over grids"),
        "area_error": (both, "standard error: surfaces and grids"),
        "scatter_error": (spread, "standard error over surfaces alone"),
        "grid_error": (grid_error, "uncertainty of one limit, root mean square"),
        "kappa": (mean / loads, "kappa = (A/A0) / p*"),
        "kappa_error": (both / loads, "standard error: surfaces and grids"),
        "persson": (theory.mean(axis=1), "A/A0, Persson with the realised gradient"),
    }
    load = ("reduced_pressure", loads, {"units": "1", "long_name": "p* = p0 / (E* h'_rms)"})
    return xr.Dataset(
        {
            name: ("reduced_pressure", values, {"units": "1", "long_name": words})
            for name, (values, words) in columns.items()
        },
        coords={"reduced_pressure": load},
        attrs=attributes,
    )


def _names(grids: Iterable[Grid]) -> str:
    return ", ".join(f"{nx} x {ny}" for nx, ny in grids)


def _resolved(options: Options) -> tuple[Grid, ...]:
    """Return the grids of at least 3 points per shortest wave; without located edges a limit needs three."""
    first, grids = options.first, options.ladder
    least = LEAST_POINTS_PER_WAVE * (1 - 1e-9)
    found = tuple(dict.fromkeys(grid for grid in grids if first.points_per_wave(grid) >= least))
    located = not options.effects and all(has_square_cells(first, grid) for grid in grids)
    needed = 2 if located else 3
    if len(found) < needed:
        side = max(first.lengths) / first.shortest * LEAST_POINTS_PER_WAVE
        raise UsageError(
            f"grids = {', '.join(map(_side, grids))}: a limit needs {'two' if located else 'three'} grids of at least "
            f"{LEAST_POINTS_PER_WAVE:g} points per shortest wave; here that is {math.ceil(side - 1e-9)} or more along a side"
        )
    return found


def _side(grid: Grid) -> str:
    nx, ny = grid
    return str(nx) if nx == ny else f"{nx} x {ny}"


def findings(data: xr.Dataset) -> tuple[str, ...]:
    """Say how kappa and the distance to the theory change from the lightest to the heaviest load."""
    from validation.comparison.findings import percent
    from validation.report.words import with_error

    loads, kappa, error = (data[name].values for name in ("reduced_pressure", "kappa", "kappa_error"))
    share, persson = data["grid_error"].values / data["area"].values, data["persson"].values
    surfaces = int(data.attrs["surfaces"])
    whose = f"standard error over {surfaces} surfaces and of the grids, which alone is"
    if surfaces == 1:
        whose = "one surface; standard error of the grids,"
    sentences = []
    for k in sorted({0, len(loads) // 2, len(loads) - 1}):
        if not np.isfinite(kappa[k]):
            sentences.append(
                f"At p* = {loads[k]:.3g} kappa is not determinable: a contact has too few points on the finest grid."
            )
            continue
        distance = float(data["area"].values[k] / persson[k] - 1)
        sentences.append(
            f"At p* = {loads[k]:.3g} kappa = {with_error(float(kappa[k]), float(error[k]))} ({whose} "
            f"{percent(float(share[k]))})"
            + (
                f"; the area lies {percent(abs(distance))} {'above' if distance > 0 else 'below'} Persson's theory."
                if math.isfinite(distance)
                else "; the theory knows nothing of these effects."
            )
        )
    left_out = data.attrs.get("left_out", "")
    if left_out:
        sentences.append(
            f"Under-resolved (fewer than {LEAST_POINTS_PER_WAVE:g} points per shortest wave), run and left out of every "
            f"limit: {left_out}."
        )
    return tuple(sentences)


def figures(data: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw area and kappa against load."""
    from validation.report.drawing import Drawing
    from validation.report.figure import lines_figure

    with_theory = data.assign(
        persson_kappa=data["persson"] / data["reduced_pressure"],
    )
    with_theory["persson_kappa"].attrs = {
        "units": "1",
        "long_name": "kappa, Persson with the realised gradient",
    }
    return (
        Drawing(
            name="area",
            figure=lines_figure(data, x="reduced_pressure", lines=("area", "persson"), logarithmic="xy"),
            data=data[["area", "area_error", "scatter_error", "grid_error", "persson"]],
            caption="Contact area against load: limit over the grids, mean and standard error (surfaces and "
            "grids), beside Persson's theory for the same surfaces.",
        ),
        Drawing(
            name="kappa",
            figure=lines_figure(
                with_theory, x="reduced_pressure", lines=("kappa", "persson_kappa"), logarithmic="x"
            ),
            data=with_theory[["kappa", "kappa_error", "persson_kappa"]],
            caption="Area over load, kappa: constant where contact grows in proportion to load.",
        ),
    )
