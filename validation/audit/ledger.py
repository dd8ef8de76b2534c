"""What was found in the files of a run, beside what its fields say."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Entry:
    """One number or word of a run."""

    place: str  # File or part of it, and what stands there
    name: str
    found: Any  # As it stands, and as the fields say
    recomputed: Any
    agrees: bool

    def __str__(self) -> str:
        verdict = "agrees" if self.agrees else "DISAGREES"
        return f"{self.place}: {self.name}: found {self.found}, recomputed {self.recomputed}: {verdict}"


@dataclass(kw_only=True)
class Ledger:
    """Entries, and what could not be judged."""

    entries: list[Entry] = field(default_factory=list)
    #: What stands in the run and is not recomputed, with the reason.
    unread: list[str] = field(default_factory=list)

    @property
    def wrong(self) -> tuple[Entry, ...]:
        """Entries that disagree."""
        return tuple(entry for entry in self.entries if not entry.agrees)

    def number(
        self, place: str, name: str, found: Any, expected: Any, *, rtol: float = 1e-9, atol: float = 1e-13
    ) -> None:
        """Enter a number, or of an array the element furthest off; a missing one is as wrong as can be."""
        a, b = (v if isinstance(v, np.ndarray) else np.asarray(as_number(v)) for v in (found, expected))
        a, b = a.astype(float), b.astype(float)
        if a.shape != b.shape:
            self.same(place, f"shape of {name}", a.shape, b.shape)
        elif a.size:
            with np.errstate(invalid="ignore", divide="ignore"):
                off = np.nan_to_num(np.abs(a - b) / (atol + rtol * np.abs(b)), nan=np.inf)
            off = np.where((a == b) | (np.isnan(a) & np.isnan(b)), 0.0, off)
            k = np.unravel_index(int(np.argmax(off)), a.shape) if a.ndim else ()
            at = f" at {tuple(map(int, k))}" if a.ndim else ""
            self.entries.append(Entry(place, name + at, float(a[k]), float(b[k]), bool(off[k] <= 1)))

    def same(self, place: str, name: str, found: Any, expected: Any) -> None:
        """Enter what must be equal."""
        self.entries.append(Entry(place, name, found, expected, found == expected))

    def exact(self, place: str, name: str, found: Any, expected: Any) -> None:
        """Enter a word that must be equal, or a number that may differ by rounding."""
        if isinstance(expected, str):
            self.same(place, name, found, expected)
        else:
            self.number(place, name, found, expected, rtol=1e-12, atol=0.0)

    def text(
        self, place: str, name: str, found: str, expected: float | None, digits: int | None = None
    ) -> None:
        """Enter a number as it is printed: to half a unit of its last digit, or of that significant one."""
        self.entries.append(Entry(place, name, found, expected, printed(found, expected, digits=digits)))


def as_number(value: Any) -> float:
    """Return a number as it is or as it is typed; NaN for words, and for nothing."""
    try:
        return float(value)
    except (TypeError, ValueError):
        return math.nan


def printed(text: str, value: float | None, *, digits: int | None = None) -> bool:
    """Whether a printed number is the value, rounded.

    >>> printed("27 %", 0.2651), printed("0.1", 0.1003, digits=4), printed("1.0e-08", 1.04e-8)
    (True, False, True)
    >>> printed("0 %", 0.0), printed("0 %", 0.004), printed("inf", math.inf), printed("inf", 1e99)
    (True, False, True, False)
    """
    exact = as_number(value)
    if not math.isfinite(exact):
        return text in ("", "not determinable", "unknown", f"{exact}")
    scale = 0.01 if text.endswith("%") else 1.0
    try:
        number = Decimal(text.removesuffix("%").strip().replace(",", ""))
        unit = scale * 10.0 ** int(number.as_tuple().exponent)
    except (ArithmeticError, ValueError):
        return False
    if number == 0 and scale < 1 and "." not in text:
        unit = 1e-9  # percentages have two significant digits: 0 % is nothing
    if digits is not None and exact != 0:
        unit = 10.0 ** (math.floor(math.log10(abs(exact))) - digits + 1) * scale
    return abs(float(number) * scale - exact) <= 0.5 * unit * (1 + 1e-6) + 1e-14 * abs(exact)
