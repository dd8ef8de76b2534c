"""Checks of arguments at every public door: the name, what was found, what is allowed."""

from __future__ import annotations

import math
import numbers
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike, NDArray

from persson.errors import InvalidInput, OutsideTheory, PerssonError

__all__ = [
    "Array",
    "choice",
    "function",
    "in_proportion",
    "instance",
    "non_negative",
    "poisson_ratio",
    "positive",
    "real",
    "returned",
    "scalar",
    "sequence",
    "shown",
    "together",
    "whole",
    "within",
]

Array = NDArray[np.float64]

#: Sizes of single numbers, in SI units, between which the equations can be evaluated; of squares, their
#: squares. In arrays, where a density falls off, small numbers are let through down to the last.
LEAST, GREATEST, LAST = 1e-30, 1e30, 1e-300


def shown(value: object) -> str:
    """Return a value as it may stand in a message: short, on one line."""
    if isinstance(value, np.ndarray):
        return f"array of shape {value.shape} and type {value.dtype}"
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, int) and abs(value) > 10**20:
        return "a whole number of more than 20 digits"
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."


def _in(unit: str) -> str:
    return f" [{unit}]" if unit else ""


def _number(value: object) -> float | None:
    """Return a real number as a float; None for anything else, booleans and arrays of numbers included."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (numbers.Real, np.floating, np.integer)):
        return None
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _numbers(name: str, value: object, *, unit: str) -> Array:
    """Return real numbers of any shape as doubles; refuse what is masked or no number."""
    if isinstance(value, np.ma.MaskedArray):
        if np.ma.is_masked(value):
            raise InvalidInput(f"{name}: has masked values; fill them or leave them out")
        value = value.data
    try:
        found = np.asarray(value)
        if found.dtype.kind not in "iuf":
            raise TypeError
        return found.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError):
        raise InvalidInput(f"{name} = {shown(value)}: must be real numbers{_in(unit)}") from None


def _bad(value: Array, bad: NDArray[np.bool_]) -> str:
    return repr(float(value[bad].flat[0]) if value.ndim else float(value))


def _computable(array: Array, power: float) -> NDArray[np.bool_]:
    size = np.abs(array)
    return np.asarray((array == 0) | ((size >= LAST) & (size <= GREATEST**power)))


def _sizes(power: float) -> str:
    return f"of a size from {LAST:g} to {GREATEST**power:g}"


def real(name: str, value: ArrayLike, *, unit: str = "", power: float = 1) -> Array:
    """Return `value` as a float array, refusing NaN, infinities and sizes that cannot be computed with."""
    array = _numbers(name, value, unit=unit)
    bad = ~np.isfinite(array)
    if bad.any():
        raise InvalidInput(f"{name} = {_bad(array, bad)}: must be finite{_in(unit)}")
    bad = ~_computable(array, power)
    if bad.any():
        raise InvalidInput(f"{name} = {_bad(array, bad)}: must be zero or {_sizes(power)}{_in(unit)}")
    return array


def non_negative(
    name: str, value: ArrayLike, *, unit: str = "", power: float = 1, vanishing: bool = False
) -> Array:
    """Return `value` as a float array, refusing anything but numbers >= 0 that can be computed with.

    Where they may be `vanishing`, such as the tail of a distribution, no size is too small.
    """
    array = _numbers(name, value, unit=unit)
    bad = ~(np.isfinite(array) & (array >= 0))
    if bad.any():
        raise InvalidInput(f"{name} = {_bad(array, bad)}: must be finite and not negative{_in(unit)}")
    bad = ~_computable(array, power) & ~(vanishing & (array < LAST))
    if bad.any():
        raise InvalidInput(f"{name} = {_bad(array, bad)}: must be zero or {_sizes(power)}{_in(unit)}")
    return array


def positive(name: str, value: object, *, unit: str = "", power: float = 1) -> float:
    """Return `value` as a float, refusing anything but one number > 0 that can be computed with."""
    number = _number(value)
    if number is None or not (math.isfinite(number) and number > 0):
        raise InvalidInput(f"{name} = {shown(value)}: must be finite and positive{_in(unit)}")
    if not LEAST**power <= number <= GREATEST**power:
        raise InvalidInput(
            f"{name} = {number!r}: must be from {LEAST**power:g} to {GREATEST**power:g}{_in(unit)}"
        )
    return number


def within(
    name: str, value: object, low: float, high: float, *, interval: str, unit: str = "", end: str = ""
) -> float:
    """Return one number between two limits; `interval`, "(0, 1]" say, tells which of them belong to it."""
    number = _number(value)
    above = number is not None and (number > low if interval[0] == "(" else number >= low)
    below = number is not None and (number < high if interval[-1] == ")" else number <= high)
    if number is None or not (above and below):
        raise InvalidInput(f"{name} = {shown(value)}: must lie in {interval}{_in(unit)}{end}")
    return number


def poisson_ratio(value: object) -> float:
    """Return a Poisson ratio of a stable solid."""
    return within("poisson", value, -1, 0.5, interval="(-1, 0.5]")


def scalar(name: str, value: object, *, unit: str = "", power: float = 1) -> float:
    """Return one number that is zero or of a size that can be computed with."""
    number = _number(value)
    if number is None:
        raise InvalidInput(f"{name} = {shown(value)}: must be one number{_in(unit)}")
    return float(real(name, number, unit=unit, power=power))


def whole(name: str, value: object, *, least: int, most: int) -> int:
    """Return a whole number between two limits, both included."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)):
        raise InvalidInput(f"{name} = {shown(value)}: must be a whole number from {least} to {most}")
    if not least <= value <= most:
        raise InvalidInput(f"{name} = {shown(value)}: must be a whole number from {least} to {most}")
    return int(value)


def choice(name: str, value: object, allowed: Iterable[str]) -> None:
    """Refuse a word that is not among those allowed."""
    words = [repr(word) for word in allowed]
    if not isinstance(value, str) or repr(value) not in words:
        raise InvalidInput(f"{name} = {shown(value)}: must be {', '.join(words[:-1])} or {words[-1]}")


def instance(name: str, value: object, kind: type, *, what: str) -> None:
    """Refuse what is not of a kind; `what` says in words what it must be."""
    if not isinstance(value, kind) or isinstance(value, type):
        raise InvalidInput(f"{name} = {shown(value)}: must be {what}")


def function(name: str, value: object) -> None:
    """Refuse what cannot be called."""
    if not callable(value):
        raise InvalidInput(f"{name} = {shown(value)}: must be a function")


def sequence(name: str, value: object) -> list[object]:
    """Return what iterates as a list."""
    if isinstance(value, (str, bytes)) or not isinstance(value, Iterable):
        raise InvalidInput(f"{name} = {shown(value)}: must be a sequence")
    if isinstance(value, np.ndarray) and value.ndim != 1:
        raise InvalidInput(f"{name} of shape {value.shape}: must be a sequence")
    return list(value)


def returned(name: str, value: object, shape: tuple[int, ...], *, unit: str = "") -> Array:
    """Return what a caller's function gave as doubles of a shape: not NaN, but infinite where it says so."""
    array = _numbers(name, value, unit=unit)
    try:
        array = np.broadcast_to(array, shape)
    except ValueError:
        raise InvalidInput(f"{name}: gave shape {array.shape} for arguments of shape {shape}") from None
    if np.any(np.isnan(array)):
        raise InvalidInput(f"{name}: gave NaN{_in(unit)}")
    return array


def together(**arrays: Array) -> None:
    """Refuse arrays that do not broadcast with each other."""
    try:
        np.broadcast_shapes(*(array.shape for array in arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise InvalidInput(f"{shapes}: arrays must have one shape, or shapes that broadcast") from None


@contextmanager
def in_proportion() -> Iterator[None]:
    """Let a numerical method that fails on arguments far out of proportion say so in words.

    The arguments have been checked one by one before; what is left are combinations nobody meant.
    """
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore", RuntimeWarning)
            yield
    except PerssonError:
        raise
    except (ArithmeticError, ValueError, IndexError, MemoryError, np.linalg.LinAlgError) as error:
        words = " ".join(str(error).split())
        raise OutsideTheory(
            f"the arguments are too far out of proportion to be computed with ({words}): "
            "check their units and orders of magnitude"
        ) from error
