"""A solver's scorecard: problems with known answers, hard ones, rough ones, and whether it keeps its word."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any, NamedTuple

from validation.cases import Case, Check, Verdict, run_cases
from validation.cases.scorecard import elementary, hard, known, ladder
from validation.cases.scorecard.diagnosis import diagnose
from validation.cases.scorecard.ladder import CostRow
from validation.cases.scorecard.subject import Subject
from validation.methods import chosen_solver

__all__ = ["Scorecard", "Subject", "own_cases", "rows", "score"]

_JOHNSON = "K. L. Johnson, J. A. Greenwood, J. G. Higginson, Int. J. Mech. Sci. 27, 383 (1985)"
_HERTZ = "H. Hertz, J. reine angew. Math. 92, 156 (1882); K. L. Johnson, Contact Mechanics, Sec. 4.2"
_WESTERGAARD = "H. M. Westergaard, J. Appl. Mech. 6, 49 (1939)"
_LAYER = "K. L. Johnson, Contact Mechanics, Sec. 5.8"
_LIMITS = "limits of boundary elements over grids and shifts"


class _Row(NamedTuple):
    """A claim as a function of any solver, its source, and what its tolerances come from."""

    name: str
    claim: str
    source: str
    tolerance: str
    checks: Callable[[Subject], Iterable[Check]]


_ROWS: tuple[_Row, ...] = (
    _Row("finite", "Every pressure is a finite number.", "definition", "rounding", elementary.finite),
    _Row(
        "repeatable", "The same question has the same answer.", "definition", "solver", elementary.repeatable
    ),
    _Row("tension", "No pressure is below zero.", "definition", "solver", elementary.tension),
    _Row(
        "place", "The pressure lies where the heights are.", "full contact, exact", "grid", elementary.place
    ),
    _Row("factor", "The stiffness is that of E*.", "full contact, exact", "grid", elementary.factor),
    _Row(
        "full-contact", "Each wave is pressed flat by E* q h / 2.", "exact", "grid", elementary.full_contact
    ),
    _Row("load", "The mean pressure is the one asked for.", "definition", "solver", elementary.load),
    _Row(
        "contact-set",
        "What is called contact carries load on a closed gap.",
        "definition",
        "solver",
        elementary.contact_set,
    ),
    _Row(
        "honesty",
        "Recomputed residuals are within the tolerance asked for.",
        "definition",
        "solver",
        elementary.honesty,
    ),
    _Row("cut-short", "A solve that ends early says so.", "definition", "rounding", hard.cut_short),
    _Row("hertz", "A paraboloid carries Hertz's pressure.", _HERTZ, "grid", known.hertz),
    _Row(
        "hertz-radius",
        "The counted radius converges to Hertz's in first order.",
        _HERTZ,
        "grid",
        known.hertz_radius,
    ),
    _Row(
        "stress-near-zero",
        "P(sigma) starts from zero, but for the grid.",
        _HERTZ,
        "grid",
        known.stress_near_zero,
    ),
    _Row("westergaard", "A wave carries Westergaard's pressure.", _WESTERGAARD, "grid", known.westergaard),
    _Row("layer", "On a bonded layer each wave is pressed flat by h / C(q).", _LAYER, "grid", known.layer),
    _Row(
        "yielding-wave",
        "Crests yield over the width that Westergaard's solution says.",
        f"{_WESTERGAARD}, mirrored",
        "grid",
        known.yielding,
    ),
    _Row("symmetry", "A mirrored surface has the mirrored pressure.", "symmetry", "solver", known.symmetry),
    _Row("units", "Units of length and pressure change nothing.", "symmetry", "solver", known.units),
    _Row(
        "against-bem",
        "Pressures approach those of boundary elements as the grid is refined.",
        "code verification: no shared contact algorithm",
        "grid",
        known.against_bem,
    ),
    _Row(
        "nested-grids", "Finer and finer grids approach one answer.", "self-consistency", "grid", known.nested
    ),
    _Row(
        "offset",
        "An offset leads to the pressures of the load that it belongs to.",
        "uniqueness of the elastic solution",
        "solver",
        hard.offset,
    ),
    _Row(
        "offset-near-full",
        "So it does near full contact.",
        "uniqueness of the elastic solution",
        "solver",
        hard.offset_near_full,
    ),
    _Row(
        "near-full",
        "Full contact just above and below the flattening load.",
        _JOHNSON,
        "grid",
        hard.near_full,
    ),
    _Row(
        "one-cell", "A load that one point carries is carried by one point.", "exact", "solver", hard.one_cell
    ),
    _Row("elongated", "Long periods and long cells change nothing.", _WESTERGAARD, "grid", hard.elongated),
    _Row("odd-axes", "Odd numbers of points are solved as well.", "definition", "solver", hard.odd_axes),
)

#: Our own solvers, whose scorecards are cases of `fem-contact validate`: method and settings.
_OWN: dict[str, tuple[str, dict[str, Any]]] = {
    "bem": ("bem", {}),
    "fem": ("fem", {"method": "full"}),
    "reduced": ("fem", {"method": "reduced"}),
}


@dataclass(frozen=True, kw_only=True)
class Scorecard:
    """How a solver did.

    Attributes
    ----------
    subject : Subject
    verdicts : tuple of Verdict
        Of all rows, the worst failure first; what was not judged says why.
    cost : tuple of CostRow
        Of one rough surface; empty where rough surfaces were not solved.
    diagnosis : str
        What is wrong, in words; empty where its answers do not tell.
    """

    subject: Subject
    verdicts: tuple[Verdict, ...]
    cost: tuple[CostRow, ...]
    diagnosis: str = ""

    @property
    def judged(self) -> tuple[Verdict, ...]:
        """Verdicts of rows that could be judged."""
        return tuple(verdict for verdict in self.verdicts if not verdict.left_out)

    @property
    def failed(self) -> tuple[Verdict, ...]:
        """Verdicts that did not pass."""
        return tuple(verdict for verdict in self.judged if not verdict.passed)

    @property
    def left_out(self) -> Mapping[str, str]:
        """Rows that were not judged, and why: not answered, not tried, or asking for what it is not given."""
        return {verdict.case: verdict.left_out for verdict in self.verdicts if verdict.left_out}

    @property
    def sentence(self) -> str:
        """What came out, in a line."""
        name, failed = self.subject.name, self.failed
        if not failed:
            return f"{name}: all {len(self.judged)} rows hold"
        count = "1 row fails" if len(failed) == 1 else f"{len(failed)} rows fail"
        why = f"; {self.diagnosis}" if self.diagnosis else ""
        return f"{name}: {count}: {', '.join(verdict.case for verdict in failed)}{why}"

    def verdict(self, row: str) -> Verdict:
        """Return the verdict of a row."""
        return next(verdict for verdict in self.verdicts if verdict.case == row)

    def needed(self, what: str, accuracy: float) -> float:
        """Return the least `seconds` or `peak_bytes` of a grid whose area is that near; NaN where none is."""
        near = [float(getattr(row, what)) for row in self.cost if row.area_miss <= accuracy]
        return min((value for value in near if not math.isnan(value)), default=math.nan)

    def summary(self) -> dict[str, Any]:
        """Everything as JSON-ready data."""
        return {
            "method": self.subject.name,
            "tolerance": self.subject.tolerance,
            "passed": not self.failed,
            "diagnosis": self.diagnosis,
            "rows": [verdict.summary() for verdict in self.judged],
            "left_out": dict(self.left_out),
            "cost": [asdict(row) for row in self.cost],
        }


def rows(subject: Subject) -> tuple[Case, ...]:
    """Return the rows of a scorecard as cases of a solver."""
    found = [
        Case(
            name=row.name,
            claim=row.claim,
            source=row.source,
            run=partial(row.checks, subject),
            solver=subject.name,
            tolerance=row.tolerance,
        )
        for row in _ROWS
    ]
    found += [
        Case(
            name=f"rough-{width}",
            claim=f"Areas, gap, stiffness, energy, low pressures: the limit's (lambda_l/lambda_s = {width}).",
            source=_LIMITS,
            run=partial(ladder.rough_surface, subject, width),
            solver=subject.name,
            tolerance="estimate",
        )
        for width in ladder.bandwidths(subject)
    ]
    return tuple(found)


def own_cases() -> tuple[Case, ...]:
    """Return the rows of the scorecards of our own solvers, named ``row-solver``."""
    found = []
    for name, (method, settings) in _OWN.items():
        subject = Subject(name=name, solver=chosen_solver(method)[0], settings=settings, own=True)
        own = (row for row in rows(subject) if row.name != f"against-{name}")
        found += [replace(row, name=f"{row.name}-{name}") for row in own]
    return tuple(found)


def score(subject: Subject, *, tell: Callable[[str], None] | None = None) -> Scorecard:
    """Run every row; one that raises has failed, and the others go on.

    Parameters
    ----------
    subject : Subject
    tell : callable, optional
        Given a line for every row.
    """
    subject.warm_up()
    verdicts = sorted(run_cases(rows(subject), tell=tell), key=_worst_first)
    wrong = any(verdict.word == "FAILS" for verdict in verdicts)
    return Scorecard(
        subject=subject,
        verdicts=tuple(verdicts),
        cost=_cost(subject, verdicts),
        diagnosis=diagnose(subject) if wrong else "",
    )


def _cost(subject: Subject, verdicts: Sequence[Verdict]) -> tuple[CostRow, ...]:
    """Price a digit where the surface that it is priced on was solved."""
    if any(v.case == f"rough-{ladder.PRICED}" and v.error is None and not v.left_out for v in verdicts):
        return ladder.cost(subject)
    return ()


def _worst_first(verdict: Verdict) -> tuple[bool, bool, float]:
    """Sort failures first, the larger before the smaller."""
    return bool(verdict.left_out), verdict.passed, -verdict.used
