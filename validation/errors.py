"""The exceptions of :mod:`validation`; a user's mistake is one line with key, value and what is allowed."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["RunFailed", "SceneError", "UsageError"]


class UsageError(Exception):
    """A request that nothing was computed for; the command line prints its lines and exits with 2."""


class SceneError(UsageError):
    """A scene that cannot be run.

    Parameters
    ----------
    source : str
        File or name of the scene.
    problems : sequence of str
        One line each: key, value, what is allowed.
    """

    def __init__(self, source: str, problems: Sequence[str]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(f"{source}: {problem}" for problem in problems))


class RunFailed(Exception):
    """A run that ended early; what was finished is stored and the next run continues after it."""
