"""One file of heights read, whatever its format; run in a child process that is held within bounds.

.npy, .nc and text of any suffix are read here; every other format, and text that is none of ours, by
SurfaceTopography.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import math
import os
import stat
from typing import Any

import numpy as np

from validation.arrays import Array
from validation.errors import UsageError, harmless
from validation.scenes.topography.raw import (
    MOST_BYTES,
    MOST_POINTS,
    FileSays,
    Raw,
    check_shape,
    even_steps,
    plain_attribute,
    real,
)
from validation.scenes.topography.text import NotText, read_text
from validation.units import metres

#: Heights farther from the median than this many times the distance of the quartiles are called spikes;
#: these are taken from so many heights, at least.
_FAR, _SAMPLED = 100.0, 2**16


def read_plain(path: str) -> FileSays:
    """Return what a file says, in metres; what goes wrong is a UsageError.

    A MemoryError passes: the bounds make a sentence of it.
    """
    try:
        data = bytes_of(path)
        _refuse_links(data)
        raw = _read(path, data)
        check_shape(raw.heights.shape)
        unit, scales = metres(raw.unit), [metres(each) or 1.0 for each in raw.length_units or ()]
        lengths = [side * s for side, s in zip(raw.lengths or (), scales or (1, 1), strict=False)]
        ratio = lengths[0] / lengths[1] if lengths else None
        if ratio is not None and not 0 < ratio < math.inf:
            raise ValueError(f"sides in the ratio {ratio:.3g}")
    except (UsageError, MemoryError):
        raise
    except OSError as error:
        raise UsageError(f"cannot be read: {one_line(error.strerror or error)}") from None
    except Exception as error:  # a reader of damaged bytes raises whatever they lead to
        reason = one_line(error) or type(error).__name__
        raise UsageError(f"is no topography of its kind ({reason})") from None
    return FileSays(
        heights=np.ascontiguousarray(raw.heights, dtype=float),
        lengths=(lengths[0], lengths[1]) if scales else None,
        ratio=ratio,
        unit=unit,
        notes=(*raw.notes, *_spikes(raw.heights)),
        digest=hashlib.sha256(data).hexdigest(),
    )


def _spikes(heights: Array) -> tuple[str, ...]:
    """Say that some heights belong to no surface; a format without checksums shows no other damage."""
    known = heights[np.isfinite(heights)]
    if not known.size:
        return ()
    with np.errstate(over="ignore"):
        low, middle, high = np.percentile(known[:: max(1, known.size // _SAMPLED)], (25, 50, 75))
        far = int(np.count_nonzero(np.abs(known - middle) > _FAR * (high - low)))
    words = f"{far} of {known.size} heights lie more than {_FAR:.0f} times the height of the middle half"
    return (f"{words} away from it: spikes, or a damaged file",) if far and high != low else ()


def one_line(words: object) -> str:
    """Return the first line of a text, shortened, as it is shown."""
    lines = str(words).strip().splitlines()
    return harmless(lines[0][:300]) if lines else ""


def bytes_of(path: str) -> bytes:
    """Return the bytes of a file; a UsageError for what is no file, or too long."""
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


def _refuse_links(data: bytes) -> None:
    """Refuse HDF5 whose numbers lie in other files: any file could be read so, and a missing one gives 0."""
    starts = (0, *(2**k for k in range(9, len(data).bit_length())))
    if not any(data.startswith(b"\x89HDF\r\n\x1a\n", start) for start in starts):
        return
    import netCDF4  # noqa: F401, I001  # first: wheels of both that hold one version of HDF5 read nothing otherwise
    import h5py

    elsewhere: list[str] = []

    def look(name: str, item: Any) -> None:
        outside = isinstance(item, h5py.Dataset) and (item.is_virtual or item.external)
        if outside or isinstance(item, h5py.ExternalLink):
            elsewhere.append(name)

    with h5py.File(io.BytesIO(data)) as file:
        file.visititems(look)
        file.visititems_links(look)
    if elsewhere:
        raise UsageError(
            f"its data set {one_line(elsewhere[0])[:80]!r} lies in another file (virtual or external "
            "storage); copy the numbers into one file, for example with h5repack"
        )


def _read(path: str, data: bytes) -> Raw:
    suffix = os.path.splitext(path)[1].lower()
    if suffix in (".npy", ".nc"):
        return _read_npy(data) if suffix == ".npy" else _read_netcdf(data)
    try:
        raw = read_text(data)  # whatever the suffix: .tsv, .prn, none
    except ValueError as error:
        try:  # text of other programs, and binary data
            return _read_other(path, suffix)
        except (ValueError, UsageError) as other:
            text = suffix in (".txt", ".csv", ".dat", ".asc", ".xyz") and not isinstance(error, NotText)
            raise (error if text else other) from None
    if raw.header:
        with contextlib.suppress(ValueError, UsageError):
            with_header = _read_other(path, suffix)
            return raw if with_header.lengths is None else with_header
    return raw


def _read_npy(data: bytes) -> Raw:
    """Read a .npy file, whose size is known from its header; one that needs pickles is refused."""
    from numpy.lib import format as npy

    file = io.BytesIO(data)
    version = npy.read_magic(file)
    readers: Any = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
    if version not in readers:
        raise ValueError(f"version {version} of .npy, in which names are written, not heights")
    shape, _, kind = readers[version](file)
    real(np.empty(0, kind))
    check_shape(shape)
    announced, there = math.prod(shape) * kind.itemsize, len(data) - file.tell()
    if there < announced:
        raise ValueError(f"{there} bytes of heights where {announced} are announced")
    file.seek(0)
    return Raw(heights=real(np.load(file, allow_pickle=False)))


#: What the map of a netCDF file is called. Its units, positions and fill values are not known to
#: SurfaceTopography.
_NAMES = ("heights", "height", "h", "z")


def _read_netcdf(data: bytes) -> Raw:
    """Read the map called heights, height, h or z, or the only two-dimensional one; x and y give the size."""
    import netCDF4

    try:
        with netCDF4.Dataset("heights.nc", memory=data) as file:
            return _read_maps(file)
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise UsageError(
            f"cannot be read: it is damaged, cut short or no netCDF (its library says {str(reason)[:80]!r})"
        ) from None


def _read_maps(file: Any) -> Raw:
    maps = {name: v for name, v in file.variables.items() if v.ndim == 2 and name.lower() != "mask"}
    named = [name for name in _NAMES if name in maps] or list(maps)
    if not named or (len(named) > 1 and named[0] not in _NAMES):
        raise ValueError(f"no variable 'heights' among {', '.join(list(file.variables)[:8]) or 'none'}")
    variable = maps[named[0]]
    check_shape(variable.shape)
    real(np.empty(0, variable.dtype))
    for key in {"scale_factor", "add_offset"} & set(variable.ncattrs()):
        # The library would leave the heights unscaled, with a warning that nobody reads.
        _number(variable.getncattr(key), f"{key!r} of {variable.name!r}")
    values = np.ma.asarray(variable[...])
    heights = np.where(np.ma.getmaskarray(values), np.nan, real(values.data))
    mask = file.variables.get("mask")
    if mask is not None and mask.shape == variable.shape and np.dtype(mask.dtype).kind in "biu":
        heights = np.where(np.ma.getdata(mask[...]) != 0, np.nan, heights)
    unit = _unit_of(variable)
    axes = [_axis(file.variables[name]) for name in variable.dimensions if name in file.variables]
    if len(axes) < 2:
        return Raw(heights=heights, unit=unit)
    (lx, x_unit, x_said, dx), (ly, y_unit, y_said, dy) = axes
    heights = heights[:: -1 if dx < 0 else 1, :: -1 if dy < 0 else 1]
    # SurfaceTopography says one unit for all, on the axes.
    if unit is None and x_said and y_said and x_unit == y_unit:
        unit = x_unit
    # Positions without a unit may be plain numbers of points.
    if x_unit is None or y_unit is None:
        return Raw(heights=heights, unit=unit)
    return Raw(heights=heights, lengths=(lx, ly), length_units=(x_unit, y_unit), unit=unit)


def _number(value: Any, what: str) -> float:
    array = np.asarray(value)
    if array.size != 1 or array.dtype.kind not in "iuf" or not np.isfinite(array).all():
        raise ValueError(f"{what} is no number")
    return float(array.reshape(-1)[0])


def _unit_of(variable: Any) -> str | None:
    key = next((key for key in ("units", "unit") if key in variable.ncattrs()), None)
    return key and plain_attribute(variable.getncattr(key), f"{key!r} of {variable.name!r}")


def _axis(position: Any) -> tuple[float, str | None, bool, float]:
    """Return length and unit of an axis, whether it says its length itself, and its step."""
    name = position.name
    if position.ndim != 1 or np.dtype(position.dtype).kind not in "biuf":
        raise ValueError(f"{name!r} holds no positions")
    x = np.ma.filled(np.ma.asarray(position[...]).astype(float), np.nan)
    try:
        step = even_steps(x, name)
    except ValueError as error:
        raise ValueError(f"{error}; interpolate the heights onto an even grid") from None
    length = abs(step) * x.size
    if "length" not in position.ncattrs():
        return length, _unit_of(position), False, step
    declared = _number(position.getncattr("length"), f"'length' of {name!r}")
    if not abs(declared - length) <= 0.02 * length:
        raise ValueError(f"'length' of {name!r} is {declared:.6g}, its positions say {length:.6g}")
    return declared, _unit_of(position), True, step


#: Formats of SurfaceTopography that may leave the size to be given, and know their own bytes; others that
#: leave it take any bytes for heights, and are believed where a file has their name.
_WITHOUT_SIZE = ("h5", "mat", "npz")


def _read_other(path: str, suffix: str) -> Raw:
    try:
        from SurfaceTopography import open_topography
    except ImportError:
        raise UsageError(
            f"{suffix or 'no suffix'} is none of .npy, .nc, and no text of numbers; for x3p and other "
            "formats install SurfaceTopography: pip install 'fem-contact[topography]'"
        ) from None
    try:
        with open_topography(path) as reader:
            channel: Any = reader.default_channel
            shape, sizes = tuple(channel.nb_grid_pts), channel.physical_sizes
            unsized = sizes is None or None in sizes
            if unsized and reader.format() not in (*_WITHOUT_SIZE, suffix.removeprefix(".")):
                raise ValueError("a reader that takes any bytes for heights")
            if len(shape) == 2 and math.prod(shape) <= MOST_POINTS:
                surface: Any = reader.topography(**({"physical_sizes": shape} if unsized else {}))
                heights = np.ma.filled(np.ma.asarray(surface.heights()).astype(float), np.nan)
                unit, sizes = surface.unit, None if unsized else surface.physical_sizes
            names = [one_line(each.name)[:40] for each in reader.channels]
    except MemoryError:
        raise
    except Exception:  # every format reader of that library raises its own, and names formats it was not
        raise ValueError("damaged, cut short, or of no format that SurfaceTopography reads") from None
    check_shape(shape)
    unit = plain_attribute(unit, "its unit")
    others = ", ".join(names[:8])
    notes = (f"of its {len(names)} channels {one_line(channel.name)!r} ({others})",) if len(names) > 1 else ()
    lengths = None if sizes is None else (float(sizes[0]), float(sizes[1]))
    # Its sizes are in the unit of the heights.
    units = None if unit is None or lengths is None else (unit, unit)
    return Raw(heights=heights, lengths=lengths, length_units=units, unit=unit, notes=notes)
