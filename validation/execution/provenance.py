"""How a stored solve was made: by what versions, where, when, on how many threads."""

from __future__ import annotations

import platform
import socket
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime

from validation.registry import versions

#: Attribute of a dataset of many solves: how they were made, the lines of `made_words`.
SOLVES_MADE = "solves_made"


@dataclass(frozen=True, kw_only=True)
class Made:
    """How one solve was made: by which versions, on which computer, in what time [s], until when (UTC)."""

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
            versions=versions(),
            host=socket.gethostname(),
            machine=f"{platform.system()} {platform.machine()}",
            threads=threads,
            seconds=round(seconds, 6),
            finished=datetime.now(UTC).isoformat(timespec="seconds"),
        )


def made_words(made: Iterable[Made]) -> tuple[str, ...]:
    r"""Return sentences on how solves were made: when, where, on how many threads, by which versions.

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

    def counted(count: int, what: str) -> str:
        return f"{count} {what}{'' if count == 1 else 's'}"

    times = sorted(solve.finished[:16].replace("T", " ") for solve in solves)
    when = f"on {times[0]}" if times[0] == times[-1] else f"between {times[0]} and {times[-1]}"
    seconds = sum(solve.seconds for solve in solves)
    lines = [f"{counted(len(solves), 'solve')}, done {when} UTC, in {seconds:.3g} s."]
    for host, machine in dict.fromkeys((solve.host, solve.machine) for solve in solves):
        threads = Counter(solve.threads for solve in solves if (solve.host, solve.machine) == (host, machine))
        shares = ", ".join(f"{n} with {counted(k, 'thread')}" for k, n in sorted(threads.items()))
        lines.append(f"On {host} ({machine}): {shares}.")
    versions = Counter(", ".join(map(" ".join, solve.versions.items())) for solve in solves)
    for named, count in versions.items():
        lines.append(f"By {named}." if len(versions) == 1 else f"{counted(count, 'solve')} by {named}.")
    return tuple(lines)
