"""What a study leaves behind: data, tables, figures and a report, all made from its dataset."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fem_contact.extrapolation import LEAST_CONTACT_POINTS
from validation.effects import effect_kinds
from validation.errors import UsageError
from validation.execution.outputs import Outputs, leave
from validation.execution.provenance import SOLVES_MADE, made_words
from validation.execution.results import Result
from validation.report.page import Page, page_of
from validation.report.papers import CITED_FOR
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


def study_page(result: Result, *, figures: bool = True) -> Page:
    """Return the page of a study, drawn or not: all of it from its dataset and from what was asked.

    A UsageError for results of another kind.
    """
    if result.kind != "study":
        raise UsageError(f"holds a {result.kind}, not a study")
    study, data, options = find_study(result.name), result.data, result.settings
    page = page_of(
        data,
        study.views(data),
        figures=figures,
        title=f"Study: {study.name}",
        lead=study.question,
        settings=options,
        seeds=_seeds(options),
        papers=_papers(str(data.attrs.get("methods", "theory bem")).split()),
        summary={"kind": "study", "study": study.name, "options": dict(options)},
    )
    return replace(page, findings=(*page.findings, *_undetermined(data), *result.words))


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


def _papers(used: Sequence[str]) -> tuple[str, ...]:
    known: dict[str, Any] = {**methods(), **effect_kinds()}
    cited = [paper for name, what in known.items() if name in used for paper in what.papers]
    return (*cited, *(CITED_FOR[name] for name in dict.fromkeys([*used, "perimeter"]) if name in CITED_FOR))


def _seeds(options: Mapping[str, Any]) -> str:
    seed = options.get("seed")
    if seed is None:
        return "see the options below"
    surfaces = int(options.get("surfaces", 1))
    return str(seed) if surfaces < 2 else f"{seed} to {seed + surfaces - 1}"
