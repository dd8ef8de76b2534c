"""Recompute Persson (2006): every calculated figure, and every claim that carries a number.

A page shows figures and claims, from one dataset. A claim that does not hold as it stands is reported so.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from validation.execution.results import Outputs, leave
from validation.paper.claims import judge
from validation.paper.figures import FIGURES
from validation.paper.general import GENERAL, STEEL
from validation.paper.page import paper_dataset, paper_page
from validation.paper.pmma import PMMA
from validation.paper.pyrex import PYREX
from validation.paper.rim import RIM

#: In the order of the table.
APPLICATIONS = (RIM, GENERAL, STEEL, PMMA, PYREX)


def run(output: Path, *, figures: bool = True, progress: Callable[[str], None] | None = None) -> Outputs:
    """Recompute the paper into a folder.

    Files of the same names are replaced. Without `figures` claims and JSON are written alone; `progress` is
    called with the name of each figure or claim before it is computed.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    tell = progress or (lambda text: None)
    output.mkdir(parents=True, exist_ok=True)
    curves = []
    for figure in FIGURES if figures else ():
        tell(f"figure {figure.name.replace('_', ' ')}")
        curves.append(figure.compute())
    rows = [
        row
        for application in APPLICATIONS
        for row in judge(application, tell=lambda text: tell(f"claim: {text}"))
    ]
    return leave(
        output,
        paper_dataset(rows, curves),
        paper_page,
        report=figures,
        kind="paper",
        name="reproduce",
        settings={"figures": figures},
        store=output,
    )
