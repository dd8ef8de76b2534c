"""Solving what is not stored yet: in this process, on local workers, or on a cluster."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from validation.errors import RunFailed, SolvesFailed, UsageError
from validation.execution.attempt import Outcome, Progress, attempt, warm_up
from validation.execution.cost import available_memory, too_large
from validation.execution.provenance import Made
from validation.execution.solve import Solve
from validation.execution.store import Store, Stored
from validation.files import prepare_folder, sync_folder


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


#: Results that are held in memory after they were read, in all.
_HELD_BYTES = 2**29
#: Syncing a folder takes some milliseconds, as long as a small solve [s].
_SYNCED_EVERY = 1.0


class Solves(Mapping[Any, Any]):
    """Results by solve, fields or numbers; each is read once, when asked for, while memory lasts.

    So many were `solved` now, the others found finished; `failures` says of those that failed, and are not
    among the others, why; `how` each that was read was made, by its key.
    """

    def __init__(self, solves: tuple[Solve, ...], store: Store) -> None:
        self.solves, self.store, self.solved = solves, store, 0
        self.failures: dict[Any, str] = {}
        self.how: dict[str, Made] = {}
        self._held: dict[str, Stored] = {}
        self._free = _HELD_BYTES

    def read(self, solve: Solve, *, on_damage: Callable[[str], None] | None = None) -> Stored | None:
        """Read a result and how it was made; None where none is stored. See `Store.read`."""
        stored = self._held.get(solve.key) or self.store.read(solve, on_damage=on_damage)
        if stored is not None and solve.key not in self._held:
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


def solve_all(
    solves: Iterable[Solve],
    store: Store,
    *,
    progress: Progress | None = None,
    execution: Execution | None = None,
    despite_failures: bool = False,
) -> Solves:
    """Solve and store what is not stored yet; return all results.

    Each result is on disk as soon as its solve ends, written by whoever solved it: an interruption loses at
    most the solves under way. A solve that fails does not keep the others from being done; with
    `despite_failures` it is named beside their results, unless nothing has one.

    A UsageError for a solve that does not fit into memory, or a scheduler that does not answer, before
    anything runs. A RunFailed when solves failed, naming them, or the disk is full.
    """
    execution, progress = execution or Execution(), progress or Progress()
    results = Solves(tuple({solve.key: solve for solve in solves}.values()), store)
    missing = tuple(solve for solve in results if results.read(solve, on_damage=progress.note) is None)
    memory = available_memory() if execution.memory is None else execution.memory
    if missing:
        largest = max(missing, key=lambda solve: solve.predict().peak_bytes)
        if execution.scheduler is None and largest.predict().peak_bytes > memory:
            raise UsageError(too_large(largest, memory))
        prepare_folder(store.folder, option="--store")  # one that holds everything may be read-only
    progress.start(missing, len(results) - len(missing))
    failed: dict[str, str] = {}
    synced = time.monotonic()
    try:
        for solve, outcome in _outcomes(missing, store, execution, progress, memory):
            if outcome.fatal:
                raise RunFailed(outcome.error)
            if outcome.error is not None:
                failed[solve.key] = outcome.error
                continue
            if time.monotonic() - synced > _SYNCED_EVERY:  # the disk keeps the names of what is finished
                sync_folder(store.folder)
                synced = time.monotonic()
            progress.done(solve)
    finally:
        sync_folder(store.folder)
    results.failures = {solve: failed[solve.key] for solve in results if solve.key in failed}
    if failed and not (despite_failures and len(failed) < len(results)):
        errors = list(failed.values())
        if len(errors) == 1 == len(missing):
            raise SolvesFailed(errors[0], results.failures)
        listed = "\n".join(f"  {error}" for error in errors[:10])
        more = f"\n  and {len(errors) - 10} more" if len(errors) > 10 else ""
        head = f"{len(errors)} of {len(missing)} solves failed, the others are stored:"
        raise SolvesFailed(f"{head}\n{listed}{more}", results.failures)
    results.solves = tuple(solve for solve in results if solve.key not in failed)
    results.solved = len(missing) - len(failed)
    return results


def _outcomes(
    solves: tuple[Solve, ...], store: Store, execution: Execution, progress: Progress, memory: int
) -> Iterator[tuple[Solve, Outcome]]:
    if solves and execution.scheduler is not None:
        from validation.execution.cluster import solve_on_cluster

        address, patience = execution.scheduler, execution.patience
        yield from solve_on_cluster(solves, store, address=address, patience=patience, progress=progress)
    elif solves and execution.workers > 1:
        from validation.execution.pool import solve_in_processes

        workers = execution.workers
        yield from solve_in_processes(solves, store, workers=workers, memory=memory, progress=progress)
    else:
        warm_up(solves)
        previous: Solve | None = None
        for solve in solves:
            progress.begin(solve)
            previous = solve.after(previous)
            yield solve, attempt(previous, store)
