"""Solves on a Dask cluster, local or far away; the only module that imports dask and distributed."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.errors import UsageError
from validation.solves.cost import too_large
from validation.solves.running import Outcome, attempt
from validation.solves.store import Store

if TYPE_CHECKING:
    from validation.solves.solve import Solve

__all__ = ["solve_on_cluster"]

#: Jobs handed to the scheduler at a time, per worker: one under way and one that waits.
_AHEAD = 2
_PATIENCE = 60.0


def solve_on_cluster(
    solves: tuple[Solve, ...], store: Store, *, address: str, begin: Callable[[Solve], None]
) -> Iterator[Outcome]:
    """Do solves on a Dask cluster; yield each outcome when it is known.

    Workers write their results into the store themselves: its folder must be on a file system that they and
    this machine share. The scheduler repeats the solve of a worker that dies.

    Parameters
    ----------
    solves : tuple of Solve
    store : Store
    address : str
        Of the scheduler, such as "tcp://host:8786".
    begin : callable
        Told each solve that is handed to the scheduler.

    Raises
    ------
    UsageError
        When dask is not installed, no scheduler or worker answers, a worker has more than one thread, or a
        solve fits on no worker.
    """
    client = _connected(address)
    try:
        import distributed

        limits = _workers(client, address)
        allowed = {solve.key: _fitting(solve, limits) for solve in solves}
        store = replace(store, folder=store.folder.resolve())
        waiting = list(solves)
        submitted: dict[str, Solve] = {}
        pending: Any = distributed.as_completed(loop=client.loop, raise_errors=False)

        def hand_out() -> None:
            while waiting and len(submitted) < _AHEAD * len(limits):
                solve = waiting.pop(0)
                begin(solve)
                name = f"{solve.key}-{uuid.uuid4()}"
                future = client.submit(_remote, solve, store.folder, key=name, workers=allowed[solve.key])
                submitted[future.key] = solve
                pending.add(future)

        hand_out()
        while submitted:
            future = next(pending)
            yield _outcome(future, submitted.pop(future.key), store)
            hand_out()
    finally:
        client.close()


def _connected(address: str, *, timeout: float = 10) -> Any:
    try:
        from distributed import Client
    except ImportError:
        raise UsageError(
            f"--scheduler = {address!r}: needs Dask; install it with: pip install 'fem-contact[cluster]'"
        ) from None
    try:
        return Client(address, timeout=timeout, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise UsageError(
            f"--scheduler = {address!r}: no scheduler answers there ({reason}); "
            "start one with: dask scheduler"
        ) from None


def _workers(client: Any, address: str) -> dict[str, int | None]:
    """Return the memory limit of every worker by address; None where it has none."""
    from distributed import TimeoutError as NoWorkers

    try:
        client.wait_for_workers(1, timeout=_PATIENCE)
    except (NoWorkers, TimeoutError):
        raise UsageError(f"--scheduler = {address!r}: has no worker after {_PATIENCE:.0f} s") from None
    found = client.run_on_scheduler(_described)
    for name, (threads, _) in found.items():
        if threads != 1:
            raise UsageError(
                f"--scheduler = {address!r}: worker {name} has {threads} threads; start workers with "
                "--nthreads 1, so that memory can be planned and no solve waits for another"
            )
    return {name: limit or None for name, (_, limit) in found.items()}


def _described(dask_scheduler: Any) -> dict[str, tuple[int, int]]:
    return {name: (state.nthreads, state.memory_limit) for name, state in dask_scheduler.workers.items()}


def _fitting(solve: Solve, limits: dict[str, int | None]) -> list[str] | None:
    """Return the workers a solve fits on; None if on all, so that workers that come later may take it."""
    needed = solve.predict().peak_bytes
    fitting = [name for name, limit in limits.items() if limit is None or needed <= limit]
    if not fitting:
        raise UsageError(
            too_large(solve, max(limit or 0 for limit in limits.values()), where="on any worker")
        )
    return None if len(fitting) == len(limits) else fitting


def _remote(solve: Solve, folder: Path) -> Outcome:
    from validation.files import prepare_folder

    return attempt(solve, Store(folder=prepare_folder(folder)), threads=1)


def _outcome(future: Any, solve: Solve, store: Store) -> Outcome:
    if future.status != "finished":
        return Outcome(solve=solve, error=f"{solve.describe()}: {_reason(future)}")
    outcome: Outcome = future.result()
    if outcome.error is None and not _visible(store.path(solve)):
        return Outcome(
            solve=solve,
            error=f"{store.folder}: a worker stored {store.path(solve).name} there, but it is not to be seen "
            "here; the store must be on a file system shared with the workers (--store)",
            fatal=True,
        )
    return outcome


def _reason(future: Any) -> str:
    from distributed import KilledWorker

    error = future.exception()
    if isinstance(error, KilledWorker):
        return "its workers died again and again, killed from outside or for lack of memory"
    return f"{type(error).__name__}: {error}"


def _visible(path: Path) -> bool:
    """Whether a file is there, allowing a network file system a few seconds."""
    for _ in range(20):
        if path.exists():
            return True
        time.sleep(0.25)
    return False
