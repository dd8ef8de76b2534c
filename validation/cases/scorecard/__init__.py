"""A solver's scorecard: problems with known answers, hard ones, rough ones, and whether it keeps its word."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

from validation.cases import Case, Check, Verdict, run_cases
from validation.cases.scorecard import control, effects, elementary, hard, known, ladder
from validation.cases.scorecard.ladder import CostRow
from validation.cases.scorecard.subject import Inconclusive, NotTried, Subject, Unanswered

__all__ = ["FAULTS", "Scorecard", "Subject", "rows", "score"]

#: Row, claim and function.
_ROWS: tuple[tuple[str, str, Callable[[Subject], Sequence[Check]]], ...] = (
    ("tension", "No pressure is below zero.", elementary.tension),
    ("place", "The pressure lies where the heights are.", elementary.place),
    ("factor", "The stiffness is that of E*.", elementary.factor),
    ("full-contact", "Each wave is pressed flat by E* q h / 2.", elementary.full_contact),
    ("load", "The mean pressure is the one asked for.", elementary.load),
    ("contact-set", "What is called contact carries load on a closed gap.", elementary.contact_set),
    ("honesty", "Recomputed residuals are within the tolerance asked for.", elementary.honesty),
    ("cut-short", "A solve that ends early says so.", control.cut_short),
    ("hertz", "A paraboloid carries Hertz's pressure.", known.hertz),
    ("hertz-radius", "The counted radius converges to Hertz's in first order.", known.hertz_radius),
    ("stress-near-zero", "P(sigma) starts from zero, but for the grid.", known.stress_near_zero),
    ("westergaard", "A wave carries Westergaard's pressure.", known.westergaard),
    ("layer", "On a bonded layer each wave is pressed flat by h / C(q).", effects.layer),
    ("yielding-wave", "Crests yield over the width that Westergaard's solution says.", effects.yielding),
    ("symmetry", "A mirrored surface has the mirrored pressure.", known.symmetry),
    ("units", "Units of length and pressure change nothing.", known.units),
    ("nested-grids", "Finer and finer grids approach one answer.", known.nested),
    ("offset", "An offset leads to the pressures of the load that it belongs to.", control.offset),
    ("offset-near-full", "So it does near full contact.", control.offset_near_full),
    ("near-full", "Full contact just above and below the flattening load.", hard.near_full),
    ("one-cell", "A load that one point carries is carried by one point.", hard.one_cell),
    ("elongated", "Long periods and long cells change nothing.", hard.elongated),
    ("odd-axes", "Odd numbers of points are solved as well.", hard.odd_axes),
)

#: Rows that name a fault, in the order in which they are believed: each is read as if those before held.
FAULTS: tuple[tuple[str, str], ...] = (
    ("tension", "pressures below zero are allowed"),
    ("place", "the pressure lies beside the heights"),
    ("factor", "the stiffness has a wrong factor"),
    ("load", "the load is not the one asked for"),
    ("contact-set", "points are called contact that carry no load"),
    ("honesty", "the iteration ends before its tolerance is met"),
)


@dataclass(frozen=True, kw_only=True)
class Scorecard:
    """How a solver did.

    Attributes
    ----------
    subject : Subject
    verdicts : tuple of Verdict
        The worst failure first.
    cost : tuple of CostRow
        Of one rough surface; empty where rough surfaces were not solved.
    left_out : mapping of str to str
        Rows that were not judged, and why: not answered, not tried, or asking for what the solver is not
        given.
    """

    subject: Subject
    verdicts: tuple[Verdict, ...]
    cost: tuple[CostRow, ...]
    left_out: Mapping[str, str]

    @property
    def failed(self) -> tuple[Verdict, ...]:
        """Verdicts that did not pass."""
        return tuple(verdict for verdict in self.verdicts if not verdict.passed)

    @property
    def fault(self) -> tuple[str, str] | None:
        """The row that names what is wrong, and the words; None where none does."""
        known_by = {verdict.case for verdict in self.failed if verdict.error is None}
        return next((fault for fault in FAULTS if fault[0] in known_by), None)

    @property
    def sentence(self) -> str:
        """What came out, in a line."""
        name, failed = self.subject.name, self.failed
        if not failed:
            return f"{name}: all {len(self.verdicts)} rows hold"
        fault = "" if self.fault is None else f"; {self.fault[1]}"
        count = "1 row fails" if len(failed) == 1 else f"{len(failed)} rows fail"
        return f"{name}: {count}: {', '.join(verdict.case for verdict in failed)}{fault}"

    def verdict(self, row: str) -> Verdict | None:
        """Return the verdict of a row; None where it does not apply."""
        return next((verdict for verdict in self.verdicts if verdict.case == row), None)

    def seconds_to(self, error: float) -> float:
        """Return processor seconds of the cheapest grid whose area is that near; NaN where none is."""
        near = [row.seconds for row in self.cost if row.error <= error and not math.isnan(row.seconds)]
        return min(near, default=math.nan)

    def bytes_to(self, error: float) -> float:
        """Return the memory of the smallest grid whose area is that near; NaN where none is."""
        return min((row.peak_bytes for row in self.cost if row.error <= error), default=math.nan)

    def summary(self) -> dict[str, Any]:
        """Everything as JSON-ready data."""
        fault = self.fault
        return {
            "method": self.subject.name,
            "tolerance": self.subject.tolerance,
            "passed": not self.failed,
            "fault": None if fault is None else {"row": fault[0], "words": fault[1]},
            "rows": [{**verdict.summary(), "over_tolerance": excess(verdict)} for verdict in self.verdicts],
            "left_out": dict(self.left_out),
            "cost": [asdict(row) for row in self.cost],
        }


def excess(verdict: Verdict) -> float:
    """Return the largest difference over its tolerance; infinite where nothing could be computed."""
    if verdict.error is not None or not verdict.checks:
        return math.inf
    return max(_excess(check) for check in verdict.checks)


def _excess(check: Check) -> float:
    difference = abs(check.computed - check.reference)
    if not math.isfinite(difference):
        return math.inf
    if check.tolerance == 0:
        return 0.0 if difference == 0 else math.inf
    return difference / check.tolerance


def _refused(subject: Subject, name: str) -> str | None:
    """Say what a row asks for that a solver cannot be given; None where it can."""
    effect, told = effects.NEEDED.get(name), control.NEEDED.get(name)
    if effect is not None and not subject.solver.handles(effect):
        return f"{subject.solver.label} cannot be given the effect {effect.kind_name()!r}"
    if told is not None and told not in subject.controlled:
        return f"{subject.solver.label} cannot be told {told!r}"
    return None


def rows(subject: Subject) -> tuple[Case, ...]:
    """Return the rows that apply to a solver."""
    found = [
        Case(name=name, claim=claim, run=partial(function, subject))
        for name, claim, function in _ROWS
        if _refused(subject, name) is None
    ]
    found += [
        Case(
            name=f"rough-{width}",
            claim=f"Areas, gap, stiffness, energy, low pressures: the limit's (lambda_l/lambda_s = {width}).",
            run=partial(ladder.rough_surface, subject, width),
        )
        for width in ladder.bandwidths(subject)
    ]
    return tuple(found)


def score(subject: Subject, *, tell: Callable[[str], None] | None = None) -> Scorecard:
    """Run every row that applies; one that raises has failed, and the others go on.

    Parameters
    ----------
    subject : Subject
    tell : callable, optional
        Given a line for every row.
    """
    subject.warm_up()
    refused = {row[0]: _refused(subject, row[0]) for row in _ROWS}
    left_out = {name: why for name, why in refused.items() if why is not None}
    found = []
    for verdict in run_cases(rows(subject)):
        why = _why_not(verdict)
        if why is None:
            found.append(verdict)
        else:
            left_out[verdict.case] = why
        if tell is not None:
            word = "passed" if verdict.passed else "FAILED" if why is None else why.partition(":")[0]
            tell(f"{word}  {verdict.case}  ({verdict.seconds:.1f} s)")
    verdicts = sorted(found, key=_worst_first)
    return Scorecard(
        subject=subject, verdicts=tuple(verdicts), cost=_cost(subject, verdicts), left_out=left_out
    )


def _why_not(verdict: Verdict) -> str | None:
    """Say why a row was not judged; None where it was."""
    for kind, words in ((Unanswered, "not answered"), (NotTried, "not tried")):
        if (verdict.error or "").startswith(f"{kind.__name__}: "):
            return f"{words}: {str(verdict.error).removeprefix(f'{kind.__name__}: ')}"
    return None


def _cost(subject: Subject, verdicts: Sequence[Verdict]) -> tuple[CostRow, ...]:
    """Price a digit where the surface that it is priced on was solved."""
    if any(verdict.case == f"rough-{ladder.PRICED}" and verdict.error is None for verdict in verdicts):
        return ladder.cost(subject)
    return ()


def _worst_first(verdict: Verdict) -> tuple[bool, bool, float]:
    """Sort failures first, the larger before the smaller; what another failure hides, after them."""
    hidden = (verdict.error or "").startswith(Inconclusive.__name__)
    return verdict.passed, hidden, -excess(verdict)
