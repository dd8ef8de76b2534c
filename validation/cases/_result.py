"""What judging claims leaves: one dataset of verdicts, numbers, ladders and costs, and the views of it."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.arrays import padded
from validation.cases import TOLERANCES, Check, Verdict
from validation.execution.results import Outputs, Result, leave
from validation.report.estimates import derive, power_law
from validation.report.figure import COLOURS, SYMBOLS
from validation.report.findings import Finding, finding, note
from validation.report.marks import Figure, Line, against
from validation.report.page import Page, page_of
from validation.report.papers import cited
from validation.report.places import gather
from validation.report.quantities import labelled
from validation.report.table import Column, Table
from validation.report.values import with_places
from validation.report.views import Card, Views
from validation.report.words import json_ready

if TYPE_CHECKING:
    import xarray as xr

    from validation.cases.scorecard import Scorecard

#: Errors of the area that a digit is priced at.
ACCURACIES = (0.1, 0.01, 0.001)
_FINDINGS = 5


def claims_dataset(verdicts: Sequence[Verdict], cards: Sequence[Scorecard]) -> xr.Dataset:
    """Return verdicts over (claim, solver), numbers over `check`, orders over `ladder`, costs over `solver`.

    Claims stand in the order of the verdicts; `cards` have what is wrong with a solver, and its costs.
    """
    import xarray as xr

    of_claim = {verdict.row: verdict for verdict in reversed(verdicts)}
    scored = [verdict for verdict in verdicts if not verdict.left_out]
    checks = [(verdict, check) for verdict in scored for check in verdict.checks]
    parts = {
        (verdict.row, _solver(verdict)): xr.Dataset(
            {
                "verdict": verdict.word,
                "reason": verdict.error or verdict.left_out,
                "tolerance_used": verdict.used if verdict.checks else math.nan,
                "wall_seconds": verdict.seconds,
            }
        )
        for verdict in verdicts
    }
    data = gather(parts, "claim", "solver")
    first = [of_claim[claim] for claim in data.claim.values.tolist()]
    data = data.assign(
        statement=("claim", [verdict.claim for verdict in first]),
        tolerance_from=("claim", [verdict.tolerance for verdict in first]),
        claim_source=("claim", [verdict.source for verdict in first]),
        **_columns(checks),
        claims_judged=float(len(scored)),
        claims_failed=float(sum(not verdict.passed for verdict in scored)),
        checks_made=float(len(checks)),
    )
    names = _unique(f"{_solver(one)}, {one.row}: {check.quantity}" for one, check in checks)
    data = data.assign_coords(check=np.array(names, str))
    data = derive(data, check_used="abs(check_value - check_reference) / check_tolerance")
    return labelled(_with_costs(_with_ladders(data, checks), cards))


#: What claims that are asked of no solver in particular stand under.
_OTHER = "other"


def _solver(verdict: Verdict) -> str:
    return verdict.solver or _OTHER


def _columns(checks: Sequence[tuple[Verdict, Check]]) -> dict[str, Any]:
    """Return what stands of every check, words first, by the names of its columns."""
    words = [(v.case, _solver(v), c.quantity, "holds" if c.passed else "FAILS") for v, c in checks]
    numbers = [(c.computed, c.reference, c.tolerance) for _, c in checks]
    columns = (*np.array(words, str).reshape(-1, 4).T, *np.array(numbers, float).reshape(-1, 3).T)
    names = ("claim", "solver", "quantity", "verdict", "value", "reference", "tolerance")
    return {f"check_{name}": ("check", column) for name, column in zip(names, columns, strict=True)}


def _unique(names: Iterable[str]) -> list[str]:
    """Return names with a number where they come again, so that two results are paired by them."""
    count = Counter[str]()
    numbered = []
    for name in names:
        count[name] += 1
        numbered.append(name if count[name] == 1 else f"{name} ({count[name]})")
    return numbered


def _with_ladders(data: xr.Dataset, checks: Sequence[tuple[Verdict, Check]]) -> xr.Dataset:
    """Add errors against resolution, and the order that is read off them."""
    ladders = [(verdict, check) for verdict, check in checks if check.ladder]
    if not ladders:
        return data
    points, misses = (padded((step[k] for step in check.ladder) for _, check in ladders) for k in (0, 1))
    data = data.assign_coords(
        ladder=_unique(f"{verdict.case}: {check.quantity}" for verdict, check in ladders),
        ladder_claim=("ladder", [f"{verdict.row}: {check.quantity}" for verdict, check in ladders]),
        ladder_solver=("ladder", [_solver(verdict) for verdict, _ in ladders]),
    )
    data = data.assign(
        ladder_points=(("ladder", "level"), points),
        ladder_miss=(("ladder", "level"), np.abs(misses)),
        ladder_expected=("ladder", [check.reference for _, check in ladders]),
    )
    data = power_law(data, "ladder_power", of="ladder_miss", x="ladder_points", along=("level",))
    return derive(data, ladder_order="-ladder_power")


def _with_costs(data: xr.Dataset, cards: Sequence[Scorecard]) -> xr.Dataset:
    """Add what is wrong with each solver, and what each grid of one rough surface took."""
    if not cards:
        return data
    data = data.assign(diagnosis=("solver", [card.diagnosis for card in cards]))
    if not any(card.cost for card in cards):
        return data
    added: dict[str, Any] = {
        name: (("solver", "priced"), padded((getattr(row, name) for row in card.cost) for card in cards))
        for name in ("points", "area_miss", "seconds", "peak_bytes", "iterations")
    }
    for name, most in (("seconds_needed", "seconds"), ("bytes_needed", "peak_bytes")):
        # What a solver takes that is wrong is no cost of an answer.
        needed = [
            [math.nan if card.failed else card.needed(most, accuracy) for accuracy in ACCURACIES]
            for card in cards
        ]
        added[name] = (("solver", "area_accuracy"), needed)
    return data.assign_coords(area_accuracy=list(ACCURACIES)).assign(added)


def claims_views(data: xr.Dataset) -> Views:
    """Verdicts, every number, orders and costs; with a diagnosis, reasons in place of later tolerances."""
    solvers = range(data.sizes["solver"])
    has_diagnosis = "diagnosis" in data
    verdicts = Table(
        ("claim",),
        (
            "claim",
            *(Column("verdict", {"solver": k}) for k in solvers),
            *(Column("tolerance_used", {"solver": k}) for k in solvers if k == 0 or not has_diagnosis),
            *(Column("reason", {"solver": k}) for k in solvers if has_diagnosis),
            "tolerance_from",
            "statement",
        ),
        title="Verdicts",
        note="Tolerance used: distance from the reference over the tolerance, of the check that uses most. "
        + "; ".join(f"{name}: {words}" for name, words in TOLERANCES.items())
        + ".",
    )
    columns = ("claim", "solver", "quantity", "value", "reference", "tolerance", "used", "verdict")
    checked = tuple(f"check_{name}" for name in columns)
    numbers = Table(("check",), checked, title="Every number", file="numbers")
    costs = Table(
        ("solver", "area_accuracy"),
        ("solver", "area_accuracy", "seconds_needed", "bytes_needed"),
        title="What a digit costs",
        note="Of the cheapest grid whose area is that near to the limit, of one rough surface; of solvers "
        "that hold every claim. Memory: empty where it was not measured.",
        file="methods",
        sparse=True,
    )
    orders = Table(
        ("ladder",), ("ladder", "ladder_order", "ladder_expected"), title="Observed orders", file="areas"
    )
    return Views(
        table=verdicts,
        more=tuple(table for table in (numbers, costs, orders) if table.columns[-1] in data),
        figures=_ladder_figures(data) if "ladder" in data else [],
        findings=list(_findings(data)),
        cards=list(_cards(data)),
    )


def _ladder_figures(data: xr.Dataset) -> list[Figure]:
    """Draw what converges for each solver, three claims a figure; the others stand in the table."""
    looks = [
        ({"ladder_solver": solver}, {"color": color, "marker": marker})
        for solver, color, marker in zip(data.solver.values.tolist(), cycle(COLOURS), cycle(SYMBOLS))
    ]
    line, panels = Line("ladder_miss", by="ladder", label="{ladder_solver}"), []
    for claim in dict.fromkeys(data.ladder_claim.values[data.ladder_solver.values != _OTHER].tolist()):
        marks = [replace(line, where={"ladder_claim": claim, **of}, look=look) for of, look in looks]
        title = claim.replace(": observed order of", "\n")
        panels.append(against("ladder_points", *marks, log="xy", title=title))
    return [
        Figure(
            f"error-against-resolution-{k // 3 + 1}",
            "Error against points along a side; its slope is the observed order of convergence.",
            panels[k : k + 3],
        )
        for k in range(0, len(panels), 3)
    ]


def _cards(data: xr.Dataset) -> list[Card]:
    failed = float(data.claims_failed) > 0
    words = "no: {claims_failed} of {claims_judged} fail" if failed else "yes"
    basis = finding("value", "{claims_judged} claims with {checks_made} numbers", data)
    cards = [Card("Does everything hold?", finding("value", words, data), basis)]
    several = data.sizes["solver"] > 1
    for k in np.flatnonzero(data.diagnosis.values != "") if "diagnosis" in data else ():
        of = f" with {data.solver.values[k]}" if several else ""
        cards.append(Card(f"What is wrong{of}?", finding("value", "{diagnosis}", data.isel(solver=k))))
    first = data.isel(solver=0)
    if "seconds_needed" in data and bool(first.seconds_needed.notnull().any()):
        cost = first.sel(area_accuracy=0.01)
        words = "{seconds_needed:u}" if np.isfinite(cost.seconds_needed) else "not reached"
        of = "{solver}, " if several else "of "
        basis = finding("value", of + "one rough surface, lambda_long/lambda_short = 4", first)
        cards.append(Card("Processor time to 1 % of the area", finding("cost", words, cost), basis))
    return cards


def _findings(data: xr.Dataset) -> list[Finding]:
    """Say which numbers are missed, and which of those that hold is nearest to its tolerance."""
    of = "{solver}: " if "diagnosis" in data and data.sizes["solver"] > 1 else ""
    crashed = ((data.verdict == "FAILS") & (data.reason != "")).transpose("claim", "solver").values
    words = of + "{claim} could not be computed: {reason}."
    findings = [
        finding("refusal", words, data.isel(claim=int(i), solver=int(j))) for i, j in np.argwhere(crashed)
    ]
    number = "{check_quantity} is {check_value:~}, allowed is {check_reference:~} within {check_tolerance:~}"
    of_check = of.replace("{", "{check_")
    missed = np.flatnonzero(data.check_verdict.values == "FAILS")
    of_claim: dict[tuple[str, str], list[int]] = {}
    for k in missed[np.argsort(-np.nan_to_num(data.check_used.values[missed], nan=np.inf), kind="stable")]:
        of_claim.setdefault((data.check_solver.values[k], data.check_claim.values[k]), []).append(int(k))
    for places in of_claim.values():
        more = f" ({len(places)} numbers of it fail)" if len(places) > 1 else ""
        words = f"{of_check}{{check_claim}} FAILS: {number}{more}."
        findings.append(finding("value", words, data.isel(check=places[0])))
    if len(findings) > _FINDINGS + 1:
        rest = float(len(findings) - _FINDINGS)
        findings[_FINDINGS:] = [note("{count} more claims fail; the table has them.", count=rest)]
    if findings:
        return findings
    findings = [finding("value", "Every claim holds: {claims_judged} of them.", data)]
    # Ranges, in which any place is good, are not near to anything.
    wide = data.check_tolerance > 0.2 * abs(data.check_reference.where(data.check_reference != 0, np.inf))
    share = np.where(~wide.values, data.check_used.values, np.nan)
    if np.isfinite(share).any():
        words = f"Nearest to its tolerance: {of_check}{{check_claim}}: {number} ({{check_used:%}} of it)."
        findings.append(finding("value", words, data.isel(check=int(np.nanargmax(share)))))
    return findings


def claims_page(result: Result, *, figures: bool) -> Page:
    """Return the page of judged claims: all of it from the dataset and from what was asked."""
    sources = dict.fromkeys(map(str, result.data.claim_source.values))
    papers = [*result.settings.get("papers", ()), *filter(_is_paper, sources)]
    scored = result.settings.get("solvers")
    return page_of(
        result.data,
        claims_views(with_places(result.data)),
        figures=figures,
        title=f"Scorecard: {' beside '.join(scored)}" if scored else "Claims with a known answer",
        lead="Is what is known found: closed forms, limits, symmetries, orders of convergence?",
        settings={name: value for name, value in result.settings.items() if name != "papers"},
        seeds="fixed in each claim",
        papers=tuple(papers),
        summary={"kind": result.kind, "name": result.name},
    )


def _is_paper(source: str) -> bool:
    """Whether a claim rests on something published, and not on a symmetry or a definition.

    >>> _is_paper("Student, Biometrika (1908)"), _is_paper("symmetry")
    (True, False)
    """
    return re.search(r"\d{4}|Johnson|Timoshenko", source) is not None


def write_claims(
    folder: Path,
    verdicts: Sequence[Verdict],
    *,
    name: str,
    settings: Mapping[str, Any],
    cards: Sequence[Scorecard] = (),
    report: bool,
) -> Outputs:
    """Write dataset, record and page of verdicts into a folder; without `report` numbers alone."""
    data = claims_dataset(verdicts, cards)
    asked = {"kind": "claims", "name": name, "settings": json_ready(dict(settings))}
    return leave(folder, data, claims_page, report=report, store=folder, **asked)


def write_scorecards(folder: Path, cards: Sequence[Scorecard], *, report: bool = True) -> Outputs:
    """Write the results of scorecards into a folder, the first of them is what the page is about."""
    settings = {
        "solvers": [card.subject.name for card in cards],
        "settings": {card.subject.name: dict(card.subject.settings) for card in cards},
        "tolerance": cards[0].subject.tolerance,
        "quick": cards[0].subject.quick,
        "papers": list(dict.fromkeys(cited(paper) for card in cards for paper in card.subject.solver.papers)),
    }
    verdicts = [verdict for card in cards for verdict in card.verdicts]
    return write_claims(folder, verdicts, name="scorecard", settings=settings, cards=cards, report=report)
