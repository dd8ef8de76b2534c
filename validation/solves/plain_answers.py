"""A Dask client that takes plain data from its scheduler, and runs nothing that it sends.

Dask's protocol lets a scheduler send a client pickles, which are programs: an address that was mistyped, or
that a stranger named, would run what it likes with the user's rights. While this is on, a pickle is taken
apart for plain data and exceptions alone; anything else in it becomes an inert `Refused`.
"""

from __future__ import annotations

import builtins
import contextlib
import io
import pickle
import types
from collections.abc import Iterator
from typing import Any

__all__ = ["Refused", "plain_answers", "plain_loads"]

#: Builtin classes that hold data and do nothing.
_PLAIN = frozenset(
    {"set", "frozenset", "bytearray", "complex", "dict", "list", "tuple", "str", "int", "float"}
)


class Refused(Exception):
    """What stands for an object that would have had to be run to be made."""

    def __setstate__(self, state: object) -> None:
        """Take no state."""


class _PlainUnpickler(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:
        if module == "builtins" and "." not in name:
            found = getattr(builtins, name, None)
            if name in _PLAIN or (isinstance(found, type) and issubclass(found, Exception)):
                return found
        # A class of its own, so that the name can be told.
        return type(name.rpartition(".")[2] or "Refused", (Refused,), {})

    def persistent_load(self, pid: object) -> Any:
        return Refused(str(pid))


def plain_loads(data: Any, *, buffers: Any = ()) -> Any:
    """Unpickle plain data and builtin exceptions; everything else is an inert `Refused`."""
    return _PlainUnpickler(io.BytesIO(bytes(data)), buffers=buffers).load()


@contextlib.contextmanager
def plain_answers() -> Iterator[None]:
    """Have Dask unpickle plain data alone in this process.

    Left off where this process has a scheduler or another client: they are the user's own, and need more.
    """
    import distributed
    import distributed.client
    import distributed.protocol.pickle as protocol

    others = [client for client in distributed.Client._instances if client.status != "closed"]
    own = [one for one in distributed.Scheduler._instances if one.status.name not in ("closed", "failed")]
    if others or own:
        yield
        return
    module: Any = distributed.client
    before = protocol.loads, getattr(module, "loads", None), getattr(module, "pickle", None)
    protocol.loads = module.loads = plain_loads
    # Warnings that workers forward are unpickled by the standard module.
    module.pickle = types.SimpleNamespace(**{**vars(pickle), "loads": plain_loads})
    try:
        yield
    finally:
        protocol.loads, module.loads, module.pickle = before
