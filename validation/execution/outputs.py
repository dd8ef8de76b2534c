"""What any act leaves, written and shown: its page is made of its stored dataset alone, now or again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.errors import RunFailed
from validation.execution.results import DATA, Result, read_results, write_results
from validation.files import locked
from validation.report.page import Page, write_page

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, kw_only=True, eq=False)
class Outputs:
    """What an act left behind.

    Of the `files` a reader may want to open the report is first. Of the solves `solved` were done now and
    `reused` found finished; `failures` say why others failed, and what to do; `more` is what a
    run to an accuracy says of what it reached.
    """

    result: Result
    page: Page
    folder: Path
    files: tuple[Path, ...]
    solved: int = 0
    reused: int = 0
    failures: tuple[str, ...] = ()
    more: tuple[str, ...] = ()

    @property
    def data(self) -> xr.Dataset:
        """Every number."""
        return self.result.data

    def check(self) -> None:
        """Raise `RunFailed` where solves failed, which are rows of the report without numbers."""
        if self.failures:
            failures = "\n".join(f"  {why}" for why in self.failures)
            raise RunFailed(f"not all solves succeeded, the report is of the others:\n{failures}")


def leave(
    folder: Path, data: xr.Dataset, page_of: Callable[..., Page], *, report: bool, **record: Any
) -> Outputs:
    """Write dataset and record (`write_results`) of an act into its folder, and `show` them."""
    with locked(folder):
        write_results(folder, data, **record)
        return show(folder, page_of, report=report)


def show(folder: Path, page_of: Callable[..., Page], *, report: bool = True) -> Outputs:
    """Write the page of what a folder holds; without `report` tables and JSON alone.

    `page_of` makes the page of a `Result`, drawn or not (`figures`).

    A UsageError for a folder that holds no finished results of this version, or others than `page_of` shows.
    """
    with locked(folder):
        result = read_results(folder)
        page = page_of(result, figures=report)
        written = write_page(page, folder, numbers_only=not report)
        return Outputs(result=result, page=page, folder=folder, files=(*written, folder / DATA))
