"""Many solves at a time on workers that may die: which is begun when, and which is tried again."""

from __future__ import annotations

import pickle
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import TYPE_CHECKING, Any, Protocol, Self

import numpy as np

from validation.arrays import Array
from validation.errors import RunFailed, UsageError
from validation.execution.attempt import Outcome, Progress, attempt_in_worker, made_ready
from validation.files import remove_drafts
from validation.sandbox import Child, OutOfBounds

if TYPE_CHECKING:
    from validation.execution.solve import Solve
    from validation.execution.store import Store

__all__ = ["Again", "Died", "Workers", "scheduled", "solve_in_processes"]

#: A solve whose worker died this often waits until the others are done, and is then tried once alone.
_ATTEMPTS = 3
#: Workers that die one after another before they begin a solve: something is wrong with this machine.
_STARTS = 3
#: Memory of an idle worker: the interpreter and its libraries.
_IDLE_BYTES = 250 * 2**20


class Died(Exception):
    """The worker of a solve died, with these words; `begun`: at the solve itself."""

    def __init__(self, words: str, *, begun: bool = True) -> None:
        super().__init__(words)
        self.begun = begun


class Again(Exception):
    """Nothing came of a solve for a reason that lies outside it."""


class Workers(Protocol):
    """Where solves are done: processes of this machine, or a cluster."""

    #: How often a solve may lose its worker before it is held back, and how that is said.
    attempts: int
    lost: str

    @property
    def count(self) -> int:
        """How many there are."""

    def room(self, solve: Solve, under_way: Sequence[Solve]) -> bool:
        """Whether a solve may begin beside those under way."""

    def submit(self, solve: Solve) -> Any:
        """Begin a solve."""

    def finished(self, under_way: Mapping[Any, Solve]) -> Iterable[Any]:
        """Wait within bounds, and return what has ended."""

    def outcome(self, future: Any, solve: Solve) -> Outcome:
        """Return how a solve ended, or raise `Died` or `Again`."""


def scheduled(solves: Sequence[Solve], workers: Workers, *, progress: Progress) -> Iterator[Outcome]:
    """Do solves on workers; yield each outcome when it is known.

    One whose worker died is tried again, at last while nothing else runs: others may have taken its memory.
    """
    waiting, failed_starts = list(solves), 0
    suspects: list[Solve] = []
    under_way: dict[Any, Solve] = {}
    deaths: Counter[str] = Counter()
    while waiting or suspects or under_way:
        alone = any(deaths[solve.key] >= workers.attempts for solve in under_way.values())
        while not alone and (solve := _next(waiting, suspects, list(under_way.values()), workers)):
            progress.begin(solve)
            under_way[workers.submit(solve)] = solve
            alone = deaths[solve.key] >= workers.attempts
        for future in workers.finished(under_way):
            solve = under_way.pop(future)
            try:
                yield workers.outcome(future, solve)
                failed_starts = 0
            except Again:
                waiting.insert(0, solve)
            except Died as death:
                deaths[solve.key] += death.begun
                failed_starts = 0 if death.begun else failed_starts + 1
                if failed_starts >= _STARTS * max(1, workers.count):
                    words = f"worker processes die before they begin to solve{death}"
                    yield Outcome(solve=solve, error=f"{words}; finished solves are intact", fatal=True)
                elif deaths[solve.key] < workers.attempts:
                    waiting.insert(0, solve)
                elif deaths[solve.key] == workers.attempts:
                    suspects.append(solve)
                    if death.begun:
                        again = "it is tried once more when the others are done"
                        progress.note(f"{solve.describe()}: {workers.lost}{death}; {again}")
                else:
                    last = f"and once more when nothing else ran{death}"
                    why = f"{workers.lost}, {last}: killed from outside or for lack of memory"
                    yield Outcome(solve=solve, error=f"{solve.describe()}: {why}")


def _next(
    waiting: list[Solve], suspects: list[Solve], under_way: Sequence[Solve], workers: Workers
) -> Solve | None:
    """Take the first solve that may begin now; a suspect runs alone."""
    if not waiting:
        return suspects.pop(0) if suspects and not under_way else None
    fitting = (k for k, solve in enumerate(waiting) if workers.room(solve, under_way))
    k = next(fitting, None)
    return None if k is None else waiting.pop(k)


class _Worker(Child):
    """A child process whose last line is kept, for the message if it dies."""

    def __init__(self) -> None:
        self.said = tempfile.TemporaryFile()  # noqa: SIM115 -- as long as the worker
        super().__init__(stderr=self.said)
        try:
            self.start()
        except OSError:
            self.said.close()
            raise

    def close(self) -> None:
        super().close()
        self.said.close()

    def last_words(self) -> str:
        """Return the last line that it wrote, in brackets, and forget it; nothing if it was silent."""
        self.said.seek(0)
        lines = self.said.read()[-2000:].decode(errors="replace").split("\n")
        self.said.seek(0)
        self.said.truncate()
        last = next((line.strip() for line in reversed(lines) if line.strip()), "")
        return f" ({last[:200]})" if last else ""


class _Processes:
    """Processes of one thread each, whose solves fit into memory together."""

    attempts, lost = _ATTEMPTS, f"its worker died {_ATTEMPTS} times"

    def __init__(self, store: Store, workers: Sequence[_Worker], *, memory: int) -> None:
        self.store, self.workers, self.memory = store, workers, memory
        self.idle = list(workers)
        self.threads, self.ending = ThreadPoolExecutor(len(workers)), False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.ending = True
        self.threads.shutdown(wait=False, cancel_futures=True)
        while len(self.idle) < self.count:
            for worker in self.workers:
                worker.kill()
            time.sleep(0.01)
        self.threads.shutdown()

    @property
    def count(self) -> int:
        return len(self.workers)

    def room(self, solve: Solve, under_way: Sequence[Solve]) -> bool:
        if not under_way:
            return True  # one always runs
        taken = sum(other.predict().peak_bytes for other in (*under_way, solve))
        return len(under_way) < self.count and taken <= self.memory - self.count * _IDLE_BYTES

    def submit(self, solve: Solve) -> Future[Outcome]:
        return self.threads.submit(self._attempt, solve)

    def finished(self, under_way: Mapping[Future[Outcome], Solve]) -> Iterable[Future[Outcome]]:
        return wait(under_way, return_when=FIRST_COMPLETED).done

    def outcome(self, future: Future[Outcome], solve: Solve) -> Outcome:
        return future.result()

    def _attempt(self, solve: Solve) -> Outcome:
        # Taken here, not by who submits: an interruption in between would leave a worker that nobody has.
        worker, begun = self.idle.pop(), False
        try:
            if self.ending:
                return Outcome(solve=solve, error="interrupted", fatal=True)
            try:
                worker.start()
            except OSError as error:
                return Outcome(solve=solve, error=_not_started(error), fatal=True)
            payload = np.frombuffer(pickle.dumps((solve, self.store)), dtype=np.uint8)
            worker.call(_made_ready, payload)
            begun = True
            problem, fatal = worker.call(_attempted)
            return Outcome(solve=solve, error=problem, fatal=fatal)
        except OutOfBounds:
            remove_drafts(self.store.folder, of=worker.pid)
            if self.store.path(solve).exists():  # it died after its work was done
                return Outcome(solve=solve)
            raise Died(worker.last_words(), begun=begun) from None
        except UsageError as error:
            return Outcome(solve=solve, error=f"{solve.describe()}: {error}", fatal=True)
        except Exception as error:
            return Outcome(
                solve=solve, error=f"{solve.describe()}: {type(error).__name__}: {error}", fatal=True
            )
        finally:
            self.idle.append(worker)


#: In a worker: what it was handed.
_given: list[Any] = []


def _made_ready(payload: Array) -> None:
    try:
        _given[:] = pickle.loads(payload.data)
    except (AttributeError, ImportError) as error:
        raise UsageError(
            f"a worker process cannot import what it solves ({error}); define that in a module, not in the "
            "script or notebook that runs it, or take one worker"
        ) from None
    made_ready(_given[0])


def _attempted() -> tuple[str | None, bool]:
    outcome = attempt_in_worker(*_given)
    return outcome.error, outcome.fatal


def _not_started(error: OSError) -> str:
    return (
        f"no worker process can be started ({error.strerror}); name fewer --workers, or raise the limits of "
        "this shell (ulimit -n, -u, -v)"
    )


def solve_in_processes(
    solves: Sequence[Solve], store: Store, *, workers: int, memory: int, progress: Progress
) -> Iterator[Outcome]:
    """Do solves on local processes of one thread each, the longest first; yield each outcome when known.

    Workers and the solves under way take `memory` bytes together: one that does not fit beside them waits.

    Raises
    ------
    RunFailed
        When the system starts no worker.
    """
    started: list[_Worker] = []
    try:
        for _ in range(min(workers, len(solves))):
            try:
                started.append(_Worker())
            except OSError as error:
                if not started:
                    raise RunFailed(_not_started(error)) from None
                progress.note(f"{_not_started(error)}; {len(started)} workers go on")
                break
        longest_first = sorted(solves, key=lambda solve: solve.predict().seconds, reverse=True)
        with _Processes(store, started, memory=memory) as processes:
            yield from scheduled(longest_first, processes, progress=progress)
    finally:
        for worker in started:
            worker.close()
            remove_drafts(store.folder, of=worker.pid)
