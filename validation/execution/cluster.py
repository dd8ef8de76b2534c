"""Solves on a Dask cluster, local or far away; this module alone imports distributed.

Who names a scheduler trusts it: it may run what it likes in this process, as Dask's documentation says. No
scene can name one.
"""

from __future__ import annotations

import contextlib
import logging
import math
import socket
import threading
import time
import uuid
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path
from typing import Any

from validation.errors import RunFailed, UsageError
from validation.execution.attempt import Outcome, Progress, attempt_in_worker, warm_up
from validation.execution.pool import Again, Died, scheduled
from validation.execution.solve import Solve, check_memory
from validation.execution.store import Store

#: Solves handed to the scheduler at a time, per worker: one under way and one that waits.
_AHEAD = 2
#: How often the cluster is looked at while nothing is finished, and after how long its silence is told [s].
_LOOK_EVERY, _TOLD_AFTER = 1.0, 30.0
#: How long a scheduler may take to answer at first, and how long a lost one is waited for [s].
_CONNECTS_WITHIN, _LOST_AFTER = 30.0, 30.0
#: How long the few words of a worker may take to come [s].
_ANSWER_WITHIN = 5.0


class _Cluster:
    """The workers of a scheduler, which itself repeats the solve of one that dies."""

    def __init__(self, client: Any, address: str, store: Store, progress: Progress, patience: float) -> None:
        self.client, self.address, self.store = client, address, store
        self.progress, self.patience = progress, patience
        self.limits = self.awaited_workers()  # memory of each worker

    def room(self, solve: Solve, under_way: Sequence[Solve]) -> bool:
        return len(under_way) < _AHEAD * len(self.limits)

    def submit(self, solve: Solve) -> Any:
        return self.client.submit(_remote, solve, self.store, key=f"{solve.key}-{uuid.uuid4()}")

    def finished(self, under_way: Mapping[Any, Solve]) -> list[Any]:
        """Return what has ended; where nothing has, look whether the scheduler answers and workers live."""
        from distributed import wait

        with contextlib.suppress(Exception):  # time is over, or a future is cancelled
            wait(list(under_way), timeout=_LOOK_EVERY, return_when="FIRST_COMPLETED")
        ended = [future for future in under_way if future.status != "pending"]
        if not ended:
            self.limits = self.awaited_workers()
        return ended

    def outcome(self, future: Any, solve: Solve) -> Outcome:
        if future.status == "error":
            raised = future.exception(timeout=_ANSWER_WITHIN)
            if type(raised).__name__ == "KilledWorker":
                raise Died
            reason = f"{type(raised).__name__}: {raised}".splitlines()[0]
            return Outcome(error=f"{solve.describe()}: {reason}")
        path = self.store.path(solve)
        outcome: Outcome | None = None
        if future.status == "finished":
            with contextlib.suppress(Exception):  # the worker died with its answer
                outcome = future.result(timeout=_ANSWER_WITHIN)
        if outcome is None:  # or it was cancelled or lost, with the scheduler; it may be stored
            if path.exists():
                return Outcome()
            self.limits = self.awaited_workers()
            raise Again
        if outcome.error is None and not _visible(path):
            return Outcome(error=_unshared(path), fatal=True)
        return outcome

    def awaited_workers(self) -> dict[str, float]:
        """Wait for workers, and return the memory limit [bytes] of each by its address.

        A RunFailed once none came within the patience, or a scheduler that was lost has not answered for
        `_LOST_AFTER` seconds; at once where our own client is closed.
        """
        began, noted, before = time.monotonic(), False, ""
        while True:
            patience, lacking = self.patience, "no workers"
            remedy = "start workers (dask worker ... --nthreads 1)"
            try:
                limits = _memory_limits(self.client, self.address)
                if limits:
                    return limits
            except UsageError:
                raise
            except Exception as error:  # Dask raises what its state makes of a lost connection
                lacking, remedy = f"the scheduler is lost ({type(error).__name__})", "start it again"
                patience = 0.0 if self.client.status == "closed" else _LOST_AFTER
            if remedy != before:  # what is raised varies while one scheduler is lost
                began, before = time.monotonic(), remedy
            waited = time.monotonic() - began
            problem = f"--scheduler = {self.address!r}: {lacking} for {waited:.0f} s"
            if waited > _TOLD_AFTER and not noted:
                # One look can take longer than the patience: it is told, and looked again, before giving up.
                noted = True
                self.progress.note(f"{problem}; waiting for up to {patience:.0f} s")
            elif waited > patience:
                more = f"what is finished is stored: {remedy} and give the same command again"
                raise RunFailed(f"{problem}; {more}")
            time.sleep(min(_LOOK_EVERY, self.patience / 10))


def solve_on_cluster(
    solves: Sequence[Solve], store: Store, *, address: str, patience: float, progress: Progress
) -> Iterator[tuple[Solve, Outcome]]:
    """Do solves on a Dask cluster; yield each with its outcome when it is known.

    Workers write their results into the store themselves: its folder must be on a file system that they and
    this machine share. The scheduler repeats the solve of a worker that dies. While there is none, one is
    waited for, as long as the `patience` lasts [s].

    A UsageError when dask is not installed, no scheduler answers, a worker has more than one thread, or a
    solve does not fit on each worker. A RunFailed when the scheduler is lost, or there is no worker for
    longer than that.
    """
    with _connected(address) as client:
        cluster = _Cluster(client, address, replace(store, folder=store.folder.resolve()), progress, patience)
        check_memory(solves, min(cluster.limits.values()), where="on the smallest worker")
        yield from scheduled(solves, cluster, progress=progress)


@contextlib.contextmanager
def _connected(address: str) -> Iterator[Any]:
    try:
        from distributed import Client
    except ImportError:
        raise UsageError(
            f"--scheduler = {address!r}: needs Dask; install it with: pip install 'fem-contact[cluster]'"
        ) from None
    answer: Future[Any] = Future()

    def connect() -> None:
        try:
            answer.set_result(Client(address, timeout=_CONNECTS_WITHIN / 3, set_as_default=False))
        except Exception as error:  # Dask raises what its parser makes of bytes that are no scheduler's
            answer.set_exception(error)

    # Its log means what is said here in a sentence.
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client", "distributed.comm")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        # Dask itself waits for ever for one that takes the connection and says nothing.
        threading.Thread(target=connect, daemon=True).start()
        try:
            client = answer.result(timeout=_CONNECTS_WITHIN)
        except Exception as error:
            reason = str(error).partition("\n")[0] or f"silent for {_CONNECTS_WITHIN:.0f} s"
            raise UsageError(
                f"--scheduler = {address!r}: no scheduler answers there ({reason}); start one with: dask "
                "scheduler; of TLS, Dask's configuration names both certificates (docs/bench.md)"
            ) from None
        try:
            yield client
        finally:
            with contextlib.suppress(Exception):  # of a scheduler that is gone
                client.close(timeout=2)
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def _memory_limits(client: Any, address: str) -> dict[str, float]:
    """Return the memory limit of every worker by its address [bytes]."""
    workers = client.scheduler_info(n_workers=-1)["workers"]
    if client.status != "running":
        raise ConnectionError(client.status)
    for name, worker in workers.items():
        if worker["nthreads"] != 1:
            raise UsageError(
                f"--scheduler = {address!r}: worker {name} has {worker['nthreads']} threads; start workers "
                "with --nthreads 1, so that memory can be planned and no solve waits for another"
            )
    return {str(name): worker["memory_limit"] or math.inf for name, worker in workers.items()}


def _remote(solve: Solve, store: Store) -> Outcome:
    if not store.folder.is_dir():
        return Outcome(error=f"{socket.gethostname()}: {_unshared(store.folder)}", fatal=True)
    warm_up([solve])
    return attempt_in_worker(solve, store)


def _unshared(path: Path) -> str:
    return (
        f"{path}: is there for the one and not for the other of this machine and a worker; the store must "
        "be on a file system that they share (--store)"
    )


def _visible(path: Path) -> bool:
    """Whether a file is there, allowing a network file system a few seconds."""
    for _ in range(20):
        if path.exists():
            return True
        time.sleep(0.25)
    return False
