"""How a stored solve was made: by what versions, where, when, on how many threads."""

from __future__ import annotations

import functools
import platform
import socket
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from importlib import metadata
from typing import Any

__all__ = ["SOLVES_MADE", "Made", "made_words"]

#: Attribute of a dataset of many solves: how they were made, the lines of `made_words`.
SOLVES_MADE = "solves_made"

#: Packages whose version may change a result.
_SHAPING = ("fem-contact", "numpy", "scipy", "numba", "ducc0", "scikit-fem")


@dataclass(frozen=True, kw_only=True)
class Made:
    """How one solve was made.

    Attributes
    ----------
    versions : mapping of str to str
        Of Python and of what shapes a result.
    host, machine : str
        Name of the computer, and its kind of processor and system.
    threads : int
    seconds : float
        Elapsed time of the solve [s].
    finished : str
        When it ended, UTC, as ISO 8601 has it.
    """

    versions: Mapping[str, str]
    host: str
    machine: str
    threads: int
    seconds: float
    finished: str

    @classmethod
    def now(cls, *, threads: int, seconds: float) -> Made:
        """Return how a solve was made that has just ended in this process."""
        return cls(
            versions=_versions(),
            host=socket.gethostname(),
            machine=f"{platform.system()} {platform.machine()}",
            threads=threads,
            seconds=round(seconds, 6),
            finished=datetime.now(UTC).isoformat(timespec="seconds"),
        )

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return asdict(self)


@functools.cache
def _versions() -> dict[str, str]:
    found = {"Python": platform.python_version()}
    for name in _SHAPING:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:  # a source tree that was not installed
            continue
    return found


def made_words(made: Iterable[Made]) -> tuple[str, ...]:
    r"""Return sentences on how solves were made: when, where, on how many threads, by which versions.

    Examples
    --------
    >>> one = Made(
    ...     versions={"Python": "3.11.7", "numpy": "2.1.0"}, host="a", machine="Linux x86_64",
    ...     threads=2, seconds=1.5, finished="2026-11-21T20:15:00+00:00",
    ... )
    >>> print(*made_words([one, one]), sep="\n")
    2 solves, done on 2026-11-21 20:15 UTC, in 3 s.
    On a (Linux x86_64): 2 with 2 threads.
    By Python 3.11.7, numpy 2.1.0.
    """
    solves = list(made)
    if not solves:
        return ()
    times = sorted(one.finished[:16].replace("T", " ") for one in solves)
    when = f"on {times[0]}" if times[0] == times[-1] else f"between {times[0]} and {times[-1]}"
    seconds = sum(one.seconds for one in solves)
    words = [f"{_solves(len(solves))}, done {when} UTC, in {seconds:.3g} s."]
    for (host, machine), own in _grouped(solves, lambda one: (one.host, one.machine)).items():
        threads = Counter(one.threads for one in own)
        shares = ", ".join(f"{n} with {_threads(k)}" for k, n in sorted(threads.items()))
        words.append(f"On {host} ({machine}): {shares}.")
    versions = _grouped(solves, lambda one: tuple(one.versions.items()))
    for found, own in versions.items():
        named = ", ".join(f"{name} {version}" for name, version in found)
        words.append(f"By {named}." if len(versions) == 1 else f"{_solves(len(own))} by {named}.")
    return tuple(words)


def _grouped(solves: Iterable[Made], key: Any) -> dict[Any, list[Made]]:
    groups: dict[Any, list[Made]] = {}
    for one in solves:
        groups.setdefault(key(one), []).append(one)
    return groups


def _solves(count: int) -> str:
    return "1 solve" if count == 1 else f"{count} solves"


def _threads(count: int) -> str:
    return "1 thread" if count == 1 else f"{count} threads"
