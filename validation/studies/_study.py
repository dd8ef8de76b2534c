"""What a study is: a module with a table of options, a `run`, and what is shown of its dataset."""

from __future__ import annotations

import ast
import types
import typing
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from pydantic import ConfigDict, ValidationError, ValidationInfo, field_validator
from pydantic.fields import FieldInfo

from fem_contact import errors as fem_errors
from persson import errors as persson_errors
from validation.errors import RunFailed, UsageError, did_you_mean
from validation.report.quantities import labelled, quantity
from validation.report.table import budget_table
from validation.report.values import with_places
from validation.scenes.mistakes import problems
from validation.scenes.scene import Scene
from validation.units import Table, unit_of, wrong

if TYPE_CHECKING:
    import xarray as xr

    from validation.execution.bench import Bench
    from validation.report.drawing import Drawing
    from validation.report.table import ResultTable
    from validation.report.views import Views


#: Surfaces, pairs or shifts that a study is given at most: what they scatter by is long known.
_MOST = 10_000


class StudyOptions(Table):
    """Options of a study: a table like those of a scene, with units, ranges and meanings; all have defaults."""

    model_config = ConfigDict(use_attribute_docstrings=True)
    why_no_scene: typing.ClassVar[str] = ""  # Why it takes no scene, where it has no option of that name

    @field_validator("*", mode="after")
    @classmethod
    def _few_enough(cls, value: Any, info: ValidationInfo) -> Any:
        """Refuse numbers of surfaces and the like that no study needs and none would end with."""
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

        Raises
        ------
        UsageError
            For an unknown option, or a value it does not allow, naming both and what is allowed.
        """
        values: dict[str, Any] = {}
        flags = cls.flags()
        for flag, text in _pairs(arguments, flags):
            several = typing.get_origin(_bare(flags[flag].annotation)) is tuple
            unit = _unit_of(flags[flag])
            text = text if several else _with_unit(text, unit)
            listed = "" if several and text.strip().lower() == "none" else text
            parts = [_with_unit(part.strip(), unit) for part in listed.split(",") if part.strip()]
            values[flag[2:].replace("-", "_")] = parts if several else text
        try:
            # Strings are numbers here, and quantities may carry units as in a scene.
            parsed = cls.model_validate_strings(values, context={"on_scene": scene is not None})
            if scene is None:
                return parsed
            given = {name: getattr(parsed, name) for name in parsed.model_fields_set}
            return cls.model_validate({**given, "scene": scene})
        except ValidationError as error:
            raise UsageError("\n".join(problems(error, flags=True))) from None

    def record(self) -> dict[str, Any]:
        """Return what was asked, as JSON-ready data."""
        return self.model_dump(mode="json", exclude_none=True)

    def words(self) -> Iterator[str]:
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
                default, unit = _default_words(field.default), _unit_of(field)
                about = "may be left out" if default is None else f"default: {default}"
                kind = _kind_words(field) + ("" if unit == "1" else f" in {unit}, or with a unit")
                yield f"    {flag} {kind} ({about})"
            meaning = " ".join((field.description or "").split())
            yield f"        {meaning}{cls.fixed_by_scene().get(flag[2:].replace('-', '_'), '')}"


@dataclass(frozen=True, kw_only=True)
class Study:
    """A study by name."""

    name: str
    module: ModuleType

    @property
    def question(self) -> str:
        """First line of its docstring."""
        return (self.module.__doc__ or "").strip().partition("\n")[0]

    @property
    def options(self) -> type[StudyOptions]:
        """Table of options of the study."""
        options_class: type[StudyOptions] = self.module.Options
        return options_class

    def compute(self, options: StudyOptions, *, bench: Bench) -> xr.Dataset:
        """Run the study on a bench.

        Raises
        ------
        UsageError
            For options that make no surface, solid or load, and for names that no registry has.
        RunFailed
            For a solve whose answer cannot be used.
        """
        wrong = "; ".join(_misnamed(self.module))
        if wrong:
            raise UsageError(f"study {self.name}: {wrong}")
        try:
            return labelled(self.module.run(options, bench=bench)).assign_attrs(study=self.name)
        except ValidationError as error:
            lines = "; ".join(problems(error))
            raise UsageError(f"study {self.name}: its options make no case: {lines}") from None
        except (fem_errors.InvalidInput, persson_errors.InvalidInput, ArithmeticError) as error:
            raise UsageError(f"study {self.name}: {error}") from None
        except (fem_errors.FemContactError, persson_errors.PerssonError) as error:
            raise RunFailed(f"study {self.name}: {error}") from error

    def views(self, data: xr.Dataset) -> Views:
        """Return what is shown of a dataset."""
        declared: Views = self.module.views(with_places(data))
        return declared

    def parse(self, arguments: Sequence[str], *, scene: Scene | None = None) -> StudyOptions:
        """Read its options from the command line.

        Raises
        ------
        UsageError
            For what it does not allow, and for a scene that it does not take.
        """
        if scene is not None and not self.options.takes_scene():
            why = f": {self.options.why_no_scene}" if self.options.why_no_scene else ""
            raise UsageError(f"study {self.name}: takes no scene{why}; leave {scene.name!r} out")
        try:
            return self.options.parse(arguments, scene=scene)
        except UsageError as error:
            raise UsageError(f"study {self.name}: {error}") from None

    def help_lines(self) -> tuple[str, ...]:
        """Question and options, each with kind, default and meaning."""
        takes = "  [takes a SCENE]" if self.options.takes_scene() else ""
        return (f"{self.name}: {self.question}{takes}", *self.options.help_lines())

    def figures(self, data: xr.Dataset) -> tuple[Drawing, ...]:
        """Return its figures of a dataset, drawn."""
        from validation.report.marks import draw

        return tuple(draw(figure, data) for figure in self.views(data).figures)

    def table(self, data: xr.Dataset) -> ResultTable | None:
        """Return its table of a dataset; None if it has none."""
        declared = self.views(data).table
        return None if declared is None else declared.of(data)

    def budget(self, data: xr.Dataset) -> ResultTable | None:
        """Return its uncertainties source by source; None if it lists none."""
        named = self.views(data).budget
        return budget_table(data, named) if named else None

    def findings(self, data: xr.Dataset) -> tuple[str, ...]:
        """Return its sentences on a dataset."""
        return tuple(unit.text for unit in self.views(data).findings)


def _misnamed(module: ModuleType) -> Iterator[str]:
    """Say which names that its source makes or shows are none, before anything is solved."""
    path = getattr(module, "__file__", None)
    tree = ast.parse(Path(path).read_text(encoding="utf-8") if path else "")
    for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
        what = call.func.id if isinstance(call.func, ast.Name) else ""
        texts = [a.value for a in call.args if isinstance(a, ast.Constant) and isinstance(a.value, str)]
        names = texts[what == "reduce" :] if what in ("mean", "change", "reduce", "same_of_all") else []
        wrong = [name for name in names if name.endswith("_each")]
        if wrong:
            yield f"line {call.lineno}: {what} is told {wrong[0].removesuffix('_each')!r}, not {wrong[0]!r}"
        if what == "derive":
            names = [keyword.arg for keyword in call.keywords if keyword.arg]
        if what in ("Line", "Level", "Band", "Image"):
            names = [
                str(k.value.value)
                for k in call.keywords
                if k.arg in ("y", "high") and isinstance(k.value, ast.Constant)
            ]
        if what == "Table":
            columns = [
                k.value for k in call.keywords if k.arg == "columns" and isinstance(k.value, ast.Tuple)
            ]
            names = [str(c.value) for row in columns for c in row.elts if isinstance(c, ast.Constant)]
        for name in names:
            try:
                quantity(name)
            except UsageError as error:
                yield f"line {call.lineno}: {error}"


def _pairs(arguments: Sequence[str], flags: Mapping[str, FieldInfo]) -> Iterator[tuple[str, str]]:
    waiting = list(arguments)
    while waiting:
        flag, equals, text = waiting.pop(0).partition("=")
        plain = flag if flag in flags else flag.replace("--no-", "--", 1)
        if not equals and plain in flags and flags[plain].annotation is bool:
            named = plain == flag and waiting and waiting[0] in ("true", "false")
            yield plain, waiting.pop(0) if named else str(plain == flag)
            continue
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
    kind = _bare(field.annotation)
    words = {int: "a whole number", float: "a number", str: "a text"}
    if typing.get_origin(kind) is typing.Literal:
        return "one of " + ", ".join(map(str, typing.get_args(kind)))
    if typing.get_origin(kind) is not tuple:
        return words.get(kind, "a text")
    item = typing.get_args(kind)[0]
    while hasattr(item, "__metadata__"):
        item = item.__origin__
    if typing.get_origin(item) is typing.Literal:
        return "some of " + ", ".join(map(str, typing.get_args(item))) + ", with commas"
    return words.get(item, "a text").removeprefix("a ") + "s with commas"


def _unit_of(field: FieldInfo) -> str:
    unit = unit_of(field)
    return unit_of(field.annotation) if unit == "1" else unit


def _with_unit(text: str, unit: str) -> str:
    try:
        float(text)
    except ValueError:
        return text
    return text if unit == "1" else f"{text} {unit}"


def _default_words(value: Any) -> str | None:
    if value is None or value == ():
        return None
    return ",".join(map(str, value)) if isinstance(value, tuple) else str(value)
