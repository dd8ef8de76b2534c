"""The page and the JSON of scorecards."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from validation.cases import Verdict
from validation.cases.scorecard import Scorecard
from validation.files import atomic_path, write_json
from validation.report.page import Answer, Note, Page, render
from validation.report.table import WordTable
from validation.report.words import json_ready

__all__ = ["scorecard_page", "write_scorecards"]

_ERRORS = (0.1, 0.01, 0.001)


def write_scorecards(cards: Sequence[Scorecard], folder: Path) -> tuple[Path, Path]:
    """Write scorecard.html and scorecard.json into a folder; return both.

    Parameters
    ----------
    cards : sequence of Scorecard
        The first is what the page is about; the others stand beside it.
    folder : Path
    """
    page = scorecard_page(cards)
    html = folder / "scorecard.html"
    with atomic_path(html) as draft:
        draft.write_text(render(page), encoding="utf-8")
    return html, write_json(
        folder / "scorecard.json", {"scorecards": [json_ready(card.summary()) for card in cards]}
    )


def scorecard_page(cards: Sequence[Scorecard]) -> Page:
    """Return the page of scorecards, the worst failure of the first one on top."""
    first = cards[0]
    papers = dict.fromkeys(paper for card in cards for paper in card.subject.solver.papers)
    return Page(
        title=f"Scorecard: {' beside '.join(card.subject.name for card in cards)}",
        lead="Is this contact solver right, in what order does it converge, where does it break, "
        "and what does a digit cost?",
        settings={card.subject.name: dict(card.subject.settings) for card in cards},
        seeds="Rough surfaces: 271.",
        papers=tuple(papers),
        answers=_answers(first),
        findings=_findings(first),
        tables=(_verdicts(cards), _costs(cards), _checks(cards)),
        notes=_notes(cards),
    )


def _answers(card: Scorecard) -> tuple[Answer, ...]:
    failed, total = len(card.failed), len(card.verdicts)
    answers = [
        Answer(
            question="Is it right?",
            answer="yes" if not failed else f"no: {failed} of {total} fail",
            basis=f"{total} rows, tolerance {card.subject.tolerance:g}",
        )
    ]
    if card.failed:
        answers.append(
            Answer(question="Worst failure", answer=card.failed[0].case, basis=_reason(card.failed[0]))
        )
    if card.fault is not None:
        row, words = card.fault
        answers.append(Answer(question="What is wrong", answer=words, basis=f"read from the row {row}"))
    cheapest = card.seconds_to(0.01)
    answers.append(
        Answer(
            question="Processor time to 1 % of the area",
            answer="not reached" if math.isnan(cheapest) else f"{cheapest:.2g} s",
            basis="of one rough surface, lambda_long/lambda_short = 4",
        )
    )
    return tuple(answers)


def _findings(card: Scorecard) -> tuple[str, ...]:
    if not card.failed:
        return (f"Every claim holds for {card.subject.name}.",)
    return tuple(f"{verdict.case} fails: {_reason(verdict)}" for verdict in card.failed)


def _reason(verdict: Verdict) -> str:
    """Say in a sentence by how much the worst check of a row is missed, or by how much it is met."""
    if verdict.error is not None:
        return verdict.error
    check = max(
        verdict.checks,
        key=lambda one: (not one.passed, abs(one.computed - one.reference) / (one.tolerance or math.inf)),
    )
    low, high = check.reference - check.tolerance, check.reference + check.tolerance
    allowed = f"{low:.4g} to {high:.4g}"
    if check.reference == 0:
        allowed = f"at most {check.tolerance:.2g}"
    elif check.tolerance < 1e-3 * abs(check.reference):
        allowed = f"{check.reference:.4g} +- {check.tolerance:.2g}"
    return f"{check.quantity} is {check.computed + 0.0:.4g}; allowed is {allowed}."


def _word(card: Scorecard, row: str) -> str:
    verdict = card.verdict(row)
    if verdict is None:
        return "not tried" if card.left_out.get(row, "").startswith("not tried") else "not judged"
    return "holds" if verdict.passed else "FAILS"


def _observed(verdict: Verdict) -> str:
    orders = [check.computed for check in verdict.checks if check.quantity.startswith("observed order")]
    return f"{orders[0]:.2f}" if orders else ""


def _verdicts(cards: Sequence[Scorecard]) -> WordTable:
    names = list(dict.fromkeys(verdict.case for card in cards for verdict in card.verdicts))
    lines = []
    for name in names:
        owners = [card for card in cards if card.verdict(name) is not None]
        verdict = owners[0].verdict(name)
        assert verdict is not None
        words = tuple(_word(card, name) for card in cards)
        lines.append((name, *words, _observed(verdict), _reason(verdict), verdict.claim))
    labels = tuple(card.subject.name for card in cards)
    columns = ("row", *labels, "observed order", "worst check", "claim")
    return WordTable(
        columns=columns,
        rows=tuple(lines),
        title="Verdicts",
        note="The worst failure of the first solver stands on top. Order and check are those of the first.",
        left=frozenset(columns) - {"observed order"},
    )


def _costs(cards: Sequence[Scorecard]) -> WordTable:
    lines = []
    for card in cards:
        times = tuple(card.seconds_to(error) for error in _ERRORS)
        sizes = tuple(card.bytes_to(error) / 2**20 for error in _ERRORS)
        words = tuple("not reached" if math.isnan(value) else f"{value:.2g}" for value in times + sizes)
        finest = card.cost[-1] if card.cost else None
        lines.append(
            (
                card.subject.name,
                *words,
                "" if finest is None else f"{finest.grid}",
                "" if finest is None else f"{finest.error:.2%}",
            )
        )
    return WordTable(
        columns=(
            "solver",
            *(f"seconds to {error:.3g}" for error in _ERRORS),
            *(f"MiB to {error:.3g}" for error in _ERRORS),
            "finest grid",
            "its error",
        ),
        rows=tuple(lines),
        title="What a digit costs",
        note="Processor seconds and memory of the cheapest grid whose area is that near to the limit.",
        left=frozenset({"solver"}),
    )


def _checks(cards: Sequence[Scorecard]) -> WordTable:
    lines = [
        (
            card.subject.name,
            verdict.case,
            check.quantity,
            f"{check.computed:.5g}",
            f"{check.reference:.5g}",
            f"{check.tolerance:.2g}",
            "holds" if check.passed else "FAILS",
        )
        for card in cards
        for verdict in card.verdicts
        for check in verdict.checks
    ]
    return WordTable(
        columns=("solver", "row", "quantity", "computed", "reference", "tolerance", "verdict"),
        rows=tuple(lines),
        title="Every number",
        left=frozenset({"solver", "row", "quantity", "verdict"}),
    )


def _notes(cards: Sequence[Scorecard]) -> tuple[Note, ...]:
    return tuple(
        Note(
            title=f"Rows that were not judged for {card.subject.name}",
            sentences=tuple(f"{row}: {why}." for row, why in card.left_out.items()),
        )
        for card in cards
        if card.left_out
    )
