"""Solving what is not stored yet: in this process, on local workers, or on a cluster."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from validation.errors import RunFailed, UsageError
from validation.files import prepare_folder, sync_folder
from validation.solves.attempt import Outcome, Progress, Silent, attempt, warm_up
from validation.solves.cost import available_memory, too_large
from validation.solves.provenance import Made
from validation.solves.solve import Solve
from validation.solves.store import Store, Stored

__all__ = ["Execution", "Solves", "solve_all"]


@dataclass(frozen=True, kw_only=True)
class Execution:
    """Where solves run.

    Attributes
    ----------
    workers : int
        1: in this process, with all its threads. More: that many processes of one thread each.
    scheduler : str or None
        Address of a Dask scheduler, which then does the work; its workers write into the same store.
    memory : int or None
        Bytes that all solves running at a time may take together; what is free on this machine if not given.
    patience : float
        How long to wait for a worker of the scheduler while there is none [s]; hours where they queue.
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
                f"workers = {self.workers}: cannot be combined with a scheduler, which has workers of its own"
            )


@dataclass(frozen=True, kw_only=True, eq=False)
class Solves(Mapping[Any, Any]):
    """Results by solve, fields or numbers; each is read once, when asked for, while memory lasts.

    Attributes
    ----------
    solves : tuple of Solve
        In the order they were asked for.
    store : Store
    solved : int
        How many were solved now; the others were found finished.
    failures : mapping
        Of those that failed, which are not among the others, why and what to do; where that is no end.
    """

    solves: tuple[Solve, ...]
    store: Store
    solved: int = 0
    failures: Mapping[Any, str] = field(default_factory=dict)
    kept: _Kept = field(default_factory=lambda: _Kept(_KEPT_BYTES))

    def __getitem__(self, solve: Solve) -> Any:
        """Read a result from the store."""
        return self._stored(solve).result

    def made(self) -> tuple[Made, ...]:
        """Return how each was made, for `made_words`."""
        known = self.kept.made
        return tuple(known.get(solve.key) or self._stored(solve).made for solve in self.solves)

    def _stored(self, solve: Solve) -> Stored:
        stored = self.kept.get(solve)
        if stored is None:
            stored = self.store.read(solve)
            if stored is None:
                raise RunFailed(f"{solve.describe()}: no intact result in {self.store.folder}; run it again")
            self.kept.put(solve, stored)
        return stored

    def __iter__(self) -> Iterator[Solve]:
        """Solves in the order they were asked for."""
        return iter(self.solves)

    def __len__(self) -> int:
        """Count the solves."""
        return len(self.solves)


#: Results that are held in memory after they were read, in all.
_KEPT_BYTES = 2**29
#: Syncing a folder takes some milliseconds, as long as a small solve [s].
_SYNCED_EVERY = 1.0


class _Kept:
    """Results that were read already, up to a size in all; how each was made, of all of them."""

    def __init__(self, limit: int) -> None:
        self.made: dict[str, Made] = {}
        self._results: dict[str, Stored] = {}
        self._free = limit

    def get(self, solve: Solve) -> Stored | None:
        """Return a result; None if it is not kept."""
        return self._results.get(solve.key)

    def put(self, solve: Solve, stored: Stored) -> None:
        """Keep a result if there is room; files of mostly zeros take more in memory than on disk."""
        self.made[solve.key] = stored.made
        size = 3 * stored.size
        if size <= self._free and solve.key not in self._results:
            self._results[solve.key] = stored
            self._free -= size


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

    Raises
    ------
    UsageError
        For a solve that does not fit into memory, or a scheduler that does not answer, before anything runs.
    RunFailed
        When solves failed, naming them, or the disk is full.
    """
    execution, progress = execution or Execution(), progress or Silent()
    wanted = tuple({solve.key: solve for solve in solves}.values())
    kept = _Kept(_KEPT_BYTES)
    missing: list[Solve] = []
    for solve in wanted:
        stored = store.read(solve, on_damage=progress.note)
        if stored is None:
            missing.append(solve)
        else:
            kept.put(solve, stored)
    if execution.scheduler is None:
        _refuse_too_large(missing, execution)
    if missing:  # a store that holds everything may be read-only
        prepare_folder(store.folder, option="--store")
    progress.start(tuple(missing), len(wanted) - len(missing))
    failures = []
    with _lasting(store) as synced:
        for outcome in _outcomes(tuple(missing), store, execution, progress):
            if outcome.fatal:
                raise RunFailed(outcome.error)
            if outcome.error is not None:
                failures.append(outcome)
            else:
                synced()
                progress.done(outcome.solve)
    if failures and not (despite_failures and len(failures) < len(wanted)):
        raise RunFailed(_failed(failures, len(missing)))
    failed = {outcome.solve.key: str(outcome.error) for outcome in failures}
    return Solves(
        solves=tuple(solve for solve in wanted if solve.key not in failed),
        store=store,
        solved=len(missing) - len(failed),
        failures={solve: failed[solve.key] for solve in wanted if solve.key in failed},
        kept=kept,
    )


@contextlib.contextmanager
def _lasting(store: Store) -> Iterator[Callable[[], None]]:
    """Have the names of finished solves kept by the disk once a second, and at the end."""
    last = time.monotonic()

    def synced() -> None:
        nonlocal last
        if time.monotonic() - last > _SYNCED_EVERY:
            sync_folder(store.folder)
            last = time.monotonic()

    try:
        yield synced
    finally:
        sync_folder(store.folder)


def _outcomes(
    solves: tuple[Solve, ...], store: Store, execution: Execution, progress: Progress
) -> Iterator[Outcome]:
    if not solves:
        return iter(())
    if execution.scheduler is not None:
        from validation.solves.cluster import solve_on_cluster

        return solve_on_cluster(
            solves, store, address=execution.scheduler, patience=execution.patience, progress=progress
        )
    if execution.workers > 1:
        from validation.solves.pool import solve_in_processes

        memory = available_memory() if execution.memory is None else execution.memory
        return solve_in_processes(solves, store, workers=execution.workers, memory=memory, progress=progress)
    return _in_this_process(solves, store, progress)


def _in_this_process(solves: Sequence[Solve], store: Store, progress: Progress) -> Iterator[Outcome]:
    warm_up(solves)
    previous: Solve | None = None
    for solve in solves:
        progress.begin(solve)
        previous = solve.after(previous)
        yield attempt(previous, store)


def _failed(failures: Sequence[Outcome], tried: int) -> str:
    if len(failures) == 1 == tried:
        return str(failures[0].error)
    lines = "\n".join(f"  {failure.error}" for failure in failures[:10])
    more = f"\n  and {len(failures) - 10} more" if len(failures) > 10 else ""
    return f"{len(failures)} of {tried} solves failed, the others are stored:\n{lines}{more}"


def _refuse_too_large(solves: Sequence[Solve], execution: Execution) -> None:
    limit = available_memory() if execution.memory is None else execution.memory
    largest = max(solves, key=lambda solve: solve.predict().peak_bytes, default=None)
    if largest is not None and largest.predict().peak_bytes > limit:
        raise UsageError(too_large(largest, limit))
