"""What is scored: a solver with its settings, and what it answers, recomputed where that can be."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from fem_contact.contact import ContactResult
from fem_contact.errors import NotConverged
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface
from validation.cases import NotJudged
from validation.effects.base import ContactModel, Effect
from validation.solvers import Solver
from validation.solvers.base import Claim, Job, Size
from validation.solvers.external import judged

__all__ = ["SOFT", "Pressed", "Subject", "rough"]

#: E* = 1.
SOFT = Solid(young=1.0, poisson=0.0)


#: A call is given as much, however little of the time is left [s].
_LEAST_SECONDS = 1.0

#: Solves on the finest grid of a ladder, about.
_FINEST = 12


@dataclass(frozen=True, kw_only=True, eq=False)
class Pressed:
    """What a solver said of one problem, what that amounts to, and the cost that its method predicted.

    The result is recomputed from the pressure alone by the response of the solid, or of the mesh.
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
        That all its solves together may take: processor time, or time on the clock where nothing came of one.
    own : bool
        Whether it is one of ours, of which more is asked: units change no bit, waves are exact.
    """

    name: str
    solver: Solver
    settings: Mapping[str, Any]
    tolerance: float = 1e-6
    quick: bool = True
    seconds: float = 300.0
    own: bool = False
    _lost: list[float] = field(default_factory=list, init=False, repr=False)
    _asked: dict[object, Pressed | NotConverged] = field(default_factory=dict, init=False, repr=False)

    @property
    def points(self) -> int:
        """Points along a side of the coarsest grid of a ladder."""
        return self.solver.score_points

    @cached_property
    def ladder(self) -> tuple[int, int, int]:
        """Three grids: each twice as fine as the one before, or less where that takes too long."""
        n = self.points
        side = self._predicted((4 * n, 4 * n), (1.0, 1.0), self.told(None, (4 * n, 4 * n)))
        return (n, 2 * n, 4 * n) if _FINEST * side <= self.seconds else (n, 3 * n // 2, 2 * n)

    @property
    def doubles(self) -> bool:
        """Whether the grids of the ladder are far enough apart to observe an order."""
        return self.ladder[-1] == 4 * self.ladder[0]

    def needs(self, *, control: str = "", effect: type[Effect] | None = None) -> None:
        """Leave a row out that asks for what the solver cannot be told or given.

        Raises
        ------
        NotJudged
        """
        if effect is not None and not self.solver.handles(effect):
            raise NotJudged(f"{self.solver.label} cannot be given the effect {effect.kind_name()!r}")
        if control and control not in self._controlled:
            raise NotJudged(f"{self.solver.label} cannot be told {control!r}")

    @cached_property
    def _controlled(self) -> frozenset[str]:
        """What it may be told beside the load."""
        return self.solver.controlled(self.settings)

    @property
    def asked_seconds(self) -> list[float]:
        """Seconds of each of its solves so far; 0 where they are not known."""
        solved = [found.claim.cpu_seconds for found in self._asked.values() if isinstance(found, Pressed)]
        return [*np.nan_to_num(solved).tolist(), *self._lost]

    @property
    def left(self) -> float:
        """Seconds that are left of its time."""
        return max(self.seconds - sum(self.asked_seconds), 0.0)

    @property
    def pressure_error(self) -> float:
        """Relative error of pressures that the tolerance allows: the tolerance is one of an energy."""
        return float(np.sqrt(10 * self.tolerance))

    def press(
        self,
        field: HeightField,
        load: float | None,
        *,
        model: ContactModel | None = None,
        more: Mapping[str, float] | None = None,
        again: bool = False,
    ) -> Pressed:
        """Press a surface [m] with a mean pressure [Pa], once; what was asked before is known.

        Parameters
        ----------
        field : HeightField
        load : float or None
            None where `more` has an offset.
        model : ContactModel, optional
            The solid and its effects; that of E* = 1 if not given.
        more : mapping, optional
            Of what the solver is told: its controls, its tolerance.
        again : bool
            Whether it is asked anew.

        Raises
        ------
        NotConverged
            Where nothing comes of it.
        NotJudged
            Where the time that is left does not allow it.
        """
        model = model or ContactModel(solid=SOFT)
        extra = tuple(sorted((more or {}).items()))
        where = (field.heights.tobytes(), field.shape, field.lengths)
        key = (where, load, model.solid, model.response, model.pressure_bound, extra, again)
        if key not in self._asked:
            began = time.monotonic()
            try:
                self._asked[key] = self._pressed(field, load, model=model, told=self.told(more, field.shape))
            except NotConverged as failure:
                self._lost.append(time.monotonic() - began)
                self._asked[key] = failure
        found = self._asked[key]
        if isinstance(found, NotConverged):
            raise found
        return found

    def _pressed(
        self, field: HeightField, load: float | None, *, model: ContactModel, told: Mapping[str, Any]
    ) -> Pressed:
        seconds, left = self._predicted(field.shape, field.lengths, told), self.left
        if seconds > left or not left:
            nx, ny = field.shape
            raise NotJudged(
                f"not tried: {nx} x {ny} points would take some {seconds:.2g} s, and of {self.seconds:g} s "
                f"there are {left:.2g} left (--seconds)"
            )
        settings = {name: value for name, value in told.items() if name != "offset"}
        asked = {"offset": told["offset"]} if load is None else {"mean_pressure": load}
        job = Job(field=field, load=asked, model=model, settings=settings, threads=1)
        claim = self.solver.claim(job)
        if claim.pressure.shape != field.shape:
            raise NotConverged(
                f"pressures of shape {claim.pressure.shape}: must have that of the heights, {field.shape}"
            )
        result = judged(
            claim,
            job,
            method=self.solver.label,
            response=self.solver.felt(job),
            element=self.solver.score_element,
        )
        return Pressed(claim=claim, result=result, pairs=self._pairs(field.shape, field.lengths, told))

    def told(self, more: Mapping[str, float] | None, shape: tuple[int, int]) -> dict[str, Any]:
        """Return what it is told on a grid beyond surface, solid and load; a process of its own, its time."""
        refined = self.solver.score_settings(max(shape))
        said = {**refined, **self.settings, "tolerance": self.tolerance, **(more or {})}
        if self.solver.foreign and math.isfinite(self.seconds):
            said["seconds"] = min(float(said.get("seconds", math.inf)), max(self.left, _LEAST_SECONDS))
        return said

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
        told, began = self.told(None, (16, 16)), time.monotonic()
        if "seconds" in told:
            # What does not return here is asked once more, so that rows can say so.
            told["seconds"] = min(told["seconds"], self.seconds / 4)
        self.solver.rehearse((), told)
        if (passed := time.monotonic() - began) >= told.get("seconds", math.inf):
            self._lost.append(passed)
        with contextlib.suppress(Exception):  # what it fails at, a row says
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
