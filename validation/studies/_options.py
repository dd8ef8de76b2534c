"""What all options of studies have: a table that the command line fills, and options that many studies share."""

import types
import typing
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ConfigDict, Field, ValidationError, ValidationInfo, field_validator
from pydantic.fields import FieldInfo

from validation.errors import UsageError, did_you_mean
from validation.measurements.common import base_surface
from validation.scenes.mistakes import problems
from validation.scenes.scene import Scene
from validation.scenes.surfaces import spectrum_of
from validation.scenes.tables import SelfAffineSurface
from validation.solvers import chosen_solver
from validation.units import Positive, Table, unit_of, wrong

Hurst = Annotated[float, Field(ge=0, le=1, description="Hurst exponent H")]
Periods = Annotated[float, Field(ge=1, description="L / lambda_long")]
Bandwidth = Annotated[float, Field(gt=1, description="lambda_long / lambda_short")]
Seed = Annotated[int, Field(ge=0, description="whole number that names the first surface")]
ReducedPressure = Annotated[
    float, Field(gt=0, description="p* = p0 / (E* h'_rms) with the realised gradient of each surface")
]


def _with_scatter(count: int, others: ValidationInfo) -> int:
    on_scene = others.data.get("scene") is not None or (others.context or {}).get("on_scene")
    if count < 2 and not on_scene:
        raise wrong("must be greater than or equal to 2")
    return count


Surfaces = Annotated[
    int,
    Field(ge=1, description="how many; scatter between them is the uncertainty"),
    AfterValidator(_with_scatter),
]
Pairs = Annotated[
    int, Field(ge=2, description="pairs of surfaces +h, -h; scatter between pairs is the uncertainty")
]
Shifts = Annotated[int, Field(ge=1, description="sub-grid shifts along each axis")]
Positives = Annotated[tuple[Positive, ...], Field(min_length=1)]


def above_one(magnifications: tuple[float, ...], *, bandwidth: float) -> None:
    """Refuse magnifications of a last wave at which there are none of several lengths, or none at all."""
    if not all(1 < zeta <= bandwidth for zeta in magnifications):
        values = ", ".join(f"{zeta:g}" for zeta in magnifications)
        raise wrong(f"magnifications = {values}: must lie above 1, at most bandwidth = {bandwidth:g}")


def _that_solve(names: tuple[str, ...]) -> tuple[str, ...]:
    for name in names:
        chosen_solver(name)
    return tuple(dict.fromkeys(names))


AnyMethods = Annotated[tuple[str, ...], AfterValidator(_that_solve)]
Methods = Annotated[
    AnyMethods,
    Field(
        min_length=1,
        description="solvers with commas: bem, fem, tamaas, ..., of another package, or module:function of your own",
    ),
]
#: Finite elements of the block, by the names of `fem_contact.block`.
Element = Literal["Hex1", "Hex1/P0", "Hex2", "Hex2/P1disc"]

#: Surfaces, pairs or shifts that a study is given at most: what they scatter by is long known.
_MOST = 10_000


class StudyOptions(Table):
    """Options of a study: a table like those of a scene, with units, ranges and meanings; all have defaults."""

    model_config = ConfigDict(use_attribute_docstrings=True)
    why_no_scene: typing.ClassVar[str] = ""  # Why it takes no scene, where it has no option of that name

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        for field in cls.model_fields.values():  # a meaning may go over several lines
            field.description = " ".join((field.description or "").split())

    @field_validator("*", mode="after")
    @classmethod
    def _few_enough(cls, value: Any, info: ValidationInfo) -> Any:
        if type(value) is int and info.field_name != "seed" and value > _MOST:
            raise wrong(f"must be at most {_MOST}")
        return value

    @classmethod
    def flags(cls) -> dict[str, FieldInfo]:
        """Fields that the command line sets, by flag; a scene is an argument, not a flag."""
        return {
            "--" + name.replace("_", "-"): field
            for name, field in cls.model_fields.items()
            if name != "scene"
        }

    @classmethod
    def takes_scene(cls) -> bool:
        """Whether the study accepts a scene."""
        return "scene" in cls.model_fields

    @classmethod
    def fixed_by_scene(cls) -> Mapping[str, str]:
        """Return the options that are refused with a scene, each with the reason."""
        return {}

    @classmethod
    def parse(cls, arguments: Sequence[str], *, scene: Scene | None = None) -> typing.Self:
        """Read ``--option value`` and ``--option=value`` pairs.

        A UsageError for an unknown option, or a value it does not allow, naming both and what is allowed.
        """
        values: dict[str, Any] = {}
        flags = cls.flags()
        for flag, text in _pairs(arguments, flags):
            several = typing.get_origin(_bare(flags[flag].annotation)) is tuple
            parts = text.split(",") if text.strip().lower() != "none" else []
            values[flag[2:].replace("-", "_")] = (
                [_with_unit(part.strip(), flags[flag]) for part in parts if part.strip()]
                if several
                else _with_unit(text, flags[flag])
            )
        try:
            # Strings are numbers here, and quantities may carry units as in a scene.
            parsed = cls.model_validate_strings(values, context={"on_scene": scene is not None})
            if scene is None:
                return parsed
            given = {name: getattr(parsed, name) for name in parsed.model_fields_set}
            return cls.model_validate({**given, "scene": scene})
        except ValidationError as error:
            raise UsageError("\n".join(problems(error, flags=True))) from None

    def self_affine(
        self, *, number: int = 0, until: float | None = None, **changes: Any
    ) -> SelfAffineSurface:
        """Return a surface of these options, or of others in their place, with its waves up to q/q_long = until.

        The waves that remain are unchanged by those that are left out.
        What may be given in place of options is that of `base_surface`.
        """
        spectrum = self.model_dump(include={"hurst", "periods", "bandwidth", "seed"})
        spectrum |= changes | {"seed": spectrum["seed"] + number}
        whole = base_surface(**spectrum)
        if until is None or until == spectrum["bandwidth"]:
            return whole
        shape = spectrum_of(whole)
        left = whole.rms_gradient * float(shape.m2(until * shape.q_long) / shape.m2()) ** 0.5
        return base_surface(**spectrum | {"bandwidth": until, "gradient": left})

    def without(self, failures: Iterable[Any]) -> typing.Self | None:
        """Return the same without the methods that solved failures are of; None where not all are of such."""
        asked = {name: chosen_solver(name) for name in getattr(self, "methods", ()) if name != "bem"}
        left = set(asked)
        for solve in failures:
            told = dict(getattr(solve, "arguments", ()))
            settings = dict(told.get("settings", ())).items()
            of = {
                n for n, (s, own) in asked.items() if s.name == told.get("method") and own.items() <= settings
            }
            if not of:
                return None
            left -= of
        return self._with_methods(tuple(n for n in getattr(self, "methods", ()) if n == "bem" or n in left))

    def _with_methods(self, names: tuple[str, ...]) -> typing.Self | None:
        return self._with(self.model_fields_set, methods=names)

    def _with(self, names: Iterable[str], **changed: Any) -> typing.Self | None:
        """Return what was given of some options, and others; None where nothing is left of the question."""
        try:
            return self.model_validate({name: getattr(self, name) for name in names} | changed)
        except ValidationError:
            return None

    def record(self) -> dict[str, Any]:
        """Return what was asked, as JSON-ready data."""
        return self.model_dump(mode="json", exclude_none=True)

    def remarks(self) -> Iterator[str]:
        """Yield what a reader should know of what was asked."""
        yield from ()

    @classmethod
    def help_lines(cls) -> Iterator[str]:
        """Yield two lines for each option: flag, kind and default; what it means."""
        for flag, field in cls.flags().items():
            if field.annotation is bool:
                off = flag.replace("--", "--no-", 1)
                yield f"    {flag}, {off} (default: {flag if field.default else off})"
            else:
                default, unit = field.default, _unit_of(field)
                values = ",".join(map(str, default)) if isinstance(default, tuple) else default
                about = "may be left out" if default in (None, ()) else f"default: {values}"
                kind = _kind_words(field) + ("" if unit == "1" else f" in {unit}, or with a unit")
                yield f"    {flag} {kind} ({about})"
            yield f"        {field.description}{cls.fixed_by_scene().get(flag[2:].replace('-', '_'), '')}"


class SurfaceOptions(StudyOptions):
    """Options of a study that makes self-affine surfaces of one H."""

    hurst: Hurst = 0.8
    seed: Seed = 2006


def _pairs(arguments: Sequence[str], flags: Mapping[str, FieldInfo]) -> Iterator[tuple[str, str]]:
    waiting = list(arguments)
    while waiting:
        flag, equals, text = waiting.pop(0).partition("=")
        plain = flag if flag in flags else flag.replace("--no-", "--", 1)
        if not equals and plain in flags and flags[plain].annotation is bool:
            named = plain == flag and waiting and waiting[0] in ("true", "false")
            yield plain, waiting.pop(0) if named else str(plain == flag)
            continue
        if flag not in flags and not flag.startswith("-"):
            raise UsageError(
                f"{flag!r}: is no option; values of one are joined by commas, a SCENE stands right behind the study"
            )
        if flag not in flags:
            hint = did_you_mean(flag, flags)
            raise UsageError(f"unknown option {flag!r}{hint}; it has: {', '.join(flags) or 'none'}")
        if not equals:
            if not waiting:
                raise UsageError(f"{flag}: needs a value, {_kind_words(flags[flag])}")
            text = waiting.pop(0)
        yield flag, text


def _bare(kind: Any) -> Any:
    kinds = [part for part in typing.get_args(kind) if part is not type(None)]
    return kinds[0] if typing.get_origin(kind) in (typing.Union, types.UnionType) else kind


def _kind_words(field: FieldInfo) -> str:
    item = _bare(field.annotation)
    several = typing.get_origin(item) is tuple
    if several:
        item = typing.get_args(item)[0]
        while hasattr(item, "__metadata__"):
            item = item.__origin__
    if typing.get_origin(item) is typing.Literal:
        words = ", ".join(map(str, typing.get_args(item)))
        return f"some of {words}, with commas" if several else f"one of {words}"
    words = {int: "a whole number", float: "a number"}.get(item, "a text")
    return words.removeprefix("a ") + "s with commas" if several else words


def _unit_of(field: FieldInfo) -> str:
    unit = unit_of(field)
    return unit_of(field.annotation) if unit == "1" else unit


def _with_unit(text: str, field: FieldInfo) -> str:
    unit = _unit_of(field)
    try:
        float(text)
    except ValueError:
        return text
    return text if unit == "1" else f"{text} {unit}"
