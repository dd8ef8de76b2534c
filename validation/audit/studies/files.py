"""The files of a study beside each other: CSV and figures hold the numbers of the dataset, the page those of CSV."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from validation.audit.files import page_tables
from validation.audit.studies.kept import Kept, rows_of

__all__ = ["judge_files"]


def judge_files(kept: Kept) -> None:
    """Judge data.csv, the data of figures and the tables of the page."""
    for path in sorted(kept.folder.glob("data*.csv")):
        _spread_out(kept, path)
    for path in sorted((kept.folder / "figures").glob("*.nc")):
        _figure(kept, path)
    _page(kept)


def _spread_out(kept: Kept, path: Path) -> None:
    """Judge a CSV file of variables that share their dimensions."""
    header, *lines = rows_of(path)
    names = [name for name in header if name in kept.data and kept.along[name] != (name,)]
    own = [name for name in names if kept.data[name].dtype.kind == "f" and len(kept.along[name]) > 0]
    for name in own:
        found = np.array([float(line[header.index(name)] or "nan") for line in lines])
        expected = kept.data[name].ravel()
        if found.size != expected.size:
            continue  # a coordinate, repeated along other dimensions
        _entry(kept, path.name, name, found, expected)


def _entry(kept: Kept, place: str, name: str, found: np.ndarray, expected: np.ndarray) -> None:
    """Enter the number of an array that is furthest from what it should be."""
    off = np.abs(found - expected) / (np.abs(expected) + 1e-300)
    off = np.where(np.isnan(found) & np.isnan(expected), 0.0, np.where(np.isnan(off), np.inf, off))
    k = int(np.argmax(off)) if off.size else 0
    if off.size:
        kept.ledger.number(place, f"{name}, number {k + 1}", found[k], expected[k], rtol=1e-12, atol=0.0)


def _figure(kept: Kept, path: Path) -> None:
    import netCDF4

    place = f"figures/{path.name}"
    with netCDF4.Dataset(path) as file:
        for name in file.variables:
            found = np.asarray(file.variables[name][...])
            known = kept.data | kept.derived
            if name not in known:
                kept.ledger.unread.append(f"{place}: {name}")
            elif found.dtype.kind == "f" and found.size == known[name].size:
                values = np.ma.filled(np.ma.asarray(file.variables[name][...]), math.nan).ravel()
                _entry(kept, place, name, values, known[name].ravel())


def _page(kept: Kept) -> None:
    """Judge the tables of report.html beside the CSV files, five digits of each number."""
    path = kept.folder / "report.html"
    if not path.exists():
        kept.ledger.unread.append("report.html: there is none")
        return
    shown = page_tables(path.read_text(encoding="utf-8"))
    for title, name in (("Numbers", "table.csv"), ("What is uncertain", "budget.csv")):
        header, *lines = rows_of(kept.folder / name) or [[]]
        if title not in shown or not lines:
            continue
        place = f"report.html, {title}"
        titles, rows = shown[title]
        header = [name.strip() for name in header]  # as a page shows them
        kept.ledger.same(place, "number of rows", len(rows), min(len(lines), len(rows)))
        order = [header.index(t) if header.count(t) == 1 else -1 for t in titles]
        for k, (row, line) in enumerate(zip(rows, lines, strict=False)):
            for j, cell in enumerate(row):
                source = line[order[j]] if order[j] >= 0 else line[j] if titles == header else None
                if source is not None:
                    _cell(kept, place, f"{titles[j]}, row {k + 1}", cell, source)


def _cell(kept: Kept, place: str, name: str, cell: str, source: str) -> None:
    try:
        value = float(source)
    except ValueError:
        kept.ledger.same(place, name, cell, source)
        return
    kept.ledger.text(place, name, cell, value, 5)
