"""A solver of the user's own: a Python function, named in the scene."""

from __future__ import annotations

import hashlib
import importlib.util
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.effects.base import Effect
from validation.errors import UsageError
from validation.registry import with_own_folder
from validation.solvers.base import Settings
from validation.solvers.external import ExternalOptions, ExternalSolver
from validation.units import key

if TYPE_CHECKING:
    from validation.scenes.problem import ContactProblem

_FUNCTION = r"^[A-Za-z_][\w.]*:[A-Za-z_][\w.]*$"


class OwnOptions(ExternalOptions):
    """Your own solver, ``solve(heights, lengths, *, contact_modulus, mean_pressure) -> pressures``."""

    solver: str = key(
        'a function as "module:name", e.g. "my_module:solve"', pattern=_FUNCTION, max_length=200
    )


class Own(ExternalSolver):
    """A function of heights [m], periods [m], E* [Pa] and p0 [Pa] that returns pressures [Pa]."""

    name = "own"
    label = "Own solver"
    options = OwnOptions

    def function(self, settings: Mapping[str, Any]) -> str:
        """Return the function that the scene names."""
        return str(settings["solver"])

    def settings(self, options: Any) -> Settings:
        """Return what was said, and what the code was when it was said."""
        return (*super().settings(options), *self.named(options.solver))

    def named(self, function: str) -> Settings:
        """Return function and digest of its code, so that a changed solver is solved with anew."""
        return ("solver", function), ("code", _digest(function))

    def check(self, options: OwnOptions, problem: ContactProblem, effects: Sequence[Effect]) -> None:
        """Refuse a module that is not found."""
        super().check(options, problem, effects)
        _ = _digest(options.solver)


def _digest(function: str) -> str:
    """Return a digest of the module of a function; in a package, of all modules of the package.

    A UsageError where there is no such module.
    """
    package = function.partition(":")[0].partition(".")[0]
    with with_own_folder() as here:
        try:
            spec = importlib.util.find_spec(package)
        except (ImportError, ValueError):
            spec = None
    if spec is None:
        raise UsageError(
            f"methods.own.solver = {function!r}: no module {package!r} is installed or lies in {here!r}"
        )
    files = [Path(spec.origin or "")]
    if (places := spec.submodule_search_locations) is not None:
        files = sorted(path for place in places for path in Path(place).rglob("*.py"))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files if file.is_file())).hexdigest()[:16]
