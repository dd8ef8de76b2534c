"""The page of `fem-contact reproduce`: every claim with a number, its verdict, and the figures."""

from __future__ import annotations

from collections.abc import Sequence

from validation.paper.claims import ClaimRow
from validation.paper.table import UNJUDGED
from validation.report.drawing import Drawing
from validation.report.page import Answer, Note, Page
from validation.report.table import ResultTable, WordTable
from validation.report.words import json_ready

__all__ = ["paper_page"]

_PAPER = "B. N. J. Persson, Contact mechanics for randomly rough surfaces, Surf. Sci. Rep. 61, 201 (2006)."
_JOINT = "reproduced under the joint convention"
_CHOSEN = "reproduced with a choice"


def paper_page(rows: Sequence[ClaimRow], *, figures: tuple[Drawing, ...] = ()) -> Page:
    """Return the page of claims and figures."""
    literal = [row for row in rows if row.verdict == "reproduced"]
    joint = [row for row in rows if row.verdict.startswith(_JOINT)]
    chosen = [row for row in rows if row.verdict.startswith(_CHOSEN)]
    missed = [row for row in rows if row.verdict.startswith("not")]
    findings = (
        f"{len(literal)} of {len(rows)} numbers follow from the text as it stands, {len(joint)} under the "
        "set of conventions with which those of the same system agree best, "
        f"{len(chosen)} with a number that the paper does not state, {len(missed)} do not.",
        *(f"{_said(row)} (Sec. {_section(row)}): {row.verdict}." for row in missed),
    )
    notes = tuple(f"{_said(row)}: {row.note}" for row in rows if row.note)
    unjudged = tuple(f"Sec. {one.section}: {one.statement} ({one.reason})." for one in UNJUDGED)
    columns = tuple(ClaimRow.__dataclass_fields__)
    record = ResultTable.of(columns, [tuple(getattr(row, name) for name in columns) for row in rows])
    return Page(
        title="Persson (2006), recomputed",
        lead="Does every calculated figure, and every claim with a number, follow from the equations?",
        answers=(
            Answer(question="As it stands", answer=f"{len(literal)} of {len(rows)}"),
            Answer(
                question="Under a joint convention, or with a choice", answer=str(len(joint) + len(chosen))
            ),
            Answer(question="Not reproduced", answer=str(len(missed))),
        ),
        findings=findings,
        notes=(
            *((Note(title="Remarks", sentences=notes),) if notes else ()),
            Note(title="Without a verdict", sentences=unjudged),
        ),
        tables=(_verdicts(rows),),
        figures=figures,
        settings={"figures": bool(figures)},
        seeds="none: nothing is drawn at random",
        papers=(_PAPER,),
        records={"claims": record},
        summary={
            "claims": [json_ready({name: getattr(row, name) for name in columns}) for row in rows],
            "findings": list(findings),
        },
    )


def _said(row: ClaimRow) -> str:
    return f"{row.application}: {row.claim}"


def _section(row: ClaimRow) -> str:
    return row.section.removeprefix("Sec. ")


def _verdicts(rows: Sequence[ClaimRow]) -> WordTable:
    return WordTable(
        title="Every claim with a number",
        columns=("claim", "paper", "computed", "literal", "verdict", "allowed", "section", "convention"),
        rows=tuple(
            (
                _said(row),
                f"{row.stated:.4g}",
                f"{row.computed:.4g}",
                f"{row.literal:.4g}",
                row.verdict.partition(" because ")[0].partition(":")[0],
                row.tolerance,
                row.section,
                row.convention,
            )
            for row in rows
        ),
        left=frozenset({"claim", "verdict", "allowed", "section", "convention"}),
        yielding=("convention", "allowed", "section", "literal"),
        note="The range allowed was written down before anything was computed. All claims of a system are "
        "judged under one set of conventions: that with which most of them agree (computed), or the literal "
        "one. Reasons are among the findings.",
    )
