"""Mistakes that pydantic finds in the table of a scene or the options of a study, each in one line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ValidationError

from validation.effects import effect_kinds
from validation.effects.base import effect_key
from validation.errors import did_you_mean
from validation.scenes.keys import scene_keys
from validation.scenes.tables import SURFACES
from validation.units import allowed, brief


def problems(error: ValidationError, *, flags: bool = False) -> list[str]:
    """List one line for each mistake: key = value: what is allowed.

    An array with a wrong item is not also called too short, nor its other items missing. With `flags` the
    keys are options of a command.
    """
    items = error.errors()
    wrong = {item["loc"][:-1] for item in items if item["type"] != "missing"}
    items = [i for i in items if i["type"] != "too_short" or i["loc"] not in wrong]
    # The values of a pair have no keys of their own.
    absent = [i for i in items if i["type"] == "missing" and isinstance(i["loc"][-1], int)]
    short = {i["loc"][:-1]: i for i in absent if i["loc"][:-1] not in wrong}
    items = [i for i in items if i not in absent]
    items += [
        {**i, "type": "too_short", "loc": array, "ctx": {"min_length": int(i["loc"][-1]) + 1}}
        for array, i in short.items()
    ]
    # A mistake of a value that stands for several items of an array is told of the array.
    alike: dict[tuple[Any, ...], list[Any]] = {}
    for item in items:
        *array, last = item["loc"] or ("",)
        place = (*array, last if isinstance(last, str) else None)
        alike.setdefault((place, item["msg"], brief(item["input"])), []).append(item)
    each: list[Any] = [
        {**first, "loc": first["loc"][:-1]} if others else first for first, *others in alike.values()
    ]
    return list(map(_flag_problem if flags else _problem, each))


def _flag_problem(item: Any) -> str:
    value = item["input"]
    given = ",".join(map(str, value)) if isinstance(value, list) and value else brief(value)
    flag = f"--{str(item['loc'][0]).replace('_', '-')} = {given}: " if item["loc"] else ""
    return f"{flag}{allowed(item)}"


#: Values of `kind`, and all that stands in pydantic's locations without being a key.
_KINDS: dict[str, Mapping[str, Any]] = {"surface": SURFACES, "effects": effect_kinds()}
_TAGS = {*SURFACES, *effect_kinds(), "one", "several"}


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
    # Keys that lead to it, as the file has them.
    parts = [str(part) for part in item["loc"]]
    place = {"surface": 1, "effects": 2, "load": 2}.get(parts[0] if parts else "", len(parts))
    location = parts[:place] + [part for k, part in enumerate(parts[place:]) if k or part not in _TAGS]
    key, kind, value = _written(location), _written([*location, "kind"]), item["input"]
    if item["type"] == "missing":
        surface, *tags = parts[:2]
        keys = scene_keys({"surface": {"kind": tags[0]}} if surface == "surface" and tags else {})
        effect = [part for part in parts if location[0] == "effects" and part in effect_kinds()]
        full = ".".join(["effects", *effect[:1], location[-1]] if effect else location)
        info = next((keys[name] for name in keys if name == full or name.endswith(f".{full}")), None)
        named = (info and info.description) or f"the table [{'.'.join(location)}] is required"
        return f"{key}: missing; {named}"
    if item["type"] == "union_tag_not_found":
        named = ", ".join(repr(kind) for kind in sorted(_KINDS[location[0]]))
        return f"{kind}: missing; one of {named}"
    if item["type"] == "union_tag_invalid":
        hint = did_you_mean(str(value.get("kind")), _KINDS[location[0]])
        return f"{kind} = {brief(value.get('kind'))}: must be one of {item['ctx']['expected_tags']}{hint}"
    if isinstance(value, (dict, BaseModel)):
        return f"{key}: {allowed(item)}" if key else allowed(item)
    return f"{key} = {brief(value)}: {allowed(item)}"
