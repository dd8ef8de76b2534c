"""Solves on a Dask cluster, local or far away; this module and `plain_answers` alone import distributed."""

from __future__ import annotations

import contextlib
import json
import logging
import queue
import socket
import time
import uuid
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.errors import RunFailed, UsageError
from validation.solves.attempt import Outcome, Progress, attempt, warm_up
from validation.solves.cost import too_large
from validation.solves.store import Store

if TYPE_CHECKING:
    from validation.solves.solve import Solve

__all__ = ["solve_on_cluster"]

#: Solves handed to the scheduler at a time, per worker: one under way and one that waits.
_AHEAD = 2
#: How often the cluster is looked at while nothing is finished, and after how long its silence is told [s].
_LOOK_EVERY, _TOLD_AFTER = 1.0, 30.0
#: How long a scheduler that does not answer is waited for [s].
_LOST_AFTER = 30.0
#: How long the few words of a worker may take to come [s].
_ANSWER_WITHIN = 5.0

#: Code paths that this process is warm for, where it is a worker.
_WARM: set[tuple[str, ...]] = set()

#: Memory limit of every worker by address; None where it has none.
_Limits = Mapping[str, int | None]


@dataclass(eq=False, kw_only=True)
class _Cluster:
    """What was handed to a scheduler, and what waits."""

    client: Any
    address: str
    store: Store
    progress: Progress
    patience: float
    waiting: list[Solve]
    #: What lost its workers again and again; tried alone at the end.
    suspects: list[Solve] = field(default_factory=list)
    tried_alone: set[str] = field(default_factory=set)
    #: Future and workers it may run on (None: all), by the key of the future.
    submitted: dict[str, tuple[Solve, Any, list[str] | None]] = field(default_factory=dict)
    finished: queue.SimpleQueue[Any] = field(default_factory=queue.SimpleQueue)
    limits: _Limits = field(default_factory=dict)
    alone: bool = False

    def outcomes(self) -> Iterator[Outcome]:
        self.limits = self._awaited_workers()
        for solve in self.waiting:  # all of them are known to fit before the first is begun
            _fitting(solve, self.limits)
        while self.waiting or self.suspects or self.submitted:
            self._hand_out()
            try:
                future = self.finished.get(timeout=_LOOK_EVERY)
            except queue.Empty:
                yield from self._looked_after()
                continue
            known = self.submitted.pop(future.key, None)
            outcome = None if known is None else self._outcome(future, known[0])
            if outcome is not None:
                yield outcome

    def _hand_out(self) -> None:
        if not self.submitted:
            self.alone = not self.waiting
            if self.alone and self.suspects:
                solve = self.suspects.pop(0)
                self.tried_alone.add(solve.key)
                self._submit(solve)
                return
        while self.waiting and not self.alone and len(self.submitted) < _AHEAD * len(self.limits):
            self._submit(self.waiting.pop(0))

    def _submit(self, solve: Solve) -> None:
        allowed = _fitting(solve, self.limits)
        self.progress.begin(solve)
        future = self.client.submit(
            _remote, solve, self.store.folder, key=f"{solve.key}-{uuid.uuid4()}", workers=allowed
        )
        self.submitted[future.key] = (solve, future, allowed)
        future.add_done_callback(self.finished.put)

    def _outcome(self, future: Any, solve: Solve) -> Outcome | None:
        """Return how a solve ended; None if it is tried again."""
        if future.status == "finished":
            said = _answer(future)
            if said is None:  # the worker died with its answer, but what it solved may be stored
                if self.store.path(solve).exists():
                    return Outcome(solve=solve)
                self.waiting.insert(0, solve)
                return None
            outcome = Outcome(solve=solve, error=said["error"], fatal=bool(said["fatal"]))
            if outcome.error is None and not _visible(self.store.path(solve)):
                return Outcome(solve=solve, error=_unshared(self.store.path(solve)), fatal=True)
            return outcome
        if future.status != "error":  # cancelled or lost, with the scheduler
            self.waiting.insert(0, solve)
            self._answering()
            return None
        reason, killed = _reason(future)
        if killed and solve.key not in self.tried_alone:
            self.suspects.append(solve)
            self.progress.note(
                f"{solve.describe()}: {reason}; it is tried once more when the others are done"
            )
            return None
        again = ", and once more when nothing else ran" if killed else ""
        return Outcome(solve=solve, error=f"{solve.describe()}: {reason}{again}")

    def _looked_after(self) -> Iterator[Outcome]:
        """Look whether the scheduler answers and workers live; take back what waits for the dead."""
        self.limits = self._awaited_workers()
        for key, (solve, future, allowed) in list(self.submitted.items()):
            if allowed is None or set(allowed) & set(self.limits):
                continue
            del self.submitted[key]
            with contextlib.suppress(Exception):  # whatever becomes of it, it is not asked for any more
                future.cancel()
            try:
                _fitting(solve, self.limits)
            except UsageError as error:
                yield Outcome(solve=solve, error=str(error))
            else:
                self.waiting.insert(0, solve)

    def _awaited_workers(self) -> _Limits:
        """Return the workers; wait for one while there is none, and say so."""
        began, told = time.monotonic(), False
        while True:
            found = self._answering()
            if found:
                return found
            waited = time.monotonic() - began
            if waited > _TOLD_AFTER and not told:
                # Told and looked again before giving up, even where one look took longer than the patience.
                told = True
                self.progress.note(
                    f"--scheduler = {self.address!r}: no workers for {waited:.0f} s; waiting for one "
                    f"for up to {self.patience:.0f} s"
                )
            elif waited > self.patience:
                raise RunFailed(
                    f"--scheduler = {self.address!r}: no workers for {waited:.0f} s; what is finished is "
                    "stored: start workers (dask worker ... --nthreads 1) and give the same command again"
                )
            time.sleep(min(_LOOK_EVERY, self.patience / 10))

    def _answering(self) -> _Limits:
        """Return the workers of a scheduler that answers."""
        began = time.monotonic()
        while True:
            try:
                return _workers(self.client, self.address)
            except UsageError:
                raise
            except Exception as error:  # Dask raises what its state makes of a lost connection
                if self.client.status == "closed" or time.monotonic() - began > _LOST_AFTER:
                    raise RunFailed(
                        f"--scheduler = {self.address!r}: the scheduler is lost ({type(error).__name__}); "
                        "what is finished is stored: start it again and give the same command"
                    ) from None
                time.sleep(_LOOK_EVERY)


def solve_on_cluster(
    solves: tuple[Solve, ...], store: Store, *, address: str, patience: float, progress: Progress
) -> Iterator[Outcome]:
    """Do solves on a Dask cluster; yield each outcome when it is known.

    Workers write their results into the store themselves: its folder must be on a file system that they and
    this machine share. The scheduler repeats the solve of a worker that dies. What comes back through Dask is
    a short text; see `plain_answers` for what else a scheduler may send.

    Parameters
    ----------
    solves : tuple of Solve
    store : Store
    address : str
        Of the scheduler, such as "tcp://host:8786" or "tls://host:8786".
    patience : float
        How long to wait while there is no worker [s].
    progress : Progress
        Told each solve that is handed to the scheduler, and when workers are missing.

    Raises
    ------
    UsageError
        When dask is not installed, no scheduler answers, a worker has more than one thread, or a solve fits
        on no worker.
    RunFailed
        When the scheduler is lost, or there is no worker for longer than `patience`.
    """
    with _connected(address) as client:
        yield from _Cluster(
            client=client,
            address=address,
            store=replace(store, folder=store.folder.resolve()),
            progress=progress,
            patience=patience,
            waiting=list(solves),
        ).outcomes()


@contextlib.contextmanager
def _connected(address: str, *, timeout: float = 10) -> Iterator[Any]:
    try:
        from distributed import Client, Security

        from validation.solves.plain_answers import plain_answers
    except ImportError:
        raise UsageError(
            f"--scheduler = {address!r}: needs Dask; install it with: pip install 'fem-contact[cluster]'"
        ) from None
    if Security().require_encryption and not address.startswith("tls://"):
        raise UsageError(
            f"--scheduler = {address!r}: Dask's configuration asks for encryption; name it as tls://host:port"
        )
    with plain_answers(), _quiet():
        try:
            client = Client(address, timeout=timeout, set_as_default=False)
        except (OSError, ValueError, TypeError, TimeoutError) as error:
            raise UsageError(f"--scheduler = {address!r}: {_unanswered(address, error)}") from None
        try:
            yield client
        finally:
            with contextlib.suppress(Exception):  # of a scheduler that is gone
                client.close(timeout=2)


def _unanswered(address: str, error: Exception) -> str:
    """Say in one line why no scheduler could be reached, and what to do."""
    reason = str(error).splitlines()[0] if str(error) else type(error).__name__
    if not address.startswith("tls://"):
        return f"no scheduler answers there ({reason}); start one with: dask scheduler"
    if isinstance(error, TypeError):  # Dask found no certificates
        return (
            "TLS needs certificates: name them to Dask, DASK_DISTRIBUTED__COMM__TLS__CA_FILE, "
            "..__CLIENT__CERT and ..__CLIENT__KEY"
        )
    return (
        f"no scheduler answers there ({reason}); it must be started with TLS, and both certificates signed "
        "by the authority that the other one trusts"
    )


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep Dask's own log off the terminal: what it means is said in a sentence."""
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client", "distributed.comm")]
    before = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, before, strict=True):
            logger.setLevel(level)


def _workers(client: Any, address: str) -> dict[str, int | None]:
    """Return the memory limit of every worker by address; None where it has none."""
    try:
        told = client.scheduler_info(n_workers=-1)
    except TypeError:  # before 2025, all of them without asking
        told = client.scheduler_info()
    if client.status != "running":
        raise ConnectionError(client.status)
    for name, worker in told["workers"].items():
        if worker["nthreads"] != 1:
            raise UsageError(
                f"--scheduler = {address!r}: worker {name} has {worker['nthreads']} threads; start workers "
                "with --nthreads 1, so that memory can be planned and no solve waits for another"
            )
    return {str(name): worker["memory_limit"] or None for name, worker in told["workers"].items()}


def _fitting(solve: Solve, limits: _Limits) -> list[str] | None:
    """Return the workers a solve fits on; None if on all, so that workers that come later may take it."""
    needed = solve.predict().peak_bytes
    fitting = [name for name, limit in limits.items() if limit is None or needed <= limit]
    if not fitting:
        raise UsageError(
            too_large(solve, max(limit or 0 for limit in limits.values()), where="on any worker")
        )
    return None if len(fitting) == len(limits) else fitting


def _remote(solve: Solve, folder: Path) -> str:
    """Do a solve in a worker; return how it ended as JSON."""
    try:
        if not folder.is_dir():
            return _said(f"{socket.gethostname()}: {_unshared(folder)}", fatal=True)
        if solve.code_path not in _WARM:
            warm_up([solve])
            _WARM.add(solve.code_path)
        outcome = attempt(solve, Store(folder=folder), threads=1)
    except Exception as error:  # no exception travels: it would have to be unpickled
        return _said(f"{solve.describe()}: {type(error).__name__}: {error}", fatal=True)
    return _said(outcome.error, fatal=outcome.fatal)


def _said(error: str | None, *, fatal: bool) -> str:
    return json.dumps({"error": error, "fatal": fatal})


def _unshared(path: Path) -> str:
    return (
        f"{path}: is there for the one and not for the other of this machine and a worker; the store must "
        "be on a file system that they share (--store)"
    )


def _answer(future: Any) -> dict[str, Any] | None:
    """Return what a worker said at the end of a solve; None if it cannot be had any more."""
    try:
        said: dict[str, Any] = json.loads(str(future.result(timeout=_ANSWER_WITHIN)))
        return said
    except Exception:  # of a worker or a scheduler that is lost, Dask raises what its state makes of it
        with contextlib.suppress(Exception):
            future.cancel()
        return None


def _reason(future: Any) -> tuple[str, bool]:
    """Say why there is no result, and whether the workers died."""
    error = future.exception(timeout=_ANSWER_WITHIN)
    # Where tblib is loaded, an exception travels as its class and what it holds.
    kinds = [type(error), *(one for one in error.args if isinstance(one, type))]
    if any(kind.__name__ == "KilledWorker" for kind in kinds):
        return "its workers died again and again, killed from outside or for lack of memory", True
    return f"{type(error).__name__}: {error}".splitlines()[0], False


def _visible(path: Path) -> bool:
    """Whether a file is there, allowing a network file system a few seconds."""
    for _ in range(20):
        if path.exists():
            return True
        time.sleep(0.25)
    return False
