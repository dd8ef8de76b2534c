"""A local worker process: receives solves, solves and stores them, until nobody listens."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import time
import traceback
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from validation.solves.solve import Solve

__all__ = ["BEGUN", "Answer", "main", "serve"]

#: What a worker says when it is warm and the solve begins: from then on a death is charged to the solve.
BEGUN = "begun"
#: What it says when the solve ended: the error, if any, and whether the others need not be tried.
Answer = tuple[str | None, bool]

#: How often a worker looks whether its parent lives, where the system does not end it at once [s].
_LOOK_EVERY = 0.5


def serve(connection: Connection[Any, Any]) -> None:
    """Do solves until the other end is closed."""
    warm: set[tuple[str, ...]] = set()
    previous: Solve | None = None
    while True:
        try:
            solve, store = connection.recv()
        except (EOFError, OSError):
            return
        try:
            from validation.solves.attempt import attempt, warm_up

            if solve.code_path not in warm:
                warm_up([solve])
                warm.add(solve.code_path)
            connection.send(BEGUN)
            previous = solve.after(previous)
            outcome = attempt(previous, store, threads=1)
            answer: Answer = (outcome.error, outcome.fatal)
        except OSError:  # the one who asked is gone
            return
        except Exception as error:
            traceback.print_exc()
            answer = (f"{solve.describe()}: {type(error).__name__}: {error}", True)
        try:
            connection.send(answer)
        except OSError:  # the one who asked is gone; the result is stored
            return


def _end_with(parent: int) -> None:
    """End this process when its parent does, at whatever it is: nobody would collect what it does."""
    if sys.platform == "linux":
        import ctypes

        with contextlib.suppress(OSError, AttributeError):
            set_parent_death_signal = 1  # PR_SET_PDEATHSIG of prctl(2)
            ctypes.CDLL(None, use_errno=True).prctl(set_parent_death_signal, signal.SIGKILL)

    def look() -> None:
        while os.getppid() == parent:
            time.sleep(_LOOK_EVERY)
        os._exit(1)

    # The signal may not be had, and may have come before it was asked for.
    threading.Thread(target=look, daemon=True).start()


def main() -> None:
    """Serve the connection whose file descriptor is the first argument, for the parent that is the second."""
    # Ctrl-C reaches every process of the terminal; the one that started this ends it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _end_with(int(sys.argv[2]))
    serve(Connection(int(sys.argv[1])))


if __name__ == "__main__":
    main()
