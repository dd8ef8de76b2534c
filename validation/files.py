"""Files and folders: written whole or not at all, kept through a loss of power, refusals said in words."""

from __future__ import annotations

import contextlib
import contextvars
import errno
import functools
import hashlib
import json
import os
import re
import shutil
import socket
import stat
import tempfile
import time
import uuid
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from validation.errors import RunFailed, UsageError, say_once

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

#: Bytes below which a disk counts as full when a library cannot say why it failed.
_NOTHING_LEFT = 64 * 1024
#: A draft that nobody has written to for so long is nobody's, whichever machine began it [s].
_ABANDONED = 24 * 3600.0
#: Largest record of what a folder is a run of; a scene takes kilobytes.
_MOST_RECORD = 2**24
_DRAFT = re.compile(r"\.([0-9a-f]{8})-(\d{1,9})-[0-9a-f]{12}-")


def prepare_folder(folder: Path, *, option: str = "--output") -> Path:
    """Create a results folder, prove that it can be written to, and clear it of the drafts of the dead.

    A UsageError where it cannot, in which `option` is what the user named it by.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise UsageError(
            f"{option} = {str(folder)!r}: cannot be written to ({error.strerror}); name another folder"
        ) from None
    for place in (folder, folder / "figures"):
        remove_drafts(place)
    return folder


#: Folders that this thread holds, which it may enter again.
_HELD: contextvars.ContextVar[frozenset[Path]] = contextvars.ContextVar("held", default=frozenset())
#: How long another process may write into a folder before who waits gives up [s].
_PATIENCE = 120.0


@contextlib.contextmanager
def locked(folder: Path, *, shared: bool = False) -> Iterator[None]:
    """Hold a results folder while dataset, record and page are written, or `shared` while they are read.

    The system forgets the lock with the process. A folder that is not there, or whose file system has no
    locks, is entered without, as all are on Windows, which is said once; a RunFailed where another process
    writes there for minutes.
    """
    place = Path(os.path.realpath(folder))
    if fcntl is None:
        say_once("no locks on this system: start one run at a time into a folder")
    if fcntl is None or place in _HELD.get():
        yield
        return
    with contextlib.ExitStack() as stack:
        kind, end = fcntl.LOCK_SH if shared else fcntl.LOCK_EX, time.monotonic() + _PATIENCE
        with contextlib.suppress(OSError):
            handle = os.open(place, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
            stack.callback(os.close, handle)
            while True:
                try:
                    fcntl.flock(handle, kind | fcntl.LOCK_NB)
                    break
                except BlockingIOError:
                    if time.monotonic() > end:
                        raise RunFailed(
                            f"{folder}: another run is writing there; wait for it, or name another folder"
                        ) from None
                    time.sleep(0.05)
        token = _HELD.set(_HELD.get() | {place})
        try:
            yield
        finally:
            _HELD.reset(token)


@contextlib.contextmanager
def atomic_path(path: Path, *, synced: bool = False, first: bool = False) -> Iterator[Path]:
    """Yield a temporary path beside `path` that takes its name only when the block ends well.

    The bytes are on the disk before the name is, so that a loss of power leaves the old file or the new one;
    a block may have `synced` them itself, whose caller syncs the folder when it suits it. It replaces what
    has the name, unless the `first` is to stay.

    A RunFailed when the system refuses it: a full disk, a folder that is gone; finished files are untouched.
    """
    draft = _draft_of(path)
    try:
        yield draft
        if not synced:
            _sync(draft)
        _name(draft, path) if first else os.replace(draft, path)
        if not synced:
            sync_folder(path.parent)
    except OSError as error:
        raise RunFailed(refusal(path, error)) from error
    except RuntimeError:
        # The netCDF library says "HDF error" for whatever the system refused it.
        if not _is_full(path.parent):
            raise
        full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        raise RunFailed(refusal(path, full)) from full
    finally:
        with contextlib.suppress(OSError):
            draft.unlink()


def _name(draft: Path, path: Path) -> None:
    try:
        os.link(draft, path)
    except OSError:
        if not path.is_file():  # a file system without hard links
            os.replace(draft, path)


_FLAGS = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0)


def write_whole(path: Path, parts: tuple[bytes | memoryview, ...], *, first: bool = False) -> None:
    """Write a file from its parts as `atomic_path` does; the caller syncs the folder."""
    with atomic_path(path, synced=True, first=first) as draft:
        handle = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _FLAGS, 0o666)
        try:
            for part in parts:
                left = memoryview(part).cast("B")
                while left:
                    left = left[os.write(handle, left) :]
            os.fsync(handle)
        finally:
            os.close(handle)


def read_whole(path: Path, *, most: int | None = None) -> bytes:
    """Return the bytes of a regular file; a link, a pipe, or more than `most` bytes are an OSError."""
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | _FLAGS)
    try:
        facts = os.fstat(handle)
        if not stat.S_ISREG(facts.st_mode):
            raise OSError(errno.EINVAL, "not a regular file")
        if most is not None and facts.st_size > most:
            raise OSError(errno.EFBIG, f"{facts.st_size} bytes long; at most {most} are read")
        with open(handle, "rb", closefd=False) as file:
            return file.read()
    finally:
        os.close(handle)


def available_memory() -> int:
    """Bytes that may be taken on this machine: nine tenths of what is free now."""
    import psutil

    return int(0.9 * psutil.virtual_memory().available)


def digest_of(path: Path) -> str:
    """Return the SHA-256 of a regular file."""
    return hashlib.sha256(read_whole(path)).hexdigest()


def sync_folder(folder: Path) -> None:
    """Have the disk keep the names of a folder; where a file system cannot, it is left to it."""
    with contextlib.suppress(OSError):
        _sync(folder)


def write_json(path: Path, values: Mapping[str, Any]) -> Path:
    """Write values as JSON for people and scripts, atomically; return the path."""
    with atomic_path(path) as draft:
        draft.write_text(json.dumps(values, indent=2) + "\n", encoding="utf-8")
    return path


def write_record(path: Path, values: Mapping[str, Any]) -> Path:
    """Write values as `write_json` does, with a SHA-256 of them as last key, for `read_record`."""
    return write_json(path, {**values, _DIGEST: _digest(values)})


def read_record(path: Path) -> dict[str, Any]:
    """Return the values that `write_record` wrote.

    An OSError where it cannot be read, is no file, or is larger than any record; a ValueError where it is not
    what was written, by damage or by hand.
    """
    try:
        values = json.loads(read_whole(path, most=_MOST_RECORD))
    except RecursionError:
        raise ValueError(f"{path.name} is nested too deep") from None
    except ValueError as error:
        raise ValueError(f"{path.name} is not what was written ({error})") from None
    digest = values.pop(_DIGEST, None) if isinstance(values, dict) else None
    if digest is None or digest != _digest(values):
        raise ValueError(f"{path.name} is not what was written (SHA-256)")
    return dict(values)


_DIGEST = "sha256"


def _digest(values: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()


def remove_drafts(folder: Path, *, of: int | None = None) -> None:
    """Remove what killed processes of this machine left half-written: one known to be dead (`of`), or any.

    A folder that cannot be read or written to is left alone.
    """
    import psutil

    with contextlib.suppress(OSError):
        for entry in os.scandir(folder):
            draft = _DRAFT.match(entry.name)
            if draft is None or not entry.is_file(follow_symlinks=False):
                continue
            process = int(draft[2])
            with contextlib.suppress(OSError):
                dead = process == of if of is not None else not psutil.pid_exists(process)
                here = draft[1] == _place()
                if (here and dead) or time.time() - entry.stat(follow_symlinks=False).st_mtime > _ABANDONED:
                    os.unlink(entry.path)


#: What a refusal of the system means, and what to do.
_REMEDIES = {
    errno.EFBIG: "larger than files may be here (ulimit -f)",
    errno.EMFILE: "too many open files (ulimit -n)",
    errno.ENFILE: "too many open files on this machine",
    errno.EROFS: "the file system is read-only; name another folder",
    errno.EACCES: "permission denied; ask its owner, or name another folder",
    errno.EPERM: "not permitted; ask its owner, or name another folder",
    errno.EISDIR: "a folder has this name; move it away",
    errno.ENOTDIR: "a part of its path is a file; name another folder",
    errno.EIO: "the disk failed (Input/output error); look at it before you go on",
    errno.ENAMETOOLONG: "its name is too long for this file system",
    errno.ENOMEM: "memory does not suffice (ulimit -v, --memory)",
    errno.EAGAIN: "no further process or thread is allowed (ulimit -u)",
}


def reason(error: OSError) -> str:
    """Say in words what the system refused."""
    return _REMEDIES.get(error.errno or 0, error.strerror or str(error))


def system_words(error: OSError) -> str:
    """Say in words what the system refused, with the file, if it is one."""
    return f"{error.filename}: {reason(error)}" if isinstance(error.filename, str) else reason(error)


def refusal(path: Path, error: OSError) -> str:
    """Say in one line why a file was not written, and what to do."""
    finished = "finished solves are intact"
    if error.errno == errno.ENOENT and not path.parent.exists():
        return (
            f"{path.parent}: is gone, removed or unmounted; {path.name} was not written; the same command "
            "makes the folder again"
        )
    if error.errno == errno.EDQUOT:
        return f"the disk is full: {path.name} was not written, your quota is used up; {finished}"
    if error.errno == errno.ENOSPC or (error.errno in (errno.EACCES, None) and _is_full(path.parent)):
        with contextlib.suppress(OSError, AttributeError):
            space = os.statvfs(path.parent)
            if space.f_files > 0 and space.f_favail == 0:
                return (
                    f"the disk takes no more files, its inodes are used up: {path.name} was not written; "
                    f"{finished}; remove files or name another folder"
                )
        return f"the disk is full: {path.name} was not written; {finished}"
    return f"{path}: not written: {reason(error)}; {finished}"


def _is_full(folder: Path) -> bool:
    with contextlib.suppress(OSError):
        return shutil.disk_usage(folder).free < _NOTHING_LEFT
    return False


def _draft_of(path: Path) -> Path:
    """Return a name that no other process takes, in this container or another one, today or ever."""
    # The end of a long name is kept: libraries choose a format by the suffix.
    return path.with_name(f".{_place()}-{os.getpid()}-{uuid.uuid4().hex[:12]}-{path.name[-160:]}")


@functools.cache
def _place() -> str:
    """Name the space in which a process number means one process: a boot of a machine, a container in it."""
    marks = [socket.gethostname()]
    with contextlib.suppress(OSError):
        marks.append(Path("/proc/sys/kernel/random/boot_id").read_text())
    with contextlib.suppress(OSError):
        marks.append(os.readlink("/proc/self/ns/pid"))
    return hashlib.sha256("\n".join(marks).encode()).hexdigest()[:8]


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
