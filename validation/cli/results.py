"""How the page of a run or a study is printed: its table, its findings, and where its files are."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.table import Table

    from validation.report.page import Page
    from validation.report.table import WordTable

__all__ = ["page_table", "print_page"]

#: Rows from which on a table is left to the files.
_MANY_ROWS = 40


def print_page(
    page: Page, files: Iterable[Path], *, more: Sequence[str] = (), done: str = "Written:"
) -> None:
    """Print the first table of a page, what was found, and the files.

    Parameters
    ----------
    page : Page
    files : iterable of Path
    more : sequence of str
        Findings that the page does not have.
    done : str
        Line above the files.
    """
    from validation.cli.options import show

    for table in page.tables[:1]:
        if len(table.rows) <= _MANY_ROWS:
            show(page_table(table, title=f"{page.title}: {page.lead}"))
    for finding in (*page.findings, *more):
        show(f"- {finding}")
    show(f"\n{done}")
    for path in files:
        show(f"  {path}")


def page_table(table: WordTable, *, title: str) -> Table:
    """Return a table as rich prints it."""
    from rich.table import Table
    from rich.text import Text

    shown = Table(title=Text(title), caption=Text(table.note))
    for column in table.columns:
        side: Any = "left" if column in table.left else "right"
        shown.add_column(Text(column), justify=side, no_wrap=True)
    for row in table.rows:
        shown.add_row(*map(Text, row))
    shown.add_section()
    for row in table.sums:
        shown.add_row(*map(Text, row))
    return shown
