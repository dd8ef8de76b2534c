"""The keys that a scene may have: unit, default, meaning and an example of each, read off its tables."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from validation.effects import effect_kinds
from validation.scenes.tables import SURFACES, Ensemble, Load, Quantities, RunOptions, SolidSpec, Title
from validation.solvers import methods
from validation.units import choices_of, example_of, unit_of

#: What the key `sweep` may hold, and its mode.
SWEPT = "Any key of surface, solid, load, methods, ensemble, effects and quantities, with a list of values"
MODE = 'every value with every other; "zip" pairs them'


def tables(kind: object = None) -> Iterator[tuple[str, str, type[BaseModel]]]:
    """Yield each table of a scene: its place in the names of keys, its head in a file, what it holds."""
    yield "", "The file itself", Title
    for name, table in SURFACES.items():
        if kind == name or kind not in SURFACES:
            yield "surface", f'`[surface]`, `kind = "{name}"`', table
    yield from (("solid", "`[solid]`", SolidSpec), ("load", "`[load]`", Load))
    for name, method in methods().items():
        yield f"methods.{name}", f"`[methods.{name}]`", method.options
    yield "ensemble", "`[ensemble]`", Ensemble
    for name, effect in effect_kinds().items():
        yield f"effects.{name}", f'`[[effects]]`, `kind = "{name}"`', effect
    for name, info in Quantities.model_fields.items():
        yield f"quantities.{name}", f"`[quantities.{name}]`", get_args(info.annotation)[0]
    yield "run", "`[run]`", RunOptions


def scene_keys(data: Mapping[str, Any]) -> dict[str, FieldInfo]:
    """Return the keys that a scene may have, with what each means; an effect is named by its kind.

    The kind of surface that `data`, the tables of a scene, say narrows the choice.
    """
    surface = data.get("surface")
    kind = surface.get("kind") if isinstance(surface, dict) else None
    keys: dict[str, FieldInfo] = {}
    for place, _, table in tables(kind if isinstance(kind, str) else None):
        for key, info in _keys_of(place, table):
            keys.setdefault(key, info)
    return keys


def _keys_of(place: str, table: type[BaseModel]) -> Iterator[tuple[str, FieldInfo]]:
    """Yield the keys of a table as a reader writes them; an effect's kind is its place."""
    for name, info in table.model_fields.items():
        if not (name == "kind" and place.startswith("effects.")):
            yield f"{place}.{name}".lstrip("."), info


def facts(info: FieldInfo) -> tuple[str, str]:
    """Return of a key what it means with what it may be, and its default; its example stands elsewhere."""
    meaning = re.sub(rf",? {re.escape(f'e.g. {example_of(info)}')}", "", info.description or "")
    meaning, _, default = meaning.partition("; default: ")
    choices, unit = choices_of(info), unit_of(info)
    if unit != "1":
        meaning += f" (plain numbers in {unit})"
    elif len(choices) > 1:
        meaning += f" ({' or '.join(choices)})"
    if info.is_required():
        return meaning, default or "required"
    if info.default in (None, "", ()):
        return meaning, default
    return meaning, str(info.default).lower() if isinstance(info.default, bool) else str(info.default)


def key_lines(word: str) -> Iterator[str]:
    """Yield two lines for each key whose name or meaning has a word: its example, then what it means."""
    every, told = [], set[tuple[str, ...]]()
    for place, head, table in tables():
        for key, info in _keys_of(place, table):
            about = facts(info)
            if (key, *about) not in told:
                of = f"    # {head.replace('`', '')}" if any(key == known for known, *_ in told) else ""
                told.add((key, *about))
                every.append((f"{key} = {example_of(info)}{of}", *about))
    every.append(("sweep.load.reduced_pressure = [0.01, 0.03, 0.1]", SWEPT, ""))
    every.append(('sweep.mode = "product"', MODE, "product"))
    for example, meaning, default in every:
        usual = default if default in ("", "required") else f"default: {default}"
        lines = example, f"    {'; '.join(filter(None, (meaning, usual)))}"
        if word.lower() in "\n".join(lines).lower():
            yield from lines
