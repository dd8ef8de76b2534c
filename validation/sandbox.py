"""Functions run in a child process, within bounds of time and memory where nobody vouches for them.

A library of formats that meets a damaged file may loop for ever, take all memory or crash; none of that can
be caught in the process itself. The child is a fresh interpreter that serves one call after another in a
process group of its own, which is ended where a call breaks its bounds. Of what comes back nothing is
unpickled: it is JSON and arrays of numbers.
"""

from __future__ import annotations

import atexit
import builtins
import contextlib
import importlib
import json
import math
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection, Pipe
from types import TracebackType
from typing import IO, Any, Self

import numpy as np

from validation import errors

__all__ = ["ONE_THREAD", "Child", "OutOfBounds", "call", "end"]

_Arrays = list[np.ndarray[Any, Any]]

#: What makes the numerical libraries of a new process use one thread.
ONE_THREAD = dict.fromkeys(
    (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "NUMBA_NUM_THREADS",
        "VECLIB_MAXIMUM_THREADS",
    ),
    "1",
)
#: What an interpreter may take to start and to import a function [s]; a loaded machine needs many.
_START_SECONDS = 120.0
#: Most bytes of one message that is no array.
_MOST_WORDS = 2**26
#: Processor time beyond the time of a call after which the system ends a child whose parent is gone [s].
_GRACE_SECONDS = 5.0
#: How often a child looks whether its parent lives [s].
_LOOK_EVERY = 0.2


class OutOfBounds(Exception):
    """A call that took more time or memory than it was given, or whose process crashed."""


class Child:
    """A child process, started by the first call and anew after one that was ended.

    Parameters
    ----------
    stderr : file or int
        Where its standard error goes, as `subprocess` has it.

    Examples
    --------
    >>> import math
    >>> with Child() as child:
    ...     child.call(math.gcd, 12, 18, seconds=10)
    6
    """

    def __init__(self, *, stderr: IO[bytes] | int = subprocess.DEVNULL) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: Connection[Any, Any] | None = None
        self._stderr = stderr
        self._owner = os.getpid()
        #: Of the process that was started last.
        self.pid = 0

    def call(
        self,
        function: Callable[..., Any],
        *arguments: Any,
        seconds: float = math.inf,
        memory: int | None = None,
        most_bytes: int = 2**31,
    ) -> Any:
        """Return what a function returns, computed in the child.

        Parameters
        ----------
        function : callable
            Found by module and name.
        *arguments
            None, booleans, numbers, text, arrays of real numbers, and lists and dictionaries of them.
        seconds : float
            Wall-clock time the function may take; that of importing it is not counted.
        memory : int, optional
            Bytes of address space it may take beyond those of the idle child. Held on Linux; elsewhere time
            alone is bounded.
        most_bytes : int
            Size of an array that is taken back.

        Returns
        -------
        object
            As `arguments`; arrays are read-only.

        Raises
        ------
        OutOfBounds
            When it took more, or crashed.
        OSError
            When no process can be started.
        Exception
            What the function raised, if it is built in or one of :mod:`validation.errors`; a RuntimeError
            that names it otherwise.
        """
        with self._lock:
            self.start()
            try:
                reply, arrays = self._ask(function, arguments, seconds, memory, most_bytes)
            except BaseException:
                self._end()
                raise
            if "memory" in reply:
                self._end()
                raise OutOfBounds(f"took more than {_words(memory)} of memory")
        if "raised" in reply:
            raise _raised(*reply["raised"])
        return _decoded(reply["value"], arrays)

    def start(self) -> None:
        """Start the process, unless it runs.

        Raises
        ------
        OSError
            When the system starts none.
        """
        if self._owner != os.getpid():  # after a fork the child belongs to the parent
            self._process = self._connection = None
            self._owner = os.getpid()
        # An idle child says nothing; what can be read is the end of one that is gone.
        if self._connection is not None and not self._connection.poll():
            return
        self._end()
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
        process = self._process
        if process is not None and process.returncode is None:
            with contextlib.suppress(OSError):
                os.killpg(process.pid, signal.SIGKILL)

    def close(self) -> None:
        """End the process."""
        with self._lock:
            if self._owner == os.getpid():
                self._end()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _ask(
        self,
        function: Callable[..., Any],
        arguments: tuple[Any, ...],
        seconds: float,
        memory: int | None,
        most_bytes: int,
    ) -> tuple[dict[str, Any], _Arrays]:
        connection, late = self._connection, threading.Event()
        assert connection is not None
        arrays: _Arrays = []
        request = {
            "function": [function.__module__, function.__qualname__],
            "arguments": [_encoded(argument, arrays) for argument in arguments],
            "seconds": seconds,
            "memory": memory,
        }
        limit = _START_SECONDS
        try:
            with self._ended_after(limit, late):
                _send(connection, request, arrays)
                connection.recv_bytes(_MOST_WORDS)  # it is imported
            limit = seconds
            with self._ended_after(limit, late):
                return _received(connection, most_bytes)
        except (EOFError, ConnectionError):
            if late.is_set():
                raise OutOfBounds(f"took more than {limit:.3g} s") from None
            raise OutOfBounds(f"crashed its process ({_ending(self._end())})") from None
        except OSError:
            raise OutOfBounds(f"gave back more than {_words(most_bytes)}") from None

    @contextlib.contextmanager
    def _ended_after(self, seconds: float, late: threading.Event) -> Iterator[None]:
        """End the child when a time is over, which whoever waits for it sees as the end of the file."""
        if math.isinf(seconds):
            yield
            return

        def end() -> None:
            late.set()
            self.kill()

        timer = threading.Timer(seconds, end)
        timer.daemon = True
        timer.start()
        try:
            yield
        finally:
            timer.cancel()

    def _end(self) -> int:
        """End the process; return how it ended."""
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
end = _SHARED.close
atexit.register(end)


def call(
    function: Callable[..., Any],
    *arguments: Any,
    **bounds: Any,
) -> Any:
    """Call a function in the child process that all share; see :meth:`Child.call`."""
    return _SHARED.call(function, *arguments, **bounds)


def _words(size: int | None) -> str:
    return f"{(size or 0) / 2**20:.4g} MiB"


def _ending(code: int) -> str:
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"exit status {code}"


def _raised(name: str, arguments: list[Any]) -> Exception:
    """Return the exception that the child names; only harmless classes are made."""
    for home in (builtins, errors):
        kind = getattr(home, name, None)
        if isinstance(kind, type) and issubclass(kind, Exception):
            with contextlib.suppress(TypeError):
                return kind(*arguments)
    return RuntimeError(f"{name}: {' '.join(map(str, arguments))}")


def _encoded(value: Any, arrays: list[np.ndarray[Any, Any]]) -> Any:
    """Return a value as JSON has it, with arrays replaced by their number."""
    if isinstance(value, np.ndarray):
        if type(value) is not np.ndarray or value.dtype.kind not in "biuf":
            raise TypeError(f"a {type(value).__name__} of {value.dtype} does not travel")
        arrays.append(np.ascontiguousarray(value))
        return {"array": len(arrays) - 1}
    if isinstance(value, dict):
        return {"table": [[str(key), _encoded(inner, arrays)] for key, inner in value.items()]}
    if isinstance(value, (list, tuple)):
        return [_encoded(inner, arrays) for inner in value]
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise TypeError(f"a {type(value).__name__} does not travel")


def _decoded(value: Any, arrays: list[np.ndarray[Any, Any]]) -> Any:
    if isinstance(value, dict):
        if "array" in value:
            return arrays[value["array"]]
        return {key: _decoded(inner, arrays) for key, inner in value["table"]}
    return [_decoded(inner, arrays) for inner in value] if isinstance(value, list) else value


def _send(connection: Connection[Any, Any], message: dict[str, Any], arrays: _Arrays) -> None:
    about = {**message, "arrays": [[array.dtype.str, array.shape] for array in arrays]}
    connection.send_bytes(json.dumps(about).encode())
    for array in arrays:
        connection.send_bytes(array.reshape(-1).view(np.uint8).data)


def _received(connection: Connection[Any, Any], most_bytes: int | None) -> tuple[dict[str, Any], _Arrays]:
    message = json.loads(connection.recv_bytes(_MOST_WORDS))
    return message, [
        np.frombuffer(connection.recv_bytes(most_bytes), dtype=kind).reshape(shape)
        for kind, shape in message["arrays"]
    ]


def _serve(connection: Connection[Any, Any]) -> None:
    """Answer calls until the other end is closed."""
    while True:
        try:
            request, arrays = _received(connection, None)
        except EOFError:
            return
        _send(connection, *_answer(connection, request, arrays))


def _answer(
    connection: Connection[Any, Any], request: dict[str, Any], given: _Arrays
) -> tuple[dict[str, Any], _Arrays]:
    arrays: _Arrays = []
    home, name = request["function"]
    try:
        function: Any = importlib.import_module(home)
        for part in name.split("."):
            function = getattr(function, part)
    except Exception as error:
        return {"raised": [type(error).__name__, [str(error)]]}, []
    finally:
        connection.send_bytes(b"imported")
    try:
        with _limited(request["seconds"], request["memory"]):
            arguments = [_decoded(argument, given) for argument in request["arguments"]]
            return {"value": _encoded(function(*arguments), arrays)}, arrays
    except MemoryError:
        return {"memory": True}, []
    except Exception as error:
        said = error.args if all(isinstance(a, (int, str)) for a in error.args) else (str(error),)
        return {"raised": [type(error).__name__, list(said)]}, []


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

    def look() -> None:
        while os.getppid() == parent:
            time.sleep(_LOOK_EVERY)
        os.killpg(0, signal.SIGKILL)

    threading.Thread(target=look, daemon=True).start()


def main() -> None:
    """Serve the connection whose file descriptor is the first argument, for the parent that is the second."""
    # Ctrl-C is for the one that started this, which ends it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _end_with(int(sys.argv[2]))
    _serve(Connection(int(sys.argv[1])))


if __name__ == "__main__":
    main()
