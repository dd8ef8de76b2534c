"""How the page of a run or a study is printed: its table, its findings, and where its files are."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Any

from validation.cli.options import WIDE, print_json, show, terminal_width
from validation.errors import harmless
from validation.execution.results import Outputs
from validation.report.table import WordTable

if TYPE_CHECKING:
    from rich.table import Table

#: Rows from which on a table is left to the files.
_MANY_ROWS = 80


def print_outputs(outputs: Outputs, *, as_json: bool = False, done: str = "Written:") -> None:
    """Print the first table of a page, its findings and `more` of them, and below `done` the files.

    For scripts, its summary as JSON instead, of a study its dataset.
    """
    page = outputs.page
    if as_json:
        print_json(outputs.data.to_dict() if outputs.result.kind == "study" else page.summary)
        return
    _show_sentence(f"{page.title}: {page.lead}")
    for table in page.tables[:1]:
        if len(table.rows) <= _MANY_ROWS:
            print_table(table, elsewhere="In the files, not here")
        else:
            show(f"A table of {len(table.rows)} rows: see table.csv, or the page.")
    for finding in (*page.findings, *outputs.more):
        _show_sentence(f"- {finding}")
    show(f"\n{done}")
    for path in outputs.files:
        show(f"  {path}")


def print_table(table: WordTable, *, elsewhere: str = "Not shown") -> None:
    """Print a table and its note; say which of its columns found no place."""
    shown, left_out = page_table(table, width=terminal_width() or WIDE)
    show(shown)
    _show_sentence((f"{elsewhere}: {'; '.join(left_out)}. " if left_out else "") + table.note)


def _show_sentence(text: str) -> None:
    for line in sentence_lines(text, terminal_width()):
        show(line)


def sentence_lines(text: str, width: int | None) -> list[str]:
    """Break a text at words, lines after the first indented below a bullet; a log gets it as one line.

    >>> sentence_lines("- The area of contact grows.", 20)
    ['- The area of', '  contact grows.']
    """
    if width is None:
        return [text] if text else []
    below = "  " if text.startswith("- ") else ""
    return textwrap.wrap(text, width, subsequent_indent=below, break_long_words=False, break_on_hyphens=False)


def page_table(table: WordTable, *, width: int) -> tuple[Table, tuple[str, ...]]:
    """Return a table as rich prints it in a width, and the columns that found no place in it.

    Columns leave whole, in the order that the table says, so that none of those that stay is cut.
    """
    import rich.table
    from rich.text import Text

    # By position: two columns, such as two uncertainties, may have one name.
    cells = zip(table.columns, *table.rows, strict=True)
    # Each brings two blanks and an edge.
    widths = {k: 3 + max(map(len, column)) for k, column in enumerate(cells)}
    left_out: list[str] = []
    for name in table.yielding:
        if sum(widths.values()) < width:
            break
        left_out.append(name)
        widths = {k: w for k, w in widths.items() if table.columns[k] != name}
    fits = sum(widths.values()) < width
    printed = rich.table.Table()
    for k in widths:
        side: Any = "left" if table.columns[k] in table.left else "right"
        printed.add_column(Text(harmless(table.columns[k])), justify=side, no_wrap=fits, overflow="fold")
    for row in table.rows:
        printed.add_row(*(Text(harmless(row[k])) for k in widths))
    return printed, tuple(left_out)
