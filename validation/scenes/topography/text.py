"""Reader of text: a matrix of numbers, or three columns x, y, z of an even grid; headers as of Gwyddion."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass

import numpy as np

from validation.arrays import Array
from validation.scenes.topography.raw import MOST_POINTS, Raw, check_shape, even_steps

__all__ = ["read_text"]

#: A file is taken for text only if its numbers begin within these many bytes.
_MOST_HEADER = 2**16
#: Rows from which three columns are taken for x, y, z rather than a map three points wide.
_LEAST_XYZ = 4
#: Points of the grid of x and y for each point that is listed; a sparser one is no grid.
_SPARSEST = 4

#: How lines begin that are no numbers, whatever they hold.
_COMMENTS = ("#", "%", "//")
_NUMBER = re.compile(
    r"[-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?|[-+]?(?:nan|inf|infinity)", re.IGNORECASE
)
_SIDE = r"^\W*{}\s*[:=]\s*([-+0-9.,eE]+)\s*([^\s\d]\S*)\s*$"
_WIDTH, _HEIGHT = (
    re.compile(_SIDE.format(name), re.MULTILINE | re.IGNORECASE) for name in ("width", "height")
)
_VALUES = re.compile(r"^\W*value units?\s*[:=]\s*(\S+)\s*$", re.MULTILINE | re.IGNORECASE)
_COLUMN_UNIT = r"\b{}\b\s*[\[(/]\s*([^\])\s,;]{{1,16}})\s*[\])]?"


@dataclass(frozen=True, kw_only=True)
class _Layout:
    """How the numbers stand: where they begin, what parts them, whether their decimals follow a comma."""

    start: int
    columns: int
    delimiter: str | None = None
    decimal_comma: bool = False
    closed: bool = False


def read_text(data: bytes) -> Raw:
    """Read text: rows along x, columns along y, or three columns x, y, z."""
    data = _as_bytes(data)
    layout = _layout(data)
    header = _decoded(data[: layout.start])
    table = _table(data, layout)
    if layout.columns == 3 and table.shape[0] >= _LEAST_XYZ:
        return _from_points(table, header)
    check_shape(table.shape)
    lengths, length_units = _sides(header)
    unit = _VALUES.search(header)
    return Raw(
        heights=table, lengths=lengths, length_units=length_units, unit=None if unit is None else unit[1][:64]
    )


def _as_bytes(data: bytes) -> bytes:
    """Return text as numbers are read from it: no byte-order mark, no UTF-16, lines ended as here."""
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        data = data.decode("utf-16").encode()
    head = data[:_MOST_HEADER]
    if b"\0" in head:
        raise ValueError("binary data, not text")
    if b"\r" in head and b"\n" not in head:
        data = data.replace(b"\r", b"\n")
    return data.removeprefix(b"\xef\xbb\xbf")


def _decoded(header: bytes) -> str:
    """Decode what stands before the numbers; instruments write Latin-1, too."""
    try:
        return header.decode("utf-8")
    except UnicodeDecodeError:
        return header.decode("latin-1")


def _layout(data: bytes) -> _Layout:
    """Find the first line of numbers and how it is written."""
    start = 0
    while start < min(len(data), _MOST_HEADER):
        end = data.find(b"\n", start)
        end = len(data) if end < 0 else end
        line = data[start:end].decode("ascii", errors="replace").strip()
        if not line.startswith(_COMMENTS) and _is_mostly_numbers(line):
            return _written(line, start)
        start = end + 1
    raise ValueError("no line of numbers at its beginning")


def _is_mostly_numbers(line: str) -> bool:
    """Whether a line belongs to the numbers; a damaged one does: it is refused, not taken for a title."""
    tokens = [token for token in re.split(r"[\s;,]+", line[:4096]) if token][:8]
    return 2 * sum(_NUMBER.fullmatch(token) is not None for token in tokens) > len(tokens)


def _written(line: str, start: int) -> _Layout:
    tokens = line.split()
    commas = [token for token in tokens if re.fullmatch(r"[-+]?\d*(,\d+)?([eE][-+]?\d+)?", token)]
    if ";" not in line and "," not in line:
        return _Layout(start=start, columns=len(tokens))
    if ";" not in line and len(tokens) > 1 and len(commas) == len(tokens):
        return _Layout(start=start, columns=len(tokens), decimal_comma=True)
    mark = ";" if ";" in line else ","
    # Some writers end each line with what parts the numbers.
    closed = line.endswith(mark)
    columns = line.count(mark) + (not closed)
    return _Layout(start=start, columns=columns, delimiter=mark, decimal_comma=mark == ";", closed=closed)


def _table(data: bytes, layout: _Layout) -> Array:
    """Read the numbers; how many there may be is known before."""
    body = data[layout.start :]
    rows = body.count(b"\n") + 1
    if rows * layout.columns > 2 * MOST_POINTS or layout.columns > MOST_POINTS:
        raise ValueError(
            f"up to {rows} rows of {layout.columns} numbers; at most {MOST_POINTS} heights are read: cut it "
            "or thin it out"
        )
    if layout.decimal_comma:
        body = body.replace(b",", b".")
    if layout.closed:
        mark = str(layout.delimiter).encode()
        body = re.sub(rb"[ \t]*%b[ \t]*(?=\r?(?:\n|\Z))" % mark, b"", body)
    lines = io.TextIOWrapper(io.BytesIO(body), encoding="ascii", errors="replace")
    try:
        return np.loadtxt(lines, ndmin=2, delimiter=layout.delimiter)
    except ValueError as error:
        # What follows speaks of arguments that a reader of this has not.
        raise ValueError(str(error).partition("; use `usecols`")[0]) from None


def _sides(header: str) -> tuple[tuple[float, float] | None, tuple[str, str] | None]:
    """Return size and unit along rows and columns: a height and a width, since rows run down the page."""
    width, height = _WIDTH.search(header), _HEIGHT.search(header)
    if width is None or height is None:
        return None, None
    sides = [float(side[1].replace(",", ".")) for side in (height, width)]
    if not all(0 < side < np.inf for side in sides):
        raise ValueError(f"a size of {sides[0]:.6g} x {sides[1]:.6g} in its header")
    return (sides[0], sides[1]), (height[2][:64], width[2][:64])


def _from_points(table: Array, header: str) -> Raw:
    """Sort points x, y, z onto their grid; points that are not listed are missing."""
    axes, indices = [], []
    for name, column in zip("xy", table[:, :2].T, strict=True):
        try:
            values = _distinct(column)
            step = even_steps(values, name)
        except ValueError as error:
            raise ValueError(f"three columns are read as x, y, z, and {error}: {_REMEDY}") from None
        axes.append((values.size, step))
        indices.append(np.rint((column - values[0]) / step).astype(np.intp))
    (nx, dx), (ny, dy) = axes
    check_shape((nx, ny))
    if nx * ny > _SPARSEST * len(table):
        raise ValueError(f"three columns, but {len(table)} points x, y on no grid: {_REMEDY}")
    place = indices[0] * ny + indices[1]
    listed = np.bincount(place, minlength=nx * ny)
    if listed.max() > 1:
        raise ValueError(f"three columns, but points x, y that are listed twice: {_REMEDY}")
    heights = np.full(nx * ny, np.nan)
    heights[place] = table[:, 2]
    units = [re.search(_COLUMN_UNIT.format(name), header, re.IGNORECASE) for name in "xyz"]
    said = [None if unit is None else unit[1] for unit in units]
    return Raw(
        heights=heights.reshape(nx, ny),
        lengths=(nx * dx, ny * dy),
        length_units=None if said[0] is None or said[1] is None else (said[0], said[1]),
        unit=said[2],
        notes=(f"three columns taken for x, y, z, spaced {dx:.4g} and {dy:.4g}",),
    )


_REMEDY = "interpolate onto an even grid, or write a map three points wide as .npy"


def _distinct(column: Array) -> Array:
    """Return the positions of a column, those that differ by rounding taken for one."""
    values = np.unique(column)
    if not np.all(np.isfinite(values)):
        return values  # to be refused
    return np.asarray(values[np.concatenate([[True], np.diff(values) > 1e-6 * (values[-1] - values[0])])])
