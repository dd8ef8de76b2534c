"""Solving what is not stored yet: in this process, on local workers, or on a cluster."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from fem_contact.errors import FemContactError
from validation.errors import RunFailed, UsageError
from validation.files import atomic_path, remove_drafts
from validation.solves.cost import available_memory, predicted_cost, too_large
from validation.solves.solve import AnyJob, NumbersJob, block_file, execute, warm_up
from validation.solves.store import Store

if TYPE_CHECKING:
    pass

__all__ = ["Execution", "Outcome", "Progress", "Silent", "attempt", "one_blas_thread", "solve_jobs"]


class Progress(Protocol):
    """What a run tells the person who watches it."""

    def start(self, missing: tuple[AnyJob, ...], stored: int) -> None:
        """Tell which jobs are to be done, and how many were found finished."""

    def begin(self, job: AnyJob) -> None:
        """Tell that a job starts."""

    def done(self, job: AnyJob) -> None:
        """Tell that a job is solved and stored."""

    def note(self, text: str) -> None:
        """Tell something the user should know, such as a damaged file that was set aside."""


class Silent:
    """Progress that nobody watches."""

    def start(self, missing: tuple[AnyJob, ...], stored: int) -> None:
        """Say nothing."""

    def begin(self, job: AnyJob) -> None:
        """Say nothing."""

    def done(self, job: AnyJob) -> None:
        """Say nothing."""

    def note(self, text: str) -> None:
        """Say nothing."""


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
    """

    workers: int = 1
    scheduler: str | None = None
    memory: int | None = None

    def __post_init__(self) -> None:
        if self.workers < 1:
            raise UsageError(f"workers = {self.workers}: must be at least 1")
        if self.scheduler is not None and self.workers != 1:
            raise UsageError(
                f"workers = {self.workers}: cannot be combined with a scheduler, which has workers of its own"
            )


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """How the attempt at one job ended; the result itself is in the store.

    Attributes
    ----------
    job : AnyJob
    error : str or None
        Why there is no result.
    fatal : bool
        Whether the others need not be tried: a full disk.
    """

    job: AnyJob
    error: str | None = None
    fatal: bool = False


def solve_jobs(
    jobs: tuple[AnyJob, ...],
    store: Store,
    *,
    progress: Progress | None = None,
    execution: Execution | None = None,
) -> int:
    """Solve and store the jobs that are not stored yet; return how many that were.

    Each result is on disk as soon as its solve ends, written by whoever solved it: an interruption loses at
    most the solves under way. A solve that fails does not keep the others from being done.

    Raises
    ------
    UsageError
        For a job that does not fit into memory, or a scheduler that does not answer, before anything runs.
    RunFailed
        When solves failed, naming them, or the disk is full.
    """
    execution, progress = execution or Execution(), progress or Silent()
    remove_drafts(store.folder)
    missing = tuple(job for job in jobs if not store.holds(job, on_damage=progress.note))
    if execution.scheduler is None:
        _refuse_too_large(missing, execution)
    progress.start(missing, len(jobs) - len(missing))
    failures = []
    for outcome in _outcomes(missing, store, execution, progress.begin):
        if outcome.fatal:
            raise RunFailed(outcome.error)
        if outcome.error is not None:
            failures.append(outcome)
        else:
            progress.done(outcome.job)
    if failures:
        raise RunFailed(_failed(failures, len(missing)))
    return len(missing)


def _outcomes(
    jobs: tuple[AnyJob, ...], store: Store, execution: Execution, begin: Callable[[AnyJob], None]
) -> Iterator[Outcome]:
    if not jobs:
        return iter(())
    if execution.scheduler is not None:
        from validation.solves.cluster import solve_on_cluster

        return solve_on_cluster(jobs, store, address=execution.scheduler, begin=begin)
    if execution.workers > 1:
        from validation.solves.pool import solve_in_processes

        memory = available_memory() if execution.memory is None else execution.memory
        return solve_in_processes(jobs, store, workers=execution.workers, memory=memory, begin=begin)
    return _in_this_process(jobs, store, begin)


def _in_this_process(
    jobs: Sequence[AnyJob], store: Store, begin: Callable[[AnyJob], None]
) -> Iterator[Outcome]:
    warm_up(jobs)
    for job in jobs:
        begin(job)
        yield attempt(job, store)


def attempt(job: AnyJob, store: Store, *, threads: int | None = None) -> Outcome:
    """Do one job and store its result; what a worker does.

    Parameters
    ----------
    job : AnyJob
    store : Store
    threads : int, optional
        Threads for this solve; all that there are if not given. Their number changes the result by rounding:
        the transforms group their sums by it.
    """
    try:
        if isinstance(job, NumbersJob):
            with one_blas_thread():
                store.save(job, job.measure())
            return Outcome(job=job)
        # Sparse solvers gain nothing from a threaded BLAS, whose idle threads spin on cores that others need.
        with one_blas_thread():
            solved = execute(job) if threads is None else execute(job, threads=threads)
        solved.contact.checked()
        # The reduced method never holds the inside of the block, which may be a thousand times the surface.
        if solved.block is not None and dict(job.settings).get("method", "full") == "full":
            from fem_contact.export import write_block

            with atomic_path(block_file(store.folder, job)) as draft:
                write_block(draft, solved.block)
        store.save(job, solved.contact)
    except (FemContactError, MemoryError) as error:
        return Outcome(job=job, error=f"{job.describe()}: {error}")
    except RunFailed as error:
        return Outcome(job=job, error=str(error), fatal=True)
    return Outcome(job=job)


def one_blas_thread() -> contextlib.AbstractContextManager[object]:
    """Keep the dense linear algebra inside to one thread."""
    from threadpoolctl import threadpool_limits

    limits: contextlib.AbstractContextManager[object] = threadpool_limits(1, user_api="blas")
    return limits


def _failed(failures: Sequence[Outcome], tried: int) -> str:
    if len(failures) == 1 == tried:
        return str(failures[0].error)
    lines = "\n".join(f"  {failure.error}" for failure in failures[:10])
    more = f"\n  and {len(failures) - 10} more" if len(failures) > 10 else ""
    return f"{len(failures)} of {tried} solves failed, the others are stored:\n{lines}{more}"


def _refuse_too_large(jobs: Sequence[AnyJob], execution: Execution) -> None:
    limit = available_memory() if execution.memory is None else execution.memory
    largest = max(jobs, key=lambda job: predicted_cost(job).peak_bytes, default=None)
    if largest is not None and predicted_cost(largest).peak_bytes > limit:
        raise UsageError(too_large(largest, limit))
