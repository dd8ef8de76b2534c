"""What a file of heights says of itself, and the sizes past which it is refused."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from validation.arrays import Array, Pair
from validation.errors import UsageError

#: Heights that are read: 8192 x 8192, half a gigabyte as numbers.
MOST_POINTS = 2**26
#: Bytes of a file that is read.
MOST_BYTES = 2**31
#: Share of a step by which positions may be off an even spacing; files round them.
_UNEVEN = 0.02
#: Cells are called oblong, and lengths at odds with a file, when ratios are off by more than this.
RATIO = 0.02


@dataclass(frozen=True, kw_only=True)
class Raw:
    """A file of heights as it is: NaN where there are none, in `unit`; None for what it does not say.

    Without `length_units` only the ratio of the two lengths is known. Notes are for readers of the results;
    a header is text that was not understood.
    """

    heights: Array
    lengths: Pair | None = None
    length_units: tuple[str, str] | None = None
    unit: str | None = None
    notes: tuple[str, ...] = ()
    header: str = ""


@dataclass(frozen=True, kw_only=True, eq=False)
class FileSays:
    """What a file of heights says of itself: heights in its own unit, NaN where there are none; sizes [m].

    Of sizes without a unit it says the ratio Lx/Ly alone.
    """

    heights: Array
    lengths: Pair | None
    ratio: float | None
    unit: float | None
    digest: str
    notes: tuple[str, ...]

    def check_square(self, key: str) -> None:
        """Refuse one length for both sides if points along them differ in number and no size is known."""
        nx, ny = self.heights.shape
        if self.lengths is None and abs(nx / ny - 1) > RATIO:
            raise UsageError(
                f"{key}: one length for {nx} x {ny} points makes oblong cells; give both sides, [Lx, Ly], x "
                "along the first of the two numbers of points"
            )


def check_shape(shape: tuple[int, ...]) -> None:
    """Refuse what is no map, or one too large, with a ValueError, before it is read."""
    if len(shape) != 2 or min(shape) < 2:
        raise ValueError(f"shape {shape}; a map of at least 2 x 2 heights is needed")
    if math.prod(shape) > MOST_POINTS:
        nx, ny = shape
        raise ValueError(f"{nx} x {ny} heights; at most {MOST_POINTS} are read: cut it or thin it out")


def real(values: Any) -> Array:
    """Return heights as real numbers; complex ones are refused with a ValueError rather than halved."""
    array = np.asarray(values)
    if array.dtype.kind not in "biuf":
        raise ValueError(f"it holds {array.dtype.name} values; heights are real numbers")
    return array.astype(float, copy=False)


def plain_attribute(value: Any, what: str) -> str | None:
    """Return an attribute that should be a short text; None for an empty one, ValueError for others."""
    if value is None:
        return None
    about = f"{len(value)} characters long" if isinstance(value, str) else f"a {type(value).__name__}"
    if not isinstance(value, str) or len(value) > 64:
        raise ValueError(f"{what} is {about}, and must be a text such as 'um'")
    return value.strip() or None


def even_steps(positions: Array, name: str) -> float:
    """Return the step of evenly spaced positions, negative where they fall; ValueError for others."""
    n = positions.size
    if n < 2:
        raise ValueError(f"{name} has {n} position{'s' * (n != 1)}; at least 2 are needed")
    if not np.all(np.isfinite(positions)):
        raise ValueError(f"{name} is not known everywhere")
    step = float(positions[-1] - positions[0]) / (n - 1)
    if not math.isfinite(step) or step == 0:
        raise ValueError(f"{name} runs from {positions[0]:.6g} to {positions[-1]:.6g}")
    if not np.abs(positions - (positions[0] + step * np.arange(n))).max() <= _UNEVEN * abs(step):
        steps = np.diff(positions)
        raise ValueError(
            f"{name} is not evenly spaced: its steps run from {steps.min():.4g} to {steps.max():.4g}"
        )
    return step
