"""The page of `fem-contact reproduce`: every claim with a number, its verdict, and the figures."""

from __future__ import annotations

from collections.abc import Sequence

from validation.paper.claims import ClaimRow
from validation.report.drawing import Drawing
from validation.report.page import Answer, Note, Page
from validation.report.table import ResultTable, WordTable
from validation.report.words import json_ready

__all__ = ["paper_page"]

_PAPER = "B. N. J. Persson, Contact mechanics for randomly rough surfaces, Surf. Sci. Rep. 61, 201 (2006)."
_INFERRED = "reproduced with the inferred convention"


def paper_page(rows: Sequence[ClaimRow], *, figures: tuple[Drawing, ...] = ()) -> Page:
    """Return the page of claims and figures."""
    literal = [row for row in rows if row.verdict == "reproduced"]
    inferred = [row for row in rows if row.verdict.startswith(_INFERRED)]
    missed = [row for row in rows if row not in literal and row not in inferred]
    findings = (
        f"{len(literal)} of {len(rows)} numbers follow from the text as it stands, {len(inferred)} with a "
        f"convention that had to be inferred, {len(missed)} do not.",
        *(f"{row.claim} (Sec. {_section(row)}): {row.verdict}." for row in missed),
    )
    notes = tuple(f"{row.claim}: {row.note}" for row in rows if row.note)
    columns = tuple(ClaimRow.__dataclass_fields__)
    record = ResultTable.of(columns, [tuple(getattr(row, name) for name in columns) for row in rows])
    return Page(
        title="Persson (2006), recomputed",
        lead="Does every calculated figure, and every claim with a number, follow from the equations?",
        answers=(
            Answer(question="As it stands", answer=f"{len(literal)} of {len(rows)}"),
            Answer(question="With an inferred convention", answer=str(len(inferred))),
            Answer(question="Not reproduced", answer=str(len(missed))),
        ),
        findings=findings,
        notes=(Note(title="Remarks", sentences=notes),) if notes else (),
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


def _section(row: ClaimRow) -> str:
    return row.section.removeprefix("Sec. ")


def _verdicts(rows: Sequence[ClaimRow]) -> WordTable:
    return WordTable(
        title="Every claim with a number",
        columns=("claim", "paper", "computed", "verdict", "allowed", "section", "convention"),
        rows=tuple(
            (
                row.claim,
                f"{row.stated:.4g}",
                f"{row.computed:.4g}",
                "inferred" if row.verdict.startswith(_INFERRED) else row.verdict.partition(" because ")[0],
                row.tolerance,
                row.section,
                row.convention,
            )
            for row in rows
        ),
        left=frozenset({"claim", "verdict", "allowed", "section", "convention"}),
        yielding=("convention", "allowed", "section"),
        note="The range allowed was written down before anything was computed. Inferred: the literal "
        "reading does not give the number, the convention named does. Reasons are among the findings.",
    )
