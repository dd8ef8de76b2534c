"""Checks of arguments at every public door: the name, what was found, what is allowed."""

from collections.abc import Callable, Iterable
from typing import TypeVar

import numpy as np

from contact_checks import Checks, in_unit
from contact_checks import shown as shown
from fem_contact._types import Array, Shape
from fem_contact.errors import InsufficientMemory, InvalidInput

_T = TypeVar("_T")
#: Sizes of numbers, in SI units, between which squares neither vanish nor products of squares overflow.
LEAST, GREATEST = 1e-120, 1e30

_CHECKS = Checks(InvalidInput, least=LEAST, greatest=GREATEST)
alike, choice, doubles, function = _CHECKS.alike, _CHECKS.choice, _CHECKS.doubles, _CHECKS.function
instance, numbers_of, poisson_ratio = _CHECKS.instance, _CHECKS.numbers_of, _CHECKS.poisson_ratio
positive, positives, positive_fields = _CHECKS.positive, _CHECKS.positives, _CHECKS.positive_fields
whole, within = _CHECKS.whole, _CHECKS.within


def finite(name: str, value: object) -> float:
    """Return a number that is zero or of a size that can be computed with."""
    number = _CHECKS.number(name, value)
    if number != 0 and not LEAST <= abs(number) <= GREATEST:
        allowed = f"finite, and zero or of a size from {LEAST:g} to {GREATEST:g}"
        raise _CHECKS.refused(name, value, allowed, None)
    return number


def non_negative(name: str, value: object) -> float:
    """Return a number that is zero, or positive and of a size that can be computed with."""
    number = _CHECKS.number(name, value)
    if not (number == 0 or LEAST <= number <= GREATEST):
        allowed = f"zero or a positive, finite number (at most {GREATEST:g})"
        raise _CHECKS.refused(name, value, allowed, None)
    return number


def array(name: str, value: object, *, unit: str | None = None, power: float = 1) -> Array:
    """Return real, finite numbers of any shape as doubles; `power` is that of the base units in them."""
    values = doubles(name, value, unit=unit)
    bad = ~np.isfinite(values)
    bad |= np.abs(values, where=~bad, out=np.zeros(values.shape)) > GREATEST**power
    if bad.any():
        raise InvalidInput(
            f"{name}: {np.count_nonzero(bad)} of {values.size} values are not finite or larger than "
            f"{GREATEST**power:g} (the first is {shown(values[bad].flat[0])}): "
            f"fill or remove them{in_unit(name, unit)}"
        )
    return values


def shape_of(name: str, value: object) -> tuple[int, ...]:
    """Return the shape of what is to be an array, whatever it holds."""
    try:
        return tuple(np.asarray(value).shape)
    except ValueError:
        raise _CHECKS.refused(name, value, "an array of numbers") from None


def field(name: str, value: object, shape: Shape, *, unit: str | None = None) -> Array:
    """Return real numbers on a grid of that shape as doubles."""
    values = array(name, value, unit=unit)
    if values.shape != shape:
        raise InvalidInput(f"{name} of shape {values.shape}: must have the shape {shape} of the grid")
    return values


def bound(name: str, value: object, shape: Shape | None = None) -> Array:
    """Return a pressure bound [Pa], one or one for each point of a grid, all positive."""
    values = array(name, value, unit="Pa")
    if shape is not None and values.ndim > 0 and values.shape != shape:
        raise InvalidInput(f"{name} of shape {values.shape}: must be one pressure or of shape {shape}")
    if values.size == 0 or not np.all(values >= LEAST):
        raise InvalidInput(f"{name}: must be positive and finite everywhere, at least {LEAST:g} Pa")
    return values


def mask(name: str, value: object) -> None:
    """Refuse what is no map of bool (nx, ny)."""
    if not (isinstance(value, np.ndarray) and value.dtype == np.bool_):
        raise InvalidInput(f"{name} = {shown(value)}: must be an array of bool (nx, ny)")
    if value.ndim != 2 or value.size == 0:
        raise InvalidInput(f"{name} of shape {value.shape}: must be a two-dimensional map (nx, ny)")


def pressures(name: str, value: object, shape: Shape) -> Array:
    """Return pressures [Pa] on a grid, none negative and not all zero."""
    values = field(name, value, shape, unit="Pa")
    if values.min() < 0 or not np.mean(values) > LEAST:
        raise InvalidInput(f"{name}: must be pressures in Pa, none negative, not all zero")
    return values


def samples(name: str, value: object, *, least: int = 1) -> Array:
    """Return a sequence of real numbers as a one-dimensional array of doubles."""
    if isinstance(value, Iterable) and not isinstance(value, (str, bytes, np.ndarray)):
        value = list(value)
    values = array(name, value)
    if values.ndim != 1 or values.size < least:
        raise InvalidInput(f"{name} of shape {values.shape}: must be a sequence of at least {least} numbers")
    return values


def pair(name: str, value: object, check: Callable[[str, object], _T], *, what: str) -> tuple[_T, _T]:
    """Return the two members of a pair as a check returns them; what it refuses must be `what`."""
    if isinstance(value, (tuple, list, np.ndarray)) and len(np.shape(np.asarray(value, dtype=object))) == 1:
        members = list(value)
        if len(members) == 2:
            try:
                return check(name, members[0]), check(name, members[1])
            except InvalidInput:
                pass
    raise InvalidInput(f"{name} = {shown(value)}: must be {what}")


def only(**given: _T | None) -> tuple[str, _T]:
    """Return name and value of the one argument that is given, or refuse."""
    named = [(name, value) for name, value in given.items() if value is not None]
    if len(named) != 1:
        raise InvalidInput(f"{', '.join(given)}: give exactly one of them")
    return named[0]


def truth(name: str, value: object) -> None:
    """Refuse what is neither true nor false."""
    instance(name, value, (bool, np.bool_), what="True or False")


def listed(name: str, value: object, kind: type, *, what: str) -> None:
    """Refuse what is not a sequence of one kind of things."""
    if not isinstance(value, (list, tuple)) or not all(isinstance(item, kind) for item in value):
        raise InvalidInput(f"{name} = {shown(value)}: must be a list of {what}")


def room_for(what: str, *, needed: float, remedy: str = "take fewer points") -> None:
    """Refuse what takes more memory [bytes] than is available, before anything is allocated."""
    import psutil

    available = psutil.virtual_memory().available
    if needed > available:
        raise InsufficientMemory(
            f"{what}: needs about {needed / 2**30:.3g} GiB, {available / 2**30:.3g} GiB are available: "
            f"{remedy}"
        )
