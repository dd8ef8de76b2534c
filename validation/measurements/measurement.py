"""What most studies measure: one surface, pressed along a path of loads on several grids, reduced to numbers."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from fem_contact import bem
from fem_contact.area import EDGE_CONSTANTS, TRAITS, ContactAreas, contact_areas, subgrid_shifts
from fem_contact.conductance import frozen_contact
from fem_contact.contact import ContactResult
from fem_contact.extrapolation import Limit, located_limit, perimeter_limit
from fem_contact.patches import find_patches
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.stress import density_at_zero, elastic_energy, window_slope
from fem_contact.surface import HeightField, random_surface
from fem_contact.surface.heights import wavevectors
from validation.arrays import Array, Grid
from validation.effects.base import ContactModel
from validation.errors import UsageError
from validation.execution.measurement import measurement
from validation.execution.solve import LOCATED_EDGES, dearer_by
from validation.measurements.common import LEAST_POINTS_PER_WAVE, SHIFTS, reduced_load
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import EffectSpec
from validation.scenes.surfaces import waves_drawn
from validation.scenes.tables import FileSurface
from validation.solvers import find_solver

if TYPE_CHECKING:
    import xarray as xr

    from validation.execution.press import Press

#: How far the sides of a cell may differ for edges to be located inside it.
_SQUARE = 0.05

#: What areas are made of, and what is read off every solve: pressures in Pa, lengths in m, costs in s and bytes.
AREAS = ("pixel", "perimeter", "subcell", "edge_fraction")
QUANTITIES = (
    *(*AREAS, *TRAITS, "density_at_zero", "patches", "patch_size", "cells_per_patch", "mean_gap", "energy"),
    *("residual", "seconds", "peak_bytes"),
)

#: Edges of the bins of sigma / (E* h'_rms); what lies above the last counts in the last bin.
STRESS_EDGES = np.linspace(0.0, 4.0, 321)

#: Edges of the bins of patch area / lambda_short^2; what lies outside counts in the first or last bin.
PATCH_EDGES = np.geomspace(1e-4, 1e4, 161)


def grid_for(problem: ContactProblem, points_per_wave: float) -> Grid:
    """Smallest even grid with at least that many points on lambda_short, along both axes."""
    nx, ny = (even_points(points_per_wave * length / problem.shortest) for length in problem.lengths)
    return nx, ny


def grids_for(problem: ContactProblem, points_per_wave: Sequence[float]) -> tuple[Grid, ...]:
    """Return `grid_for` of several numbers of points."""
    return tuple(grid_for(problem, points) for points in points_per_wave)


#: Points along a side that no grid has.
_MOST_POINTS = 2**20


def even_points(points: float) -> int:
    """Return the smallest even number of points that is at least that; a UsageError for one that no grid has."""
    even = 2 * math.ceil(min(points, 2 * _MOST_POINTS) / 2 - 1e-9)
    if not 2 <= even <= _MOST_POINTS:
        raise UsageError(f"{points:.3g} points along a side of a grid: must be 2 to {_MOST_POINTS}")
    return even


#: Of the solver by default.
TOLERANCE = 1e-8

#: Tolerance whose effect on the located area is below a hundredth of what its grids leave, at 8 points per
#: shortest wave; that falls with the cube of the spacing (docs/bem.md).
_TOLERANCE, _AT_POINTS, _LEAST_TOLERANCE = 1e-5, 8, 1e-8

#: The located area of a solve is off by so many tolerances, relative, but for rare ones (docs/bem.md).
TOLERANCES_LEFT = 7.0


def grid_tolerance(problem: ContactProblem, grids: Sequence[Grid]) -> float:
    """Tolerance that areas on such grids deserve: below it, digits are computed that the grids do not have."""
    points = float(np.max(np.array(grids) * problem.shortest / problem.lengths))
    return max(_TOLERANCE * min(1.0, (_AT_POINTS / points) ** 3), _LEAST_TOLERANCE)


def has_square_cells(problem: ContactProblem, grid: Grid) -> bool:
    """Whether the cells of a grid are square within 5 %, so that edges can be located inside them."""
    dx, dy = problem.spacing(grid)
    return abs(dx / dy - 1) <= _SQUARE


#: Kinds of the stored results, by what is kept besides the areas.
_KINDS: dict[tuple[str, ...], str] = {
    (): "Measurement",
    ("distributions",): "Distributions",
    ("stiffness",): "StiffMeasurement",
    ("distributions", "stiffness"): "LoadPath",
    ("stiffness", "slope"): "_Rich",
}


def _recipe(
    made: dict[str, Any],
    keep: tuple[str, ...],
    reduced_pressures: Any,
    problem: ContactProblem,
    grids: Any,
    effects: tuple[EffectSpec, ...],
) -> dict[str, Any]:
    """Name what is read off, too: a stored result that lacks a number is another one."""
    # P(0+) over a coating stands on E* of the solid below it; it stood on that of the coating.
    surface = ContactModel.filled(problem.elastic, effects).felt_response
    below = ["below"] if surface.contact_modulus != problem.contact_modulus else []
    more = [name for name in ("stiffness", "slope") if name in keep]
    if not made["effects"]:
        del made["effects"]
    # A surface that is cut has its lay; solves of before had lost it.
    lay = ["lay"] if "truncation" in made and "stretch" in made["surface"] else []
    # So has a map on fewer points than its own that is moved: its waves were moved as the grid sees them.
    moved = ["moved"] if made["shifts"] > 1 and any(map(problem.aliases, grids)) else []
    return {
        "truncation": None,
        **made,
        "kind": _KINDS[keep],
        "reduced_pressures": list(reduced_pressures or (reduced_load(problem),)),
        "quantities": sorted([*QUANTITIES, *more, "cells", LOCATED_EDGES, *below, *lay, *moved]),
    }


@measurement(
    "measure-{size}",
    kind="Measurement",
    words="areas to",
    recipe=_recipe,
    left_out=("load", "keep"),
    seconds=lambda grids, shifts, effects, reduced_pressures: (
        dearer_by(effects)
        * max(len(reduced_pressures), 1)
        * shifts**2
        * sum(2e-3 + 8e-7 * nx * ny for nx, ny in grids)
    ),
    bytes=120,
)
def press_on_grids(
    *,
    problem: ContactProblem,
    grids: tuple[Grid, ...],
    reduced_pressures: tuple[float, ...] = (),
    effects: tuple[EffectSpec, ...] = (),
    truncation: float | None = None,
    shifts: int = SHIFTS,
    tolerance: float = TOLERANCE,
    keep: tuple[Literal["distributions", "stiffness", "slope"], ...] = (),
) -> xr.Dataset:
    """Press one surface, at ascending loads, on nested grids, each on `shifts`^2 sub-grid shifts.

    `QUANTITIES` over (grid, shift, load); histograms (grid, load, bin), means over the shifts.

    Parameters
    ----------
    reduced_pressures : tuple of float
        A path of loads instead of the one of `problem`: p* with the realised gradient of the untruncated surface.
    effects : tuple
        Of a scene; then each load is pressed by itself.
    truncation : float or None
        Drop waves beyond this wavevector [1/m]: roughness up to a magnification.
    keep : tuple of str
        What else is read off: ``distributions`` of P(sigma) and patch sizes; ``stiffness``, K h_rms / p0 with the
        contact set held; ``slope`` of P(sigma), times (E* h'_rms)^2, fitted between .1 and .4 E* h'_rms.
    """
    import xarray as xr

    loads = reduced_pressures or (reduced_load(problem),)

    def read(grid: Grid, shift: tuple[float, float]) -> list[dict[str, Any]]:
        field = truncated_heights(problem, grid, shift, truncation=truncation)
        path = pressed_path(field, problem, loads, effects=effects, tolerance=tolerance)
        located = not effects and has_square_cells(problem, grid)
        return [_read_off(result, problem, keep, located=located) for result in path]

    solves = [[read(grid, shift) for shift in subgrid_shifts(shifts)] for grid in grids]
    data = stacked(solves, "grid", "shift", "load")
    for name in [name for name, (_, values) in data.items() if values.ndim > 3]:
        data[f"{name}_profile"] = ("grid", "load", f"{name}_bin"), data.pop(name)[1].mean(axis=1)
    field, modulus = problem.field, problem.contact_modulus
    return xr.Dataset(
        data,
        coords={
            "points": ("grid", [nx for nx, _ in grids]),
            "cells": ("grid", [nx * ny for nx, ny in grids]),
            "points_per_wave": ("grid", [problem.points_per_wave(grid) for grid in grids]),
            "reduced_pressure": ("load", list(loads)),
        },
        attrs={
            "rms_height": field.rms_height,
            "rms_gradient": field.rms_gradient,
            "nayak": field.nayak,
            "contact_modulus": modulus,
            "full_contact_energy": field.spectral_sum(lambda q: modulus / 4 * q),
        },
    )


def stacked(rows: Any, *dims: str) -> dict[str, Any]:
    """Return numbers by name, in lists of lists of them along `dims`, as variables of a dataset."""

    def values(name: str, part: Any) -> Any:
        return part[name] if isinstance(part, Mapping) else [values(name, row) for row in part]

    first = rows
    for _ in dims:
        first = first[0]
    return {name: (dims, np.array(values(name, rows))) for name in first}


def pressed_path(
    field: HeightField,
    problem: ContactProblem,
    loads: Sequence[float],
    *,
    tolerance: float,
    effects: tuple[EffectSpec, ...] = (),
) -> Iterator[ContactResult]:
    """Solve loads p* of one grid in order, one result at a time: without effects each from the one before.

    p* is with the gradient of the whole surface of the problem, not that of `field`.
    """
    pressures = [reduced * problem.pressure_scale for reduced in loads]
    if not effects:
        return elastic_path(field, problem.elastic, pressures, tolerance=tolerance)
    model, solver = ContactModel.filled(problem.elastic, effects), find_solver("bem")
    return (solver.pressed(field, model, p, tolerance=tolerance).checked() for p in pressures)


def elastic_path(
    field: HeightField, solid: Solid, pressures: Sequence[float], *, tolerance: float = TOLERANCE
) -> Iterator[ContactResult]:
    """Solve the half-space at pressures [Pa] in order, each from the one before, one result at a time."""
    start = None
    for pressure in pressures:
        result = press_elastic(field, solid, pressure, start=start, tolerance=tolerance)
        yield result
        start = result.pressure


def press_elastic(
    field: HeightField,
    solid: Solid,
    pressure: float,
    *,
    start: Array | None = None,
    tolerance: float = TOLERANCE,
) -> ContactResult:
    """Solve the half-space at a mean pressure [Pa] on one thread, from a pressure field that is near."""
    body = HalfSpace(solid=solid)
    return bem.solve(
        field, body, mean_pressure=pressure, start=start, tolerance=tolerance, threads=1
    ).checked()


def truncated_heights(
    problem: ContactProblem, grid: Grid, shift: tuple[float, float] = (0.0, 0.0), *, truncation: float | None
) -> HeightField:
    """Return the heights of a surface on a grid, without its waves beyond a wavevector [1/m]."""
    if truncation is None:
        return problem.heights(grid, shift)
    if isinstance(problem.surface, FileSurface):
        return problem.on_points(without_waves_beyond(problem.field, truncation), grid, shift)
    drawn = waves_drawn(problem.surface, problem.realisation)
    drawn["q_short"] = min(truncation, drawn["q_short"])
    field = random_surface(**drawn, shape=grid).shifted(shift)
    return HeightField(heights=-field.heights, lengths=field.lengths) if problem.inverted else field


def without_waves_beyond(field: HeightField, last: float) -> HeightField:
    """Return a surface without its waves shorter than 2 pi / `last`, on the same points."""
    qx, qy = wavevectors(field.shape, field.lengths)
    waves = np.where(np.hypot(qx[:, None], qy) <= last * (1 + 1e-9), np.fft.rfft2(field.heights), 0)
    return HeightField(heights=np.fft.irfft2(waves, s=field.shape), lengths=field.lengths)


def _read_off(
    result: ContactResult, problem: ContactProblem, keep: Sequence[str], *, located: bool
) -> dict[str, Any]:
    """Return `QUANTITIES` of a solve, and what else is to be kept."""
    patches = find_patches(result.in_contact, result.spacing)
    sizes = np.sort(patches.areas)[::-1]
    cell = result.spacing[0] * result.spacing[1]
    full = result.in_contact.all() and not result.at_bound.any()
    half = np.searchsorted(np.cumsum(sizes), sizes.sum() / 2)
    # What is read off in units of E* at the surface stands on that of the solid below a coating.
    unit = problem.contact_modulus / result.contact_modulus
    numbers = {
        **areas_read(contact_areas(result, subcell=located)),
        "density_at_zero": density_at_zero(result).reduced * unit,
        "patches": patches.count,
        "patch_size": patches.mean_size,
        "cells_per_patch": sizes[half] / cell if sizes.size else 0.0,
        # What is left of the gaps where every point touches is rounding.
        "mean_gap": 0.0 if full else result.mean_gap,
        "energy": elastic_energy(result),
        "residual": result.residuals.worst,
        "seconds": result.cost.cpu_seconds,
        "peak_bytes": result.cost.peak_bytes,
    }
    if "stiffness" in keep and result.in_contact.all():
        numbers["stiffness"] = math.inf
    elif "stiffness" in keep:
        # Off by the square of the tolerance, .6 of that at worst.
        tolerance = 1e-3 if "slope" in keep else 1e-9
        frozen = frozen_contact(result, HalfSpace(solid=problem.elastic), tolerance=tolerance, threads=1)
        numbers["stiffness"] = frozen.stiffness * problem.field.rms_height / result.mean_pressure
    if "slope" in keep:
        numbers["slope"] = window_slope(result).reduced * unit**2
    return numbers | (histograms_of(result, problem) if "distributions" in keep else {})


def areas_read(areas: ContactAreas) -> dict[str, float]:
    """Return the numbers that `stored_areas` takes; the located area is NaN where there is none."""
    subcell = math.nan if areas.subcell is None else areas.subcell
    return {name: getattr(areas, name) for name in (*AREAS, *TRAITS)} | {"subcell": subcell}


def areas_of_solve(solve: Press, result: ContactResult) -> ContactAreas:
    """Return areas; edges are located inside the cells where their law is known: without effects, on square cells."""
    located = solve.solver.locates_edges and not solve.effects and has_square_cells(solve.problem, solve.grid)
    return contact_areas(result, edge_constant=solve.solver.edge_constant(result), subcell=located)


def limit_over(areas: Sequence[ContactAreas]) -> Limit:
    """Return the limit of the located area where there is one, else of the corrected."""
    located = all(area.subcell is not None for area in areas)
    return located_limit(areas) if located else perimeter_limit(areas)


def reduced_numbers(measured: xr.Dataset) -> dict[str, xr.DataArray]:
    """Return gap over h_rms, compliance p0 / (K h_rms), which is 0 in full contact, and energy over that of full contact."""
    return {
        "gap": measured.mean_gap / measured.attrs["rms_height"],
        "compliance": 1 / measured.stiffness,
        "energy_ratio": measured.energy / measured.attrs["full_contact_energy"],
    }


def no_limit(doubt: str) -> Limit:
    """Return what there is in place of a limit: why there is none."""
    return Limit(value=math.nan, uncertainty=math.nan, grids=0, definition="none", doubt=doubt)


def areas_of(dataset: xr.Dataset, load: int) -> list[ContactAreas]:
    """Return the areas of a measurement at one load, one for each grid and shift, as `located_limit` takes them.

    Grids of fewer than `LEAST_POINTS_PER_WAVE` are left out.
    """
    keep = np.flatnonzero(dataset.points_per_wave.values >= LEAST_POINTS_PER_WAVE)
    points, cells = dataset.points.values, dataset.cells.values
    read = {name: dataset[name].values[:, :, load] for name in (*AREAS, *TRAITS) if name in dataset}
    return [
        stored_areas(
            {name: values[i, j] for name, values in read.items()},
            grid=(int(points[i]), int(cells[i]) // int(points[i])),
        )
        for i, j in itertools.product(keep, range(dataset.sizes["shift"]))
    ]


def stored_areas(
    numbers: Mapping[str, Any] | xr.Dataset, *, grid: Grid, edge_constant: float = EDGE_CONSTANTS["bem"]
) -> ContactAreas:
    """Return the areas of one solve from stored numbers, as limits take them, on periods of 1.

    ``pixel``, ``perimeter``, ``edge_fraction``; ``subcell`` and `fem_contact.area.TRAITS` where they were
    measured.
    """
    known = {name: float(numbers[name]) for name in (*AREAS, *TRAITS) if name in numbers}
    subcell = known.pop("subcell", math.nan)
    return ContactAreas(
        **known,
        edge_length=math.nan,
        edge_constant=edge_constant,
        spacing=(1 / grid[0], 1 / grid[1]),
        subcell=None if math.isnan(subcell) else subcell,
        cells=grid[0] * grid[1],
    )


def area_limits(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return the limit of A/A0 over the grids of one measurement and its standard error, for each load.

    It is that of the located areas (`fem_contact.extrapolation`), else of those corrected at their edge, on
    grids of `LEAST_POINTS_PER_WAVE` or more. Both are NaN where the contact is too small to carry the law.
    """
    limits = [limit_over(areas_of(dataset, k)) for k in range(dataset.sizes["load"])]
    return np.array([limit.value for limit in limits]), np.array([limit.uncertainty for limit in limits])


def histograms_of(result: ContactResult, problem: ContactProblem) -> dict[str, Array]:
    """Return P(sigma) and patch sizes of one solve, as histograms over the edges above.

    ``stress``, share of the nominal area by pressure, and ``load``, share of p0; ``patch_number`` and
    ``patch_area``, number of patches and share of the nominal area, by patch size.
    """
    unit = problem.pressure_scale
    contact = result.in_contact
    pressure = result.pressure[contact] / unit
    inside = np.clip(pressure, 0.0, STRESS_EDGES[-1])
    stress, _ = np.histogram(inside, bins=STRESS_EDGES)
    load, _ = np.histogram(inside, bins=STRESS_EDGES, weights=pressure)
    sizes = find_patches(contact, result.spacing).areas
    scaled = np.clip(sizes / problem.shortest**2, PATCH_EDGES[0], PATCH_EDGES[-1])
    number, _ = np.histogram(scaled, bins=PATCH_EDGES)
    cell = result.spacing[0] * result.spacing[1]
    area, _ = np.histogram(scaled, bins=PATCH_EDGES, weights=sizes / cell)
    nominal = np.mean(result.pressure) / unit * contact.size
    return {
        "stress": stress / contact.size,
        "load": load / nominal,
        "patch_number": number.astype(float),
        "patch_area": area / contact.size,
    }
