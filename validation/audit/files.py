"""Tables of a page, as they were typed."""

from __future__ import annotations

import html
import re

#: Symbols as a page sets them, and as they are typed.
_MARKS = {"±\u00a0": "+- ", "\u00a0%": " %", "\u2032": "'", "Δx": "dx", "Δγ": "Delta gamma"}
_MARKS |= {"κ": "kappa", "σ": "sigma", "γ": "gamma"}
_MARKS |= {"λ": "lambda", "ζ": "zeta", "α": "alpha", "μ": "mu", "ν": "nu"}
#: Fractions in exponents have brackets, A0 and p0 no underscore.
_SET = {r"<sup>([^<]*/[^<]*)": r"^(\1)", "<sup>": "^", r"<sub>(?=[^<\d])": "_", "(?<![Ap])<sub>": "_"}


def _plain(cell: str) -> str:
    """Return a cell of a page as it was typed."""
    for printed, typed in _SET.items():
        cell = re.sub(printed, typed, cell)
    text = html.unescape(re.sub(r"<[^>]+>", "", cell))
    for printed, typed in _MARKS.items():
        text = text.replace(printed, typed)
    return text.strip()


def page_tables(page: str) -> dict[str, tuple[list[str], list[list[str]]]]:
    """Return the tables of a page by their titles: names of the columns, and lines of cells."""
    found = {}
    for title, table in re.findall(
        r'aria-label="Table: ([^"]+)"><table[^>]*>(.*?)</table>', page, flags=re.S
    ):
        names = [_plain(cell) for cell in re.findall(r"<th[^>]*>(.*?)</th>", table, flags=re.S)]
        lines = re.findall(r"<tr[^>]*>((?:<td.*?)+)</tr>", table, flags=re.S)
        cells = [[_plain(c) for c in re.findall(r"<td[^>]*>(.*?)</td>", line, flags=re.S)] for line in lines]
        found[html.unescape(title)] = names, cells
    return found
