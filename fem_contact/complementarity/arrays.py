"""The passes of the contact iteration in plain array operations: NumPy, PyTorch, any Array-API library.

The iteration is that of `solve`; only what it does to arrays stands here a second time: readable, without
threads or compiled code, in the library and on the device of the heights. It checks the compiled passes, too.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fem_contact._checks import shown
from fem_contact.complementarity.passes import Errors, Passes
from fem_contact.errors import InvalidInput

if TYPE_CHECKING:
    from fem_contact.complementarity.fourier import FourierOperator
    from fem_contact.complementarity.operator import Operator, Solution

__all__ = ["ArrayOperator", "ArrayPasses", "Device"]

Array = NDArray[np.float64]

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


class Device:
    """The library and the device that the arrays of a solve are put on.

    Parameters
    ----------
    where : str or array
        A device of PyTorch, such as "cuda", or an array that lies there already, of any library.
    """

    def __init__(self, where: str | Values) -> None:
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

    def put(self, field: Array | None) -> Values:
        """Return a field there."""
        return None if field is None else self.xp.asarray(field, device=self.device, copy=True)

    def fetched(self, solution: Solution) -> Solution:
        """Return a solution whose fields are NumPy's."""
        return replace(
            solution,
            force=self._fetched(solution.force),
            displacement=self._fetched(solution.displacement),
            in_contact=self._fetched(solution.in_contact),
            at_bound=self._fetched(solution.at_bound),
        )

    def _fetched(self, field: Values) -> NDArray[Any]:
        if isinstance(field, np.ndarray):
            return field
        from array_api_compat import is_torch_array

        return np.array(np.from_dlpack(field.cpu() if is_torch_array(field) else field))


class ArrayOperator:
    """A Fourier response in the library and on the device of an array; see `FourierOperator`."""

    pairs = 1.0

    def __init__(self, operator: FourierOperator, device: Device) -> None:
        self.xp, self.shape, self.stiffness = device.xp, operator.shape, operator.stiffness
        inverse = 1 / np.where(operator.compliance > 0, operator.compliance, 1.0)
        inverse[0, 0] = 0.0
        if operator.long_waves is not None:
            rows, factor = operator.long_waves
            inverse[rows, : factor.shape[1]] *= factor
        self.compliance, self.inverse = device.put(operator.compliance), device.put(inverse)

    def apply(self, force: Values, out: Values) -> None:
        """Write the displacement [m] under the pressure ``force`` [Pa] into ``out``."""
        self._filter(force, out, self.compliance)

    def precondition(self, residual: Values, out: Values) -> None:
        """Write the full-contact pressure [Pa] under a displacement [m], without its mean, into ``out``."""
        self._filter(residual, out, self.inverse)

    def _filter(self, field: Values, out: Values, factor: Values) -> None:
        fft = self.xp.fft
        spectrum = fft.rfftn(field, axes=(0, 1)) * factor
        out[...] = fft.irfftn(spectrum, s=self.shape, axes=(0, 1))


class ArrayPasses(Passes):
    """What `Passes` does, in plain array operations; the same names mean the same."""

    def __init__(self, operator: Operator, heights: Values, *, bound: Values | None, caution: float) -> None:
        self.xp = xp = namespace(heights)
        self.operator = self.quick = operator
        self.heights, self.bound, self.stiffness = heights, bound, caution * operator.stiffness
        self.single, self.force_unit, self.length_unit = False, 1.0, 1.0
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
            own = (levels[k] + above) * shares[k]
            above = self._repeated(own, levels[k - 1].shape) if k else own
        self.buffer[...] = above
        return self._sum(above), self._sum(above * self.image)

    def _summed(self, fine: Values) -> Values:
        """Sum over cells of 2 x 2, the last of an odd axis smaller."""
        (nx, ny), xp = fine.shape, self.xp
        if nx % 2:
            fine = xp.concat([fine, xp.zeros_like(fine[:1, :])], axis=0)
        if ny % 2:
            fine = xp.concat([fine, xp.zeros_like(fine[:, :1])], axis=1)
        return fine[::2, ::2] + fine[1::2, ::2] + fine[::2, 1::2] + fine[1::2, 1::2]

    def _repeated(self, coarse: Values, shape: tuple[int, int]) -> Values:
        """Give each point of a level the value of its cell."""
        xp = self.xp
        for axis in (0, 1):
            coarse = xp.repeat(coarse, 2, axis=axis)
        return coarse[: shape[0], : shape[1]]

    def _spread(self, coarse: Values, shape: tuple[int, int]) -> Values:
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
        xp = self.xp
        for axis in (0, 1):
            if fine.shape[axis] % 2:
                edge = fine[:1, :] if axis == 0 else fine[:, :1]
                fine = xp.concat([fine, xp.zeros_like(edge)], axis=axis)
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
        y = xp.where(self.working & (y > 0), y, nothing)
        if self.bound is None:
            total = self._sum(y)
            if total > 0:
                y = y * (load / total)
            self._step_to(y)
            return
        y = xp.where(~self.working & (x >= 0.5 * self.bound), self.bound, y)
        y = xp.where(y < self.bound, y, self.bound)
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
        self.slope = self._sum(self.gap * self.step)

    def project(self, load: float) -> None:
        """Write the step of the projected gradient: to the forces of that sum nearest to x - stiffness g."""
        xp, mean = self.xp, load / self.count
        aim = self.force - self.stiffness * self.gap

        def clipped(shift: float) -> Values:
            moved = xp.where(aim + shift > 0, aim + shift, xp.zeros_like(aim))
            return moved if self.bound is None else xp.where(moved < self.bound, moved, self.bound)

        low = mean - float(xp.max(aim))
        high = (mean if self.bound is None else float(xp.max(self.bound))) - float(xp.min(aim))
        for _ in range(200):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            low, high = (middle, high) if self._sum(clipped(middle)) < load else (low, middle)
        self._step_to(clipped(high))

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
        moved = self.force + factor * self.step
        moved = xp.where(moved > 0, moved, xp.zeros_like(moved))
        if self.bound is not None:
            moved = xp.where(moved < self.bound * (1 - 1e-14), moved, self.bound)
        self.force[...] = moved
        phi = self._phi
        return self._sum(phi), self._sum(phi * (self.gap + factor * self.image))
