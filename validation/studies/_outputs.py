"""What a study leaves behind: data, tables, figures and a report, all made from its dataset."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fem_contact.extrapolation import LEAST_CONTACT_POINTS
from validation.effects import effect_kinds
from validation.errors import UsageError
from validation.execution.provenance import SOLVES_MADE, made_words
from validation.execution.results import DATA, read_results, write_results
from validation.files import locked
from validation.report.page import Page, page_of, write_page
from validation.report.papers import PAPERS
from validation.solvers import methods
from validation.studies import Study, StudyOptions, find_study

if TYPE_CHECKING:
    import xarray as xr

    from validation.execution.bench import Bench


@dataclass(frozen=True, kw_only=True, eq=False)
class StudyOutputs:
    """What a study left behind; the report is the first file."""

    data: xr.Dataset
    page: Page
    files: tuple[Path, ...]


def run_study(
    study: Study, options: StudyOptions, folder: Path, *, bench: Bench, report: bool = True
) -> StudyOutputs:
    """Run a study on a bench and write its outputs into a folder, without `report` tables and JSON alone."""
    data = study.compute(options, bench=bench)
    data.attrs[SOLVES_MADE] = "\n".join(made_words(bench.made()))
    with locked(folder):
        write_results(
            folder,
            data,
            kind="study",
            name=study.name,
            settings=options.record(),
            store=bench.store.folder,
            words=list(options.remarks()),
        )
        return report_study(folder, numbers_only=not report)


def report_study(folder: Path, *, numbers_only: bool = False) -> StudyOutputs:
    """Write tables, figures and report of a study again, from its stored dataset alone.

    Parameters
    ----------
    numbers_only : bool
        Whether to write tables and JSON alone.

    Raises
    ------
    UsageError
        For a folder that holds no finished study of this version.
    """
    with locked(folder):
        result = read_results(folder)
        if result.kind != "study":
            raise UsageError(f"{folder}: holds a {result.kind}, not a study")
        study, data = find_study(result.name), result.data
        page = study_page(study, data, result.settings, words=result.words, figures=not numbers_only)
        written = write_page(page, folder, numbers_only=numbers_only)
    return StudyOutputs(data=data, page=page, files=(*written, folder / DATA))


def study_page(
    study: Study,
    data: xr.Dataset,
    options: Mapping[str, Any],
    *,
    words: Sequence[str] = (),
    figures: bool = True,
) -> Page:
    """Return the page of a study, drawn or not: all of it from its dataset and from what was asked."""
    header: dict[str, Any] = {
        "title": f"Study: {study.name}",
        "lead": study.question,
        "settings": options,
        "seeds": _seeds(options),
        "papers": _papers(str(data.attrs.get("methods", "theory bem")).split()),
    }
    summary: dict[str, Any] = {"kind": "study", "study": study.name, "options": dict(options)}
    page = page_of(data, study.views(data), figures=figures, summary=summary, **header)
    return replace(page, findings=(*page.findings, *_undetermined(data), *words))


def _undetermined(data: xr.Dataset) -> Iterator[str]:
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
    return (*cited, *(PAPERS[name] for name in dict.fromkeys([*used, "perimeter"]) if name in PAPERS))


def _seeds(options: Mapping[str, Any]) -> str:
    seed = options.get("seed")
    if seed is None:
        return "see the options below"
    surfaces = int(options.get("surfaces", 1))
    return str(seed) if surfaces < 2 else f"{seed} to {seed + surfaces - 1}"
