"""Finding what has a file of its own: classes in the modules of a package, or given by entry points."""

from __future__ import annotations

import contextlib
import functools
import importlib
import inspect
import os
import pkgutil
import platform
import signal
import sys
import threading
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Any, TypeVar

from validation.errors import UsageError, say_once

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

    A UsageError for an entry point whose name is taken. One that cannot be loaded or is no such class is a
    line on stderr, and all else works.
    """
    kinds: dict[str, type[T]] = {}
    path = importlib.import_module(package).__path__
    for name in sorted(info.name for info in pkgutil.iter_modules(path)):
        module = importlib.import_module(f"{package}.{name}")
        for value in vars(module).values():
            inside = inspect.isclass(value) and value.__module__ == module.__name__
            if not inside or not issubclass(value, base) or value is base or inspect.isabstract(value):
                continue
            if hasattr(value, "kind_name") or hasattr(value, "name"):
                kinds[_name(value)] = value
    for where, _, value in entries(group):
        if not (inspect.isclass(value) and issubclass(value, base)):
            say_once(f"{where}: left out: must be a subclass of {base.__module__}.{base.__qualname__}")
            continue
        other = kinds.setdefault(_name(value), value)
        if other is not value:
            raise UsageError(
                f"{where}: the name {_name(value)!r} is that of {other.__module__}.{other.__qualname__}; "
                "uninstall one of the two packages, or have it renamed"
            )
    return tuple(kinds.values())


def entries(group: str) -> Iterator[tuple[str, str, Any]]:
    """Yield what other packages name in a group of entry points: where it stands, its name, the object.

    One that raises, exits or hangs while it is imported is left out with a line on stderr.
    """
    for entry in sorted(metadata.entry_points(group=group), key=lambda entry: entry.name):
        where = f"entry point {entry.name} = {entry.value} of {group}"
        try:
            with _nothing_on_stdout(), _within(_PATIENCE):
                value = entry.load()
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # whatever it raises, its name is what the user needs
            text = " ".join(str(error).split())[:200]
            say_once(f"{where}: left out, cannot be loaded: {type(error).__name__}: {text}")
            continue
        yield where, entry.name, value


#: How long another package may take to be imported [s].
_PATIENCE = 20.0


@contextlib.contextmanager
def _nothing_on_stdout() -> Iterator[None]:
    """Send to stderr what is printed, by libraries in C, too: it is no answer of a command."""
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError, ValueError, AttributeError):
            sys.stdout.flush()
            stdout = os.dup(1)
            stack.callback(os.close, stdout)
            stack.callback(os.dup2, stdout, 1)
            os.dup2(2, 1)
        with contextlib.redirect_stdout(sys.stderr):
            yield


@contextlib.contextmanager
def _within(seconds: float) -> Iterator[None]:
    """End what takes longer, in the main thread of a system with alarms, by an exception."""
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield
        return

    def late(*_: object) -> None:
        raise TimeoutError(f"still importing after {seconds:g} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, seconds, 1.0)  # again, where the package catches the first
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _name(kind: Any) -> str:
    return str(kind.kind_name() if hasattr(kind, "kind_name") else getattr(kind, "name", kind.__qualname__))


#: Packages whose version may change a result.
_SHAPING = ("fem-contact", "numpy", "scipy", "numba", "ducc0", "scikit-fem")


@functools.cache
def versions() -> dict[str, str]:
    """Versions of everything that shapes a result."""
    known = {"Python": platform.python_version()}
    for name in _SHAPING:
        with contextlib.suppress(metadata.PackageNotFoundError):  # a source tree that was not installed
            known[name] = metadata.version(name)
    return known
