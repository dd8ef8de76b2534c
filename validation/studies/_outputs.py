"""What a study leaves behind: data, tables, figures and a report, all made from its dataset."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.extrapolation import LEAST_CONTACT_POINTS
from validation.effects import effect_kinds
from validation.execution.provenance import SOLVES_MADE, made_words
from validation.execution.results import Outputs, Result, leave
from validation.report.estimates import derive, sources_of, total_error
from validation.report.page import Page, page_of
from validation.report.papers import CITED_FOR
from validation.report.places import each
from validation.report.quantities import in_prefixed_unit, place_words, quantity
from validation.report.views import Card, Views
from validation.report.words import percent
from validation.solvers import methods
from validation.studies import Study, StudyOptions, find_study

if TYPE_CHECKING:
    import xarray as xr

    from validation.execution.bench import Bench


def run_study(
    study: Study, options: StudyOptions, folder: Path, *, bench: Bench, report: bool = True
) -> Outputs:
    """Run a study on a bench and write its outputs into a folder, without `report` tables and JSON alone."""
    data = study.compute(options, bench=bench)
    data.attrs[SOLVES_MADE] = "\n".join(made_words(bench.made()))
    outputs = leave(
        folder,
        data,
        study_page,
        report=report,
        kind="study",
        name=study.name,
        settings=options.record(),
        store=bench.store.folder,
        words=list(options.remarks()),
    )
    return replace(outputs, failures=tuple(data.attrs.get("failures", "").splitlines()))


def study_page(result: Result, *, figures: bool) -> Page:
    """Return the page of a study, drawn or not: all of it from its dataset and from what was asked."""
    study, data, options = find_study(result.name), result.data, result.settings
    views, seed = study.views(data), options.get("seed")
    used = str(data.attrs.get("methods", "theory bem")).split()
    known: dict[str, Any] = {**methods(), **effect_kinds()}
    cited = [paper for name, what in known.items() if name in used for paper in what.papers]
    page = page_of(
        data,
        replace(views, cards=tuple(_cards(data, views))),
        figures=figures,
        title=f"Study: {study.name}",
        lead=study.question,
        settings=options,
        seeds="none is asked for"
        if seed is None
        else f"{seed} is the first; each further surface has its own",
        papers=(
            *cited,
            *(CITED_FOR[name] for name in dict.fromkeys([*used, "perimeter"]) if name in CITED_FOR),
        ),
        summary={"kind": "study", "study": study.name, "options": dict(options)},
    )
    return replace(page, findings=(*page.findings, *_undetermined(data), *result.words))


def _cards(data: xr.Dataset, views: Views) -> Iterator[Card]:
    """Yield what is budgeted first, at all its places: how large, how sure, how far from Persson's theory.

    Of a study without a single number, what was found first.
    """
    name = next(iter(views.budget), "")
    if not name or not bool(data[name].notnull().any()):
        yield from (Card("The answer", finding) for finding in views.findings[:1])
        return
    what, places = quantity(name), [str(dim) for dim in data[name].dims]
    ends = [data.isel(at(places)) for at in (data[name].argmin, data[name].argmax)] if places else []
    words = [[place_words(end, dim, data) for dim in places] for end in ends]
    where = " to ".join(dict.fromkeys(", ".join(w for w in one if w and "nan" not in w) for one in words))
    answer = _range(data[name], lambda value: in_prefixed_unit(value, what.unit))
    yield Card(f"{what.meaning}, {what.symbol}", answer, where)
    half = total_error(data, name)
    if half is not None and bool((half > 0).any()):
        held = dict.fromkeys(sources_of(here[f"{name}_error"]) for here in each(data, *places))
        basis = f"95 %: {' or '.join(filter(None, held)) or 'all sources of this spectrum and period'}"
        share = half / abs(data[name])
        # Of what may be nothing a share of it says nothing.
        sure = _range(half, lambda value: in_prefixed_unit(value, what.unit, 2))
        if not (share > 1).any():
            sure = _range(share, percent)
        yield Card("How sure?", f"+- {sure}", basis)
    if f"{name}_persson" in data and bool(data[f"{name}_persson"].notnull().any()):
        data = derive(data, distance=f"{name} / {name}_persson - 1")
        answer = _range(data.distance, lambda value: f"{round(100 * value, 3):+.3g} %")
        half, basis = total_error(data, "distance"), ""
        if half is not None:
            agree = int((abs(data.distance) <= half + 1e-9).sum())  # but for rounding, in full contact
            cases = f"{agree} of {int(data.distance.notnull().sum())} cases"
            basis = f"in {cases} they agree within the 95 % interval"
        yield Card("How far from Persson's theory?", answer, basis)


def _range(values: xr.DataArray, printed: Callable[[float], str]) -> str:
    """Say the smallest and the largest of the numbers that are known."""
    known = np.sort(values.values[np.isfinite(values.values)])
    return (
        " to ".join(dict.fromkeys(printed(float(end)) for end in known[[0, -1]])) if known.size else "unknown"
    )


def _undetermined(data: xr.Dataset) -> Iterator[str]:
    if "failures" in data.attrs:
        first, *others = data.attrs["failures"].splitlines()
        more = f", and {len(others)} more" if others else ""
        yield f"Not all solves succeeded; their methods are left out: {first}{more}."
    for name in ("area", "limit", "kappa"):
        if name not in data.data_vars:
            continue
        lacking = data[name].isnull()
        if f"{name}_error" in data:  # what nobody made has no error of any source
            lacking &= data[f"{name}_error"].notnull().any("source")
        missing = int(lacking.sum())
        if missing:
            yield (
                f"{missing} of {data[name].size} values of '{name}' are not determinable (NaN): the contact "
                f"has fewer than {LEAST_CONTACT_POINTS} points on the finest grid, or the grids extrapolate "
                "beyond 0 or 1."
            )
