"""The search for the grids and surfaces that an accuracy takes: what each claims, and what it costs."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import scipy.fft

from fem_contact.area import ContactAreas
from fem_contact.extrapolation import PlannedGrid, predicted_uncertainty, too_small
from validation.arrays import Grid
from validation.comparison.reductions import grid_name, too_far_apart
from validation.errors import NoLimit, RunFailed, UsageError
from validation.execution.attempt import warm_up
from validation.execution.bench import Bench, Solves
from validation.execution.measurement import Call
from validation.execution.press import Press, solves_of
from validation.execution.solve import Prediction, Solve, memory_words, transform_seconds
from validation.measurements.ensemble import MeanArea, area_pairs, mean_area
from validation.measurements.measurement import (
    TOLERANCES_LEFT,
    areas_of_solve,
    has_square_cells,
    limit_over,
    no_limit,
)
from validation.report.words import percent, significant
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import Methods, Scene
from validation.solvers.bem import BemOptions

Grids: TypeAlias = tuple[Grid, ...]

#: Grids that are considered, as points per shortest wave; below the first an area says little of its limit.
_LEVELS = (3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256)

#: Tolerance over the error asked for.
_SOLVER_SHARE = 0.002
_TOLERANCES = (1e-8, 1e-4)

#: Surfaces solved for a mean, in all.
_MOST_SURFACES = 65_536

#: A claim is predicted from a coarser grid than it will be made from: some of the target is left for that.
_SPARE = 0.9
#: Share of the target that the grids of a mean may take: few surfaces are solved on the finest, many more are
#: needed where it leaves less for their scatter.
_GRID_SHARE = 0.4

#: Points per shortest wave that the finest grid of a mean has unless memory or time forbid it: what is saved
#: on coarser ones is lost to their scatter.
_USUAL_LEVEL = 12

#: Points per shortest wave from which on a contact without a limit will have none on finer grids, unless it
#: is too small.
_RESOLVED = 16

#: Times of solves over what a few of their kind foretell, the more while others use the machine, too.
_FORETOLD = (0.7, 2.0)

#: How far the sides of the cells of a grid may differ.
_OBLONG = 0.02


#: Seconds, taken and predicted, beside which those of a kind of solves tell little [s].
_LITTLE = (0.1, 0.1)


@dataclass(kw_only=True)
class Account:
    """What was spent so far: seconds, solves `found` finished and `done`; what is `reserved` for the last.

    By the kind of solves, `alike` has the seconds that these took, and those that were predicted.
    """

    solving: float = 0.0
    predicted: float = 0.0
    found: set[Solve] = field(default_factory=set)
    done: set[Solve] = field(default_factory=set)
    reserved: float = 0.0
    alike: dict[str, tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Metered(Bench):
    """A bench that refuses what does not end within a time limit, `time_limit` seconds from `clock` on.

    Messages begin with what is `wanted`; `pair` is the time of a pair of transforms on this machine [s].
    """

    wanted: str = ""
    time_limit: float | None = None
    pair: float = field(default_factory=transform_seconds)
    clock: float = field(default_factory=time.perf_counter)
    account: Account = field(default_factory=Account)

    @property
    def spent(self) -> float:
        """Seconds since the clock was started."""
        return time.perf_counter() - self.clock

    def seconds(self, solve: Solve) -> float:
        """Predict what a solve takes, by what those of its kind took; else by the machine alone."""
        taken, predicted = self.account.alike.get(_kind(solve), _LITTLE)
        return solve.predict(pair_seconds=self.pair).seconds * taken / predicted

    def affordable(self, seconds: float, peak_bytes: int = 0) -> bool:
        """Whether solves of so many seconds in all would end in time, and the largest fits into memory."""
        left = math.inf if self.time_limit is None else self.time_limit - self.spent - self.account.reserved
        return seconds / self.execution.workers <= left and peak_bytes <= self.memory

    def means(self) -> str:
        """Say what memory and time are left."""
        words = f"{memory_words(self.memory)} are free"
        if self.time_limit is not None:
            words += f" and {max(self.time_limit - self.spent - self.account.reserved, 0):.3g} s are left"
            words += f" beside {self.account.reserved:.2g} s for other methods" * (self.account.reserved > 0)
        return words

    def solve(self, solves: Iterable[Solve], *, despite_failures: bool = False) -> Solves:
        """Solve what is not stored yet.

        A RunFailed for solves that would not end in time, before they begin, and as `Bench.solve`.
        """
        wanted, account = tuple(solves), self.account
        missing = [solve for solve in wanted if not self.store.path(solve).exists()]
        # What is solved here, now or before, is not taken from the store.
        account.found |= set(wanted) - set(missing) - account.done
        account.done |= set(missing)
        if not missing:
            return super().solve(wanted, despite_failures=despite_failures)
        seconds = sum(map(self.seconds, missing))
        if not self.affordable(seconds):
            late = f"solves take longer here than predicted, {missing[0].describe()} would not end in time"
            remedy = "all finished solves are stored: allow more with --time-limit"
            raise RunFailed(f"{self.wanted}: {late}, and {self.means()}; {remedy}")
        warm_up(missing)  # not charged to the solves, whose time tells how fast the machine is
        account.predicted += seconds / self.execution.workers
        start = time.perf_counter()
        results = super().solve(wanted, despite_failures=despite_failures)
        account.solving += time.perf_counter() - start
        for solve, made in zip(results.solves, results.made(), strict=True):
            if solve in missing:
                taken, predicted = account.alike.get(_kind(solve), _LITTLE)
                predicted += solve.predict(pair_seconds=self.pair).seconds
                account.alike[_kind(solve)] = taken + made.seconds, predicted
        return results


def _kind(solve: Solve) -> str:
    """Name solves whose predictions are off by the same factor."""
    return solve.describe().partition(", surface")[0]


def grid_words(grids: Sequence[Grid]) -> str:
    """Name grids."""
    return ", ".join(map(grid_name, grids))


@dataclass(frozen=True, kw_only=True)
class Ladder:
    """Grids that are solved together, coarse to fine, with what is claimed from them."""

    grids: Grids
    shifts: int
    error: float
    seconds: float
    peak_bytes: int


@dataclass(frozen=True, kw_only=True)
class Single:
    """The scene's own surface, solved on `shifts`^2 sub-grid shifts of each of its `grids`.

    The error is half of the 95 % interval, relative to the limit of A/A0.
    """

    grids: Grids
    shifts: int
    area: float
    error: float
    finest: ContactAreas

    @property
    def located(self) -> bool:
        """Whether the limit is of the area whose edge is located inside the cells, or corrected."""
        return self.finest.subcell is not None


@dataclass(frozen=True, kw_only=True)
class Beside:
    """What another method of the scene says of the same surface, on the grids that its table names.

    `area` is the limit over them, and `error` half of its 95 % interval, relative; NaN, and a `doubt`, where
    there is none. It is of the `located` area, or of the one corrected at its edge.
    """

    method: str
    label: str
    grids: Grids
    area: float
    error: float
    located: bool
    doubt: str


@dataclass(kw_only=True)
class Search:
    """A search for the cheapest grids; what it has learnt of the surface and of the machine."""

    scene: Scene
    problem: ContactProblem
    target: float
    bench: Metered
    areas: dict[Press, ContactAreas] = field(default_factory=dict)
    costs: dict[Grid, Prediction] = field(default_factory=dict)
    peak_bytes: int = 0
    doubt: float = 1.0

    @property
    def tolerance(self) -> float:
        """Tolerance whose error is little of the one asked for."""
        return float(np.clip(_SOLVER_SHARE * self.target, *_TOLERANCES))

    @property
    def left(self) -> float:
        """Relative error that it leaves in an area."""
        return TOLERANCES_LEFT * self.tolerance

    @cached_property
    def others(self) -> dict[str, tuple[Press, ...]]:
        """Solves of the other methods that the scene lists, by method."""
        methods = self.scene.methods
        names = [name for name in methods.solvers if name != "bem"]
        return {name: self._solves(**{name: methods.options(name)}) for name in names}

    @cached_property
    def shared(self) -> Grids:
        """Grids of other methods, on which boundary elements are solved, too, to compare point by point."""
        grids = {solve.grid for solves in self.others.values() for solve in solves}
        fine = (grid for grid in sorted(grids) if self.problem.points_per_wave(grid) >= _LEVELS[0])
        return tuple(grid for grid in fine if has_square_cells(self.problem, grid))

    def own_surface(self) -> Single:
        """Solve the scene's own surface to the accuracy."""
        known = min(self._solved(self._jobs(self.shared or (self._grid(4),), 1)), key=lambda a: a.spacing)
        if self.problem.load.held and not known.pixel:
            raise too_far_apart(self.problem)
        tried: set[Grids] = set()
        while True:
            ladder = self._cheapest(self._ladders(known), tried, share=_SPARE)
            tried.add(ladder.grids)
            self._foretell(f"this surface on {grid_words(ladder.grids)}", ladder.seconds)
            areas = self._solved(self._jobs(ladder.grids, ladder.shifts))
            limit = limit_over(areas)
            error = 2 * limit.uncertainty / limit.value + self.left if limit.determinable else np.inf
            known = min(areas, key=lambda area: area.spacing)
            resolved = self.problem.points_per_wave(ladder.grids[-1]) >= _RESOLVED
            if limit.doubt and resolved and not too_small(areas):
                raise RunFailed(f"{self.bench.wanted}: {limit.doubt}; all solves are stored")
            # Where grids disagree by more than the law allows, they will again.
            if np.isfinite(error):
                self.doubt = max(self.doubt, _SPARE * error / ladder.error)
            if error <= self.target:
                return Single(
                    grids=ladder.grids, shifts=ladder.shifts, area=limit.value, error=error, finest=known
                )

    def ensemble(self, single: Single) -> MeanArea:
        """Solve the pairs of surfaces whose controlled mean meets the accuracy at least cost."""
        tried: set[Grids] = set()
        while True:
            chains = list(self._chains(single.finest))
            usual = [c for c in chains if self.problem.points_per_wave(c.grids[-1]) >= _USUAL_LEVEL]
            possible = any(self.bench.affordable(chain.seconds, chain.peak_bytes) for chain in usual)
            ladder = self._cheapest(usual if possible else chains, tried, share=_GRID_SHARE)
            tried.add(ladder.grids)
            try:
                ensemble = mean_area(
                    self.problem,
                    half_width=self.target,
                    bench=self.bench,
                    grids=ladder.grids,
                    effects=self.scene.effects,
                    tolerance=self.tolerance,
                    watch=self._watch,
                )
            except NoLimit:
                # One of many contacts is too small for these grids; the next are finer.
                tried |= {chain.grids for chain in chains if chain.seconds <= ladder.seconds}
                continue
            self.peak_bytes = max(self.peak_bytes, ensemble.peak_bytes)
            if ensemble.half_width <= self.target * ensemble.estimate.value:
                return ensemble
            grid = ensemble.grid / ensemble.estimate.value
            if grid < _SPARE * self.target:
                again = "all solves are stored: run it again, or ask for less"
                raise RunFailed(f"{self._known(ensemble)}; {again}")
            self.doubt = max(self.doubt, grid / ladder.error) * self.doubt

    def beside(self) -> tuple[Beside, ...]:
        """Solve what other methods the scene lists."""
        self.bench.account.reserved = 0.0
        others = []
        for name, solves in self.others.items():
            resolved = [solve for solve in solves if self.problem.resolved_by(solve.grid)]
            limit = no_limit("no grid resolves the surface")
            try:
                self._solved(solves)
                if resolved:
                    limit = limit_over([self.areas[solve] for solve in resolved])
            except RunFailed as error:  # it does not keep the others from being heard
                limit = no_limit(str(error))
            beside = Beside(
                method=name,
                label=solves[0].solver.label,
                grids=tuple(dict.fromkeys(solve.grid for solve in solves)),
                area=limit.value,
                error=2 * limit.uncertainty / limit.value,
                located=limit.definition == "subcell",
                doubt=limit.doubt,
            )
            others.append(beside)
        return tuple(others)

    def reserve(self) -> None:
        """Keep time for the methods beside, and refuse those that time or memory do not allow."""
        for name, listed in self.others.items():
            solves = [solve for solve in listed if not self.bench.store.path(solve).exists()]
            if not solves:
                continue
            costs = [solve.predict(pair_seconds=self.bench.pair) for solve in solves]
            seconds, peak = sum(cost.seconds for cost in costs), max(cost.peak_bytes for cost in costs)
            if not self.bench.affordable(seconds, peak):
                needs = f"needs about {memory_words(peak)} and {seconds:.2g} s on its own grids"
                remedy = f"{self.bench.means()}; name coarser ones, or leave it out"
                raise UsageError(f"{self.bench.wanted}: methods.{name} {needs}, and {remedy}")
            self.bench.account.reserved += seconds / self.bench.execution.workers

    def _watch(self, ensemble: MeanArea, solves: Sequence[Call]) -> None:
        """Say what the next solves of a mean take; a RunFailed where time or surfaces would run out.

        `ensemble` is the mean so far; a block of pairs has two surfaces for each.
        """
        seconds = sum(map(self.bench.seconds, solves))
        pairs = sum(call["count"] for call in solves if call.measurement is area_pairs)
        surfaces = ensemble.surfaces + 2 * pairs
        if not self.bench.affordable(seconds) or surfaces > _MOST_SURFACES:
            needs = f"about {significant(seconds, 2)} s more, or more than {_MOST_SURFACES} surfaces"
            means = f"{self.bench.means()}; all solves are stored"
            raise RunFailed(f"{self._known(ensemble)}; it needs {needs}, and {means}")
        self._foretell(f"{surfaces} surfaces for the mean", seconds)

    def _foretell(self, what: str, seconds: float) -> None:
        each = seconds / self.bench.execution.workers
        least, most = (significant(factor * each, 2) for factor in _FORETOLD)
        self.bench.progress.plan(f"{self.bench.wanted}: {what}, {least} to {most} s of solving")

    def _known(self, ensemble: MeanArea) -> str:
        error = percent(ensemble.half_width / ensemble.estimate.value)
        return f"{self.bench.wanted}: the mean over {ensemble.surfaces} surfaces is known to {error}"

    def _grid(self, per_wave: float) -> Grid:
        """Return an even grid of fast transforms and nearly square cells of at least that resolution."""
        wave, (long, wide) = self.problem.shortest, self.scene.surface.length
        least = [int(np.ceil(per_wave * length / wave / 2 - 1e-9)) for length in (long, wide)]
        nx, ny = (2 * scipy.fft.next_fast_len(n, real=True) for n in least)
        # Some number of points along x leaves cells that are nearly square.
        along = (2 * n for n in itertools.count(least[0]))
        pairs = itertools.chain([(nx, ny)], ((n, 2 * round(n * wide / long / 2)) for n in along))
        return next((nx, ny) for nx, ny in pairs if ny >= 2 and abs(nx * wide / (ny * long) - 1) <= _OBLONG)

    def _ladders(self, known: ContactAreas) -> Iterator[Ladder]:
        levels = tuple(dict.fromkeys(self._grid(level) for level in _LEVELS))
        spans = [levels[i : i + n] for n in (2, 3) for i in range(len(levels) - n + 1)]
        spans += [()] if self.shared else []
        for span, shifts in itertools.product(spans, (1, 2)):
            grids = tuple(sorted({*span, *self.shared}))
            if len(grids) > 1:
                yield self._planned(grids, shifts, known)

    def _chains(self, known: ContactAreas) -> Iterator[Ladder]:
        """List three grids each for a mean: most surfaces are solved on the coarsest, few on the finest."""
        for last in range(2, len(_LEVELS)):
            between = np.sqrt(_LEVELS[0] * _LEVELS[last])
            middle = min(_LEVELS[1:last], key=lambda level: abs(level - between))
            grids = tuple(dict.fromkeys(self._grid(level) for level in (_LEVELS[0], middle, _LEVELS[last])))
            yield self._planned(grids, 1, known)

    def _planned(self, grids: Grids, shifts: int, known: ContactAreas) -> Ladder:
        spacing, solves = self.problem.spacing, shifts**2
        plan = [PlannedGrid(spacing=spacing(g), cells=math.prod(g), solves=solves) for g in grids]
        area = known.pixel if known.subcell is None else known.subcell
        claim = 2 * predicted_uncertainty(known, plan) / max(area, known.cell_share)
        for grid in grids:
            if grid not in self.costs:
                (solve,) = self._jobs((grid,), 1)
                # Not by what solves took: taken up again, the search chooses the same.
                self.costs[grid] = solve.predict(pair_seconds=self.bench.pair)
        return Ladder(
            grids=grids,
            shifts=shifts,
            error=self.doubt * claim + self.left,
            seconds=solves * sum(self.costs[grid].seconds for grid in grids),
            peak_bytes=max(self.costs[grid].peak_bytes for grid in grids),
        )

    def _cheapest(self, ladders: Iterable[Ladder], tried: set[Grids], *, share: float) -> Ladder:
        left = [ladder for ladder in ladders if ladder.grids not in tried]
        affordable = [ladder for ladder in left if self.bench.affordable(ladder.seconds, ladder.peak_bytes)]
        enough = [ladder for ladder in left if ladder.error <= share * self.target]
        good = sorted(enough, key=lambda ladder: ladder.seconds)
        if chosen := next((ladder for ladder in good if ladder in affordable), None):
            return chosen
        reachable = [ladder.error for ladder in affordable if np.isfinite(ladder.error)]
        best = f"about {percent(min(reachable) / share)}" if reachable else "nothing"
        needs = f"needs more than {_LEVELS[-1]} points per shortest wave"
        if good:
            memory, seconds = memory_words(good[0].peak_bytes), good[0].seconds
            needs = f"needs about {memory} and {seconds:.2g} s ({grid_words(good[0].grids)})"
        remedy = "ask for less, allow more, or use a larger machine"
        why = f"{needs}, and {self.bench.means()}; {best} is within reach"
        raise UsageError(f"{self.bench.wanted}: {why}; {remedy}")

    def _jobs(self, grids: Sequence[Grid], shifts: int) -> tuple[Press, ...]:
        return self._solves(bem=BemOptions(grids=tuple(grids), shifts=shifts, tolerance=self.tolerance))

    def _solves(self, **methods: Any) -> tuple[Press, ...]:
        """List the solves of the scene's own surface by other methods than it lists."""
        asked = {"methods": Methods(**methods), "ensemble": None}
        return solves_of(self.scene.model_copy(update=asked), self.problem)

    def _solved(self, solves: Sequence[Press]) -> list[ContactAreas]:
        for solve, result in self.bench.solve(s for s in solves if s not in self.areas).items():
            self.peak_bytes = max(self.peak_bytes, result.cost.peak_bytes)
            self.areas[solve] = areas_of_solve(solve, result)
        return [self.areas[solve] for solve in solves]
