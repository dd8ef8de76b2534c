"""The comparison of theory and simulation: the only package that knows both.

What a notebook calls is best had by ``import fem_contact as fc``: fc.press, fc.self_affine, fc.study ...
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fem_contact._environment import settle
from validation import _renamed

if TYPE_CHECKING:
    from validation.notebook import Contact, Surface, measured, press, self_affine, study, table, theory

#: By which `fem_contact` tells it from another package of this name.
belongs_to_fem_contact = True

__all__ = ["Contact", "Surface", "measured", "press", "self_affine", "study", "table", "theory"]

settle()
_renamed.install()


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("fem-contact")
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    # Not before it is asked for: the command line needs none of it.
    from validation import notebook

    value: object = getattr(notebook, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "__version__"} - {"TYPE_CHECKING", "annotations"})
