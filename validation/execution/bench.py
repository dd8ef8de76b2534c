"""The bench that studies run on: solves what is not stored yet, stores it, and hands the results back.

Solves run in this process, on local workers, or on a cluster.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from validation.errors import RunFailed, SolvesFailed, UsageError
from validation.execution.attempt import Outcome, Progress, attempt, warm_up
from validation.execution.provenance import Made
from validation.execution.solve import Solve, check_memory
from validation.execution.store import Store, Stored
from validation.files import available_memory, prepare_folder, sync_folder

#: Where studies keep their solves unless told otherwise: one folder for all of them, so that they share
#: cases.
DEFAULT_STORE = Path("results") / "solves"
#: Results that are held in memory after they were read, in all.
_HELD_BYTES = 2**29
#: Syncing a folder takes some milliseconds, as long as a small solve [s].
_SYNCED_EVERY = 1.0


@dataclass(frozen=True, kw_only=True)
class Execution:
    """Where solves run: in this process, with all its threads, or in many of one thread each (`workers`).

    A Dask `scheduler`, named by its address, has workers of its own, which write into the same store; while
    there is none, one is waited for (`patience` [s]; hours where they queue). All solves running at a time
    may take `memory` bytes together; what is free on this machine if not given.
    """

    workers: int = 1
    scheduler: str | None = None
    memory: int | None = None
    patience: float = 300.0

    def __post_init__(self) -> None:
        if self.workers < 1:
            raise UsageError(f"workers = {self.workers}: must be at least 1")
        if self.scheduler is not None and self.workers != 1:
            raise UsageError(
                f"workers = {self.workers}: not together with --scheduler, which has workers of its own"
            )


class Solves(Mapping[Any, Any]):
    """Results by solve, fields or numbers; each is read once, when asked for, while memory lasts.

    So many were `solved` now, the others found finished; `failures` says of those that failed, and are not
    among the others, why; `how` each that was read was made, by its key.
    """

    def __init__(self, solves: tuple[Solve, ...], store: Store, *, how: dict[str, Made]) -> None:
        self.solves, self.store, self.how, self.solved = solves, store, how, 0
        self.failures: dict[Any, str] = {}
        self._held: dict[str, Stored] = {}
        self._free = _HELD_BYTES

    def read(self, solve: Solve, *, on_damage: Callable[[str], None] | None = None) -> Stored | None:
        """Read a result and how it was made; None where none is stored. See `Store.read`."""
        stored = self._held.get(solve.key) or self.store.read(solve, on_damage=on_damage)
        if stored is None:
            self.how.pop(solve.key, None)  # of one that was damaged since
        elif solve.key not in self._held:
            self.how[solve.key] = stored.made
            size = 3 * stored.size  # files of mostly zeros take more in memory than on disk
            if size <= self._free:
                self._held[solve.key] = stored
                self._free -= size
        return stored

    def __getitem__(self, solve: Solve) -> Any:
        stored = self.read(solve)
        if stored is None:
            raise RunFailed(f"{solve.describe()}: no intact result in {self.store.folder}; run it again")
        return stored.result

    def made(self) -> tuple[Made, ...]:
        """Return how each was made, for `made_words`."""
        for solve in self.solves:
            if solve.key not in self.how:
                self[solve]
        return tuple(self.how[solve.key] for solve in self.solves)

    def __iter__(self) -> Iterator[Solve]:
        return iter(self.solves)

    def __len__(self) -> int:
        return len(self.solves)


class PlannedOnly(Exception):
    """Raised by a bench that only plans, in place of the first solve; its arguments are the solves."""


@dataclass(frozen=True, kw_only=True)
class Bench:
    """A store, which studies share, and a way of running: in the process, on local workers or on a cluster.

    One that only plans solves nothing: `solve` raises `PlannedOnly` with the solves.

    ::

        bench = Bench.at("results/solves", execution=Execution(workers=2))
        results = bench.solve(solves)
        areas = [results[solve].in_contact.mean() for solve in solves]  # a solve is the key of its result
    """

    store: Store
    execution: Execution = field(default_factory=Execution)
    progress: Progress = field(default_factory=Progress)
    plan_only: bool = False
    _how: dict[str, Made] = field(default_factory=dict, init=False, repr=False, compare=False)

    @classmethod
    def at(cls, folder: Path | str = DEFAULT_STORE, **how: Any) -> Bench:
        """Return a bench whose store is in a folder, made by the first solve that is to be kept."""
        return cls(store=Store(folder=Path(folder)), **how)

    @property
    def memory(self) -> int:
        """Bytes that the solves under way may take."""
        return available_memory() if self.execution.memory is None else self.execution.memory

    def solve(self, solves: Iterable[Solve], *, despite_failures: bool = False) -> Solves:
        """Solve what is not stored yet and return all results, a mapping whose keys are the solves.

        Each result is on disk as soon as its solve ends, written by whoever solved it: an interruption loses
        at most the solves under way. A solve that fails does not keep the others from being done; with
        `despite_failures` it is named beside their results, unless nothing has one.

        A UsageError for a solve that does not fit into memory, or a scheduler that does not answer, before
        anything runs. A RunFailed when solves failed, naming them, or the disk is full.
        """
        results = Solves(tuple({solve.key: solve for solve in solves}.values()), self.store, how=self._how)
        if self.plan_only:
            for solve in results:
                solve.predict()  # refuses what has no cost, for it cannot be done
            raise PlannedOnly(*results)
        progress, folder = self.progress, self.store.folder
        missing = tuple(solve for solve in results if results.read(solve, on_damage=progress.note) is None)
        if missing:
            if self.execution.scheduler is None:
                check_memory(missing, self.memory)
            prepare_folder(folder, option="--store")  # one that holds everything may be read-only
        progress.start(missing, len(results) - len(missing))
        failed: dict[str, str] = {}
        synced = time.monotonic()
        try:
            for solve, outcome in self._outcomes(missing):
                if outcome.fatal:
                    raise RunFailed(outcome.error)
                if outcome.error is not None:
                    failed[solve.key] = outcome.error
                    continue
                if time.monotonic() - synced > _SYNCED_EVERY:  # the disk keeps the names of what is finished
                    sync_folder(folder)
                    synced = time.monotonic()
                progress.done(solve)
        finally:
            sync_folder(folder)
        results.failures = {solve: failed[solve.key] for solve in results if solve.key in failed}
        if failed and not (despite_failures and len(failed) < len(results)):
            words, *others = failed.values()
            if len(missing) > 1:
                head = f"{len(failed)} of {len(missing)} solves failed, the others are stored:"
                more = [f"and {len(others) - 9} more"] if len(others) > 9 else []
                words = "\n  ".join([head, words, *others[:9], *more])
            raise SolvesFailed(words, results.failures)
        results.solves = tuple(solve for solve in results if solve.key not in failed)
        results.solved = len(missing) - len(failed)
        return results

    def _outcomes(self, solves: tuple[Solve, ...]) -> Iterator[tuple[Solve, Outcome]]:
        execution, progress, store = self.execution, self.progress, self.store
        if solves and execution.scheduler is not None:
            from validation.execution.cluster import solve_on_cluster

            address, patience = execution.scheduler, execution.patience
            yield from solve_on_cluster(solves, store, address=address, patience=patience, progress=progress)
        elif solves and execution.workers > 1:
            from validation.execution.pool import solve_in_processes

            count, memory = execution.workers, self.memory
            yield from solve_in_processes(solves, store, workers=count, memory=memory, progress=progress)
        else:
            warm_up(solves)
            previous: Solve | None = None
            for solve in solves:
                progress.begin(solve)
                previous = solve.after(previous)
                yield solve, attempt(previous, store)

    def made(self) -> tuple[Made, ...]:
        """Return how each result was made that has been read from this bench, for `made_words`."""
        return tuple(self._how.values())
