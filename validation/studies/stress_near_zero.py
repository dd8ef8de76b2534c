"""Does P(sigma) vanish at sigma = 0, with which slope, and is it the slope of the theory?"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from persson import elastic
from validation.measures.common import at_least, base_surface, measure, over_surfaces, rising, solid_of
from validation.measures.edge import EdgeMeasurement, window_slope
from validation.measures.measurement import grid_for
from validation.measures.statistics import Estimate, combined, mean_over_surfaces
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.solves.bench import Bench

if TYPE_CHECKING:
    import xarray as xr

    from validation.scenes.scene import Scene

__all__ = ["figures", "findings", "limit_at_zero", "limit_contour_slope", "limit_slope", "run", "table"]


def run(
    *,
    scene: Scene | None = None,
    bench: Bench | None = None,
    reduced_pressure: float = 0.05,
    hurst: float = 0.8,
    size: float = 4.0,
    ratio: float = 4.0,
    surfaces: int = 6,
    points_per_wave: tuple[float, ...] = (16.0, 24.0, 32.0, 48.0, 64.0, 96.0, 128.0),
    window: float = 0.4,
    slope_window: float = 1.2,
    seed: int = 2006,
) -> xr.Dataset:
    """Measure the density of small pressures on grids fine enough to see the edge.

    Parameters
    ----------
    scene : Scene, optional
        Gives the solid; nothing reported depends on it.
    bench : Bench, optional
        Where and how the cases run.
    reduced_pressure : float
        p*.
    hurst, size, ratio : float
        H, L/lambda_long and lambda_long/lambda_short.
    surfaces : int
        Realisations.
    points_per_wave : tuple of float
        Grids, as lambda_short/dx, rising.
    window : float
        eps of the density P(sigma < eps)/eps, in units of E* h'_rms sqrt(dx/lambda_short): it closes with the grid, since a
        window of fixed width would tend to its slope times half its width and not to P(0+).
    slope_window : float
        The same for the slope. It must end beyond the first cell inside the edge, where the continuum begins.
    seed : int
        Of the first surface.

    Returns
    -------
    xarray.Dataset
        density_at_zero (surface, grid), the mean slope of P inside the window after the counted area in excess is taken out,
        the slope that follows from the contour and the edge coefficient, and the number of patches.
    """
    import xarray as xr

    at_least("surfaces", surfaces, 2)
    points_per_wave = rising("points_per_wave", points_per_wave)
    surface, solid = base_surface(hurst=hurst, size=size, ratio=ratio, seed=seed), solid_of(scene)
    solves = [
        EdgeMeasurement(
            surface=surface,
            realisation=k,
            solid=solid,
            reduced_pressure=reduced_pressure,
            points=grid_for(surface, n)[0],
        )
        for k, n in itertools.product(range(surfaces), points_per_wave)
    ]
    measured = measure(bench, solves)
    shape = (surfaces, len(points_per_wave))
    step = float(np.diff(measured[0].upper[:2])[0])
    spacing = (
        np.array([surface.lambda_short / surface.length[0] * solve.points for solve in solves[: shape[1]]])
        ** -1
    )
    below, slope = [], []
    for data, root in zip(measured, np.tile(np.sqrt(spacing), surfaces), strict=True):
        share = np.concatenate([[0], np.cumsum(data.density.values) * step])
        upper = np.concatenate([[0], data.upper.values])
        ends = window * root, slope_window * root
        inside = np.interp(ends, upper, share)
        below.append(float(inside[0]) / ends[0])
        slope.append(window_slope(float(inside[1]), excess=float(data.excess), window=ends[1]))
    contour = np.array([2 * float(d.contour * d.inverse_square) for d in measured]).reshape(shape)
    return xr.Dataset(
        {
            "density_at_zero": (("surface", "grid"), np.array(below).reshape(shape)),
            "slope": (("surface", "grid"), np.array(slope).reshape(shape)),
            "contour_slope": (("surface", "grid"), contour),
            "patches": (("surface", "grid"), np.array([float(d.patches) for d in measured]).reshape(shape)),
            "density": (
                ("grid", "bin"),
                np.mean([_rows(measured, k, shape[1]) for k in range(surfaces)], axis=0),
            ),
        },
        coords={
            "spacing": ("grid", spacing, {"long_name": "dx / lambda_short"}),
            "stress": ("bin", measured[0].stress.values, {"long_name": "sigma / (E* h'_rms)"}),
        },
        attrs={
            "study": "stress-near-zero",
            "reduced_pressure": reduced_pressure,
            "persson_slope": _persson_slope(reduced_pressure),
            "window": window,
            "slope_window": slope_window,
            "surfaces": surfaces,
        },
    )


def _rows(measured: list[xr.Dataset], surface: int, grids: int) -> np.ndarray:
    return np.array([data.density.values for data in measured[surface * grids : (surface + 1) * grids]])


def _persson_slope(reduced_pressure: float) -> float:
    """Slope of Persson's P(sigma) at zero in units of E* h'_rms."""
    variance = elastic.stress_variance(1.0, contact_modulus=1.0)
    return float(elastic.initial_slope(reduced_pressure, stress_variance=variance))


def _at_zero(rows: np.ndarray, root: np.ndarray, *, degree: int) -> np.ndarray:
    """Value at dx -> 0 of each surface, by a polynomial in dx^(1/2) over its grids."""
    degree = min(degree, root.size - 2) if root.size > 2 else 1
    return np.array([np.polyfit(root, row, degree)[degree] for row in rows])


def intercepts(dataset: xr.Dataset, *, degree: int = 2) -> np.ndarray:
    """P(0+) at dx -> 0 of each surface, by a polynomial in dx^(1/2) over its grids.

    The density in a window eps ~ dx^(1/2) is P(0+) + S eps/2 - c eps^2 + ..., since P bends down from its initial slope S:
    a straight line takes the bend for an intercept.
    """
    return _at_zero(dataset.density_at_zero.values, np.sqrt(dataset.spacing.values), degree=degree)


def _with_drift(dataset: xr.Dataset, values: Callable[[xr.Dataset], np.ndarray]) -> Estimate:
    """Mean over surfaces, its interval widened by how much it moves without the coarsest grid."""
    estimate = mean_over_surfaces(values(dataset))
    finer = dataset.isel(grid=slice(1, None))
    drift = float(values(finer).mean()) - estimate.value if finer.sizes["grid"] > 2 else 0.0
    return replace(estimate, half_width=combined(estimate.half_width, drift))


def limit_at_zero(dataset: xr.Dataset) -> Estimate:
    """P(0+) at dx -> 0, mean over surfaces."""
    return _with_drift(dataset, intercepts)


def limit_slope(dataset: xr.Dataset) -> Estimate:
    """P'(0) at dx -> 0 from the mean slope inside the window that closes, mean over surfaces."""
    return _with_drift(
        dataset, lambda part: _at_zero(part.slope.values, np.sqrt(part.spacing.values), degree=2)
    )


def limit_contour_slope(dataset: xr.Dataset) -> Estimate:
    """2 S <B^-2> at dx -> 0: the patches curve within the cells where B is read, a bias of first order in dx."""
    return _with_drift(
        dataset, lambda part: _at_zero(part.contour_slope.values, part.spacing.values, degree=1)
    )


def exponent(dataset: xr.Dataset) -> float:
    """Fitted exponent of dx in the mean density at zero."""
    mean = dataset.density_at_zero.mean("surface").values
    return float(np.polyfit(np.log(dataset.spacing.values), np.log(mean), 1)[0])


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each grid."""
    rows = []
    for i, spacing in enumerate(dataset.spacing.values):
        density, slope = over_surfaces(dataset.density_at_zero[:, i]), over_surfaces(dataset.slope[:, i])
        contour = over_surfaces(dataset.contour_slope[:, i])
        rows.append(
            (
                1 / float(spacing),
                density.value,
                density.half_width,
                slope.value,
                slope.half_width,
                contour.value,
                contour.half_width,
                float(dataset.patches[:, i].mean()),
            )
        )
    columns = (
        "lambda_short/dx",
        "P(0+) E*h'",
        "+- (95 %)",
        "mean slope in the window",
        "+- (95 %)",
        "slope from the contour",
        "+- (95 %)",
        "patches",
    )
    return ResultTable.of(columns, rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return whether the density vanishes, and how the slopes compare."""
    limit = limit_at_zero(dataset)
    straight = float(intercepts(dataset, degree=1).mean())
    finest = float(dataset.density_at_zero[:, -1].mean())
    zero = abs(limit.value) <= limit.half_width
    slope, contour = limit_slope(dataset), limit_contour_slope(dataset)
    persson = float(dataset.attrs["persson_slope"])
    patches = dataset.patches.mean("surface").values
    return (
        f"The density at vanishing pressure falls like dx^{exponent(dataset):.2f}, to {finest:.3f} on the finest grid; at dx -> 0 it is "
        f"{limit} (95 %), {'not told from zero' if zero else 'different from zero'} "
        f"(in units of 1/(E* h'_rms), {limit.samples} surfaces; a straight line in dx^(1/2), which takes the bend of P for an intercept, leaves {straight:.4f}).",
        _slope_sentence(slope, contour, persson),
        f"On the finest grid the slopes are {float(dataset.slope[:, -1].mean()):.3f} and {float(dataset.contour_slope[:, -1].mean()):.3f}."
        + _drift(dataset),
        f"Every patch adds to the slope whatever its size: it rests on {patches[-1]:.0f} patches per surface, "
        f"{patches[-2]:.0f} on the next coarser grid.",
    )


#: A slope less certain than this, relative, is no number.
_DECIDED = 0.3


def _slope_sentence(slope: Estimate, contour: Estimate, persson: float) -> str:
    """Say what the slope at zero is, whether both ways to it agree, and how far the theory is."""
    both = f"{slope} from the density in a closing window, {contour} from contour length and edge coefficient (2 S <B^-2>)"
    if slope.half_width > _DECIDED * slope.value:
        return f"The slope P'(0) is not determinable to {100 * _DECIDED:.0f} % from these surfaces and grids: {both}; Persson's closed form has {persson:.3f}."
    agree = abs(slope.value - contour.value) <= combined(slope.half_width, contour.half_width)
    return (
        f"P grows from zero with the slope {both}, in units of (E* h'_rms)^-2 at dx -> 0: the two {'agree' if agree else 'do not agree'} within "
        f"their intervals. Persson's closed form has {persson:.3f}, {slope.value / persson:.1f} +- {slope.half_width / persson:.1f} times less than simulated."
    )


def _drift(dataset: xr.Dataset) -> str:
    """Say whether the slopes still move from one grid to the next."""
    words = []
    for name, label in (("slope", "slope in the window"), ("contour_slope", "slope from the contour")):
        mean = dataset[name].mean("surface").values
        change = mean[-1] / mean[-2] - 1
        if abs(change) > 0.05:
            words.append(f"the {label} still changes by {100 * change:+.0f} % from the last grid but one")
    return f" Not converged: {' and '.join(words)}; finer grids are needed for a number." if words else ""


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw P(sigma) near zero and its value at zero against the grid."""
    from validation.studies import _plots_limits as plots_limits
    from validation.studies import _plots_studies as plots_studies

    return (
        Drawing(
            name="pressure-near-zero",
            figure=plots_studies.pressure_near_zero(
                dataset, window=limit_slope(dataset).value, contour=limit_contour_slope(dataset).value
            ),
            data=dataset[["density"]],
            caption="Distribution of contact pressure near zero on each grid, mean over surfaces, with the initial slope that follows from contour and edge coefficient and that of the theory.",
        ),
        Drawing(
            name="slope-at-zero",
            figure=plots_limits.slope_at_zero(dataset, limit_slope(dataset), limit_contour_slope(dataset)),
            data=dataset[["slope", "contour_slope"]],
            caption="Slope of P(sigma) at zero on each grid, from the density in a closing window and from the contour; filled at 0, the limits with 95 % intervals; line, the theory.",
        ),
        Drawing(
            name="density-at-zero",
            figure=plots_studies.density_at_zero(dataset, intercepts(dataset)),
            data=dataset[["density_at_zero"]],
            caption="Density at vanishing pressure against the square root of the spacing: grey, single surfaces; black, mean; the intercept tells whether it vanishes.",
        ),
    )
