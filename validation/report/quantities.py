"""The one registry of quantities: symbol, unit and words of all that a dataset, axis, column or legend names.

`quantities.toml` beside this file holds it. A variable is called by a quantity, then by what tells it from
its like (``kappa_pixel``: kappa, counted), then by what it is of it (``_each``: of each surface, ``_error``:
its 95 % interval).
"""

from __future__ import annotations

import contextlib
import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from validation.errors import UsageError
from validation.units import four_digits

if TYPE_CHECKING:
    import xarray as xr

#: Engineering prefixes by power of a thousand, for units that take them.
_PREFIXES = {-4: "p", -3: "n", -2: "u", -1: "m", 0: "", 1: "k", 2: "M", 3: "G"}
#: Coordinates whose texts are names of solvers and theories.
_NAMING = ("leg", "method", "other", "solver", "theory")
_PREFIXED = ("m", "Pa", "s", "J", "N", "W", "V", "Ohm", "m/s", "J/m^2", "Pa m", "byte")


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """What a variable is: symbol as it is typed (`validation.report.words` sets it), meaning, SI unit or "1".

    `which` tells it from its like, such as "counted" or "Persson", and is empty for the thing itself; `look`
    is how it is drawn wherever it is drawn. Where it is `linear` its axis is, whatever it spans, and no power
    of it a law.
    """

    name: str
    symbol: str
    words: str
    unit: str = "1"
    which: str = ""
    look: Mapping[str, Any]
    linear: bool = False

    @property
    def title(self) -> str:
        """Symbol, what tells it apart, and unit: the title of a column."""
        unit = "" if self.unit == "1" else f" [{self.unit}]"
        return f"{self.symbol}{', ' if self.which else ''}{self.which}{unit}"

    @property
    def meaning(self) -> str:
        """The same in words."""
        return self.words + (f", {self.which}" if self.which else "")


@cache
def registry() -> Mapping[str, Mapping[str, Any]]:
    """Return the tables of the registry: ``quantities`` and ``qualifiers``."""
    return tomllib.loads(resources.files(__package__).joinpath("quantities.toml").read_text(encoding="utf-8"))


@cache
def quantity(name: str) -> Quantity:
    """Return what a variable of this name is.

    A UsageError for a name that does not stand in the registry.

    >>> quantity("kappa_pixel").title, quantity("reduced_pressure").symbol
    ('kappa, counted', 'p*')
    """
    tables = registry()
    known, qualifiers = tables["quantities"], tables["qualifiers"]
    parts = name.split("_")
    for cut in range(len(parts), 0, -1):
        start = "_".join(parts[:cut])
        qualified = _qualifiers("_".join(parts[cut:]), qualifiers) if start in known else None
        if qualified is not None:
            named = [qualifiers[qualifier] for qualifier in qualified]
            look = {key: value for one in named for key, value in one.get("look", {}).items()}
            which = ", ".join(one["words"] for one in named)
            return Quantity(name=start, which=which, look=look, **known[start])
    raise UsageError(
        f"{name!r}: no such quantity in docs/glossary.md; add it to validation/report/quantities.toml"
    )


def quantity_of(data: xr.Dataset, name: str) -> Quantity:
    """Return what a variable is: as the registry has it, or as a swept key of a scene says of itself.

    A UsageError for a name that neither knows.
    """
    attrs = data[name].attrs if name in data.variables else {}
    if "key" not in attrs:
        return quantity(name)
    with contextlib.suppress(UsageError):
        if (registered := quantity(name)).unit == attrs["units"]:
            return registered
    about = {"words": attrs["long_name"], "unit": attrs["units"]}
    return Quantity(name=name, symbol=name.replace("_", " "), look={}, **about)


def _qualifiers(text: str, known: Mapping[str, Any]) -> list[str] | None:
    """Split what follows a quantity into qualifiers, longest first; None where that cannot be done."""
    if not text:
        return []
    for name in sorted(known, key=len, reverse=True):
        if text == name or text.startswith(f"{name}_"):
            rest = _qualifiers(text[len(name) + 1 :], known)
            if rest is not None:
                return [name, *rest]
    return None


def labelled(data: xr.Dataset, written: Mapping[str, Any] = MappingProxyType({})) -> xr.Dataset:
    """Return a dataset whose variables have ``long_name`` and ``units`` of the registry.

    What `written` has with a unit is shown in that unit. A UsageError for a variable whose name does not
    stand in the registry.
    """
    data = data.copy()
    for name in data.variables:
        if str(name).startswith(("source", "solve")) or (name in data.dims and data[name].dtype.kind in "OU"):
            continue
        what = quantity_of(data, str(name))
        data[name].attrs |= {"long_name": what.meaning, "units": what.unit}
        if (given := written.get(str(name))) and hasattr(given, "written"):
            data[name].attrs["written_in"], data[name].attrs["written_unit"] = given.unit
    return data


def written_unit(variable: xr.DataArray | xr.Variable) -> tuple[float, str] | None:
    """Return factor and unit of a variable that is shown as its scene was written."""
    attrs = variable.attrs
    if not {"written_in", "written_unit"} <= set(attrs):
        return None  # or what is not alike in all of several is gone
    return 1 / float(attrs["written_unit"]), str(attrs["written_in"])


def in_shown_unit(number: xr.DataArray, unit: str = "") -> str:
    """Return one number of a dataset with four digits, in the unit in which it is shown.

    Its SI unit is that of the registry, unless it is given.
    """
    value = float(number)
    unit = unit or quantity(str(number.name)).unit
    factor, unit = written_unit(number) or prefixed_unit(unit, abs(value))
    return four_digits(value * factor) + ("" if unit == "1" else f" {unit}")


def in_shown_range(numbers: xr.DataArray) -> str:
    """Return the least and the largest of several, or the one number where they are alike."""
    ends = numbers.min(keep_attrs=True), numbers.max(keep_attrs=True)
    return " to ".join(dict.fromkeys(map(in_shown_unit, ends)))


def prefixed_unit(unit: str, largest: float) -> tuple[float, str]:
    """Return a factor and an engineering unit in which a number of this size is read well.

    >>> prefixed_unit("m", 3e-6), prefixed_unit("1/m", 4e7), prefixed_unit("1/m^2", 9e13)
    ((1000000.0, 'um'), (1e-06, '1/um'), (1e-12, '1/um^2'))
    """
    if unit not in (*_PREFIXED, "1/m", "m^2", "1/m^2") or not 0 < largest < math.inf:
        return 1.0, unit
    if unit in ("m^2", "1/m^2"):
        factor, named = prefixed_unit(unit.removesuffix("^2"), math.sqrt(largest))
        return factor**2, f"{named}^2"
    power = math.floor(math.log10(largest) / 3 + 1e-9)
    if unit == "1/m":
        power = min(max(power, 0), 3)
        return 1000.0**-power, f"1/{_PREFIXES[-power]}m"
    power = min(max(power, -4), 3)
    return 1000.0**-power, _PREFIXES[power] + unit


def in_prefixed_unit(value: float, unit: str, digits: int = 4) -> str:
    """Return a number with its unit, prefixed: ``0.5684 MPa``; a quantity of a scene as it was written.

    >>> in_prefixed_unit(5.684e6, "Pa")
    '5.684 MPa'
    """
    if written := getattr(value, "written", ""):
        return str(written)
    factor, named = prefixed_unit(unit, abs(value))
    return f"{value * factor:.{digits}g}" + ("" if unit == "1" else f" {named}")


def as_length(metres: float, digits: int = 6) -> str:
    """Return a length in metres as one reads it: ``12.5 um``."""
    return in_prefixed_unit(metres, "m", digits)


def named_at(here: xr.Dataset, name: str) -> Mapping[str, Any]:
    """Return words and look of the solver or theory that a coordinate names; nothing of other coordinates."""
    known = dict(registry()["qualifiers"].get(str(here[name].item()) if name in _NAMING else "", {}))
    # A solver that is called as a qualifier of something else has words of its own.
    return {**known, "words": known["solver"]} if "solver" in known else known


def place_words(here: xr.Dataset, dim: str, data: xr.Dataset) -> str:
    """Say where one is along a dimension: its coordinate, ``p* = 0.05``.

    The coordinate is that of its name, or else the first along it.
    """
    along = (str(n) for n, c in data.coords.items() if c.dims == (dim,) and not str(n).startswith("_"))
    name = dim if dim in data.coords else next(along, "")
    if not name:
        return ""
    place = here[name]
    if isinstance(place.item(), str):
        return str(named_at(here, name).get("words", place.item()))
    what = quantity_of(data, name)
    return f"{what.symbol} = {in_shown_unit(place, what.unit)}"
