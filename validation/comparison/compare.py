"""Results folders side by side: their datasets along a new dimension, and how far each is from the first.

Nothing here solves, and nothing but records and datasets is read.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy.special
import xarray as xr

from validation.errors import UsageError
from validation.execution.results import Outputs, Result, leave, read_results, record_of
from validation.files import prepare_folder
from validation.report.estimates import NORMAL, claim_surfaces, derive, total_error
from validation.report.findings import Finding, finding, note
from validation.report.page import RECORD, page_of
from validation.report.places import each
from validation.report.quantities import in_prefixed_unit, labelled, place_words, quantity_of
from validation.report.table import ResultTable, Row, WordTable, shown, value_cells
from validation.report.values import Value, value_of
from validation.report.views import Card, Figure, Line, Views, against
from validation.scenes.keys import scene_keys
from validation.units import unit_of

_KINDS = {"run": "runs", "sweep": "sweeps", "theory": "runs of the theory alone"}
#: What is not compared: names of solves, maps, what a run took, and what says how another number was made.
_LEFT_OUT = ("solve", "seconds", "points", "unknowns", "resolved", "stress_", "magnification", "plane_")
#: Dimensions of what figures show of fields.
_FIELDS = ("x", "y", "shift", "wave", "near", "near_exact", "wide", "wide_exact", "plane", "wavevector")
#: Rows of the page, and of the variables with an interval that have a figure; table.csv has all of them.
_ROWS, _FIGURES, _FINDINGS = 120, 3, 4
_JOINT = (
    "+-: 95 %; that of a difference of means is from surface to surface, and all else as if independent: "
    "of the same grids differences are better known than that."
)
_FIRST = "the first, with which the others are compared"
#: What is asked for where a load is given in one of these ways, and so is nothing found.
_HELD = {"approach": {"load.offset", "load.mean_gap"}, "mean_gap": {"load.mean_gap"}}
#: What says again, in sentences, what another variable says.
_TWICE = ("_own", "_limit", "_excess", "_located", "_each")


def compare_folders(folders: Sequence[Path], output: Path, *, report: bool = True) -> Outputs:
    """Put results folders on one page, and write it.

    A UsageError where fewer than two can be compared, or `output` holds results of its own.
    """
    results, left_out = _read(folders)
    # A record that cannot be read may be that of a run.
    if (output / RECORD).exists() and record_of(output).get("kind") != "compare":
        raise UsageError(f"--output {output}: holds results of its own; name another folder")
    data, differ = side_by_side(results), differing(results)
    settings = {label: dict(result.settings) for label, result in results.items()}
    label, first = next(iter(results.items()))
    kind = _KINDS.get(first.kind, f"results of the {_question(first)}")
    table = _table(data)
    short = replace(table, rows=table.rows[:_ROWS])
    more = f"{len(table.rows) - _ROWS} more rows are in table.csv. " if len(table.rows) > _ROWS else ""
    tables = [shown(short, title="Numbers side by side", note=more + _JOINT)]
    if differ:
        columns, rows = ("setting", *results), tuple((key, *values) for key, values in differ.items())
        title = "Settings that differ"
        tables.append(WordTable(title=title, columns=columns, rows=rows, left=frozenset(columns)))
    flat = {name: _flat_settings(result) for name, result in results.items()}
    seeds = (f"{name}: {one.get('surface.seed') or one.get('seed') or 'none'}" for name, one in flat.items())
    page = page_of(
        data,
        Views(
            figures=tuple(itertools.islice(_figures(data), _FIGURES)),
            findings=(*_findings(data, differ), *map(note, left_out)),
            cards=tuple(_cards(data, differ)),
        ),
        figures=report,
        title=" beside ".join(results),
        lead=f"{len(results)} {kind}. What differs in what was asked, and in what came out; differences are "
        f"from {label}",
        tables=tuple(tables),
        settings=settings,
        seeds="; ".join(seeds),
        papers=(),
        records={"table": table},
        data=None,  # table.csv has all numbers
        summary={
            "kind": "compare",
            "results": {name: str(folder) for name, folder in _labels(folders).items() if name in results},
            "differing": {key: list(values) for key, values in differ.items()},
            "not_compared": list(left_out),
        },
    )
    record: Any = {"kind": "compare", "name": page.title, "settings": settings, "store": output}
    return leave(prepare_folder(output), data, lambda *_, **__: page, report=report, **record)


def _read(folders: Sequence[Path]) -> tuple[dict[str, Result], tuple[str, ...]]:
    if len({folder.resolve() for folder in folders}) < max(2, len(folders)):
        raise UsageError("compare: needs at least two results folders, each named once")
    results: dict[str, Result] = {}
    left_out = []
    for label, folder in _labels(folders).items():
        try:
            result = read_results(folder)
            question, first = (_question(one) for one in (result, next(iter(results.values()), result)))
            if question != first:
                raise UsageError(f"it is a {question}, and the first is a {first}")
        except UsageError as error:
            left_out.append(f"{folder}: not compared: {str(error).removeprefix(f'{folder}: ')}")
        else:
            results[label] = result
    if len(results) < 2:
        why = "; ".join(left_out)
        raise UsageError(f"{why}; fewer than two folders are left: name results folders of one kind")
    return results, tuple(left_out)


def _question(result: Result) -> str:
    words = {"theory": "run of the theory alone", "study": f"study {result.name}"}
    return words.get(result.kind, result.kind)


def _labels(folders: Sequence[Path]) -> dict[str, Path]:
    """Name folders, no two of which are the same, by as much of their paths as tells them apart."""
    named = ({"/".join(f.resolve().parts[-length:]): f for f in folders} for length in itertools.count(1))
    return next(names for names in named if len(names) == len(folders))


def side_by_side(results: Mapping[str, Result]) -> xr.Dataset:
    """Return the numbers that all results have, along ``result``, and of each its difference from the first.

    Where they have other places (another grid, another load) those that all share are compared.

    A UsageError where they share no place, or have different numbers of rows that nothing names.
    """
    parts = []
    for whole in (result.data.drop_dims(_FIELDS, errors="ignore") for result in results.values()):
        numbers = [str(name) for name, values in whole.data_vars.items() if values.dtype.kind in "fiu"]
        kept = [n for n in numbers if not n.startswith(_LEFT_OUT) and not n.endswith("_drift")]
        parts.append(whole[kept])
    if len({str(part.theory.values) for part in parts if part.sizes.get("theory") == 1}) == len(parts):
        parts = [part.isel(theory=0, drop=True) for part in parts]  # one each, which are what is compared
    first = parts[0]
    names = [n for n in first.data_vars if all(n in part and part[n].dims == first[n].dims for part in parts)]
    placed = [_placed(part)[names].drop_attrs(deep=False) for part in parts]
    try:
        parts = list(xr.align(*placed, join="inner"))
    except ValueError as error:
        raise UsageError(f"{', '.join(results)}: rows without names cannot be paired: {error}") from error
    # What has no place in common, such as grids, is left out.
    parts = [part.drop_dims([dim for dim, size in part.sizes.items() if not size]) for part in parts]
    names = list(parts[0].data_vars)
    if not names:
        remedy = "their datasets share no place; compare results with common values"
        raise UsageError(f"{', '.join(results)}: {remedy}")

    def common(attrs: Sequence[Mapping[str, Any]], context: Any = None) -> dict[str, Any]:
        # Those that all have: what does not enter one result may enter another.
        return {k: v for k, v in attrs[0].items() if all(k in other and other[k] == v for other in attrs)}

    data = xr.concat(parts, dim="result", combine_attrs=common, join="exact")
    data = data.assign_coords(result=list(results))
    values = [str(name) for name in names if not str(name).endswith("_error")]
    errors = {name: data[f"{name}_error"] for name in values if f"{name}_error" in data}
    # A source that some of them measured is in all differences: none is surer than what it is of.
    known = data
    for name, half in errors.items():
        own: Any = total_error(data, name)
        gap = half.isnull() & half.notnull().any("result") & own.notnull()
        known = known.assign({f"{name}_error": half.where(~gap, 0.0)})
    first = known.isel(result=0, drop=True)
    beside = {f"{name}_first": first[name] for name in values}
    beside |= {f"{name}_first_error": first[f"{name}_error"] for name in errors}
    made = derive(known.assign(beside), **{f"{name}_apart": f"{name} - {name}_first" for name in values})
    for name in values:  # What rounding leaves of a difference is none; unknown and endless ones stay.
        difference = made[f"{name}_apart"]
        made[f"{name}_apart"] = difference.where(~(abs(difference) < 1e-12 * abs(made[name])), 0.0)
        made = claim_surfaces(made, f"{name}_apart", f"{name}_each_apart", of=data[name].attrs)
    # The first is no further from itself than nothing.
    apart = [name for name in made.data_vars if name not in data and name not in beside]
    return labelled(data.assign(made[apart].where(made.result != made.result[0], 0.0)))


def _placed(data: xr.Dataset) -> xr.Dataset:
    """Give dimensions without values of their own those of the first coordinate along them, as loads have."""
    for dim in map(str, data.dims):
        coordinates = [str(n) for n, c in data.coords.items() if c.dims == (dim,)]
        if dim not in data.coords and coordinates:
            name, values = coordinates[0], data[coordinates[0]].values
            data = data.drop_vars(coordinates).rename({dim: name}).assign_coords({name: values})
    return data


# ---- what was asked --------------------------------------------------------------------------------


def _flat(tree: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, str]]:
    """Yield dotted keys and their values in words; effects and swept keys are named by what they are."""
    for key, value in tree.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{before}{key}.")
        elif isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
            for item in value:
                name = item.get("kind") or item.get("key", "")
                yield f"{before}{key}.{name}", "listed"
                inner = {k: v for k, v in item.items() if k not in ("kind", "key", "name", "meaning", "unit")}
                yield from _flat(inner, f"{before}{key}.{name}.")
        else:
            info = scene_keys({}).get(before + key)
            yield before + key, _word(value, "1" if info is None else unit_of(info))


def _word(value: Any, unit: str) -> str:
    if isinstance(value, list):
        return ", ".join(_word(item, unit) for item in value)
    if not isinstance(value, float):
        return str(value)
    return f"{value:.6g}" if unit == "1" else in_prefixed_unit(value, unit, 6)


def _flat_settings(result: Result) -> dict[str, str]:
    settings = {key: value for key, value in result.settings.items() if key not in ("written", "cases")}
    scene = {k: v for k, v in settings.pop("scene", {}).items() if k not in ("name", "title", "run")}
    swept = [key["key"] for key in settings.get("sweep", {}).get("keys", ())]
    # Of an accuracy what was reached is no setting.
    return {
        k: v
        for k, v in _flat({**scene, **settings})
        if k not in swept and (not k.startswith("accuracy.") or k == "accuracy.target")
    }


def differing(results: Mapping[str, Result]) -> dict[str, tuple[str, ...]]:
    """Return the settings that differ, each with its value in every result; "" where it has none."""
    every = [_flat_settings(result) for result in results.values()]
    keys = dict.fromkeys(itertools.chain(*every))
    values = {key: tuple(settings.get(key, "") for settings in every) for key in keys}
    return {key: value for key, value in values.items() if len(set(value)) > 1}


# ---- what is shown ---------------------------------------------------------------------------------


def _compared(data: xr.Dataset) -> list[str]:
    names = [str(n).removesuffix("_apart") for n in data.data_vars if str(n).endswith("_apart")]
    # The scene's own surface says nothing new where no other was pressed.
    twice = "area" in data and "area_own" in data and data.area.equals(data.area_own)
    names = [name for name in names if name in data and not (twice and name.endswith("_own"))]

    def order(name: str) -> tuple[bool, bool, bool, int]:
        alike = bool((data[f"{name}_apart"] == 0).all())
        return alike, f"{name}_apart_error" not in data, not name.startswith("area"), data[name].ndim

    return sorted(names, key=order)


def _places(data: xr.Dataset, name: str) -> Iterator[tuple[str, xr.Dataset]]:
    dims = [str(dim) for dim in data[name].dims if dim != "result"]
    names = [n for n in (name, f"{name}_error", f"{name}_apart", f"{name}_apart_error") if n in data]
    for here in each(data[names], *dims):
        if here[name].notnull().all():
            yield ", ".join(filter(None, (_place(here, dim, data) for dim in dims))), here


def _place(here: xr.Dataset, dim: str, data: xr.Dataset) -> str:
    return place_words(here, dim, data) if dim in data.coords else f"{dim} {here.attrs['at'][dim] + 1}"


def _table(data: xr.Dataset) -> ResultTable:
    rows: list[Row] = []
    for name in _compared(data):
        for place, here in _places(data, name):
            for k, label in enumerate(data.result.values):
                part = here.isel(result=k)
                value, apart = value_of(part, name), value_of(part, f"{name}_apart")
                cells = {"quantity": quantity_of(data, name).title, "where": place, "result": str(label)}
                off = value_cells("less the first", apart) if k else {"less the first": np.nan}
                rows.append({**cells, **value_cells("value", value), **off})
    return ResultTable.of_rows(rows)


def _cards(data: xr.Dataset, differ: Mapping[str, Sequence[str]]) -> Iterator[Card]:
    keys = list(differ)
    shown_keys = ", ".join(keys[:3]) + (", ..." if len(keys) > 3 else "")
    count = f"{len(keys)} setting{'' if len(keys) == 1 else 's'}"
    yield Card("What differs in what was asked?", shown_keys or "nothing", count)
    if "area" not in data or data.area.dims != ("result",):
        return
    for k, label in enumerate(data.result.values):
        here = data.isel(result=k)
        basis = finding("value", "{area_apart:+} from it", here) if k else _FIRST
        yield Card(f"A/A0, {label}", finding("value", "{area}", here), basis)


def _findings(data: xr.Dataset, differ: Mapping[str, Sequence[str]]) -> Iterator[Finding]:
    if differ:
        words = [f"{key} ({'; '.join(v or 'none' for v in values)})" for key, values in differ.items()]
        more = f", and {len(words) - 6} more settings" if len(words) > 6 else ""
        # As a value, whatever braces are in it.
        yield note("{settings}", settings=f"They differ in {', '.join(words[:6])}{more}.")
    else:
        yield note("No setting differs: these are results of one and the same question.")
    every = _compared(data)
    names = [n for n in every if f"{n}_apart_error" in data and not n.endswith(_TWICE)]
    names = [n for n in names if not _HELD.get(n, set()) & differ.keys()]
    if all(bool((data[f"{n}_apart"] == 0).all()) for n in names):  # so what has none tells them apart
        names += [n for n in every if n not in names and bool((data[f"{n}_apart"] != 0).any())][:2]
    for name in names[:_FINDINGS]:
        for k in range(1, data.sizes["result"]):
            yield _farthest(data, name, k)
    if not names:
        yield note("No number that they share has an interval: how far they are apart cannot be judged.")
    draws = ("surface.seed", "seed", "surface.hurst", "surface.lambda", "ensemble.")
    single = data.get("surfaces", xr.DataArray([])) == 1
    if single.any() and (not single.all() or any(key.startswith(draws) for key in differ)):
        yield note(
            "Their surfaces differ, and an interval of one surface is that of the grids: another draw of the "
            "same spectrum would differ, too, by how much an [ensemble] in every scene tells."
        )


def _farthest(data: xr.Dataset, name: str, k: int) -> Finding:
    """Say how far a result is from the first in one quantity, where that is most for its interval."""

    def rank(apart: Value) -> tuple[bool, float]:
        """Difference over its error, by which places are ranked; those without an error come last."""
        far, sure = abs(float(apart.value)), apart.error is not None and np.isfinite(apart.error)
        if far == 0 or not sure:
            return bool(sure), far
        return True, far / apart.error if apart.error else np.inf

    places, what = list(_places(data, name)), quantity_of(data, name)
    symbol = ", ".join(filter(None, (what.symbol, what.which)))
    if not places:
        return note("{symbol}: no value in common.", symbol=symbol)
    first, other = (str(data.result.values[j]) for j in (0, k))
    names: dict[str, Any] = {"symbol": symbol, "first": first, "other": other}
    differences = [value_of(here.isel(result=k), f"{name}_apart") for _, here in places]
    if all(apart.value == 0 for apart in differences):
        return note("{symbol}: {other} and {first} agree to the last digit.", **names)
    apart = max(differences, key=rank)
    place, here = places[differences.index(apart)]
    # The worst of many places is far for an interval of one.
    most = float(scipy.special.ndtri(1 - 0.025 / len(places))) / NORMAL
    return finding(
        "agreement",
        "{symbol}{place}: {other} has {mine:p} and {first} {its:p}; they {verdict} (difference "
        "{apart:+p}[, of {places} places the one where it is largest for its interval]).",
        by="joint",
        place=f" ({place})" if place else "",
        mine=value_of(here.isel(result=k), name),
        its=value_of(here.isel(result=0), name),
        apart=apart,
        joint=replace(apart, error=None if apart.error is None else most * apart.error),
        places=float(len(places)) if len(places) > 1 else math.nan,
        **names,
    )


def _figures(data: xr.Dataset) -> Iterator[Figure]:
    for name in _compared(data):
        dims = [str(dim) for dim in data[name].dims if dim != "result"]
        numeric = [dim for dim in dims if dim in data.coords and data[dim].dtype.kind in "fiu"]
        axes = [dim for dim in numeric if data.sizes[dim] > 1]
        if f"{name}_error" not in data or len(dims) > 2 or (dims and not axes):
            continue
        rest = {dim: data.sizes[dim] // 2 for dim in dims if dim != axes[0]} if axes else {}
        place = ", ".join(_place(data.isel({dim: k}), dim, data) for dim, k in rest.items())
        x = axes[0] if axes else "result"
        line = Line(name, by="result" if axes else (), at=rest, joined=bool(axes))
        caption = f"Of every result: {quantity_of(data, name).meaning}{place and f' ({place})'}."
        yield Figure(name.replace("_", "-"), caption, [against(x, line)])
