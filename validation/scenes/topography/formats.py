"""One file of heights read, whatever its format; run in a child process that is held within bounds."""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Callable
from typing import Any

import numpy as np

from validation.errors import UsageError, harmless
from validation.scenes.topography.arrays import read_npy
from validation.scenes.topography.netcdf import read_netcdf
from validation.scenes.topography.raw import MOST_BYTES, Raw, check_shape, plain_attribute
from validation.scenes.topography.text import read_text
from validation.scenes.topography.x3p import read_x3p

__all__ = ["READERS", "one_line", "read_plain"]

READERS: dict[str, Callable[[bytes], Raw]] = {
    ".npy": read_npy,
    ".txt": read_text,
    ".csv": read_text,
    ".dat": read_text,
    ".asc": read_text,
    ".xyz": read_text,
    ".nc": read_netcdf,
    ".x3p": read_x3p,
}


def read_plain(path: str) -> dict[str, Any]:
    """Return what a file says as plain values and one array; whatever goes wrong is one sentence.

    Raises
    ------
    UsageError
    MemoryError
        Which the bounds turn into a sentence.
    """
    try:
        data = _bytes_of(path)
        reader = READERS.get(os.path.splitext(path)[1].lower())
        raw = _read_other(path) if reader is None else reader(data)
        check_shape(raw.heights.shape)
    except (UsageError, MemoryError):
        raise
    except OSError as error:
        raise UsageError(f"cannot be read: {one_line(error.strerror or error)}") from None
    except Exception as error:  # a reader of damaged bytes raises whatever they lead to
        said = one_line(error) or type(error).__name__
        raise UsageError(f"is no topography of its kind ({said})") from None
    return {
        "heights": np.ascontiguousarray(raw.heights, dtype=float),
        "lengths": None if raw.lengths is None else [float(side) for side in raw.lengths],
        "length_units": raw.length_units,
        "unit": raw.unit,
        "notes": raw.notes,
        "digest": hashlib.sha256(data).hexdigest(),
    }


def one_line(words: object) -> str:
    """Return the first line of a text, shortened, as it is shown."""
    lines = str(words).strip().splitlines()
    return harmless(lines[0][:300]) if lines else ""


def _bytes_of(path: str) -> bytes:
    # A pipe or a device has no end, and opening one may wait for ever.
    facts = os.stat(path)
    if stat.S_ISDIR(facts.st_mode):
        raise IsADirectoryError(21, "Is a directory")
    if not stat.S_ISREG(facts.st_mode):
        raise UsageError("cannot be read: it is a pipe or a device, not a file")
    if facts.st_size > MOST_BYTES:
        raise UsageError(
            f"is {facts.st_size / 2**30:.3g} GiB long; at most {MOST_BYTES // 2**30} GiB are read: cut it or "
            "thin it out"
        )
    with open(path, "rb") as file:
        return file.read(MOST_BYTES)


def _read_other(path: str) -> Raw:
    try:
        from SurfaceTopography import read_topography as read
    except ImportError:
        raise UsageError(
            f"{os.path.splitext(path)[1] or 'no suffix'} is none of {', '.join(READERS)}; for other formats "
            "install SurfaceTopography: pip install 'fem-contact[topography]'"
        ) from None
    try:
        found: Any = read(path)
        check_shape(tuple(found.nb_grid_pts))
        heights = np.ma.filled(np.ma.asarray(found.heights()).astype(float), np.nan)
    except MemoryError:
        raise
    except Exception as error:  # every format reader of that library raises its own
        raise ValueError(f"SurfaceTopography: {error or type(error).__name__}") from None
    unit, sizes = plain_attribute(found.unit, "its unit"), found.physical_sizes
    if sizes is None:
        return Raw(heights=heights, unit=unit)
    # Its sizes are in the unit of the heights.
    units = None if unit is None else (unit, unit)
    return Raw(heights=heights, lengths=(float(sizes[0]), float(sizes[1])), length_units=units, unit=unit)
