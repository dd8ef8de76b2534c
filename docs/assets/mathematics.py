"""Docstrings for the site: equations as MathML, which browsers draw without a script; imports as code."""

from __future__ import annotations

import re
import textwrap
from typing import Any

import griffe
from latex2mathml.converter import convert

#: A directive `.. math::` with what follows on its line, and lines that are indented or empty after it.
_EQUATION = re.compile(r"^( *)\.\. math::(.*\n(?:(?:\1 +.*)?(?:\n|\Z))*)", re.MULTILINE)


#: A line of a session; a module shows by one how it is imported, outside of any section.
_SESSION = re.compile(r"^>>> (.*)$", re.MULTILINE)


class Mathematics(griffe.Extension):
    """Writes each equation of a docstring as a block of HTML."""

    def on_instance(self, *, obj: griffe.Object, **_: Any) -> None:
        """Rewrite the docstring of a module, class or function."""
        if obj.docstring is not None:
            text = _EQUATION.sub(_drawn, obj.docstring.value + "\n").rstrip()
            obj.docstring.value = _SESSION.sub(r"    \1", text) if obj.is_module else text


def _drawn(found: re.Match[str]) -> str:
    first, _, rest = found[2].partition("\n")
    source = " ".join(f"{first} {textwrap.dedent(rest)}".split())
    return f"{found[1]}<div>{convert(source, display='block')}</div>\n\n"
