"""The table of a report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["ResultTable"]


@dataclass(frozen=True, kw_only=True)
class ResultTable:
    """Rows for people and for CSV: column names with units, then values as numbers or words."""

    columns: tuple[str, ...]
    rows: tuple[tuple[float | str, ...], ...]

    @classmethod
    def of(cls, columns: Sequence[str], rows: Sequence[Sequence[float | str]]) -> ResultTable:
        """Build a table from sequences."""
        return cls(columns=tuple(columns), rows=tuple(tuple(row) for row in rows))
