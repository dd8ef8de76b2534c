"""The arrays of one contact iteration and the passes over them; no decision is taken here."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from fem_contact._types import AnyArray, Array, Shape
from fem_contact.complementarity.fourier import FourierOperator
from fem_contact.complementarity.operator import Operator
from fem_contact.complementarity.rows import Rows


@dataclass(frozen=True, kw_only=True)
class Errors:
    """By how much an iterate misses the contact conditions, in the units of the iteration."""

    # sum x |g| and sum x over points below the bound.
    moment: float
    total: float
    # Least gap of these points, greatest gap of points at the bound.
    lowest: float
    highest: float
    # Sums over the working set of phi (x, or x (1 - x / bound)), of the last step, and of phi times the
    # image of that step.
    free: float
    last: float
    image: float

    @classmethod
    def joined(cls, parts: Iterable[Sequence[float]]) -> Self:
        """Join the errors of parts of a grid, each a row of these numbers in their order."""
        joins: list[Callable[..., float]] = [sum, sum, min, max, sum, sum, sum]
        values = [join(column) for join, column in zip(joins, zip(*parts, strict=True), strict=True)]
        return cls(**dict(zip(cls.__annotations__, values, strict=True)))

    def within(self, tolerance: float, *, least: float) -> bool:
        """Whether complementarity, of `least` as sum x at least, and penetration meet a tolerance."""
        return (
            self.moment <= tolerance * max(self.total, least)
            and max(-self.lowest, self.highest) <= 10 * tolerance
        )

    @property
    def size(self) -> float:
        """Mean |g| under the load."""
        return self.moment / self.total if self.total > 0 else 0.0


def _staggered(shape: Shape, place: int, dtype: type[np.floating[Any]]) -> AnyArray:
    """Empty array that starts on a cache line, the one after those of the arrays of lower place.

    A pass reads up to seven arrays at one point of the grid. Large ones all start at the same place of a
    memory page, so that these points compete for the same few lines of the cache.
    """
    line = 64
    size = shape[0] * shape[1] * np.dtype(dtype).itemsize
    # Not a power of two: an eighth of the second-level cache, and nine lines of the first.
    apart = 137 * line * place if size >= 2**20 else 0
    raw = np.empty(size + line + apart, dtype=np.uint8)
    start = -raw.ctypes.data % line + apart
    return raw[start : start + size].view(dtype).reshape(shape)


def _levels(
    nx: int, ny: int, precision: type[np.floating[Any]]
) -> tuple[list[AnyArray], list[NDArray[np.uint8]]]:
    """Return arrays of the sums and counts of the level of nx x ny cells and those above."""
    shapes = [(nx, ny)]
    while max(shapes[-1]) > 4:
        shapes.append((-(-shapes[-1][0] // 2), -(-shapes[-1][1] // 2)))
    return [np.empty(shape, precision) for shape in shapes], [np.empty(shape, np.uint8) for shape in shapes]


class IterationArrays:
    """The arrays of one problem and the compiled passes over them, shared out over threads.

    Force, displacement, heights and bound are double and in Pa and m. Gap, step and image are of the
    precision and the units of the iteration: rounded, they are so to their own size, which falls with the
    error, and what the rounding of images leaves in the gap goes when `start` applies the response afresh.

    Heights h [m] and bound [Pa] are (nx, ny); `caution` is the share of the operator's stiffness by which the
    working set is told, see `solve`. In `units` of force [Pa] and length [m] the iteration runs in single
    precision; in double precision, in Pa and m, if not given.
    """

    def __init__(
        self,
        operator: Operator,
        heights: Array,
        *,
        bound: Array | None,
        caution: float,
        units: tuple[float, float] | None = None,
        threads: int,
    ) -> None:
        from fem_contact.complementarity import kernels

        self.kernels, self.operator, self.quick = kernels, operator, operator
        # Told once that they are only read, given and coarser heights alike need one compiled pass.
        self.heights, self.bound = heights.view(), bound
        self.heights.setflags(write=False)
        self.single = units is not None
        self.force_unit, self.length_unit = (1.0, 1.0) if units is None else units
        self.load_unit = 1 / self.force_unit
        if units is not None:
            assert isinstance(operator, FourierOperator)
            self.quick = operator.single(self.force_unit / self.length_unit)
        self.stiffness = caution * self.quick.stiffness
        self.xp: Any = np
        self.count = heights.size
        nx, ny = heights.shape
        precision = np.float32 if self.single else np.float64
        self.force, self.displacement = (_staggered((nx, ny), place, np.float64) for place in (1, 2))
        self.gap, self.step, self.image, self.buffer = (
            _staggered((nx, ny), place, precision) for place in (3, 4, 5, 6)
        )
        self.step[:] = self.image[:] = 0
        self.working = np.zeros((nx, ny), dtype=bool)
        self.slope, self.most = 0.0, 0.0
        # Sums and counts of points in ever larger cells: levels in slabs, where the grid is, and whole ones.
        self.top = _levels(-(-nx // 2), -(-ny // 2), precision)
        self.levels = self.top[0][:1], self.top[1][:1]
        self.rows = Rows(nx, threads=threads)
        self.coarse_rows = Rows(-(-nx // 2), threads=threads, least=64)

    @property
    def _occupied(self) -> NDArray[np.uint8]:
        """The working set as the counts of a level are."""
        return self.working.view(np.uint8)

    @property
    def nbytes(self) -> int:
        """Memory of the arrays, the heights included."""
        fields = self.heights, self.force, self.displacement, self.gap, self.step, self.image, self.buffer
        return sum(array.nbytes for array in (*fields, self.working, *self.top[0], *self.top[1]))

    def start(self, *, roughly: bool) -> tuple[float, float]:
        """Apply the response afresh, in double precision unless `roughly`; sum phi and phi (u - h)."""
        if roughly and self.single:
            np.multiply(self.force, self.load_unit, out=self.step, casting="same_kind")
            self.quick.apply(self.step, self.image)
            self.step[:] = 0
            self._afresh = self.image, 1.0
        else:
            self.operator.apply(self.force, self.displacement)
            self._afresh = self.displacement, 1 / self.length_unit
        (u, per_u), per_h = self._afresh, 1 / self.length_unit
        total, moment = self.rows.add(
            self.kernels.weigh, self.force, u, self.heights, self.bound, self.load_unit, per_u, per_h
        )
        return total, moment

    def place(self, offset: float) -> Errors:
        """Write the gap at an offset, of the response just applied."""
        u, per_u = self._afresh
        self.rows.run(self.kernels.place, self.gap, u, self.heights, per_u, 1 / self.length_unit, offset)
        return self.move(0.0, 0.0)

    def move(self, factor: float, shift: float) -> Errors:
        """Move the gap by `factor` steps and a change of offset, and measure the conditions there."""
        fields = self.force, self.gap, self.step, self.image, self.bound
        units, level = (self.load_unit, self.stiffness), (self.levels[0][0], self.levels[1][0])
        parts = self.coarse_rows.run(
            self.kernels.move, *fields, factor, shift, *units, self._occupied, *level
        )
        return Errors.joined(parts)

    def precondition(self) -> tuple[float, float]:
        """Turn the residual into z = E' M E residual; sum z, and z times the image of the last step."""
        k, (sums, counts), (top, top_counts) = self.kernels, self.levels, self.top
        local, whole = range(len(sums) - 1), range(len(top) - 1)
        for fine in local:
            k.pull(sums[fine], counts[fine], sums[fine + 1], counts[fine + 1])
        top[0], top_counts[0] = self._whole(sums[-1]), self._whole(counts[-1])
        for fine in whole:
            k.pull(top[fine], top_counts[fine], top[fine + 1], top_counts[fine + 1])
        shares = np.take(k.PARTS, top_counts[-1])
        top[-1] *= shares
        for fine in reversed(whole):
            k.push(0, len(top[fine]), top[fine], top_counts[fine], top[fine + 1], top[fine], 1)
        self._take_top()
        for fine in reversed(local):
            k.push(0, len(sums[fine]), sums[fine], counts[fine], self._as_coarse(fine + 1), sums[fine], 1)
        self.rows.run(k.push, self.buffer, self._occupied, self._as_coarse(0), self.gap, -1)
        self.quick.precondition(self.buffer, self.buffer)
        self.coarse_rows.run(k.push_transposed, *self._as_fine(-1))
        for fine in local:
            k.push_transposed(0, len(sums[fine + 1]), *self._as_fine(fine))
        top[0] = self._whole(sums[-1])
        for fine in whole:
            k.push_transposed(0, len(top[fine + 1]), top[fine], top_counts[fine], top[fine + 1])
        top[-1] *= shares
        for fine in reversed(whole):
            k.pull_transposed(top[fine], top_counts[fine], top[fine + 1])
        self._take_top()
        for fine in reversed(local):
            k.pull_transposed(sums[fine], counts[fine], sums[fine + 1])
        total, image = self.rows.add(k.finish, self.buffer, self._occupied, sums[0], self.image)
        return total, image

    def _whole(self, level: AnyArray) -> AnyArray:
        return level

    def _take_top(self) -> None:
        """Take the rows of `levels` over from `top`, whose finest they are."""

    def _as_coarse(self, level: int) -> AnyArray:
        """Return the sums of a level as the next finer one reads them."""
        return self.levels[0][level]

    def _as_fine(self, level: int) -> tuple[AnyArray, AnyArray, AnyArray]:
        """Values and counts of a level, -1 for the grid, as the next coarser one reads them, and its sums."""
        return self.buffer, self._occupied, self.levels[0][0]

    def trial(self, load: float, *, length: float, beta: float, shift: float) -> None:
        """Write the step to the clipped trial force of the prescribed sum."""
        fields = self.force, self.buffer, self.step, self._occupied, self.bound
        total, above, below = self.rows.add(self.kernels.trial, *fields, self.load_unit, length, beta, shift)
        missing = load - total
        limit = total if self.bound is None else above if missing > 0 else below
        if self.bound is not None and abs(missing) > limit:
            self.project(load)
            return
        self._restore(missing / limit if limit > 0 and abs(missing) > 1e-13 * load else 0.0)

    def _restore(self, toward: float) -> None:
        parts = self.rows.run(
            self.kernels.restore, self.force, self.gap, self.step, self.bound, self.load_unit, toward
        )
        slopes, most = zip(*parts, strict=True)
        self.slope, self.most = sum(slopes), max(most)

    def project(self, load: float) -> None:
        """Write the step of the projected gradient: to the forces of that sum nearest to x - stiffness g.

        Whatever the state, it is a direction of descent; it is slow and used where the other is none.
        """
        xp, force, mean = self.xp, self.force * self.load_unit, load / self.count
        aim = force - self.stiffness * self.gap
        top = None if self.bound is None else self.bound * self.load_unit
        low = mean - float(xp.max(aim))
        high = (mean if top is None else float(xp.max(top))) - float(xp.min(aim))
        for _ in range(200):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            below = float(xp.mean(xp.clip(aim + middle, 0.0, top))) < mean
            low, high = (middle, high) if below else (low, middle)
        self.step[...] = xp.clip(aim + high, 0.0, top) - force
        self._restore(0.0)

    def bend(self) -> float:
        """Apply the response to the step; its curvature, sum s v."""
        self.quick.apply(self.step, self.image)
        (bend,) = self.rows.add(self.kernels.bend, self.step, self.image)
        return bend

    def room(self) -> float:
        """How many steps the bounds leave room for; never less than one, since the trial force keeps them."""
        return max(1.0, 1 / self.most) if self.most > 0 else np.inf

    def advance(self, factor: float) -> tuple[float, float]:
        """Move the force by `factor` steps; sum phi, and phi times the gap there before the offset moves."""
        fields = self.force, self.gap, self.step, self.image, self.bound
        total, moment = self.rows.add(self.kernels.advance, *fields, self.load_unit, factor)
        return total, moment
