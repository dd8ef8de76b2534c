"""Where tables and figures stand on a page: beside the first figure, across the page, or in two columns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from validation.report.table import WordTable

#: Characters of a table, and of a sentence, in half of a page of 1400 pixels.
_HALF, _LINE = 76, 68
#: Lines of a table that are as high as the first figure, and by how many what is beside it may be higher.
_FIGURE, _HIGHER = 20.0, 6.0
#: Rows from which on a table is folded.
_FOLDED = 40
#: Lines of a table for its title and its note, and for a line of a sentence.
_AROUND, _SENTENCE = 4.5, 0.85


@dataclass(frozen=True)
class Placed:
    """A table on a page; where it is `turned`, its rows stand side by side."""

    table: WordTable
    turned: bool

    @property
    def narrow(self) -> bool:
        """Whether half a page holds it: titles and long cells break between words."""
        rows = [[len(cell.replace("+- ", "+-")) for cell in row] for row in self.table.rows]
        if len(rows) > _FOLDED:
            return False
        if self.turned:
            return 20 + sum(2 + max([min(20, first), *others]) for first, *others in rows) <= _HALF
        titles = (max([6, *map(len, title.split())]) for title in self.table.columns)
        widths: list[int] = [max(column) for column in zip(titles, *rows, strict=True)]
        return sum(2 + min(36, width) for width in widths) <= _HALF

    @property
    def lines(self) -> float:
        """How high it is, in lines of a table."""
        return _AROUND + len(self.table.columns if self.turned else self.table.rows)


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Tables `beside` the first figure, `across` the page and in `columns` with the `narrow` figures."""

    beside: tuple[Placed, ...]
    across: tuple[Placed, ...]
    columns: tuple[Placed, ...]
    narrow: tuple[Mapping[str, Any], ...]
    wide: tuple[Mapping[str, Any], ...]

    @property
    def even(self) -> bool:
        """Whether neither column is longer by a third of a figure."""
        heights = [*(one.lines for one in self.columns), *(_FIGURE for _ in self.narrow)]
        splits = (sum(heights[:k]) - sum(heights[k:]) for k in range(len(heights) + 1))
        return min(map(abs, splits)) < _FIGURE / 3


def layout(
    findings: Iterable[str],
    tables: Sequence[WordTable],
    budget: WordTable | None,
    figures: Sequence[Mapping[str, Any]],
) -> Layout:
    """Place what a page shows so that no half of it stays empty.

    The budget and the first table stand below the findings, where half a page holds them and there is room
    beside the first figure.
    """
    placed = [Placed(table, len(table.columns) > 12 and len(table.rows) < 9) for table in tables]
    if budget is not None:
        upright = Placed(budget, False)
        placed.insert(1, upright if upright.narrow else Placed(budget, len(budget.rows) < 5))
    beside: list[Placed] = []
    lines = 2 + sum(_SENTENCE * (1 + len(text) // _LINE) for text in findings)
    room = _FIGURE + _HIGHER if figures and not figures[0]["wide"] else 0.0
    for one in sorted(placed[:2], key=lambda one: one.table is not budget):
        if one.narrow and lines + one.lines <= room:
            beside.append(one)
            lines += one.lines
    rest = [one for one in placed if one not in beside]
    return Layout(
        beside=tuple(beside),
        across=tuple(one for one in rest if not one.narrow),
        columns=tuple(one for one in rest if one.narrow),
        narrow=tuple(figure for figure in figures[1:] if not figure["wide"]),
        wide=tuple(figure for figure in figures[1:] if figure["wide"]),
    )
