"""The arrays of one contact iteration and the passes over them; no decision is taken here."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fem_contact.complementarity.rows import Rows

if TYPE_CHECKING:
    from fem_contact.complementarity.operator import Operator

__all__ = ["Errors", "Passes", "Slopes"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Slopes:
    """The energy along the step.

    Attributes
    ----------
    slope, curvature : float
        First and second derivative per step.
    lift : float
        Sum of displacement times step.
    plain : float
        Curvature along the trial step, before it was scaled to the load.
    """

    slope: float
    curvature: float
    lift: float
    plain: float


@dataclass(frozen=True, kw_only=True)
class Errors:
    """By how much an iterate misses the contact conditions.

    Attributes
    ----------
    moment, total : float
        sum x |g| and sum x over points below the bound.
    lowest, highest : float
        Least gap of these points, greatest gap of points at the bound [m].
    free, last, image : float
        Sums over the working set of phi (x, or x (1 - x / bound)), of the last step, and of phi times the
        image of that step.
    """

    moment: float
    total: float
    lowest: float
    highest: float
    free: float
    last: float
    image: float

    def within(self, tolerance: float, *, least: float) -> bool:
        """Whether complementarity, of `least` as sum x at least, and penetration meet a tolerance [m]."""
        return (
            self.moment <= tolerance * max(self.total, least)
            and max(-self.lowest, self.highest) <= 10 * tolerance
        )

    @property
    def size(self) -> float:
        """Mean |g| under the load [m]."""
        return self.moment / self.total if self.total > 0 else 0.0


def _staggered(shape: tuple[int, int], place: int, dtype: type[np.floating[Any]]) -> NDArray[Any]:
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


class Passes:
    """The arrays of one problem and the compiled passes over them, shared out over threads.

    All are of the precision of the heights.
    """

    def __init__(
        self, heights: NDArray[Any], *, bound: NDArray[Any] | None, stiffness: float, threads: int
    ) -> None:
        from fem_contact.complementarity import kernels

        self.kernels, self.heights, self.bound, self.stiffness = kernels, heights, bound, stiffness
        self.xp: Any = np
        self.count = heights.size
        nx, ny = heights.shape
        precision = heights.dtype.type
        fields = (_staggered((nx, ny), place, precision) for place in range(1, 6))
        self.force, self.displacement, self.step, self.image, self.buffer = fields
        self.step[:] = self.image[:] = 0
        self.working = np.zeros((nx, ny), dtype=bool)
        self.share, self.pull_back = 1.0, 0.0
        self._trial: tuple[float, float] | None = None
        self.sums: list[NDArray[Any]] = []
        self.counts: list[NDArray[np.uint8]] = []
        while max(nx, ny) > 4 or not self.sums:
            nx, ny = -(-nx // 2), -(-ny // 2)
            self.sums.append(np.empty((nx, ny), dtype=precision))
            self.counts.append(np.empty((nx, ny), dtype=np.uint8))
        self.rows = Rows(heights.shape[0], threads=threads)
        self.coarse_rows = Rows(self.sums[0].shape[0], threads=threads, least=64)

    @property
    def nbytes(self) -> int:
        """Memory of the arrays, the heights included."""
        fields = (
            self.heights,
            self.force,
            self.displacement,
            self.step,
            self.image,
            self.buffer,
            self.working,
        )
        return sum(array.nbytes for array in (*fields, *self.sums, *self.counts))

    def start(self, operator: Operator) -> tuple[float, float, float]:
        """Apply the response afresh; sum phi, phi (u - h) and x u."""
        operator.apply(self.force, self.displacement)
        total, moment, energy = self.rows.add(
            self.kernels.weigh, self.force, self.displacement, self.heights, self.bound
        )
        return total, moment, energy

    def residual(self, offset: float) -> Errors:
        """Write the residual and the working set; measure by how much the conditions are missed."""
        if self.bound is None:
            return self._move(0.0, 0.0, offset)[0]
        parts = self.coarse_rows.run(
            self.kernels.residual_bounded,
            self.force,
            self.displacement,
            self.heights,
            offset,
            self.bound,
            self.stiffness,
            self.buffer,
            self.working,
            self.sums[0],
            self.counts[0],
            self.step,
            self.image,
        )
        moments, totals, lowest, highest, free, last, images = zip(*parts, strict=True)
        return Errors(
            moment=sum(moments),
            total=sum(totals),
            lowest=min(lowest),
            highest=max(highest),
            free=sum(free),
            last=sum(last),
            image=sum(images),
        )

    def precondition(self, operator: Operator) -> tuple[float, float]:
        """Turn the residual into z = E' M E residual; sum z, and z times the image of the last step."""
        k, sums, counts = self.kernels, self.sums, self.counts
        for fine in range(len(sums) - 1):
            k.pull(sums[fine], counts[fine], sums[fine + 1], counts[fine + 1])
        sums[-1] /= np.maximum(counts[-1], 1)
        for fine in range(len(sums) - 2, -1, -1):
            k.push(0, sums[fine].shape[0], sums[fine], counts[fine], sums[fine + 1], k.DECAY)
        self.rows.run(k.push, self.buffer, self.working, sums[0], k.DECAY)
        operator.precondition(self.buffer, self.buffer)
        self.coarse_rows.run(k.push_transposed, self.buffer, self.working, sums[0], k.DECAY)
        for fine in range(len(sums) - 1):
            rows = sums[fine + 1].shape[0]
            k.push_transposed(0, rows, sums[fine], counts[fine], sums[fine + 1], k.DECAY)
        sums[-1] *= (counts[-1] > 0) / np.maximum(counts[-1], 1)
        for fine in range(len(sums) - 2, -1, -1):
            k.pull_transposed(sums[fine], counts[fine], sums[fine + 1])
        total, image = self.rows.add(k.finish, self.buffer, self.working, sums[0], self.image)
        return total, image

    def trial(self, mean_force: float, *, offset: float, length: float, beta: float, shift: float) -> None:
        """Write the step to the clipped trial force of the prescribed load."""
        k, target = self.kernels, mean_force * self.count
        self.share, self.pull_back, self._trial = 1.0, 0.0, None
        if self.bound is None:
            total, slope, lift = self.rows.add(
                k.trial,
                self.force,
                self.buffer,
                self.step,
                self.working,
                self.displacement,
                self.heights,
                offset,
                length,
                beta,
                shift,
            )
            self._trial = slope, lift
            # The trial force times `share` carries the load; its step is share * step - pull_back * force.
            if total > 0 and abs(target / total - 1) > 1e-13:
                self.share, self.pull_back = target / total, 1 - target / total
            return
        inside, rest, room = self.rows.add(
            k.trial_bounded, self.force, self.buffer, self.step, self.working, self.bound, length, beta, shift
        )
        missing = target - inside - rest
        limit = room if missing > 0 else inside
        if abs(missing) > limit:
            self.project(mean_force, offset)
            return
        toward = missing / limit if limit > 0 and abs(missing) > 1e-13 * target else 0.0
        self.rows.run(k.subtract_bounded, self.step, self.force, self.bound, toward)

    def project(self, mean_force: float, offset: float) -> None:
        """Write the step of the projected gradient: to the forces of that load nearest to x - stiffness g.

        Whatever the state, it is a direction of descent; it is slow and used where the other is none.
        """
        self.share, self.pull_back, self._trial = 1.0, 0.0, None
        aim = self.force - self.stiffness * (self.displacement - self.heights + offset)
        top = np.inf if self.bound is None else self.bound
        low = mean_force - float(np.max(aim))
        high = (mean_force if self.bound is None else float(np.max(self.bound))) - float(np.min(aim))
        for _ in range(200):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            if float(np.mean(np.clip(aim + middle, 0.0, top))) < mean_force:
                low = middle
            else:
                high = middle
        np.subtract(np.clip(aim + high, 0.0, top), self.force, out=self.step)

    def search(self, offset: float, energy: float) -> Slopes:
        """Slope and curvature of the elastic energy less work along the step; `energy` is sum x u."""
        k = self.kernels
        if self._trial is None:
            slope, bend, lift = self.rows.add(
                k.line, self.force, self.displacement, self.heights, offset, self.step, self.image
            )
            return Slopes(slope=slope, curvature=bend, lift=lift, plain=bend)
        (bend,) = self.rows.add(k.bend, self.step, self.image)
        slope, lift = self._trial
        share, back = self.share, self.pull_back
        # The offset makes sum g x vanish, and x times the image of s is s times that of x.
        return Slopes(
            slope=share * slope,
            curvature=share**2 * bend - 2 * share * back * lift + back**2 * energy,
            lift=share * lift - back * energy,
            plain=bend,
        )

    def room(self) -> float:
        """How many steps the bounds leave room for; never less than one, since the trial force keeps them."""
        parts = self.rows.run(
            self.kernels.room, self.force, self.step, self.bound, self.share, self.pull_back
        )
        return min(most for (most,) in parts)

    def advance_residual(self, factor: float, offset: float) -> tuple[Errors, float, float]:
        """Move by `factor` steps and write the residual for that offset; sum x (u - h) and x u; no bound."""
        return self._move(factor * self.share, factor * self.pull_back, offset)

    def _move(self, share: float, pull_back: float, offset: float) -> tuple[Errors, float, float]:
        parts = self.coarse_rows.run(
            self.kernels.advance_residual,
            self.force,
            self.displacement,
            self.heights,
            self.step,
            self.image,
            share,
            pull_back,
            offset,
            self.stiffness,
            self.buffer,
            self.working,
            self.sums[0],
            self.counts[0],
        )
        moments, totals, torques, energies, lowest, free, last, images = zip(*parts, strict=True)
        errors = Errors(
            moment=sum(moments),
            total=sum(totals),
            lowest=min(lowest),
            highest=-np.inf,
            free=sum(free),
            last=sum(last),
            image=sum(images),
        )
        return errors, sum(torques), sum(energies)

    def advance(self, factor: float) -> tuple[float, float]:
        """Move by `factor` steps; sum phi and phi (u - h) there; under a bound."""
        total, moment = self.rows.add(
            self.kernels.advance_bounded,
            self.force,
            self.displacement,
            self.heights,
            self.step,
            self.image,
            factor,
            self.bound,
        )
        return total, moment
