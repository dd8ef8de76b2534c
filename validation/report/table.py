"""Tables: values for files, words for people, and how both are written."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.files import atomic_path

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["ResultTable", "WordTable", "shown", "shown_dataset", "write_dataset", "write_table"]

_ROWS_SHOWN = 60


@dataclass(frozen=True, kw_only=True)
class ResultTable:
    """Rows for people and for CSV: column names with units, then values as numbers or words."""

    columns: tuple[str, ...]
    rows: tuple[tuple[float | str, ...], ...]

    @classmethod
    def of(cls, columns: Sequence[str], rows: Sequence[Sequence[float | str]]) -> ResultTable:
        """Build a table from sequences."""
        return cls(columns=tuple(columns), rows=tuple(tuple(row) for row in rows))

    @classmethod
    def of_rows(cls, rows: Iterable[Mapping[str, float | str]]) -> ResultTable:
        """Build a table from rows by title: the first has every column, what others leave out is NaN.

        >>> ResultTable.of_rows([{"grid": "64 x 64", "A/A0": 0.1}, {"grid": "limit"}]).rows
        (('64 x 64', 0.1), ('limit', nan))
        """
        rows = list(rows)
        titles = tuple(rows[0]) if rows else ()
        return cls.of(titles, [[row.get(title, math.nan) for title in titles] for row in rows])


@dataclass(frozen=True, kw_only=True)
class WordTable:
    """A table as it is read, on a page or in a terminal.

    Attributes
    ----------
    columns : tuple of str
        Names, with units.
    rows : tuple of tuples of str
    sums : tuple of tuples of str
        Rows below a line: what the others come to.
    title, note : str
    left : frozenset of str
        Columns of words, which begin at the left; numbers end at the right.
    yielding : tuple of str
        Columns that leave first where there is no room for all, in this order.
    """

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    sums: tuple[tuple[str, ...], ...] = ()
    title: str = ""
    note: str = ""
    left: frozenset[str] = frozenset()
    yielding: tuple[str, ...] = ()


def shown(table: ResultTable, *, title: str = "", note: str = "") -> WordTable:
    """Return a table of values in words, numbers with five significant digits."""
    return _in_words(table.columns, table.rows, title=title, note=note)


def shown_dataset(data: xr.Dataset, *, title: str = "") -> tuple[WordTable, ...]:
    """Return one table for each set of dimensions of a dataset, of at most 60 rows each."""
    tables: list[WordTable] = []
    for frame in _frames(data).values():
        rows = frame.head(_ROWS_SHOWN).itertuples(index=False)
        left_out = len(frame) - _ROWS_SHOWN
        note = f"{left_out} more rows are in data.csv and data.nc." if left_out > 0 else ""
        columns = [_column(data, name) for name in frame.columns]
        tables.append(_in_words(columns, rows, title="" if tables else title, note=note))
    return tuple(tables)


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
    """Return one data frame for each set of dimensions: together they would be multiplied out."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for name, variable in data.data_vars.items():
        if variable.dims:
            groups.setdefault(tuple(map(str, variable.dims)), []).append(str(name))
    return {
        dimensions: data[names].to_dataframe().reset_index()[[*dimensions, *names]]
        for dimensions, names in groups.items()
    }


def _in_words(columns: Sequence[str], rows: Iterable[Sequence[Any]], *, title: str, note: str) -> WordTable:
    values = [tuple(row) for row in rows]
    left = {
        name for k, name in enumerate(columns) if k == 0 or any(isinstance(row[k], str) for row in values)
    }
    return WordTable(
        columns=tuple(columns),
        rows=tuple(tuple(map(_cell, row)) for row in values),
        title=title,
        note=note,
        left=frozenset(left),
        # What a row is stands first, and what it comes to soon after.
        yielding=tuple(reversed(columns[2:])),
    )


def _column(data: xr.Dataset, name: str) -> str:
    unit = data[name].attrs.get("units", "1") if name in data.variables else "1"
    return name if unit == "1" else f"{name} [{unit}]"


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.5g}"
    return str(value)
