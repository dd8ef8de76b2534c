"""Values of a scene: numbers with units, converted once to SI, and tables that refuse unknown keys."""

from __future__ import annotations

import functools
import math
import re
import typing
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    WrapValidator,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from validation.errors import UsageError, did_you_mean

if TYPE_CHECKING:
    import pint

#: Sizes of quantities in SI that are computed with: their fourth powers and products stay numbers.
SMALLEST, LARGEST = 1e-30, 1e30
#: Points along a side of a grid; no machine holds more on both sides.
MOST_POINTS = 2**17
#: Grids, or items of another list, in one scene.
MOST_ITEMS = 256

_LONGEST = 100
_QUANTITY = re.compile(
    r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?)\s*([^\d\s][^\s]*(?:\s+[^\d\s][^\s]*)*)?\s*"
)
#: Units that most scenes name, over SI: read without the registry of all units, which takes half a second
#: to load.
_PLAIN = {
    unit: {
        prefix + unit: Fraction(10) ** power
        for prefix, power in {"n": -9, "u": -6, "m": -3, "": 0, "k": 3, "M": 6, "G": 9}.items()
    }
    for unit in ("m", "Pa", "N")
}
#: An example in a description: a text, a list or a number.
_EXAMPLE = re.compile(r"e\.g\. (\"[^\"]*\"|\[[^\]]*\]|-?[\d.]+(?:e-?\d+)?)")
_LETTER = "[^\\W⁰¹²³⁴-⁹]"
_NAME = rf"(?!(?:square|squared|sq|cubic|cubed)(?!{_LETTER}))(?![\d_]){_LETTER}++|[%°]\w*+|1(?![\w.])"
_POWER = r"(?:\*\*|\^)\s*+[-+]?\d{1,2}(?![\w.])|⁻?[⁰¹²³⁴-⁹]{1,2}"
#: Products of units with powers of two digits at most, and no words for powers, which pile up: what reads
#: units computes whatever else it is given, and 9**9**9 has no end.
_PRODUCT = re.compile(rf"(?:\*(?!\*)|[/·()\s]|(?:{_NAME})(?:\s*+(?:{_POWER}))?+)++")


def wrong(message: str) -> PydanticCustomError:
    """Return the error that says this of a value."""
    return PydanticCustomError("scene", "{message}", {"message": message})


def allowed(error: Mapping[str, Any]) -> str:
    """Say what is allowed where pydantic found a mistake; a scene knows lists, not tuples."""
    if error["type"] in ("tuple_type", "list_type"):
        return "must be a list in brackets"
    if error["type"] in ("too_long", "too_short"):
        most = error["ctx"].get("max_length")
        number = f"most {most}" if error["type"] == "too_long" else f"least {error['ctx']['min_length']}"
        return f"must have at {number} {'value' if number.endswith(' 1') else 'values'}"
    return str(error["msg"]).replace("Input should be", "must be").replace("Value error, ", "")


def brief(value: object) -> str:
    """Write a value as Python does, and no more of it than tells it from others.

    >>> len(brief("x" * 98)), len(brief("x" * 99))
    (100, 80)
    """
    try:
        words = repr(value)
    except ValueError:  # a whole number of thousands of digits
        return "a number of thousands of digits"
    return words if len(words) <= 100 else f"{words[:60]}... ({len(words)} characters)"


def read_quantity(kind: Any, text: str, key: str) -> float:
    """Return a quantity that stands alone, in SI, as a bare number counts; a UsageError names it by `key`."""
    try:
        return float(TypeAdapter(kind).validate_python(plain_number(text)))
    except ValidationError as error:
        raise UsageError(f"{key} = {text!r}: {allowed(error.errors()[0])}") from None


def plain_number(text: str) -> float | str:
    """Return the number that a text without a unit is, to count in SI, or else the text."""
    try:
        return float(text)
    except ValueError:
        return text


class Written(float):
    """A quantity in SI that remembers how it was `written`, such as "1000 MPa", to be printed so."""

    written: str

    @classmethod
    def of(cls, value: float, written: str) -> Written:
        """Return a quantity that was written so."""
        made = cls(value)
        made.written = written
        return made

    @property
    def unit(self) -> tuple[str, float]:
        """The unit in which it was written, and what one of it is in SI."""
        number, _, unit = self.written.partition(" ")
        return unit, float(f"{float(self) / float(number):.12g}")  # one unit, whatever number it stands at


def four_digits(value: float) -> str:
    """Return four digits, and no exponent below a million.

    >>> four_digits(13333.3), four_digits(0.0290754)
    ('13330', '0.02908')
    """
    return f"{float(f'{value:.4g}'):g}"


def alike(value: float, given: object) -> float:
    """Return a quantity that is printed in the unit in which another was written, if that was.

    >>> alike(1.1e9, TypeAdapter(Pressure).validate_python("1000 MPa")).written
    '1100 MPa'
    """
    if not isinstance(given, Written) or not given:
        return value
    unit, size = given.unit
    return Written.of(value, f"{four_digits(value / size)} {unit}")


def as_written(value: Any, plain: Any) -> Any:
    """Return tables as they are ready for JSON (`plain`), but quantities as they were written."""
    if isinstance(value, dict):
        return {key: as_written(item, plain[key]) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [as_written(*items) for items in zip(value, plain, strict=True)]
    return value.written if isinstance(value, Written) else plain


def quantity(unit: str, kind: str, example: str) -> WrapValidator:
    """Read a number with a unit ("0.5 um") or a bare number in SI, and convert it once."""
    return WrapValidator(functools.partial(_read, unit=unit, kind=kind, example=example))


def unit(si: str) -> BeforeValidator:
    """Read a unit ("um^4"), or the number of SI units that it is, and convert it once."""

    def read(value: object) -> object:
        if not isinstance(value, str):
            return value
        try:
            return float(_converted(Fraction(1), value.strip(), si))
        except Exception:  # the parser of unit names raises whatever its tokens lead to
            raise wrong(f'must be a unit such as "{si.replace("m", "um")}", or a number of {si}') from None

    return BeforeValidator(read)


def unit_of(annotation: object) -> str:
    """Return the SI unit of the values that a field holds, one of them or several; "1" for plain numbers.

    >>> unit_of(Lengths), unit_of(Pressure | None), unit_of(int)
    ('m', 'Pa', '1')
    """
    return _told(annotation).get("unit", "1")


def example_of(info: FieldInfo) -> str:
    """Return a value of a key as a scene file has it: what its description names, else one of its kind.

    >>> example_of(FieldInfo(annotation=Length | None)), example_of(FieldInfo(annotation=bool))
    ('"0.5 um"', 'true')
    """
    named = _EXAMPLE.search(info.description or "")
    if named is not None:
        return named[1]
    told, choices = _told(info), choices_of(info)
    if told or choices:
        return f'"{told["example"] if told else choices[-1]}"'
    return "true" if bool in _within(info) else str(info.default)


def choices_of(annotation: object) -> tuple[Any, ...]:
    """Return the values that a field allows, if it lists them."""
    kinds = (kind for kind in _within(annotation) if typing.get_origin(kind) is typing.Literal)
    return typing.get_args(next(kinds, None))


def _told(annotation: object) -> Mapping[str, str]:
    """Return what `quantity` was told of the values that a field holds; nothing for plain numbers."""
    readers = (part.func for part in _within(annotation) if isinstance(part, WrapValidator))
    return next((read.keywords for read in readers if isinstance(read, functools.partial)), {})


def _within(annotation: object) -> Iterator[object]:
    """Yield an annotation and all that it is made of."""
    yield annotation
    inner = (*typing.get_args(annotation), *getattr(annotation, "metadata", ()))
    if isinstance(annotation, FieldInfo):
        inner = (annotation.annotation, *inner)
    if typing.get_origin(annotation) is not typing.Literal:
        for part in inner:
            yield from _within(part)


def _read(value: object, check: Callable[[float], float], *, unit: str, kind: str, example: str) -> float:
    """Return a number, with a unit or bare in SI, in SI, as a float that it is then checked to be."""
    allowed = f'must be a {kind} such as "{example}", or a number in {unit}'
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise wrong(allowed)
    if not isinstance(value, str):
        return value if isinstance(value, Written) else check(_in_bounds(value, unit))
    match = _QUANTITY.fullmatch(value) if len(value) <= _LONGEST else None
    if match is None:
        raise wrong(allowed)
    number, symbol = match[1], match[2]
    if symbol is None:
        raise wrong(f"has no unit; {allowed} without quotes")
    if symbol in _PLAIN.get(unit, ()):
        return Written.of(_in_bounds(Fraction(number) * _PLAIN[unit][symbol], unit), f"{number} {symbol}")
    try:
        converted = _converted(Fraction(number), symbol, unit)
    except Exception as error:  # the parser of unit names raises whatever its tokens lead to
        known = type(error).__name__ == "DimensionalityError"
        raise wrong(f"{f'is not a {kind}' if known else 'has an unknown unit'}; {allowed}") from None
    return Written.of(_in_bounds(converted, unit), f"{number} {symbol}")


def _converted(number: Fraction, symbol: str, unit: str) -> Fraction:
    """Convert a number of one unit to another; what is no product of units is not handed to their parser.

    >>> [_PRODUCT.fullmatch(unit) is not None for unit in ("kg/(m s^2)", "m**9**9**9", "(nm^99)^99")]
    [True, False, False]
    """
    if len(symbol) > _LONGEST or not _PRODUCT.fullmatch(symbol):
        raise ValueError(f"{symbol!r} is no product of units")
    return Fraction(unit_registry().Quantity(number, symbol).to(unit).magnitude)


def _in_bounds(value: float | Fraction, unit: str) -> float:
    """Return a number of a size that is computed with; what a field allows is its own matter."""
    try:
        number = float(value)
    except OverflowError:  # a whole number or a fraction of hundreds of digits
        number = 10 * LARGEST
    if not math.isfinite(number):
        raise wrong("must be a finite number")
    if value != 0 and not SMALLEST <= abs(number) <= LARGEST:
        raise wrong(f"is out of range; sizes from {SMALLEST:.0e} to {LARGEST:.0e} {unit} are computed with")
    return number


def metres(symbol: str | None) -> float | None:
    """Return a unit of length in metres, None for none; a ValueError for what is no unit of length.

    >>> metres("um"), metres(None)
    (1e-06, None)
    """
    symbol = (symbol or "").strip()
    if not symbol:
        return None
    try:
        return _in_bounds(_PLAIN["m"].get(symbol) or _converted(Fraction(1), symbol, "m"), "m")
    except Exception:
        raise ValueError(f"unit {symbol[:64]!r} is not a length") from None


Length = Annotated[float, quantity("m", "length", "0.5 um"), Field(gt=0)]
Pressure = Annotated[float, quantity("Pa", "pressure", "10 MPa"), Field(gt=0)]
Force = Annotated[float, quantity("N", "force", "10 mN"), Field(gt=0)]
Work = Annotated[float, quantity("J/m^2", "work of adhesion", "50 mJ/m^2"), Field(gt=0)]
Tension = Annotated[float, quantity("J/m^2", "surface tension", "0.04 J/m^2"), Field(gt=0)]
Temperature = Annotated[float, quantity("K", "temperature", "370 K"), Field(gt=0)]
Memory = Annotated[float, quantity("byte", "memory size", "4 GiB"), Field(ge=1)]
Duration = Annotated[float, quantity("s", "time", "10 min"), Field(gt=0)]
Velocity = Annotated[float, quantity("m/s", "velocity", "20 mm/s"), Field(gt=0)]
Number = Annotated[float, Field(strict=True)]
Positive = Annotated[float, Field(gt=0)]


def within(least: float, most: float, *, or_zero: bool = False) -> AfterValidator:
    """Refuse what is not between two numbers, both allowed [SI]; beyond, powers vanish or overflow."""

    def check(value: float) -> float:
        if not least <= value <= most and not (or_zero and value == 0):
            raise wrong(f"must lie between {least:g} and {most:g}")
        return value

    return AfterValidator(check)


#: A ratio such as h'_rms or p*.
Ratio = Annotated[Number, Field(gt=0), within(1e-12, 1e6)]


@functools.cache
def unit_registry() -> pint.UnitRegistry[Fraction]:
    """Return the unit registry, built on the first unit read; exact, so that "100 um" is 1e-4."""
    import pint

    return pint.UnitRegistry(non_int_type=Fraction)


def sides_of(text: object) -> list[float | str] | None:
    """Return two values that one text holds, as in "64 um, 48 um" or "[64 um, 48 um]"; None of any other.

    >>> sides_of("64 um, 48 um"), sides_of("1e-4,2e-4"), sides_of("1,5 um")
    (['64 um', '48 um'], [0.0001, 0.0002], None)
    """
    if not isinstance(text, str) or "," not in text:
        return None
    sides = [plain_number(side.strip(" []\"'")) for side in text.split(",")]
    return sides if len({type(side) for side in sides}) == 1 else None  # "1,5 um" is no pair


def pair_of(value: object) -> object:
    """Return a pair; a single value stands for both, unless it is text of two."""
    if (sides := sides_of(value)) is not None:
        return sides
    return [value, value] if not isinstance(value, (list, tuple)) else value


def grid_of(value: object) -> object:
    """Return a pair of whole numbers of points; a single one stands for both."""
    pair: Any = pair_of(value)
    if len(pair) != 2 or not all(type(n) is int and n >= 2 for n in pair):
        raise wrong("must be a whole number of points n >= 2, or [nx, ny]")
    if max(pair) > MOST_POINTS:
        raise wrong(f"must have at most {MOST_POINTS} points along a side")
    return pair


def grids_of(value: object) -> object:
    """Return a list of grids; a single number is refused, for it is read elsewhere as one grid."""
    if isinstance(value, (list, tuple)):
        return value[: MOST_ITEMS + 1]  # enough to be refused for its length, without a check of each
    listed = f"[{value}]" if type(value) is int else "[32, 64]"
    raise wrong(f"must be a list of grids such as {listed}")


Grid = Annotated[tuple[int, int], BeforeValidator(grid_of)]
Grids = Annotated[tuple[Grid, ...], BeforeValidator(grids_of), Field(max_length=MOST_ITEMS)]
Lengths = Annotated[tuple[Length, Length], BeforeValidator(pair_of)]


def key(meaning: str, default: Any = ..., **limits: Any) -> Any:
    """Return a key of a table: what it means, its default unless it is required, and its limits."""
    return Field(default, description=meaning, **limits)


class Table(BaseModel):
    """A table of the scene file: unknown keys are errors that name the known ones."""

    #: Which key is meant by another word for it.
    meant: typing.ClassVar[Mapping[str, str]] = {}
    #: What else a file may have there, which is read before the table is.
    before: typing.ClassVar[tuple[str, ...]] = ()

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @model_validator(mode="before")
    @classmethod
    def _only_known_keys(cls, data: object) -> object:
        if isinstance(data, dict):
            for key in data:
                if key not in cls.model_fields:
                    known = *cls.model_fields, *cls.before
                    hint = did_you_mean(str(key), known, cls.meant) or "."
                    raise wrong(f"unknown key {key!r}{hint} Allowed: {', '.join(known)}")
        return data

    @model_validator(mode="after")
    def _fits_together(self, info: ValidationInfo) -> typing.Self:
        for fault in self._faults(info.context):
            raise wrong(fault)
        return self

    def _faults(self, context: Any) -> Iterator[str]:
        """Yield what of its keys does not fit together; `context` is that in which it is read."""
        yield from ()


def exactly_one(table: BaseModel, names: tuple[str, ...]) -> Iterator[str]:
    """Yield a fault of a table with none or several of some keys."""
    given = [name for name in names if getattr(table, name) is not None]
    if len(given) != 1:
        *others, last = map(repr, names)
        yield f"give exactly one of {', '.join(others)} and {last}; found {' and '.join(given) or 'none'}"
