"""Files and folders: written atomically, drafts of killed processes removed, a full disk said in words."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import re
import shutil
import socket
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from validation.errors import RunFailed, UsageError

__all__ = ["atomic_path", "json_text", "prepare_folder", "remove_drafts", "write_json"]

#: Bytes below which a disk counts as full when a library cannot say why it failed.
_NOTHING_LEFT = 64 * 1024


def prepare_folder(folder: Path, *, option: str = "--output") -> Path:
    """Create a results folder and prove that it can be written to.

    Parameters
    ----------
    folder : Path
    option : str
        What the user named it by, for the message.

    Raises
    ------
    UsageError
        When it cannot.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise UsageError(
            f"{option} = {str(folder)!r}: cannot be written to ({error.strerror}); name another folder"
        ) from None
    return folder


@contextlib.contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """Yield a temporary path beside `path` that takes its name only when the block ends well.

    Raises
    ------
    RunFailed
        When the disk is full; finished files are untouched.
    """
    draft = path.with_name(f".{socket.gethostname()}-{os.getpid()}-{path.name}")
    try:
        yield draft
        os.replace(draft, path)
    except (OSError, RuntimeError) as error:
        # The netCDF library says "HDF error" for whatever the system refused it.
        numbers = (errno.ENOSPC, errno.EDQUOT)
        if getattr(error, "errno", None) in numbers or shutil.disk_usage(path.parent).free < _NOTHING_LEFT:
            raise RunFailed(
                f"the disk is full: {path.name} was not written; finished solves are intact"
            ) from None
        raise
    finally:
        draft.unlink(missing_ok=True)


def write_json(path: Path, values: Mapping[str, Any]) -> Path:
    """Write values as JSON for people and scripts, atomically; return the path."""
    with atomic_path(path) as draft:
        draft.write_text(json_text(values), encoding="utf-8")
    return path


def json_text(values: Mapping[str, Any]) -> str:
    """Return values as JSON as `write_json` writes them."""
    return json.dumps(values, indent=2) + "\n"


def remove_drafts(folder: Path, *, of: int | None = None) -> None:
    """Remove what killed processes of this machine left half-written.

    Parameters
    ----------
    folder : Path
    of : int, optional
        Process whose drafts are meant, known to be dead; all that no longer run if not given.
    """
    name = re.compile(rf"\..*\b{re.escape(socket.gethostname())}-(\d+)-")
    for path in folder.glob(".*"):
        found = name.match("." + path.name)
        if found and (int(found[1]) == of if of is not None else not _runs(int(found[1]))):
            path.unlink(missing_ok=True)


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
