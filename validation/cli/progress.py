"""Progress on a terminal: a bar over the solves of a run, with the time that is left."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from validation.solves.solve import Solve

__all__ = ["Bar", "steps_bar"]


class Bar:
    """Progress bar over solves, weighted by their predicted cost; notes are shown even when it is quiet."""

    def __init__(self, *, quiet: bool) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

        self._console = Console(stderr=True, highlight=False)
        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:3.0f} %"),
            TimeElapsedColumn(),
            TextColumn("left"),
            # Jobs of very different length follow each other: the speed is averaged over a long while.
            TimeRemainingColumn(elapsed_when_finished=False),
            console=self._console,
            disable=quiet,
            speed_estimate_period=600,
        )
        self._weights: dict[str, float] = {}

    def __enter__(self) -> Bar:
        return self

    def __exit__(self, *exc: object) -> None:
        if self._progress.tasks:
            self._progress.stop()

    def start(self, missing: tuple[Solve, ...], stored: int) -> None:
        """Show the bar over the solves still to be done."""
        self._weights = {solve.key: solve.predict().seconds for solve in missing}
        total = sum(self._weights.values())
        # Not earlier: what is refused before anything runs leaves no empty bar behind.
        self._progress.start()
        self._task = self._progress.add_task(f"{stored} solves found finished", total=total)

    def begin(self, solve: Solve) -> None:
        """Name the solve under way."""
        self._progress.update(self._task, description=solve.describe())

    def done(self, solve: Solve) -> None:
        """Advance by the solve's share."""
        self._progress.advance(self._task, self._weights[solve.key])

    def note(self, text: str) -> None:
        """Print a line above the bar."""
        self._console.print(f"fem-contact: {text}", markup=False, soft_wrap=True)


@contextlib.contextmanager
def steps_bar(count: int | None, *, quiet: bool) -> Iterator[Callable[[str], None]]:
    """Progress bar over named steps; yields what is to be called before each."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description:.60}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), disable=quiet) as progress:
        task = progress.add_task("", total=count, completed=-1)

        def tell(name: str) -> None:
            progress.update(task, advance=1, description=name)

        yield tell
