"""Checks of arguments, shared by the modules of this package."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from persson.errors import InvalidInput

__all__ = ["Array", "non_negative", "positive", "real"]

Array = NDArray[np.float64]


def _shown(value: Array, bad: NDArray[np.bool_]) -> str:
    return repr(float(value[bad].flat[0]) if value.ndim else float(value))


def real(name: str, value: ArrayLike, *, unit: str = "") -> Array:
    """Return `value` as a float array, refusing NaN and infinities."""
    array = np.asarray(value, dtype=float)
    bad = ~np.isfinite(array)
    if bad.any():
        raise InvalidInput(f"{name} = {_shown(array, bad)}: must be finite{_in(unit)}")
    return array


def non_negative(name: str, value: ArrayLike, *, unit: str = "") -> Array:
    """Return `value` as a float array, refusing anything but finite numbers >= 0."""
    array = np.asarray(value, dtype=float)
    bad = ~(np.isfinite(array) & (array >= 0))
    if bad.any():
        raise InvalidInput(f"{name} = {_shown(array, bad)}: must be finite and not negative{_in(unit)}")
    return array


def positive(name: str, value: float, *, unit: str = "") -> float:
    """Return `value` as a float, refusing anything but a finite number > 0."""
    number = float(value)
    if not (math.isfinite(number) and number > 0):
        raise InvalidInput(f"{name} = {number!r}: must be finite and positive{_in(unit)}")
    return number


def _in(unit: str) -> str:
    return f" [{unit}]" if unit else ""
