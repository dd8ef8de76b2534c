"""What a study leaves behind: data, tables, figures and a report, all made from its dataset."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fem_contact.extrapolation import LEAST_CONTACT_POINTS
from validation.effects import effect_kinds
from validation.errors import RunFailed, UsageError
from validation.files import read_record, write_record
from validation.methods import methods
from validation.report.page import Page, write_page
from validation.report.papers import PAPERS
from validation.report.table import shown, shown_dataset
from validation.solves.provenance import SOLVES_MADE, made_words
from validation.solves.store import read_numbers, write_numbers
from validation.studies import Study, StudyOptions, find_study

if TYPE_CHECKING:
    import xarray as xr

    from validation.solves.bench import Bench

__all__ = [
    "StudyOutputs",
    "check_results",
    "is_study",
    "report_study",
    "run_study",
    "study_page",
]

_RECORD = "study.json"
_FORMAT = "fem-contact study 1"
_DATA = "data.nc"


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
    said = {
        "format": _FORMAT,
        "study": study.name,
        "options": options.said(),
        "words": list(options.words()),
        "store": os.path.relpath(bench.store.folder.resolve(), folder.resolve()),
    }
    data.attrs[SOLVES_MADE] = "\n".join(made_words(bench.made()))
    for other in ("run.json", "accuracy.json", "sweep.json"):  # the folder is that of this study now
        (folder / other).unlink(missing_ok=True)
    write_record(folder / _RECORD, said)
    write_numbers(folder / _DATA, data, recipe=said)
    return report_study(folder, numbers_only=not report)


def is_study(folder: Path) -> bool:
    """Whether a results folder is that of a study."""
    return (folder / _RECORD).exists()


def check_results(folder: Path) -> None:
    """Refuse a folder that holds neither a run nor a study, and name those beside it that do.

    Raises
    ------
    UsageError
    """
    records = ("run.json", "sweep.json", _RECORD)
    if any((folder / record).exists() for record in records):
        return
    places = sorted(
        {path.parent for place in (folder.parent, Path("results")) for path in place.glob("*/*.json")}
    )
    found = [str(place) for place in places if any((place / record).exists() for record in records)]
    raise UsageError(
        f"{folder}: holds no run (run.json) and no study (study.json): run one first; results are in "
        + (", ".join(found[:12]) + (", ..." if len(found) > 12 else "") if found else "no folder here")
    )


def report_study(folder: Path, *, numbers_only: bool = False) -> StudyOutputs:
    """Write tables, figures and report of a study again, from its stored dataset alone.

    Parameters
    ----------
    folder : Path
    numbers_only : bool
        Whether to write tables and JSON alone.

    Raises
    ------
    UsageError
        For a folder that holds no finished study of this version.
    """
    try:
        said = read_record(folder / _RECORD)
        study = find_study(said["study"])
        data = read_numbers(folder / _DATA)
    except RunFailed as error:
        raise UsageError(str(error)) from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UsageError(f"{folder}: holds no finished study ({error})") from None
    page = study_page(study, data, said["options"], words=said.get("words", ()), figures=not numbers_only)
    written = write_page(page, folder, numbers_only=numbers_only)
    return StudyOutputs(data=data, page=page, files=(*written, folder / _DATA))


def study_page(
    study: Study,
    data: xr.Dataset,
    options: Mapping[str, Any],
    *,
    words: Sequence[str] = (),
    figures: bool = True,
) -> Page:
    """Return the page of a study, drawn or not: all of it from its dataset and from what was asked."""
    table = study.table(data)
    findings = (*study.findings(data), *_undetermined(data), *words)
    return Page(
        title=f"Study: {study.name}",
        lead=study.question,
        findings=findings,
        tables=shown_dataset(data, title="Numbers") if table is None else (shown(table, title="Numbers"),),
        budget=study.budget(data),
        figures=study.figures(data) if figures else (),
        facts=tuple(str(data.attrs.get(SOLVES_MADE, "")).splitlines()),
        settings=options,
        seeds=_seeds(options),
        papers=_papers(str(data.attrs.get("methods", "theory bem")).split()),
        records={} if table is None else {"table": table},
        data=data,
        summary={
            "study": study.name,
            "options": dict(options),
            **(study.views(data).as_json(data) if study.generic else {"findings": list(findings)}),
        },
    )


def _undetermined(data: xr.Dataset) -> Iterator[str]:
    """Say which limits of the contact area are not there."""
    for name in ("area", "limit", "kappa"):
        missing = int(data[name].isnull().sum()) if name in data.data_vars else 0
        if missing:
            yield (
                f"{missing} of {data[name].size} values of '{name}' are not determinable (NaN): the contact "
                f"has fewer than {LEAST_CONTACT_POINTS} points on the finest grid, or the grids extrapolate "
                "beyond 0 or 1."
            )


def _papers(used: Sequence[str]) -> tuple[str, ...]:
    """Papers of the methods and effects that a study names."""
    known: dict[str, Any] = {**methods(), **effect_kinds()}
    cited = [paper for name, what in known.items() if name in used for paper in what.papers]
    return (*cited, *(PAPERS[name] for name in dict.fromkeys([*used, "perimeter"]) if name in PAPERS))


def _seeds(options: Mapping[str, Any]) -> str:
    seed = options.get("seed")
    if seed is None:
        return "see the options below"
    surfaces = int(options.get("surfaces", 1))
    return str(seed) if surfaces < 2 else f"{seed} to {seed + surfaces - 1}"
