"""Reader of text: a matrix of numbers, or three columns x, y, z of an even grid; headers as of Gwyddion."""

from __future__ import annotations

import io
import re

import numpy as np

from validation.arrays import Array
from validation.scenes.topography.raw import MOST_POINTS, Raw, check_shape, even_steps

#: A file is taken for text only if its numbers begin within these many bytes.
_MOST_HEADER = 2**16
#: Rows from which three columns are taken for x, y, z rather than a map three points wide.
_LEAST_XYZ = 4
#: Numbers that are read at most: x, y, z of each point.
_MOST_NUMBERS = 3 * MOST_POINTS
#: Points of the grid of x and y for each point that is listed; a sparser one is no grid.
_SPARSEST = 4

_NUMBER = re.compile(
    r"[-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?|[-+]?(?:nan|inf|infinity)", re.IGNORECASE
)
_DECIMAL_COMMA = re.compile(r"[-+]?(?:\d*(,\d+)?([eE][-+]?\d+)?|nan|inf|infinity)", re.IGNORECASE)
_SIDE = r"^\W*{}\s*[:=]\s*([-+0-9.,eE]+)\s*([^\s\d]\S*)\s*$"
# As Gwyddion writes them, in English, German, French, Spanish and Czech.
_WIDTH, _HEIGHT = (
    re.compile(_SIDE.format(f"(?:{names})"), re.M | re.I)
    for names in ("width|breite|largeur|anchura|šířka", "height|höhe|hauteur|altura|výška")
)
_VALUES = re.compile(
    r"^\W*(?:value units?|einheiten|unités|unidades de valor|jednotky hodnot)\s*[:=]\s*(\S+)\s*$", re.M | re.I
)
_COLUMN_UNIT = r"\b{}\b\s*[\[(/]\s*([^\])\s,;]{{1,16}})\s*[\])]?"
_REMEDY = "interpolate onto an even grid, or write a map three points wide as .npy"


class NotText(ValueError):
    """Binary data under a suffix of text."""


def read_text(data: bytes) -> Raw:
    """Read text: rows along x, columns along y, or three columns x, y, z."""
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        data = data.decode("utf-16").encode()
    head = data[:_MOST_HEADER]
    if b"\0" in head:
        raise NotText("binary data, not text")
    if b"\r" in head and b"\n" not in head:
        data = data.replace(b"\r", b"\n")
    data = data.removeprefix(b"\xef\xbb\xbf")
    start, first = _first_line(data)
    try:
        header = data[:start].decode("utf-8")
    except UnicodeDecodeError:
        header = data[:start].decode("latin-1")
    table = _table(data[start:], first)
    width, height = _WIDTH.search(header), _HEIGHT.search(header)
    if table.shape[1] == 3 and table.shape[0] >= _LEAST_XYZ and (width is None or height is None):
        return _from_points(table, header)
    check_shape(table.shape)
    values = _VALUES.search(header)
    unit = None if values is None else values[1][:64]
    if width is None or height is None:
        return Raw(heights=table, unit=unit, header=header.strip())
    # Rows run down the page: x runs along the height.
    lx, ly = (float(side[1].replace(",", ".")) for side in (height, width))
    if not (0 < lx < np.inf and 0 < ly < np.inf):
        raise ValueError(f"a size of {lx:.6g} x {ly:.6g} in its header")
    return Raw(heights=table, lengths=(lx, ly), length_units=(height[2][:64], width[2][:64]), unit=unit)


def read_columns(data: bytes) -> Array:
    """Read a table of numbers below a header; a ValueError for none."""
    data = data.removeprefix(b"\xef\xbb\xbf")
    start, first = _first_line(data)
    return _table(data[start:], first)


def _first_line(data: bytes) -> tuple[int, str]:
    """Return where the numbers begin, and their first line; a damaged one is refused later, no title."""
    start = 0
    while start < min(len(data), _MOST_HEADER):
        end = data.find(b"\n", start)
        end = len(data) if end < 0 else end
        line = data[start:end].decode("ascii", errors="replace").strip()
        tokens = [token for token in re.split(r"[\s;,]+", line[:4096]) if token][:8]
        numbers = sum(_NUMBER.fullmatch(token) is not None for token in tokens)
        if 2 * numbers > len(tokens) and not line.startswith(("#", "%", "//")):
            return start, line
        start = end + 1
    raise ValueError("no line of numbers at its beginning")


def _table(body: bytes, first: str) -> Array:
    """Read numbers, parted as in the `first` line: by ";" or blanks, with decimal points or commas, or ",".

    Where they may be too many, a ValueError before they are read.
    """
    tokens, mark = first.split(), None
    if ";" in first:
        mark = ";"
    elif "," in first and (len(tokens) == 1 or not all(map(_DECIMAL_COMMA.fullmatch, tokens))):
        mark = ","
    columns, rows = (len(tokens) if mark is None else first.count(mark) + 1), body.count(b"\n") + 1
    if rows * columns > _MOST_NUMBERS or columns > MOST_POINTS:
        raise ValueError(
            f"up to {rows} rows of {columns} numbers; at most {MOST_POINTS} heights are read: cut it "
            "or thin it out"
        )
    if mark != ",":
        body = body.replace(b",", b".")
    if mark is not None and first.endswith(mark):  # some writers end each line with what parts the numbers
        body = re.sub(rb"[ \t]*%b[ \t]*(?=\r?(?:\n|\Z))" % mark.encode(), b"", body)
    lines = io.TextIOWrapper(io.BytesIO(body), encoding="ascii", errors="replace")
    try:
        return np.loadtxt(lines, ndmin=2, delimiter=mark)
    except ValueError as error:
        # What follows speaks of arguments that a reader of this has not.
        raise ValueError(str(error).partition("; use `usecols`")[0]) from None


def _from_points(table: Array, header: str) -> Raw:
    """Sort points x, y, z onto their grid; points that are not listed are missing."""
    steps, indices, shape = [], [], []
    for name, column in zip("xy", table[:, :2].T, strict=True):
        values = np.unique(column)
        if np.all(np.isfinite(values)):  # those that differ by rounding are one
            values = values[np.diff(values, prepend=-np.inf) > 1e-6 * (values[-1] - values[0])]
        try:
            step = even_steps(values, name)
        except ValueError as error:
            raise ValueError(f"three columns are read as x, y, z, and {error}: {_REMEDY}") from None
        steps.append(step)
        shape.append(values.size)
        indices.append(np.rint((column - values[0]) / step).astype(np.intp))
    nx, ny = shape
    check_shape((nx, ny))
    if nx * ny > _SPARSEST * len(table):
        raise ValueError(f"three columns, but {len(table)} points x, y on no grid: {_REMEDY}")
    place = indices[0] * ny + indices[1]
    if np.bincount(place).max() > 1:
        raise ValueError(f"three columns, but points x, y that are listed twice: {_REMEDY}")
    heights = np.full(nx * ny, np.nan)
    heights[place] = table[:, 2]
    units = [re.search(_COLUMN_UNIT.format(name), header, re.I) for name in "xyz"]
    x_unit, y_unit, z_unit = (None if unit is None else unit[1] for unit in units)
    return Raw(
        heights=heights.reshape(nx, ny),
        lengths=(nx * steps[0], ny * steps[1]),
        length_units=None if x_unit is None or y_unit is None else (x_unit, y_unit),
        unit=z_unit,
        notes=(f"three columns taken for x, y, z, spaced {steps[0]:.4g} and {steps[1]:.4g}",),
    )
