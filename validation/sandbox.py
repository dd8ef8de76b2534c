"""Functions run in a child process, within bounds of time and memory where nobody vouches for them.

A library of formats that meets a damaged file may loop for ever, take all memory or crash; none of that can
be caught in the process itself. The child is a fresh interpreter that serves one call after another in a
process group of its own, which is ended where a call breaks its bounds. It has the rights of the user: the
bounds are against mistakes and damage, not against code that means harm.
"""

from __future__ import annotations

import atexit
import builtins
import contextlib
import io
import math
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection, Pipe
from typing import IO, Any, Self

from validation import errors

#: What makes the numerical libraries of a new process use one thread.
ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMBA")}
ONE_THREAD |= {"VECLIB_MAXIMUM_THREADS": "1"}
#: What an interpreter may take to start and to import a function [s]; a loaded machine needs many.
_START_SECONDS = 120.0
#: Processor time beyond the time of a call after which the system ends a child whose parent is gone [s].
_GRACE_SECONDS = 5.0
#: How often a child looks whether its parent lives [s].
_LOOK_EVERY = 0.2


class OutOfBounds(Exception):
    """A call that took more time or memory than it was given, or whose process crashed."""


class Child:
    """A child process, started by the first call and anew after one that was ended.

    Examples
    --------
    >>> import math
    >>> with Child() as child:
    ...     child.call(math.gcd, 12, 18, seconds=10)
    6
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: Connection[Any, Any] | None = None
        self._stderr: IO[bytes] = io.BytesIO()
        self._owner = os.getpid()
        #: Of the process that was started last, and whether the function of the last call was imported.
        self.pid, self.imported = 0, False

    def call(
        self,
        function: Callable[..., Any],
        *arguments: Any,
        seconds: float = math.inf,
        memory: int | None = None,
        most_bytes: int = 2**31,
    ) -> Any:
        """Return what a function returns, computed in the child; arrays in it are read-only.

        The function is found by module and name; its arguments are whatever pickle carries. It may take so
        many `seconds` of wall-clock time, that of importing it not counted, and so many bytes of `memory`,
        address space beyond that of the idle child; that is held on Linux, elsewhere time alone is. An array
        of up to `most_bytes` is taken back.

        An OutOfBounds when it took more, or crashed; an OSError when no process can be started. What the
        function raised, if it is built in or one of :mod:`validation.errors`; a RuntimeError that names it
        otherwise.
        """
        with self._lock:
            try:
                self.start()
                value, error = self._ask((function, arguments, seconds, memory), seconds, most_bytes)
                if isinstance(error, MemoryError) and memory is not None:
                    raise OutOfBounds(f"took more than {memory / 2**20:.4g} MiB of memory")
            except BaseException:
                self._end()
                raise
        if error is not None:
            raise error
        return value

    def start(self) -> None:
        """Start the process, unless it runs; an OSError where the system starts none."""
        if self._owner != os.getpid():  # after a fork the child belongs to the parent
            self._process = self._connection = None
            self._owner = os.getpid()
        # An idle child says nothing; what can be read is the end of one that is gone.
        if self._connection is not None and not self._connection.poll():
            return
        self._end()
        self._stderr.close()
        self._stderr = tempfile.TemporaryFile()  # noqa: SIM115 -- as long as the process
        ours, theirs = Pipe()
        # In a notebook the folder it is in is "".
        path = os.pathsep.join(entry or os.getcwd() for entry in sys.path)
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "validation.sandbox", str(theirs.fileno()), str(os.getpid())],
            pass_fds=(theirs.fileno(),),
            env={**os.environ, **ONE_THREAD, "PYTHONPATH": path},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._stderr,
            start_new_session=True,
        )
        theirs.close()
        self._connection, self.pid = ours, self._process.pid

    def kill(self) -> None:
        """End the process and all that it started, whatever it is at; may be called from another thread."""
        import psutil

        process, strays = self._process, []
        if process is not None and process.returncode is None:
            with contextlib.suppress(psutil.Error):  # in sessions of their own
                strays = psutil.Process(process.pid).children(recursive=True)
            with contextlib.suppress(OSError):
                os.killpg(process.pid, signal.SIGKILL)
            for stray in strays:
                with contextlib.suppress(psutil.Error):
                    stray.kill()

    def close(self) -> None:
        """End the process."""
        with self._lock:
            if self._owner == os.getpid():
                self._end()
                self._stderr.close()

    def last_words(self) -> str:
        """Return the last line on its standard error, in brackets; nothing if it was silent."""
        self._stderr.seek(0)
        lines = self._stderr.read()[-2000:].decode(errors="replace").split("\n")
        last = next((line.strip() for line in reversed(lines) if line.strip()), "")
        return f" ({last[:200]})" if last else ""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _ask(self, request: Any, seconds: float, most_bytes: int) -> tuple[Any, Exception | None]:
        """Send a call, and return value and error once it has ended."""
        connection, late, limit = self._connection, threading.Event(), _START_SECONDS
        assert connection is not None
        self.imported = False
        try:
            with self._ended_after(limit, late):
                _send(connection, request)
                if (failure := _received(connection)) is not None:
                    return None, failure
            self.imported, limit = True, seconds
            with self._ended_after(limit, late):
                value, error = _received(connection, most_bytes)
                return value, error
        except (EOFError, ConnectionError):
            code = self._end()
            if late.is_set():
                raise OutOfBounds(f"took more than {limit:.3g} s") from None
            name = signal.Signals(-code).name if -code in list(signal.Signals) else f"exit status {code}"
            raise OutOfBounds(f"crashed its process ({name})") from None
        except OSError:
            raise OutOfBounds(f"gave back more than {most_bytes / 2**20:.4g} MiB") from None

    @contextlib.contextmanager
    def _ended_after(self, seconds: float, late: threading.Event) -> Iterator[None]:
        """End the child when a time is over, which whoever waits for it sees as the end of the file."""

        def end() -> None:
            late.set()
            self.kill()

        timer = threading.Timer(min(seconds, threading.TIMEOUT_MAX), end)
        timer.daemon = True
        timer.start()
        try:
            yield
        finally:
            timer.cancel()

    def _end(self) -> int:
        """End the process; return its exit code, minus the signal that ended it; the lock is held."""
        code = 0
        if self._connection is not None:
            self._connection.close()
        if self._process is not None:
            self.kill()
            code = self._process.wait()
        self._process = self._connection = None
        return code


#: One child for a whole process, since an interpreter takes a third of a second to start.
_SHARED = Child()
call, end = _SHARED.call, _SHARED.close
atexit.register(end)


def _send(connection: Connection[Any, Any], value: Any) -> None:
    """Send a value, its arrays uncopied behind it."""
    arrays: list[pickle.PickleBuffer] = []
    content = pickle.dumps(value, protocol=5, buffer_callback=arrays.append)
    connection.send_bytes(str(len(arrays)).encode())
    connection.send_bytes(content)
    for array in arrays:
        connection.send_bytes(array.raw())


def _received(connection: Connection[Any, Any], most_bytes: int | None = None) -> Any:
    count = int(connection.recv_bytes())
    content = connection.recv_bytes(most_bytes)
    return pickle.loads(content, buffers=[connection.recv_bytes(most_bytes) for _ in range(count)])


def _serve(connection: Connection[Any, Any]) -> None:
    """Answer calls until the other end is closed: None once a function is imported, then value and error."""
    while True:
        try:
            function, arguments, seconds, memory = _received(connection)
        except EOFError:
            return
        except Exception as error:
            _send(connection, _plain(error))
            continue
        _send(connection, None)
        try:
            with _limited(seconds, memory):
                value = function(*arguments)
            _send(connection, (value, None))
        except BaseException as error:  # a SystemExit is an answer, too
            _send(connection, (None, _plain(error)))


def _plain(error: BaseException) -> Exception:
    """Return an exception that every process can make again."""
    kind = MemoryError if isinstance(error, MemoryError) else type(error)
    known = kind in vars(builtins).values() or kind in vars(errors).values()
    if known and issubclass(kind, Exception):
        with contextlib.suppress(TypeError):
            simple = all(isinstance(value, (int, str)) for value in error.args)
            return kind(*(error.args if simple else (str(error),)))
    return RuntimeError(f"{kind.__name__}: {error}")


@contextlib.contextmanager
def _limited(seconds: float, memory: int | None) -> Iterator[None]:
    """Have the system hold the bounds of a call, where it can."""
    try:
        import resource
    except ImportError:  # Windows
        yield
        return
    used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    limits = {} if math.isinf(seconds) else {resource.RLIMIT_CPU: int(used + seconds + _GRACE_SECONDS)}
    if memory is not None and sys.platform == "linux":
        with open("/proc/self/statm") as file:
            limits[resource.RLIMIT_AS] = int(file.read().split()[0]) * resource.getpagesize() + memory
    before = {which: resource.getrlimit(which) for which in limits}
    for which, limit in limits.items():
        hard = before[which][1]
        resource.setrlimit(which, (limit if hard == resource.RLIM_INFINITY else min(limit, hard), hard))
    try:
        yield
    finally:
        for which, pair in before.items():
            resource.setrlimit(which, pair)


def _end_with(parent: int) -> None:
    """End this process and what it started when its parent ends: nobody would collect what it does."""
    while os.getppid() == parent:
        time.sleep(_LOOK_EVERY)
    os.killpg(0, signal.SIGKILL)


def main() -> None:
    """Serve the connection whose file descriptor is the first argument, for the parent that is the second."""
    # Ctrl-C is for the one that started this, which ends it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(int(sys.argv[2]),), daemon=True).start()
    connection: Connection[Any, Any] = Connection(int(sys.argv[1]))
    os.register_at_fork(after_in_child=connection.close)  # whose end is that of this process alone
    _serve(connection)


if __name__ == "__main__":
    main()
