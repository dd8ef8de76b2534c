"""What a study leaves behind: data, tables, figures and a report, all made from its dataset."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fem_contact.extrapolation import LEAST_CONTACT_POINTS
from validation.effects import effect_kinds
from validation.errors import UsageError
from validation.files import atomic_path
from validation.methods import methods
from validation.report.drawing import frames, write_csv, write_drawings
from validation.report.papers import MEASURED, PERIMETER
from validation.studies import Study, StudyOptions, find_study

if TYPE_CHECKING:
    import xarray as xr

    from validation.report.table import ResultTable
    from validation.solves.bench import Bench

__all__ = ["StudyOutputs", "check_results", "is_study", "report_study", "run_study"]

_RECORD = "study.json"
_FORMAT = "fem-contact study 1"
_ROWS_SHOWN = 60


@dataclass(frozen=True, kw_only=True, eq=False)
class StudyOutputs:
    """What a study left behind; the report is the first file."""

    data: xr.Dataset
    findings: tuple[str, ...]
    files: tuple[Path, ...]


def run_study(study: Study, options: StudyOptions, folder: Path, *, bench: Bench) -> StudyOutputs:
    """Run a study on a bench and write its outputs into a folder."""
    data = study.compute(options, bench=bench)
    said = {
        "format": _FORMAT,
        "study": study.name,
        "options": options.model_dump(mode="json", exclude_none=True),
    }
    with atomic_path(folder / _RECORD) as draft:
        draft.write_text(json.dumps(said, indent=2) + "\n", encoding="utf-8")
    with atomic_path(folder / "data.nc") as draft:
        data.to_netcdf(draft, engine="netcdf4")
    return report_study(folder)


def is_study(folder: Path) -> bool:
    """Whether a results folder is that of a study."""
    return (folder / _RECORD).exists()


def check_results(folder: Path) -> None:
    """Refuse a folder that holds neither a run nor a study, and name those beside it that do.

    Raises
    ------
    UsageError
    """
    records = ("run.json", _RECORD)
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


def report_study(folder: Path) -> StudyOutputs:
    """Write tables, figures and report of a study again, from its stored dataset alone.

    Raises
    ------
    UsageError
        For a folder that holds no finished study of this version.
    """
    import xarray as xr

    from validation.report.page import render, versions

    try:
        said = json.loads((folder / _RECORD).read_text(encoding="utf-8"))
        study = find_study(said["study"])
        with xr.open_dataset(folder / "data.nc", engine="netcdf4") as stored:
            data = stored.load()
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UsageError(f"{folder}: holds no finished study ({error})") from None
    tables = write_csv(data, folder / "data.csv")
    findings = (*study.findings(data), *_undetermined(data))
    table, budget = study.table(data), study.budget(data)
    for name, made in (("table", table), ("budget", budget)):
        if made is not None:
            tables += (_write_table(made, folder / f"{name}.csv"),)
    page = render(
        "study.html.j2",
        title=f"Study: {study.name}",
        question=study.question,
        findings=findings,
        tables=_tables(data) if table is None else [_shown(table)],
        budget=None if budget is None else _shown(budget),
        figures=write_drawings(study.figures(data), folder),
        settings=json.dumps(said["options"], indent=2),
        seeds=_seeds(said["options"]),
        versions=versions(),
        papers=_papers(str(data.attrs.get("methods", "theory bem")).split()),
    )
    report = folder / "report.html"
    with atomic_path(report) as draft:
        draft.write_text(page, encoding="utf-8")
    files = (report, *tables, folder / "data.nc", folder / "figures")
    return StudyOutputs(data=data, findings=findings, files=files)


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


def _write_table(table: ResultTable, path: Path) -> Path:
    with atomic_path(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([table.columns, *table.rows])
    return path


def _papers(used: Sequence[str]) -> tuple[str, ...]:
    """Papers of the methods and effects that a study names."""
    known: dict[str, Any] = {**methods(), **effect_kinds()}
    cited = [paper for name, what in known.items() if name in used for paper in what.papers]
    return (*cited, PERIMETER, *([MEASURED] if "measured" in used else []))


def _seeds(options: Mapping[str, Any]) -> str:
    seed = options.get("seed")
    if seed is None:
        return "see the options below"
    surfaces = int(options.get("surfaces", 1))
    return str(seed) if surfaces < 2 else f"{seed} to {seed + surfaces - 1}"


def _tables(data: xr.Dataset) -> list[dict[str, Any]]:
    """One table for each set of dimensions, of at most 60 rows."""
    tables = []
    for frame in frames(data).values():
        rows = [tuple(map(_cell, row)) for row in frame.head(_ROWS_SHOWN).itertuples(index=False)]
        columns = [_column(data, name) for name in frame.columns]
        tables.append({"columns": columns, "rows": rows, "left_out": max(0, len(frame) - _ROWS_SHOWN)})
    return tables


def _shown(table: ResultTable) -> dict[str, Any]:
    rows = [tuple(map(_cell, row)) for row in table.rows]
    return {"columns": list(table.columns), "rows": rows, "left_out": 0}


def _column(data: xr.Dataset, name: str) -> str:
    unit = data[name].attrs.get("units", "1") if name in data.variables else "1"
    return name if unit == "1" else f"{name} [{unit}]"


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.5g}"
    return str(value)
