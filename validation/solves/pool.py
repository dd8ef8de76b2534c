"""Local worker processes of one thread each; one that dies loses only its solve, which is repeated."""

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
from validation.solves.running import Outcome

if TYPE_CHECKING:
    from validation.solves.solve import Solve
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
#: A solve whose worker died this often is given up: it is probably what kills them.
_ATTEMPTS = 3
#: Memory of an idle worker: the interpreter and its libraries.
_IDLE_BYTES = 250 * 2**20


@dataclass(eq=False, kw_only=True)
class _Worker:
    process: subprocess.Popen[bytes]
    connection: Connection[Any, Any]
    solve: Solve | None = None


@dataclass(eq=False, kw_only=True)
class _Pool:
    """The workers, what waits, and how often each solve was tried."""

    store: Store
    memory: int
    waiting: list[Solve]
    workers: list[_Worker] = field(default_factory=list)
    tries: Counter[str] = field(default_factory=Counter)

    def busy(self) -> list[_Worker]:
        return [worker for worker in self.workers if worker.solve is not None]

    def next_solve(self) -> Solve | None:
        """Take the first waiting solve that fits beside those under way; one always runs."""
        taken = sum(w.solve.predict().peak_bytes for w in self.busy() if w.solve is not None)
        free = self.memory - len(self.workers) * _IDLE_BYTES - taken
        for solve in self.waiting:
            if not self.busy() or solve.predict().peak_bytes <= free:
                self.waiting.remove(solve)
                return solve
        return None

    def hand_out(self, begin: Callable[[Solve], None]) -> None:
        for worker in self.workers:
            if worker.solve is None:
                solve = self.next_solve()
                if solve is None:
                    return
                worker.solve = solve
                self.tries[solve.key] += 1
                begin(solve)
                with contextlib.suppress(OSError):  # a worker that is dead already is noticed when it is read
                    worker.connection.send((solve, self.store))

    def collect(self, worker: _Worker) -> Outcome | None:
        """Return what a worker sends, or None if it died and its solve waits again."""
        solve, worker.solve = worker.solve, None
        assert solve is not None
        try:
            outcome: Outcome = worker.connection.recv()
            return outcome
        except (EOFError, OSError):
            self._replace(worker)
        if self.store.path(solve).exists():  # it died after its work was done
            return Outcome(solve=solve)
        if self.tries[solve.key] < _ATTEMPTS:
            self.waiting.insert(0, solve)
            return None
        return Outcome(
            solve=solve,
            error=f"{solve.describe()}: its worker died {_ATTEMPTS} times, killed from outside or for lack "
            "of memory",
        )

    def _replace(self, worker: _Worker) -> None:
        _end(worker)
        remove_drafts(self.store.folder, of=worker.process.pid)
        self.workers[self.workers.index(worker)] = _start()


def solve_in_processes(
    solves: tuple[Solve, ...], store: Store, *, workers: int, memory: int, begin: Callable[[Solve], None]
) -> Iterator[Outcome]:
    """Do solves on local processes, the longest first; yield each outcome when it is known.

    Parameters
    ----------
    solves : tuple of Solve
    store : Store
        Where the workers put their results.
    workers : int
        Number of processes, of one thread each.
    memory : int
        Bytes that workers and the solves under way may take together; a solve that does not fit beside the
        others waits.
    begin : callable
        Told each solve that is handed to a worker, again when it has to be repeated.
    """
    longest_first = sorted(solves, key=lambda solve: solve.predict().seconds, reverse=True)
    pool = _Pool(store=store, memory=memory, waiting=longest_first)
    try:
        pool.workers += [_start() for _ in range(min(workers, len(solves)))]
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
    if worker.solve is None:
        with contextlib.suppress(subprocess.TimeoutExpired):  # an idle one ends by itself
            worker.process.wait(timeout=2)
    worker.process.kill()
    worker.process.wait()
