"""Histories of adhesive contact: approach and retraction, and the jumps between them.

Each state starts from the one before. Approach and retraction differ by the energy lost where a state ceases
to be a minimum and the surfaces snap together or apart; those jumps are located by bisection, not stepped
over.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, Unpack

import numpy as np

from fem_contact._checks import finite, non_negative, numbers_of, only, within
from fem_contact._types import Array
from fem_contact.adhesion.descent import Minimum, Point
from fem_contact.adhesion.laws import GapLaw
from fem_contact.adhesion.state import AdhesionProblem, AdhesiveContact, settings_of
from fem_contact.contact import Status
from fem_contact.errors import InvalidInput, NotConverged
from fem_contact.response import Response
from fem_contact.settings import Limits
from fem_contact.surface import HeightField


@dataclass(frozen=True, kw_only=True)
class PathPoint:
    """Numbers of one state of a path, all per nominal area.

    Attributes
    ----------
    offset : float
        Distance of the mean planes before deformation [m].
    mean_pressure : float
        p0 [Pa], negative under tension.
    mean_gap : float
        [m].
    contact : float
        Share of the points on the wall.
    within_reach : float
        Share of the points with a gap below the range of the law, those on the wall included.
    energy : float
        Elastic energy and energy of the gap law [J/m^2].
    """

    offset: float
    mean_pressure: float
    mean_gap: float
    contact: float
    within_reach: float
    energy: float


@dataclass(frozen=True, kw_only=True)
class Jump:
    """A place where a minimum ceases to exist and the surfaces snap to another one.

    Attributes
    ----------
    kind : {"snap-in", "pull-off"}
        Whether the points within reach become more or fewer.
    before, after : PathPoint
        The last state of the old minimum and the first of the new one; what is controlled (offset or mean
        pressure) differs between them by less than the resolution asked for. `after` is None where the
        surfaces part for good under a mean tension.
    dissipated : float
        Energy lost in the jump per nominal area [J/m^2]; infinite where a constant tension goes on pulling
        parted surfaces.
    """

    kind: Literal["snap-in", "pull-off"]
    before: PathPoint
    after: PathPoint | None
    dissipated: float


@dataclass(frozen=True, kw_only=True)
class AdhesionPath:
    """States along a path and the jumps between them.

    Attributes
    ----------
    points : tuple of PathPoint
        The states asked for, and those found around jumps, in order.
    last : AdhesiveContact
        The last state of equilibrium.
    """

    points: tuple[PathPoint, ...]
    jumps: tuple[Jump, ...]
    last: AdhesiveContact

    @property
    def dissipated(self) -> float:
        """Energy lost in jumps per nominal area [J/m^2]."""
        return sum(jump.dissipated for jump in self.jumps)

    @property
    def greatest_tension(self) -> float:
        """Largest mean tension along the path [Pa]: the pull-off stress of a retraction."""
        return -min(point.mean_pressure for point in self.points)


def follow(
    surface: HeightField,
    response: Response,
    *,
    law: GapLaw,
    offsets: Iterable[float] | None = None,
    mean_pressures: Iterable[float] | None = None,
    start: Array | None = None,
    resolution: float = 1e-3,
    least_jump: float = 0.02,
    **limits: Unpack[Limits],
) -> AdhesionPath:
    """Follow a path of offsets or mean pressures, each state from the one before, and locate its jumps.

    Parameters
    ----------
    offsets, mean_pressures : iterable of float
        Offsets [m] or mean pressures [Pa] in the order they are passed, down and up; exactly one of them.
    resolution : float
        Jumps are located to this fraction of the range (offsets) or of the largest pressure of the path.
    least_jump : float
        Least energy lost that counts as a jump, over the work of adhesion of the area within reach.
    surface, response, law, start, tolerance, max_iterations, time_limit, threads
        As in `fem_contact.adhesion.solve`; `start` is for the first state, the time for each.

    Returns
    -------
    AdhesionPath
        Under mean pressures the path ends where the surfaces are pulled apart for good.

    Raises
    ------
    InvalidInput
        As `fem_contact.adhesion.solve`.
    NotConverged
        If a state of the path does not converge.

    Notes
    -----
    Along an unbroken branch the energy changes by the work of the load. What is missing after a step was lost
    in a jump, or is the error of the trapezoidal rule for that work; halving the step tells them apart.
    """
    name, held = only(offsets=offsets, mean_pressures=mean_pressures)
    within("resolution", resolution, "[1e-12, 1]")
    non_negative("least_jump", least_jump)
    problem = AdhesionProblem(surface, response, law=law, settings=settings_of(limits))
    values = [finite(name, value) for value in numbers_of(name, held)]
    if not values:
        raise InvalidInput("the path is empty: give at least one offset or mean pressure")
    points = [Point(**{name.removesuffix("s"): value}) for value in values]
    width = resolution * (law.reach if mean_pressures is None else max(map(abs, values)))
    return _Walk(problem, width=width, least=least_jump).run(points, start)


class _Walk:
    """Steps along a path; a step that loses energy is halved until the loss is pinned down."""

    def __init__(self, problem: AdhesionProblem, *, width: float, least: float) -> None:
        self.problem, self.width, self.least = problem, width, least
        self.points: list[PathPoint] = []
        self.jumps: list[Jump] = []

    def run(self, points: list[Point], start: Array | None) -> AdhesionPath:
        state = self._solved(points[0], self.problem.first_gap(points[0], start))
        if state.separated:
            raise NotConverged(f"{state.status.value} (at the start of the path, {points[0]})")
        self._record(state)
        for point in points[1:]:
            self.problem.check(point)
        for point in points[1:]:
            if state.separated:
                break
            state = self._advance(state, point)
        return AdhesionPath(
            points=tuple(self.points), jumps=tuple(self.jumps), last=self.problem.packed(self.last)
        )

    def _record(self, state: Minimum) -> None:
        if not state.separated:
            self.points.append(self._numbers(state))
            self.last = state

    def _numbers(self, minimum: Minimum) -> PathPoint:
        return PathPoint(
            offset=minimum.offset,
            mean_pressure=minimum.mean_pressure,
            mean_gap=float(np.mean(minimum.gap)),
            contact=float(np.mean(minimum.gap == 0)),
            within_reach=float(np.mean(minimum.gap < self.problem.law.reach)),
            energy=minimum.energy,
        )

    def _advance(self, state: Minimum, point: Point) -> Minimum:
        """Go to a point, recording states and jumps on the way."""
        after = self._solved(point, self._predicted(state, point))
        if self._lost(state, after) <= 0:
            self._record(after)
            return after
        here, there = point.held_of(state), point.held
        if abs(there - here) <= self.width or (here + there) / 2 in (here, there):
            self._jump(state, after)
            self._record(after)
            return after
        middle = self._advance(state, point.at((here + there) / 2))
        if middle.separated:
            return middle
        return self._advance(middle, point)

    def _lost(self, before: Minimum, after: Minimum) -> float:
        """Energy lost beyond the least that counts; positive for a jump, or a step too long to tell."""
        # Before first contact nothing is within reach: the least area is that of a few points.
        shares = (self._numbers(state).within_reach for state in (before, after))
        area = max(*shares, 4 / before.gap.size)
        return self._dissipated(before, after) - self.least * self.problem.law.work * area

    def _dissipated(self, before: Minimum, after: Minimum) -> float:
        """Work of the load less the energy stored [J/m^2]; without end on surfaces that part for good."""
        if after.separated:
            return np.inf
        mean = 0.5 * (before.mean_pressure + after.mean_pressure)
        return -mean * (after.offset - before.offset) - (after.energy - before.energy)

    def _jump(self, before: Minimum, after: Minimum) -> None:
        one, two = self._numbers(before), None if after.separated else self._numbers(after)
        closer = two is not None and two.within_reach > one.within_reach
        kind: Literal["snap-in", "pull-off"] = "snap-in" if closer else "pull-off"
        self.jumps.append(Jump(kind=kind, before=one, after=two, dissipated=self._dissipated(before, after)))

    def _predicted(self, state: Minimum, point: Point) -> Array:
        """Gap to start from: points on the wall stay there, the others move with the body."""
        if point.offset is None:
            return state.gap
        step = point.offset - state.offset
        law = self.problem.law
        if step < 0:
            return state.gap + step
        held = law.traction(state.gap) / law.strength
        return np.where(state.gap > 0, state.gap + (1 - held) * step, 0.0)

    def _solved(self, point: Point, start: Array) -> Minimum:
        state = self.problem.at(point, start)
        if not state.separated and state.status is not Status.CONVERGED:
            raise NotConverged(f"{state.status.value} (at {point}, imbalance {state.imbalance:.3g})")
        return state
