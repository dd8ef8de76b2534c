"""Claims of Persson (2006) with a number: what a claim is, and how those of a system are judged together.

The tolerance belongs to the claim and is written before anything is computed: 5 % for stated figures,
half of the last digit for derived ones, a factor where the paper says "of order". Where the paper leaves
a convention open, all claims of an application are judged under one and the same set of conventions: the
literal one, and the one under which most of them agree. That one is looked for, so agreement under it is
weaker evidence than agreement as printed. What the paper does not state at all and had to be chosen is
named in the row.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

__all__ = [
    "Application",
    "Claim",
    "ClaimRow",
    "Convention",
    "Stated",
    "Unjudged",
    "claim",
    "digit",
    "factor",
    "judge",
    "percent",
]


@dataclass(frozen=True, kw_only=True)
class Convention:
    """One joint set of conventions of an application.

    Attributes
    ----------
    name : str
        In words.
    value : object
        What the claims of the application are computed with.
    """

    name: str
    value: Any


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
    value : callable
        Computes the number under a convention of the application.
    fixed : bool
        Whether no convention enters.
    choice : str
        What the paper does not state and was chosen here; empty if nothing.
    failure : str
        Why the claim does not hold, should it not agree.
    note : callable, optional
        Further numbers to report beside it.
    """

    text: str
    section: str
    stated: float
    low: float
    high: float
    basis: str
    value: Callable[[Any], float]
    fixed: bool = True
    choice: str = ""
    failure: str = "the formulas and numbers of the paper do not give it"
    note: Callable[[], str] | None = None

    def agrees(self, value: float) -> bool:
        """Whether a number counts as the paper's."""
        return self.low <= value <= self.high


@dataclass(frozen=True, kw_only=True)
class Application:
    """What the paper computes for one system, and the conventions it leaves open, the literal one first."""

    name: str
    claims: tuple[Claim, ...]
    conventions: tuple[Convention, ...] = (Convention(name="", value=None),)


@dataclass(frozen=True, kw_only=True)
class ClaimRow:
    """A claim and what became of it.

    Attributes
    ----------
    claim, application, section : str
        What is claimed, of which system, and where.
    stated : float
        The paper's number.
    tolerance : str
        Range that counts as the same number, and why.
    computed : float
        Under the joint convention of the application.
    literal : float
        Under the literal one.
    convention : str
        The joint convention; "as stated" where none enters.
    verdict, note : str
        Whether it holds, and what else there is to say.
    """

    claim: str
    application: str
    section: str
    stated: float
    tolerance: str
    computed: float
    literal: float
    convention: str
    verdict: str
    note: str


@dataclass(frozen=True, kw_only=True)
class Unjudged:
    """A statement of the paper without a verdict, and the reason."""

    section: str
    statement: str
    reason: str


def judge(application: Application, *, tell: Callable[[str], None] | None = None) -> tuple[ClaimRow, ...]:
    """Judge all claims of an application under one joint convention: the one under which most of them agree.

    Where several conventions serve equally well the first of them is taken, so that the literal one wins
    a tie.
    """
    first = application.conventions[0]
    values: dict[tuple[int, int], float] = {}
    for number, one in enumerate(application.claims):
        (tell or (lambda text: None))(one.text)
        for index, convention in enumerate(application.conventions):
            known = one.fixed and index > 0
            values[number, index] = values[number, 0] if known else float(one.value(convention.value))
    scores = [
        sum(one.agrees(values[number, index]) for number, one in enumerate(application.claims))
        for index in range(len(application.conventions))
    ]
    best = scores.index(max(scores))
    joint = application.conventions[best]
    return tuple(
        _row(
            one,
            application.name,
            computed=values[number, best],
            literal=values[number, 0],
            convention="" if one.fixed else joint.name,
            inferred=joint is not first and not one.fixed,
        )
        for number, one in enumerate(application.claims)
    )


def _row(
    one: Claim, application: str, *, computed: float, literal: float, convention: str, inferred: bool
) -> ClaimRow:
    if not one.agrees(computed):
        verdict = f"not reproduced because {one.failure}"
    elif inferred:
        verdict = "reproduced under the joint convention" + (
            f", with a choice: {one.choice}" if one.choice else ""
        )
    elif one.choice:
        verdict = f"reproduced with a choice: {one.choice}"
    else:
        verdict = "reproduced"
    agreement = ", which agrees, too" if one.agrees(literal) else ""
    extra = f"literally {literal:.4g}{agreement}" if inferred else ""
    notes = [extra, one.note() if one.note else ""]
    return ClaimRow(
        claim=one.text,
        application=application,
        section=one.section,
        stated=one.stated,
        tolerance=f"{one.low:.4g} ... {one.high:.4g} ({one.basis})",
        computed=computed,
        literal=literal,
        convention=convention or "as stated",
        verdict=verdict,
        note="; ".join(text for text in notes if text),
    )


class Stated(NamedTuple):
    """A number that the paper states, the range that counts as the same, and on what grounds."""

    value: float
    low: float
    high: float
    basis: str


def digit(stated: float, last: float) -> Stated:
    """Return a number with the range of those that round to it."""
    return Stated(stated, stated - last / 2, stated + last / 2, "half of the last digit")


def percent(stated: float, share: float = 5.0) -> Stated:
    """Return a number with the range within so many per cent of it."""
    return Stated(stated, stated * (1 - share / 100), stated * (1 + share / 100), f"{share:g} %")


def factor(stated: float, size: float, *, words: str) -> Stated:
    """Return a number with the range within a factor of it, for what the paper says in `words`."""
    return Stated(stated, stated / size, stated * size, f"a factor {size:g}, for '{words}'")


def claim(
    text: str,
    section: str,
    stated: Stated,
    *,
    fixed: Callable[[], float] | None = None,
    under: Callable[[Any], float] | None = None,
    choice: str = "",
    failure: str = Claim.failure,
    note: Callable[[], str] | None = None,
) -> Claim:
    """Write a claim down: what, where, the number, its tolerance, and how it is computed.

    `fixed` takes nothing, `under` the convention of its application.
    """
    if (fixed is None) == (under is None):
        raise ValueError(f"{text}: must be computed with `fixed` or with `under`")
    return Claim(
        text=text,
        section=section,
        stated=stated.value,
        low=stated.low,
        high=stated.high,
        basis=stated.basis,
        value=under if under is not None else (lambda convention: fixed() if fixed else math.nan),
        fixed=under is None,
        choice=choice,
        failure=failure,
        note=note,
    )
