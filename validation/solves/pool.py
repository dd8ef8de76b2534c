"""Local worker processes of one thread each; one that dies loses only its solve, which is repeated."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, Pipe, wait
from typing import IO, TYPE_CHECKING, Any

from validation.errors import RunFailed
from validation.files import remove_drafts
from validation.solves.attempt import Outcome, Progress
from validation.solves.worker import Answer

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
#: A solve whose worker died this often waits until the others are done, and is then tried once alone.
_ATTEMPTS = 3
#: Workers that die one after another before they begin a solve: something is wrong with this machine.
_STARTS = 3
#: Memory of an idle worker: the interpreter and its libraries.
_IDLE_BYTES = 250 * 2**20


@dataclass(eq=False, kw_only=True)
class _Worker:
    process: subprocess.Popen[bytes]
    connection: Connection[Any, Any]
    #: What it writes to its standard error, for the message if it dies.
    said: IO[bytes]
    solve: Solve | None = None
    begun: bool = False


@dataclass(eq=False, kw_only=True)
class _Pool:
    """The workers, what waits, and how often each solve was tried."""

    store: Store
    memory: int
    progress: Progress
    waiting: list[Solve]
    #: What lost its workers again and again; tried alone at the end.
    suspects: list[Solve] = field(default_factory=list)
    workers: list[_Worker] = field(default_factory=list)
    deaths: Counter[str] = field(default_factory=Counter)
    failed_starts: int = 0

    def busy(self) -> list[_Worker]:
        return [worker for worker in self.workers if worker.solve is not None]

    def next_solve(self) -> Solve | None:
        """Take the first waiting solve that fits beside those under way; one always runs."""
        if not self.waiting:
            return self.suspects.pop(0) if self.suspects and not self.busy() else None
        if any(self.deaths[w.solve.key] >= _ATTEMPTS for w in self.busy() if w.solve is not None):
            return None  # a suspect stays alone
        taken = sum(w.solve.predict().peak_bytes for w in self.busy() if w.solve is not None)
        free = self.memory - len(self.workers) * _IDLE_BYTES - taken
        for solve in self.waiting:
            if not self.busy() or solve.predict().peak_bytes <= free:
                self.waiting.remove(solve)
                return solve
        return None

    def hand_out(self) -> None:
        for worker in self.workers:
            if worker.solve is None:
                solve = self.next_solve()
                if solve is None:
                    return
                worker.solve, worker.begun = solve, False
                self.progress.begin(solve)
                with contextlib.suppress(OSError):  # a worker that is dead already is noticed when it is read
                    worker.connection.send((solve, self.store))

    def collect(self, worker: _Worker) -> Outcome | None:
        """Return how a solve ended; None if it has only begun, or if its worker died and it waits again."""
        solve = worker.solve
        assert solve is not None
        try:
            answer: str | Answer = worker.connection.recv()
        except (EOFError, OSError):
            return self._died(worker, solve)
        self.failed_starts = 0
        if isinstance(answer, str):
            worker.begun = True
            return None
        worker.solve = None
        error, fatal = answer
        return Outcome(solve=solve, error=error, fatal=fatal)

    def _died(self, worker: _Worker, solve: Solve) -> Outcome | None:
        worker.solve, begun = None, worker.begun
        words = self._replace(worker)
        if self.store.path(solve).exists():  # it died after its work was done
            return Outcome(solve=solve)
        if not begun:
            self.failed_starts += 1
            again = self.suspects if self.deaths[solve.key] >= _ATTEMPTS else self.waiting
            again.insert(0, solve)
            if self.failed_starts < _STARTS * max(1, len(self.workers)):
                return None
            return Outcome(
                solve=solve,
                error=f"worker processes die before they begin to solve{words}; finished solves are intact",
                fatal=True,
            )
        self.deaths[solve.key] += 1
        if self.deaths[solve.key] < _ATTEMPTS:
            self.waiting.insert(0, solve)
            return None
        if self.deaths[solve.key] == _ATTEMPTS:
            self.suspects.append(solve)
            self.progress.note(
                f"{solve.describe()}: its worker died {_ATTEMPTS} times{words}; it is tried once more when "
                "the others are done"
            )
            return None
        return Outcome(
            solve=solve,
            error=f"{solve.describe()}: its worker died {_ATTEMPTS} times, and once more when nothing "
            f"else ran{words}: killed from outside or for lack of memory",
        )

    def _replace(self, worker: _Worker) -> str:
        """Start another worker in place of a dead one; return its last words."""
        words = _last_words(worker)
        _end(worker)
        remove_drafts(self.store.folder, of=worker.process.pid)
        self.workers[self.workers.index(worker)] = _start()
        return words


def solve_in_processes(
    solves: tuple[Solve, ...], store: Store, *, workers: int, memory: int, progress: Progress
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
    progress : Progress
        Told each solve that is handed to a worker, again when it has to be repeated.

    Raises
    ------
    RunFailed
        When the system starts no worker.
    """
    longest_first = sorted(solves, key=lambda solve: solve.predict().seconds, reverse=True)
    pool = _Pool(store=store, memory=memory, progress=progress, waiting=longest_first)
    try:
        for _ in range(min(workers, len(solves))):
            try:
                pool.workers.append(_start())
            except RunFailed as error:
                if not pool.workers:
                    raise
                progress.note(f"{error}; {len(pool.workers)} workers go on")
                break
        while pool.waiting or pool.suspects or pool.busy():
            pool.hand_out()
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
    path = os.pathsep.join(entry for entry in sys.path if entry)
    try:
        ours, theirs = Pipe()
        said = tempfile.TemporaryFile()  # noqa: SIM115 -- as long as the worker
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "validation.solves.worker", str(theirs.fileno()), str(os.getpid())],
            pass_fds=(theirs.fileno(),),
            env={**os.environ, **ONE_THREAD, "PYTHONPATH": path},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=said,
        )
    except OSError as error:
        raise RunFailed(
            f"no worker process can be started ({error.strerror}); name fewer --workers, or raise the "
            "limits of this shell (ulimit -n, -u, -v)"
        ) from None
    theirs.close()
    return _Worker(process=process, connection=ours, said=said)


def _last_words(worker: _Worker) -> str:
    """Return the last line that a dead worker wrote, in brackets; nothing if it was silent."""
    try:
        worker.said.seek(0)
        lines = worker.said.read()[-2000:].decode(errors="replace").split("\n")
    except (OSError, ValueError):
        return ""
    last = next((line.strip() for line in reversed(lines) if line.strip()), "")
    return f" ({last[:200]})" if last else ""


def _end(worker: _Worker) -> None:
    worker.connection.close()
    if worker.solve is None:
        with contextlib.suppress(subprocess.TimeoutExpired):  # an idle one ends by itself
            worker.process.wait(timeout=2)
    worker.process.kill()
    worker.process.wait()
    worker.said.close()
