"""Where the distribution of stress lives: its walls, the window that follows them, the steps in ln V."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from persson._checks import Array, returned, within
from persson.errors import InvalidInput, OutsideTheory

#: Why a hardness must not fall.
FALLING = (
    "yield_stress(V) falls: with Persson 2006, Eq. 34 the density at the wall would be negative; "
    "the theory holds for a hardness that is constant or rises with magnification"
)

Flags = NDArray[np.bool_]

#: A stress limit [Pa] as a function of the stress variance V [Pa^2], for arrays; a constant; or None for no
#: wall.
Wall = float | Callable[[Array], Array] | None

#: Half width of the window in standard deviations: the neglected tail holds 3e-14 of the area.
TAIL = 7.6
#: Steps beyond which a wall counts as too wild to be followed; the error estimate then says so.
_MOST_STEPS = 5000


@dataclass(frozen=True, kw_only=True)
class Problem:
    """Distances of the walls from the nominal pressure [Pa] as functions of V; infinite without a wall."""

    pressure: float
    below: Callable[[Array], Array]
    above: Callable[[Array], Array]
    hardening: bool

    def window(self, t: Array, reference: float) -> tuple[Array, Array, Flags, Flags]:
        """Edges of the window relative to sigma_0 at T = ln(V / reference), and which of them are walls."""
        variance = reference * np.exp(t)
        tail = TAIL * np.sqrt(variance)
        below, above = self.below(variance), self.above(variance)
        return -np.minimum(below, tail), np.minimum(above, tail), below < tail, above < tail


def distance(wall: Wall, pressure: float, sign: float, name: str) -> Callable[[Array], Array]:
    if wall is None:
        return lambda variance: np.full(np.shape(variance), np.inf)
    if callable(wall):
        function = wall

        def moving(variance: Array) -> Array:
            limit = returned(f"{name}(V)", function(variance), np.shape(variance), unit="Pa")
            if np.any(limit < 0):
                raise InvalidInput(
                    f"{name}(V): must give a stress that is not negative for every V of an array"
                )
            return sign * pressure + limit

        return moving
    limit = within(name, wall, "[0, inf]")
    return lambda variance: np.full(np.shape(variance), sign * pressure + limit)


@dataclass(frozen=True, kw_only=True)
class Pieces:
    """Intervals of T = ln(V / reference) between switches of the window; empty if no wall is ever reached."""

    reference: float
    edges: Array
    roots: Array
    start: float


def find_pieces(problem: Problem, outputs: Array, breaks: Array) -> Pieces:
    """Find where the distribution first meets a wall, and where an edge changes to or from a wall."""
    last, nothing = float(outputs[-1]), np.empty(0)
    untouched = Pieces(reference=last or 1.0, edges=nothing, roots=nothing, start=np.inf)
    if last == 0:
        _refuse(problem, 1.0, np.array([-140.0]))
        return untouched
    inside = breaks[(breaks > 0) & (breaks < last)]
    coarse = np.unique(np.concatenate([np.arange(-140.0, 0.0, 0.25), [0.0], np.log(inside / last)]))
    _refuse(problem, last, coarse)
    touched = problem.window(coarse, last)
    first = np.flatnonzero(touched[2] | touched[3])
    if first.size == 0:
        return untouched
    if first[0] == 0:
        raise OutsideTheory(
            "a wall stands at the nominal pressure from the start: no distribution can begin there"
        )
    fine = np.unique(
        np.concatenate([np.arange(coarse[first[0] - 1], 0.0, 0.02), [0.0], np.log(inside / last)])
    )
    switches: list[float] = []
    for side in (2, 3):
        walls = problem.window(fine, last)[side]
        turns = np.flatnonzero(walls[1:] != walls[:-1])
        switches.extend(_turn(problem, last, side, fine[i], fine[i + 1]) for i in turns)
    start = min(switches) if switches else float(fine[0])
    roots = np.log(np.unique(inside) / last)
    edges = np.unique(
        np.concatenate([[start], [s for s in switches if s > start], roots[roots > start], [0.0]])
    )
    # Two marks closer than rounding are one.
    edges = edges[np.append(True, np.diff(edges) > 1e-12)]
    return Pieces(reference=last, edges=edges, roots=roots, start=start)


def _turn(problem: Problem, last: float, side: int, low: float, high: float) -> float:
    """Where an edge changes, to rounding: many places at once, as a wall may take long to be asked."""
    while (places := np.unique(np.linspace(low, high, 65))).size > 2:
        walls = problem.window(places, last)[side]
        k = int(np.argmax(walls != walls[0]))
        if k == 0:
            break
        low, high = float(places[k - 1]), float(places[k])
    return high


def _refuse(problem: Problem, last: float, coarse: Array) -> None:
    """Cases without an admissible solution."""
    variance = last * np.exp(coarse)
    below, above = problem.below(variance), problem.above(variance)
    if below[0] <= 0:
        if problem.pressure < 0:
            raise OutsideTheory(
                f"pressure = {problem.pressure!r} Pa: the tension exceeds the tensile limit; nothing holds"
            )
        raise OutsideTheory(
            "pressure = 0 without a tensile limit: nothing presses the bodies together, the area is 0"
        )
    if above[0] <= 0:
        raise OutsideTheory(f"pressure = {problem.pressure!r} Pa: must stay below the yield stress")
    if problem.hardening and np.any(np.diff(above) < -1e-12 * (np.abs(above[1:]) + abs(problem.pressure))):
        raise OutsideTheory(FALLING)


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Steps in s: T itself, or its square root after a mark, where walls may start like a root."""

    first: Array
    last: Array
    rooted: Flags
    origin: Array

    @property
    def steps(self) -> Array:
        """Step sizes in s."""
        return self.last - self.first

    def time(self, s: Array) -> Array:
        """T of values (n, m) of s, one row per step."""
        return np.where(self.rooted[:, None], self.origin[:, None] + s * s, s)

    @property
    def ends(self) -> Array:
        """T at the end of each step."""
        return self.time(self.last[:, None])[:, 0]


def make_grid(problem: Problem, pieces: Pieces, outputs: Array, largest: float) -> Grid:
    """Place steps between marks and outputs, shorter where a wall runs fast."""
    parts = []
    for index in range(max(pieces.edges.size - 1, 0)):
        low, high = float(pieces.edges[index]), float(pieces.edges[index + 1])
        marks = np.concatenate([[low], outputs[(outputs > low + 1e-13) & (outputs < high - 1e-13)], [high]])
        root = bool(np.any(np.abs(pieces.roots - low) < 1e-13))
        marks = np.sqrt(marks - low) if root else marks
        counts = np.maximum(np.ceil(np.diff(marks) / largest), 1).astype(int)
        sizes = np.repeat(np.diff(marks) / counts, counts)
        number = np.arange(sizes.size) - np.repeat(np.cumsum(counts) - counts, counts)
        first = np.repeat(marks[:-1], counts) + number * sizes
        last = np.append(first[1:], marks[-1])
        parts.append((first, last, np.full(first.size, root), np.full(first.size, low)))
    if not parts:
        empty = np.empty(0)
        return Grid(first=empty, last=empty, rooted=empty.astype(bool), origin=empty)
    firsts, lasts, rooted, origins = (np.concatenate(column) for column in zip(*parts, strict=True))
    grid = Grid(first=firsts, last=lasts, rooted=rooted, origin=origins)
    for _ in range(16):
        fast = _too_long(problem, pieces.reference, grid, largest)
        if not fast.any() or fast.size > _MOST_STEPS:
            break
        grid = _halved(grid, fast)
    return grid


def _too_long(problem: Problem, reference: float, grid: Grid, largest: float) -> Flags:
    """Find steps in which an edge runs far, or bends away from a parabola, on the scale of the window."""
    s = grid.first[:, None] + np.array([0.0, 0.25, 0.5, 0.75, 1.0]) * grid.steps[:, None]
    left, right, _, _ = problem.window(grid.time(s), reference)
    width = (right - left).min(axis=1)
    result = np.zeros(width.shape, dtype=bool)
    for edge in (left, right):
        run = np.ptp(edge, axis=1)
        bend = np.abs(edge[:, 0] - 4 * edge[:, 1] + 6 * edge[:, 2] - 4 * edge[:, 3] + edge[:, 4])
        skew = np.abs(edge[:, 4] - 2 * edge[:, 3] + 2 * edge[:, 1] - edge[:, 0])
        result |= (run > 2 * largest * width) | (np.maximum(bend, skew) > 0.02 * largest * largest * width)
    return result


def _halved(grid: Grid, chosen: Flags) -> Grid:
    repeats = np.where(chosen, 2, 1)
    halved = Grid(**{name: np.repeat(part, repeats) for name, part in vars(grid).items()})
    starts = (np.cumsum(repeats) - repeats)[chosen]
    halved.last[starts] = halved.first[starts + 1] = ((grid.first + grid.last) / 2)[chosen]
    return halved
