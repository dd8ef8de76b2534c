"""Is the mean area over surfaces cheaper from many coarse grids and few fine ones?

Multilevel Monte Carlo: the mean on the finest grid is the mean on the coarsest plus the mean differences between
neighbouring grids, each from surfaces of its own, the two grids of a difference sharing theirs. Differences scatter
little, so that few surfaces are needed where a solve is dear.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field

from validation.measures.common import Rising, base_case, base_surface, named, results_of
from validation.measures.controlled import allocation as least_cost
from validation.measures.measurement import Measurement, grid_for, grid_tolerance
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.solves.bench import Bench
from validation.studies._options import Bandwidth, Hurst, Periods, ReducedPressure, Seed
from validation.studies._study import StudyOptions

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

__all__ = [
    "Level",
    "Options",
    "allocation",
    "estimate",
    "figures",
    "findings",
    "run",
    "saving",
    "table",
]

_AREAS = ("pixel", "perimeter", "subcell")

#: Between the first surfaces of neighbouring levels, so that no surface serves two of them.
_APART = 100_000


class Options(StudyOptions):
    """Levels, and the error that is asked for. Costs are times: use one worker and a quiet machine."""

    own = "it asks about means over many surfaces of one spectrum"

    points_per_wave: Annotated[
        Rising, Field(min_length=2, description="grids, as lambda_short/dx, rising")
    ] = (
        4.0,
        8.0,
        16.0,
    )
    area: Literal["pixel", "perimeter", "subcell"] = Field(
        default="subcell", description="definition of the area"
    )
    error: float = Field(
        default=0.002, gt=0, lt=1, description="standard error of the mean that is asked for, relative"
    )
    pilot: int = Field(
        default=12,
        ge=4,
        le=10_000,
        description="surfaces of each level from which its variance and cost are first told",
    )
    reduced_pressure: ReducedPressure = 0.05
    hurst: Hurst = 0.8
    periods: Periods = 4.0
    bandwidth: Bandwidth = 8.0
    seed: Seed = 1607


@dataclass(frozen=True, kw_only=True)
class Level:
    """One term of the telescoping sum.

    Attributes
    ----------
    variance : float
        Between surfaces, of the area on the coarsest grid or of its difference between two neighbouring grids.
    cost : float
        Of one surface, on both grids [s].
    """

    variance: float
    cost: float


def allocation(levels: Sequence[Level], error: float) -> tuple[int, ...]:
    """Return how many surfaces of each level bring the standard error of the sum to `error` at least cost.

    Examples
    --------
    >>> allocation([Level(variance=1.0, cost=1.0), Level(variance=0.01, cost=4.0)], 0.1)
    (120, 6)
    """
    return least_cost([(level.variance, level.cost) for level in levels], error)


def saving(levels: Sequence[Level], *, variance: float, cost: float) -> float:
    """Return the cost of plain Monte Carlo over that of the levels, at one statistical error.

    Parameters
    ----------
    levels : sequence of Level
    variance, cost : float
        Between surfaces and of one surface, on the finest grid alone.

    Examples
    --------
    >>> saving([Level(variance=1.0, cost=1.0)], variance=1.0, cost=1.0)
    1.0
    """
    return float(variance * cost / sum(np.sqrt(level.variance * level.cost) for level in levels) ** 2)


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Measure variance and cost of each level on some surfaces, then solve as many as the error takes.

    Returns
    -------
    xarray.Dataset
        Over `level`: mean and variance of the level's term, cost of one surface, surfaces that were solved; over
        (level, definition): the same variances for every definition of the area. The attributes hold the estimate.
    """
    first = _solved(options, [options.pilot] * len(options.points_per_wave), bench=bench)
    levels = [_level(part, options.area) for part in first]
    scale = float(np.mean(_terms(first[0], options.area)))
    counts = [max(count, options.pilot) for count in allocation(levels, options.error * scale)]
    return _dataset(_solved(options, counts, bench=bench), options)


def _solved(options: Options, counts: Sequence[int], *, bench: Bench) -> list[list[xr.Dataset]]:
    """Solve so many surfaces of each level, each on the two grids of the level."""
    surface = base_surface(
        hurst=options.hurst, periods=options.periods, bandwidth=options.bandwidth, seed=options.seed
    )
    first = base_case(surface, reduced_pressure=options.reduced_pressure)
    grids = [grid_for(first, n) for n in options.points_per_wave]
    found = results_of(
        bench,
        {
            (level, k): Measurement(
                realised=first.further(k + _APART * level),
                grids=tuple(grids[max(level - 1, 0) : level + 1]),
                shifts=1,
                tolerance=grid_tolerance(first, grids),
            )
            for level, count in enumerate(counts)
            for k in range(count)
        },
    )
    return [[found[level, k] for k in range(count)] for level, count in enumerate(counts)]


def _dataset(found: Sequence[Sequence[xr.Dataset]], options: Options) -> xr.Dataset:
    import xarray as xr

    area, terms = options.area, [_terms(part, options.area) for part in found]
    alone = float(np.mean([float(d.seconds[-1, 0, 0]) for d in found[-1]]))
    every = {name: [_level(part, name) for part in found] for name in _AREAS}
    savings = [saving(every[name], variance=_finest_variance(found, name), cost=alone) for name in _AREAS]
    means = np.array([term.mean() for term in terms])
    return xr.Dataset(
        {
            "mean": named("level", means, "mean area, then differences"),
            "variance": ("level", np.array([term.var(ddof=1) for term in terms])),
            "cost": ("level", np.array([level.cost for level in every[area]]), {"units": "s"}),
            "surfaces": ("level", np.array([len(part) for part in found])),
            "saving": named(
                "definition",
                np.array(savings),
                "cost of plain Monte Carlo on the finest grid over that of the levels",
            ),
        },
        coords={
            "points_per_wave": ("level", list(options.points_per_wave)),
            "definition": ("definition", list(_AREAS)),
        },
        attrs={
            "study": "multilevel",
            "area": area,
            "error": options.error,
            "finest_variance": _finest_variance(found, area),
            "finest_cost": alone,
            "methods": "bem",
        },
    )


def _terms(measured: Sequence[xr.Dataset], area: str) -> NDArray[np.float64]:
    """Return the area on the only grid, or its difference between two, of each surface."""
    values = np.array([d[area][:, 0, 0].values for d in measured])
    return np.asarray(values[:, -1] - values[:, 0] if values.shape[1] > 1 else values[:, 0])


def _finest_variance(found: Sequence[Sequence[xr.Dataset]], area: str) -> float:
    """Return the variance between surfaces on the finest grid.

    The few surfaces of the finest level tell it badly. That of the coarsest is well known, and by how much it changes
    from grid to grid is, too, because both grids of a level have their surfaces in common.
    """
    variance = float(_terms(found[0], area).var(ddof=1))
    for part in found[1:]:
        coarse, fine = np.array([d[area][:, 0, 0].values for d in part]).var(axis=0, ddof=1)
        variance *= float(fine / coarse)
    return variance


def _level(measured: Sequence[xr.Dataset], area: str) -> Level:
    cost = float(np.mean([float(d.seconds.sum()) for d in measured]))
    return Level(variance=float(_terms(measured, area).var(ddof=1)), cost=cost)


def estimate(dataset: xr.Dataset) -> tuple[float, float]:
    """Return the mean area on the finest grid, and its standard error."""
    return float(dataset["mean"].sum()), float(np.sqrt((dataset.variance / dataset.surfaces).sum()))


def _plain(dataset: xr.Dataset, level: int, error: float) -> tuple[int, float]:
    """Surfaces and seconds that plain Monte Carlo on the grid of a level takes for a standard error."""
    # Between surfaces the area scatters alike on all grids; a difference of two grids costs about what both do.
    variance = float(dataset.attrs["finest_variance"])
    cost = float(dataset.cost[0]) if level == 0 else float(dataset.cost[level] - dataset.cost[level - 1])
    cost = float(dataset.attrs["finest_cost"]) if level == dataset.sizes["level"] - 1 else cost
    count = max(2, int(np.ceil(variance / error**2)))
    return count, count * cost


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each level, then the sums."""
    mean, error = estimate(dataset)
    rows: list[tuple[float | str, ...]] = []
    for i, n in enumerate(dataset.points_per_wave.values):
        what = (
            f"{n:g} per wave" if i == 0 else f"{n:g} less {float(dataset.points_per_wave[i - 1]):g} per wave"
        )
        deviation = float(np.sqrt(dataset.variance[i])) / mean
        cost, count = float(dataset.cost[i]), int(dataset.surfaces[i])
        rows.append(
            (what, 100 * float(dataset["mean"][i]) / mean, 100 * deviation, cost, float(count), cost * count)
        )
    spent = float((dataset.cost * dataset.surfaces).sum())
    rows.append(("sum", 100.0, 100 * error / mean, "", float(dataset.surfaces.sum()), spent))
    count, seconds = _plain(dataset, dataset.sizes["level"] - 1, error)
    rows.append(
        (
            "plain, finest grid",
            100.0,
            100 * error / mean,
            float(dataset.attrs["finest_cost"]),
            float(count),
            seconds,
        )
    )
    return ResultTable.of(
        (
            "level",
            "mean [% of the sum]",
            "scatter (sums: standard error) [%]",
            "s per surface",
            "surfaces",
            "seconds",
        ),
        rows,
    )


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return the estimate, what it saved, and whether it was worth it."""
    mean, error = estimate(dataset)
    area, grids = dataset.attrs["area"], dataset.points_per_wave.values
    spent = float((dataset.cost * dataset.surfaces).sum())
    count, seconds = _plain(dataset, len(grids) - 1, error)
    sentences = [
        f"Mean A/A0 ({area}, {grids[-1]:g} points per wave) {mean:.5f} +- {100 * error / mean:.2g} % (one standard error) from "
        f"{', '.join(str(int(n)) for n in dataset.surfaces.values)} surfaces on the levels, coarse to fine: {spent:.2g} s; plain Monte Carlo "
        f"on the finest grid takes {count} surfaces and {seconds:.2g} s for that error, {seconds / spent:.2g} times as long.",
        "With the best numbers of surfaces the levels save a factor of "
        + ", ".join(
            f"{float(dataset.saving.sel(definition=name)):.2g} ({name})" for name in dataset.definition.values
        )
        + " against the finest grid alone.",
    ]
    for level in range(len(grids) - 1):
        bias = abs(float(dataset["mean"][level + 1 :].sum())) / mean
        if bias <= 0.5 * error / mean:
            _, plain = _plain(dataset, level, error)
            verdict = (
                f"{spent / plain:.2g} times less than"
                if plain < spent
                else f"{plain / spent:.2g} times as much as"
            )
            worth = "not" if plain < spent else ("hardly" if plain < 2 * spent else "well")
            sentences.append(
                f"Plain Monte Carlo on {grids[level]:g} points per wave alone is off by {100 * bias:.2g} %, less than half of the "
                f"statistical error, and takes {plain:.2g} s, {verdict} the levels: at this error they are {worth} worth it."
            )
            break
    else:
        sentences.append(
            "No coarser grid alone is within half of the statistical error of the finest: the levels are worth it."
        )
    return tuple(sentences)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw variance and cost of the levels."""
    return (
        Drawing(
            name="multilevel",
            figure=_levels_figure(dataset),
            data=dataset[["variance", "cost", "surfaces"]],
            caption="Left: scatter between surfaces of the area on the finest grid and of the terms of the telescoping sum. "
            "Right: time of one surface, and the number of surfaces of each term.",
        ),
    )


def _levels_figure(dataset: xr.Dataset) -> Figure:
    """Scatter of the levels against their resolution, and their cost and number of surfaces."""
    from validation.report.figure import new_figure, plain_look

    figure, (left, right) = new_figure(width=9.0, columns=2, height=3.6)
    mean, _ = estimate(dataset)
    level = np.arange(dataset.sizes["level"])
    grids = [f"{n:g}" for n in dataset.points_per_wave.values]
    names = [grids[0], *(f"{b} - {a}" for a, b in itertools.pairwise(grids))]
    scatter = 100 * np.sqrt(dataset.variance.values) / mean
    left.plot(level, scatter, label="term of the sum", **plain_look(0))
    alone = 100 * float(np.sqrt(dataset.attrs["finest_variance"])) / mean
    left.axhline(alone, color="black", lw=0.8, label="area on the finest grid")
    left.set_ylabel("scatter between surfaces [%]")
    right.plot(level, dataset.cost.values, label="seconds for one surface", **plain_look(1))
    right.plot(level, dataset.surfaces.values, label="surfaces", **plain_look(2))
    right.set_ylabel("seconds; surfaces")
    for axes in (left, right):
        axes.set_yscale("log")
        axes.set_xticks(level, names)
        axes.set_xlabel("points per shortest wave")
        axes.legend(fontsize=8)
    return figure
