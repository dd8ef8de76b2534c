"""Recompute Persson (2006): every calculated figure, and every claim that carries a number.

Figures are written as PNG and SVG with their data as CSV, claims as one table in CSV and Markdown. A claim
that does not hold as it stands is reported so.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from dataclasses import astuple, fields
from pathlib import Path

from validation.paper.claims import ClaimRow, judge
from validation.paper.figures import FIGURES, PaperFigure
from validation.paper.table import APPLICATIONS, UNJUDGED

__all__ = ["ClaimRow", "run", "steps"]


def steps() -> int:
    """Count the times `run` reports progress."""
    return len(FIGURES) + sum(len(application.claims) for application in APPLICATIONS)


def run(
    output: Path, *, figures: bool = True, progress: Callable[[str], None] | None = None
) -> tuple[ClaimRow, ...]:
    """Recompute the paper into a folder.

    Parameters
    ----------
    output : Path
        Folder, made if it does not exist; files in it of the same names are replaced.
    figures : bool
        Whether to draw and write the figures, too.
    progress : callable, optional
        Called with the name of each figure or claim before it is computed.

    Returns
    -------
    tuple of ClaimRow
        One row per claim: the paper's number, ours under the joint convention of its application and
        under the literal one, and the verdict.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    tell = progress or (lambda name: None)
    output.mkdir(parents=True, exist_ok=True)
    if figures:
        # matplotlib takes a second to load: only when something is drawn.
        from validation.paper import plots as plots_paper

        for make in FIGURES:
            tell(f"figure {make.__name__.replace('_', ' ')}")
            figure = make()
            _write_data(figure, output / f"{figure.name}.csv")
            plots_paper.save(figure, output)
    rows = [
        row
        for application in APPLICATIONS
        for row in judge(application, tell=lambda text: tell(f"claim: {text}"))
    ]
    _write_claims(rows, output)
    return tuple(rows)


def _write_data(figure: PaperFigure, path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["panel", "curve", "x", "y", "x axis", "y axis"])
        for number, panel in enumerate(figure.panels, start=1):
            for curve in panel.curves:
                for x, y in zip(curve.x, curve.y, strict=True):
                    writer.writerow([number, curve.label, f"{x:.9g}", f"{y:.9g}", panel.x, panel.y])


def _write_claims(rows: Sequence[ClaimRow], output: Path) -> None:
    names = [field.name for field in fields(ClaimRow)]
    with (output / "claims.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        writer.writerows(astuple(row) for row in rows)
    lines = ["| " + " | ".join(names) + " |", "|" + " --- |" * len(names)]
    lines += ["| " + " | ".join(_cell(value) for value in astuple(row)) + " |" for row in rows]
    lines += ["", "Without a verdict:", ""]
    lines += [f"- {one.section}: {one.statement} ({one.reason})." for one in UNJUDGED]
    (output / "claims.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _cell(value: str | float) -> str:
    return value.replace("|", "\\|") if isinstance(value, str) else f"{value:.5g}"
