"""Recompute Persson (2006): every calculated figure, and every claim that carries a number.

A page shows figures and claims, from one dataset. A claim that does not hold as it stands is reported so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from validation.execution.results import Outputs, Result, leave
from validation.paper.claims import STATED, judge, written
from validation.paper.figures import FIGURES
from validation.paper.general import GENERAL, STEEL
from validation.paper.pmma import PMMA
from validation.paper.pyrex import PYREX
from validation.paper.rim import RIM
from validation.report.findings import finding
from validation.report.page import Page, page_of
from validation.report.quantities import labelled
from validation.report.table import Table
from validation.report.values import with_places
from validation.report.views import Card, Views

#: In the order of the table.
APPLICATIONS = (RIM, GENERAL, STEEL, PMMA, PYREX)


def run(output: Path, *, figures: bool = True, progress: Callable[[str], None] | None = None) -> Outputs:
    """Recompute the paper into a folder.

    Files of the same names are replaced. Without `figures` claims and JSON are written alone; `progress` is
    called with the name of each figure or claim before it is computed. An OSError where it cannot be written.
    """
    tell = progress or (lambda text: None)
    output.mkdir(parents=True, exist_ok=True)
    curves, rows = [], []
    for figure in FIGURES if figures else ():
        tell(f"figure {figure.name.replace('_', ' ')}")
        curves.append(figure.compute())
    for application in APPLICATIONS:
        rows += judge(application, tell=lambda text: tell(f"claim: {text}"))
    asked: dict[str, Any] = {"kind": "paper", "name": "reproduce", "settings": {"figures": figures}}
    return leave(output, paper_dataset(rows, curves), paper_page, report=figures, store=output, **asked)


_COUNTED = {
    "claims_literal": "reproduced",
    "claims_joint": "reproduced under the joint convention",
    "claims_chosen": "reproduced with a choice",
    "claims_missed": "not reproduced",
}


def paper_dataset(rows: Sequence[Mapping[str, Any]], figures: Iterable[xr.Dataset]) -> xr.Dataset:
    """Return claims along `claim`, and the curves of figures."""
    columns = {name: ("claim", [row[name] for row in rows]) for name in rows[0]}
    verdicts = columns["paper_verdict"][1]
    counted = {name: float(verdicts.count(words)) for name, words in _COUNTED.items()}
    data = xr.Dataset({**columns, "claims_judged": float(len(rows)), **counted})
    for figure in figures:
        data = data.merge(figure)
    return labelled(data)


def _views(data: xr.Dataset) -> Views:
    missed = data.isel(claim=np.flatnonzero(data.paper_verdict.values == _COUNTED["claims_missed"]))
    answers = {
        "As it stands": "{claims_literal} of {claims_judged}",
        "Under a joint convention": "{claims_joint}",
        "With a choice": "{claims_chosen}",
        "Not reproduced": "{claims_missed}",
    }
    return Views(
        table=Table(
            ("claim",),
            (
                *("claim", "stated", "computed", "paper_verdict", "literal", *STATED[1:]),
                *("paper_section", "paper_convention", "paper_reason", "paper_note"),
            ),
            title="Every claim with a number",
            note="The range allowed was written down before anything was computed. All claims of a system "
            "are judged under one set of conventions: that with which most of them agree (computed), or "
            "the literal one.",
        ),
        figures=[figure.declared() for figure in FIGURES if f"curve_{figure.name}" in data.dims],
        findings=[
            finding(
                "share",
                "{claims_literal} of {claims_judged} numbers follow from the text as it stands, "
                "{claims_joint} under the set of conventions with which those of the same system agree "
                "best, {claims_chosen} with a number that the paper does not state, {claims_missed} do not.",
                data,
            ),
            finding(
                "value", "Not reproduced: {each}.", missed, item="{claim} ({paper_section}: {paper_reason})"
            ),
        ],
        cards=[Card(question=name, answer=finding("share", form, data)) for name, form in answers.items()],
    )


def paper_page(result: Result, *, figures: bool) -> Page:
    """Return the page of claims and figures, from their dataset alone."""
    unjudged = tuple(
        f"Sec. {section}: {one['statement']} ({one['reason']})."
        for section, one in written()["unjudged"].items()
    )
    return page_of(
        result.data,
        _views(with_places(result.data)),
        figures=figures,
        title="Persson (2006), recomputed",
        lead="Does every calculated figure, and every claim with a number, follow from the equations?",
        notes={"Without a verdict": unjudged},
        settings=result.settings,
        seeds="none: nothing is drawn at random",
        papers=("[persson2006].",),
        summary={"kind": result.kind, "name": result.name},
    )
