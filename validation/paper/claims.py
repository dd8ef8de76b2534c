"""Claims of Persson (2006) with a number: what a claim is, how it is judged.

The tolerance belongs to the claim and is written before anything is computed: 5 % for stated figures, half
of the last digit for derived ones, a factor where the paper says "of order". The first reading of every
claim is the literal one; others are inferred conventions, named in the row. Nothing is fitted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

__all__ = ["Claim", "ClaimRow", "Reading", "claim", "digit", "judge", "literal", "percent"]


@dataclass(frozen=True, kw_only=True)
class Reading:
    """One way to read a claim.

    Attributes
    ----------
    convention : str
        In words; empty for the literal reading.
    value : float
        What it gives.
    """

    convention: str
    value: float


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A number in the paper.

    Attributes
    ----------
    text, section : str
        What is claimed, and where.
    stated : float
        The paper's number.
    low, high : float
        Range within which a computed number counts as the same, and why.
    basis : str
        Where the range comes from.
    readings : callable
        Yields readings, the literal one first; evaluation stops at the first that agrees.
    failure : str
        Why the claim does not hold, should no reading agree.
    note : callable, optional
        Further numbers to report beside it.
    """

    text: str
    section: str
    stated: float
    low: float
    high: float
    basis: str
    readings: Callable[[], Iterator[Reading]]
    failure: str = "no reading of the text gives the number"
    note: Callable[[], str] | None = None


@dataclass(frozen=True, kw_only=True)
class ClaimRow:
    """A claim and what became of it."""

    claim: str
    section: str
    stated: float
    tolerance: str
    computed: float
    convention: str
    verdict: str
    note: str


def judge(claim: Claim) -> ClaimRow:
    """Evaluate a claim: literal reading first, inferred ones after, and say which agreed."""
    first: Reading | None = None
    for reading in claim.readings():
        first = first or reading
        if claim.low <= reading.value <= claim.high:
            exact = reading is first
            verdict = (
                "reproduced" if exact else f"reproduced with the inferred convention: {reading.convention}"
            )
            named = "nothing" if math.isnan(first.value) else f"{first.value:.4g}"
            extra = "" if exact else f"literally {named} ({first.convention or 'as stated'})"
            return _row(claim, reading, verdict, extra)
    if first is None:
        raise ValueError(f"{claim.text}: no reading")
    return _row(claim, first, f"not reproduced because {claim.failure}", "")


def _row(claim: Claim, reading: Reading, verdict: str, extra: str) -> ClaimRow:
    notes = [extra, claim.note() if claim.note else ""]
    return ClaimRow(
        claim=claim.text,
        section=claim.section,
        stated=claim.stated,
        tolerance=f"{claim.low:.4g} ... {claim.high:.4g} ({claim.basis})",
        computed=reading.value,
        convention=reading.convention or "as stated",
        verdict=verdict,
        note="; ".join(text for text in notes if text),
    )


def digit(stated: float, last: float) -> tuple[float, float, str]:
    """Range of numbers that round to the stated one."""
    return stated - last / 2, stated + last / 2, "half of the last digit"


def percent(stated: float, share: float = 5.0) -> tuple[float, float, str]:
    """Range of numbers within so many per cent of the stated one."""
    return stated * (1 - share / 100), stated * (1 + share / 100), f"{share:g} %"


def claim(
    text: str,
    section: str,
    stated: float,
    *,
    within: tuple[float, float, str],
    readings: Callable[[], Iterator[Reading]],
    failure: str = "no reading of the text gives the number",
    note: Callable[[], str] | None = None,
) -> Claim:
    """Write a claim down: what, where, the number, its tolerance, its readings."""
    low, high, basis = within
    return Claim(
        text=text,
        section=section,
        stated=stated,
        low=low,
        high=high,
        basis=basis,
        readings=readings,
        failure=failure,
        note=note,
    )


def literal(function: Callable[[], float]) -> Callable[[], Iterator[Reading]]:
    """Wrap the value of a claim that can be read in one way only."""

    def readings() -> Iterator[Reading]:
        yield Reading(convention="", value=float(function()))

    return readings
