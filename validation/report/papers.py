"""The one list of papers: a text that has "[hertz1882]" in it cites that one."""

from __future__ import annotations

import re
import tomllib
from importlib import resources

_LISTED = tomllib.loads(resources.files(__package__).joinpath("papers.toml").read_text(encoding="utf-8"))
PAPERS: dict[str, str] = _LISTED["papers"]

#: What to cite by the name of what is used: a paper itself, or one of methods and effects of ours.
CITED_FOR: dict[str, str] = {key: f"[{key}]." for key in PAPERS} | _LISTED["cited_for"]


def cited(text: str) -> str:
    """Return a text with each key in brackets written out.

    >>> cited("Cells under constant pressure: [love1929].")
    'Cells under constant pressure: A. E. H. Love, Phil. Trans. R. Soc. A 228, 377 (1929).'
    """
    return re.sub(r"\[(\w+)\]", lambda key: PAPERS.get(key[1], key[0]), text)
