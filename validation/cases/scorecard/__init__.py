"""A solver's scorecard: problems with known answers, hard ones, rough ones, and whether it keeps its word."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

from validation.cases import Case, Verdict, cases_of, run_cases
from validation.cases.scorecard import elementary, hard, known, ladder
from validation.cases.scorecard.diagnosis import diagnose
from validation.cases.scorecard.ladder import CostRow
from validation.cases.scorecard.subject import Subject
from validation.solvers import chosen_solver

__all__ = ["Scorecard", "Subject", "own_cases", "rows", "score"]

_LIMITS = "limits of boundary elements over grids and shifts"

#: In the order in which they are asked.
_ROWS = tuple(row for module in (elementary, known, hard) for row in cases_of(vars(module)))

#: Our own solvers, whose scorecards are cases of `fem-contact validate`: method and settings.
_OWN: dict[str, tuple[str, dict[str, Any]]] = {
    "bem": ("bem", {}),
    "fem": ("fem", {"method": "full"}),
    "reduced": ("fem", {"method": "reduced"}),
}


@dataclass(frozen=True, kw_only=True)
class Scorecard:
    """How a solver did."""

    subject: Subject
    verdicts: tuple[Verdict, ...]  # Of all rows, the worst failure first; what was not judged says why
    cost: tuple[CostRow, ...]  # Of one rough surface; empty where rough surfaces were not solved
    diagnosis: str = ""  # What is wrong, in words; empty where its answers do not tell

    @property
    def counted(self) -> tuple[Verdict, ...]:
        """Verdicts of rows that could be judged."""
        return tuple(verdict for verdict in self.verdicts if not verdict.left_out)

    @property
    def failed(self) -> tuple[Verdict, ...]:
        """Verdicts that did not pass."""
        return tuple(verdict for verdict in self.verdicts if verdict.word == "FAILS")

    @property
    def left_out(self) -> Mapping[str, str]:
        """Rows that were not judged, and why: not answered, not tried, or asking for what it is not given."""
        return {verdict.case: verdict.left_out for verdict in self.verdicts if verdict.left_out}

    @property
    def sentence(self) -> str:
        """What came out, in a line."""
        name, failed = self.subject.name, self.failed
        if not failed:
            return f"{name}: all {len(self.counted)} rows hold"
        count = "1 row fails" if len(failed) == 1 else f"{len(failed)} rows fail"
        why = f"; {self.diagnosis}" if self.diagnosis else ""
        return f"{name}: {count}: {', '.join(verdict.case for verdict in failed)}{why}"

    def needed(self, what: str, accuracy: float) -> float:
        """Return the least `seconds` or `peak_bytes` of a grid whose area is that near; NaN where none is."""
        near = [float(getattr(row, what)) for row in self.cost if row.area_miss <= accuracy]
        return min((value for value in near if value > 0), default=math.nan)

    def summary(self) -> dict[str, Any]:
        """Everything as JSON-ready data."""
        return {
            "method": self.subject.name,
            "tolerance": self.subject.tolerance,
            "passed": not self.failed,
            "diagnosis": self.diagnosis,
            "rows": [verdict.summary() for verdict in self.counted],
            "left_out": dict(self.left_out),
            "cost": [asdict(row) for row in self.cost],
        }


def rows(subject: Subject) -> tuple[Case, ...]:
    """Return the rows of a scorecard as cases of a solver."""
    wide = (
        Case(
            name=f"rough-{width}",
            claim=f"Areas, gap, stiffness, energy, low pressures: the limit's (lambda_l/lambda_s = {width}).",
            source=_LIMITS,
            tolerance="estimate",
            run=partial(ladder.rough_surface, width=width),
        )
        for width in ladder.bandwidths(subject)
    )
    return tuple(replace(row, run=partial(row.run, subject), solver=subject.name) for row in (*_ROWS, *wide))


def own_cases() -> tuple[Case, ...]:
    """Return the rows of the scorecards of our own solvers, named ``row-solver``."""
    cases = []
    for name, (method, settings) in _OWN.items():
        subject = Subject(name=name, solver=chosen_solver(method)[0], settings=settings, built_in=True)
        cases += [
            replace(row, name=f"{row.name}-{name}") for row in rows(subject) if row.name != f"against-{name}"
        ]
    return tuple(cases)


def score(subject: Subject, *, tell: Callable[[str], None] | None = None) -> Scorecard:
    """Run every row and `tell` its line; one that raises has failed, and the others go on."""
    subject.warm_up()
    verdicts = sorted(
        run_cases(rows(subject), tell=tell),
        key=lambda verdict: (bool(verdict.left_out), verdict.passed, -verdict.used),
    )
    priced = any(v.case == f"rough-{ladder.PRICED}" and not (v.error or v.left_out) for v in verdicts)
    cost = ladder.cost(subject) if priced else ()
    card = Scorecard(subject=subject, verdicts=tuple(verdicts), cost=cost)
    return replace(card, diagnosis=diagnose(subject)) if card.failed else card
