"""Rows of a scorecard: claims as functions of any solver."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

from validation.cases import Case, Check
from validation.cases.scorecard.subject import Subject

__all__ = ["Row", "row"]


@dataclass(frozen=True, kw_only=True)
class Row:
    """A claim, its source, what its tolerances come from, and what it asks of a solver."""

    name: str
    claim: str
    source: str
    tolerance: str
    checks: Callable[[Subject], Iterable[Check]]

    def __call__(self, subject: Subject) -> tuple[Check, ...]:
        """Return the checks of a solver."""
        return tuple(self.checks(subject))

    def of(self, subject: Subject) -> Case:
        """Return the claim as a case of a solver."""
        return Case(
            name=self.name,
            claim=self.claim,
            source=self.source,
            run=partial(self.checks, subject),
            solver=subject.name,
            tolerance=self.tolerance,
        )


def row(
    name: str, claim: str, *, source: str, tolerance: str
) -> Callable[[Callable[[Subject], Iterable[Check]]], Row]:
    """Make a `Row` of the function that follows."""
    return lambda checks: Row(name=name, claim=claim, source=source, tolerance=tolerance, checks=checks)
