"""The page of a sweep: table, figures and findings, all of them from its dataset."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.comparison.findings import percent
from validation.comparison.report import papers_for, seed_words
from validation.methods import find_method
from validation.report.drawing import Drawing
from validation.report.page import Answer, Page
from validation.report.table import ResultTable, WordTable, shown
from validation.report.words import json_ready, significant, with_error
from validation.scenes.sweep import SweptKey, value_words
from validation.solves.provenance import SOLVES_MADE

if TYPE_CHECKING:
    import xarray as xr

    from validation.scenes.scene import Scene

__all__ = ["sweep_findings", "sweep_page", "sweep_table"]

#: Lines of a figure that can be told apart.
_MOST_LINES = 4
#: Columns of the table after the swept keys, and after those of the methods.
_COLUMNS = {
    "area": "A/A0 limit",
    "area_error": "A/A0 +-",
    "theory": "A/A0 theory",
    "kappa": "kappa",
    "kappa_error": "kappa +-",
    "theory_plastic": "A_pl/A0 theory",
}
_LAST = {
    "theory_ensemble": "A/A0 theory, C(q)",
    "scatter": "scatter of surfaces",
    "reduced_pressure": "p*",
    "pressure": "p0 [Pa]",
}
#: Values that are read with the error in the column after them.
_WITH_ERROR = ("A/A0 limit", "kappa")
_OF_METHODS = {"plastic": "A_pl/A0", "perimeter": "A/A0 perimeter", "pixel": "A/A0 pixel", "grid": "grid"}


def sweep_page(data: xr.Dataset, keys: Sequence[SweptKey], scene: Scene, *, figures: bool = True) -> Page:
    """Return the page of a sweep, drawn or not.

    Parameters
    ----------
    data : xarray.Dataset
        As the sweep stored it.
    keys : sequence of SweptKey
    scene : Scene
        The first of its scenes, which says what is not swept.
    figures : bool
    """
    table = sweep_table(data, keys)
    findings = sweep_findings(data, keys)
    swept = {key.key: list(key.values) for key in keys}
    rows = [json_ready(dict(zip(table.columns, row, strict=True))) for row in table.rows]
    seeds = next((key.values for key in keys if key.key == "surface.seed"), None)
    return Page(
        title=scene.name,
        lead=_lead(data, keys),
        answers=tuple(_answers(data)),
        findings=findings,
        tables=(_in_words(table, swept=len(keys)),),
        figures=tuple(_figures(data, keys)) if figures else (),
        facts=tuple(str(data.attrs.get(SOLVES_MADE, "")).splitlines()),
        settings={
            "sweep": {"mode": data.attrs["mode"], **swept},
            "first case": scene.model_dump(mode="json", exclude_none=True),
        },
        seeds=seed_words(scene) if seeds is None else ", ".join(map(str, seeds)),
        papers=papers_for(scene),
        records={"table": table},
        data=data,
        summary={"sweep": swept, "mode": data.attrs["mode"], "findings": list(findings), "cases": rows},
    )


def _lead(data: xr.Dataset, keys: Sequence[SweptKey]) -> str:
    named = [f"{key.key} ({len(key.values)} values)" for key in keys]
    joined = " times ".join(named) if data.attrs["mode"] == "product" else " beside ".join(named)
    return f"{data.attrs['title']}. Swept: {joined}, {_cases(data, keys)} cases"


def _cases(data: xr.Dataset, keys: Sequence[SweptKey]) -> int:
    return int(np.prod([data.sizes[name] for name in _over(data, keys)]))


def _over(data: xr.Dataset, keys: Sequence[SweptKey]) -> tuple[str, ...]:
    """Dimensions of the cases."""
    return ("case",) if data.attrs["mode"] == "zip" else tuple(key.name for key in keys)


def _flat(data: xr.Dataset, name: str, keys: Sequence[SweptKey]) -> Any:
    """Values of a variable or coordinate of all cases, in order; NaN where there is none."""
    over = _over(data, keys)
    if name not in data.variables:
        return np.full(_cases(data, keys), np.nan)
    like = data["contact_modulus"]
    return data[name].broadcast_like(like).transpose(*over).values.ravel()


def sweep_table(data: xr.Dataset, keys: Sequence[SweptKey]) -> ResultTable:
    """Return one row for each case: the swept values, limit, theory, each method on its finest grid."""
    columns = {
        key.name if key.unit == "1" else f"{key.name} [{key.unit}]": _flat(data, key.name, keys)
        for key in keys
    }
    swept = {key.name for key in keys}

    def add(chosen: dict[str, str]) -> None:
        for name, words in chosen.items():
            if name in data.data_vars and name not in swept:
                columns[words] = _flat(data, name, keys)

    add(_COLUMNS)
    for method in data["solver"].values if "solver" in data.coords else ():
        here = data.sel(solver=method)
        for name, words in _OF_METHODS.items():
            if name in data.data_vars:
                columns[f"{find_method(str(method)).label} {words}"] = _flat(here, name, keys)
    add(_LAST)
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    return ResultTable.of(list(columns), list(rows))


def _in_words(table: ResultTable, *, swept: int) -> WordTable:
    """Return the table as it is read, values with their errors."""
    pairs = {name: table.columns.index(name) for name in _WITH_ERROR if name in table.columns}
    kept = [k for k in range(len(table.columns)) if k - 1 not in pairs.values()]
    rows = [
        [with_error(float(row[k]), float(row[k + 1])) if k in pairs.values() else row[k] for k in kept]
        for row in table.rows
    ]
    columns = [table.columns[k] for k in kept]
    words = shown(
        ResultTable.of(columns, rows),
        title="Every case",
        note="A/A0 limit: over the grids, with its standard error for this surface (grid only); theory: "
        "Persson with the realised gradient, or from C(q) alone; perimeter and pixel: on the finest grid.",
    )
    # What a case is and what it comes to stay.
    return replace(words, left=frozenset(columns[:1]), yielding=tuple(reversed(columns[swept + 1 :])))


def _answers(data: xr.Dataset) -> Iterator[Answer]:
    """Yield the cards on top of the page."""
    known = data["area"] if "area" in data else data["theory_ensemble"]
    if not bool(known.notnull().any()):
        return
    low, high = significant(float(known.min())), significant(float(known.max()))
    basis = "limit over the grids" if "area" in data else "theory alone"
    yield Answer(question="How large is the contact? A/A0", answer=f"{low} to {high}", basis=basis)
    if "area_error" in data:
        share = float((data["area_error"] / data["area"]).max())
        scatter = (
            f"; surfaces scatter by up to {percent(float(data['scatter'].max()))}"
            if "scatter" in data
            else ""
        )
        yield Answer(
            question="How sure?",
            answer=f"grid +- {percent(share)} at most",
            basis=f"one standard error for this surface{scatter or '; scatter between surfaces unknown'}",
        )
    if "theory" in data and "area" in data:
        apart = data["area"] / data["theory"] - 1
        yield Answer(
            question="How far from Persson's theory?",
            answer=f"{100 * float(apart.min()):+.1f} % to {100 * float(apart.max()):+.1f} %",
            basis="limit over the theory with the realised gradient, less one",
        )


def sweep_findings(data: xr.Dataset, keys: Sequence[SweptKey]) -> tuple[str, ...]:
    """Say what changes along each key, how far the theory is, and what is not known."""
    sentences = [text for key in keys if len(key.values) > 1 for text in _along(data, key, keys)]
    sentences += _theory(data, keys)
    sentences += _missing(data, keys)
    if data.attrs.get("layered") and "kappa" in data:
        sentences.append(
            "p* of the scene is of the solid below, kappa stands on E* of the layer at the surface: it is no "
            "number of a homogeneous solid; a run of one case says what it is on the moduli below and felt."
        )
    shared = int(data.attrs["asked"]) - int(data.attrs["solves"])
    if data.attrs["solves"]:
        sentences.append(
            f"{_cases(data, keys)} cases took {data.attrs['solves']} solves"
            + (f"; {shared} more were asked for by several cases and done once." if shared else ".")
        )
    return tuple(sentences)


def _result(data: xr.Dataset) -> tuple[str, str]:
    """Return the variable that answers, and what it is called."""
    if "area" not in data:
        return "theory_ensemble", "the theory gives A/A0"
    if bool(data["area"].notnull().any()):
        return "area", "A/A0"
    return "", ""


def _along(data: xr.Dataset, key: SweptKey, keys: Sequence[SweptKey]) -> Iterator[str]:
    """Say how the area changes from the first to the last value of a key, the others in the middle."""
    name, words = _result(data)
    if not name:
        return
    here, fixed = _line(data, key, keys)
    if key.key == "surface.seed" and data.attrs["mode"] == "product":
        yield from _between_seeds(here, name, fixed)
        return
    finite = here.isel({here[key.name].dims[0]: np.flatnonzero(np.isfinite(here[name].values))})
    if finite[name].size < 2:
        return
    ends = []
    for k in (0, -1):
        value = float(finite[name].values[k])
        has_error = name == "area"
        said = with_error(value, float(finite["area_error"].values[k])) if has_error else significant(value)
        ends.append((value_words(finite[key.name].values[k].item(), key.unit), said))
    (first, low), (last, high) = ends
    load = ""
    if "kappa" in finite and name == "area":
        pair = (float(finite["kappa"].values[k]) for k in (0, -1))
        load = ", kappa from " + " to ".join(significant(value, 3) for value in pair)
    slope = _slope(finite[key.name].values, finite[name].values) if key.numeric else ""
    yield f"From {key.name} = {first} to {last}{fixed} {words} goes from {low} to {high}{load}{slope}."


def _slope(x: Any, y: Any) -> str:
    """Say by which power y follows x, where three values tell."""
    if len(x) < 3 or np.min(x) <= 0 or np.min(y) <= 0 or np.ptp(np.log(x)) == 0:
        return ""
    power = float(np.polyfit(np.log(x), np.log(y), 1)[0])
    return f"; fitted over {len(x)} values, the area follows its power {power:.2f}"


def _between_seeds(here: xr.Dataset, name: str, fixed: str) -> Iterator[str]:
    values = here[name].values[np.isfinite(here[name].values)]
    if len(values) > 1 and np.mean(values) > 0:
        spread = float(np.std(values, ddof=1) / np.mean(values))
        yield (
            f"Between {len(values)} surfaces{fixed} A/A0 scatters by {percent(spread)} (standard deviation) "
            f"about {significant(float(np.mean(values)))}."
        )


def _line(data: xr.Dataset, key: SweptKey, keys: Sequence[SweptKey]) -> tuple[xr.Dataset, str]:
    """Return the cases along one key, sorted, with the others at their middle value, and say which."""
    here, said = data, []
    if data.attrs["mode"] == "product":
        for other in keys:
            if other is not key:
                middle = data.sizes[other.name] // 2
                here = here.isel({other.name: middle})
                said.append(f"{other.name} = {value_words(here[other.name].item(), other.unit)}")
    ordered = here.sortby(key.name) if key.numeric else here
    return ordered, f" (at {', '.join(said)})" if said else ""


def _theory(data: xr.Dataset, keys: Sequence[SweptKey]) -> Iterator[str]:
    if "theory" not in data or not _result(data)[0] or "area_error" not in data:
        return
    area, error, theory = (_flat(data, name, keys) for name in ("area", "area_error", "theory"))
    known = np.isfinite(area) & np.isfinite(theory) & (theory > 0)
    if not known.any():
        return
    apart, sure = area[known] / theory[known] - 1, error[known] / theory[known]
    agree = int(np.sum(np.abs(apart) <= np.maximum(2 * sure, 1e-9)))
    low, high = _side(float(apart.min())), _side(float(apart.max()))
    text = (
        f"The limit lies between {low} and {high} Persson's theory "
        f"with the realised gradient (grid uncertainty at most {percent(float(sure.max()))})"
    )
    yield text + f"; in {agree} of {int(known.sum())} cases the two agree to within twice that uncertainty."


def _side(difference: float) -> str:
    return f"{percent(abs(difference))} {'above' if difference > 0 else 'below'}"


def _missing(data: xr.Dataset, keys: Sequence[SweptKey]) -> Iterator[str]:
    """Say which limits are not there, and that one surface is one surface."""
    if "area" not in data:
        return
    missing = int(data["area"].isnull().sum())
    if missing:
        why = data.attrs["no_limit"] or "the grids do not tell"
        cases = data["area"].size
        yield f"In {missing} of {cases} cases the limit over the grids is not determinable: {why}."
    if "scatter" in data:
        low, high = (percent(float(v)) for v in (data["scatter"].min(), data["scatter"].max()))
        yield f"Between surfaces of one spectrum the area scatters by {low} to {high} (standard deviation)."
    elif not any(key.key == "surface.seed" for key in keys):
        yield "Every case is one surface: the scatter between surfaces is unknown."


def _figures(data: xr.Dataset, keys: Sequence[SweptKey]) -> Iterator[Drawing]:
    """Draw area, kappa and the yielded area against each key that has several values."""
    alone = "area" not in data
    limit = not alone and bool(data["area"].notnull().any())
    drawn: dict[str, tuple[tuple[str, ...], str]] = {}
    if alone:
        drawn["area"] = (("theory_ensemble",), "Contact area by Persson's theory from C(q)")
    elif limit:
        drawn["area"] = (
            ("area", "theory"),
            "Contact area: limit over the grids with its standard error (grid only; may hide in a symbol)",
        )
        drawn["kappa"] = (
            ("kappa", "theory_kappa"),
            "Area over load, kappa, with its standard error (grid only)",
        )
    else:
        drawn["area"] = (
            ("finest", "theory"),
            "Contact area on the finest grid, since the grids tell no limit",
        )
    if "plastic" in data:
        drawn["plastic"] = (("yielded", "theory_plastic"), "Yielded area, points counted on the finest grid")
    shown_data = _with_finest(data)
    for key in keys:
        if len(set(key.values)) > 1:
            for name, (lines, words) in drawn.items():
                yield _drawing(shown_data, key, keys, name=name, lines=lines, words=words)


def _with_finest(data: xr.Dataset) -> xr.Dataset:
    """Add what the first method finds on its finest grid, as a line to be drawn."""
    if "solver" not in data.coords:
        return data
    first = data.isel(solver=0, drop=True)
    added = {"finest": "perimeter", "yielded": "plastic"}
    return data.assign({new: first[old] for new, old in added.items() if old in data})


def _drawing(
    data: xr.Dataset, key: SweptKey, keys: Sequence[SweptKey], *, name: str, lines: Sequence[str], words: str
) -> Drawing:
    from validation.report.figure import lines_figure

    lines = [line for line in lines if line in data and bool(data[line].notnull().any())]
    errors = [f"{line}_error" for line in lines if f"{line}_error" in data]
    here, along, fixed = _plane(data[[*lines, *errors]], key, keys)
    figure = lines_figure(here, x=key.name, lines=lines, along=along, logarithmic=_scales(here, key, lines))
    theory = ", beside Persson's theory" if any("theory" in line for line in lines[1:]) else ""
    return Drawing(
        name=f"{name}-against-{key.name.replace('_', '-')}",
        figure=figure,
        data=here,
        caption=f"{words}{theory}, against {key.key}{fixed}.",
    )


def _plane(data: xr.Dataset, key: SweptKey, keys: Sequence[SweptKey]) -> tuple[xr.Dataset, str | None, str]:
    """Return what one figure shows: along a key, a line for each of a few values of another."""
    along, said = None, []
    if data.attrs["mode"] == "product":
        for other in keys:
            count = data.sizes[other.name]
            if other is key:
                continue
            if along is None and count > 1:
                along = other.name
                kept = np.unique(np.linspace(0, count - 1, min(count, _MOST_LINES)).round().astype(int))
                data = data.isel({other.name: kept})
                if len(kept) < count:
                    said.append(f"{len(kept)} of {count} values of {other.name}")
            else:
                data = data.isel({other.name: count // 2})
                said.append(f"{other.name} = {value_words(data[other.name].item(), other.unit)}")
    ordered = data.sortby(key.name) if key.numeric else data
    return ordered, along, f" ({', '.join(said)})" if said else ""


def _scales(data: xr.Dataset, key: SweptKey, lines: Sequence[str]) -> str:
    """Logarithmic axes for keys that span a factor of three, and results that span ten."""
    spans = {"x": np.asarray(key.values, dtype=float) if key.numeric else np.zeros(1)}
    spans["y"] = np.concatenate([data[line].values.ravel() for line in lines])
    least = {"x": 3, "y": 10}
    wide = (k for k, v in spans.items() if np.nanmin(v) > 0 and np.nanmax(v) >= least[k] * np.nanmin(v))
    return "".join(wide)
