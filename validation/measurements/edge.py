"""What happens at the edge of contact: how p grows with the distance from it, and what P(sigma) follows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import scipy.ndimage
import xarray as xr
from numpy.typing import NDArray

from fem_contact.area import contact_areas
from fem_contact.contact import ContactResult
from fem_contact.patches import find_patches
from fem_contact.stress import pressure_distribution
from validation.arrays import Array, Grid
from validation.effects.base import ContactModel
from validation.execution.bench import Bench
from validation.execution.measurement import measurement
from validation.measurements.common import reduced_load
from validation.measurements.limits import solve_of, solved, value_at_zero
from validation.measurements.measurement import grid_for
from validation.report.places import gather
from validation.scenes.problem import ContactProblem
from validation.solvers import find_solver
from validation.solvers.base import Settings

#: Distances from the edge, in cells, between which p = B sqrt(s) is read off: beyond the cells the grid smears,
#: and before the curvature of the patch is felt.
_NEAR, _FAR = 1.5, 4.0
_BINS = 120
_WINDOW = 1.2
#: Largest pressure, over E* h'_rms.
_TOP = 0.6


def _recipe(made: dict[str, Any], method: str, settings: Settings) -> dict[str, Any]:
    """Boundary elements as they are by themselves go without a name."""
    plain = method == "bem" and not settings
    return {n: v for n, v in made.items() if not (plain and n in ("method", "settings"))} | {"top": _TOP}


@measurement(
    "edge-{size}",
    kind="EdgeMeasurement",
    words="edge of contact, {method}",
    recipe=_recipe,
    seconds=lambda points: 5e-3 + 1.2e-6 * points,
    bytes=160,
    compiled=lambda method, settings: ((method, dict(settings), ()),),
)
def edge_of_contact(
    *, problem: ContactProblem, grid: Grid, method: str = "bem", settings: Settings = ()
) -> xr.Dataset:
    """Return P(sigma) of one realisation at small pressure and the edge coefficient, in units of E* h'_rms, lambda_short."""
    unit, solver = problem.pressure_scale, find_solver(method)
    field, model = problem.heights(grid), ContactModel(solid=problem.elastic)
    result = solver.pressed(field, model, reduced_load(problem) * unit, **dict(settings)).checked()
    edges = np.linspace(0, _TOP, _BINS + 1)
    density = pressure_distribution(result, edges * unit).density * unit
    wave = problem.shortest
    areas = contact_areas(result, edge_constant=solver.edge_constant(result))
    return xr.Dataset(
        {
            "density": ("bin", density),
            # The counted edge is 4/pi times the true contour on average.
            "contour": np.pi / 4 * areas.edge_length * wave,
            "inverse_square": inverse_square_coefficient(result) * unit**2 / wave,
            "patches": find_patches(result.in_contact, result.spacing).count,
            "area": areas.perimeter,
            "excess": areas.pixel - areas.perimeter,
        },
        coords={"stress": ("bin", (edges[1:] + edges[:-1]) / 2), "upper": ("bin", edges[1:])},
    )


def window_slope(below: float, *, excess: float, window: float) -> float:
    r"""Mean initial slope of P(sigma) from the area `below` a small pressure, 2 (A_\epsilon - A_excess) / epsilon^2.

    Counting adds the area `excess` at the edge, at pressures below that of the first cell inside, B
    dx^(1/2). A `window` epsilon that ends beyond them sees the continuum and the excess: on a Hertzian
    contact, whose slope is pi^3 R^2 / (2 E*^2 A_0), it is right within 1 % from epsilon = 1.2 B dx^(1/2)
    on, at any spacing. One that ends within the first cell is not, at any spacing: 29 % too much at .4.
    Areas are over the nominal area.
    """
    return 2 * (below - excess) / window**2


def slopes_of(
    bench: Bench,
    surfaces: Mapping[tuple[Any, ...], ContactProblem],
    *dims: str,
    points_per_wave: Sequence[float],
) -> xr.Dataset:
    """P'(0) of surfaces, by their places along dimensions, at dx -> 0, and how far it moves on other grids (`edge_limits`).

    ``pressure_slope_each`` in units of (E* h'_rms)^-2, by a polynomial of at most second degree in
    dx^(1/2), and its drift. Grids are rising lambda_short/dx; `window_slope` ends at 1.2 E* h'_rms
    sqrt(dx/lambda_short).
    """
    cases = {
        (*place, n): edge_of_contact(problem=surface, grid=grid_for(surface, n))
        for place, surface in surfaces.items()
        for n in points_per_wave
    }
    starts = {}
    for place, measured in solved(bench, cases).items():
        # A grid is even, and so a little finer than asked for.
        spacing = 1 / cases[place]["problem"].points_per_wave(cases[place]["grid"])
        start = start_of_pressure(measured, spacing=spacing, window=_WINDOW, slope_window=_WINDOW)
        starts[place] = start.assign_coords(spacing=spacing)
    data = edge_limits(gather(starts, *dims, "grid"))
    names = {f"initial_slope_window_each{what}": f"pressure_slope_each{what}" for what in ("", "_drift")}
    return data[[*names]].rename(names)


def inverse_square_coefficient(result: ContactResult) -> float:
    """Mean of B^-2 over the contour, with p = B sqrt(s) at the distance s inside the edge [m/Pa^2].

    Each contact point between 1.5 and 4 cells from the edge gives s / p^2; points at the same distance stand for equal
    lengths of contour. The distance to the edge is that to the nearest point out of contact, less half a cell.
    """
    contact = result.in_contact
    if contact.all() or not contact.any():
        return np.nan
    dx = np.sqrt(result.spacing[0] * result.spacing[1])
    inside = distance_to_outside(contact, margin=int(_FAR) + 2, spacing=result.spacing) - dx / 2
    ring = contact & (inside > _NEAR * dx) & (inside < _FAR * dx)
    return np.mean(inside[ring] / result.pressure[ring] ** 2) if ring.any() else np.nan


def distance_to_outside(
    points: NDArray[np.bool_], *, margin: int, spacing: tuple[float, float] = (1.0, 1.0)
) -> Array:
    """Distance from each of some points of a period to the nearest other, right up to `margin` cells; 0 for the others."""
    padded = np.pad(points, margin, mode="wrap")
    distance: Array = scipy.ndimage.distance_transform_edt(padded, sampling=spacing)
    return distance[margin:-margin, margin:-margin]


def start_of_pressure(
    measured: xr.Dataset, *, spacing: float, window: float, slope_window: float
) -> xr.Dataset:
    """Reduce what `edge_of_contact` left to how P(sigma) starts: in windows that close, and by the contour.

    The windows of the density and of its mean slope end at so many E* h'_rms sqrt(dx/lambda_short);
    `spacing` is dx / lambda_short.
    """
    upper = np.concatenate([[0], measured.upper.values])
    share = np.concatenate([[0], np.cumsum(measured.density.values) * float(np.diff(measured.upper[:2])[0])])
    ends = np.array([window, slope_window]) * np.sqrt(spacing)
    below, below_slope = np.interp(ends, upper, share, right=np.nan)  # beyond _TOP nothing was counted
    return xr.Dataset(
        {
            "density_at_zero_each": below / ends[0],
            "window_slope_each": window_slope(below_slope, excess=float(measured.excess), window=ends[1]),
            "contour_slope_each": 2 * float(measured.contour * measured.inverse_square),
            "patches_each": float(measured.patches),
            "small_density_each": ("bin", measured.density.values),
        },
        attrs=solve_of(measured),
    )


#: What is taken to dx -> 0, of which number on the grids, against which power of dx, by which polynomial. The density
#: in a window eps ~ dx^(1/2) is P(0+) + S eps/2 - c eps^2 + ..., since P bends down from its initial slope S: a
#: straight line takes the bend for an intercept. Patches curve within the cells where B is read, a bias of first order.
_LIMITS = {
    "initial_density": ("density_at_zero", 0.5, 2),
    "initial_density_straight": ("density_at_zero", 0.5, 1),
    "initial_slope_window": ("window_slope", 0.5, 2),
    "initial_slope_contour": ("contour_slope", 1.0, 1),
}


def edge_limits(data: xr.Dataset) -> xr.Dataset:
    """Add P(0+) and P'(0) of `_LIMITS` at dx -> 0 of each surface, with what they move by without the coarsest grid.

    ``initial_density_straight_each`` takes the bend of P for an intercept; the slope from the contour is 2
    S <B^-2>.
    """
    for name, (of, power, degree) in _LIMITS.items():
        values, x = data[f"{of}_each"], data.spacing**power
        made = {"reduction": "polynomial limit", "of": f"{of}_each", "power": power, "degree": degree}
        limit = value_at_zero(values, x, degree=degree)
        data[f"{name}_each"] = limit.assign_attrs(made)
        if values.sizes["grid"] > 3:
            finer = (array.isel(grid=slice(1, None)) for array in (values, x))
            data[f"{name}_each_drift"] = value_at_zero(*finer, degree=degree) - limit
        elif values.sizes["grid"] == 3:
            # A straight line: two of its points tell a third of what its bend leaves.
            data[f"{name}_each_drift"] = value_at_zero(values, x, degree=2, places_more=0) - limit
    return data
