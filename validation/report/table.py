"""Tables: which variables of a dataset by which rows, as values for files and as words for people."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import xarray as xr

from validation.errors import UsageError
from validation.files import atomic_path
from validation.report.estimates import SOURCES, SPECTRAL, sources_of, total_error
from validation.report.places import each
from validation.report.quantities import place_words, prefixed_unit, quantity, quantity_of, written_unit
from validation.report.values import Value, known, value_of
from validation.report.words import with_error

#: Characters in half of a page of 1400 pixels, and rows from which on a table is folded.
_HALF, _FOLDED = 76, 40
#: How variables of single surfaces end.
_SINGLE = ("_each", "_each_error", "_each_drift")

#: What a column of half widths is called, behind the title of its values, and one of what these hold where
#: not all that enters was measured.
INTERVAL, SOURCES_OF = "+- (95 %)", "+- holds"
#: What a budget says of a measured map beside the sources.
TREATMENT = "treatment [%]"
#: What stands in a budget for a source that has no part in a number.
_ENTERS_NOT = "does not enter"
#: What stands there for a source that enters, and was left out.
_UNMEASURED = "not measured"


#: Cells by the titles of their columns.
Row: TypeAlias = dict[str, float | str]


@dataclass(frozen=True)
class Column:
    """A variable as a column, where it has more dimensions than the rows at positions along them."""

    name: str
    at: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Table:
    """A table of a dataset: one row for each place along `rows`, the last one running first.

    A place at which nothing but its coordinates is known has no row; with `sparse`, nor has one where nothing
    was solved. Titles and units of the columns are those of the registry, intervals stand behind their
    values.
    """

    rows: tuple[str, ...]
    columns: tuple[str | Column, ...]
    _: KW_ONLY
    title: str = "Numbers"
    note: str = ""
    file: str = "table"
    sparse: bool = False

    def of(self, data: xr.Dataset) -> ResultTable:
        """Return every number of it: a value with an interval takes two columns.

        A UsageError for a name that the registry does not know, and for two of one title.
        """
        every = (_place(column, data) for column in self.columns)
        made = [one for one in every if one[0] in data.variables]
        named: dict[str, str] = {}
        for name, title, _ in made:
            if named.setdefault(title, name) != name:
                raise UsageError(f"table: {named[title]!r} and {name!r} have one title, {title!r}; list one")
        rows = []
        places = {title for name, title, _ in made if name in data.coords}
        solved = [t for n, t, _ in made if n in data.data_vars and set(data[n].dims) >= set(self.rows)]
        listed = {name for name, _, _ in made}
        subset = data[[n for n in data.data_vars if str(n).removesuffix("_error") in listed]]
        for here in each(subset, *self.rows):
            row: Row = {}
            for name, title, at in made:
                row |= value_cells(title, value_of(here.isel(at, missing_dims="ignore"), name))
            values = {k: v for k, v in row.items() if k not in places and not k.endswith(SOURCES_OF)}
            there = any(isinstance(v, str) or not math.isnan(v) for v in values.values())
            if there and (not self.sparse or any(known(row[title]) for title in solved)):
                rows.append(row)
        written = {title: unit for name, title, _ in made if (unit := written_unit(data[name]))}
        return replace(ResultTable.of_rows(rows), units=written)

    def as_json(self, data: xr.Dataset) -> dict[str, Any]:
        """Return which variables its columns are of, those that the dataset has."""
        there: list[dict[str, Any]] = []
        for name, _, at in (_place(column, data) for column in self.columns):
            place = {dim: k % data.sizes[dim] for dim, k in at.items() if dim in data.dims}
            column = {"name": name, "at": place}
            if name in data.variables and column not in there:
                there.append(column)
        coordinates = sorted(str(name) for name in data.coords if not str(name).startswith("_"))
        attrs = {"sparse": True} if self.sparse else {}
        return {"rows": list(self.rows), "columns": there, "coordinates": coordinates, **attrs}


@dataclass(frozen=True, kw_only=True)
class Listing:
    """A table of single numbers: a row for each variable that a dataset has, in words and in its unit."""

    names: tuple[str, ...]
    title: str
    note: str = ""
    file: str = "numbers"

    def of(self, data: xr.Dataset) -> ResultTable:
        """Return the numbers that are there, in units that suit their size."""
        rows: list[Row] = []
        for name in self.names:
            if name not in data.variables or data[name].ndim:
                continue
            value, what = value_of(data, name), quantity_of(data, name)
            if not known(value.value):
                continue
            size = abs(value.value) if isinstance(value.value, float) else 0.0
            factor, unit = written_unit(data[name]) or prefixed_unit(what.unit, size)
            scaled = value.value if isinstance(value.value, str) else factor * value.value
            error = math.nan if value.error is None else factor * value.error
            cells = value_cells("value", replace(value, value=scaled, error=error))
            named: Row = {"quantity": what.meaning, "symbol": what.symbol}
            rows.append({**named, **cells, "unit": "" if unit == "1" else unit})
        return ResultTable.of_rows(rows)

    def as_json(self, data: xr.Dataset) -> dict[str, Any]:
        """Return which variables its rows may be of."""
        return {"names": list(self.names)}


def value_cells(title: str, value: Value) -> Row:
    """Return a value, half of its interval, and what that holds where it is not all, by their columns."""
    interval: Row = {} if value.error is None else {INTERVAL: value.error, SOURCES_OF: value.sources}
    return {title: value.value, **{f"{title} {what}": cell for what, cell in interval.items()}}


def _place(column: str | Column, data: xr.Dataset) -> tuple[str, str, Mapping[str, int]]:
    if isinstance(column, str):
        column = Column(column)
    title = quantity_of(data, column.name).title
    for dim, k in column.at.items():
        if dim in data.dims:
            there = place_words(data.isel({dim: k}), dim, data) or f"{dim} {k % data.sizes[dim] + 1}"
            title += f" at {there}"
    return column.name, title, column.at


def budget_table(data: xr.Dataset, names: Sequence[str]) -> ResultTable:
    """Return what is uncertain about some variables at every place, by source, in per cent of the value.

    A source that was not measured leaves the totals that it enters empty. How far other treatments of a
    measured map move its area stands beside the sources, with the root of the sum of squares of all that was
    measured.
    """
    rows: list[Row] = []
    for name in names:
        errors = data[f"{name}_error"]
        dims = [str(d) for d in errors.dims if d != "source"]
        for here in each(data, *dims):
            value, error = float(here[name]), here[f"{name}_error"]
            places = [place for dim in dims for place in _all_words(here, dim, data)]
            # Of zero only no error is a part.
            parts = 100 * abs(error / value) if value else error.where(error == 0)
            shares = dict(zip(SOURCES, map(float, parts), strict=True))
            entering = [share for s, share in shares.items() if s not in SPECTRAL]
            row: Row = {
                "number": ", ".join([quantity(name).title, *filter(None, places)]),
                "value": value,
                "for this spectrum and period [%]": math.hypot(*entering),
                "for any [%]": math.hypot(*shares.values()),
            }
            for source, share in shares.items():
                measured = _UNMEASURED if math.isnan(share) else share
                row[f"{source} [%]"] = _ENTERS_NOT if source in error.attrs else measured
            if "treatment_spread" in data and name in ("area", "area_own"):
                row[TREATMENT] = spread = 100 * float(here["treatment_spread"])
                known_shares = (share for share in entering if not math.isnan(share))
                row["with treatment [%]"] = math.hypot(spread, *known_shares)
            rows.append(row)
    return ResultTable.of_rows(rows)


def _all_words(here: xr.Dataset, dim: str, data: xr.Dataset) -> list[str]:
    """Say where one is along a dimension: by all that changes along it, where nothing has its name."""
    along = [str(n) for n, c in data.coords.items() if c.dims == (dim,) and len(set(c.values.tolist())) > 1]
    if dim in data.coords or not along:
        return [place_words(here, dim, data)]
    there = [name for name in along if bool(here[name].notnull())]
    return [place_words(here[[name]], dim, data[[name]]) for name in there]


@dataclass(frozen=True, kw_only=True)
class ResultTable:
    """Rows for people and for CSV: column names with units, then values as numbers or words."""

    columns: tuple[str, ...]
    rows: tuple[tuple[float | str, ...], ...]
    #: Factors and units of columns that are shown as their scene was written.
    units: Mapping[str, tuple[float, str]] = field(default_factory=dict)

    @classmethod
    def of_rows(cls, rows: Iterable[Row]) -> ResultTable:
        """Build a table from rows by title: the first has every column, what others leave out is NaN.

        >>> ResultTable.of_rows([{"grid": "64 x 64", "A/A0": 0.1}, {"grid": "limit"}]).rows
        (('64 x 64', 0.1), ('limit', nan))
        """
        rows = list(rows)
        titles = tuple(dict.fromkeys(title for row in rows for title in row))
        titles = tuple(t for t in titles if not t.endswith(SOURCES_OF) or any(row.get(t) for row in rows))
        return cls(columns=titles, rows=tuple(tuple(row.get(t, math.nan) for t in titles) for row in rows))

    def _repr_html_(self) -> str:
        import pandas

        frame = pandas.DataFrame(self.rows, columns=self.columns)
        return str(frame.to_html(index=False, na_rep="", float_format="{:.4g}".format))


@dataclass(frozen=True, kw_only=True)
class WordTable:
    """A table as it is read, on a page or in a terminal.

    Columns that begin at the `left` are words; those `yielding` leave first, in this order, where there is no
    room. Where it is `turned`, its rows stand side by side.
    """

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    title: str = ""
    note: str = ""
    left: frozenset[str] = frozenset()
    yielding: tuple[str, ...] = ()
    turned: bool = False

    @property
    def narrow(self) -> bool:
        """Whether half a page holds it: titles and long cells break between words."""
        rows = [[len(cell.replace("+- ", "+-")) for cell in row] for row in self.rows]
        if len(rows) > _FOLDED:
            return False
        if self.turned:
            return 20 + sum(2 + max([min(20, first), *others]) for first, *others in rows) <= _HALF
        titles = (max([6, *map(len, title.split())]) for title in self.columns)
        widths: list[int] = [max(column) for column in zip(titles, *rows, strict=True)]
        return sum(2 + min(36, width) for width in widths) <= _HALF

    @property
    def lines(self) -> float:
        """How high it is, in lines of a table, with its title and note."""
        return 4.5 + len(self.columns if self.turned else self.rows)


def shown(table: ResultTable, *, title: str = "", note: str = "") -> WordTable:
    """Return a table of values in words, those with an interval in one cell, others with five digits.

    Units have the prefix that suits the largest number of a column. Columns in which nothing stands are left
    out, as are those of what enters nowhere or was measured nowhere, which the note names.
    """
    names = [name for name in table.columns if not name.endswith((INTERVAL, SOURCES_OF))]
    cells = [dict(zip(table.columns, row, strict=True)) for row in table.rows]
    columns: list[str] = []
    printed: list[list[str]] = []
    left, absent = set(), dict[str, list[str]]()
    for name in names:
        values = [row[name] for row in cells]
        words = {*map(_cell, values)}
        if words <= {"", _ENTERS_NOT} or words == {_UNMEASURED}:
            for what in words - {""}:
                absent.setdefault(what, []).append(name.removesuffix(" [%]"))
            continue
        head, bracket, unit = (
            name.removesuffix("]").rpartition("[") if name.endswith("]") else (name, "", "1")
        )
        sizes = (abs(value) for value in values if isinstance(value, float) and math.isfinite(value))
        factor, prefixed = table.units.get(name) or prefixed_unit(unit, max(sizes, default=0.0))
        columns.append(f"{head}[{prefixed}]" if bracket else name)
        column = [_with_interval(row[name], row.get(f"{name} {INTERVAL}"), factor) for row in cells]
        if name == names[0] or any(isinstance(cell, str) for cell in column):
            left.add(columns[-1])
        printed.append(list(map(_cell, column)))
    titles = {_UNMEASURED: "Not measured", _ENTERS_NOT: f"What {_ENTERS_NOT}"}
    nowhere = [f"{title}: {', '.join(absent[what])}." for what, title in titles.items() if what in absent]
    return WordTable(
        columns=tuple(columns),
        rows=tuple(zip(*printed, strict=True)),
        title=title,
        note=" ".join(filter(None, (note, _what_intervals_hold(names, cells), *nowhere))),
        left=frozenset(left),
        # What a row is stands first, and what it comes to soon after.
        yielding=tuple(reversed(columns[2:])),
    )


def _what_intervals_hold(names: Sequence[str], cells: Sequence[Row]) -> str:
    """Say of which sources the intervals of a table are, where these are not all that enter."""
    of: dict[str, list[str]] = {}
    for name in names:
        told = (row.get(f"{name} {SOURCES_OF}") for row in cells)
        held = dict.fromkeys(one for one in told if isinstance(one, str))
        if sources := " or ".join(filter(None, held)):
            of.setdefault(sources, []).append(name)
    if len(of) == 1 and sum(f"{name} {INTERVAL}" in cells[0] for name in names) == len(*of.values()):
        return f"Intervals (95 %) hold: {next(iter(of))}."
    each_of = (f"{sources} ({', '.join(names)})" for sources, names in of.items())
    return f"Intervals (95 %) hold: {'; '.join(each_of)}." if of else ""


def write_table(table: ResultTable, path: Path) -> Path:
    """Write a table as CSV, every digit of its numbers."""
    with atomic_path(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([table.columns, *table.rows])
    return path


def write_dataset(data: xr.Dataset, path: Path) -> tuple[Path, ...]:
    """Write a dataset as CSV; variables of other dimensions than the first go into files of their own."""
    written = []
    for k, (dimensions, frame) in enumerate(_frames(data).items()):
        target = path if k == 0 else path.with_stem(f"{path.stem}-{'-'.join(dimensions)}")
        with atomic_path(target) as draft:
            frame.to_csv(draft, index=False)
        written.append(target)
    return tuple(written)


def _frames(data: xr.Dataset) -> dict[tuple[str, ...], Any]:
    """Return one data frame for each set of dimensions: together they would be multiplied out.

    Coordinates stand in front, and intervals, as one number, behind their values. Values of single surfaces
    and the shares of the sources are in data.nc.
    """
    groups: dict[tuple[str, ...], dict[str, Any]] = {}
    for name in map(str, data.data_vars):
        of_another = name.endswith("_error") and name.removesuffix("_error") in data
        if of_another or name.endswith(_SINGLE) or name == "solve" or not data[name].dims:
            continue
        group = groups.setdefault(tuple(map(str, data[name].dims)), {})
        group[name] = data[name]
        error = total_error(data, name)
        if error is not None:
            group[f"{name}_error"] = error.transpose(*data[name].dims)
            held = data[f"{name}_error"].transpose(*data[name].dims, "source")
            words = [sources_of(held[k]) for k in np.ndindex(data[name].shape)]
            if any(words):
                group[f"{name}_sources"] = data[name].copy(data=np.reshape(words, data[name].shape))
    frames = {}
    for dims, group in groups.items():
        along = {str(n): c for n, c in data.coords.items() if n not in dims and c.ndim}
        rows = [name for name, c in along.items() if set(c.dims) <= set(dims)]
        frame = data[rows].assign(group).to_dataframe(dim_order=list(dims)).reset_index()
        # A place along a dimension is told by its value, or counted where it has none.
        valued = {data[name].dims for name in rows}
        counted = [dim for dim in dims if dim in data.indexes or (dim,) not in valued]
        frames[dims] = frame[[*counted, *rows, *group]]
    return frames


def _with_interval(value: float | str, error: float | str | None, factor: float) -> float | str:
    if isinstance(value, str):
        return value
    if not isinstance(error, float) or not error or math.isnan(error + value):
        return value * factor
    return with_error(value * factor, error * factor)


def _cell(value: Any) -> str:
    if not isinstance(value, float):
        return str(value)
    digits = ".0f" if value.is_integer() and abs(value) < 1e9 else ".5g"
    return "" if math.isnan(value) else f"{value:{digits}}"
