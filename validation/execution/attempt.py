"""Doing one solve and storing its result: what every worker does, and what it tells."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass

from fem_contact.errors import FemContactError
from fem_contact.settings import available_processors, one_blas_thread
from validation.errors import RunFailed
from validation.execution.provenance import Made
from validation.execution.solve import Solve
from validation.execution.store import Store
from validation.files import system_words


class Progress:
    """What a run tells the person who watches it; here, nobody."""

    def start(self, missing: tuple[Solve, ...], stored: int) -> None:
        """Tell which solves are to be done, and how many were found finished."""

    def begin(self, solve: Solve) -> None:
        """Tell that a solve starts."""

    def done(self, solve: Solve) -> None:
        """Tell that a solve is solved and stored."""

    def plan(self, text: str) -> None:
        """Tell what will be done, and how long that takes."""

    def note(self, text: str) -> None:
        """Tell something the user should know, such as a damaged file that was set aside."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """How the attempt at one solve ended; the result itself is in the store.

    `error` says why there is none, and is `fatal` where the others need not be tried: a full disk.
    """

    error: str | None = None
    fatal: bool = False


#: Compiled passes that this process has loaded; of a worker, the solve before, whose surface may be shared.
_warm = set[tuple[str, ...]]()
_previous: list[Solve] = []


def warm_up(solves: Iterable[Solve]) -> None:
    """Load compiled passes of methods and effects, and what writes results, so that no solve is charged."""
    import xarray as xr

    xr.Dataset(coords={"x": [0.0]})  # xarray then imports the libraries of arrays that are installed
    for solve in solves:
        solve.warm_up(_warm)


def attempt_in_worker(solve: Solve, store: Store) -> Outcome:
    """Do one solve of many on one thread, in a worker process that is ready for it."""
    _previous[:] = [solve.after(_previous[0] if _previous else None)]
    return attempt(_previous[0], store, threads=1)


def attempt(solve: Solve, store: Store, *, threads: int | None = None) -> Outcome:
    """Do one solve and store its result, on so many threads; on all that there are if not given.

    Their number changes the result by rounding: the transforms group their sums by it.
    """
    began = time.monotonic()
    try:
        with one_blas_thread():
            result = solve.do(threads=threads)
        used = threads or available_processors() if solve.threaded else 1
        made = Made.now(threads=used, seconds=time.monotonic() - began)
        store.save(solve, result, made=made)
    except (FemContactError, MemoryError) as error:
        return Outcome(error=f"{solve.describe()}: {error}")
    except RunFailed as error:
        return Outcome(error=str(error), fatal=True)
    except OSError as error:  # too many open files, no further thread: the others would meet the same
        return Outcome(error=f"{solve.describe()}: {system_words(error)}", fatal=True)
    return Outcome()
