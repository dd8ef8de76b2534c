"""The passes of the contact iteration in plain array operations: NumPy, PyTorch, any Array-API library.

The iteration is that of `solve`; only what it does to arrays stands here a second time: readable, without
threads or compiled code, in the library and on the device of the heights. It checks the compiled passes, too.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fem_contact._checks import shown
from fem_contact._types import AnyArray, Lengths, Shape
from fem_contact.complementarity.fourier import FourierOperator
from fem_contact.complementarity.grids import Grids
from fem_contact.complementarity.iteration_arrays import Errors, IterationArrays
from fem_contact.complementarity.operator import Operator
from fem_contact.errors import InvalidInput
from fem_contact.response import Response

#: What the compiled passes have as `PARTS`, for one and for two.
ALONE, PAIRED = 0.5, 0.46

#: An array of any library: they share no type.
Values = Any


def namespace(values: Values) -> Any:
    """Return the library of an array, as the Array-API standard has it."""
    if isinstance(values, np.ndarray):
        return np
    try:
        from array_api_compat import array_namespace
    except ImportError:
        raise InvalidInput("device: arrays beyond NumPy's need pip install 'fem-contact[arrays]'") from None
    return array_namespace(values)


class ArrayGrids(Grids):
    """Grids whose arrays lie on a device of PyTorch, such as "cuda", or beside an array of any library."""

    def __init__(self, where: str | Values, shape: Shape, *, threads: int) -> None:
        super().__init__(shape, threads=threads)
        if not isinstance(where, str):
            try:
                self.xp, self.device = namespace(where), where.device
            except (TypeError, AttributeError):
                allowed = 'a device of PyTorch, such as "cuda", or an array'
                raise InvalidInput(f"device = {shown(where)}: must be {allowed}") from None
            return
        try:
            import array_api_compat.torch as torch

            self.xp, self.device = torch, torch.empty(1, device=where).device
        except (ImportError, OSError):
            what = "PyTorch and pip install 'fem-contact[arrays]'"
            raise InvalidInput(f"device = {where!r}: needs {what}") from None
        except (RuntimeError, AssertionError) as error:
            reason = " ".join(str(error).split())[:80]
            raise InvalidInput(f"device = {where!r}: must be one that PyTorch has here ({reason})") from None

    def put(self, field: AnyArray | None) -> Values:
        """Return a field there."""
        return None if field is None else self.xp.asarray(field, device=self.device, copy=True)

    def fetched_field(self, field: Values) -> AnyArray:
        """Return one field as NumPy's."""
        if isinstance(field, np.ndarray):
            return field
        from array_api_compat import is_torch_array

        return np.array(np.from_dlpack(field.cpu() if is_torch_array(field) else field))

    def residual_sums(self, pressure: Values, gap: Values, at_bound: Values) -> list[float]:
        """Return what the residuals are made of."""
        xp, size = self.xp, self.xp.abs(pressure)
        closed = xp.where(at_bound, xp.zeros_like(gap), gap)
        sums = xp.sum(pressure), xp.sum(size), xp.sum(size * xp.abs(closed)), xp.min(closed), xp.min(pressure)
        return [float(value) for value in sums]

    def rms_gradient(self, surface: Any, heights: Values) -> float:
        """Return h'_rms of the surface, of its heights there, as `HeightField.rms_gradient` has it."""
        xp, (nx, ny) = self.xp, self.shape
        power = xp.abs(xp.fft.rfftn(heights, axes=(0, 1), norm="forward")) ** 2
        m, n = np.fft.fftfreq(nx, 1 / nx), np.arange(ny // 2 + 1)
        # Half of the waves stand for both signs; those of the Nyquist limit for half of either.
        of_m, of_n = np.where(2 * m == -nx, 0.5, 1.0), np.where(n == 0, 1.0, np.where(2 * n == ny, 0.5, 2.0))
        qx, qy = (2 * np.pi / length * waves for length, waves in zip(surface.lengths, (m, n), strict=True))
        rows = xp.sum(power * self.put(of_n)[None, :], axis=1)
        columns = xp.sum(power * self.put(of_m)[:, None], axis=0)
        squares = xp.sum(rows * self.put(of_m * qx**2)) + xp.sum(columns * self.put(of_n * qy**2))
        return math.sqrt(float(squares))

    def operator_of(self, response: Response, shape: Shape, lengths: Lengths) -> ArrayOperator:
        """Return the response of a solid on one of the grids; C(q) itself is evaluated by NumPy."""
        return ArrayOperator(FourierOperator(response, shape, lengths, threads=self.threads), self)

    def coarsened(self, heights: Values, old: Shape, new: Shape) -> Values:
        """Return heights on a coarser grid, freed of the waves that it cannot carry."""
        xp, top = self.xp, (min(old[0], new[0]) - 1) // 2
        kept = (min(old[1], new[1]) - 1) // 2 + 1
        waves = xp.fft.rfftn(heights, axes=(0, 1), norm="forward")[:, :kept]
        coarse = xp.zeros((new[0], new[1] // 2 + 1), dtype=waves.dtype, device=self.device)
        coarse[: top + 1, :kept] = waves[: top + 1, :]
        if top:
            coarse[new[0] - top :, :kept] = waves[old[0] - top :, :]
        return xp.fft.irfftn(coarse, s=new, axes=(0, 1), norm="forward")

    def refined(self, field: Values, old: Shape, new: Shape) -> Values:
        """Carry a field to a finer grid, bilinearly."""
        for axis in (0, 1):
            place = np.arange(new[axis]) * (old[axis] / new[axis])
            below = place.astype(int)
            share = self.put(np.expand_dims(place - below, 1 - axis))
            sides = (self.xp.take(field, self.put((below + k) % old[axis]), axis=axis) for k in (0, 1))
            field = (1 - share) * next(sides) + share * next(sides)
        return field

    def nearest(self, field: Values, new: Shape) -> Values:
        """Take a field of the finest grid at the points of a coarser one nearest below."""
        for axis in (0, 1):
            places = np.arange(new[axis]) * self.shape[axis] // new[axis]
            field = self.xp.take(field, self.put(places), axis=axis)
        return field


class ArrayOperator:
    """A Fourier response in the library and on the device of an array; see `FourierOperator`."""

    pairs = 1.0

    def __init__(self, operator: FourierOperator, grids: ArrayGrids) -> None:
        self.xp, self.shape, self.stiffness = grids.xp, operator.shape, operator.stiffness
        self.nbytes = 2 * operator.compliance.nbytes
        self.compliance = grids.put(operator.compliance)
        self.inverse = self._stiffnesses()
        self.inverse[0, 0] = 0.0
        if operator.long_waves is not None:
            rows, factor = operator.long_waves
            weaker = np.ones(operator.compliance.shape)
            weaker[rows, : factor.shape[1]] = factor
            self.inverse *= grids.put(weaker)

    def apply(self, force: Values, out: Values) -> None:
        """Write the displacement [m] under the pressure ``force`` [Pa] into ``out``."""
        self._filter(force, out, self.compliance)

    def invert(self, displacement: Values, out: Values) -> None:
        """Write the full-contact pressure [Pa] under a displacement [m], with no mean, into ``out``."""
        self._filter(displacement, out, self._stiffnesses())
        out -= self.xp.mean(out)

    def precondition(self, residual: Values, out: Values) -> None:
        """Do as `invert`, but with long waves no stiffer than contacts feel them: see `FourierOperator`."""
        self._filter(residual, out, self.inverse)

    def _stiffnesses(self) -> Values:
        return 1 / self.xp.where(self.compliance > 0, self.compliance, self.xp.ones_like(self.compliance))

    def _filter(self, field: Values, out: Values, factor: Values) -> None:
        fft = self.xp.fft
        spectrum = fft.rfftn(field, axes=(0, 1)) * factor
        out[...] = fft.irfftn(spectrum, s=self.shape, axes=(0, 1))


class PlainIterationArrays(IterationArrays):
    """What `IterationArrays` does, in plain array operations; the same names mean the same."""

    def __init__(self, operator: Operator, heights: Values, *, bound: Values | None, caution: float) -> None:
        self.xp = xp = namespace(heights)
        self.operator = self.quick = operator
        self.heights, self.bound, self.stiffness = heights, bound, caution * operator.stiffness
        self.single, self.force_unit, self.length_unit, self.load_unit = False, 1.0, 1.0, 1.0
        self.force, self.displacement, self.gap, self.step, self.image, self.buffer = (
            xp.zeros_like(heights) for _ in range(6)
        )
        self.working = xp.zeros_like(heights, dtype=xp.bool)
        self.count = heights.shape[0] * heights.shape[1]
        self.slope = 0.0

    @property
    def nbytes(self) -> int:
        """Memory of the arrays, the heights included."""
        return 8 * self.count * (7 if self.bound is None else 8) + self.count

    def _sum(self, values: Values) -> float:
        return float(self.xp.sum(values))

    @property
    def _phi(self) -> Values:
        return self.force if self.bound is None else self.force * (1 - self.force / self.bound)

    def start(self, *, roughly: bool = False) -> tuple[float, float]:
        """Apply the response afresh; sum phi and phi (u - h)."""
        self.operator.apply(self.force, self.displacement)
        phi = self._phi
        return self._sum(phi), self._sum(phi * (self.displacement - self.heights))

    def place(self, offset: float) -> Errors:
        """Write the gap at an offset, of the response just applied."""
        self.gap[...] = self.displacement - self.heights + offset
        return self.move(0.0, 0.0)

    def move(self, factor: float, shift: float) -> Errors:
        """Move the gap by `factor` steps and a change of offset, and measure the conditions there."""
        xp, x = self.xp, self.force
        self.gap[...] = gap = self.gap + factor * self.image + shift
        aim = x - self.stiffness * gap
        free = xp.ones_like(self.working) if self.bound is None else x < self.bound
        self.working = (
            aim > 0 if self.bound is None else xp.where(x < 0.5 * self.bound, aim > 0, aim < self.bound)
        )
        nothing = xp.zeros_like(gap)
        borne = xp.where(free, x, nothing)
        inside = xp.where(self.working, self._phi, nothing)
        highest = -np.inf if self.bound is None else float(xp.max(xp.where(free, nothing - np.inf, gap)))
        return Errors(
            moment=self._sum(borne * xp.abs(gap)),
            total=self._sum(borne),
            lowest=float(xp.min(xp.where(free, gap, nothing + np.inf))),
            highest=highest,
            free=self._sum(inside),
            last=self._sum(xp.where(self.working, self.step, nothing)),
            image=self._sum(inside * self.image),
        )

    def precondition(self) -> tuple[float, float]:
        """Turn the residual into z = E' M E residual; sum z, and z times the image of the last step."""
        xp = self.xp
        one, nothing = xp.ones_like, xp.zeros_like
        shares = [xp.where(self.working, one(self.gap), nothing(self.gap))]
        values = [-self.gap * shares[0]]
        while max(values[-1].shape) > 4 or len(values) < 2:
            count = self._summed(xp.where(shares[-1] > 0, one(shares[-1]), nothing(shares[-1])))
            few = xp.where(count > 1, PAIRED * one(count), ALONE * count)
            shares.append(xp.where(count > 2, 1 / xp.where(count > 2, count, one(count)), few))
            values.append(self._summed(values[-1]) * shares[-1])
        for k in range(len(values) - 2, -1, -1):
            values[k] = xp.where(shares[k] > 0, values[k], self._spread(values[k + 1], values[k].shape))
        self.operator.precondition(values[0], self.buffer)
        levels = [self.buffer]
        for k in range(len(values) - 1):
            rest = xp.where(shares[k] > 0, nothing(levels[k]), levels[k])
            levels.append(self._gathered(rest))
        above = nothing(levels[-1])
        for k in range(len(levels) - 1, -1, -1):
            nx, ny = levels[k].shape
            own = (levels[k] + above[:nx, :ny]) * shares[k]
            above = own if k == 0 else xp.repeat(xp.repeat(own, 2, axis=0), 2, axis=1)
        self.buffer[...] = above
        return self._sum(above), self._sum(above * self.image)

    def _even(self, fine: Values) -> Values:
        """Append zeros along an axis of an odd number of points."""
        (nx, ny), xp = fine.shape, self.xp
        if nx % 2:
            fine = xp.concat([fine, xp.zeros_like(fine[:1, :])], axis=0)
        if ny % 2:
            fine = xp.concat([fine, xp.zeros_like(fine[:, :1])], axis=1)
        return fine

    def _summed(self, fine: Values) -> Values:
        """Sum over cells of 2 x 2, the last of an odd axis smaller."""
        fine = self._even(fine)
        return fine[::2, ::2] + fine[1::2, ::2] + fine[::2, 1::2] + fine[1::2, 1::2]

    def _spread(self, coarse: Values, shape: Shape) -> Values:
        """Interpolate a level bilinearly to the next finer one."""
        xp = self.xp
        for axis in (0, 1):
            left = 0.75 * coarse + 0.25 * xp.roll(coarse, 1, axis=axis)
            right = 0.75 * coarse + 0.25 * xp.roll(coarse, -1, axis=axis)
            wide = list(coarse.shape)
            wide[axis] *= 2
            coarse = xp.reshape(xp.stack([left, right], axis=axis + 1), tuple(wide))
        return coarse[: shape[0], : shape[1]]

    def _gathered(self, fine: Values) -> Values:
        """Transpose of `_spread`."""
        xp, fine = self.xp, self._even(fine)
        for axis in (0, 1):
            left = fine[::2, :] if axis == 0 else fine[:, ::2]
            right = fine[1::2, :] if axis == 0 else fine[:, 1::2]
            fine = 0.75 * (left + right) + 0.25 * (
                xp.roll(left, -1, axis=axis) + xp.roll(right, 1, axis=axis)
            )
        return fine

    def trial(self, load: float, *, length: float, beta: float, shift: float) -> None:
        """Write the step to the clipped trial force of the prescribed sum."""
        xp, x = self.xp, self.force
        nothing = xp.zeros_like(x)
        y = x + length * (self.buffer + beta * self.step - shift * self._phi)
        y = xp.where(self.working, xp.clip(y, 0.0, None), nothing)
        if self.bound is None:
            total = self._sum(y)
            self._step_to(y * (load / total) if total > 0 else y)
            return
        y = xp.where(~self.working & (x >= 0.5 * self.bound), self.bound, xp.clip(y, None, self.bound))
        between = (y > 0) & (y < self.bound)
        missing = load - self._sum(y)
        room = xp.where(between, self.bound - y if missing > 0 else y, nothing)
        limit = self._sum(room)
        if abs(missing) > limit:
            self.project(load)
            return
        self._step_to(y + (missing / limit if limit > 0 else 0.0) * room)

    def _step_to(self, force: Values) -> None:
        self.step[...] = force - self.force
        self._restore(0.0)

    def _restore(self, toward: float) -> None:
        self.slope = self._sum(self.gap * self.step)

    def bend(self) -> float:
        """Apply the response to the step; its curvature, sum s v."""
        self.operator.apply(self.step, self.image)
        return self._sum(self.step * self.image)

    def room(self) -> float:
        """How many steps the bounds leave room for."""
        xp, x, s = self.xp, self.force, self.step
        endless = xp.zeros_like(x) + np.inf
        down = xp.where(s < 0, x / xp.where(s < 0, -s, xp.ones_like(s)), endless)
        if self.bound is not None:
            up = (self.bound - x) / xp.where(s > 0, s, xp.ones_like(s))
            down = xp.where((s > 0) & (up < down), up, down)
        return float(xp.min(down))

    def advance(self, factor: float) -> tuple[float, float]:
        """Move the force by `factor` steps; sum phi, and phi times the gap there before the offset moves."""
        xp = self.xp
        moved = xp.clip(self.force + factor * self.step, 0.0, None)
        if self.bound is not None:
            moved = xp.where(moved < self.bound * (1 - 1e-14), moved, self.bound)
        self.force[...] = moved
        phi = self._phi
        return self._sum(phi), self._sum(phi * (self.gap + factor * self.image))
