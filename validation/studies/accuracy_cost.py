"""What does each digit of the contact area cost, for which method and which definition, and do the claimed errors hold?"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from validation.bench import Bench
from validation.drawing import Drawing
from validation.studies._block import BlockMeasurement
from validation.studies._common import ResultTable, at_least, base_surface, ladder, measure, solid_of
from validation.studies._measurement import Measurement, area_limits, grid_for

if TYPE_CHECKING:
    import xarray as xr

    from validation.scene import Scene

__all__ = ["figures", "findings", "run", "table"]

_TARGETS = (0.1, 0.03, 0.01, 0.003, 0.001)
_AREAS = ("pixel", "perimeter", "subcell")


def run(
    *,
    scene: Scene | None = None,
    bench: Bench | None = None,
    reduced_pressure: float = 0.05,
    hurst: float = 0.8,
    size: float = 4.0,
    ratio: float = 8.0,
    surfaces: int = 12,
    points_per_wave: tuple[float, ...] = (3.0, 4.0, 6.0, 8.0, 12.0, 16.0),
    held_out: tuple[float, ...] = (16.0, 24.0, 32.0),
    fem_points_per_wave: tuple[float, ...] = (4.0, 8.0, 16.0),
    seed: int = 5006,
) -> xr.Dataset:
    """Measure error and time of every way to an area, against limits from grids that no way has seen.

    Parameters
    ----------
    scene : Scene, optional
        Gives the solid.
    bench : Bench, optional
        Where and how the cases run. Times mean something only if nothing else runs: use one worker.
    reduced_pressure : float
        p*.
    hurst, size, ratio : float
        H, L/lambda_long and lambda_long/lambda_short.
    surfaces : int
        Realisations; their claimed intervals are checked too, for which sixty are better than twelve.
    points_per_wave : tuple of float
        Grids of the boundary elements, as lambda_short/dx, rising.
    held_out : tuple of float
        Finer grids whose limit is the reference.
    fem_points_per_wave : tuple of float
        Grids of the finite elements (exact reduction).
    seed : int
        Of the first surface.

    Returns
    -------
    xarray.Dataset
        error (way, surface), relative to the reference of the surface; seconds (way); reference_error; for the limits from
        three neighbouring grids, claimed (surface): the half width of their 95 % interval, relative.
    """
    import xarray as xr

    at_least("surfaces", surfaces, 2)
    points_per_wave, held_out = ladder("points_per_wave", points_per_wave), ladder("held_out", held_out)
    surface, solid = base_surface(hurst=hurst, size=size, ratio=ratio, seed=seed), solid_of(scene)
    ladders = [
        [
            Measurement(
                surface=surface,
                realisation=k,
                solid=solid,
                reduced_pressures=(reduced_pressure,),
                grids=tuple(grid_for(surface, n) for n in grids),
                shifts=2,
            )
            for k in range(surfaces)
        ]
        for grids in (points_per_wave, held_out)
    ]
    blocks = [
        BlockMeasurement(
            surface=surface,
            realisation=k,
            solid=solid,
            reduced_pressure=reduced_pressure,
            points=grid_for(surface, n)[0],
            element=element,
        )
        for element, n, k in itertools.product(("Hex1", "Hex2"), fem_points_per_wave, range(surfaces))
    ]
    measured = measure(bench, [*ladders[0], *ladders[1], *blocks])
    coarse, fine, fem = measured[:surfaces], measured[surfaces : 2 * surfaces], measured[2 * surfaces :]
    reference = np.array([area_limits(data)[0][0] for data in fine])
    uncertainty = np.array([area_limits(data)[1][0] for data in fine]) / reference
    ways = [*_bem_ways(coarse), *_fem_ways(fem, fem_points_per_wave, surfaces)]
    claimed, missed = _claims(coarse, reference)
    return xr.Dataset(
        {
            "error": (("way", "surface"), np.array([areas / reference - 1 for _, areas, _ in ways])),
            "seconds": ("way", np.array([seconds for *_, seconds in ways]), {"units": "s"}),
            "reference_error": (
                "surface",
                uncertainty,
                {"long_name": "standard error of the reference, relative"},
            ),
            "claimed": (
                "surface",
                claimed,
                {"long_name": "half width of the claimed 95 % interval, relative"},
            ),
            "missed": (
                "surface",
                missed,
                {"long_name": "distance of the claimed limit from the reference, relative"},
            ),
        },
        coords={"label": ("way", [label for label, *_ in ways])},
        attrs={
            "study": "accuracy-cost",
            "reduced_pressure": reduced_pressure,
            "methods": "bem fem perimeter",
        },
    )


def _bem_ways(measured: list[xr.Dataset]) -> list[tuple[str, np.ndarray, float]]:
    """List (label, area of each surface, mean seconds): single grids, shifts averaged, and limits over three grids."""
    ways = []
    per_wave = measured[0].points_per_wave.values
    for i, name in itertools.product(range(per_wave.size), _AREAS):
        values = np.array([d[name][i, :, 0].values for d in measured])
        seconds = float(np.mean([d.seconds[i, :, 0].values for d in measured]))
        ways.append((f"BEM {name}, {per_wave[i]:g} per wave", values[:, 0], seconds))
        ways.append((f"BEM {name}, {per_wave[i]:g} per wave, 4 shifts", values.mean(axis=1), 4 * seconds))
    for i in range(per_wave.size - 2):
        parts = [d.isel(grid=slice(i, i + 3)) for d in measured]
        areas = np.array([area_limits(part)[0][0] for part in parts])
        seconds = float(np.mean([part.seconds.sum() for part in parts]))
        ways.append((f"BEM limit, {per_wave[i]:g} to {per_wave[i + 2]:g} per wave, 4 shifts", areas, seconds))
    return ways


def _fem_ways(
    measured: list[xr.Dataset], per_wave: tuple[float, ...], surfaces: int
) -> list[tuple[str, np.ndarray, float]]:
    ways = []
    for k, (element, n) in enumerate(itertools.product(("Hex1", "Hex2"), per_wave)):
        part = measured[k * surfaces : (k + 1) * surfaces]
        seconds = float(np.mean([float(d.seconds) for d in part]))
        for name in ("pixel", "perimeter"):
            areas = np.array([float(d[name]) for d in part])
            ways.append((f"FEM {element} {name}, {n:g} per wave", areas, seconds))
    return ways


def _claims(measured: list[xr.Dataset], reference: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Half widths of the 95 % intervals of the limits over all coarse grids, and how far those limits are off."""
    half, missed = [], []
    for data, truth in zip(measured, reference, strict=True):
        (value,), (error,) = area_limits(data)
        half.append(2 * error / truth)
        missed.append(value / truth - 1)
    return np.array(half), np.array(missed)


def root_mean_square(dataset: xr.Dataset) -> np.ndarray:
    """Return the root mean square error over the surfaces of each way, the error of the reference included."""
    return np.asarray(np.sqrt((dataset.error**2).mean("surface")).values)


def front(dataset: xr.Dataset) -> list[int]:
    """Return the ways no other beats in both time and error, cheapest first."""
    error, seconds = root_mean_square(dataset), dataset.seconds.values
    best, kept = np.inf, []
    for k in np.argsort(seconds):
        if error[k] < best:
            best = error[k]
            kept.append(int(k))
    return kept


def coverage(dataset: xr.Dataset) -> tuple[int, int]:
    """Return how many claimed intervals hold the reference (with its own interval), and of how many."""
    allowed = np.hypot(dataset.claimed.values, 2 * dataset.reference_error.values)
    return int(np.count_nonzero(np.abs(dataset.missed.values) <= allowed)), int(dataset.sizes["surface"])


def table(dataset: xr.Dataset) -> ResultTable:
    """Return the cheapest way to each accuracy; below the error of the reference it is not determinable."""
    error, seconds = root_mean_square(dataset), dataset.seconds.values
    floor = float(np.sqrt((dataset.reference_error**2).mean()))
    rows: list[tuple[float | str, ...]] = []
    for target in _TARGETS:
        good = np.flatnonzero(error <= target)
        if target < 2 * floor:
            words: tuple[float | str, ...] = (
                f"not determinable: the reference is known to {100 * floor:.2g} %",
                "",
                "",
            )
        elif not good.size:
            words = ("none of the ways tried", "", "")
        else:
            best = int(good[np.argmin(seconds[good])])
            words = (str(dataset.label.values[best]), 100 * float(error[best]), float(seconds[best]))
        rows.append((f"{100 * target:g} %", *words))
    return ResultTable.of(("accuracy of A/A0", "cheapest way", "rms error [%]", "seconds"), rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return what a digit costs and whether the claimed intervals hold."""
    sentences = []
    for row in table(dataset).rows:
        if isinstance(row[3], float):
            sentences.append(f"{row[0]} costs {row[3]:.2g} s: {row[1]} (rms error {row[2]:.2g} %).")
        else:
            sentences.append(f"{row[0]}: {row[1]}.")
    held, total = coverage(dataset)
    sentences.append(
        f"The claimed 95 % intervals of the limits over the coarse grids hold the reference on {held} of {total} surfaces "
        f"({100 * held / total:.0f} %); they are {100 * float(dataset.claimed.mean()):.2g} % wide to either side on average."
    )
    return tuple(sentences)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw error against time."""
    from validation import plots_studies

    return (
        Drawing(
            name="accuracy-cost",
            figure=plots_studies.accuracy_cost(dataset, root_mean_square(dataset), front(dataset)),
            data=dataset[["error", "seconds"]],
            caption="Root mean square error of the contact area over the surfaces against the wall time of one surface, for every method, grid and definition of the area; the line joins the ways that no other beats; grey, the error of the reference.",
        ),
    )
