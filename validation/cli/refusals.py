"""What the machine refuses a command, said in one line: memory, open files, a full output."""

from __future__ import annotations

import contextlib
import errno
import os
import sys
from collections.abc import Iterator

from validation.cli.options import say
from validation.files import system_words

_STORED = "every finished solve is stored, and the same command continues after it"
#: Address space that numba, OpenBLAS and the interpreter take before a surface is made [bytes].
_LEAST = 2**30
_MEMORY = f"memory does not suffice (ulimit -v, smaller grids, fewer --workers); {_STORED}"


@contextlib.contextmanager
def refusals_in_words() -> Iterator[None]:
    """Turn a refusal of the system into a sentence and exit code 1."""
    _refuse_too_little()
    try:
        try:
            yield
        finally:
            if sys.stdout is not None:  # closed by who started the command: >&-
                sys.stdout.flush()
    except MemoryError:
        _end(_MEMORY)
    except ImportError as error:
        # A library that finds no room to be loaded; one that is missing is another matter.
        words = ("cannot allocate memory", "failed to map segment", "cannot create shared object")
        if isinstance(error, ModuleNotFoundError) or not any(word in str(error).lower() for word in words):
            raise
        _end(_MEMORY)
    except OSError as error:
        if error.errno == errno.ENOMEM:
            _end(_MEMORY)
        if error.errno in (errno.ENOSPC, errno.EPIPE, errno.EIO, errno.EDQUOT) and error.filename is None:
            _end(f"the output cannot be written ({error.strerror})")
        _end(f"{system_words(error)}; {_STORED}")
    except RuntimeError as error:
        if "can't start new thread" not in str(error):
            raise
        _end(f"no further thread can be started (ulimit -u, ulimit -v); {_STORED}")


def _refuse_too_little() -> None:
    """Refuse a limit of memory under which libraries abort the process with words of their own."""
    try:
        import resource
    except ImportError:  # Windows
        return
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit != resource.RLIM_INFINITY and limit < _LEAST:
        say(f"ulimit -v = {limit // 1024}: the libraries alone take more; allow {_LEAST // 1024} or more")
        sys.exit(2)


def _end(words: str) -> None:
    with contextlib.suppress(OSError):
        say(words)
    # Nothing of what could not be written is tried again when the interpreter ends.
    null = os.open(os.devnull, os.O_WRONLY)
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(null, sys.stdout.fileno())
    sys.exit(1)
