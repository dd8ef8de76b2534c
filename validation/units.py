"""Values of a scene: numbers with units, converted once to SI, and tables that refuse unknown keys."""

from __future__ import annotations

import difflib
import functools
import re
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

if TYPE_CHECKING:
    import pint

__all__ = [
    "Duration",
    "Grid",
    "Grids",
    "Length",
    "Lengths",
    "Memory",
    "Number",
    "Positive",
    "Pressure",
    "Table",
    "Temperature",
    "Tension",
    "Work",
    "exactly_one",
    "quantity",
    "unit_registry",
    "wrong",
]

_QUANTITY = re.compile(
    r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\d\s][^\s]*(?:\s+[^\d\s][^\s]*)*)?\s*"
)


def wrong(message: str) -> PydanticCustomError:
    """Return the error that says this of a value."""
    return PydanticCustomError("scene", "{message}", {"message": message})


def quantity(unit: str, kind: str, example: str) -> BeforeValidator:
    """Read a number with a unit ("0.5 um") or a bare number in SI, and convert it once."""

    def convert(value: object) -> float:
        allowed = f'must be a {kind} such as "{example}", or a number in {unit}'
        if isinstance(value, bool) or not isinstance(value, (int, float, str)):
            raise wrong(allowed)
        if not isinstance(value, str):
            return float(value)
        found = _QUANTITY.fullmatch(value)
        if found is None:
            raise wrong(allowed)
        number, symbol = found[1], found[2]
        if symbol is None:
            raise wrong(f"has no unit; {allowed} without quotes")
        import pint

        try:
            return float(unit_registry().Quantity(Fraction(number), symbol).to(unit).magnitude)
        except pint.DimensionalityError:
            raise wrong(f"is not a {kind}; {allowed}") from None
        except Exception:  # the parser of unit names raises whatever its tokens lead to
            raise wrong(f"has an unknown unit; {allowed}") from None

    return BeforeValidator(convert)


Length = Annotated[float, quantity("m", "length", "0.5 um"), Field(gt=0)]
Pressure = Annotated[float, quantity("Pa", "pressure", "10 MPa"), Field(gt=0)]
Work = Annotated[float, quantity("J/m^2", "work of adhesion", "50 mJ/m^2"), Field(gt=0)]
Tension = Annotated[float, quantity("J/m^2", "surface tension", "0.04 J/m^2"), Field(gt=0)]
Temperature = Annotated[float, quantity("K", "temperature", "370 K"), Field(gt=0)]
Memory = Annotated[float, quantity("byte", "memory size", "4 GiB"), Field(ge=1)]
Duration = Annotated[float, quantity("s", "time", "10 min"), Field(gt=0)]
Number = Annotated[float, Field(strict=True)]
Positive = Annotated[float, Field(gt=0)]


@functools.cache
def unit_registry() -> pint.UnitRegistry[Fraction]:
    """Return the unit registry, built on the first unit read; exact, so that "100 um" is 1e-4."""
    import pint

    return pint.UnitRegistry(non_int_type=Fraction)


def pair_of(value: object) -> object:
    """Return a pair; a single value stands for both."""
    return [value, value] if not isinstance(value, (list, tuple)) else value


def grid_of(value: object) -> object:
    """Return a pair of whole numbers of points; a single one stands for both."""
    pair = pair_of(value)
    if not (
        isinstance(pair, (list, tuple)) and len(pair) == 2 and all(type(n) is int and n >= 2 for n in pair)
    ):
        raise wrong("must be a whole number of points n >= 2, or [nx, ny]")
    return pair


def grids_of(value: object) -> object:
    """Return a list of grids; a single number is refused, for it is read elsewhere as one grid."""
    if isinstance(value, (list, tuple)):
        return value
    listed = f"[{value}]" if type(value) is int else "[32, 64]"
    raise wrong(f"must be a list of grids such as {listed}")


Grid = Annotated[tuple[int, int], BeforeValidator(grid_of)]
Grids = Annotated[tuple[Grid, ...], BeforeValidator(grids_of)]
Lengths = Annotated[tuple[Length, Length], BeforeValidator(pair_of)]


class Table(BaseModel):
    """A table of the scene file: unknown keys are errors that name the known ones."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _only_known_keys(cls, data: object) -> object:
        if isinstance(data, dict):
            for key in data:
                if key not in cls.model_fields:
                    close = difflib.get_close_matches(str(key), cls.model_fields, n=1)
                    hint = f"; did you mean {close[0]!r}?" if close else ""
                    raise wrong(f"unknown key {key!r}{hint} Allowed: {', '.join(cls.model_fields)}")
        return data


def exactly_one(table: BaseModel, names: tuple[str, str]) -> None:
    """Refuse a table with none or both of two keys."""
    given = [name for name in names if getattr(table, name) is not None]
    if len(given) != 1:
        raise wrong(
            f"give exactly one of {names[0]!r} and {names[1]!r}; found {' and '.join(given) or 'neither'}"
        )
