"""Theories of rough contact that simulations are scored against: a class each, found by name or entry point.

A theory is a subclass of `Theory` in a module of this package, or one that another package names by the
entry-point group ``fem_contact.theories``. A user's own functions need neither: ``my_module:area``.
"""

from collections.abc import Mapping
from functools import cache

from validation.errors import UsageError
from validation.registry import found_in
from validation.theories.base import Rough, Theory
from validation.theories.user_function import OwnTheory

__all__ = ["Rough", "Theory", "find_theory", "theories"]


@cache
def theories() -> Mapping[str, Theory]:
    """Return all theories by name: those of this package, then those of other packages."""
    kinds = found_in(__name__, Theory, group="fem_contact.theories")  # type: ignore[type-abstract]
    return {kind.name: kind() for kind in kinds if kind is not OwnTheory}


def find_theory(text: str) -> Theory:
    """Return a theory by name, or the user's own by ``module:function``, or ``module`` for all it has.

    A UsageError for a name that is neither.
    """
    if text in theories():
        return theories()[text]
    theory = OwnTheory.named(text)
    if theory is None:
        raise UsageError(
            f"theory {text!r}: neither a module here nor one of: {', '.join(theories())}; "
            "your own is named module:function, or module"
        )
    return theory
