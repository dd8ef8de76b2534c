"""One page of HTML from a template of this package."""

from __future__ import annotations

import platform
from importlib import metadata
from typing import Any

__all__ = ["render", "versions"]


def versions() -> dict[str, str]:
    """Versions of everything that shapes a result."""
    names = ("fem-contact", "numpy", "scipy", "numba", "scikit-fem", "pyamg")
    return {"Python": platform.python_version(), **{name: metadata.version(name) for name in names}}


def render(template: str, **context: Any) -> str:
    """Fill in a template of this package; a name it needs and does not get is an error."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("validation.report"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(context)
