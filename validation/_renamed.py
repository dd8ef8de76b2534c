"""Modules that had other names: from now on an import of one says in a line what it is called."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from types import ModuleType

_NEW = {
    "validation.methods": "validation.solvers",
    "validation.solves": "validation.execution",
    "validation.measures": "validation.measurements",
    "validation.bounded": "validation.sandbox",
    "validation.execution.running": "validation.execution.bench",
    "validation.scenes.realised": "validation.scenes.problem",
    "validation.theories.own": "validation.theories.user_function",
}


class _Renamed(MetaPathFinder):
    """Asked last, when no module of the name was found."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> None:
        """Refuse an old name with the new one."""
        if name in _NEW:
            raise ModuleNotFoundError(f"{name} is called {_NEW[name]}", name=name)


sys.meta_path.append(_Renamed())
