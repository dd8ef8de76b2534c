"""Scenes: what to compute, read from TOML, checked, in SI units. A scene describes; it computes nothing."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from functools import reduce
from importlib import resources
from operator import or_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self, TypeAlias

from pydantic import (
    AfterValidator,
    BaseModel,
    Field,
    StrictInt,
    ValidationError,
    ValidationInfo,
    create_model,
    model_validator,
)
from pydantic.fields import FieldInfo

from validation.effects import effect_kinds
from validation.effects.base import Effect, clash, effect_key
from validation.errors import SceneError, UsageError, harmless
from validation.scenes.quantities import QUANTITIES, Quantities, Subsurface
from validation.scenes.run_options import RunOptions
from validation.scenes.tables import (
    SURFACES,
    CapillarySurface,
    FileSurface,
    Load,
    RandomSurface,
    SelfAffineSurface,
    SolidSpec,
    Surface,
)
from validation.solvers import Method, Solver, methods
from validation.units import MOST_POINTS, Grids, Table, allowed, brief, unit_registry, wrong

__all__ = [
    "CapillarySurface",
    "EffectSpec",
    "Ensemble",
    "FileSurface",
    "Load",
    "MethodTables",
    "Methods",
    "Quantities",
    "RandomSurface",
    "RunOptions",
    "Scene",
    "SelfAffineSurface",
    "SolidSpec",
    "builtin_scenes",
    "checked_scene",
    "load_scene",
    "parsed_toml",
    "scene_keys",
    "scene_problems",
    "scene_text",
    "sized",
    "unit_registry",
]


#: What a scene may be called, since a folder of results is named so.
_NAME = r"^[A-Za-z0-9][A-Za-z0-9._-]{0,99}$"


#: Tables whose grids `run --accuracy` chooses, and the context in which they are then read.
_CHOSEN, _GRIDS_CHOSEN = ("methods.bem", "ensemble"), {"grids": "chosen"}

#: Surfaces of one scene: the scatter between ten thousand is known to a percent of itself.
_MOST_REALISATIONS = 10_000


class MethodTables(Table):
    """Which methods run: those whose table is present, no others; see `validation.solvers`."""

    @model_validator(mode="after")
    def _some_method(self) -> Self:
        if not self.solvers and self.options("theory") is None:
            tables = ", ".join(f"[methods.{name}]" for name in methods())
            raise wrong(f"give at least one of the tables {tables}")
        return self

    @property
    def asked(self) -> dict[str, Method]:
        """Methods whose table is present, by name, in the order of the registry."""
        return {name: method for name, method in methods().items() if getattr(self, name, None) is not None}

    @property
    def solvers(self) -> dict[str, Solver]:
        """Those of them that press a surface; the first is what the others are compared with."""
        return {name: method for name, method in self.asked.items() if isinstance(method, Solver)}

    def options(self, name: str) -> Any:
        """Return the table of a method; None where it is not listed."""
        return getattr(self, name, None)


if TYPE_CHECKING:
    EffectSpec: TypeAlias = Effect

    class Methods(MethodTables):
        """One optional table for each method of the registry."""

        def __init__(self, **tables: Any) -> None: ...

        def __getattr__(self, name: str) -> Any: ...

else:
    Methods = create_model(
        "Methods",
        __base__=MethodTables,
        __doc__="One optional table for each method of the registry.",
        **{name: (method.options | None, None) for name, method in methods().items()},
    )
    EffectSpec = Annotated[reduce(or_, effect_kinds().values()), Field(discriminator="kind")]


class Ensemble(Table):
    """Further realisations of the same C(q), by boundary elements, for the scatter between surfaces."""

    realisations: Annotated[StrictInt, Field(ge=2, le=_MOST_REALISATIONS)] = Field(
        description="how many surfaces, that of the scene included"
    )
    grids: Annotated[Grids, Field(min_length=2)] = Field(description="surface points, e.g. [32, 64]")


def _one_line(text: str) -> str:
    """Refuse what would change a terminal, or how a line reads."""
    bad = next((c for c in text if c == "\n" or harmless(c) != c), None)
    if bad is not None:
        raise wrong(f"must be a line of text; it holds the control character {bad!a}")
    return text


class Scene(Table):
    """One comparison: a surface, a solid, a load, the methods, and nothing that is not listed.

    Attributes are the tables of the scene file; every quantity is in SI units.
    """

    name: str = Field(
        min_length=1, pattern=_NAME, description="names the results folder; that of the file if not given"
    )
    title: Annotated[str, AfterValidator(_one_line)] = Field(default="", max_length=200)
    surface: Surface
    solid: SolidSpec
    load: Load
    methods: Methods
    ensemble: Ensemble | None = None
    effects: tuple[EffectSpec, ...] = ()
    quantities: Quantities | None = None
    run: RunOptions = RunOptions()

    @model_validator(mode="before")
    @classmethod
    def _effects_are_a_list(cls, data: object) -> object:
        if isinstance(data, dict) and isinstance(data.get("effects"), dict):
            raise wrong("effects: each is a table of a list; write [[effects]], not [effects]")
        return data

    @model_validator(mode="after")
    def _fits_together(self, info: ValidationInfo) -> Self:
        problem = next(self._problems(_CHOSEN if info.context == _GRIDS_CHOSEN else ()), None)
        if problem is not None:
            raise wrong(problem)
        return self

    def _problems(self, chosen: tuple[str, ...]) -> Iterator[str]:
        """Yield what does not fit together; grids of the chosen tables are not looked at."""
        surface, load, ensemble, solvers = self.surface, self.load, self.ensemble, list(self.methods.solvers)
        clashing = clash(self.effects)
        if clashing is not None:
            yield clashing
        if load.held and not solvers:
            yield f"load.{load.key}: the theory is told a load; add a method that presses, which finds it"
        if load.held and ensemble is not None:
            yield f"ensemble: is pressed with one load; remove the table, or load.{load.key}"
        if not load.held and solvers and (len(load.values) > 1 or load.values[0] == 0):
            given = getattr(load, load.key)
            listed = list(given) if isinstance(given, tuple) else given
            yield (
                f"load.{load.key} = {listed!r}: method {solvers[0]!r} presses with one load above 0; "
                "lists, and 0 with adhesion, belong to [methods.theory] alone"
            )
        sticky = any(effect.slot == "gap law" for effect in self.effects)
        if not load.held and min(load.values) == 0 and not sticky:
            yield f"load.{load.key}: 0 needs the effect 'adhesion'; without it nothing touches"
        if self.quantities is not None and not solvers:
            yield "quantities: are read off a contact; add the table of a method that presses"
        if isinstance(surface, FileSurface):
            if ensemble is not None:
                yield "ensemble: a measured surface has one realisation; remove the table"
            return
        if solvers and surface.seed is None:
            yield (
                f"surface.seed: missing; method {solvers[0]!r} presses one surface; a whole number names it"
            )
        tables = {f"methods.{name}": self.methods.options(name) for name in solvers}
        for name, table in (*tables.items(), ("ensemble", ensemble)):
            if table is not None and name not in chosen and not getattr(table, "under_resolved", False):
                for grid in table.grids:
                    yield from _too_coarse(f"{name}.grids", grid, surface)
        if ensemble is not None and self.ensemble_solver is None:
            quick = [name for name, method in methods().items() if getattr(method, "for_ensembles", False)]
            yield f"ensemble: add the table of a method that is quick enough for it: {', '.join(quick)}"

    @property
    def subsurface(self) -> Subsurface | None:
        """What is asked of the solid below the contact."""
        return None if self.quantities is None else self.quantities.subsurface

    @property
    def ensemble_solver(self) -> Solver | None:
        """The listed method that further realisations are solved by: the first that is quick enough."""
        return next((method for method in self.methods.solvers.values() if method.for_ensembles), None)


def _too_coarse(key: str, grid: tuple[int, int], surface: RandomSurface) -> Iterator[str]:
    """Yield what is wrong with a grid with lambda_short <= 2 dx on either axis."""
    needed = surface.resolving_grid
    if any(n < least for n, least in zip(grid, needed, strict=True)):
        size = max(surface.length)
        # No machine holds that: more likely a number without a unit, which counts as metres.
        hint = f"; length: {size:.6g} was read as {size:.6g} m" if max(needed) > MOST_POINTS else ""
        yield (
            f"{key} = {list(grid)}: too coarse for lambda_short = {surface.lambda_short:.6g} m; "
            f"at least {list(needed)} points, or say under_resolved = true in the method's table{hint}"
        )


def scene_keys(data: Mapping[str, Any]) -> dict[str, FieldInfo]:
    """Return the keys that a scene may have, with what each means; an effect is named by its kind.

    The kind of surface that `data`, the tables of a scene, say narrows the choice.
    """
    surface = data.get("surface")
    kind = surface.get("kind") if isinstance(surface, dict) else None
    rough = [SURFACES[kind]] if isinstance(kind, str) and kind in SURFACES else list(SURFACES.values())
    tables: list[tuple[str, type[BaseModel]]] = [("surface", table) for table in rough]
    tables += [("solid", SolidSpec), ("load", Load), ("ensemble", Ensemble), ("run", RunOptions)]
    tables += [(f"quantities.{name}", table) for name, table in QUANTITIES.items()]
    tables += [(f"methods.{name}", method.options) for name, method in methods().items()]
    tables += [(f"effects.{name}", effect) for name, effect in effect_kinds().items()]
    keys = {name: Scene.model_fields[name] for name in ("name", "title")}
    for place, table in tables:
        for name, info in table.model_fields.items():
            if not (name == "kind" and place.startswith("effects.")):
                keys.setdefault(f"{place}.{name}", info)
    return keys


def builtin_scenes() -> tuple[str, ...]:
    """Names of the scenes that come with the package."""
    folder = resources.files("validation.scenes") / "library"
    return tuple(
        sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml"))
    )


def scene_text(scene: str) -> tuple[str, Path]:
    """Text of a built-in scene or a scene file, and the folder its relative paths refer to."""
    path = Path(scene)
    # os.path, because pathlib raises for a name that is too long.
    if path.suffix == ".toml" or os.path.isfile(scene):
        try:
            return path.read_text(encoding="utf-8"), path.parent
        except UnicodeDecodeError:
            raise SceneError(scene, ["is not UTF-8 text; a scene is a TOML file"]) from None
        except OSError as error:
            raise SceneError(scene, [f"cannot be read: {error.strerror}"]) from None
        except ValueError:  # a zero byte in the name
            raise SceneError(scene, ["is no name of a file"]) from None
    if scene in builtin_scenes():
        entry = resources.files("validation.scenes") / "library" / f"{scene}.toml"
        return entry.read_text(encoding="utf-8"), Path()
    raise SceneError(scene, [f"no such scene; give a .toml file or one of: {', '.join(builtin_scenes())}"])


def parsed_toml(text: str, scene: str) -> dict[str, Any]:
    """Parse the text of a scene; a SceneError for what is not TOML, or what the parser gives up on."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise SceneError(scene, ["is nested too deeply; a scene has tables within lists at most"]) from None
    except ValueError as error:  # of which TOMLDecodeError is one; a number of thousands of digits another
        raise SceneError(scene, [f"is not valid TOML: {error}"]) from None


def load_scene(scene: str) -> Scene:
    """Read and check a scene, built-in by name or from a TOML file by path.

    A SceneError has one line for each problem: key, value, what is allowed.
    """
    text, folder = scene_text(scene)
    data = parsed_toml(text, scene)
    if "sweep" in data:
        raise SceneError(
            scene, ["[sweep]: is many scenes; fem-contact run and explain take it, this does not"]
        )
    return checked_scene(sized(data, folder, scene), folder, scene)


def checked_scene(data: Mapping[str, Any], folder: Path, scene: str, *, grids_chosen: bool = False) -> Scene:
    """Return the scene that parsed tables say, with the path of a measured surface made absolute.

    Relative paths refer to `folder`; messages, one line for each problem, name the scene `scene`. Where grids
    of boundary elements and ensemble, and its number of surfaces, will be chosen they may be missing, or too
    coarse.
    """
    try:
        context = _GRIDS_CHOSEN if grids_chosen else None
        named = _named(_filled(data) if grids_chosen else data, scene)
        checked = Scene.model_validate(named, context=context)
    except ValidationError as error:
        raise SceneError(scene, scene_problems(error)) from None
    if isinstance(checked.surface, FileSurface) and not checked.surface.path.is_absolute():
        # Absolute, because a worker may stand in another folder.
        path = (folder / checked.surface.path).resolve()
        surface = checked.surface.model_copy(update={"path": path})
        checked = checked.model_copy(update={"surface": surface})
    return checked


def _filled(data: Mapping[str, Any]) -> dict[str, Any]:
    """Fill in what will be chosen, where tables leave it out."""
    filled, usual = dict(data), {"grids": [8, 16]}
    if isinstance(filled.get("ensemble"), dict):
        filled["ensemble"] = {"realisations": 2, **usual, **filled["ensemble"]}
    methods = filled.get("methods")
    if isinstance(methods, dict) and isinstance(methods.get("bem"), dict):
        filled["methods"] = {**methods, "bem": {**usual, **methods["bem"]}}
    return filled


def _named(data: Mapping[str, Any], scene: str) -> Mapping[str, Any]:
    """Name a scene that has no name after its file, if that makes a name."""
    stem = Path(scene).stem
    return data if "name" in data or re.fullmatch(_NAME, stem) is None else {"name": stem, **data}


def sized(data: dict[str, Any], folder: Path, scene: str) -> dict[str, Any]:
    """Fill in the length of a measured surface from its file, and ask for what neither of the two says."""
    surface = data.get("surface")
    if not isinstance(surface, dict) or surface.get("kind") != "file":
        return data
    path = surface.get("path")
    if not isinstance(path, str):
        return data
    from validation.scenes.topography import file_says

    try:
        says = file_says(folder / path)
        if "length" in surface and not isinstance(surface["length"], list):
            says.check_square("surface.length")
    except UsageError as error:
        raise SceneError(scene, [f"surface.path = {path!r}: {error}"]) from None
    known = {"length": says.lengths, "unit": says.unit, **surface}
    missing = [
        f"surface.{key}: missing, and {path!r} does not say it; {FileSurface.model_fields[key].description}"
        for key in ("length", "unit")
        if known[key] is None
    ]
    if missing:
        raise SceneError(scene, missing)
    return {**data, "surface": {"length": says.lengths, **surface}}


def scene_problems(error: ValidationError) -> list[str]:
    """List one line for each mistake; an array with a wrong item is not also called too short."""
    items = error.errors()
    within = {item["loc"][:depth] for item in items for depth in range(len(item["loc"]))}
    return [_problem(item) for item in _told_once(item for item in items if item["loc"] not in within)]


def _told_once(items: Iterable[Any]) -> Iterator[Any]:
    """Yield mistakes; one of a value that stands for several items of an array is told of the array."""
    alike: dict[tuple[Any, ...], list[Any]] = {}
    for item in items:
        *array, last = item["loc"] or ("",)
        place = (*array, last if isinstance(last, str) else None)
        alike.setdefault((place, item["msg"], brief(item["input"])), []).append(item)
    for first, *others in alike.values():
        yield {**first, "loc": first["loc"][:-1]} if others else first


#: Values of `kind`, and all that stands in pydantic's locations without being a key.
_KINDS: dict[str, Mapping[str, Any]] = {"surface": SURFACES, "effects": effect_kinds()}
_TAGS = {*SURFACES, *effect_kinds(), "one", "several"}


def _keys(location: tuple[str | int, ...]) -> list[str]:
    """Keys that lead to a mistake, as the file has them."""
    parts = [str(part) for part in location]
    place = {"surface": 1, "effects": 2, "load": 2}.get(parts[0] if parts else "", len(parts))
    return parts[:place] + [part for k, part in enumerate(parts[place:]) if k or part not in _TAGS]


def _written(location: list[str]) -> str:
    """Write the keys that lead to a mistake for a reader, who counts from one.

    >>> _written(["effects", "0", "hardness"]), _written(["methods", "bem", "grids", "1"])
    ('[[effects]] 1 hardness', 'methods.bem.grids (item 2)')
    """
    if len(location) > 1 and location[0] == "effects" and location[1].isdigit():
        return effect_key(int(location[1]), _written(location[2:])).rstrip()
    if location and location[-1].isdigit():
        return f"{_written(location[:-1])} (item {int(location[-1]) + 1})"
    return ".".join(location)


def _problem(item: Any) -> str:
    """One line for one error of the schema: key = value: what is allowed."""
    location = _keys(item["loc"])
    key, kind, value = _written(location), _written([*location, "kind"]), item["input"]
    if item["type"] == "missing":
        surface, *tags = [str(part) for part in item["loc"]][:2]
        keys = scene_keys({"surface": {"kind": tags[0]}} if surface == "surface" and tags else {})
        effect = [str(part) for part in item["loc"] if location[0] == "effects" and part in effect_kinds()]
        full = ".".join(["effects", *effect[:1], location[-1]] if effect else location)
        info = next((keys[name] for name in keys if name == full or name.endswith(f".{full}")), None)
        named = (info and info.description) or f"the table [{'.'.join(location)}] is required"
        return f"{key}: missing; {named}"
    if item["type"] == "union_tag_not_found":
        named = ", ".join(repr(kind) for kind in sorted(_KINDS[location[0]]))
        return f"{kind}: missing; one of {named}"
    if item["type"] == "union_tag_invalid":
        return f"{kind} = {brief(value.get('kind'))}: must be one of {item['ctx']['expected_tags']}"
    if isinstance(value, (dict, BaseModel)):
        return f"{key}: {allowed(item)}" if key else allowed(item)
    return f"{key} = {brief(value)}: {allowed(item)}"
