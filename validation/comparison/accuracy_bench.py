"""A bench that keeps account of what solves take, and refuses what would not end in time."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from dataclasses import dataclass, field

from validation.errors import RunFailed
from validation.execution.attempt import warm_up
from validation.execution.bench import Bench
from validation.execution.cost import available_memory, memory_words, transform_seconds
from validation.execution.running import Solves
from validation.execution.solve import Solve

#: Seconds, taken and predicted, beside which those of a kind of solves tell little [s].
_LITTLE = (0.1, 0.1)


@dataclass(kw_only=True)
class Account:
    """What was spent so far: seconds, solves `found` finished and `done`; what is `reserved` for the last.

    By the kind of solves, `alike` has the seconds that these took, and those that were predicted.
    """

    solving: float = 0.0
    predicted: float = 0.0
    found: set[Solve] = field(default_factory=set)
    done: set[Solve] = field(default_factory=set)
    reserved: float = 0.0
    alike: dict[str, tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Metered(Bench):
    """A bench that refuses what does not end within a time limit, `time_limit` seconds from `clock` on.

    Messages begin with what is `wanted`; `pair` is the time of a pair of transforms on this machine [s].
    """

    wanted: str = ""
    time_limit: float | None = None
    pair: float = field(default_factory=transform_seconds)
    clock: float = field(default_factory=time.perf_counter)
    account: Account = field(default_factory=Account)

    @property
    def memory(self) -> int:
        """Bytes that a solve may take."""
        return available_memory() if self.execution.memory is None else self.execution.memory

    @property
    def spent(self) -> float:
        """Seconds since the clock was started."""
        return time.perf_counter() - self.clock

    def seconds(self, solve: Solve) -> float:
        """Predict what a solve takes, by what those of its kind took; else by the machine alone."""
        taken, predicted = self.account.alike.get(_kind(solve), _LITTLE)
        return solve.predict(pair_seconds=self.pair).seconds * taken / predicted

    def affordable(self, seconds: float, peak_bytes: int = 0) -> bool:
        """Whether solves of so many seconds in all would end in time, and the largest fits into memory."""
        left = math.inf if self.time_limit is None else self.time_limit - self.spent - self.account.reserved
        return seconds / self.execution.workers <= left and peak_bytes <= self.memory

    def means(self) -> str:
        """Say what memory and time are left."""
        words = f"{memory_words(self.memory)} are free"
        if self.time_limit is not None:
            words += f" and {max(self.time_limit - self.spent, 0):.3g} s are left"
        return words

    def solve(self, solves: Iterable[Solve], *, despite_failures: bool = False) -> Solves:
        """Solve what is not stored yet.

        A RunFailed for solves that would not end in time, before they begin, and as `Bench.solve`.
        """
        wanted, account = tuple(solves), self.account
        missing = [solve for solve in wanted if not self.store.path(solve).exists()]
        # What is solved here, now or before, is not taken from the store.
        account.found |= set(wanted) - set(missing) - account.done
        account.done |= set(missing)
        if not missing:
            return super().solve(wanted, despite_failures=despite_failures)
        if not self.affordable(sum(map(self.seconds, missing))):
            raise RunFailed(
                f"{self.wanted}: solves take longer here than predicted, {missing[0].describe()} would not "
                f"end in time, and {self.means()}; all finished solves are stored: allow more with "
                f"--time-limit"
            )
        warm_up(missing)  # not charged to the solves, whose time tells how fast the machine is
        account.predicted += sum(map(self.seconds, missing)) / self.execution.workers
        start = time.perf_counter()
        results = super().solve(wanted, despite_failures=despite_failures)
        account.solving += time.perf_counter() - start
        for solve, made in zip(results.solves, results.made(), strict=True):
            if solve in missing:
                taken, predicted = account.alike.get(_kind(solve), _LITTLE)
                predicted += solve.predict(pair_seconds=self.pair).seconds
                account.alike[_kind(solve)] = taken + made.seconds, predicted
        return results


def _kind(solve: Solve) -> str:
    """Name solves whose predictions are off by the same factor."""
    return solve.describe().partition(", surface")[0]
