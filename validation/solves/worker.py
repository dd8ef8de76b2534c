"""A local worker process: receives jobs, solves and stores them, until nobody listens."""

from __future__ import annotations

import signal
import sys
import traceback
from multiprocessing.connection import Connection
from typing import Any

__all__ = ["main", "serve"]


def serve(connection: Connection[Any, Any]) -> None:
    """Do jobs until the other end is closed."""
    from validation.solves.running import Outcome, attempt
    from validation.solves.solve import code_path, warm_up

    warm: set[tuple[str, ...]] = set()
    while True:
        try:
            job, store = connection.recv()
        except EOFError:
            return
        try:
            if code_path(job) not in warm:
                warm_up([job])
                warm.add(code_path(job))
            outcome = attempt(job, store, threads=1)
        except Exception as error:
            traceback.print_exc()
            outcome = Outcome(job=job, error=f"{job.describe()}: {type(error).__name__}: {error}", fatal=True)
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
