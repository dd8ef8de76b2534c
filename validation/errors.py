"""The exceptions of :mod:`validation`; a user's mistake is one line with key, value and what is allowed."""

from __future__ import annotations

import contextlib
import difflib
import functools
import sys
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from typing import Any


def harmless(text: object) -> str:
    r"""Return a text with every character as its code that would change a terminal, or how a line reads.

    Names of files and what is written in them are nobody's promise. Ends of lines stay.

    >>> harmless("a\x1b[31m\u202eb\nc")
    'a\\x1b[31m\\u202eb\nc'
    """
    plain = str(text)
    if plain.replace("\n", "").isprintable():
        return plain
    # Spaces of any width (Zs) do not count as printable, but harm nobody.
    return "".join(
        c if c == "\n" or c.isprintable() or unicodedata.category(c) == "Zs" else ascii(c)[1:-1]
        for c in plain
    )


def did_you_mean(word: str, known: Iterable[str], meant: Mapping[str, str] | None = None) -> str:
    """Return a hint at the known word nearest to one, or at what that one is meant by; empty for none.

    >>> did_you_mean("yung", ["young", "poisson"])
    "; did you mean 'young'?"
    """
    # Without the hyphens of options, which are alike in all of them.
    words = {name.lstrip("-"): name for name in (*known, *(meant or ()))}
    close = [words[name] for name in difflib.get_close_matches(word.lstrip("-"), words, n=1)]
    return f"; did you mean {(meant or {}).get(close[0], close[0])!r}?" if close else ""


@functools.cache
def say_once(words: str) -> None:
    """Write a line on stderr, the first time that it is said."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        sys.stderr.write(f"fem-contact: {harmless(words)}\n")


class UsageError(Exception):
    """A request that nothing was computed for; the command line prints its lines and exits with 2."""


class SceneError(UsageError):
    """A scene that cannot be run: its file or name (`source`), and one line for each of its problems.

    Each line says key, value and what is allowed.
    """

    def __init__(self, source: str, problems: Sequence[str]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(f"{source}: {problem}" for problem in problems))


class RunFailed(Exception):
    """A run that ended early; what was finished is stored and the next run continues after it."""


class SolvesFailed(RunFailed):
    """Solves that failed, each with why, while the others were done."""

    def __init__(self, words: str, failures: Mapping[Any, str]) -> None:
        self.failures = failures
        super().__init__(words)


class NoLimit(RunFailed):
    """A contact whose area has no limit over the grids it was pressed on; finer ones may have."""
