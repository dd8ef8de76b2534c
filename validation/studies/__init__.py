"""Studies: one module for each question, found by name.

A study is a module of this package with

- a docstring whose first line says the question,
- ``run(*, bench: Bench | None = None, ...) -> xarray.Dataset``, whose other keyword arguments are its
  options: each has a default and is annotated ``int``, ``float``, ``str``, ``bool``, or a tuple of ``int``,
  ``float`` or ``str``; one called ``scene`` is a :class:`validation.scene.Scene`. It lists jobs, has them
  solved by the bench, and returns numbers with ``units`` and ``long_name``;
- optionally ``table(data) -> ResultTable``, one row for each thing compared;
- optionally ``budget(data) -> ResultTable``: what is uncertain about its numbers, source by source;
- optionally ``figures(data) -> tuple[Drawing, ...]`` and ``findings(data) -> tuple[str, ...]``, which read
  the dataset.

docs/studies.md has a complete example. ``fem-contact study NAME`` does the rest: options from the command line, storing, resuming, report.
"""

from __future__ import annotations

import importlib
import inspect
import math
import pkgutil
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from fem_contact import errors as fem_errors
from persson import errors as persson_errors
from validation.errors import RunFailed, UsageError
from validation.scenes.scene import scene_problems

if TYPE_CHECKING:
    import xarray as xr

    from validation.report.drawing import Drawing
    from validation.report.table import ResultTable
    from validation.solves.bench import Bench

__all__ = ["Option", "Study", "find_study", "studies"]


@dataclass(frozen=True, kw_only=True)
class Option:
    """One option of a study.

    Attributes
    ----------
    name : str
    kind : type
    default : object
    meaning : str
        What it is, with its unit or definition, from the docstring of `run`.
    """

    name: str
    kind: Any
    default: Any
    meaning: str = ""

    @property
    def flag(self) -> str:
        """How it is written on the command line."""
        return "--" + self.name.replace("_", "-")

    @property
    def words(self) -> str:
        """Flag, kind and default; what it means without a value is said by its meaning."""
        default = _default_words(self.default)
        said = "may be left out" if default is None else f"default: {default}"
        return f"{self.flag} {_kind_words(self.kind)} ({said})"

    def parse(self, text: str) -> Any:
        """Turn the text of the command line into a value.

        Raises
        ------
        UsageError
            Naming option, text and what is allowed.
        """
        try:
            value = _parse(self.kind, text)
        except ValueError:
            raise UsageError(f"{self.flag} = {text!r}: must be {_kind_words(self.kind)}") from None
        values = value if isinstance(value, tuple) else (value,)
        if not values and self.default != ():
            raise UsageError(f"{self.flag} = {text!r}: must be {_kind_words(self.kind)}, at least one")
        if any(isinstance(item, float) and not math.isfinite(item) for item in values):
            raise UsageError(f"{self.flag} = {text!r}: must be finite")
        return value


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
    def run(self) -> Callable[..., xr.Dataset]:
        """Its `run`."""
        found: Callable[..., xr.Dataset] = self.module.run
        return found

    def compute(self, *, bench: Bench, options: Mapping[str, Any]) -> xr.Dataset:
        """Run it on a bench.

        Raises
        ------
        UsageError
            For options that make no surface, solid or load.
        RunFailed
            For a solve whose answer cannot be used.
        """
        try:
            return self.run(bench=bench, **options)
        except ValidationError as error:
            problems = "; ".join(scene_problems(error))
            raise UsageError(f"study {self.name}: its options make no case: {problems}") from None
        except (fem_errors.InvalidInput, persson_errors.InvalidInput, ArithmeticError) as error:
            raise UsageError(f"study {self.name}: {error}") from None
        except (fem_errors.FemContactError, persson_errors.PerssonError) as error:
            raise RunFailed(f"study {self.name}: {error}") from error

    @property
    def options(self) -> dict[str, Option]:
        """Options of `run` by name, but for the bench and the scene."""
        said = {
            name: parameter
            for name, parameter in inspect.signature(self.run).parameters.items()
            if name not in ("bench", "scene")
        }
        # Only the options are looked up: the other annotations may name what is imported for type checkers
        # alone.
        namespace = {"__annotations__": {name: parameter.annotation for name, parameter in said.items()}}
        hints = typing.get_type_hints(type("Options", (), namespace | {"__module__": self.module.__name__}))
        meanings = _meanings(self.run)
        return {
            name: Option(
                name=name,
                kind=_bare(hints[name]),
                default=parameter.default,
                meaning=meanings.get(name) or _USUAL.get(name, ""),
            )
            for name, parameter in said.items()
        }

    def help_lines(self) -> tuple[str, ...]:
        """Question and options, each with kind, default and meaning."""
        lines = [f"{self.name}: {self.question}" + ("  [takes a SCENE]" if self.takes_scene else "")]
        for option in self.options.values():
            lines += [f"    {option.words}", f"        {option.meaning}"]
        return tuple(lines)

    @property
    def takes_scene(self) -> bool:
        """Whether it accepts a scene."""
        return "scene" in inspect.signature(self.run).parameters

    def parse(self, arguments: Sequence[str]) -> dict[str, Any]:
        """Read ``--option value`` and ``--option=value`` pairs.

        Raises
        ------
        UsageError
            For an unknown option, or a value it does not allow.
        """
        values, waiting = {}, list(arguments)
        while waiting:
            flag, equals, text = waiting.pop(0).partition("=")
            option = self.options.get(flag.removeprefix("--").replace("-", "_"))
            if option is None or not flag.startswith("--"):
                known = ", ".join(option.flag for option in self.options.values()) or "none"
                raise UsageError(f"study {self.name}: unknown option {flag!r}; it has: {known}")
            if not equals:
                if not waiting:
                    raise UsageError(f"{flag}: needs a value, {_kind_words(option.kind)}")
                text = waiting.pop(0)
            values[option.name] = option.parse(text)
        return values

    def figures(self, data: xr.Dataset) -> tuple[Drawing, ...]:
        """Return its figures of a dataset; none if it draws none."""
        draw = getattr(self.module, "figures", None)
        return () if draw is None else tuple(draw(data))

    def table(self, data: xr.Dataset) -> ResultTable | None:
        """Return the table it makes of a dataset; None if it leaves that to the report."""
        make = getattr(self.module, "table", None)
        return None if make is None else make(data)

    def budget(self, data: xr.Dataset) -> ResultTable | None:
        """Return its uncertainties source by source; None if it lists none."""
        make = getattr(self.module, "budget", None)
        return None if make is None else make(data)

    def findings(self, data: xr.Dataset) -> tuple[str, ...]:
        """Return its sentences on a dataset."""
        say = getattr(self.module, "findings", None)
        return () if say is None else tuple(say(data))


def studies() -> Mapping[str, Study]:
    """Return all studies by name; a name is that of its module with hyphens."""
    names = sorted(info.name for info in pkgutil.iter_modules(__path__) if not info.name.startswith("_"))
    found = (importlib.import_module(f"{__name__}.{name}") for name in names)
    return {
        name.replace("_", "-"): Study(name=name.replace("_", "-"), module=module)
        for name, module in zip(names, found, strict=True)
    }


def find_study(name: str) -> Study:
    """Return one study.

    Raises
    ------
    UsageError
        For an unknown name.
    """
    known = studies()
    if name not in known:
        raise UsageError(f"study {name!r}: no such study; one of: {', '.join(known) or 'none yet'}")
    return known[name]


def _parse(kind: Any, text: str) -> Any:
    item = _item(kind)
    if item is not None:
        return tuple(_parse(item, part.strip()) for part in text.split(",") if part.strip())
    if kind is bool:
        if text.lower() not in ("true", "false", "yes", "no"):
            raise ValueError(text)
        return text.lower() in ("true", "yes")
    return kind(text)


def _bare(kind: Any) -> Any:
    """Return the kind without the None that an option which may be left out allows."""
    kinds = [part for part in typing.get_args(kind) if part is not type(None)]
    return kinds[0] if typing.get_origin(kind) in (typing.Union, types.UnionType) else kind


def _item(kind: Any) -> Any:
    """Kind of the items of a tuple; None for a single value."""
    arguments = typing.get_args(kind)
    return arguments[0] if typing.get_origin(kind) is tuple else None


def _kind_words(kind: Any) -> str:
    words = {int: "a whole number", float: "a number", str: "a text", bool: "true or false"}
    item = _item(kind)
    return words.get(kind, "a text") if item is None else words[item].removeprefix("a ") + "s with commas"


def _default_words(value: Any) -> str | None:
    if value is None or value == ():
        return None
    return ",".join(map(str, value)) if isinstance(value, tuple) else str(value)


#: What options mean whose name says it to whoever knows the field, and whose docstring then leaves it at that.
_USUAL = {
    "hurst": "Hurst exponent H, from 0 to 1.",
    "poisson": "Poisson ratio.",
    "seed": "Whole number that names the first surface.",
    "seeds": "Whole numbers that name the surfaces.",
}


def _meanings(function: Callable[..., Any]) -> dict[str, str]:
    """Read what each parameter means from the section "Parameters" of a NumPy docstring.

    A line without indent names one parameter or several, the indented lines below it say what they are.
    """
    _, found, section = (inspect.getdoc(function) or "").partition("Parameters\n----------\n")
    if not found:
        return {}
    meanings: dict[str, list[str]] = {}
    names: list[str] = []
    for line in section.splitlines():
        if not line.strip():
            break
        if line[0] != " ":
            names = [name.strip() for name in line.partition(":")[0].split(",")]
        for name in names:
            meanings.setdefault(name, []).extend([line.strip()] if line[0] == " " else [])
    return {name: " ".join(lines) for name, lines in meanings.items()}
