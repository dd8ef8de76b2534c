"""Recompute Persson (2006): every calculated figure, and every claim that carries a number.

A page shows figures and claims; every number goes to CSV, netCDF and JSON beside it. A claim that does not
hold as it stands is reported so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from validation.paper.claims import ClaimRow, judge
from validation.paper.figures import FIGURES
from validation.paper.page import paper_page
from validation.paper.table import APPLICATIONS
from validation.report.drawing import Drawing
from validation.report.page import Page, write_page

__all__ = ["ClaimRow", "Reproduced", "run", "steps"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Reproduced:
    """What recomputing the paper left behind.

    Attributes
    ----------
    rows : tuple of ClaimRow
        One for each claim: the paper's number, ours, the convention, the verdict.
    page : Page
    files : tuple of Path
        The report first, where figures were asked for.
    """

    rows: tuple[ClaimRow, ...]
    page: Page
    files: tuple[Path, ...]


def steps() -> int:
    """Count the times `run` reports progress."""
    return len(FIGURES) + sum(len(application.claims) for application in APPLICATIONS)


def run(output: Path, *, figures: bool = True, progress: Callable[[str], None] | None = None) -> Reproduced:
    """Recompute the paper into a folder.

    Parameters
    ----------
    output : Path
        Folder, made if it does not exist; files in it of the same names are replaced.
    figures : bool
        Whether to draw the figures and write the report, or claims and JSON alone.
    progress : callable, optional
        Called with the name of each figure or claim before it is computed.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    tell = progress or (lambda name: None)
    output.mkdir(parents=True, exist_ok=True)
    drawings: list[Drawing] = []
    if figures:
        # matplotlib takes a second to load: only when something is drawn.
        from validation.paper.plots import drawn

        for make in FIGURES:
            tell(f"figure {make.__name__.replace('_', ' ')}")
            drawings.append(drawn(make()))
    rows = [
        row
        for application in APPLICATIONS
        for row in judge(application, tell=lambda text: tell(f"claim: {text}"))
    ]
    page = paper_page(rows, figures=tuple(drawings))
    files = write_page(page, output, numbers_only=not figures)
    return Reproduced(rows=tuple(rows), page=page, files=files)
