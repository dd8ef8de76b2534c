"""Progress: a bar with the time that is left on a terminal, lines as it goes in a log."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator

from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as RichProgress
from rich.table import Column

from validation.errors import harmless
from validation.execution.attempt import Progress
from validation.execution.solve import Solve

#: Seconds between two lines of a log.
_BETWEEN_LINES = 10.0
#: What is under way when nothing is left to be solved.
_AFTER = "writing the report"
#: Columns of a terminal for the bar and the times.
_TIMES = 38


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
        self._progress = RichProgress(
            TextColumn("{task.fields[count]} {task.description}", markup=False, table_column=words),
            BarColumn(),
            TextColumn("{task.percentage:3.0f} %"),
            TimeElapsedColumn(),
            TextColumn("left"),
            # Jobs of very different length follow each other: the speed is averaged over a long while.
            TimeRemainingColumn(elapsed_when_finished=False),
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
