"""Claims of Persson (2006) with a number: what a claim is, and how those of a system are judged together.

The tolerance belongs to the claim and is written before anything is computed: 5 % for stated figures,
half of the last digit for derived ones, a factor where the paper says "of order". Where the paper leaves
a convention open, all claims of an application are judged under one and the same set of conventions: the
literal one, and the one under which most of them agree. That one is looked for, so agreement under it is
weaker evidence than agreement as printed. What the paper does not state at all and had to be chosen is
named in the row.
"""

from __future__ import annotations

import inspect
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import resources
from typing import Any, NamedTuple

import numpy as np

#: What `Stated` holds, as columns.
STATED = ("stated", "stated_low", "stated_high", "stated_basis")


class Stated(NamedTuple):
    """A number that the paper states, the range that counts as the same, and on what grounds."""

    value: float
    low: float
    high: float
    basis: str


def percent(stated: float, share: float = 5.0) -> Stated:
    """Return a number with the range within so many per cent of it.

    >>> percent(2.0, 10)
    Stated(value=2.0, low=1.8, high=2.2, basis='10 %')
    """
    return Stated(stated, stated * (1 - share / 100), stated * (1 + share / 100), f"{share:g} %")


def _stated(row: dict[str, Any]) -> Stated:
    """Take the number out of a row of claims.toml, with its range."""
    value, take = row.pop("stated"), row.pop
    if "digit" in row:
        half = take("digit") / 2
        return Stated(value, value - half, value + half, "half of the last digit")
    if "percent" in row:
        return percent(value, take("percent"))
    if "factor" in row:
        size = take("factor")
        return Stated(value, value / size, value * size, f"a factor {size:g}, for '{take('words')}'")
    return Stated(value, take("low"), take("high"), take("basis"))


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A number in the paper."""

    text: str  # What is claimed, and where
    section: str
    stated: Stated
    value: Callable[..., Any]  # Computes the number; where not `fixed`, under a convention
    fixed: bool = False  # Whether no convention enters
    choice: str = ""  # What the paper does not state and was chosen here; empty if nothing
    # Why the claim does not hold, should it not agree.
    failure: str = "the formulas and numbers of the paper do not give it"
    note: str | Callable[[], str] = ""  # Further numbers to report beside it

    def agrees(self, value: float) -> bool:
        """Whether a number counts as the paper's."""
        return self.stated.low <= value <= self.stated.high


@dataclass(frozen=True, kw_only=True)
class Application:
    """What the paper computes for one system."""

    name: str
    claims: tuple[Claim, ...]
    #: The joint sets of conventions it leaves open by name, the literal one first, as claims are told them.
    conventions: Mapping[str, Any] = field(default_factory=lambda: {"": None})


def written() -> dict[str, dict[str, Any]]:
    """Return the claims of each system as they were written down, and what has no verdict."""
    return tomllib.loads(resources.files(__package__).joinpath("claims.toml").read_text(encoding="utf-8"))


def application(
    name: str,
    *,
    values: Mapping[str, Callable[..., Any]],
    more: Mapping[str, Mapping[str, Any]] | None = None,
    **conventions: Mapping[str, Any],
) -> Application:
    """Join the claims of a system with how they are computed, by their keys in claims.toml.

    Those of the `values` that depend on a convention take it; `more` are fields of `Claim` that are computed.
    """
    rows, claims = written()[name], []
    if values.keys() != rows.keys():
        raise ValueError(f"{name}: {', '.join(values.keys() ^ rows.keys())}: written or computed alone")
    for key, row in rows.items():
        computed = dict((more or {}).get(key, {}))
        stated = computed.pop("stated", None) or _stated(row)
        fixed = not inspect.signature(values[key]).parameters
        claims.append(Claim(stated=stated, value=values[key], fixed=fixed, **row, **computed))
    return Application(name=name, claims=tuple(claims), **conventions)


def judge(application: Application, *, tell: Callable[[str], None] | None = None) -> list[dict[str, Any]]:
    """Judge all claims of an application under one joint convention: the one under which most of them agree.

    Returns rows of the dataset, by the names of its columns.

    Where several conventions serve equally well the first of them is taken, so that the literal one wins
    a tie.
    """
    conventions, claims = application.conventions, application.claims
    values = []
    for claim in claims:
        if tell is not None:
            tell(claim.text)
        told = [()] if claim.fixed else [(convention,) for convention in conventions.values()]
        values.append([float(claim.value(*each)) for each in told] * (len(conventions) // len(told)))
    agree = [[claim.agrees(value) for value in known] for claim, known in zip(claims, values, strict=True)]
    best = int(np.argmax(np.sum(agree, axis=0)))
    rows: list[dict[str, Any]] = []
    for claim, known in zip(claims, values, strict=True):
        inferred = best > 0 and not claim.fixed
        verdict, reason = "reproduced", claim.choice
        if not claim.agrees(known[best]):
            verdict, reason = "not reproduced", claim.failure
        elif inferred:
            verdict = "reproduced under the joint convention"
        elif claim.choice:
            verdict = "reproduced with a choice"
        agreement = ", which agrees, too" if claim.agrees(known[0]) else ""
        literally = f"literally {known[0]:.4g}{agreement}" if inferred else ""
        note = claim.note() if callable(claim.note) else claim.note
        row = {
            "claim": f"{application.name}: {claim.text}",
            "paper_section": claim.section,
            "paper_convention": ("" if claim.fixed else [*conventions][best]) or "as stated",
            "paper_verdict": verdict,
            "paper_reason": reason,
            "paper_note": "; ".join(filter(None, (literally, note))),
            "computed": known[best],
            "literal": known[0],
        }
        rows.append(row | dict(zip(STATED, claim.stated, strict=True)))
    return rows
