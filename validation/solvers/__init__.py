"""The ways to answer a scene: solvers and theory, one file each, found by name or entry point."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from functools import cache

from validation.errors import UsageError
from validation.registry import found_in
from validation.solvers.base import Method, Solver

__all__ = ["Method", "Solver", "chosen_solver", "find_method", "find_solver", "methods"]


@cache
def methods() -> Mapping[str, Method]:
    """Return all methods by name: those of this package, then those of other packages.

    Another package adds one by an entry point of the group ``fem_contact.methods``. The first solver that a
    scene lists is the one its limit is taken from and the others are compared with; so those written
    elsewhere stand last.
    """
    kinds = found_in(__name__, Method, group="fem_contact.methods")  # type: ignore[type-abstract]
    for kind in kinds:
        if issubclass(kind, Solver) and "job" not in inspect.signature(kind.solve).parameters:
            raise UsageError(
                f"method {kind.name!r} of {kind.__module__}: its `solve` takes one `job` now, and its "
                "`cost` one `size` (validation.solvers.base); see ARCHITECTURE.md"
            )
    # Ours first.
    return {kind.name: kind() for kind in sorted(kinds, key=lambda kind: getattr(kind, "foreign", False))}


def find_method(name: str) -> Method:
    """Return one method; a UsageError for an unknown name."""
    if name not in methods():
        raise UsageError(f"method {name!r}: no such method; one of: {', '.join(methods())}")
    return methods()[name]


def chosen_solver(text: str) -> tuple[Solver, dict[str, float | str]]:
    """Return a solver by name, or the user's own by ``module:function``, and what it is told.

    A UsageError for one that is unknown, presses no surface, or is not installed.
    """
    from validation.solvers.user_function import Own

    if ":" in text:
        return (own := Own()), dict(own.named(text))
    solver = find_solver(text)
    if isinstance(solver, Own):
        raise UsageError(f"method {text!r}: say which function: module:name")
    missing = solver.available()
    if missing is not None:
        raise UsageError(f"method {text!r}: {missing}")
    return solver, {}


def find_solver(name: str) -> Solver:
    """Return one method that solves; a UsageError for an unknown name, or one that presses no surface."""
    method = find_method(name)
    if not isinstance(method, Solver):
        raise UsageError(f"method {name!r}: presses no surface")
    return method
