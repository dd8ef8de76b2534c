"""What is shown of a result: table, budget, figures and findings, each a declaration over the dataset."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import xarray as xr

from validation.report.findings import Finding, finding, note, of_one_surface
from validation.report.marks import Band, Figure, Image, Level, Line, Panel, against, panels_along
from validation.report.table import Column, Listing, Table

#: With `Views` all that a study declares by.
__all__ = ["Band", "Card", "Column", "Figure", "Finding", "Findings", "Image", "Level", "Line", "Listing"]
__all__ += ["Panel", "Table", "Views", "against", "finding", "note", "of_one_surface", "panels_along"]

#: What a study found, one after the other.
Findings: TypeAlias = Iterator[Finding]


@dataclass(frozen=True)
class Card:
    """A question on top of a page, its answer, and what the answer rests on."""

    question: str
    answer: Finding | str
    basis: Finding | str = ""


#: So many findings a reader in a hurry takes in.
MOST_FINDINGS = 6


@dataclass(frozen=True, kw_only=True)
class Views:
    """Declarations that `validation.report` shows; nothing in them computes.

    Variables of the `budget` are listed source by source; findings are at most six, the most asked-for first;
    `more` tables stand below the first.
    """

    table: Table | None = None
    budget: Sequence[str] = ()
    figures: Sequence[Figure] = ()
    findings: Sequence[Finding] = ()
    cards: Sequence[Card] = ()
    more: Sequence[Table | Listing] = ()

    @property
    def tables(self) -> list[Table | Listing]:
        """All tables."""
        return [*([] if self.table is None else [self.table]), *self.more]

    def as_json(self, data: xr.Dataset) -> dict[str, Any]:
        """Return what is shown as data: findings, and which variables tables and budget are of."""
        record: dict[str, Any] = {"findings": [finding.as_json() for finding in self.findings]}
        record["tables"] = {table.file: table.as_json(data) for table in self.tables}
        return record | ({"budget": list(self.budget)} if self.budget else {})
