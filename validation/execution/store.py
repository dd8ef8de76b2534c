"""Results on disk: one sealed file for each finished solve, written whole, verified when read.

A sealed file is the bytes of a netCDF file, one line of JSON that says what it is a result of and how it was
made, and a last line ``sha256`` with the digest of every byte before it. netCDF readers know where their data
end and do not see the two lines. Nothing is parsed before the digest is found right: what a flipped bit, a
lost block or a cut end would make of it is never asked, and reading takes the time of one pass over them.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.errors import RunFailed, UsageError
from validation.execution.provenance import Made
from validation.execution.solve import Solve
from validation.files import available_memory, read_whole, reason, write_whole
from validation.netcdf import dataset_bytes, read_dataset

if TYPE_CHECKING:
    import xarray as xr

_SUFFIX = ".nc"
_ASIDE = ".nc.corrupt"
_WORD = b"sha256 "
_FOOT = len(_WORD) + 64 + 1


class Damaged(Exception):
    """Bytes that are not those that were written; says how it shows."""


@dataclass(frozen=True, kw_only=True)
class Sealed:
    """The netCDF file in a sealed file that is intact, `Solve.recipe_text`, and how it was made, as JSON."""

    content: memoryview
    recipe: str
    made: Mapping[str, Any]


def seal(content: bytes | memoryview, *, recipe: str, made: Mapping[str, Any]) -> bytes:
    """Return the two lines that go behind the content."""
    line = b"\n" + json.dumps({"recipe": recipe, "made": dict(made)}).encode() + b"\n"
    digest = hashlib.sha256(content)
    digest.update(line)
    return line + _WORD + digest.hexdigest().encode() + b"\n"


def unseal(data: bytes) -> Sealed:
    """Return what a sealed file holds; `Damaged` where any byte of it is not the one that was written."""
    view = memoryview(data)
    body, foot = view[:-_FOOT], bytes(view[-_FOOT:])
    if len(data) <= _FOOT or not foot.startswith(_WORD) or not foot.endswith(b"\n"):
        raise Damaged("no digest at its end: it was cut off, or written by an earlier version")
    if foot != _WORD + hashlib.sha256(body).hexdigest().encode() + b"\n":
        raise Damaged("its bytes are not those that were written (SHA-256)")
    start = data.rfind(b"\n", 0, len(body) - 1)
    return Sealed(content=body[:start], **json.loads(bytes(body[start + 1 :])))


@dataclass(frozen=True, kw_only=True, eq=False)
class Stored:
    """A verified result, how it was made, and the size of its file in bytes."""

    made: Made
    size: int
    decode: Callable[[], Any]

    @cached_property
    def result(self) -> Any:
        """The result itself, decoded when it is first asked for; RunFailed where it cannot be."""
        return self.decode()


@dataclass(frozen=True, kw_only=True)
class Store:
    """The folder of finished solves; a file is there whole or not at all.

    Who may write to the folder is believed: the seal of a file shows damage and mistakes, not malice.
    """

    folder: Path

    def path(self, solve: Solve) -> Path:
        """Return where the result of a solve is, or will be."""
        return self.folder / f"{solve.key}{_SUFFIX}"

    def save(self, solve: Solve, result: Any, *, made: Made) -> None:
        """Write what `do` returned of a solve, how it was made, and what belongs beside it.

        A RunFailed when the system refuses it: a full disk, a folder that is gone.
        """
        path = self.path(solve)
        if path.is_file():
            return
        solve.written_beside(result, self.folder)
        try:
            content = solve.encode(result)
        except (OSError, RuntimeError) as error:  # in memory, where nothing else can fail it
            raise RunFailed(
                f"{solve.describe()}: memory does not suffice to store it ({error}); name fewer "
                "--workers, or a smaller --memory"
            ) from error
        # The folder is synced by who collects the outcomes: a name lost with the power is a solve to repeat.
        # Another run that was faster may have told its time: the first file stays.
        write_whole(path, (content, seal(content, recipe=solve.recipe_text, made=asdict(made))), first=True)

    def read(self, solve: Solve, *, on_damage: Callable[[str], None] | None = None) -> Stored | None:
        """Read a finished solve and how it was made; None if there is none.

        A file that is damaged, or of another recipe than its name says, is set aside as `*.corrupt`, counts
        as none, and is told to `on_damage` in a sentence.

        A RunFailed for a file that is there and cannot be read: another user's, a link, memory that does not
        suffice. It stays where it is.
        """
        path = self.path(solve)
        try:
            data = _bytes_of(path)
            if data is None:
                return None
            sealed = _verified(path, data)
        except Damaged as damage:
            _set_aside(path, damage, tell=on_damage)
            return None
        made = _understood(path, partial(Made, **sealed.made))
        decode = partial(_understood, path, partial(solve.decode, sealed.content))
        return Stored(decode=decode, made=made, size=len(data))


def _understood(path: Path, read: Callable[[], Any]) -> Any:
    try:
        return read()
    except (MemoryError, OSError) as error:
        raise RunFailed(f"{path}: intact, but memory does not suffice to read it ({error})") from None
    except Exception as error:
        raise RunFailed(
            f"{path}: intact, but not what this version writes ({type(error).__name__}: {error}); name "
            "another store, or move it away"
        ) from error


def write_numbers(path: Path, data: xr.Dataset, *, recipe: Mapping[str, Any]) -> None:
    """Write the numbers of a study or a sweep, sealed: netCDF that shows every change since."""
    content = dataset_bytes(data)
    made = asdict(Made.now(threads=1, seconds=0.0))
    write_whole(path, (content, seal(content, recipe=json.dumps(recipe), made=made)))


def read_numbers(path: Path, decode: Callable[[memoryview], Any] = read_dataset) -> Any:
    """Return the content of a sealed file, verified; RunFailed for none, or a damaged one."""
    try:
        data = _bytes_of(path)
        if data is None:
            raise RunFailed(f"{path}: is not there; run it again")
        return decode(unseal(data).content)
    except Damaged as damage:
        raise RunFailed(f"{path}: damaged: {damage}; run it again") from None


def check_store(folder: Path, *, set_aside: bool) -> Iterator[tuple[Path, int, Sealed | Exception]]:
    """Verify every result in a folder: its digest, and that its name is that of its recipe.

    Yields each file, its bytes, and what is in it, or why not: `Damaged`, or RunFailed where it cannot be
    read. Damaged files may be set aside as `*.corrupt`, as a run does that meets them. A UsageError for a
    folder that cannot be read.
    """
    try:
        names = sorted(os.listdir(folder))
    except OSError as error:
        raise UsageError(f"{folder}: cannot be read ({error.strerror}); name the folder of a store") from None
    for name in names:
        if name.startswith(".") or not name.endswith(_SUFFIX):
            continue
        path, size = folder / name, 0
        try:
            data = _bytes_of(path)
            if data is None:  # removed meanwhile
                continue
            size = len(data)
            yield path, size, _verified(path, data)
        except RunFailed as error:
            yield path, size, error
        except Damaged as damage:
            if set_aside:
                _set_aside(path, damage)
            yield path, size, damage


#: Bytes of a file that is read without asking how much memory is free.
_SURELY_FITS = 2**28

#: Why a file that is there cannot be read, where it is not what the system says of any file.
_UNREADABLE = {
    errno.ELOOP: "is a link, which is not followed in a store; put the file itself there",
    errno.EINVAL: "is not a file; move it away",
    errno.EFBIG: "larger than the memory that is free",
}


def _bytes_of(path: Path) -> bytes | None:
    try:
        return read_whole(path, most=max(_SURELY_FITS, available_memory()))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError as error:
        why = _UNREADABLE.get(error.errno or 0) or reason(error)
        raise RunFailed(f"{path}: cannot be read: {why}") from None
    except MemoryError:
        raise RunFailed(f"{path}: cannot be read: memory does not suffice") from None


def _verified(path: Path, data: bytes) -> Sealed:
    sealed = unseal(data)
    if not path.stem.endswith(f"-{hashlib.sha256(sealed.recipe.encode()).hexdigest()[:16]}"):
        raise Damaged("it is the result of another recipe than its name says")
    return sealed


def _set_aside(path: Path, damage: Damaged, *, tell: Callable[[str], None] | None = None) -> None:
    aside = path.with_name(path.name.removesuffix(_SUFFIX) + _ASIDE)
    words = f"{path}: damaged: {damage}; "
    try:
        with contextlib.suppress(FileNotFoundError):  # another run may have set it aside first
            os.replace(path, aside)
        words += f"set aside as {aside.name}, to be computed again"
    except OSError as error:
        words += f"to be computed again; not set aside ({error.strerror})"
    if tell is not None:
        tell(words)
