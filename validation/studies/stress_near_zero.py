"""Does P(sigma) vanish at sigma = 0, with which slope, and is it the slope of the theory?"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from persson import elastic
from validation.bench import Bench
from validation.drawing import Drawing
from validation.statistics import mean_over_surfaces
from validation.studies._common import (
    ResultTable,
    at_least,
    base_surface,
    measure,
    over_surfaces,
    rising,
    solid_of,
)
from validation.studies._edge import EdgeMeasurement
from validation.studies._measurement import grid_for

if TYPE_CHECKING:
    import xarray as xr

    from validation.scene import Scene

__all__ = ["figures", "findings", "run", "table"]


def run(
    *,
    scene: Scene | None = None,
    bench: Bench | None = None,
    reduced_pressure: float = 0.05,
    hurst: float = 0.8,
    size: float = 4.0,
    ratio: float = 4.0,
    surfaces: int = 6,
    points_per_wave: tuple[float, ...] = (16.0, 24.0, 32.0, 48.0, 64.0),
    window: float = 0.4,
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
    seed : int
        Of the first surface.

    Returns
    -------
    xarray.Dataset
        density_at_zero (surface, grid), its intercept at dx -> 0 by a fit in dx^(1/2), the slope of P above the window, the
        slope that follows from the contour and the edge coefficient, and the number of patches.
    """
    import xarray as xr

    at_least("surfaces", surfaces, 2)
    points_per_wave = rising("points_per_wave", points_per_wave)
    surface, solid = base_surface(hurst=hurst, size=size, ratio=ratio, seed=seed), solid_of(scene)
    jobs = [
        EdgeMeasurement(
            surface=surface,
            realisation=k,
            solid=solid,
            reduced_pressure=reduced_pressure,
            points=grid_for(surface, n)[0],
        )
        for k, n in itertools.product(range(surfaces), points_per_wave)
    ]
    measured = measure(bench, jobs)
    shape = (surfaces, len(points_per_wave))
    step = float(np.diff(measured[0].upper[:2])[0])
    spacing = (
        np.array([surface.lambda_short / surface.length[0] * job.points for job in jobs[: shape[1]]]) ** -1
    )
    below, slope = [], []
    for data, eps in zip(measured, np.tile(window * np.sqrt(spacing), surfaces), strict=True):
        share = np.concatenate([[0], np.cumsum(data.density.values) * step])
        below.append(float(np.interp(eps, np.concatenate([[0], data.upper.values]), share)) / eps)
        fitted = (data.stress.values > eps) & (data.stress.values < max(0.12, 2 * eps))
        slope.append(float(np.polyfit(data.stress.values[fitted], data.density.values[fitted], 1)[0]))
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
            "surfaces": surfaces,
        },
    )


def _rows(measured: list[xr.Dataset], surface: int, grids: int) -> np.ndarray:
    return np.array([data.density.values for data in measured[surface * grids : (surface + 1) * grids]])


def _persson_slope(reduced_pressure: float) -> float:
    """Slope of Persson's P(sigma) at zero in units of E* h'_rms."""
    variance = elastic.stress_variance(1.0, contact_modulus=1.0)
    return float(elastic.initial_slope(reduced_pressure, stress_variance=variance))


def intercepts(dataset: xr.Dataset) -> np.ndarray:
    """P(0+) at dx -> 0 of each surface, by a straight line in dx^(1/2) over its grids."""
    root = np.sqrt(dataset.spacing.values)
    return np.array([np.polyfit(root, row, 1)[1] for row in dataset.density_at_zero.values])


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
        "slope",
        "+- (95 %)",
        "slope from the contour",
        "+- (95 %)",
        "patches",
    )
    return ResultTable.of(columns, rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return whether the density vanishes, and how the slopes compare."""
    limit = mean_over_surfaces(intercepts(dataset))
    finest = float(dataset.density_at_zero[:, -1].mean())
    zero = abs(limit.value) <= limit.half_width
    slope, contour = over_surfaces(dataset.slope[:, -1]), over_surfaces(dataset.contour_slope[:, -1])
    persson = float(dataset.attrs["persson_slope"])
    patches = dataset.patches.mean("surface").values
    return (
        f"The density at vanishing pressure falls like dx^{exponent(dataset):.2f}, to {finest:.3f} on the finest grid; its intercept at dx -> 0 is "
        f"{limit} (95 %), {'not told from zero' if zero else 'different from zero'} "
        f"(in units of 1/(E* h'_rms), {limit.samples} surfaces).",
        f"P grows from zero with the slope {slope} in units of (E* h'_rms)^-2 on the finest grid; contour length and edge coefficient predict "
        f"{contour} (2 S <B^-2>), Persson's closed form {persson:.3f}: {slope.value / persson:.1f} times less than simulated."
        + _drift(dataset),
        f"Every patch adds to the slope whatever its size: it rests on {patches[-1]:.0f} patches per surface, "
        f"{patches[-2]:.0f} on the next coarser grid.",
    )


def _drift(dataset: xr.Dataset) -> str:
    """Say whether the slopes still move from one grid to the next."""
    words = []
    for name, label in (("slope", "fitted slope"), ("contour_slope", "slope from the contour")):
        mean = dataset[name].mean("surface").values
        change = mean[-1] / mean[-2] - 1
        if abs(change) > 0.05:
            words.append(f"the {label} still changes by {100 * change:+.0f} % from the last grid but one")
    return f" Not converged: {' and '.join(words)}; finer grids are needed for a number." if words else ""


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw P(sigma) near zero and its value at zero against the grid."""
    from validation import plots_studies

    return (
        Drawing(
            name="pressure-near-zero",
            figure=plots_studies.pressure_near_zero(dataset),
            data=dataset[["density"]],
            caption="Distribution of contact pressure near zero on each grid, mean over surfaces, with the initial slope that follows from contour and edge coefficient and that of the theory.",
        ),
        Drawing(
            name="density-at-zero",
            figure=plots_studies.density_at_zero(dataset, intercepts(dataset)),
            data=dataset[["density_at_zero"]],
            caption="Density at vanishing pressure against the square root of the spacing: grey, single surfaces; black, mean; the intercept tells whether it vanishes.",
        ),
    )
