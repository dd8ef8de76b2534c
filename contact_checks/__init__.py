"""Checks of arguments, for `persson` and `fem_contact` alike: the name, what was found, what is allowed.

Nothing here computes: what passes is returned as it was given, as a double where it is a number.
"""

from __future__ import annotations

import inspect
import math
import numbers
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

__all__ = ["UNITS", "Checks", "in_unit", "shown"]

Array = NDArray[np.float64]

#: Unit of the quantities that have one, by the name of the argument, which is the same in both packages.
UNITS = {
    name: unit
    for unit, names in {
        "Pa": "bulk bulk_young contact_modulus excess hardness ideal_strength layer local_shear_stress loss "
        "mean_pressure mean_pressures moduli nominal peak_pressure pressure relaxed shear_stress storage "
        "stress target_pressure tensile_limit unrelaxed yield_stress young",
        "Pa^2": "stress_variance variance",
        "Pa/m": "stiffness",
        "m": "atomic_distance cell contact_radius contact_size depth depths first_layer gap height heights "
        "length lift mean_gap offset offsets position radii radius range_ reach rms_height separation slip "
        "spacing thickness thicknesses tip_radius wall wavelengths width",
        "1/m": "q q_bend q_gravity q_long q_min q_reference q_short q_upper qx qy wavevector wavevectors",
        "1/m^2": "densities density",
        "J/m^2": "barrier surface_tension work work_of_adhesion",
        "N": "force",
        "K": "temperature",
        "m/s": "velocity",
        "rad": "angle",
        "s": "time time_limit times",
        "1/s": "frequencies frequency",
    }.items()
    for name in names.split()
}


def in_unit(name: str, unit: str | None = None) -> str:
    """Return the unit of a quantity as a message ends with it: that of its name, if none is given."""
    unit = UNITS.get(name, "") if unit is None else unit
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


class Checks:
    """Checks that refuse with an exception of one package.

    Parameters
    ----------
    refusal : type
        The exception.
    least, greatest : float
        Sizes of positive numbers, in SI units, that the package can compute with.
    """

    def __init__(self, refusal: type[Exception], *, least: float, greatest: float) -> None:
        self.refusal, self.least, self.greatest = refusal, least, greatest

    def refused(self, name: str, value: object, allowed: str, unit: str | None = "") -> Exception:
        """Return the exception that says what was found and what is allowed; None is the unit of the name."""
        return self.refusal(f"{name} = {shown(value)}: must be {allowed}{in_unit(name, unit)}")

    def number(self, name: str, value: object, unit: str | None = None) -> float:
        """Return one real number, of whatever size."""
        number = _float(value)
        if number is None:
            raise self.refused(name, value, "one finite number", unit)
        return number

    def positive(self, name: str, value: object, *, unit: str | None = None, power: float = 1) -> float:
        """Return a positive number that can be computed with; `power` is that of the base units in it."""
        number, least, greatest = _float(value), self.least**power, self.greatest**power
        if number is None or not least <= number <= greatest:
            raise self.refused(name, value, f"a positive, finite number from {least:g} to {greatest:g}", unit)
        return number

    def within(
        self, name: str, value: object, interval: str, *, ends: tuple[float, float] | None = None
    ) -> float:
        """Return a number in an interval, "(0, 1]" say; `ends` are its limits where it has words for them."""
        number = _float(value)
        low, high = ends or map(float, interval[1:-1].split(","))
        above = number is not None and (number > low if interval[0] == "(" else number >= low)
        below = number is not None and (number < high if interval[-1] == ")" else number <= high)
        if number is None or not (above and below):
            raise self.refusal(f"{name} = {shown(value)}: must lie in {interval}{in_unit(name)}")
        return number

    def poisson_ratio(self, value: object) -> float:
        """Return a Poisson ratio of a stable solid."""
        return self.within("poisson", value, "(-1, 0.5]")

    def whole(self, name: str, value: object, *, least: int, most: int) -> int:
        """Return a whole number between two limits, both included."""
        number = None if isinstance(value, (bool, np.bool_)) else value
        if not isinstance(number, (int, np.integer)) or not least <= number <= most:
            raise self.refused(name, value, f"a whole number from {least} to {most}")
        return int(number)

    def choice(self, name: str, value: object, allowed: Iterable[str]) -> None:
        """Refuse a word that is not among those allowed."""
        allowed_words = list(allowed)
        if not (isinstance(value, str) and value in allowed_words):
            *others, last = map(repr, allowed_words)
            raise self.refused(name, value, f"{', '.join(others)} or {last}" if others else last)

    def instance(self, name: str, value: object, kind: type | tuple[type, ...], *, what: str = "") -> None:
        """Refuse what is not of a kind; `what` says in words what it must be, by default the kind's name."""
        if isinstance(value, type) or not isinstance(value, kind):
            article = "an" if getattr(kind, "__name__", "")[:1] in "AEIO" else "a"
            raise self.refused(name, value, what or f"{article} `{getattr(kind, '__name__', kind)}`")

    def function(self, name: str, value: object, *, of: tuple[str, ...] = ()) -> None:
        """Refuse what cannot be called with the arguments named."""
        wanted = f"a function of {' and '.join(of)}" if of else "a function"
        if not callable(value):
            raise self.refused(name, value, wanted)
        if of:
            try:
                inspect.signature(value).bind(*of)
            except ValueError:  # compiled functions may tell no signature
                return
            except TypeError:
                raise self.refused(name, value, wanted) from None

    def numbers_of(self, name: str, value: object, *, unit: str | None = None) -> list[object]:
        """Return what iterates over single numbers as a list; each is still to be checked."""
        if isinstance(value, (str, bytes)) or not isinstance(value, Iterable):
            raise self.refused(name, value, "a sequence of numbers", unit)
        if isinstance(value, np.ndarray) and value.ndim != 1:
            raise self.refusal(
                f"{name} of shape {value.shape}: must be a sequence of numbers{in_unit(name, unit)}"
            )
        return list(value)

    def positive_fields(self, owner: object, *names: str) -> None:
        """Refuse an object whose attributes of these names are not all positive numbers."""
        for name in names:
            self.positive(name, getattr(owner, name))

    def positives(self, name: str, value: object, *, unit: str | None = None) -> list[float]:
        """Return what iterates over positive numbers as a list of them."""
        return [self.positive(name, number, unit=unit) for number in self.numbers_of(name, value, unit=unit)]

    def doubles(self, name: str, value: object, *, unit: str | None = None) -> Array:
        """Return real numbers of any shape as doubles, NaN included; refuse masked points and no numbers.

        The array is the caller's own where it already holds doubles.
        """
        if isinstance(value, np.ma.MaskedArray):
            missing = int(np.count_nonzero(np.ma.getmaskarray(value)))
            if missing:
                raise self.refusal(
                    f"{name}: {missing} of {value.size} points are masked: "
                    "fill them (.filled) or cut them off"
                )
            value = value.data
        try:
            array = np.asarray(value)
            if array.dtype.kind not in "iuf":
                raise TypeError
            return array.astype(np.float64, copy=False)
        except (TypeError, ValueError, OverflowError) as error:
            raise self.refused(name, value, "real numbers", unit) from error

    def alike(self, **arrays: Array) -> None:
        """Refuse arrays that do not broadcast with each other."""
        try:
            np.broadcast_shapes(*(values.shape for values in arrays.values()))
        except ValueError:
            shapes = ", ".join(f"{name} {values.shape}" for name, values in arrays.items())
            raise self.refusal(f"{shapes}: arrays must have one shape, or shapes that broadcast") from None
