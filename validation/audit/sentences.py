"""Numbers with their error, as sentences print them."""

from __future__ import annotations

import re

from validation.audit.ledger import Ledger

__all__ = ["with_error"]

_PLACE = "sentence"
_N = r"[-+]?[\d.]+(?:e[-+]?\d+)?"


def with_error(ledger: Ledger, name: str, text: str, pair: tuple[float, float]) -> None:
    """Enter a number with its error, printed with as many decimals."""
    inner = re.fullmatch(rf"\(?({_N}) \+- ({_N}|unknown)\)?(e[-+]\d+)?", text)
    if inner is None:
        ledger.same(_PLACE, name, text, f"{pair[0]} +- {pair[1]}")
        return
    power = inner[3] or ""
    ledger.text(_PLACE, name, inner[1] + power, pair[0])
    ledger.text(_PLACE, f"error of {name}", inner[2] + power, pair[1], digits=None if pair[1] == 0 else 2)
