"""A local worker process: receives solves, solves and stores them, until nobody listens."""

from __future__ import annotations

import signal
import sys
import traceback
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from validation.solves.solve import Solve

__all__ = ["main", "serve"]


def serve(connection: Connection[Any, Any]) -> None:
    """Do solves until the other end is closed."""
    from validation.solves.running import Outcome, attempt, warm_up

    warm: set[tuple[str, ...]] = set()
    previous: Solve | None = None
    while True:
        try:
            solve, store = connection.recv()
        except EOFError:
            return
        try:
            if solve.code_path not in warm:
                warm_up([solve])
                warm.add(solve.code_path)
            previous = solve.after(previous)
            outcome = attempt(previous, store, threads=1)
        except Exception as error:
            traceback.print_exc()
            outcome = Outcome(
                solve=solve, error=f"{solve.describe()}: {type(error).__name__}: {error}", fatal=True
            )
        try:
            connection.send(outcome)
        except OSError:  # the one who asked is gone; the result is stored
            return


def main() -> None:
    """Serve the connection whose file descriptor is the first argument."""
    # Ctrl-C reaches every process of the terminal; the one that started this ends it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    serve(Connection(int(sys.argv[1])))


if __name__ == "__main__":
    main()
