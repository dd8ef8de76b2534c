"""Equations of the site as MathML, which browsers draw without a script; imports in docstrings as code."""

from __future__ import annotations

import re
import textwrap
from typing import Any

import griffe
from latex2mathml.converter import convert

#: A directive `.. math::` with what follows on its line, and lines that are indented or empty after it.
_DIRECTIVE = re.compile(r"^( *)\.\. math::(.*\n(?:(?:\1 +.*)?(?:\n|\Z))*)", re.MULTILINE)

#: A line of a session; a module shows by one how it is imported, outside of any section.
_SESSION = re.compile(r"^>>> (.*)$", re.MULTILINE)

#: Code, which is left alone; or an equation on lines of its own, or within one.
_EQUATION = re.compile(r"```.*?```|`[^`\n]*`|\$\$(.+?)\$\$|\$([^$\n]+)\$", re.DOTALL)


class Mathematics(griffe.Extension):
    """Writes each equation of a docstring as a block of HTML."""

    def on_instance(self, *, obj: griffe.Object, **_: Any) -> None:
        """Rewrite the docstring of a module, class or function."""
        if obj.docstring is not None:
            text = _DIRECTIVE.sub(_block, obj.docstring.value + "\n").rstrip()
            obj.docstring.value = _SESSION.sub(r"    \1", text) if obj.is_module else text


def _block(match: re.Match[str]) -> str:
    first, _, rest = match[2].partition("\n")
    source = " ".join(f"{first} {textwrap.dedent(rest)}".split())
    return f"{match[1]}<div>{convert(source, display='block')}</div>\n\n"


def _mathml(match: re.Match[str]) -> str:
    if match[1]:
        return f"<div>{convert(' '.join(match[1].split()), display='block')}</div>"
    # A line that begins with an element of MathML would be taken for a block.
    return f"<span>{convert(match[2])}</span>" if match[2] else match[0]


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Write the equations of a page, between dollars, as MathML."""
    return _EQUATION.sub(_mathml, markdown)
