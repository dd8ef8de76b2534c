"""The page of results side by side: what differs, the numbers, how far apart, one figure with all."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.comparison.beside import Beside, Result, Row, beside
from validation.comparison.findings import percent
from validation.errors import UsageError
from validation.files import atomic_path, prepare_folder
from validation.report.page import Answer, Page, write_page
from validation.report.table import ResultTable, WordTable
from validation.report.words import json_ready, significant, with_error

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["beside_page", "compare_folders"]

#: Joint uncertainties up to which two numbers are not told apart.
_TOLD_APART = 2.0
_DATA = "data.nc"


def compare_folders(
    folders: Sequence[Path], output: Path, *, report: bool = True
) -> tuple[Page, tuple[Path, ...]]:
    """Put results folders on one page, and write it; return the page and the files.

    Raises
    ------
    UsageError
        Where fewer than two can be compared, or `output` holds results of its own.
    """
    found = beside(folders)
    own = [name for name in ("run.json", "sweep.json", "study.json") if (output / name).exists()]
    if own:
        raise UsageError(f"--output {output}: holds results of its own ({own[0]}); name another folder")
    page = beside_page(found, figures=report)
    written = write_page(page, prepare_folder(output), numbers_only=not report)
    assert page.data is not None
    with atomic_path(output / _DATA) as draft:
        page.data.to_netcdf(draft, engine="netcdf4")
    return page, (*written, output / _DATA)


def beside_page(found: Beside, *, figures: bool = True) -> Page:
    """Return the page of results side by side, drawn or not."""
    from validation.comparison.beside_figures import drawings

    table = _numbers(found)
    findings = tuple(_findings(found))
    papers = dict.fromkeys(paper for result in found.results for paper in result.summary.get("papers", ()))
    return Page(
        title=" beside ".join(found.labels),
        lead=f"{_kind(found)}. What differs in what was asked, and in what came out; "
        f"differences are from {found.labels[0]}",
        answers=tuple(_answers(found)),
        findings=findings,
        tables=(_in_words(found), *_settings(found)),
        figures=drawings(found) if figures else (),
        settings={result.label: dict(result.settings) for result in found.results},
        seeds="; ".join(f"{result.label}: {_seed(result)}" for result in found.results),
        papers=tuple(papers),
        records={"table": table},
        data=_dataset(found),
        summary={
            "results": {result.label: str(result.folder) for result in found.results},
            "differing": {key: list(values) for key, values in found.differing.items()},
            "numbers": [json_ready(dict(zip(table.columns, row, strict=True))) for row in table.rows],
            "not_compared": list(found.left_out),
            "findings": list(findings),
        },
    )


def _kind(found: Beside) -> str:
    kind, count = found.results[0].kind, len(found.results)
    words = {"run": "runs", "sweep": "sweeps", "theory": "runs of the theory alone"}
    return f"{count} {words.get(kind, f'results of the {kind}')}"


def _seed(result: Result) -> str:
    return result.settings.get("surface.seed") or result.settings.get("seed") or "none"


def _at(found: Beside, row: Row) -> str:
    """Say where a row stands: p* = 0.05, H = 0.8."""
    return ", ".join(f"{key} = {_short(value)}" for key, value in zip(found.keys, row.where, strict=True))


def _short(value: str) -> str:
    try:
        return f"{float(value):.4g}"
    except ValueError:
        return value


def _numbers(found: Beside) -> ResultTable:
    """Return every number, one line for each result."""
    rows: list[tuple[float | str, ...]] = []
    for row in found.rows:
        for k, (label, number) in enumerate(zip(found.labels, row.numbers, strict=True)):
            apart, units = (row.apart(k), row.units(k)) if k else (None, math.nan)
            difference = (math.nan, math.nan) if apart is None else (apart.value, apart.error)
            cells = (row.quantity, label, number.value, number.error, *difference, units)
            rows.append((*row.where, *cells))
    names = ("quantity", "result", "value", "+-", "difference", "joint +-", "difference / joint +-")
    return ResultTable.of((*found.keys, *names), rows)


def _in_words(found: Beside) -> WordTable:
    """Return the same as it is read, values with their uncertainty."""
    rows = []
    for row in found.rows:
        for k, (label, number) in enumerate(zip(found.labels, row.numbers, strict=True)):
            apart = row.apart(k)
            cells = (
                _said(number.value, number.error),
                *(
                    ("", "")
                    if k == 0
                    else (
                        _units(row.units(k)),
                        _said(apart.value, apart.error),
                    )
                ),
            )
            rows.append((*map(_short, row.where), row.quantity, label, *cells))
    columns = (*found.keys, "quantity", "result", "value", "in joint +-", "less the first")
    kind = found.results[0].kind
    meant = "one standard error" if kind in ("run", "sweep") else "as the table of the study names it"
    return WordTable(
        title="Numbers side by side",
        columns=columns,
        rows=tuple(rows[:_ROWS]),
        left=frozenset({"quantity", "result", *found.keys}),
        yielding=("less the first",),
        note=(f"{len(rows) - _ROWS} more rows are in table.csv. " if len(rows) > _ROWS else "")
        + f"+- is {meant}; joint: the root of the sum of the squares of both, as if they were independent. "
        "Of one and the same surfaces the differences are better known than that.",
    )


#: Rows of the page; table.csv has all of them.
_ROWS = 120


def _said(value: float, error: float) -> str:
    return significant(value, 5) if math.isnan(error) else with_error(value, error)


def _units(units: float) -> str:
    return "" if math.isnan(units) else f"{units:+.1f}" if abs(units) < 100 else f"{units:+.3g}"


def _times(number: float) -> str:
    return significant(number, 2)


def _settings(found: Beside) -> Iterator[WordTable]:
    if found.differing:
        yield WordTable(
            title="Settings that differ",
            columns=("setting", *found.labels),
            rows=tuple((key, *values) for key, values in found.differing.items()),
            left=frozenset({"setting", *found.labels}),
        )


def _answers(found: Beside) -> Iterator[Answer]:
    """Yield the cards: what differs, and by how much the first quantity with an uncertainty does."""
    yield Answer(
        question="What differs in what was asked?",
        answer=", ".join(list(found.differing)[:3]) + (", ..." if len(found.differing) > 3 else "")
        if found.differing
        else "nothing",
        basis=f"{len(found.differing)} setting{'' if len(found.differing) == 1 else 's'}",
    )
    headline = [row for row in found.rows if row.uncertain]
    if found.keys or not headline:
        return
    row = headline[0]
    for k, label in enumerate(found.labels):
        basis = "the first, with which the others are compared"
        if k:
            share = percent(row.apart(k).value / row.numbers[0].value)
            basis = f"{share} from it, {_times(abs(row.units(k)))} joint +-"
        number = row.numbers[k]
        yield Answer(
            question=f"{row.quantity}, {label}", answer=_said(number.value, number.error), basis=basis
        )


def _findings(found: Beside) -> Iterator[str]:
    if found.differing:
        shown = [
            f"{key} ({'; '.join(v or 'none' for v in values)})" for key, values in found.differing.items()
        ]
        more = f", and {len(shown) - 6} more settings" if len(shown) > 6 else ""
        yield f"They differ in {', '.join(shown[:6])}{more}."
    else:
        yield "No setting differs: these are results of one and the same question."
    quantities = dict.fromkeys(row.quantity for row in found.rows if row.uncertain)
    for quantity in quantities:
        rows = [row for row in found.rows if row.quantity == quantity]
        for k in range(1, len(found.results)):
            yield _difference(found, rows, k)
    if found.results[0].kind == "run":
        yield _surfaces(found)
    if not quantities:
        yield "No number that they share has an uncertainty: how far they are apart cannot be judged."
    yield from found.left_out


def _difference(found: Beside, rows: Sequence[Row], k: int) -> str:
    """Say how far a result is from the first in one quantity, at the row where it is farthest."""
    known = [row for row in rows if math.isfinite(row.units(k))]
    name, first, other = rows[0].quantity, found.labels[0], found.labels[k]
    if not known:
        return f"{name}: {other} and {first} are equal or without uncertainty."
    row = max(known, key=lambda row: abs(row.units(k)))
    a, b = row.numbers[0], row.numbers[k]
    place = f" at {_at(found, row)}" if found.keys else ""
    apart = row.apart(k)
    if apart.value == 0:
        return f"{name}: {other} and {first} agree to the last digit{' everywhere' if found.keys else ''}."
    size = "" if a.value == 0 else f", {percent(abs(apart.value / a.value))}"
    weight = abs(row.units(k))
    verdict = "told apart" if weight > _TOLD_APART else "not told apart"
    text = (
        f"{name}: {other} has {with_error(b.value, b.error)} and {first} {with_error(a.value, a.error)}"
        f"{place}, {'more' if apart.value > 0 else 'less'} by {significant(abs(apart.value), 3)}{size}: "
        f"{_times(weight)} times their joint uncertainty"
    )
    if len(known) > 1:
        beyond = sum(abs(row.units(k)) > _TOLD_APART for row in known)
        return f"{text}, the most of {len(known)} rows; in {beyond} of them the two are told apart."
    return f"{text}, so they are {verdict}."


def _surfaces(found: Beside) -> str:
    """Say what the uncertainties of runs leave out, and how far they are apart with it."""
    if found.one_surface:
        return "All of them press the same surface: its scatter plays no part in the differences."
    shares = []
    for result in found.results:
        scatter = result.summary["scatter"]
        ratios = np.array([] if scatter is None else scatter["ratios"])
        shares.append(float(np.std(ratios, ddof=1) / ratios.mean()) if ratios.size > 1 else math.nan)
    rows = [row for row in found.rows if row.quantity == "A/A0 limit"]
    text = (
        "Their surfaces differ, and these uncertainties are those of the grids: another draw of the same "
        "spectrum would differ, too"
    )
    if not rows or not all(map(math.isfinite, shares)):
        return f"{text}, by how much is unknown without an [ensemble] in every scene."
    (row,) = rows
    said = []
    for k in range(1, len(found.results)):
        joint = math.hypot(row.apart(k).error, *(shares[j] * row.numbers[j].value for j in (0, k)))
        said.append(f"{_times(abs(row.apart(k).value) / joint)} ({found.labels[k]})")
    scatters = ", ".join(
        f"{percent(share)} ({label})" for share, label in zip(shares, found.labels, strict=True)
    )
    return (
        f"{text}: single surfaces scatter by {scatters}. With that the areas are "
        f"{', '.join(said)} joint uncertainties from {found.labels[0]}."
    )


def _dataset(found: Beside) -> xr.Dataset:
    """Return every number over row and result."""
    import xarray as xr

    def over(read: Any, words: str) -> tuple[tuple[str, str], Any, dict[str, str]]:
        values = [[read(row, k) for k in range(len(found.results))] for row in found.rows]
        return ("row", "result"), np.array(values), {"units": "1", "long_name": words}

    index = np.arange(1, len(found.rows) + 1)
    keys = {
        f"key_{n + 1}": ("row", [row.where[n] for row in found.rows], {"units": "1", "long_name": key})
        for n, key in enumerate(found.keys)
    }
    quantity = (
        "row",
        [row.quantity for row in found.rows],
        {"units": "1", "long_name": "what it is, with its unit"},
    )
    return xr.Dataset(
        {
            "value": over(lambda row, k: row.numbers[k].value, "in the unit that the quantity names"),
            "error": over(lambda row, k: row.numbers[k].error, "its uncertainty"),
            "difference": over(lambda row, k: row.apart(k).value, "less the first result"),
            "joint_error": over(lambda row, k: row.apart(k).error, "uncertainty of the difference"),
            **keys,
            "quantity": quantity,
        },
        coords={
            "row": ("row", index, {"units": "1"}),
            "result": ("result", list(found.labels), {"units": "1"}),
        },
    )
