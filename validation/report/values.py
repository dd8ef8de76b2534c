"""Single numbers of a dataset as they are said: with their 95 % intervals, and where they stand."""

from __future__ import annotations

import html
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from validation.errors import UsageError
from validation.report.estimates import error_here
from validation.report.quantities import in_prefixed_unit, prefixed_unit, quantity, written_unit
from validation.report.words import significant, with_error
from validation.units import four_digits


@dataclass(frozen=True, kw_only=True, repr=False)
class Value:
    """A number as it is said: with half of its 95 % interval where it has one.

    An `error` of NaN was not measured, None or 0 is that of what is exact, such as a load; `sources` are what
    it holds, where not all that enters was measured. It was read from the variable `name`, `at` a position by
    dimension. `shown_in` are factor and unit of one that its scene wrote with a unit.

    >>> kappa = Value(value=2.1563, error=0.019)
    >>> f"{kappa}, {kappa:%}, {kappa:~}, {kappa:.2f}, {Value(value=0.05)}"
    '2.156 +- 0.019, (215.6 +- 1.9) %, 2.156, 2.16, 0.05'
    >>> Value(value=3.583e-7, error=1.2e-9, name="mean_gap")
    mean gap = (358.3 +- 1.2) nm
    >>> f"{Value(value=2.1563, error=0.019, sources='grid')}"
    '2.156 +- 0.019 (grid)'
    """

    value: float | str
    error: float | None = None
    sources: str = ""
    name: str = ""
    at: Mapping[str, int] | None = None
    shown_in: tuple[float, str] | None = None

    @property
    def unit(self) -> str:
        """SI unit of value and error; "1" for a plain number."""
        return quantity(self.name).unit if self.name else "1"

    def __float__(self) -> float:
        return float(self.value)

    def __repr__(self) -> str:
        if isinstance(self.value, str) or not self.name:
            return f"{self}"
        return f"{quantity(self.name).symbol} = {self:p}"

    def _repr_html_(self) -> str:
        head, said = (html.escape(text) for text in repr(self).rpartition(" = ")[::2])
        return f"<table><tr><th style='text-align:left'>{head}</th><td>{said}</td></tr></table>"

    def __format__(self, spec: str) -> str:
        """Return it in words: ``%`` in per cent, ``+`` with sign, ``~`` without error.

        ``u`` is with prefixed unit and no error, ``p`` with both. With a number, as in ``.2`` or ``+.2%``,
        that many digits and no error.
        """
        if isinstance(self.value, str):
            return self.value
        if "u" in spec:
            if self.shown_in is None:
                return in_prefixed_unit(self.value, quantity(self.name).unit, 3)
            return f"{four_digits(self.value * self.shown_in[0])} {self.shown_in[1]}"
        if "p" in spec:
            factor, unit = self.shown_in or prefixed_unit(self.unit, abs(self.value))
            scaled = Value(value=factor * self.value, error=self.error and factor * self.error)
            text = f"{scaled:{spec.replace('p', '')}}"
            if unit != "1":
                text = f"{text} {unit}" if "(" in text or "+-" not in text else f"({text}) {unit}"
            return f"{text} ({self.sources})" if self.sources else text
        if "." in spec and math.isfinite(self.value):
            if "%" not in spec:
                return f"{self.value:{spec if spec[-1] in 'efg' else spec + 'g'}}"
            text = f"{100 * self.value:{spec.rstrip('%')}g}"
            return (f"{float(text):{'+' * ('+' in spec)}.0f}" if "e+" in text else text) + " %"
        factor, unit = (100.0, " %") if "%" in spec else (1.0, "")
        value = factor * self.value
        sign = "+" if "+" in spec and value > 0 else ""
        if not math.isfinite(value):
            return "not determinable"
        if not self.error:
            digits = 3 if unit else 4
            if value == int(value) and abs(value) < 1e9:  # a count, such as of unknowns
                return f"{sign}{value:.0f}{unit}"
            return f"{sign}{float(f'{value:.{digits}g}'):g}{unit}"
        if not math.isfinite(self.error):
            return f"{sign}{significant(value, 3)}{unit}"
        text = with_error(value, factor * self.error)
        if "~" in spec:
            # (2.10 +- 0.32)e-05 is 2.10e-05.
            number, power = text.partition(" +- ")[0].removeprefix("("), text.partition(")")[2]
            return sign + number + power + unit
        text = f"({sign}{text}){unit}" if unit else sign + text
        return f"{text} ({self.sources})" if self.sources else text

    def as_json(self) -> dict[str, Any]:
        """Return it as data: value, error if it has one, and where it was read."""
        record = {"value": self.value, "error": self.error, "sources": self.sources or None}
        place = {"name": self.name, "at": dict(self.at or {})} if self.name else {}
        return {name: part for name, part in record.items() if part is not None} | place


def known(value: float | str) -> bool:
    """Whether there is a number, or a text that is not empty."""
    return bool(value) if isinstance(value, str) else not math.isnan(value)


def with_places(data: xr.Dataset) -> xr.Dataset:
    """Return a dataset that knows of each number where it stands, however it is sliced.

    >>> import xarray as xr
    >>> data = with_places(xr.Dataset({"area": ("load", [0.1, 0.2])}))
    >>> value_of(data.isel(load=1), "area").at
    {'load': 1}
    """
    return data.assign_coords({f"{_PLACE}{dim}": (dim, np.arange(n)) for dim, n in data.sizes.items()})


def place_of(data: xr.Dataset) -> dict[str, int]:
    """Return the position along each dimension that was sliced away."""
    names = [str(name) for name in data.variables if str(name).startswith(_PLACE)]
    variables = {name.removeprefix(_PLACE): data.variables[name] for name in names}
    places = {dim: int(place) for dim, place in variables.items() if place.ndim == 0}
    return {**data.attrs.get("at", {}), **places}


#: What coordinates begin with that count places.
_PLACE = "_at_"


def value_of(data: xr.Dataset, name: str) -> Value:
    """Return one number of a dataset that has no dimension left there, with its error and where it stands.

    Coordinates, texts and what has no errors are exact.
    """
    variable = data.variables[name]
    if variable.size != 1:
        along = ", ".join(map(str, variable.dims))
        raise UsageError(
            f"{name!r} is no single number here but one along {along}: choose a place, or its mean"
        )
    item = variable.values.item()
    if isinstance(item, str):
        return Value(value=item, name=name, at=place_of(data))
    error, sources = error_here(data, name)
    shown_in = written_unit(variable)
    return Value(
        value=float(item), error=error, sources=sources, name=name, at=place_of(data), shown_in=shown_in
    )


def values_of(data: xr.Dataset, wanted: Callable[[str], bool] = lambda _: True) -> dict[str, Value]:
    """Return all numbers of a dataset without dimensions, by name, or those that are wanted."""
    single = (str(n) for n, v in data.variables.items() if v.ndim == 0 and v.dtype.kind in "fiubUO")
    names = [name for name in single if wanted(name) and not name.startswith(_PLACE)]
    return {name: value_of(data, name) for name in names}
