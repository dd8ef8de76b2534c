"""Checks of arguments at every public door: the name, what was found, what is allowed."""

from __future__ import annotations

import inspect
import math
import numbers
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from fem_contact.errors import InsufficientMemory, InvalidInput

__all__ = [
    "GREATEST",
    "LEAST",
    "alike",
    "array",
    "choice",
    "doubles",
    "field",
    "finite",
    "function",
    "instance",
    "listed",
    "non_negative",
    "numbers_of",
    "pair",
    "positive",
    "room_for",
    "samples",
    "shape_of",
    "shown",
    "truth",
    "whole",
    "within",
]

Array = NDArray[np.float64]

#: Sizes of numbers, in SI units, between which squares neither vanish nor products of squares overflow.
LEAST, GREATEST = 1e-120, 1e30


def _in(unit: str) -> str:
    return f" in {unit}" if unit else ""


def shown(value: object) -> str:
    """Return a value as it may stand in a message: short, on one line."""
    if isinstance(value, np.ndarray):
        return f"array of shape {value.shape} and type {value.dtype}"
    if isinstance(value, int) and abs(value) > 10**20:
        return "a whole number of more than 20 digits"
    text = repr(float(value)) if isinstance(value, (float, np.floating)) else repr(value)
    text = " ".join(text.split())
    return text if len(text) <= 60 else text[:57] + "..."


def _float(value: object) -> float | None:
    """Return a real number as a float; None for anything else, booleans and arrays of numbers included."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (numbers.Real, np.floating, np.integer)):
        return None
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _refused(name: str, value: object, allowed: str, unit: str = "") -> InvalidInput:
    return InvalidInput(f"{name} = {shown(value)}: must be {allowed}{_in(unit)}")


def finite(name: str, value: object, *, unit: str = "") -> float:
    """Return a number that is zero or of a size that can be computed with."""
    number = _float(value)
    if number is None:
        raise _refused(name, value, "one finite number", unit)
    if number != 0 and not LEAST <= abs(number) <= GREATEST:
        raise _refused(name, value, f"finite, and zero or of a size from {LEAST:g} to {GREATEST:g}", unit)
    return number


def positive(name: str, value: object, *, unit: str = "") -> float:
    """Return a number that is positive and of a size that can be computed with."""
    number = _float(value)
    if number is None or not LEAST <= number <= GREATEST:
        raise _refused(name, value, f"a positive, finite number from {LEAST:g} to {GREATEST:g}", unit)
    return number


def non_negative(name: str, value: object, *, unit: str = "") -> float:
    """Return a number that is zero, or positive and of a size that can be computed with."""
    number = _float(value)
    if number is None or not (number == 0 or LEAST <= number <= GREATEST):
        raise _refused(name, value, f"zero or a positive, finite number (at most {GREATEST:g})", unit)
    return number


def within(name: str, value: object, low: float, high: float, *, interval: str, unit: str = "") -> float:
    """Return a number between two limits; `interval`, "(0, 1]" say, tells which of them belong to it."""
    number = _float(value)
    above = number is not None and (number > low if interval[0] == "(" else number >= low)
    below = number is not None and (number < high if interval[-1] == ")" else number <= high)
    if number is None or not (above and below):
        raise InvalidInput(f"{name} = {shown(value)}: must lie in {interval}{_in(unit)}")
    return number


def whole(name: str, value: object, *, least: int, most: int) -> int:
    """Return a whole number between two limits, both included."""
    number = None if isinstance(value, (bool, np.bool_)) else value
    if not isinstance(number, (int, np.integer)) or not least <= number <= most:
        raise _refused(name, value, f"a whole number from {least} to {most}")
    return int(number)


def choice(name: str, value: object, allowed: Iterable[str]) -> None:
    """Refuse a word that is not among those allowed."""
    words = list(allowed)
    if not (isinstance(value, str) and value in words):
        listed = ", ".join(repr(word) for word in words[:-1]) + f" or {words[-1]!r}"
        raise _refused(name, value, listed)


def instance(name: str, value: object, kind: type | tuple[type, ...], *, what: str) -> None:
    """Refuse what is not of a kind; `what` says in words what it must be."""
    if isinstance(value, type) or not isinstance(value, kind):
        raise InvalidInput(f"{name} = {shown(value)}: must be {what}")


def doubles(name: str, value: object, *, unit: str = "") -> Array:
    """Return real numbers of any shape as doubles, NaN included; refuse masked points and what is no number.

    The array is the caller's own where it already holds doubles.
    """
    if isinstance(value, np.ma.MaskedArray):
        if np.ma.is_masked(value):
            missing = int(np.count_nonzero(np.ma.getmaskarray(value)))
            raise InvalidInput(
                f"{name}: {missing} of {value.size} points are masked: fill them (.filled) or cut them off"
            )
        value = value.data
    try:
        found = np.asarray(value)
        if found.dtype.kind not in "iuf":
            raise TypeError
        return found.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError) as error:
        raise _refused(name, value, "real numbers", unit) from error


def array(name: str, value: object, *, unit: str = "", power: float = 1) -> Array:
    """Return real, finite numbers of any shape as doubles; `power` is that of the base units in them."""
    values = doubles(name, value, unit=unit)
    bad = ~np.isfinite(values)
    bad |= np.abs(values, where=~bad, out=np.zeros(values.shape)) > GREATEST**power
    if bad.any():
        raise InvalidInput(
            f"{name}: {np.count_nonzero(bad)} of {values.size} values are not finite or larger than "
            f"{GREATEST**power:g} (the first is {shown(values[bad].flat[0])}): fill or remove them{_in(unit)}"
        )
    return values


def shape_of(name: str, value: object) -> tuple[int, ...]:
    """Return the shape of what is to be an array, whatever it holds."""
    try:
        return tuple(np.asarray(value).shape)
    except ValueError:
        raise _refused(name, value, "an array of numbers") from None


def field(name: str, value: object, shape: tuple[int, int], *, unit: str = "") -> Array:
    """Return real numbers on a grid of that shape as doubles."""
    values = array(name, value, unit=unit)
    if values.shape != shape:
        raise InvalidInput(f"{name} of shape {values.shape}: must have the shape {shape} of the grid")
    return values


def samples(name: str, value: object, *, least: int = 1, unit: str = "") -> Array:
    """Return a sequence of real numbers as a one-dimensional array of doubles."""
    if isinstance(value, Iterable) and not isinstance(value, (str, bytes, np.ndarray)):
        value = list(value)
    values = array(name, value, unit=unit)
    if values.ndim != 1 or values.size < least:
        raise InvalidInput(f"{name} of shape {values.shape}: must be a sequence of at least {least} numbers")
    return values


def pair(name: str, value: object, *, what: str) -> tuple[object, object]:
    """Return the two members of a pair, each still to be checked."""
    if isinstance(value, (tuple, list, np.ndarray)) and len(np.shape(np.asarray(value, dtype=object))) == 1:
        found = list(value)
        if len(found) == 2:
            return found[0], found[1]
    raise InvalidInput(f"{name} = {shown(value)}: must be {what}")


def truth(name: str, value: object) -> None:
    """Refuse what is neither true nor false."""
    instance(name, value, (bool, np.bool_), what="True or False")


def listed(name: str, value: object, kind: type, *, what: str) -> None:
    """Refuse what is not a sequence of one kind of things."""
    if not isinstance(value, (list, tuple)) or not all(isinstance(item, kind) for item in value):
        raise InvalidInput(f"{name} = {shown(value)}: must be a list of {what}")


def function(name: str, value: object, *, of: tuple[str, ...] = ()) -> None:
    """Refuse what cannot be called with the arguments named."""
    wanted = f"a function of {' and '.join(of)}" if of else "a function"
    if not callable(value):
        raise InvalidInput(f"{name} = {shown(value)}: must be {wanted}")
    if of:
        try:
            inspect.signature(value).bind(*of)
        except ValueError:  # compiled functions may tell no signature
            return
        except TypeError:
            raise InvalidInput(f"{name} = {shown(value)}: must be {wanted}") from None


def alike(**arrays: Array) -> None:
    """Refuse arrays that do not broadcast with each other."""
    try:
        np.broadcast_shapes(*(values.shape for values in arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {values.shape}" for name, values in arrays.items())
        raise InvalidInput(f"{shapes}: arrays must have one shape, or shapes that broadcast") from None


def numbers_of(name: str, value: object, *, unit: str = "") -> list[object]:
    """Return what iterates over single numbers as a list; each is still to be checked."""
    if isinstance(value, (str, bytes)) or not isinstance(value, Iterable):
        raise _refused(name, value, "a sequence of numbers", unit)
    if isinstance(value, np.ndarray) and value.ndim != 1:
        raise InvalidInput(f"{name} of shape {value.shape}: must be a sequence of numbers{_in(unit)}")
    return list(value)


def room_for(name: str, value: object, *, needed: float) -> None:
    """Refuse what takes more memory [bytes] than is available, before anything is allocated."""
    import psutil

    available = psutil.virtual_memory().available
    if needed > available:
        raise InsufficientMemory(
            f"{name} = {shown(value)}: needs about {needed / 2**30:.3g} GiB, {available / 2**30:.3g} GiB are "
            "available: take fewer points"
        )
