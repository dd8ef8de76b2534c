"""Means over the surfaces of a spectrum: what was read off them, sorted by the grid they end with, and how many it takes."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
import scipy.special
import xarray as xr
from numpy.typing import ArrayLike

from validation.arrays import Array, Grid
from validation.errors import NoLimit
from validation.execution.bench import Bench
from validation.execution.measurement import Call, measurement
from validation.execution.solve import PAIR_SECONDS, Prediction
from validation.measurements.control_variates import (
    Controlled,
    Known,
    allocation,
    chained_mean,
    unsolved_pairs,
)
from validation.measurements.limits import solved
from validation.measurements.measurement import TOLERANCES_LEFT, area_limits, press_on_grids
from validation.measurements.statistics import pair_means
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import EffectSpec

#: Pairs of a first look, by the grid they end with, which then grow by blocks of the same size; and how often the
#: numbers are chosen anew from what was found.
_FIRST, _ROUNDS = (16, 6, 4), 8
#: Pairs that are not solved, of a first look.
_FIRST_UNSOLVED = 64
#: Between the first surfaces that end with different grids, and the first that are not solved.
_APART = 1_000_000
#: Largest factor of Student's that numbers are first chosen with.
_STUDENT = 2.1
#: Share of an interval that the grids may take; with more, surfaces that make up for it are too many.
_GRID_SHARE = 0.9

#: What is done with a block of pairs; their last grid, or how many there are for those that are not solved; the first.
_Name = tuple[str, int, int]


def _predicted(
    problem: ContactProblem,
    grids: tuple[Grid, ...],
    count: int,
    effects: tuple[EffectSpec, ...],
    pair_seconds: float,
) -> Prediction:
    surface = press_on_grids(problem=problem, grids=grids, effects=effects, shifts=1).predict()
    return replace(surface, seconds=2 * count * surface.seconds * pair_seconds / PAIR_SECONDS)


@measurement(
    "pairs-{size}",
    kind="AreaPairs",
    words="{count} pairs of surfaces, to",
    located=True,
    version=1,
    recipe=lambda made, problem, first: made | problem.further(first).recipe,
    left_out=("first",),
    predict=_predicted,
    compiled=lambda tolerance, effects: (("bem", {"tolerance": tolerance}, effects),),
)
def area_pairs(
    *,
    problem: ContactProblem,
    grids: tuple[Grid, ...],
    first: int,
    count: int,
    tolerance: float,
    effects: tuple[EffectSpec, ...],
) -> xr.Dataset:
    """Press `count` pairs +h, -h from the first realisation on, one sign after the other, on ascending grids.

    What `press_on_grids` keeps of each, with surfaces in the place of loads, and the processor time of each
    on all grids (load). Each meets the load as a scene says it. With effects, edges are not located, and the
    corrected area stands for the area.
    """
    made = []
    for k, mirrored in itertools.product(range(first, first + count), (False, True)):
        drawn, began = problem.further(k), time.process_time()
        surface = replace(drawn, inverted=drawn.inverted != mirrored)
        areas = press_on_grids(
            problem=surface, grids=grids, effects=effects, shifts=1, tolerance=tolerance
        ).do()
        made.append(areas.assign(seconds=("load", [time.process_time() - began])))
    return xr.concat(made, "load", combine_attrs="drop")


@dataclass(frozen=True, kw_only=True)
class Chained:
    """Surfaces of one spectrum, in pairs +h, -h, some of which end with each grid."""

    unsolved: Array  # (n, k): Statistics without a solve of the pairs that end with the coarsest grid
    further: Array  # (m, k): The same of pairs that are not solved at all
    unsolved_seconds: float  # Processor time of the statistics of all these
    #: (surface, load): That of the solves, by the last grid of a surface, coarsest first.
    seconds: Sequence[Array]

    @classmethod
    def of(
        cls, unsolved: Sequence[xr.Dataset], further: Sequence[xr.Dataset], seconds: Sequence[Array]
    ) -> Self:
        """Take statistics from what `unsolved_pairs` left."""
        values = [np.concatenate([block.value.values for block in blocks]) for blocks in (unsolved, further)]
        spent = sum(float(block.attrs["seconds"]) for block in (*unsolved, *further))
        return cls(unsolved=values[0], further=values[1], unsolved_seconds=spent, seconds=seconds)

    def chains(self, values: Callable[[int, int], Array]) -> list[tuple[Controlled, ...]]:
        """Return the controlled means of a quantity on all grids, for each load; the last is the one that counts.

        `values` gives (load, surface) of the surfaces that end with one grid, on another.
        """
        numbers = [pair_means(values(0, 0))]
        for last in range(1, len(self.seconds)):
            numbers += [pair_means(values(last, grid)) for grid in (last, last - 1)]
        known = Known.of_samples(self.further)
        return [
            chained_mean([(first, self.unsolved), *zip(rest[::2], rest[1::2], strict=True)], known)
            for first, *rest in zip(*numbers, strict=True)
        ]

    def parts(self, chain: Sequence[Controlled]) -> list[tuple[float, float]]:
        """Return variance and processor time of one pair that ends with each grid, then of one that is not solved."""
        look = self.unsolved_seconds / (len(self.unsolved) + len(self.further))
        slopes = chain[0].coefficients
        explained = float(slopes @ np.cov(self.further, rowvar=False) @ slopes)
        times = [2 * seconds.sum(axis=1).mean() for seconds in self.seconds]
        times[0] += look
        # The mean of a level is multiplied by the coefficients of those above it.
        above = [math.prod(mean.coefficients.item() for mean in chain[k + 1 :]) for k in range(len(chain))]
        solves = [(f**2 * mean.left, time) for f, mean, time in zip(above, chain, times, strict=True)]
        return [*solves, (above[0] ** 2 * explained, look)]

    def savings(self, chains: Sequence[Sequence[Controlled]], coarse: Array) -> Array:
        """Return the processor time of plain means over single surfaces, for the same intervals, over that spent, (load,).

        Their scatter is that of the `coarse` grid, (load, surface), on which there are many; each takes all grids.
        """
        errors = np.array([chain[-1].half_width / chain[-1].value for chain in chains])
        scatter = coarse.std(axis=1, ddof=1) / coarse.mean(axis=1) / errors * scipy.special.ndtri(0.975)
        spent = sum(seconds.sum(axis=0) for seconds in self.seconds) + self.unsolved_seconds
        return np.asarray(scatter**2 * self.seconds[-1].mean(axis=0) / spent)


def common_error(errors: ArrayLike) -> Array:
    """Half of the 95 % interval of what the grids leave, by surface (n, ...): alike on all, it does not average."""
    return np.asarray(1.96 * np.sqrt(np.mean(np.square(errors), axis=0)))


@dataclass(frozen=True, kw_only=True)
class MeanArea:
    """The mean A/A0 over all surfaces of a spectrum."""

    chain: tuple[Controlled, ...]  # Means on all grids, the last of their limits
    grid: float  # Half of the 95 % interval of what grids and solver leave
    grids: tuple[Grid, ...]
    pairs: tuple[int, ...]  # Pairs +h, -h that end with each grid, coarsest first
    unsolved: int  # Further pairs that are only looked at
    scatter: float  # Standard deviation of single surfaces over the mean, on the coarsest grid
    peak_bytes: int  # Largest memory of the arrays of any solve

    @property
    def estimate(self) -> Controlled:
        """Limit over grids, with what the scatter of surfaces leaves."""
        return self.chain[-1]

    @property
    def surfaces(self) -> int:
        """Surfaces that were solved."""
        return 2 * sum(self.pairs)

    @property
    def half_width(self) -> float:
        """Half of the 95 % interval: surfaces, grids and solver."""
        return float(np.hypot(self.estimate.half_width, self.grid))


#: Called with what was found so far and the solves that come next; raises to stop.
Watch = Callable[[MeanArea, Sequence[Call]], None]


def mean_area(
    base: ContactProblem,
    *,
    half_width: float,
    bench: Bench,
    grids: tuple[Grid, ...],
    effects: Sequence[EffectSpec] = (),
    tolerance: float = 1e-6,
    watch: Watch | None = None,
) -> MeanArea:
    """Mean contact area of all surfaces of a spectrum to a given accuracy, from as few solves as it takes.

    A NoLimit for a surface without a limit, as a contact of too few points has none.

    Parameters
    ----------
    base : ContactProblem
        Surface, solid and one load; each surface meets it as it is said, p* of its own gradient or one pressure.
    half_width : float
        Half of the 95 % interval, relative to the mean: surfaces, grids and solver. It stays wider where the grids
        leave nine tenths of that or more, or eight rounds did not suffice.
    grids : tuple of (int, int)
        Two or three, ascending.
    effects : sequence
        Of those whose corrected area has a law of error (`fem_contact.extrapolation.perimeter_limit`).
    watch : callable, optional
        Called before each round but the first with the mean so far and the solves that come next; raises to stop.
    """
    drawn = _Drawn(base=base, grids=grids, tolerance=tolerance, effects=tuple(effects))
    known: dict[_Name, xr.Dataset] = solved(bench, drawn.cases())
    for rounds in itertools.count(1):
        ending, chained = drawn.samples(known)
        result = _estimated(ending, chained, grids=grids, tolerance=tolerance)
        target = half_width * result.estimate.value
        left = np.sqrt(max(target**2 - result.grid**2, 0.0))
        enough = result.estimate.half_width <= left or result.grid >= _GRID_SHARE * target
        if enough or rounds == _ROUNDS:
            break
        factor = result.estimate.half_width / result.estimate.standard_error
        parts = chained.parts(result.chain)
        # What Student's factor of few pairs adds goes with more of them.
        for student in (min(factor, _STUDENT), factor):
            drawn.grow(allocation(parts, left / student))
            if missing := {name: case for name, case in drawn.cases().items() if name not in known}:
                break
        if watch is not None:
            watch(result, tuple(missing.values()))
        known |= solved(bench, missing)
    return result


def _estimated(
    ending: Sequence[xr.Dataset], chained: Chained, *, grids: tuple[Grid, ...], tolerance: float
) -> MeanArea:
    levels = len(ending)
    # Those that end with coarser grids are controls: their areas are read as they are.
    if any(np.isnan(area_limits(pressed)).any() for pressed in ending[min(2, levels - 1) :]):
        raise NoLimit("a surface of the ensemble has no limit on these grids; all solves are stored")

    def values(last: int, grid: int) -> Array:
        if grid >= 2 or grid == levels - 1:
            return area_limits(ending[last].isel(grid=slice(grid + 1)))[0][None]
        on_grid = ending[last].isel(grid=grid)
        return np.asarray(on_grid.subcell.fillna(on_grid.perimeter))

    (chain,) = chained.chains(values)
    coarse, grid_error = values(0, 0), float(common_error(area_limits(ending[-1])[1]))
    return MeanArea(
        chain=chain,
        grid=grid_error + TOLERANCES_LEFT * tolerance * chain[-1].value,
        grids=grids,
        pairs=tuple(pressed.sizes["load"] // 2 for pressed in ending),
        unsolved=len(chained.further),
        scatter=coarse.std(ddof=1) / coarse.mean(),
        peak_bytes=int(max(pressed.peak_bytes.max() for pressed in ending)),
    )


@dataclass(kw_only=True)
class _Drawn:
    """Surfaces of one spectrum that are solved or looked at so far; their numbers only grow."""

    base: ContactProblem
    grids: tuple[Grid, ...]
    tolerance: float
    effects: tuple[EffectSpec, ...] = ()
    #: Pairs that end with each grid, coarsest first, and that are not solved.
    counts: list[int] = field(init=False)

    def __post_init__(self) -> None:
        self.counts = [*self._blocks]

    @property
    def _blocks(self) -> tuple[int, ...]:
        return _FIRST[0], *_FIRST[1 - len(self.grids) :], _FIRST_UNSOLVED

    def cases(self) -> dict[_Name, Call]:
        """Return the blocks of pairs that end with each grid, and of those that are looked at."""
        calls: dict[_Name, Call] = {}
        for last, (count, size) in enumerate(zip(self.counts, self._blocks, strict=True)):
            for k in range(0, count, size):
                block: dict[str, Any] = {"problem": self.base, "first": k + last * _APART, "count": size}
                if last in (0, len(self.grids)):
                    calls["looked", last, k] = unsolved_pairs(grid=self.grids[0], **block)
                if last < len(self.grids):
                    calls["pressed", last, k] = area_pairs(
                        grids=self.grids[: last + 1], tolerance=self.tolerance, effects=self.effects, **block
                    )
        return calls

    def samples(self, known: Mapping[_Name, xr.Dataset]) -> tuple[list[xr.Dataset], Chained]:
        """Return what was read off the surfaces that end with each grid, and their statistics and times."""

        def of(what: str, last: int) -> list[xr.Dataset]:
            return [known[name] for name in self.cases() if name[:2] == (what, last)]

        levels = len(self.grids)
        ending = [xr.concat(of("pressed", last), "load") for last in range(levels)]
        seconds = [pressed.seconds.values[:, None] for pressed in ending]
        return ending, Chained.of(of("looked", 0), of("looked", levels), seconds)

    def grow(self, numbers: Sequence[int]) -> None:
        """Take at least so many pairs that end with each grid, and that are only looked at, in whole blocks."""
        sizes = zip(self.counts, numbers, self._blocks, strict=True)
        self.counts = [max(old, size * math.ceil(new / size)) for old, new, size in sizes]
