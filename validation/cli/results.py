"""What is shown of an act: its progress, then the table, the findings and the files of its page."""

from __future__ import annotations

import contextlib
import textwrap
import time
from collections.abc import Callable, Iterator
from typing import Any

from rich import progress
from rich.console import Console
from rich.table import Column, Table
from rich.text import Text

from validation.cli.options import WIDE, print_json, show, terminal_width
from validation.errors import harmless
from validation.execution.attempt import Progress
from validation.execution.results import Outputs
from validation.execution.solve import Solve
from validation.report.table import WordTable

#: Seconds between two lines of a log.
_BETWEEN_LINES = 10.0
#: What is under way when nothing is left to be solved.
_AFTER = "writing the report"
#: Columns of a terminal for the bar and the times.
_TIMES = 38
#: Rows from which on a table is left to the files.
_MANY_ROWS = 80


class Bar(Progress, contextlib.AbstractContextManager["Bar"]):
    """Progress over solves: how many are done, and a bar weighted by their predicted cost.

    Notes are shown even when it is quiet. Where stderr is no terminal, a line is written when the first and
    the last is done and every ten seconds between.
    """

    def __init__(self, *, quiet: bool) -> None:
        self._console = Console(stderr=True, highlight=False)
        self._quiet = quiet
        self._logs = not quiet and not self._console.is_terminal
        # A long name is cut, the times are not.
        words = Column(no_wrap=True, overflow="ellipsis", max_width=max(20, self._console.width - _TIMES))
        self._progress = progress.Progress(
            progress.TextColumn("{task.fields[count]} {task.description}", markup=False, table_column=words),
            progress.BarColumn(),
            progress.TextColumn("{task.percentage:3.0f} %"),
            progress.TimeElapsedColumn(),
            progress.TextColumn("left"),
            # Jobs of very different length follow each other: the speed is averaged over a long while.
            progress.TimeRemainingColumn(elapsed_when_finished=False),
            console=self._console,
            disable=quiet or self._logs,
            speed_estimate_period=600,
        )

    def __exit__(self, *exc: object) -> None:
        if self._progress.tasks and not self._progress.disable:  # rich ends a bar nobody saw with a line
            for task in self._progress.tasks:
                self._progress.update(task.id, description="all is written" if task.finished else "stopped")
            self._progress.stop()

    def start(self, missing: tuple[Solve, ...], stored: int) -> None:
        """Show the bar over the solves still to be done."""
        self._weights = {solve.key: solve.predict().seconds for solve in missing}
        self._done, self._told = 0, -float("inf")
        total = sum(self._weights.values())
        # Not earlier: what is refused before anything runs leaves no empty bar behind.
        self._progress.start()
        for task in self._progress.task_ids:  # a study solves in several rounds: one bar for each
            self._progress.remove_task(task)
        if missing:
            self._task = self._progress.add_task("getting ready", total=total, count=f"0 of {len(missing)}")
        else:
            found = f"all {stored} solves found,"
            self._task = self._progress.add_task(_AFTER, total=1, completed=1, count=found)

    def begin(self, solve: Solve) -> None:
        """Name the solve under way."""
        self._progress.update(self._task, description=harmless(solve.describe()))

    def done(self, solve: Solve) -> None:
        """Advance by the solve's share; after the last the bar is full."""
        self._done += 1
        count = len(self._weights)
        words = f"{self._done} of {count}"
        if self._done == count:
            whole = sum(self._weights.values())
            self._progress.update(self._task, completed=whole, count=f"{words} solved,", description=_AFTER)
        else:
            self._progress.update(self._task, advance=self._weights[solve.key], count=words)
        if self._logs and (self._done in (1, count) or time.monotonic() - self._told > _BETWEEN_LINES):
            self._told = time.monotonic()
            self.note(f"{words}: {solve.describe()} is solved")

    def plan(self, text: str) -> None:
        """Print a line above the bar, unless it is quiet."""
        if not self._quiet:
            self.note(text)

    def note(self, text: str) -> None:
        """Print a line above the bar."""
        self._console.print(f"fem-contact: {harmless(text)}", markup=False, soft_wrap=True)


@contextlib.contextmanager
def under_way(what: str, *, quiet: bool) -> Iterator[Callable[[str], None]]:
    """Say on a terminal what is under way; yields what says the next."""
    console = Console(stderr=True, highlight=False)
    if quiet or not console.is_terminal:
        yield lambda step: None
        return
    with console.status(harmless(what)) as status:
        yield lambda step: status.update(harmless(step))


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
    printed = Table()
    for k in widths:
        side: Any = "left" if table.columns[k] in table.left else "right"
        printed.add_column(Text(harmless(table.columns[k])), justify=side, no_wrap=fits, overflow="fold")
    for row in table.rows:
        printed.add_row(*(Text(harmless(row[k])) for k in widths))
    return printed, tuple(left_out)
