"""Sentences, tables and budgets of studies, beside what they should say."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from validation.audit.ledger import Ledger
from validation.audit.sentences import with_error
from validation.audit.studies.kept import Kept, rows_of
from validation.audit.studies.numbers import root_sum

__all__ = ["SOURCES", "budget", "modes", "said", "table"]

Cell = float | str

_FIELD = re.compile(r"\{(\w+)(?::(\d+))?\}")
_NUMBER = r"[-+]?[\d.]+(?:e[-+]?\d+)?(?: %)?|[-+]?nan|not determinable"
_ERROR = r"[-+\d.e]+ \+- (?:[\d.e-]+|unknown)|\([^()]*\)e[-+]\d+|not determinable"

#: Sources of uncertainty in the order of the columns of a budget.
SOURCES = ("grid", "solver", "surfaces", "finite size", "bandwidth", "depth")


def said(kept: Kept, template: str, **values: float | str | tuple[float, float]) -> None:
    """Judge the sentence of a form: ``{name}`` stands for a number, a word, or a number with its error.

    A figure behind the name, ``{name:3}``, is the number of significant digits that are printed. A sentence of
    that form must be there.
    """
    named: dict[str, tuple[str, int | None]] = {}

    def group(match: re.Match[str]) -> str:
        key = f"f{len(named)}"
        named[key] = match[1], None if match[2] is None else int(match[2])
        value = values[match[1]]
        form = ".+?" if isinstance(value, str) else _ERROR if isinstance(value, tuple) else _NUMBER
        return f"(?P<{key}>{form})"

    parts = _FIELD.split(template)
    pattern = "".join(
        re.escape(part) if k % 3 == 0 else group(_FIELD.fullmatch(_field(parts, k)) or _never())
        for k, part in enumerate(parts)
        if k % 3 != 2
    )
    for sentence in kept.unsaid:
        found = re.fullmatch(pattern, sentence)
        if found is not None:
            kept.unsaid.remove(sentence)
            for key, (name, digits) in named.items():
                _judge(kept.ledger, f"{name}, {_start(sentence)}", found[key], values[name], digits)
            return
    kept.ledger.same("sentence", f"a sentence of the form {_start(template)}", False, True)


def _field(parts: Sequence[str], k: int) -> str:
    return f"{{{parts[k]}}}" if parts[k + 1] is None else f"{{{parts[k]}:{parts[k + 1]}}}"


def _never() -> re.Match[str]:
    raise AssertionError("a field is a field")


def _start(text: str) -> str:
    return text if len(text) < 60 else f"{text[:57]}..."


def _judge(
    ledger: Ledger, name: str, found: str, value: float | str | tuple[float, float], digits: int | None
) -> None:
    if isinstance(value, str):
        ledger.same("sentence", name, found, value)
    elif isinstance(value, tuple):
        if math.isfinite(value[0]):
            with_error(ledger, name, found, value)
        else:
            ledger.same("sentence", name, found, "not determinable")
    else:
        ledger.text("sentence", name, found, value, digits)


def table(kept: Kept, columns: Sequence[str], rows: Sequence[Sequence[Cell]], **how: float) -> None:
    """Judge table.csv: its titles, its words, and each number, to `rtol` (1e-9 unless said)."""
    _grid(kept, "table.csv", columns, rows, how)


def _grid(
    kept: Kept, place: str, columns: Sequence[str], rows: Sequence[Sequence[Cell]], how: Mapping[str, float]
) -> None:
    ledger = kept.ledger
    header, *lines = rows_of(kept.folder / place) or [[]]
    ledger.same(place, "columns", header, list(columns))
    ledger.same(place, "number of rows", len(lines), len(rows))
    for k, (line, row) in enumerate(zip(lines, rows, strict=False)):
        for title, found, exact in zip(columns, line, row, strict=False):
            name = f"{title}, row {k + 1}"
            if isinstance(exact, str) or not _is_number(found):
                ledger.same(place, name, found, exact)
            else:
                ledger.number(place, name, found, exact, **how)


def _is_number(text: str) -> bool:
    try:
        float(text or "nan")
    except ValueError:
        return False
    return True


def budget(kept: Kept, rows: Sequence[tuple[str, float, Mapping[str, float]]]) -> None:
    """Judge budget.csv: (quantity, value, relative half widths by source) of each row, and their sums."""
    columns = ("number", "value", *(f"{name} [%]" for name in SOURCES))
    sums = ("for this spectrum and period [%]", "for any [%]")
    expected = []
    for quantity, value, shares in rows:
        own = root_sum(*(share for name, share in shares.items() if name not in ("finite size", "bandwidth")))
        cells = [_per_cent(shares[name]) if name in shares else "does not enter" for name in SOURCES]
        total = root_sum(*shares.values())
        expected.append((quantity, value, *cells, _per_cent(own), _per_cent(total)))
    _grid(kept, "budget.csv", (*columns, *sums), expected, {"rtol": 1e-8, "atol": 1e-11})


def _per_cent(share: float) -> Cell:
    return 100 * abs(share) if np.isfinite(share) else "not determinable"


def modes(kept: Kept, conditional: Any, ensemble: Any) -> None:
    """Judge the sentence on what the theory says from C(q) alone, beside that told the realised gradient."""
    change = 100 * (np.asarray(ensemble, dtype=float) / np.asarray(conditional, dtype=float) - 1)
    spread = "{low} to {high} % (mean {mean} %)" if change.size > 1 else "{low} %"
    said(
        kept,
        "Told C(q) alone (ensemble) instead of the realised gradient (conditional), the theory predicts areas "
        f"that differ by {spread}: the sum over the waves of a finite period against the integral, which is "
        "what a wrong generator would also change.",
        low=float(change.min()),
        high=float(change.max()),
        mean=float(change.mean()),
    )
