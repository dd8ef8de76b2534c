"""Measured topographies from files: within bounds of time and memory, once for a file, in metres."""

from __future__ import annotations

import functools
import os
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from validation import sandbox
from validation.arrays import Array, Pair
from validation.errors import UsageError
from validation.report.quantities import as_length
from validation.scenes.topography.formats import one_line, read_plain
from validation.scenes.topography.patch import Topography, rms
from validation.scenes.topography.raw import MOST_POINTS, RATIO, FileSays
from validation.units import LARGEST

#: Time to read a file, and bytes of it that are read in a further second [s, 1/s].
_SECONDS, _BYTES_PER_SECOND = 60.0, 2e6
#: Memory to read a file: that of the largest map in a few copies, and more for the text of it.
_MEMORY, _COPIES = 2**31 + 2**30, 4
#: Sides of a patch and of its cells [m], rms slopes and heights [m], that no instrument goes beyond.
_LARGEST_PATCH, _SMALLEST_CELL, _STEEPEST, _LEAST_HEIGHT = 1.0, 1e-12, 10.0, 1e-12
#: A file that was changed less than this before it was read is read again: a later change may have the same
#: time [s].
_SETTLED = 1.0


def file_says(path: Path) -> FileSays:
    """Read a file as it is; a file that has not changed since is not read again.

    A UsageError for one that cannot be read, or not within bounds of size, time and memory.
    """
    name = os.path.abspath(path)
    try:
        facts = os.stat(name)
    except (OSError, ValueError):  # whoever reads it says why
        return _read(name)
    changed = max(facts.st_mtime_ns, facts.st_ctime_ns)
    unsettled = time.monotonic_ns() if time.time() - changed / 1e9 < _SETTLED else 0
    return _read(name, facts.st_size, (facts.st_dev, facts.st_ino, changed, unsettled))


@functools.lru_cache(maxsize=1)
def _read(name: str, size: int = 0, content: tuple[int, ...] = ()) -> FileSays:
    """Read a file of a size; what tells its content tells whether it is read again."""
    del content
    try:
        says: FileSays = sandbox.call(
            read_plain,
            name,
            seconds=_SECONDS + size / _BYTES_PER_SECOND,
            memory=_MEMORY + _COPIES * size,
            most_bytes=8 * MOST_POINTS,
        )
    except sandbox.OutOfBounds as error:
        raise UsageError(f"cannot be read: its reader {error}") from None
    return says


def read_topography(path: Path, *, lengths: Pair | None = None, unit: float | None = None) -> Topography:
    """Read a topography: .npy, text, .nc, and whatever SurfaceTopography reads where it is installed.

    Text is a matrix, rows along x, or three columns x, y, z of an even grid; a width and a height in its
    header, as Gwyddion writes them, are the sizes along its columns and rows.

    The size [m] and the unit of the heights [m] are those of the file if not given. A UsageError for a file
    that cannot be read, or says neither and is given none: heights taken for metres by default would be wrong
    by the factor that instruments most often leave out.
    """
    says = file_says(path)
    size = lengths or says.lengths
    if size is None:
        raise UsageError("does not say how large the patch is: give length")
    scale = unit if unit is not None else says.unit
    if scale is None:
        raise UsageError('does not say the unit of its heights: give unit, such as "1 nm"')
    if says.lengths is None and says.ratio is not None and abs(size[0] / size[1] / says.ratio - 1) > RATIO:
        raise UsageError(
            f"its sides are in the ratio {says.ratio:.4g}, and length = [{size[0]:.4g}, {size[1]:.4g}] m "
            f"says {size[0] / size[1]:.4g}: give both sides, [Lx, Ly]"
        )
    heights = np.where(np.isfinite(says.heights), says.heights, np.nan)
    peak = float(np.abs(says.heights).max(where=np.isfinite(says.heights), initial=0.0)) * scale
    if not peak <= LARGEST:
        raise UsageError(f"holds heights up to {peak:.3g} m; at most {LARGEST:.0e} m are computed with")
    heights *= scale
    heights.setflags(write=False)
    nx, ny = heights.shape
    words = f"{one_line(path.name)}: {nx} x {ny} points, {_sides(size)}"
    if any(abs(a / b - 1) > RATIO for a, b in zip(size, says.lengths or size, strict=True)):
        words += f" (its own: {_sides(says.lengths or size)})"
    cells = size[0] / nx, size[1] / ny
    if abs(cells[0] / cells[1] - 1) > RATIO:
        words += f", oblong cells of {_sides(cells)}"
    return Topography(
        heights=heights, lengths=size, history=(words, *says.notes), unit=scale, digest=says.digest
    )


def _sides(sides: Pair) -> str:
    return " x ".join(as_length(side, 4) for side in sides)


def impossible(heights: Array, size: Pair) -> Iterator[str]:
    """Yield what no instrument measures: more likely a unit that is missing, or another."""
    cells = [side / n for side, n in zip(size, heights.shape, strict=True)]
    if max(size) > _LARGEST_PATCH or min(cells) < _SMALLEST_CELL:
        yield (
            f"no instrument measures {as_length(size[0], 3)} x {as_length(size[1], 3)} in cells of "
            f"{as_length(min(cells), 3)}: check the unit of length"
        )
    with np.errstate(over="ignore", invalid="ignore"):
        slope = max(rms(np.diff(heights, axis=axis)) / cells[axis] for axis in (0, 1))
    if slope > _STEEPEST:
        yield f"root mean square slopes of {slope:.3g} are no surface's: check unit and length"
    known = heights[np.isfinite(heights)]
    if known.size and (height := float(np.std(known))) < _LEAST_HEIGHT:
        yield f"no instrument measures heights of {as_length(height, 3)}, root mean square: check their unit"
