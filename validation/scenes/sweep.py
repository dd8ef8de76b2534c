"""Sweeps: one scene at several values of its keys, and keys that are set from outside the file."""

from __future__ import annotations

import copy
import itertools
import math
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from validation.errors import SceneError, UsageError, did_you_mean
from validation.report.quantities import in_prefixed_unit
from validation.scenes.keys import scene_keys
from validation.scenes.scene import Scene, checked_scene, parsed_toml, scene_text
from validation.scenes.tables import LOADS, RunOptions
from validation.units import MOST_ITEMS, brief, plain_number, unit_of

Value = float | int | str
Mode = Literal["product", "zip"]
MODES: tuple[Mode, ...] = ("product", "zip")

#: Scenes of one sweep; each has solves of its own.
_MOST_CASES = 4096
#: Keys of which a scene gives one: setting the one takes the other out.
_EITHER = (
    frozenset(f"load.{key}" for key in LOADS),
    frozenset({"surface.rms_gradient", "surface.rms_height"}),
)
#: Last words of keys that mean something else in a dataset of a sweep.
_TAKEN = frozenset(
    {"area", "solver", "kappa", "theory", "case", "scatter", "grid", "shift", "shifts", "surface", "surfaces"}
    | {"source", "solve", "points", "spacing", "residual", "seconds", "unknowns", "resolved", "depth", "load"}
)


@dataclass(frozen=True, kw_only=True)
class SweptKey:
    """A key of a scene, such as "load.reduced_pressure", and the values it takes, in SI.

    In the dataset it is named by its last word, or the last two where that would not tell.
    """

    key: str
    name: str
    unit: str
    meaning: str
    values: tuple[Value, ...]


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """The scenes that a table [sweep] makes of one; of a product the last key runs fastest."""

    scenes: tuple[Scene, ...]
    keys: tuple[SweptKey, ...]
    mode: Mode

    @property
    def name(self) -> str:
        """Name of the scene that is swept."""
        return self.scenes[0].name

    @property
    def run(self) -> RunOptions:
        """How the sweep is run."""
        return self.scenes[0].run

    @property
    def given(self) -> dict[str, Any]:
        """What was given, by the variables of a result that are shown in its unit."""
        return self.scenes[0].given | {key.name: key.values[0] for key in self.keys}

    def place(self, case: int) -> str:
        """Say where a case stands, such as "young = 2 GPa, seed = 7"."""
        counts = [len(key.values) for key in self.keys]
        places: Any = [case] * len(counts) if self.mode == "zip" else np.unravel_index(case, counts)
        pairs = zip(self.keys, places, strict=True)
        return ", ".join(f"{key.name} = {value_words(key.values[k], key.unit)}" for key, k in pairs)


def value_words(value: Value, unit: str = "1") -> str:
    """Write a value and its unit.

    >>> value_words(2e6, "Pa"), value_words(0.05), value_words("smooth")
    ('2 MPa', '0.05', 'smooth')
    """
    return in_prefixed_unit(value, unit, digits=6) if isinstance(value, float) else str(value)


def load_asked(scene: str, settings: Sequence[str] = (), *, grids_chosen: bool = False) -> Scene | Sweep:
    """Read a scene with some keys set otherwise, and expand its table [sweep] if it has one.

    Settings are ``key=value``, the value as in the file; quotes round a quantity may be left out. One that
    names no key is a UsageError; a SceneError has one line for each problem: key, value, what is allowed.
    """
    text, folder = scene_text(scene)
    data = parsed_toml(text, scene)
    given: list[str] = []
    for setting in settings:
        key = _set_from_outside(data, setting)
        if key in given:
            raise UsageError(f"--set {key}: is set twice; give one value")
        _refuse_rivals(f"--set {key}", key, given, "set")
        given.append(key)
    if "sweep" not in data:
        return checked_scene(data, folder, scene, grids_chosen=grids_chosen)
    try:
        mode, lists = _table(data.pop("sweep"), data)
        scenes = tuple(_expanded(data, mode, lists, folder=folder, scene=scene))
        return Sweep(scenes=scenes, keys=_swept(scenes, mode, lists), mode=mode)
    except SceneError:
        raise
    except UsageError as error:
        raise SceneError(scene, [f"[sweep] {error}"]) from None


def _refuse_rivals(place: str, key: str, others: Iterable[str], how: str) -> None:
    """Refuse a key beside one that it excludes, such as two loads."""
    if rivals := [k for k in others if k != key and any({k, key} <= pair for pair in _EITHER)]:
        raise UsageError(f"{place}: excludes {rivals[0]}, which is {how}, too; leave one of them out")


def _set_from_outside(data: dict[str, Any], setting: str) -> str:
    """Set one key, as --set says it, and return it in full."""
    key, equals, text = setting.partition("=")
    key = key.strip()
    if not (equals and key):
        raise UsageError(f"--set {setting}: must be key=value, such as solid.young='2 GPa'")
    table, swept = data.get("sweep"), key.startswith("sweep.")
    try:
        flat = dict(_flat(table)) if isinstance(table, dict) else {}
        listed = {k: k if k == "mode" else _found_key(k, data) for k in flat}
        name = "mode" if key == "sweep.mode" else _found_key(key.removeprefix("sweep."), data)
        if swept:
            data["sweep"] = {**{k: v for k, v in flat.items() if listed[k] != name}, name: _value(text)}
        elif name in listed.values():
            raise UsageError(f"{name}: is swept; set sweep.{name}=[...] instead")
        else:
            _refuse_rivals(name, name, listed.values(), "swept")
            _put(data, name, _value(text))
    except UsageError as error:
        raise UsageError(f"--set {error}") from None
    return name


def _value(text: str) -> Any:
    """Read a value as a scene file has it; what is no TOML is a text, such as 5 GPa without quotes."""
    text = text.strip()
    try:
        read = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return plain_number(text)
    value = read.pop("value", None)
    return value if not read and isinstance(value, (bool, int, float, str, list)) else text


def _found_key(key: str, data: Mapping[str, Any]) -> str:
    """Return a key in full; its last word does where only one has it. A UsageError for any other."""
    keys = scene_keys(data)
    if key in keys:
        return key
    ending = [full for full in keys if full.endswith(f".{key}")]
    present = [full for full in ending if _present(full, data)] or ending
    effect_key = f"effects.{key}.{key}"  # the hardness of the effect 'hardness' before that of another
    if len(present) == 1 or effect_key in present:
        return effect_key if effect_key in present else present[0]
    if present:
        raise UsageError(f"{key}: is short for {', '.join(present)}; name one of them")
    inside = [full for full in keys if full.startswith(f"{key}.")]
    if inside:
        raise UsageError(f"{key}: is a table; name one of its keys: {', '.join(inside)}")
    # Where tables share a last word, that of one which the scene has is meant.
    last = {full.rpartition(".")[2]: full for full in sorted(keys, key=lambda full: _present(full, data))}
    raise UsageError(f"{key}: is no key of a scene{did_you_mean(key, keys) or did_you_mean(key, (), last)}")


def _present(key: str, data: Mapping[str, Any]) -> bool:
    table, *rest = key.split(".")
    if table == "methods":
        return rest[0] in (data["methods"] if isinstance(data.get("methods"), dict) else ())
    return _effect(data, rest[0]) is not None if table == "effects" else table in data


def _effects(data: Mapping[str, Any]) -> list[Any]:
    listed = data.get("effects")
    return listed if isinstance(listed, list) else []


def _effect(data: Mapping[str, Any], kind: str) -> dict[str, Any] | None:
    return next((e for e in _effects(data) if isinstance(e, dict) and e.get("kind") == kind), None)


def _put(data: dict[str, Any], key: str, value: Any) -> None:
    """Set a key in full; a table, method or effect that is not there is listed with it.

    >>> data = {}
    >>> _put(data, "effects.adhesion.work", 0.05)
    >>> _put(data, "effects.adhesion.law", "dugdale")
    >>> data
    {'effects': [{'kind': 'adhesion', 'work': 0.05, 'law': 'dugdale'}]}
    """
    parts = key.split(".")
    if parts[0] == "effects":
        table = _effect(data, parts[1])
        if table is None:
            table = {"kind": parts[1]}
            data["effects"] = [*_effects(data), table]
    else:
        table = data
        for part in parts[:-1]:
            inner = table.setdefault(part, {})
            if not isinstance(inner, dict):
                raise UsageError(f"{key}: {part} = {brief(inner)} of the scene is no table")
            table = inner
    for rivals in _EITHER:
        for other in rivals - {key} if key in rivals else ():
            table.pop(other.rpartition(".")[2], None)
    table[parts[-1]] = value


def _flat(table: Mapping[str, Any], place: str = "") -> Iterator[tuple[str, Any]]:
    """Yield keys and values of [sweep]: without quotes, load.pressure is a table in a table."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{place}{key}.")
        else:
            yield f"{place}{key}", value


def _table(table: Any, data: Mapping[str, Any]) -> tuple[Mode, dict[str, list[Any]]]:
    """Read [sweep]: the mode, and each key in full with its list."""
    if not isinstance(table, dict):
        raise UsageError("must be a table of keys with lists, such as load.reduced_pressure = [0.01, 0.1]")
    flat = dict(_flat(table))
    mode = flat.pop("mode", "product")
    if mode not in MODES:
        raise UsageError(f"mode = {mode!r}: must be 'product' or 'zip'")
    lists: dict[str, list[Any]] = {}
    for key, values in flat.items():
        full = _found_key(key, data)
        if full.partition(".")[0] in ("name", "title", "run"):
            raise UsageError(f"{full}: says how a scene is called or run, and changes no result")
        if not isinstance(values, list) or not 1 <= len(values) <= MOST_ITEMS:
            raise UsageError(f"{full} = {brief(values)}: must be a list of 1 to {MOST_ITEMS} values")
        if full in lists:
            raise UsageError(f"{full}: is listed twice")
        _refuse_rivals(full, full, lists, "swept")
        lists[full] = values
    if not lists:
        raise UsageError("is empty; list a key with its values, such as load.reduced_pressure = [0.01, 0.1]")
    lengths = {key: len(values) for key, values in lists.items()}
    if mode == "zip" and len(set(lengths.values())) > 1:
        counts = ", ".join(f"{key} has {n}" for key, n in lengths.items())
        raise UsageError(f"mode = 'zip': all lists must be as long; {counts}")
    if mode == "product" and math.prod(lengths.values()) > _MOST_CASES:
        raise UsageError(f"makes {math.prod(lengths.values())} scenes; must be at most {_MOST_CASES}")
    return mode, lists


def _expanded(
    data: dict[str, Any], mode: Mode, lists: Mapping[str, list[Any]], *, folder: Path, scene: str
) -> Iterator[Scene]:
    """Make and check every scene; the first that cannot be run is refused, with the values it stands at."""
    joined: Any = itertools.product if mode == "product" else zip
    for values in joined(*lists.values()):
        here, placed = copy.deepcopy(data), dict(zip(lists, values, strict=True))
        for key, value in placed.items():
            _put(here, key, value)
        try:
            yield checked_scene(here, folder, scene)
        except SceneError as error:
            at = ", ".join(f"{key} = {brief(value)}" for key, value in placed.items())
            # One sentence about a swept value says enough of where it is.
            known = [
                words if "\n" in words or any(key in words for key in lists) else f"{words} ([sweep] at {at})"
                for words in error.problems
            ]
            raise SceneError(scene, known) from None


def _swept(scenes: Sequence[Scene], mode: Mode, lists: Mapping[str, list[Any]]) -> tuple[SweptKey, ...]:
    """Read the values off the checked scenes, where quantities are in SI."""
    last = [key.rpartition(".")[2] for key in lists]
    known = scene_keys({"surface": {"kind": scenes[0].surface.kind}})
    keys, step = [], len(scenes)
    for key, word in zip(lists, last, strict=True):
        step = 1 if mode == "zip" else step // len(lists[key])
        unit, meaning = unit_of(known[key]), known[key].description
        values = tuple(_said(scenes[k * step], key, unit) for k in range(len(lists[key])))
        twice = next((v for k, v in enumerate(values) if mode == "product" and v in values[:k]), None)
        if twice is not None:
            raise UsageError(f"{key}: {value_words(twice, unit)} is listed twice")
        if any(isinstance(value, str) for value in values):
            values, unit = tuple(value_words(value, unit) for value in values), "1"
        taken = word in _TAKEN or (word == "pressure" and key != "load.pressure")
        clear = last.count(word) == 1 and not taken
        name = word if clear else "_".join(key.split(".")[-2:])
        name += "_spectrum" * (key in ("surface.rms_gradient", "surface.rms_height"))  # without: realised
        keys.append(SweptKey(key=key, name=name, unit=unit, meaning=meaning or key, values=values))
    return tuple(keys)


def _said(scene: Scene, key: str, unit: str) -> Value:
    """Value of a key in a checked scene, as a coordinate: a number or words."""
    value: Any = scene
    for part in key.split("."):
        tables = value if isinstance(value, tuple) else ()
        value = next((effect for effect in tables if effect.kind == part), None) or getattr(value, part)
    if isinstance(value, tuple) and len(set(value)) == 1 and isinstance(value[0], float):
        value = value[0]
    if isinstance(value, tuple):  # grids as 32x32, 64x64
        items = ("x".join(map(str, n)) if isinstance(n, tuple) else value_words(n, unit) for n in value)
        return ", ".join(items)
    return value if isinstance(value, (int, float)) and not isinstance(value, bool) else str(value)
