"""Finding what has a file of its own: classes in the modules of a package, or given by entry points."""

from __future__ import annotations

import contextlib
import importlib
import inspect
import pkgutil
import sys
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Any, TypeVar

from validation.errors import UsageError

__all__ = ["entries", "found_in", "with_own_folder"]

T = TypeVar("T")


@contextlib.contextmanager
def with_own_folder() -> Iterator[str]:
    """Let modules in the folder of the command be found, after those that are installed; yield the folder."""
    here = str(Path.cwd())
    added = here not in sys.path
    if added:
        sys.path.append(here)
    try:
        yield here
    finally:
        if added:
            sys.path.remove(here)


def found_in(package: str, base: type[T], *, group: str) -> tuple[type[T], ...]:
    """Return the concrete subclasses of `base` in the modules of a package, then those of entry points.

    Raises
    ------
    UsageError
        For an entry point that cannot be loaded, is no such class, or has a name that is taken.
    """
    found: list[type[T]] = []
    path = importlib.import_module(package).__path__
    for name in sorted(info.name for info in pkgutil.iter_modules(path)):
        module = importlib.import_module(f"{package}.{name}")
        for value in vars(module).values():
            own = inspect.isclass(value) and value.__module__ == module.__name__
            if own and issubclass(value, base) and not inspect.isabstract(value) and value is not base:
                found.append(value)
    taken = {_name(kind): kind for kind in found}
    for where, _, value in entries(group):
        if not (inspect.isclass(value) and issubclass(value, base)):
            raise UsageError(f"{where}: must be a subclass of {base.__module__}.{base.__qualname__}")
        other = taken.setdefault(_name(value), value)
        if other is not value:
            raise UsageError(
                f"{where}: the name {_name(value)!r} is that of {other.__module__}.{other.__qualname__}; "
                "uninstall one of the two packages, or have it renamed"
            )
        found.append(value)
    return tuple(found)


def entries(group: str) -> Iterator[tuple[str, str, Any]]:
    """Yield what other packages name in a group of entry points: where it stands, its name, the object.

    Raises
    ------
    UsageError
        For one that cannot be loaded.
    """
    for entry in sorted(metadata.entry_points(group=group), key=lambda entry: entry.name):
        where = f"entry point {entry.name} = {entry.value} of {group}"
        try:
            with contextlib.redirect_stdout(sys.stderr):  # what it prints is no answer of a command
                value = entry.load()
        except (Exception, SystemExit) as error:  # whatever it raises, its name is what the user needs
            raise UsageError(f"{where}: cannot be loaded: {type(error).__name__}: {error}") from None
        yield where, entry.name, value


def _name(kind: Any) -> str:
    """Return by which name a class is listed."""
    return str(kind.kind_name() if hasattr(kind, "kind_name") else getattr(kind, "name", kind.__qualname__))
