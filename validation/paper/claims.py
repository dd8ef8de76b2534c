"""Claims of Persson (2006) with a number: what a claim is, and how those of a system are judged together.

The tolerance belongs to the claim and is written before anything is computed: 5 % for stated figures,
half of the last digit for derived ones, a factor where the paper says "of order". Where the paper leaves
a convention open, all claims of an application are judged under one and the same set of conventions: the
literal one, and the one under which most of them agree. That one is looked for, so agreement under it is
weaker evidence than agreement as printed. What the paper does not state at all and had to be chosen is
named in the row.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple


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


@dataclass(frozen=True, kw_only=True)
class Convention:
    """One joint set of conventions of an application: its name, and what its claims are computed with."""

    name: str
    value: Any


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A number in the paper."""

    text: str  # What is claimed, and where
    section: str
    stated: Stated
    value: Callable[[Any], float]  # Computes the number under a convention of the application
    fixed: bool = True  # Whether no convention enters
    choice: str = ""  # What the paper does not state and was chosen here; empty if nothing
    # Why the claim does not hold, should it not agree.
    failure: str = "the formulas and numbers of the paper do not give it"
    note: Callable[[], str] | None = None  # Further numbers to report beside it

    def agrees(self, value: float) -> bool:
        """Whether a number counts as the paper's."""
        return self.stated.low <= value <= self.stated.high


def claim(
    text: str,
    section: str,
    stated: Stated,
    *,
    fixed: Callable[[], float] | None = None,
    under: Callable[[Any], float] | None = None,
    **more: Any,
) -> Claim:
    """Write a claim down: what, where, the number, its tolerance, and how it is computed.

    `fixed` takes nothing, `under` the convention of its application; `more` are fields of `Claim`.
    """
    if (fixed is None) == (under is None):
        raise ValueError(f"{text}: must be computed with `fixed` or with `under`")
    value = under if fixed is None else lambda convention: fixed()
    assert value is not None
    return Claim(text=text, section=section, stated=stated, value=value, fixed=under is None, **more)


@dataclass(frozen=True, kw_only=True)
class Application:
    """What the paper computes for one system, and the conventions it leaves open, the literal one first."""

    name: str
    claims: tuple[Claim, ...]
    conventions: tuple[Convention, ...] = (Convention(name="", value=None),)


class Unjudged(NamedTuple):
    """A statement of the paper without a verdict, and the reason."""

    section: str
    statement: str
    reason: str


@dataclass(frozen=True, kw_only=True)
class ClaimRow:
    """A claim and what became of it."""

    claim: str  # What is claimed, of which system, and where
    application: str
    section: str
    stated: Stated
    computed: float  # Under the joint convention of the application, and under the literal one
    literal: float
    convention: str  # The joint convention; "as stated" where none enters
    verdict: str  # Whether it holds, why not or what was chosen, and what else there is to say
    reason: str
    note: str


def judge(application: Application, *, tell: Callable[[str], None] | None = None) -> tuple[ClaimRow, ...]:
    """Judge all claims of an application under one joint convention: the one under which most of them agree.

    Where several conventions serve equally well the first of them is taken, so that the literal one wins
    a tie.
    """
    values: list[list[float]] = []
    for one in application.claims:
        if tell is not None:
            tell(one.text)
        asked = application.conventions[:1] if one.fixed else application.conventions
        known = [float(one.value(convention.value)) for convention in asked]
        values.append(known * (len(application.conventions) if one.fixed else 1))
    scores = [
        sum(one.agrees(known[k]) for one, known in zip(application.claims, values, strict=True))
        for k in range(len(application.conventions))
    ]
    best = scores.index(max(scores))
    return tuple(
        _row(one, application, known, best) for one, known in zip(application.claims, values, strict=True)
    )


def _row(one: Claim, application: Application, known: list[float], best: int) -> ClaimRow:
    inferred = best > 0 and not one.fixed
    verdict, reason = "reproduced", one.choice
    if not one.agrees(known[best]):
        verdict, reason = "not reproduced", one.failure
    elif inferred:
        verdict = "reproduced under the joint convention"
    elif one.choice:
        verdict = "reproduced with a choice"
    agreement = ", which agrees, too" if one.agrees(known[0]) else ""
    notes = [f"literally {known[0]:.4g}{agreement}" if inferred else "", one.note() if one.note else ""]
    return ClaimRow(
        claim=one.text,
        application=application.name,
        section=one.section,
        stated=one.stated,
        computed=known[best],
        literal=known[0],
        convention=("" if one.fixed else application.conventions[best].name) or "as stated",
        verdict=verdict,
        reason=reason,
        note="; ".join(filter(None, notes)),
    )
