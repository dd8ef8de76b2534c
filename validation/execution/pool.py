"""Many solves at a time on workers that may die: which is begun when, and which is tried again."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import Any

from validation.execution.attempt import Outcome, Progress, attempt_in_worker, warm_up
from validation.execution.solve import Solve
from validation.execution.store import Store
from validation.files import remove_drafts
from validation.sandbox import Child, OutOfBounds

#: Deaths one after another before a solve is begun: something is wrong with this machine.
_STARTS = 6
#: Memory of an idle worker: the interpreter and its libraries.
_IDLE_BYTES = 250 * 2**20


class Died(Exception):
    """The worker of a solve died, with these words; `begun`: at the solve itself."""

    def __init__(self, words: str = "", *, begun: bool = True) -> None:
        super().__init__(words)
        self.begun = begun


class Again(Exception):
    """Nothing came of a solve for a reason that lies outside it."""


def scheduled(
    solves: Sequence[Solve], workers: Any, *, progress: Progress
) -> Iterator[tuple[Solve, Outcome]]:
    """Do solves on workers; yield each with its outcome when it is known.

    Workers, processes of this machine or a cluster, say whether there is `room` for a solve, `submit` it,
    wait within bounds for what has `finished`, and return its `outcome` or raise `Died` or `Again`. A solve
    whose worker died is tried once more while nothing else runs: others may have taken its memory.
    """
    waiting, failed_starts = list(solves), 0
    suspects: list[Solve] = []
    alone: set[str] = set()
    under_way: dict[Any, Solve] = {}
    while waiting or suspects or under_way:
        busy = list(under_way.values())
        if suspects and not waiting and not busy:
            waiting.append(suspects.pop(0))
            alone.add(waiting[0].key)
        while (k := next((k for k, s in enumerate(waiting) if workers.room(s, busy)), None)) is not None:
            solve = waiting.pop(k)
            busy.append(solve)
            progress.begin(solve)
            under_way[workers.submit(solve)] = solve
        for future in workers.finished(under_way):
            solve = under_way.pop(future)
            try:
                yield solve, workers.outcome(future, solve)
                failed_starts = 0
            except Again:
                waiting.insert(0, solve)
            except Died as death:
                failed_starts = 0 if death.begun else failed_starts + 1
                if failed_starts >= _STARTS:
                    why = f"worker processes die before they begin to solve{death}"
                    yield solve, Outcome(error=f"{why}; finished solves are intact", fatal=True)
                elif not death.begun:
                    waiting.insert(0, solve)
                elif solve.key not in alone:
                    suspects.append(solve)
                    words = f"its worker died{death}; it is tried once more when the others are done"
                    progress.note(f"{solve.describe()}: {words}")
                else:
                    why = "its worker died, and once more when nothing else ran"
                    cause = "killed from outside or for lack of memory"
                    yield solve, Outcome(error=f"{solve.describe()}: {why}{death}: {cause}")


class _Processes:
    """Processes of one thread each, whose solves fit into memory together."""

    def __init__(self, store: Store, count: int, *, memory: int) -> None:
        self.store, self.memory = store, memory - count * _IDLE_BYTES
        self.workers = [Child() for _ in range(count)]
        self.idle = list(self.workers)
        self.threads, self.ending = ThreadPoolExecutor(count), False

    def close(self) -> None:
        self.ending = True
        while len(self.idle) < len(self.workers):
            for worker in self.workers:
                worker.kill()
            time.sleep(0.01)
        self.threads.shutdown()
        for worker in self.idle:
            worker.close()
            remove_drafts(self.store.folder, of=worker.pid)

    def room(self, solve: Solve, under_way: Sequence[Solve]) -> bool:
        if not under_way:
            return True  # one always runs
        taken = sum(other.predict().peak_bytes for other in (*under_way, solve))
        return len(under_way) < len(self.workers) and taken <= self.memory

    def submit(self, solve: Solve) -> Future[Outcome]:
        return self.threads.submit(self._attempt, solve)

    def finished(self, under_way: Mapping[Future[Outcome], Solve]) -> Iterable[Future[Outcome]]:
        return wait(under_way, return_when=FIRST_COMPLETED).done

    def outcome(self, future: Future[Outcome], solve: Solve) -> Outcome:
        return future.result()

    def _attempt(self, solve: Solve) -> Outcome:
        """Solve on an idle worker, in a thread of the pool; `Died` is caught by `scheduled`."""
        # Taken here, not by who submits: an interruption in between would leave a worker that nobody has.
        worker, began = self.idle.pop(), False
        try:
            if self.ending:
                return Outcome(error="interrupted", fatal=True)
            try:
                worker.start()
            except OSError as error:
                remedy = "name fewer --workers, or raise the limits of this shell (ulimit -n, -u, -v)"
                why = f"no worker process can be started ({error.strerror}); {remedy}"
                return Outcome(error=why, fatal=True)
            worker.call(warm_up, [solve])
            began = True
            outcome: Outcome = worker.call(attempt_in_worker, solve, self.store)
            return outcome
        except OutOfBounds:
            remove_drafts(self.store.folder, of=worker.pid)
            if self.store.path(solve).exists():  # it died after its work was done
                return Outcome()
            raise Died(worker.last_words(), begun=began) from None
        except Exception as error:
            why = f"{type(error).__name__}: {error}"
            if not worker.imported:
                why = (
                    f"a worker process cannot import what it solves ({error}); define that in a module, not "
                    "in the script or notebook that runs it, or take one worker"
                )
            return Outcome(error=f"{solve.describe()}: {why}", fatal=True)
        finally:
            self.idle.append(worker)


def solve_in_processes(
    solves: Sequence[Solve], store: Store, *, workers: int, memory: int, progress: Progress
) -> Iterator[tuple[Solve, Outcome]]:
    """Do solves on local processes of one thread each, the longest first; yield each with its outcome.

    Workers and the solves under way take `memory` bytes together: one that does not fit beside them waits.
    """
    longest_first = sorted(solves, key=lambda solve: solve.predict().seconds, reverse=True)
    with contextlib.closing(_Processes(store, min(workers, len(solves)), memory=memory)) as processes:
        yield from scheduled(longest_first, processes, progress=progress)
