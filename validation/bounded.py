"""Functions run in a child process within bounds of time and memory, for bytes that nobody vouches for.

A library of formats that meets a damaged file may loop for ever, take all memory or crash; none of that can
be caught in the process itself. The child is a fresh interpreter that serves one call after another, and is
ended where a call breaks its bounds. Nothing is unpickled: what comes back is JSON and arrays of numbers.
"""

from __future__ import annotations

import atexit
import builtins
import contextlib
import importlib
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection, Pipe
from types import TracebackType
from typing import Any, Self

import numpy as np

from validation import errors

__all__ = ["Child", "OutOfBounds", "call", "end"]

#: What an interpreter may take to start and to import a function [s]; a loaded machine needs many.
_START_SECONDS = 120.0
#: Most bytes of one message that is no array.
_MOST_WORDS = 2**26
#: Processor time beyond the time of a call after which the system ends a child whose parent is gone [s].
_GRACE_SECONDS = 5.0


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
        self._owner = os.getpid()

    def call(
        self,
        function: Callable[..., Any],
        *arguments: Any,
        seconds: float,
        memory: int | None = None,
        most_bytes: int = 2**31,
    ) -> Any:
        """Return what a function returns, computed in the child.

        Parameters
        ----------
        function : callable
            Found by module and name.
        *arguments
            None, booleans, numbers, text, and lists and dictionaries of them.
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
            As `arguments`, or arrays of real numbers among them, which are read-only.

        Raises
        ------
        OutOfBounds
            When it took more, or crashed.
        Exception
            What the function raised, if it is built in or one of :mod:`validation.errors`; a RuntimeError
            that names it otherwise.
        """
        with self._lock:
            if self._owner != os.getpid():  # after a fork the child belongs to the parent
                self._process = self._connection = None
                self._owner = os.getpid()
            connection = self._started()
            try:
                reply, arrays = self._ask(connection, function, arguments, (seconds, memory, most_bytes))
            except BaseException:
                self._end()
                raise
            if "memory" in reply:
                self._end()
                raise OutOfBounds(f"took more than {_words(memory)} of memory")
        if "raised" in reply:
            raise _raised(*reply["raised"])
        return _decoded(reply["value"], arrays)

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
        connection: Connection[Any, Any],
        function: Callable[..., Any],
        arguments: tuple[Any, ...],
        bounds: tuple[float, int | None, int],
    ) -> tuple[dict[str, Any], list[np.ndarray[Any, Any]]]:
        seconds, memory, most_bytes = bounds
        request = {
            "function": [function.__module__, function.__qualname__],
            "arguments": arguments,
            "seconds": seconds,
            "memory": memory,
        }
        with self._ended_after(_START_SECONDS) as late:
            connection.send_bytes(json.dumps(request).encode())
            self._received(connection, late, _START_SECONDS, most=_MOST_WORDS)
        with self._ended_after(seconds) as late:
            reply = json.loads(self._received(connection, late, seconds, most=_MOST_WORDS))
            arrays = []
            for kind, shape in reply.get("arrays", ()):
                raw = self._received(connection, late, seconds, most=most_bytes)
                arrays.append(np.frombuffer(raw, dtype=kind).reshape(shape))
        return reply, arrays

    def _received(
        self, connection: Connection[Any, Any], late: threading.Event, seconds: float, *, most: int
    ) -> bytes:
        try:
            return connection.recv_bytes(most)
        except EOFError:
            if late.is_set():
                raise OutOfBounds(f"took more than {seconds:.3g} s") from None
            assert self._process is not None
            raise OutOfBounds(f"crashed its process ({_ending(self._process)})") from None
        except OSError:
            raise OutOfBounds(f"gave back more than {_words(most)}") from None

    @contextlib.contextmanager
    def _ended_after(self, seconds: float) -> Iterator[threading.Event]:
        """End the child when a time is over, which whoever waits for it sees as the end of the file."""
        process, late = self._process, threading.Event()
        assert process is not None

        def end() -> None:
            late.set()
            process.kill()

        timer = threading.Timer(seconds, end)
        timer.daemon = True
        timer.start()
        try:
            yield late
        finally:
            timer.cancel()

    def _started(self) -> Connection[Any, Any]:
        if self._process is not None and self._connection is not None and self._process.poll() is None:
            return self._connection
        self._end()
        ours, theirs = Pipe()
        path = os.pathsep.join(entry for entry in sys.path if entry)
        one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "validation.bounded", str(theirs.fileno())],
            pass_fds=(theirs.fileno(),),
            env={**os.environ, **one_thread, "PYTHONPATH": path},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        theirs.close()
        self._connection = ours
        return ours

    def _end(self) -> None:
        if self._connection is not None:
            self._connection.close()
        if self._process is not None:
            self._process.kill()
            self._process.wait()
        self._process = self._connection = None


#: One child for a whole process, since an interpreter takes a third of a second to start.
_SHARED = Child()
end = _SHARED.close
atexit.register(end)


def call(
    function: Callable[..., Any],
    *arguments: Any,
    seconds: float,
    memory: int | None = None,
    most_bytes: int = 2**31,
) -> Any:
    """Call a function in the child process that all share; see :meth:`Child.call`."""
    return _SHARED.call(function, *arguments, seconds=seconds, memory=memory, most_bytes=most_bytes)


def _words(size: int | None) -> str:
    return f"{(size or 0) / 2**20:.4g} MiB"


def _ending(process: subprocess.Popen[bytes]) -> str:
    code = process.wait()
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


def _serve(connection: Connection[Any, Any]) -> None:
    """Answer calls until the other end is closed."""
    while True:
        try:
            request = json.loads(connection.recv_bytes())
        except EOFError:
            return
        reply, arrays = _answer(connection, request)
        connection.send_bytes(json.dumps(reply).encode())
        for array in arrays:
            connection.send_bytes(array.reshape(-1).view(np.uint8).data)


def _answer(
    connection: Connection[Any, Any], request: dict[str, Any]
) -> tuple[dict[str, Any], list[np.ndarray[Any, Any]]]:
    arrays: list[np.ndarray[Any, Any]] = []
    home, name = request["function"]
    try:
        function: Any = importlib.import_module(home)
        for part in name.split("."):
            function = getattr(function, part)
    except Exception as error:
        connection.send_bytes(b"started")
        return {"raised": [type(error).__name__, [str(error)]]}, []
    connection.send_bytes(b"started")
    try:
        with _limited(request["seconds"], request["memory"]):
            value = _encoded(function(*request["arguments"]), arrays)
    except MemoryError:
        return {"memory": True}, []
    except Exception as error:
        said = error.args if all(isinstance(a, (int, str)) for a in error.args) else (str(error),)
        return {"raised": [type(error).__name__, list(said)]}, []
    return {"value": value, "arrays": [[a.dtype.str, a.shape] for a in arrays]}, arrays


@contextlib.contextmanager
def _limited(seconds: float, memory: int | None) -> Iterator[None]:
    """Have the system hold the bounds of a call, where it can."""
    try:
        import resource
    except ImportError:  # Windows
        yield
        return
    used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    limits = {resource.RLIMIT_CPU: int(used + seconds + _GRACE_SECONDS)}
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


def main() -> None:
    """Serve the connection whose file descriptor is the first argument."""
    # Ctrl-C reaches every process of the terminal; the one that started this ends it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _serve(Connection(int(sys.argv[1])))


if __name__ == "__main__":
    main()
