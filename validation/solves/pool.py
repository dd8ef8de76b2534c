"""Local worker processes of one thread each; one that dies loses only its job, which is repeated."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, Pipe, wait
from typing import TYPE_CHECKING, Any

from validation.files import remove_drafts
from validation.solves.cost import predicted_cost
from validation.solves.running import Outcome

if TYPE_CHECKING:
    from validation.solves.solve import AnyJob
    from validation.solves.store import Store

__all__ = ["ONE_THREAD", "solve_in_processes"]

#: What makes the numerical libraries of a new process use one thread.
ONE_THREAD = dict.fromkeys(
    (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "NUMBA_NUM_THREADS",
        "VECLIB_MAXIMUM_THREADS",
    ),
    "1",
)
#: A job whose worker died this often is given up: it is probably what kills them.
_ATTEMPTS = 3
#: Memory of an idle worker: the interpreter and its libraries.
_IDLE_BYTES = 250 * 2**20


@dataclass(eq=False, kw_only=True)
class _Worker:
    process: subprocess.Popen[bytes]
    connection: Connection[Any, Any]
    job: AnyJob | None = None


@dataclass(eq=False, kw_only=True)
class _Pool:
    """The workers, what waits, and how often each job was tried."""

    store: Store
    memory: int
    waiting: list[AnyJob]
    workers: list[_Worker] = field(default_factory=list)
    tries: Counter[str] = field(default_factory=Counter)

    def busy(self) -> list[_Worker]:
        return [worker for worker in self.workers if worker.job is not None]

    def next_job(self) -> AnyJob | None:
        """Take the first waiting job that fits beside those under way; one always runs."""
        taken = sum(predicted_cost(w.job).peak_bytes for w in self.busy() if w.job is not None)
        free = self.memory - len(self.workers) * _IDLE_BYTES - taken
        for job in self.waiting:
            if not self.busy() or predicted_cost(job).peak_bytes <= free:
                self.waiting.remove(job)
                return job
        return None

    def hand_out(self, begin: Callable[[AnyJob], None]) -> None:
        for worker in self.workers:
            if worker.job is None:
                job = self.next_job()
                if job is None:
                    return
                worker.job = job
                self.tries[job.key] += 1
                begin(job)
                with contextlib.suppress(OSError):  # a worker that is dead already is noticed when it is read
                    worker.connection.send((job, self.store))

    def collect(self, worker: _Worker) -> Outcome | None:
        """Return what a worker sends, or None if it died and its job waits again."""
        job, worker.job = worker.job, None
        assert job is not None
        try:
            outcome: Outcome = worker.connection.recv()
            return outcome
        except (EOFError, OSError):
            self._replace(worker)
        if self.store.path(job).exists():  # it died after its work was done
            return Outcome(job=job)
        if self.tries[job.key] < _ATTEMPTS:
            self.waiting.insert(0, job)
            return None
        return Outcome(
            job=job,
            error=f"{job.describe()}: its worker died {_ATTEMPTS} times, killed from outside or for lack "
            "of memory",
        )

    def _replace(self, worker: _Worker) -> None:
        _end(worker)
        remove_drafts(self.store.folder, of=worker.process.pid)
        self.workers[self.workers.index(worker)] = _start()


def solve_in_processes(
    jobs: tuple[AnyJob, ...], store: Store, *, workers: int, memory: int, begin: Callable[[AnyJob], None]
) -> Iterator[Outcome]:
    """Do jobs on local processes, the longest first; yield each outcome when it is known.

    Parameters
    ----------
    jobs : tuple of AnyJob
    store : Store
        Where the workers put their results.
    workers : int
        Number of processes, of one thread each.
    memory : int
        Bytes that workers and the solves under way may take together; a solve that does not fit beside the
        others waits.
    begin : callable
        Told each job that is handed to a worker, again when it has to be repeated.
    """
    longest_first = sorted(jobs, key=lambda job: predicted_cost(job).seconds, reverse=True)
    pool = _Pool(store=store, memory=memory, waiting=longest_first)
    try:
        pool.workers += [_start() for _ in range(min(workers, len(jobs)))]
        while pool.waiting or pool.busy():
            pool.hand_out(begin)
            ready = wait([worker.connection for worker in pool.busy()])
            for worker in [worker for worker in pool.busy() if worker.connection in ready]:
                outcome = pool.collect(worker)
                if outcome is not None:
                    yield outcome
    finally:
        for worker in pool.workers:
            _end(worker)
            remove_drafts(store.folder, of=worker.process.pid)


def _start() -> _Worker:
    """Start a fresh interpreter: threads do not survive a fork, and a spawn would run the user's script."""
    ours, theirs = Pipe()
    path = os.pathsep.join(entry for entry in sys.path if entry)
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "validation.solves.worker", str(theirs.fileno())],
        pass_fds=(theirs.fileno(),),
        env={**os.environ, **ONE_THREAD, "PYTHONPATH": path},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
    )
    theirs.close()
    return _Worker(process=process, connection=ours)


def _end(worker: _Worker) -> None:
    worker.connection.close()
    if worker.job is None:
        with contextlib.suppress(subprocess.TimeoutExpired):  # an idle one ends by itself
            worker.process.wait(timeout=2)
    worker.process.kill()
    worker.process.wait()
