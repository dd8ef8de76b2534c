"""The search for the grids and surfaces that an accuracy takes: what each claims, and what it costs."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.fft
import scipy.special

from fem_contact.area import ContactAreas, contact_areas
from fem_contact.extrapolation import PlannedGrid, located_limit, predicted_uncertainty
from validation.comparison.findings import percent
from validation.errors import RunFailed, UsageError
from validation.methods.bem import BemOptions
from validation.scenes.realised import Realised
from validation.scenes.scene import Methods, Scene
from validation.solves.bench import Bench
from validation.solves.cost import available_memory, memory_words, transform_seconds
from validation.solves.press import Press, solves_of
from validation.solves.running import Solves

if TYPE_CHECKING:
    pass

__all__ = ["Ladder", "Mean", "Search", "Single", "grid_words"]

Grid = tuple[int, int]

#: Grids that are considered, as points per shortest wave.
_LEVELS = (3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256)

#: The area of a solve is off by less than its tolerance at p* of .2 and above; below, by some 4 % of a point
#: (docs/bem.md).
_SOLVER_SHARE = 0.01
_TOLERANCES = (1e-8, 1e-4)

#: Surfaces from which their scatter is first estimated, and the least that a mean is taken over.
_PILOT_SURFACES, _LEAST_SURFACES = 8, 4
_MOST_SURFACES = 4096

#: A claim is predicted from a coarser grid than it will be made from: some of the target is left for that.
_SPARE = 0.9

#: Scatter between surfaces, relative, until it has been measured.
_USUAL_SCATTER = 0.1


def grid_words(grids: Sequence[Grid]) -> str:
    """Name grids in words."""
    return ", ".join(f"{nx} x {ny}" for nx, ny in grids)


@dataclass(frozen=True, kw_only=True)
class Ladder:
    """Grids that are solved together, coarse to fine, with what is claimed from them."""

    grids: tuple[Grid, ...]
    shifts: int
    error: float
    seconds: float
    peak_bytes: int


@dataclass(frozen=True, kw_only=True)
class Single:
    """The scene's own surface, solved."""

    ladder: Ladder
    area: float
    error: float
    finest: ContactAreas


@dataclass(frozen=True, kw_only=True)
class Mean:
    """The ensemble, solved."""

    ladder: Ladder
    surfaces: int
    area: float
    error: float
    grid: float
    statistical: float


@dataclass(kw_only=True)
class Search:
    """A search for the cheapest grids; what it has learnt of the surface and of the machine."""

    scene: Scene
    realised: Realised
    target: float
    bench: Bench
    time_limit: float | None
    pair: float = field(default_factory=transform_seconds)
    clock: float = field(default_factory=time.perf_counter)
    solves: int = 0
    #: Jobs wanted so far that were found finished when they were first wanted.
    found: set[Press] = field(default_factory=set)
    done: set[Press] = field(default_factory=set)
    areas: dict[Press, ContactAreas] = field(default_factory=dict)
    solving: float = 0.0
    predicted: float = 0.0
    peak_bytes: int = 0
    doubt: float = 1.0

    @property
    def reused(self) -> int:
        """Solves that were found finished."""
        return len(self.found)

    @property
    def tolerance(self) -> float:
        """Tolerance whose error is a hundredth of the one asked for."""
        return float(np.clip(_SOLVER_SHARE * self.target, *_TOLERANCES))

    @property
    def memory(self) -> int:
        """Bytes that a solve may take."""
        return available_memory() if self.bench.execution.memory is None else self.bench.execution.memory

    def own_surface(self) -> Single:
        """Solve the scene's own surface to the accuracy."""
        pilot = Ladder(grids=(self._grid(4),), shifts=1, error=np.inf, seconds=0.0, peak_bytes=0)
        ((known,),) = self._solved(pilot)
        tried: set[tuple[Grid, ...]] = set()
        while True:
            ladder = self._cheapest(known, tried)
            tried.add(ladder.grids)
            (areas,) = self._solved(ladder)
            limit = located_limit(areas)
            error = 2 * limit.uncertainty / limit.value + self.tolerance if limit.determinable else np.inf
            known = min(areas, key=lambda area: area.spacing)
            # Where grids disagree by more than the law allows, they will again.
            self.doubt = max(self.doubt, _SPARE * error / ladder.error) if np.isfinite(error) else self.doubt
            if error <= self.target:
                return Single(ladder=ladder, area=limit.value, error=error, finest=known)

    def ensemble(self, single: Single) -> Mean:
        """Solve as many surfaces on the grids that together meet the accuracy of the mean at least cost."""
        ladder, surfaces = self._balanced(single.finest, _USUAL_SCATTER, None)
        while True:
            solved = self._solved(ladder, realisations=range(surfaces))
            limits = [located_limit(areas) for areas in solved]
            for k, limit in enumerate(limits):
                if not limit.determinable:
                    raise RunFailed(
                        f"--accuracy = {100 * self.target:g} %: realisation {k} has no limit: {limit.doubt}; "
                        "all solves are stored"
                    )
            area = np.array([limit.value for limit in limits])
            # The grids are off to the same side on all surfaces of a spectrum: this error does not average.
            grid = 2 * float(np.mean([limit.uncertainty for limit in limits]) / area.mean()) + self.tolerance
            scatter = float(area.std(ddof=1) / area.mean())
            statistical = _student(surfaces) * scatter / float(np.sqrt(surfaces))
            error = float(np.hypot(grid, statistical))
            mean = Mean(
                ladder=ladder,
                surfaces=surfaces,
                area=float(area.mean()),
                error=error,
                grid=grid,
                statistical=statistical,
            )
            if error <= self.target:
                return mean
            ladder, surfaces = self._balanced(single.finest, scatter, mean)

    def _balanced(self, known: ContactAreas, scatter: float, now: Mean | None) -> tuple[Ladder, int]:
        """Choose grids and surfaces so that grid and scatter together meet the target at least cost."""
        choices, least = [], np.inf
        for ladder in self._ladders(known, shifts=(1,)):
            done = now.surfaces if now is not None and ladder.grids == now.ladder.grids else 0
            # What was measured of a ladder counts for more than what was predicted of it.
            grid = now.grid if now is not None and done else ladder.error
            if grid >= 0.95 * self.target:
                continue
            surfaces = max(_surfaces_for(np.sqrt(self.target**2 - grid**2), scatter), done + 1)
            cost = (surfaces - done) * ladder.seconds
            if now is None:
                # The scatter is a guess that ranks the grids; a few surfaces then say how large it is.
                surfaces = min(surfaces, _PILOT_SURFACES)
            seconds = (surfaces - done) * ladder.seconds
            least = min(least, seconds)
            if surfaces <= _MOST_SURFACES and self._affordable(seconds, ladder.peak_bytes):
                choices.append((cost, surfaces, ladder))
        if not choices:
            found = (
                ""
                if now is None
                else f"the mean over {now.surfaces} surfaces is known to {percent(now.error)}; "
            )
            raise RunFailed(
                f"--accuracy = {100 * self.target:g} %: {found}the mean over surfaces needs "
                f"about {least:.2g} s more, or more than {_MOST_SURFACES} surfaces, and {self._means()}; "
                "all solves are stored"
            )
        _, surfaces, ladder = min(choices, key=lambda choice: choice[0])
        return ladder, surfaces

    def _grid(self, per_wave: float) -> Grid:
        """Return an even grid of fast transforms and nearly square cells of at least that resolution."""
        wave = self.realised.shortest
        halves = (int(np.ceil(per_wave * x / wave / 2 - 1e-9)) for x in self.scene.surface.length)
        nx, ny = (2 * scipy.fft.next_fast_len(n, real=True) for n in halves)
        return nx, ny

    def _ladders(self, known: ContactAreas, *, shifts: Sequence[int] = (1, 2)) -> Iterator[Ladder]:
        """List ladders of two and three grids with what they will claim and cost."""
        levels = tuple(dict.fromkeys(self._grid(level) for level in _LEVELS))
        spans = [levels[i : i + n] for n in (2, 3) for i in range(len(levels) - n + 1)]
        lengths = self.scene.surface.length
        for grids, shift in itertools.product(spans, shifts):
            plan = [
                PlannedGrid(spacing=(lengths[0] / nx, lengths[1] / ny), cells=nx * ny, solves=shift * shift)
                for nx, ny in grids
            ]
            if any(abs(one.spacing[0] / one.spacing[1] - 1) > 0.05 for one in plan):
                continue
            area = known.pixel if known.subcell is None else known.subcell
            claim = 2 * predicted_uncertainty(known, plan) / max(area, known.cell_share)
            costs = [solve.predict(pair_seconds=self.pair) for solve in self._jobs(grids, shift)]
            yield Ladder(
                grids=grids,
                shifts=shift,
                error=self.doubt * claim + self.tolerance,
                seconds=self._slowness * sum(cost.seconds for cost in costs),
                peak_bytes=max(cost.peak_bytes for cost in costs),
            )

    def _cheapest(self, known: ContactAreas, tried: set[tuple[Grid, ...]]) -> Ladder:
        ladders = [ladder for ladder in self._ladders(known) if ladder.grids not in tried]
        good = [ladder for ladder in ladders if ladder.error <= _SPARE * self.target]
        affordable = [ladder for ladder in good if self._affordable(ladder.seconds, ladder.peak_bytes)]
        if affordable:
            return min(affordable, key=lambda ladder: ladder.seconds)
        reachable = [
            one.error
            for one in ladders
            if self._affordable(one.seconds, one.peak_bytes) and np.isfinite(one.error)
        ]
        best = f"about {percent(min(reachable) / _SPARE)}" if reachable else "nothing"
        if good:
            least = min(good, key=lambda ladder: ladder.seconds)
            needs = (
                f"needs about {memory_words(least.peak_bytes)} and {least.seconds:.2g} s "
                f"({grid_words(least.grids)})"
            )
        else:
            needs = f"needs more than {_LEVELS[-1]} points per shortest wave"
        raise UsageError(
            f"--accuracy = {100 * self.target:g} %: {needs}, and {self._means()}; {best} is within reach; "
            "ask for less, allow more, or use a larger machine"
        )

    def _means(self) -> str:
        words = f"{memory_words(self.memory)} are free"
        if self.time_limit is not None:
            words += f" and {max(self.time_limit - self.spent, 0):.3g} s are left"
        return words

    @property
    def spent(self) -> float:
        """Seconds since the search began."""
        return time.perf_counter() - self.clock

    @property
    def _slowness(self) -> float:
        """How much longer than predicted solves of some size took here; a second of them tells."""
        return min(max(self.solving / self.predicted, 0.2), 5.0) if self.solving > 1 else 1.0

    def _affordable(self, seconds: float, peak_bytes: int) -> bool:
        in_time = (
            self.time_limit is None or self.spent + seconds / self.bench.execution.workers <= self.time_limit
        )
        return in_time and peak_bytes <= self.memory

    def _jobs(self, grids: Sequence[Grid], shifts: int) -> tuple[Press, ...]:
        method = BemOptions(grids=tuple(grids), shifts=shifts, tolerance=self.tolerance)
        chosen = self.scene.model_copy(update={"methods": Methods(bem=method), "ensemble": None})
        return solves_of(chosen, self.realised)

    def _solved(self, ladder: Ladder, *, realisations: Sequence[int] = (0,)) -> list[list[ContactAreas]]:
        """Solve a ladder of each surface, coarse grids first, and read the areas."""
        own = self._jobs(ladder.grids, ladder.shifts)
        surfaces = [self.realised.further(k) for k in realisations]
        solves = [[replace(solve, realised=surface) for solve in own] for surface in surfaces]
        for grid in ladder.grids:
            self._solve([solve for one in solves for solve in one if solve.grid == grid])
        return [[self._areas(solve) for solve in one] for one in solves]

    def _areas(self, solve: Press) -> ContactAreas:
        """Read the areas of a stored solve, once."""
        if solve not in self.areas:
            result = Solves(solves=(solve,), store=self.bench.store)[solve]
            self.peak_bytes = max(self.peak_bytes, result.cost.peak_bytes)
            self.areas[solve] = contact_areas(result, subcell=True)
        return self.areas[solve]

    def _solve(self, solves: Sequence[Press]) -> None:
        missing = [solve for solve in solves if not self.bench.store.path(solve).exists()]
        self.found |= set(solves) - set(missing) - self.done
        self.done |= set(missing)
        if not missing:
            return
        predicted = sum(solve.predict(pair_seconds=self.pair).seconds for solve in missing)
        if not self._affordable(self._slowness * predicted, 0):
            raise RunFailed(
                f"--accuracy = {100 * self.target:g} %: solves take longer here than predicted, "
                f"{missing[0].describe()} would not end in time, and {self._means()}; all finished solves "
                "are stored: allow more with --time-limit"
            )
        start = time.perf_counter()
        self.bench.solve(missing)
        self.solves += len(missing)
        self.solving += time.perf_counter() - start
        self.predicted += predicted


def _student(samples: int) -> float:
    return float(scipy.special.stdtrit(samples - 1, 0.975))


def _surfaces_for(error: float, scatter: float) -> int:
    """Return how many surfaces bring half of the 95 % interval of the mean below `error`."""
    surfaces = _LEAST_SURFACES
    while surfaces <= _MOST_SURFACES and _student(surfaces) * scatter / np.sqrt(surfaces) > error:
        surfaces = int(np.ceil(1.05 * surfaces))
    return surfaces
