"""A study read back: its dataset from the stored solves, and all that it shows from the dataset."""

from __future__ import annotations

import html
import math
import re
from collections.abc import Collection, Mapping
from functools import cache
from typing import Any

import numpy as np
import pint

from validation.audit.dataset import Lines, Result, Variables, ordered
from validation.audit.ledger import Ledger, as_number
from validation.audit.reductions import SOURCES, errors_of, recomputed
from validation.audit.stored import Array

#: Those of the step to any spectrum and period.
_SPECTRAL = ("size", "bandwidth")
_INTERVAL, _HOLDS = "+- (95 %)", "+- holds"
#: Symbols as a page sets them, and as they are typed.
_MARKS = {"±\u00a0": "+- ", "\u00a0%": " %", "\u2032": "'", "Δx": "dx", "Δγ": "Delta gamma"}
_MARKS |= {"κ": "kappa", "σ": "sigma", "γ": "gamma"}
_MARKS |= {"λ": "lambda", "ζ": "zeta", "α": "alpha", "μ": "mu", "ν": "nu"}
#: Fractions in exponents have brackets, A0 and p0 no underscore.
_SET = {r"<sup>([^<]*/[^<]*)": r"^(\1)", "<sup>": "^", r"<sub>(?=[^<\d])": "_", "(?<![Ap])<sub>": "_"}


def value_ledger(result: Result) -> Ledger:
    """Judge all that a result holds."""
    ledger = Ledger()
    if result.store is None:
        ledger.unread.append("data.nc against the solves: its record names no store that is there")
    judge_dataset(result, ledger)
    judge_shown(result, ledger)
    return ledger


def judge_shown(result: Result, ledger: Ledger) -> None:
    """Judge all that shows the dataset: findings, numbers, tables, CSV files, data of figures, page."""
    for judge in (judge_findings, judge_numbers, judge_tables, judge_budget):
        judge(result, ledger)
    for file, data in result.figures.items():  # variables of the dataset
        for name, variable in data.items():
            place, whole = f"figures/{file}", result.data.get(name)
            if whole is None:
                ledger.unread.append(f"{place}: {name}")
            elif variable.values.dtype.kind in "fiub" and variable.dims == whole.dims:
                ledger.exact(place, name, variable.values, whole.values)
    judge_page(result, ledger)


# ---- the dataset -----------------------------------------------------------------------------------------


def judge_dataset(result: Result, ledger: Ledger, judged: Collection[str] = ()) -> None:
    """Judge every variable by its reduction, and its errors by theirs, but those that were judged."""
    for name, variable in result.data.items():
        if variable.values.dtype.kind not in "fiub" or name == "source" or name.endswith("_error"):
            continue
        expected = None if name in judged else recomputed(result, name)
        if expected is not None:
            loose = {"rtol": 1e-6, "atol": 1e-9} if variable.attrs.get("reduction") in _FITTED else {}
            ledger.number("data.nc", name, variable.values, expected, **loose)
        elif name not in {*judged, *variable.dims}:  # neither judged nor a position
            ledger.unread.append(f"data.nc: {name}")
        if f"{name}_error" in result.data and f"{name}_error" not in judged:
            _errors(result, name, ledger)


#: What the audit fits by an implementation of its own: both round.
_FITTED = ("limit", "drift", "line limit", "line slope", "polynomial limit", "power law")


def _errors(result: Result, name: str, ledger: Ledger) -> None:
    error, variable = result.data[f"{name}_error"], result.data[name]
    # Where there is no value, its errors say nothing.
    nowhere = np.isnan(variable.values.astype(float))
    expected = {s: np.where(nowhere, 0.0, share) for s, share in errors_of(result, name).items()}
    for k, source in enumerate(SOURCES):
        where = f"{name}_error, {source}"
        part = np.where(nowhere, 0.0, ordered(error.isel(source=k), variable.dims))
        if source in error.attrs:
            none = np.where(np.isnan(part), np.nan, 0.0)
            ledger.number("data.nc", f"{where} does not enter", part, none)
        elif source in expected and source not in str(error.attrs.get("claimed", "")).split():
            scale = np.fmax.reduce(np.abs(variable.values), axis=None, initial=0.0)
            ledger.number("data.nc", where, part, expected[source], rtol=1e-5, atol=1e-11 * scale)
        elif np.isfinite(part).any():
            ledger.unread.append(f"data.nc: {where}")


# ---- what is shown ---------------------------------------------------------------------------------------


def _total(data: Variables, name: str, place: Mapping[str, int]) -> float | None:
    """Root sum of squares of the sources that enter and are measured; None for what has no errors."""
    return float(_totals(data, name, place).item()) if f"{name}_error" in data else None


def _totals(data: Variables, name: str, place: Mapping[str, int]) -> Array:
    """Return these totals at a place, along the dimensions that are left there."""
    error = data[f"{name}_error"]
    limit = error.attrs.get("limit_in")
    enters = [k for k, s in enumerate(SOURCES) if (s not in _SPECTRAL or s == limit) and s not in error.attrs]
    parts = error.isel(source=enters).isel(place, missing_dims="ignore").astype(float)
    return np.asarray(np.sqrt((parts**2).sum("source", min_count=1)))


def judge_findings(result: Result, ledger: Ledger) -> None:
    """Judge the values of findings by where they say that they stand; those that stand nowhere are listed."""
    for k, finding in enumerate(result.summary.get("findings", ())):
        if isinstance(finding, str):
            ledger.unread.append(f"sentence: {finding}")
            continue
        groups = [finding.get("values", {}), *finding.get("rows", ())]
        for j, (name, value) in enumerate((n, v) for group in groups for n, v in group.items()):
            named, at = value.get("name"), value.get("at", {})
            if named not in result.data or not set(result.data[named].dims) <= set(at):
                ledger.unread.append(f"finding {k + 1}: {name} = {value.get('value')}")
            else:
                _judge_value(result, f"findings: {k + 1}, {name}, value {j + 1}", value, named, at, ledger)


def judge_numbers(result: Result, ledger: Ledger) -> None:
    """Judge the numbers of summary.json, and their intervals: all that have no dimension."""
    numbers = result.summary.get("numbers", {})
    single = {name for name, v in result.data.items() if not v.dims and v.dtype.kind in "fiubUO"}
    ledger.same("summary.json", "missing numbers", sorted(single - {*numbers}), [])
    for name, value in numbers.items():
        if name in result.data:
            _judge_value(result, f"numbers: {name}", value, name, {}, ledger)


def _judge_value(
    result: Result, where: str, value: Mapping[str, Any], name: str, at: Mapping[str, int], ledger: Ledger
) -> None:
    """Judge one value of summary.json, and its interval, by the place of the dataset that it is of."""
    known = {where: (value.get("value"), result.data[name].isel(at, missing_dims="ignore").values.item())}
    if "error" in value:
        known[f"{where}, its interval"] = value["error"], _total(result.data, name, at)
    for what, (found, expected) in known.items():
        infinite = expected in (math.inf, -math.inf)  # JSON has neither
        ledger.exact("summary.json", what, found, math.nan if infinite else expected)


def judge_tables(result: Result, ledger: Ledger) -> None:
    """Judge the CSV files of tables by the variables that their columns or rows are of."""
    tables = result.summary.get("tables", {"table": result.summary.get("table")})
    for name, lines in result.tables.items():
        file = name.removesuffix(".csv")
        known = tables.get(file)
        if known and "names" in known:
            _judge_listing(result, name, known["names"], lines, ledger)
        elif known:
            _judge_table(result, name, known, lines, ledger)
        elif file.startswith("data"):
            _spread_out(result, name, lines, ledger)
        elif file != "budget":
            ledger.unread.append(f"{name}: what its columns are of")


def _judge_listing(result: Result, file: str, names: list[str], lines: Lines, ledger: Ledger) -> None:
    """Judge a table with a row for each number that there is, each in a unit of its own."""
    header, *lines = lines
    value, unit = header.index("value"), header.index("unit")
    there = {name: result.data[name] for name in names if name in result.data and not result.data[name].dims}
    numbers = {name: variable.values.item() for name, variable in there.items()}
    known = {name: n for name, n in numbers.items() if n != "" and n == n}  # neither empty nor NaN
    rows: list[dict[int, Any]] = []
    for (name, number), line in zip(known.items(), lines, strict=False):
        plain = str(there[name].attrs.get("units", "1"))
        factor = (_factor(plain, line[unit]) if line[unit] else 1.0) or math.nan
        rows.append({value: number if isinstance(number, str) else factor * number})
        if header[value + 1].endswith(_INTERVAL):
            rows[-1][value + 1] = factor * as_number(_total(result.data, name, {}))
    _judge_lines(file, header, lines, rows, ledger)


def _judge_table(result: Result, file: str, shown: Mapping[str, Any], lines: Lines, ledger: Ledger) -> None:
    """Judge a table by the variables that its columns are of, where more is known than coordinates."""
    data = result.data
    header, *lines = lines
    intervals = [k for k, title in enumerate(header) if title.endswith((_INTERVAL, _HOLDS))]
    places = [k for k in range(len(header)) if k not in intervals]
    ledger.same(file, "number of columns", len(places), len(shown["columns"]))
    dims, rows = list(shown["rows"]), []
    sizes = {dim: n for v in data.values() for dim, n in v.sizes.items()}
    for place in np.ndindex(*(sizes[dim] for dim in dims)):
        row: dict[int, Any] = {}
        known = False
        for k, column in zip(places, shown["columns"], strict=False):
            name = column["name"]
            at = {**dict(zip(dims, map(int, place), strict=True)), **column.get("at", {})}
            row[k] = data[name].isel(at, missing_dims="ignore").values.item()
            if k + 1 in intervals:  # a column has none where no value of it has an interval
                row[k + 1] = _total(data, name, at)
            whole = not shown.get("sparse") or set(data[name].dims) >= set(dims)
            known |= row[k] == row[k] and whole and name not in shown["coordinates"]
        rows += [row] if known else []
    _judge_lines(file, header, lines, rows, ledger)


def _judge_lines(
    file: str, header: list[str], lines: Lines, rows: list[dict[int, Any]], ledger: Ledger
) -> None:
    """Judge the lines of a CSV file by words and numbers at their columns."""
    ledger.same(file, "number of rows", len(lines), len(rows))
    for j, (line, row) in enumerate(zip(lines, rows, strict=False)):
        ledger.same(file, f"number of cells in row {j + 1}", len(line), len(header))
        for k, value in row.items():
            ledger.exact(file, f"row {j + 1}, {header[k]}", line[k], value)


def judge_budget(result: Result, ledger: Ledger) -> None:
    """Judge budget.csv: value, shares by source in per cent, and their two sums."""
    header, *lines = result.tables.get("budget.csv") or [[]]
    if not lines:
        return
    rows: list[dict[str, Any]] = []
    for name in result.summary.get("budget", ()):
        values, error = result.data[name], result.data[f"{name}_error"]
        for place in np.ndindex(values.shape):
            at, value = dict(zip(values.dims, place, strict=True)), float(values.values[place])
            halves = error.isel(at, missing_dims="ignore").values.ravel().astype(float).tolist()
            # Of zero only no error is a part.
            shares = [100 * abs(half / value) if value else 0.0 if half == 0 else math.nan for half in halves]
            entering = [share for s, share in zip(SOURCES, shares, strict=True) if s not in _SPECTRAL]
            cells: dict[str, Any] = {
                "value": value,
                "for any [%]": math.hypot(*shares),
                "for this spectrum and period [%]": math.hypot(*entering),
            }
            for source, share in zip(SOURCES, shares, strict=True):
                told = "not measured" if math.isnan(share) else share
                cells[f"{source} [%]"] = "does not enter" if source in error.attrs else told
            if "treatment_spread" in result.data:
                spread = result.data["treatment_spread"].isel(at, missing_dims="ignore")
                of_map = 100 * float(spread.values) if name in ("area", "area_own") else math.nan
                measured = [share for share in entering if not math.isnan(share)]
                cells |= {"treatment [%]": of_map, "with treatment [%]": math.hypot(of_map, *measured)}
            rows.append(cells)
    ledger.same("budget.csv", "missing columns", sorted({*rows[0]} - {*header}) if rows else [], [])
    at_columns = [{k: row[title] for k, title in enumerate(header) if title in row} for row in rows]
    _judge_lines("budget.csv", header, lines, at_columns, ledger)


def _spread_out(result: Result, file: str, rows: Lines, ledger: Ledger) -> None:
    """Judge a CSV file of variables that share their dimensions."""
    header, *lines = rows
    for k, name in enumerate(header):
        if name not in result.data or result.data[name].values.dtype.kind not in "fiub":
            continue
        variable, base = result.data[name], name.removesuffix("_error")
        # An interval stands there as one number.
        whole = base != name and base in result.data
        expected = _totals(result.data, base, {}) if whole else variable.values
        if expected.ndim and expected.size == len(lines) and variable.dims != (name,):
            ledger.exact(file, name, np.array([as_number(line[k]) for line in lines]), expected.ravel())


def _plain(cell: str) -> str:
    """Return a cell of a page as it was typed."""
    for printed, typed in _SET.items():
        cell = re.sub(printed, typed, cell)
    text = html.unescape(re.sub(r"<[^>]+>", "", cell))
    for printed, typed in _MARKS.items():
        text = text.replace(printed, typed)
    return text.strip()


def page_tables(page: str) -> dict[str, tuple[list[str], list[list[str]]]]:
    """Return the tables of a page by their titles: names of the columns, and lines of cells."""
    found = {}
    for title, table in re.findall(
        r'aria-label="Table: ([^"]+)"><table[^>]*>(.*?)</table>', page, flags=re.S
    ):
        names = [_plain(cell) for cell in re.findall(r"<th[^>]*>(.*?)</th>", table, flags=re.S)]
        lines = re.findall(r"<tr[^>]*>((?:<td.*?)+)</tr>", table, flags=re.S)
        cells = [[_plain(c) for c in re.findall(r"<td[^>]*>(.*?)</td>", line, flags=re.S)] for line in lines]
        found[html.unescape(title)] = names, cells
    return found


def judge_page(result: Result, ledger: Ledger) -> None:
    """Judge the tables of report.html beside the CSV files: what is printed is what stands there, rounded."""
    if not result.page:
        ledger.unread.append("report.html: there is none")
        return
    for title, (titles, rows) in page_tables(result.page).items():
        place = f"report.html, {title}"
        files = [
            (len(lines) != len(rows), header, lines)
            for header, *lines in filter(None, result.tables.values())
            if all(_in_si(one, dict.fromkeys(header, ""))[0] for one in titles)
        ]
        if not files:
            ledger.unread.append(f"{place}: no file has its columns")
            continue
        # Of several files with these columns the one that is as long.
        _, header, lines = min(files, key=lambda one: one[0])
        ledger.same(place, "number of rows", len(rows), len(lines))
        for k, (row, line) in enumerate(zip(rows, lines, strict=False)):
            cells = dict(zip(header, line, strict=False))
            for column, cell in zip(titles, row, strict=False):
                source, factor = _in_si(column, cells)
                half = factor * as_number(cells.get(f"{source} {_INTERVAL}", ""))
                _cell(ledger, place, f"row {k + 1}, {column}", cell, cells[source], half, factor)


def _in_si(column: str, cells: Mapping[str, str]) -> tuple[str, float]:
    """Find the column of a file in SI units that a page shows, and the factor between them."""
    name, _, unit = column.removesuffix("]").rpartition(" [")
    for title in () if column in cells or not name else cells:
        known, _, plain = title.removesuffix("]").rpartition(" [")
        if known == name and (factor := _factor(plain, unit)):
            return title, factor
    return (column, 1.0) if column in cells else ("", 1.0)


@cache
def _factor(plain: str, unit: str) -> float | None:
    """Return how many of a unit are one of another; None of those of other kinds, and of what is none."""
    plain, unit = (text.replace("Ohm", "ohm") for text in (plain, unit))
    try:
        return float(pint.Quantity(1.0, plain).to(unit).magnitude)
    except Exception:  # the parser of unit names raises whatever its tokens lead to
        return None


def _cell(ledger: Ledger, place: str, name: str, cell: str, source: str, half: float, factor: float) -> None:
    """Judge one cell: words, a number of five digits, or a number with its interval."""
    value = factor * as_number(source)
    if math.isnan(value) and source not in ("", "nan"):
        # A page sets some signs otherwise than they are typed.
        cell, source = (re.sub("[ ^]", "", text).replace("\u2032", "'") for text in (cell, source))
        ledger.same(place, name, cell, source)
    elif "+-" in cell:
        # (2.10 +- 0.32)e-05
        number, _, interval = cell.removeprefix("(").partition("+-")
        interval, _, power = interval.partition(")")
        ledger.text(place, name, number.strip() + power, value)
        ledger.text(place, f"{name}, its interval", interval.strip() + power, half)
    else:
        ledger.text(place, name, cell, value, 5)
