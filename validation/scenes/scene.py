"""Scenes: what to compute, read from TOML, checked, in SI units. A scene describes; it computes nothing."""

from __future__ import annotations

import contextlib
import math
import os
import re
import tomllib
from collections.abc import Iterator, Mapping
from functools import reduce
from importlib import resources
from operator import or_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, TypeAlias

from pydantic import Field, TypeAdapter, ValidationError, create_model, model_validator
from scipy.fft import next_fast_len

from validation.arrays import Grid, Pair
from validation.effects import effect_kinds
from validation.effects.base import Effect
from validation.errors import SceneError, UsageError, did_you_mean
from validation.report.quantities import as_length
from validation.scenes.mistakes import problems
from validation.scenes.tables import (
    NAME,
    Ensemble,
    FileSurface,
    Load,
    Quantities,
    RunOptions,
    SolidSpec,
    SpectrumUnits,
    Subsurface,
    Surface,
    Title,
)
from validation.solvers import Method, Solver, methods
from validation.solvers.base import Size
from validation.units import MOST_POINTS, Table, as_written, sides_of, wrong

#: Tables whose grids `run --accuracy` chooses: the context in which a scene is then read.
_GRIDS_CHOSEN = ("methods.bem", "ensemble")


class MethodTables(Table):
    """Which methods run: those whose table is present, no others; see `validation.solvers`."""

    def _faults(self, context: Any) -> Iterator[str]:
        if not self.chosen:
            yield f"give at least one of the tables {', '.join(f'[methods.{name}]' for name in methods())}"

    @property
    def chosen(self) -> dict[str, Method]:
        """Methods whose table is present, by name, in the order of the registry."""
        return {name: method for name, method in methods().items() if self.options(name) is not None}

    @property
    def solvers(self) -> dict[str, Solver]:
        """Methods that press a surface; the first is what the others are compared with."""
        return {name: method for name, method in self.chosen.items() if isinstance(method, Solver)}

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


class Scene(Title):
    """One comparison: a surface, a solid, a load, the methods, and nothing that is not listed.

    Attributes are the tables of the scene file; every quantity is in SI units.
    """

    before: ClassVar[tuple[str, ...]] = ("sweep",)

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

    def _faults(self, context: Any) -> Iterator[str]:
        """Yield what does not fit together; grids of the tables that the context names are not looked at."""
        surface, load, ensemble, solvers = self.surface, self.load, self.ensemble, list(self.methods.solvers)
        filled: dict[str, str] = {}
        for effect in self.effects:
            if effect.slot in filled:
                yield (
                    f"effects: {filled[effect.slot]!r} and {effect.kind!r} both fill the slot "
                    f"'{effect.slot}'; list one of them"
                )
            filled[effect.slot] = effect.kind
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
        if not load.held and min(load.values) == 0 and "gap law" not in filled:
            yield f"load.{load.key}: 0 needs the effect 'adhesion'; without it nothing touches"
        if self.quantities is not None and not solvers:
            yield "quantities: are read off a contact; add the table of a method that presses"
        if isinstance(surface, FileSurface):
            maps = 1 + len(surface.more_paths)
            if ensemble is not None and ensemble.realisations != maps:
                remedy = "remove the table, or give more_paths" if maps == 1 else f"say realisations = {maps}"
                yield f"ensemble: the measured surface has {maps} map{'s' * (maps > 1)}; {remedy}"
            if maps > 1 and ensemble is None:
                yield f"surface.more_paths: is of an ensemble; add [ensemble] with realisations = {maps}"
            return
        if solvers and surface.seed is None:
            yield (
                f"surface.seed: missing; method {solvers[0]!r} presses one surface; a whole number names it"
            )
        size, needed = max(surface.length), surface.resolving_grid
        # No machine holds that: more likely a number without a unit, which counts as metres.
        hint = f"; length: {size:.6g} was read as {size:.6g} m" if max(needed) > MOST_POINTS else ""
        tables = {f"methods.{name}": self.methods.options(name) for name in solvers}
        for name, table in (*tables.items(), ("ensemble", ensemble)):
            if (
                table is not None
                and name not in (context or ())
                and not getattr(table, "under_resolved", False)
            ):
                for grid in table.grids:
                    if any(n < least for n, least in zip(grid, needed, strict=True)):
                        yield (
                            f"{name}.grids = {list(grid)}: too coarse for lambda_short = "
                            f"{as_length(surface.lambda_short)}; at least {list(needed)} points, or say "
                            f"under_resolved = true in the method's table{hint}"
                        )
        if ensemble is not None and self.ensemble_solver is None:
            quick = [name for name, method in methods().items() if getattr(method, "for_ensembles", False)]
            yield f"ensemble: add the table of a method that is quick enough for it: {', '.join(quick)}"

    @property
    def as_written(self) -> dict[str, Any]:
        """All of it as JSON-ready data, quantities as they were written."""
        made: dict[str, Any] = as_written(
            self.model_dump(exclude_none=True), self.model_dump(mode="json", exclude_none=True)
        )
        return made

    @property
    def given(self) -> dict[str, Any]:
        """What was given, by the variables of a result that are shown in its unit."""
        load, height = self.load, getattr(self.surface, "rms_height", None)
        pressure = load.pressure[0] if isinstance(load.pressure, tuple) else load.pressure
        work = next((effect.work for effect in self.effects if hasattr(effect, "work")), None)
        shown = (
            (pressure, "pressure", "largest_pressure", "pressure_map", "pressure_map_difference"),
            (self.solid.young, "contact_modulus", "surface_modulus", "felt_modulus"),
            (height, "rms_height", "rms_height_spectrum"),
            (work, "work", "work_left"),
            (load.mean_gap or height, "mean_gap"),
        )
        return {name: value for value, *names in shown for name in names}

    @property
    def subsurface(self) -> Subsurface | None:
        """Depths and quantities computed in the solid below the contact."""
        return None if self.quantities is None else self.quantities.subsurface

    @property
    def ensemble_solver(self) -> Solver | None:
        """The listed method that further realisations are solved by: the first that is quick enough."""
        return next((method for method in self.methods.solvers.values() if method.for_ensembles), None)


_LIBRARY = resources.files("validation.scenes") / "library"


def builtin_scenes() -> tuple[str, ...]:
    """Names of the scenes that come with the package."""
    names = (entry.name for entry in _LIBRARY.iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml")))


def scene_text(scene: str) -> tuple[str, Path]:
    """Text of a built-in scene or a scene file, and the folder its relative paths refer to."""
    path, known = Path(scene), builtin_scenes()
    # os.path, because pathlib raises for a name that is too long.
    if path.suffix == ".toml" or os.path.isfile(scene):
        try:
            return path.read_text(encoding="utf-8"), path.parent
        except UnicodeDecodeError:
            problem = "is not UTF-8 text; a scene is a TOML file"
        except OSError as error:
            problem = f"cannot be read: {error.strerror}"
        except ValueError:  # a zero byte in the name
            problem = "is no name of a file"
    elif scene in known:
        return (_LIBRARY / f"{scene}.toml").read_text(encoding="utf-8"), Path()
    else:
        hint = did_you_mean(scene, known)
        problem = f"no such scene{hint}; give a .toml file or one of: {', '.join(known)}"
    raise SceneError(scene, [problem])


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
        problem = "[sweep]: is many scenes; fem-contact run and explain take it, this does not"
        raise SceneError(scene, [problem])
    return checked_scene(data, folder, scene)


def checked_scene(data: Mapping[str, Any], folder: Path, scene: str, *, grids_chosen: bool = False) -> Scene:
    """Return the scene that parsed tables say, with the path of a measured surface made absolute.

    Relative paths refer to `folder`; messages, one line for each problem, name the scene `scene`. Where grids
    and number of surfaces will be chosen, the number may be missing and the grids may be too coarse.
    """
    faults: list[str] = []
    try:
        data = sized(dict(data), folder, scene)
    except SceneError as error:  # of the map; those of other tables are said with them
        faults, data = [*error.problems], {**data, "surface": None}
    try:
        if grids_chosen and isinstance(data.get("ensemble"), dict):
            data = {**data, "ensemble": {"realisations": 2, **data["ensemble"]}}
        context = _GRIDS_CHOSEN if grids_chosen else None
        # A scene without a name has that of its file, if that makes a name.
        stem = {"name": Path(scene).stem} if re.fullmatch(NAME, Path(scene).stem) else {}
        checked = Scene.model_validate({**stem, **with_usual_grids(data, folder)}, context=context)
    except ValidationError as error:
        others = [words for words in problems(error) if not (faults and words.startswith("surface"))]
        raise SceneError(scene, [*others, *faults]) from None
    except UsageError as error:
        raise SceneError(scene, [str(error), *faults]) from None
    # Absolute, because a worker may stand in another folder.
    named = {key: getattr(checked.surface, key, None) for key in ("path", "second_path")}
    paths: dict[str, Any] = {key: (folder / path).resolve() for key, path in named.items() if path}
    if more := getattr(checked.surface, "more_paths", ()):
        paths["more_paths"] = tuple((folder / path).resolve() for path in more)
    return checked.model_copy(update={"surface": checked.surface.model_copy(update=paths)})


def sized(data: dict[str, Any], folder: Path, scene: str) -> dict[str, Any]:
    """Fill in what the file of a surface says: size of a map, waves of a C(q); ask for what nobody says."""
    surface = data.get("surface")
    if not isinstance(surface, dict) or not isinstance(path := surface.get("path"), str):
        return data
    if surface.get("kind") == "spectrum":
        from validation.scenes.surfaces import read_spectrum

        units = None
        with contextlib.suppress(ValidationError):  # which the scene is refused for
            units = TypeAdapter[Any](SpectrumUnits | None).validate_python(surface.get("units"))
        try:
            spectrum, _ = read_spectrum(folder / path, units=units)
        except UsageError as error:
            raise SceneError(scene, [str(error)]) from None
        waves = {"lambda_long": 2 * math.pi / spectrum.q_min, "lambda_short": 2 * math.pi / spectrum.q_short}
        return {**data, "surface": {**waves, **surface}}
    if surface.get("kind") != "file":
        return data
    from validation.scenes.topography.measured import fault_lines, file_says
    from validation.scenes.topography.patch import Topography

    try:
        says = file_says(folder / path)
        length = surface.get("length")
        if length is not None and not isinstance(length, list) and sides_of(length) is None:
            says.check_square("surface.length")
    except UsageError as error:
        raise SceneError(scene, [f"surface.path = {path!r}: {error}"]) from None
    known, fields = {"length": says.lengths, "unit": says.unit, **surface}, FileSurface.model_fields
    sides = "..." if len({*says.heights.shape}) == 1 else ["...", "..."]
    blank = {key: mark for key, mark in (("length", sides), ("unit", "...")) if known[key] is None}
    if not blank:
        return {**data, "surface": {"length": says.lengths, **surface}}
    about = {key: str(fields[key].description).partition("; d")[0] for key in blank}
    missing = [f"surface.{key}: missing, and {path!r} does not say it; {about[key]}" for key in blank]
    # All faults at once: none of the others needs size or unit.
    patch = Topography(heights=says.heights, lengths=(1.0, 1.0))
    asked = {key: surface.get(key, fields[key].default) for key in ("tilt", "missing", "edges")}
    if faults := patch.faults(**asked):
        lines = fault_lines(faults, {**surface, **blank})
        missing.append("\n".join(("cannot be pressed as it is", *lines)))
    raise SceneError(scene, missing)


#: Points on the shortest wave of the coarsest usual grid; the others halve its spacing once and twice.
_POINTS = 4
#: What one solve on a usual grid may take: bytes, and pairs of real 256 x 256 transforms, of a millisecond.
_BYTES, _PAIRS = 2 * 2**30, 6e5
#: In place of grids where the surface is refused anyway.
_ANY: list[Any] = [32, 64]


def usual_grids(lengths: Pair, shortest: float) -> tuple[Grid, ...]:
    """Return grids with at least 4, 8 and 16 points on the shortest wave, of sizes that transform quickly."""
    nx, ny = (2 * int(next_fast_len(math.ceil(_POINTS * n / shortest / 2 - 1e-9))) for n in lengths)
    return (nx, ny), (2 * nx, 2 * ny), (4 * nx, 4 * ny)


def affordable(solver: Solver, grid: Grid, *, lengths: Pair, options: Any) -> bool:
    """Whether a solve on a grid is predicted to take at most 2 GiB, and about ten minutes."""
    cost = solver.cost(Size(grid=grid, lengths=lengths, settings=dict(solver.settings(options))))
    return cost.peak_bytes <= _BYTES and cost.pairs <= _PAIRS


def with_usual_grids(data: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the tables of a scene with usual grids for each method that names none, and for its ensemble.

    A method has those that it can afford, the ensemble the first two.

    A UsageError for a method that cannot afford the coarsest.
    """
    filled, tables = dict(data), data.get("methods")
    named = {"ensemble": data.get("ensemble"), **(tables if isinstance(tables, dict) else {})}
    lacking = {n: table for n, table in named.items() if isinstance(table, dict) and "grids" not in table}
    solvers = {n: method for n, method in methods().items() if n in lacking and isinstance(method, Solver)}
    if not solvers and "ensemble" not in lacking:
        return filled
    waves = _waves(data.get("surface"), folder)
    usual = usual_grids(**waves) if waves else ()
    if "ensemble" in lacking:
        filled["ensemble"] = {**lacking["ensemble"], "grids": list(map(list, usual[:2])) or _ANY}
    for name, solver in solvers.items():
        grids = list(map(list, usual)) or _ANY
        with contextlib.suppress(ValidationError):  # which the scene is refused for
            options = solver.options.model_validate({**lacking[name], "grids": grids})
            fitting = (g for g in usual if affordable(solver, g, lengths=waves["lengths"], options=options))
            grids = list(map(list, fitting)) or _ANY
            if usual and grids is _ANY:
                nx, ny = usual[0]
                raise UsageError(
                    f"methods.{name}.grids: missing; {_POINTS} points on the shortest wave are {nx} x {ny}, "
                    "more than 2 GiB or ten minutes a solve; name grids that you can wait for"
                )
        filled["methods"] = {**filled["methods"], name: {**lacking[name], "grids": grids}}
    return filled


def _waves(surface: object, folder: Path) -> dict[str, Any]:
    """Return `lengths` and `shortest` wave of the table of a surface; of a map it is two points at least."""
    try:
        table = TypeAdapter[Any](Surface).validate_python(surface)
    except ValidationError:  # which the scene is refused for
        return {}
    if not isinstance(table, FileSurface):
        return {"lengths": table.length, "shortest": table.lambda_short}
    from validation.scenes.topography.measured import file_says

    points = file_says(folder / table.path).heights.shape
    spacing = (length / n for length, n in zip(table.length, points, strict=True))
    return {"lengths": table.length, "shortest": max(2 * max(spacing), table.lambda_short or 0.0)}
