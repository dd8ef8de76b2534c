"""Checks of arguments at every public door: the name, what was found, what is allowed."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contact_checks import Checks, in_unit
from contact_checks import shown as shown
from persson.errors import InvalidInput, OutsideTheory, PerssonError

Array = NDArray[np.float64]

#: Sizes of single numbers, in SI units, between which the equations can be evaluated; of squares, their
#: squares. In arrays, where a density falls off, small numbers are let through down to the last.
LEAST, GREATEST, LAST = 1e-30, 1e30, 1e-300

_CHECKS = Checks(InvalidInput, least=LEAST, greatest=GREATEST)
alike, choice, function, instance = _CHECKS.alike, _CHECKS.choice, _CHECKS.function, _CHECKS.instance
numbers_of, poisson_ratio, positive = _CHECKS.numbers_of, _CHECKS.poisson_ratio, _CHECKS.positive
positives, positive_fields = _CHECKS.positives, _CHECKS.positive_fields
whole, within = _CHECKS.whole, _CHECKS.within


def real(name: str, value: ArrayLike, *, unit: str | None = None, power: float = 1) -> Array:
    """Return `value` as a float array, refusing NaN, infinities and sizes that cannot be computed with."""
    return _sized(name, value, unit=unit, power=power, signed=True, vanishing=False)


def non_negative(
    name: str,
    value: ArrayLike,
    *,
    unit: str | None = None,
    power: float = 1,
    vanishing: bool = False,
    zero: str = "",
) -> Array:
    """Return `value` as a float array, refusing anything but numbers >= 0 that can be computed with.

    Where they may be `vanishing`, such as the tail of a distribution, no size is too small. Where `zero` says
    why, 0 is refused, too.
    """
    array = _sized(name, value, unit=unit, power=power, signed=False, vanishing=vanishing)
    if zero and np.any(array == 0):
        raise InvalidInput(f"{name} = 0: {zero}")
    return array


def _sized(
    name: str, value: ArrayLike, *, unit: str | None, power: float, signed: bool, vanishing: bool
) -> Array:
    array = _CHECKS.doubles(name, value, unit=unit)
    size = np.abs(array)
    fine = np.isfinite(array) & (signed | (array >= 0))
    computable = (array == 0) | ((size >= LAST) & (size <= GREATEST**power)) | (vanishing & (array < LAST))
    good = fine & computable
    if good.all():
        return array
    what = "finite" if signed else "finite and not negative"
    if fine.all():
        what, fine = f"zero or of a size from {LAST:g} to {GREATEST**power:g}", computable
    raise InvalidInput(f"{name} = {float(array[~fine].flat[0])!r}: must be {what}{in_unit(name, unit)}")


def scalar(name: str, value: object, *, unit: str | None = None, power: float = 1) -> float:
    """Return one number that is zero or of a size that can be computed with."""
    return float(real(name, _CHECKS.number(name, value, unit), unit=unit, power=power))


def returned(name: str, value: object, shape: tuple[int, ...], *, unit: str) -> Array:
    """Return what a caller's function gave as doubles of a shape: not NaN, but infinite where it says so.

    >>> returned("f(x)", 2.0, (2,), unit="Pa")
    array([2., 2.])
    """
    array = _CHECKS.doubles(name, value, unit=unit)
    try:
        array = np.broadcast_to(array, shape)
    except ValueError:
        raise InvalidInput(f"{name}: gave shape {array.shape} for arguments of shape {shape}") from None
    if np.any(np.isnan(array)):
        raise InvalidInput(f"{name}: gave NaN{in_unit(name, unit)}")
    return array


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
        reason = " ".join(str(error).split())
        raise OutsideTheory(
            f"the arguments are too far out of proportion to be computed with ({reason}): "
            "check their units and orders of magnitude"
        ) from error
