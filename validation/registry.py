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
from typing import TypeVar

from validation.errors import UsageError

__all__ = ["found_in", "with_own_folder"]

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
        For an entry point that cannot be loaded or is no such class.
    """
    found: list[type[T]] = []
    path = importlib.import_module(package).__path__
    for name in sorted(info.name for info in pkgutil.iter_modules(path)):
        module = importlib.import_module(f"{package}.{name}")
        for value in vars(module).values():
            own = inspect.isclass(value) and value.__module__ == module.__name__
            if own and issubclass(value, base) and not inspect.isabstract(value) and value is not base:
                found.append(value)
    for entry in sorted(metadata.entry_points(group=group), key=lambda entry: entry.name):
        where = f"entry point {entry.name} = {entry.value} of {group}"
        try:
            value = entry.load()
        except Exception as error:  # whatever another package raises, its name is what the user needs
            raise UsageError(f"{where}: cannot be loaded: {type(error).__name__}: {error}") from None
        if not (inspect.isclass(value) and issubclass(value, base)):
            raise UsageError(f"{where}: must be a subclass of {base.__module__}.{base.__qualname__}")
        found.append(value)
    return tuple(found)
