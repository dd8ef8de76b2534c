"""What is scored: a solver with its settings, and what it answers, recomputed where that can be."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from fem_contact.contact import ContactResult
from fem_contact.errors import NotConverged
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface
from validation.effects.base import Slots
from validation.methods import Solver
from validation.methods.base import Claim, Job, Size
from validation.methods.foreign import judged

__all__ = ["SOFT", "Inconclusive", "NotTried", "Pressed", "Subject", "Unanswered", "rough"]

#: E* = 1.
SOFT = Solid(young=1.0, poisson=0.0)


#: Solves on the finest grid of a ladder, about.
_FINEST = 12


class Inconclusive(Exception):
    """A row that cannot be read, because another one fails."""


class Unanswered(Exception):
    """A problem that the solver was not asked, or left out."""


class NotTried(Exception):
    """A problem that would take longer than what is left of the time."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Pressed:
    """What a solver said of one problem, and what that amounts to.

    Attributes
    ----------
    claim : Claim
    result : ContactResult
        Recomputed from the pressure alone by the response of the solid, or of the mesh of finite elements.
    pairs : float
        What the method predicted that it costs.
    """

    claim: Claim
    result: ContactResult
    pairs: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Subject:
    """A solver to be scored.

    Attributes
    ----------
    name : str
        By which it was asked for.
    solver : Solver
    settings : mapping
        What it is told beyond surface, solid and load.
    tolerance : float
        Of the residuals it is asked for.
    quick : bool
        Whether small grids do.
    seconds : float
        Processor time that all its solves together may take.
    """

    name: str
    solver: Solver
    settings: Mapping[str, Any]
    tolerance: float = 1e-6
    quick: bool = True
    seconds: float = 300.0
    _asked: dict[object, Pressed | NotConverged] = field(default_factory=dict, init=False, repr=False)

    @property
    def points(self) -> int:
        """Points along a side of the coarsest grid of a ladder."""
        return self.solver.score_points

    @cached_property
    def ladder(self) -> tuple[int, int, int]:
        """Three grids: each twice as fine as the one before, or less where that takes too long."""
        n = self.points
        side = self._predicted((4 * n, 4 * n), (1.0, 1.0), self._told(None, (4 * n, 4 * n)))
        return (n, 2 * n, 4 * n) if _FINEST * side <= self.seconds else (n, 3 * n // 2, 2 * n)

    @property
    def doubles(self) -> bool:
        """Whether the grids of the ladder are far enough apart to observe an order."""
        return self.ladder[-1] == 4 * self.ladder[0]

    @cached_property
    def controlled(self) -> frozenset[str]:
        """What it may be told beside the load."""
        return self.solver.controlled(self.settings)

    @property
    def asked_seconds(self) -> list[float]:
        """Processor time of each of its solves so far; 0 where it is not known."""
        solved = [found.claim.cpu_seconds for found in self._asked.values() if isinstance(found, Pressed)]
        return [float(seconds) for seconds in np.nan_to_num(solved)]

    @property
    def pressure_error(self) -> float:
        """Relative error of pressures that the tolerance allows: the tolerance is one of an energy."""
        return float(np.sqrt(10 * self.tolerance))

    def press(
        self,
        field: HeightField,
        load: float | None,
        *,
        slots: Slots | None = None,
        more: Mapping[str, float] | None = None,
    ) -> Pressed:
        """Press a surface [m] with a mean pressure [Pa], once; what was asked before is known.

        Parameters
        ----------
        field : HeightField
        load : float or None
            None where `more` has an offset.
        slots : Slots, optional
            The solid and its effects; that of E* = 1 if not given.
        more : mapping, optional
            Of the solver's controls.

        Raises
        ------
        NotConverged
            Where nothing comes of it.
        NotTried
            Where the time that is left does not allow it.
        """
        slots = slots or Slots(solid=SOFT)
        told = tuple(sorted((more or {}).items()))
        where = (field.heights.tobytes(), field.shape, field.lengths)
        key = (where, load, slots.solid, slots.response, slots.pressure_bound, told)
        if key not in self._asked:
            try:
                self._asked[key] = self._pressed(field, load, slots=slots, told=self._told(more, field.shape))
            except NotConverged as failure:
                self._asked[key] = failure
        found = self._asked[key]
        if isinstance(found, NotConverged):
            raise found
        return found

    def _pressed(
        self, field: HeightField, load: float | None, *, slots: Slots, told: Mapping[str, Any]
    ) -> Pressed:
        seconds, left = (
            self._predicted(field.shape, field.lengths, told),
            self.seconds - sum(self.asked_seconds),
        )
        if seconds > left:
            nx, ny = field.shape
            raise NotTried(
                f"{nx} x {ny} points would take some {seconds:.2g} s, and of {self.seconds:.3g} s there are "
                f"{max(left, 0.0):.2g} left (--seconds)"
            )
        settings = {name: value for name, value in told.items() if name != "offset"}
        asked = {"offset": told["offset"]} if load is None else {"mean_pressure": load}
        job = Job(field=field, load=asked, slots=slots, settings=settings, threads=1)
        claim = self.solver.claim(job)
        result = judged(
            claim,
            job,
            method=self.solver.label,
            response=self.solver.felt(job),
            element=self.solver.score_element,
        )
        return Pressed(claim=claim, result=result, pairs=self._pairs(field.shape, field.lengths, told))

    def _told(self, more: Mapping[str, float] | None, shape: tuple[int, int]) -> dict[str, Any]:
        refined = self.solver.score_settings(max(shape))
        return {**refined, **self.settings, "tolerance": self.tolerance, **(more or {})}

    def _pairs(
        self, shape: tuple[int, int], lengths: tuple[float, float], settings: Mapping[str, Any]
    ) -> float:
        return self.solver.cost(Size(grid=shape, lengths=lengths, settings=settings)).pairs

    def _predicted(
        self, shape: tuple[int, int], lengths: tuple[float, float], settings: Mapping[str, Any]
    ) -> float:
        """Seconds of a solve by what its largest took so far; 0 before the first."""
        solved = [found for found in self._asked.values() if isinstance(found, Pressed)]
        if not solved:
            return 0.0
        largest = max(solved, key=lambda found: found.pairs)
        rate = float(np.nan_to_num(largest.claim.cpu_seconds)) / largest.pairs
        return rate * self._pairs(shape, lengths, settings)

    def warm_up(self) -> None:
        """Let it import and compile what it needs, and see what a solve takes."""
        self.solver.rehearse((), {**self.settings, "tolerance": self.tolerance})
        with contextlib.suppress(NotConverged, Unanswered):
            self.press(rough(2 * self.points), 0.05)


def rough(points: int, *, bandwidth: int = 4, waves: int = 2, seed: int = 271) -> HeightField:
    """Return a surface of unit gradient and period with `waves` longest waves across, H = 0.8.

    Parameters
    ----------
    points : int
        Along a side.
    bandwidth : int
        lambda_long / lambda_short.
    waves : int
        L / lambda_long.
    seed : int
    """
    longest, shortest = 2 * np.pi * waves, 2 * np.pi * waves * bandwidth
    surface = random_surface(
        lambda q: np.where(q >= 0.999 * longest, np.maximum(q, longest) ** -3.6, 0.0),
        q_short=shortest,
        lengths=(1.0, 1.0),
        shape=(4 * waves * bandwidth,) * 2,
        seed=seed,
    )
    unit = HeightField(heights=surface.heights / surface.rms_gradient, lengths=(1.0, 1.0))
    return unit.resampled((points, points))
