"""The page of `fem-contact validate`: verdicts, every check, and errors against resolution."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from validation.cases import Check, Verdict
from validation.report.drawing import Drawing
from validation.report.page import Answer, Page
from validation.report.table import ResultTable, WordTable
from validation.report.words import json_ready, with_error

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["validation_page"]


def validation_page(verdicts: Sequence[Verdict], *, asked: Mapping[str, Any], figures: bool = True) -> Page:
    """Return the page of verdicts, what failed on top.

    Parameters
    ----------
    verdicts : sequence of Verdict
    asked : mapping
        What was asked for.
    figures : bool
    """
    failed = [verdict for verdict in verdicts if not verdict.passed]
    worst = [verdict for verdict in verdicts if verdict.passed and verdict.checks]
    findings = [f"{verdict.case} FAILED: {_reason(verdict)}" for verdict in failed]
    if not failed:
        findings.append(f"Every claim holds: all {len(verdicts)} cases passed.")
    findings += _closest(worst)
    ladders = [(v.case, check) for v in verdicts for check in v.checks if check.ladder]
    checks = sum(len(verdict.checks) for verdict in verdicts)
    return Page(
        title="Cases with a known answer",
        lead="Does the code give what is known: closed forms, limits, symmetries, orders of convergence?",
        answers=(
            Answer(
                question="Does everything hold?",
                answer=f"no: {len(failed)} of {len(verdicts)} fail" if failed else "yes",
                basis=f"{len(verdicts)} cases with {checks} checks",
            ),
            Answer(question="What did it cost?", answer=f"{sum(v.seconds for v in verdicts):.3g} s"),
        ),
        findings=tuple(findings),
        tables=(_verdicts(verdicts), _checks(verdicts)),
        figures=_figures(ladders) if figures and ladders else (),
        settings=asked,
        seeds="fixed in each case",
        papers=tuple(dict.fromkeys(verdict.source for verdict in verdicts if _is_paper(verdict.source))),
        records={"table": _record(verdicts)},
        summary={"cases": [json_ready(verdict.summary()) for verdict in verdicts], "findings": findings},
    )


def _is_paper(source: str) -> bool:
    """Whether a case rests on something published, and not on a symmetry or a definition.

    >>> _is_paper("Student, Biometrika 6, 1 (1908)"), _is_paper("symmetry")
    (True, False)
    """
    return re.search(r"\d{4}|Johnson|Timoshenko", source) is not None


def _used(check: Check) -> float:
    """Share of its tolerance that a check uses."""
    apart = abs(check.computed - check.reference)
    return apart / check.tolerance if check.tolerance > 0 else (0.0 if apart == 0 else math.inf)


def _reason(verdict: Verdict) -> str:
    if verdict.error is not None:
        return verdict.error
    said = [
        f"{check.quantity} is {check.computed:.4g}, allowed is {check.allowed}"
        for check in verdict.checks
        if not check.passed
    ]
    return "; ".join(said) + "." if said else "it checked nothing."


def _closest(passed: Sequence[Verdict]) -> Iterator[str]:
    """Say which check that passed is nearest to its tolerance; ranges, in which any place is good, apart."""
    known = [
        (_used(check), verdict.case, check)
        for verdict in passed
        for check in verdict.checks
        if not check.is_range
    ]
    if known:
        share, case, check = max(known, key=lambda item: item[0])
        yield (
            f"Nearest to its tolerance of those that passed: {case}, {check.quantity}: {check.computed:.4g}, "
            f"allowed is {check.allowed} ({100 * share:.0f} % of it)."
        )


def _verdicts(verdicts: Sequence[Verdict]) -> WordTable:
    ordered = sorted(verdicts, key=lambda verdict: verdict.passed)
    rows = [
        (
            verdict.case,
            "passed" if verdict.passed else "FAILED",
            f"{max(map(_used, verdict.checks), default=math.nan):.2g}",
            f"{verdict.seconds:.2g}",
            verdict.claim,
        )
        for verdict in ordered
    ]
    return WordTable(
        title="Verdicts",
        columns=("case", "verdict", "tolerance used", "seconds", "claim"),
        rows=tuple(rows),
        left=frozenset({"case", "verdict", "claim"}),
        yielding=("claim", "seconds", "tolerance used"),
        note="Tolerance used: distance from the reference over the tolerance, of the check nearest to it. "
        "Tolerances come from estimates of the error; each stands beside its case in the source.",
    )


def _checks(verdicts: Sequence[Verdict]) -> WordTable:
    rows = [
        (
            verdict.case,
            check.quantity,
            f"{check.computed:.6g}",
            check.allowed,
            "" if check.passed else "FAILED",
        )
        for verdict in verdicts
        for check in verdict.checks
    ]
    return WordTable(
        title="Every check",
        columns=("case", "quantity", "computed", "allowed", "verdict"),
        rows=tuple(rows),
        left=frozenset({"case", "quantity", "allowed", "verdict"}),
    )


def _record(verdicts: Sequence[Verdict]) -> ResultTable:
    columns = ("case", "quantity", "computed", "reference", "tolerance", "passed", "seconds of the case")
    rows = [
        (v.case, c.quantity, c.computed, c.reference, c.tolerance, str(c.passed), v.seconds)
        for v in verdicts
        for c in v.checks
    ]
    return ResultTable.of(columns, rows)


def _figures(ladders: Sequence[tuple[str, Check]]) -> tuple[Drawing, ...]:
    """Draw error against resolution, each with the line of its observed order."""
    import xarray as xr

    words = {
        "case": "case",
        "quantity": "what converges",
        "resolution": "points along a side, or steps",
        "error": "error",
    }
    rows = [(case, check.quantity, n, error) for case, check in ladders for n, error in check.ladder]
    columns = zip(words.items(), zip(*rows, strict=True), strict=True)
    data = xr.Dataset(
        {name: ("point", list(values), {"units": "1", "long_name": said}) for (name, said), values in columns}
    )
    return (
        Drawing(
            name="error-against-resolution",
            figure=_converging(ladders),
            data=data,
            caption="Error against resolution of every case with an order of convergence. Symbols: what "
            "was computed; lines: the fitted power, whose exponent is the observed order in the legend "
            "beside what is expected.",
        ),
    )


def _converging(ladders: Sequence[tuple[str, Check]]) -> Figure:
    import numpy as np

    from validation.report.figure import COLOURS, STYLES, SYMBOLS, new_figure

    figure, (axes,) = new_figure(width=9.0, height=5.0)
    for k, (case, check) in enumerate(ladders):
        n, error = (np.array(values) for values in zip(*check.ladder, strict=True))
        middle = np.exp(np.mean(np.log(error)) + check.computed * np.mean(np.log(n)))
        colour = COLOURS[k % len(COLOURS)]
        order = with_error(check.reference, check.tolerance).replace("+-", r"$\pm$")
        label = f"{case}, {check.quantity}: {check.computed:.2f} (expected {order})"
        symbol: dict[str, Any] = {
            "marker": SYMBOLS[k % len(SYMBOLS)],
            "ms": 5,
            "mfc": "white" if k >= len(SYMBOLS) else colour,
        }
        axes.plot(n, error, color=colour, ls="", **symbol)
        axes.plot(n, middle * n**-check.computed, color=colour, ls=STYLES[k % 4], lw=1)
        axes.plot([], [], color=colour, ls=STYLES[k % 4], label=label, **symbol)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("points along a side, or steps")
    axes.set_ylabel("error")
    figure.legend(fontsize=7, loc="outside lower center", ncols=1)
    return figure
