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
from validation.arrays import Array, Grid
from validation.cases import NotJudged
from validation.cases._closed_forms import periodic
from validation.effects.base import ContactModel, Effect
from validation.solvers import Solver
from validation.solvers.base import Claim, Job, Size
from validation.solvers.external import verified

#: E* = 1.
SOFT = Solid(young=1.0, poisson=0.0)

#: A call is given as much, however little of the time is left [s].
_LEAST_SECONDS = 1.0

#: Solves on the finest grid of a ladder, about.
_FINEST = 12


@dataclass(frozen=True, kw_only=True, eq=False)
class Pressed:
    """What a solver said of one problem, and what that amounts to.

    The result is recomputed from the pressure alone by the response of the solid, or of the mesh.
    """

    claim: Claim
    result: ContactResult

    @property
    def pressure(self) -> Array:
        """The pressures that it claims [Pa]."""
        return self.claim.pressure


@dataclass(frozen=True, kw_only=True, eq=False)
class Subject:
    """A solver to be scored."""

    name: str  # By which it was asked for
    solver: Solver
    settings: Mapping[str, Any]  # What it is told beyond surface, solid and load
    tolerance: float = 1e-6  # Of the residuals it is asked for
    quick: bool = True  # Whether small grids do
    #: All its solves together may take: processor time, or time on the clock where nothing came of one.
    seconds: float = 300.0
    #: Whether it is one of ours, of which more is asked: units change no bit, waves are exact.
    built_in: bool = False
    #: Pairs that its cost predicts and seconds of each solve, 0 where they are not known.
    _costs: list[tuple[float, float]] = field(default_factory=list, init=False, repr=False)
    _answers: dict[object, Pressed | NotConverged] = field(default_factory=dict, init=False, repr=False)

    @property
    def points(self) -> int:
        """Points along a side of the coarsest grid of a ladder."""
        return self.solver.score_points

    @property
    def most_points(self) -> int:
        """Points along a side of the finest grid that it is asked for."""
        return (4 if self.quick else 8) * self.points

    @cached_property
    def rough(self) -> HeightField:
        """A rough surface on the middle grid of a full ladder."""
        return rough(2 * self.points)

    @cached_property
    def ladder(self) -> tuple[int, int, int]:
        """Three grids: each twice as fine as the one before, or less where that takes too long."""
        n = self.points
        size = Size(grid=(4 * n, 4 * n), lengths=(1.0, 1.0), settings=self._options((4 * n, 4 * n)))
        return (
            (n, 2 * n, 4 * n) if _FINEST * self._predicted(size) <= self.seconds else (n, 3 * n // 2, 2 * n)
        )

    @property
    def doubles(self) -> bool:
        """Whether the grids of the ladder are far enough apart to observe an order."""
        return self.ladder[-1] == 4 * self.ladder[0]

    def needs(self, *, control: str = "", effect: type[Effect] | None = None) -> None:
        """Leave a row out, by a NotJudged, that asks for what the solver cannot be told or given."""
        if effect is not None and not self.solver.handles(effect):
            raise NotJudged(f"{self.solver.label} cannot be given the effect {effect.kind_name()!r}")
        if control and control not in self._controlled:
            raise NotJudged(f"{self.solver.label} cannot be told {control!r}")

    @cached_property
    def _controlled(self) -> frozenset[str]:
        """What it may be told beside the load: a foreign one is asked in a process of its own."""
        return self.solver.controlled(self.settings)

    @property
    def left(self) -> float:
        """Seconds that are left of its time."""
        return max(self.seconds - sum(seconds for _, seconds in self._costs), 0.0)

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
        """Press a surface [m] with a mean pressure [Pa], once; only `again` is it asked anew.

        The load is None where `more`, the controls and the tolerance that the solver is told, has an offset;
        the solid without a `model` is that of E* = 1. A NotConverged where nothing comes of it, a NotJudged
        where the time that is left does not allow it.
        """
        model = model or ContactModel(solid=SOFT)
        extra = tuple(sorted((more or {}).items()))
        where = (field.heights.tobytes(), field.shape, field.lengths)
        key = (where, load, model.solid, model.response, model.pressure_bound, extra, again)
        if key not in self._answers:
            began = time.monotonic()
            try:
                self._answers[key] = self._pressed(field, load, model, self._options(field.shape, more))
            except NotConverged as failure:
                self._costs.append((0.0, time.monotonic() - began))
                self._answers[key] = failure
        answer = self._answers[key]
        if isinstance(answer, NotConverged):
            raise answer
        return answer

    def _pressed(
        self, field: HeightField, load: float | None, model: ContactModel, settings: dict[str, Any]
    ) -> Pressed:
        size = Size(grid=field.shape, lengths=field.lengths, settings=settings)
        seconds, left = self._predicted(size), self.left
        if seconds > left or not left:
            nx, ny = field.shape
            raise NotJudged(
                f"not tried: {nx} x {ny} points would take some {seconds:.2g} s, and of {self.seconds:g} s "
                f"there are {left:.2g} left (--seconds)"
            )
        control = {"mean_pressure": load} if load is not None else {"offset": settings.pop("offset")}
        job = Job(field=field, load=control, model=model, settings=settings, threads=1)
        claim = self.solver.claim(job)
        if claim.pressure.shape != field.shape:
            raise NotConverged(
                f"pressures of shape {claim.pressure.shape}: must have that of the heights, {field.shape}"
            )
        result = verified(
            claim,
            job,
            method=self.solver.label,
            response=self.solver.felt(job),
            element=self.solver.score_element,
        )
        self._costs.append((self.solver.cost(size).pairs, np.nan_to_num(claim.cost.cpu_seconds)))
        return Pressed(claim=claim, result=result)

    def _options(self, shape: Grid, more: Mapping[str, float] | None = None) -> dict[str, Any]:
        """Return what it is told on a grid beyond surface, solid and load; a process of its own, its time."""
        refined = self.solver.score_settings(max(shape))
        options = {**refined, **self.settings, "tolerance": self.tolerance, **(more or {})}
        if self.solver.foreign and math.isfinite(self.seconds):
            options["seconds"] = min(float(options.get("seconds", math.inf)), max(self.left, _LEAST_SECONDS))
        return options

    def _predicted(self, size: Size) -> float:
        """Seconds of a solve by what its largest took so far; 0 before the first."""
        pairs, seconds = max(self._costs, default=(0.0, 0.0))
        return seconds / pairs * self.solver.cost(size).pairs if pairs else 0.0

    def warm_up(self) -> None:
        """Let it import and compile what it needs, and see what a solve takes."""
        options, began = self._options((16, 16)), time.monotonic()
        if "seconds" in options:
            # What does not return here is asked once more, so that rows can say so.
            options["seconds"] = min(options["seconds"], self.seconds / 4)
        self.solver.warm_up((), options)
        if (passed := time.monotonic() - began) >= options.get("seconds", math.inf):
            self._costs.append((0.0, passed))
        with contextlib.suppress(Exception):  # what it fails at, a row says
            self.press(self.rough, 0.05)


def rough(points: int, *, bandwidth: int = 4, waves: int = 2) -> HeightField:
    """Return a surface of unit gradient and period, H = 0.8, with `points` along a side.

    `bandwidth` is lambda_long / lambda_short, `waves` L / lambda_long.
    """
    longest, shortest = 2 * np.pi * waves, 2 * np.pi * waves * bandwidth
    surface = random_surface(
        lambda q: np.where(q >= 0.999 * longest, np.maximum(q, longest) ** -3.6, 0.0),
        q_short=shortest,
        lengths=(1.0, 1.0),
        shape=(4 * waves * bandwidth,) * 2,
        seed=271,
    )
    return periodic(surface.heights / surface.rms_gradient).resampled((points, points))
