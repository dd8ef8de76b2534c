"""Measured topographies: read from files, levelled, filled, made periodic; every step is written down."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from fem_contact.errors import InvalidInput
from fem_contact.surface import HeightField
from fem_contact.surface.spectra import window_weights
from validation.errors import UsageError
from validation.files import atomic_path

__all__ = ["Edges", "Missing", "Tilt", "Topography", "file_says", "read_topography", "write_topography"]

Array = NDArray[np.float64]
Tilt = Literal["keep", "plane", "quadratic"]
Missing = Literal["refuse", "nearest", "harmonic"]
Edges = Literal["periodic", "tukey", "hann"]

#: A step between opposite edges of more than this many typical steps between neighbours is no period.
_JUMP = 4.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Topography:
    """A measured patch of a surface.

    Attributes
    ----------
    heights : (nx, ny) array
        Heights [m]; NaN where there are none.
    lengths : tuple of float
        Size of the patch (Lx, Ly) [m], number of points times spacing.
    history : tuple of str
        What was done to it, in words.
    """

    heights: Array
    lengths: tuple[float, float]
    history: tuple[str, ...] = ()

    @property
    def missing(self) -> int:
        """Number of points without a height."""
        return int(np.count_nonzero(~np.isfinite(self.heights)))

    @property
    def slope(self) -> tuple[float, float]:
        """Slope of the least-squares plane along x and y [-]."""
        x, y, coefficients = _fitted(self.heights, "plane")
        del x, y
        nx, ny = self.heights.shape
        return float(coefficients[1]) * nx / self.lengths[0], float(coefficients[2]) * ny / self.lengths[1]

    @property
    def edge_jump(self) -> float:
        """Root mean square step between opposite edges over that between neighbours; about 1 if periodic."""
        h = self.heights
        jumps, steps = [], []
        for axis in (0, 1):
            rows = np.moveaxis(h, axis, 0)
            if rows.shape[0] > 2:
                jumps.append(_rms(rows[0] - rows[-1]))
                steps.append(_rms(np.diff(rows, axis=0)))
        ratios = [jump / step for jump, step in zip(jumps, steps, strict=True) if step > 0]
        return max(ratios, default=0.0)

    def levelled(self, tilt: Tilt) -> Topography:
        """Take the least-squares plane or quadratic of the known points out."""
        if tilt == "keep":
            return self
        x, y, coefficients = _fitted(self.heights, tilt)
        surface = sum(c * term for c, term in zip(coefficients, _terms(x, y, tilt), strict=True))
        sx, sy = self.slope
        words = f"{tilt} taken out (slope {sx:.3g} along x, {sy:.3g} along y)"
        return replace(self, heights=self.heights - surface, history=(*self.history, words))

    def filled(self, missing: Missing) -> Topography:
        """Give missing points a height, by choice.

        Raises
        ------
        UsageError
            When there are some and the choice is to refuse.
        """
        count = self.missing
        if count == 0:
            return self
        if count == self.heights.size:
            raise UsageError("the topography has no known point")
        if missing == "refuse":
            raise UsageError(
                f"{count} of {self.heights.size} heights are NaN or infinite: say how to fill them with "
                "missing = 'nearest' or 'harmonic'"
            )
        fill: Callable[[Array], Array] = _nearest if missing == "nearest" else _harmonic
        words = f"{count} missing points ({100 * count / self.heights.size:.2g} %) filled: {missing}"
        return replace(self, heights=fill(self.heights), history=(*self.history, words))

    def made_periodic(self, edges: Edges | None, *, margin: float = 0.1) -> Topography:
        """Bring opposite edges together by a named taper, or take the patch as one period.

        Raises
        ------
        UsageError
            When nothing was chosen and opposite edges do not match.
        """
        if edges is None:
            if self.edge_jump > _JUMP:
                raise UsageError(
                    f"opposite edges differ by {self.edge_jump:.3g} typical steps between neighbours, so "
                    "this is "
                    "no period: choose edges = 'tukey' or 'hann', or 'periodic' to take it as it is"
                )
            return self
        if edges == "periodic":
            words = f"taken as periodic (edges differ by {self.edge_jump:.3g} typical steps)"
            return replace(self, history=(*self.history, words))
        nx, ny = self.heights.shape
        weights = window_weights((nx, ny), window=edges, margin=margin)
        mean = float(np.mean(self.heights))
        before = _rms(self.heights - mean)
        tapered = weights * (self.heights - mean)
        share = f" over {100 * margin:.3g} % of each side" if edges == "tukey" else ""
        after = f"h_rms {before:.4g} m before, {_rms(tapered):.4g} m after"
        words = f"made periodic: {edges} taper{share} ({after})"
        return replace(self, heights=tapered, history=(*self.history, words))

    def height_field(self) -> HeightField:
        """Return the heights as one period of a surface."""
        return HeightField(heights=self.heights, lengths=self.lengths)


def _rms(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else 0.0


def _terms(x: Array, y: Array, tilt: Tilt) -> list[Array]:
    plane = [np.ones_like(x), x, y]
    return plane if tilt == "plane" else [*plane, x * x, x * y, y * y]


def _fitted(heights: Array, tilt: Tilt) -> tuple[Array, Array, Array]:
    """Positions in points from the centre, and the least-squares coefficients over the known points."""
    nx, ny = heights.shape
    x, y = np.meshgrid(np.arange(nx) - (nx - 1) / 2, np.arange(ny) - (ny - 1) / 2, indexing="ij")
    known = np.isfinite(heights)
    matrix = np.stack([term[known] for term in _terms(x, y, tilt)], axis=1)
    # Columns of like size: a constant beside squares of thousands would lose digits.
    scale = np.max(np.abs(matrix), axis=0, initial=0.0)
    scale[scale == 0] = 1.0
    solution = np.linalg.lstsq(matrix / scale, heights[known], rcond=None)[0] / scale
    return x, y, np.asarray(solution)


def _nearest(heights: Array) -> Array:
    from scipy.ndimage import distance_transform_edt

    indices = distance_transform_edt(~np.isfinite(heights), return_distances=False, return_indices=True)
    return np.asarray(heights[tuple(indices)])


def _harmonic(heights: Array) -> Array:
    """Fill holes with the discrete harmonic function that continues their rims: a stretched membrane."""
    from scipy.sparse import coo_array
    from scipy.sparse.linalg import spsolve

    hole = ~np.isfinite(heights)
    number = np.full(heights.shape, -1)
    number[hole] = np.arange(np.count_nonzero(hole))
    count = int(number.max()) + 1
    rows, columns, values, right, degree = [], [], [], np.zeros(count), np.zeros(count)
    for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
        n = heights.shape[axis]
        here = np.moveaxis(number, axis, 0)[max(0, -step) : n - max(0, step)]
        there = np.moveaxis(number, axis, 0)[max(0, step) : n - max(0, -step)]
        level = np.moveaxis(heights, axis, 0)[max(0, step) : n - max(0, -step)]
        mine = here >= 0
        np.add.at(degree, here[mine], 1.0)
        inside = mine & (there >= 0)
        rows.append(here[inside])
        columns.append(there[inside])
        values.append(np.full(np.count_nonzero(inside), -1.0))
        rim = mine & (there < 0)
        np.add.at(right, here[rim], level[rim])
    rows.append(np.arange(count))
    columns.append(np.arange(count))
    values.append(degree)
    matrix = coo_array(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(count, count)
    ).tocsr()
    filled = heights.copy()
    filled[hole] = spsolve(matrix, right)
    return filled


def read_topography(
    path: Path, *, lengths: tuple[float, float] | None = None, unit: float | None = None
) -> Topography:
    """Read a topography: .npy, text, .nc, .x3p, and whatever SurfaceTopography reads where it is installed.

    Parameters
    ----------
    path : Path
    lengths : tuple of float, optional
        Size of the patch [m]; from the file if not given.
    unit : float, optional
        Unit of the heights [m]; that of the file if not given.

    Raises
    ------
    UsageError
        For a file that cannot be read, or says neither size nor unit and is not given them: heights taken for
        metres by default would be wrong by the factor that instruments most often leave out.
    """
    heights, own_lengths, own_unit = _raw(path)
    size = lengths or own_lengths
    if size is None:
        raise UsageError("does not say how large the patch is: give length")
    scale = unit if unit is not None else own_unit
    if scale is None:
        raise UsageError('does not say the unit of its heights: give unit, such as "1 nm"')
    heights = np.where(np.isfinite(heights), heights, np.nan) * scale
    nx, ny = heights.shape
    words = f"{path.name}: {nx} x {ny} points, {size[0]:.4g} m x {size[1]:.4g} m"
    return Topography(heights=heights, lengths=size, history=(words,))


#: Heights, size of the patch [m] and unit of the heights [m]; None for what the file does not say.
_Raw = tuple[Array, tuple[float, float] | None, float | None]


def _raw(path: Path) -> _Raw:
    """Read a file as it is; whatever goes wrong is one sentence."""
    reader = _READERS.get(path.suffix.lower(), _read_other)
    try:
        heights, lengths, unit = reader(path)
    except (OSError, zipfile.BadZipFile) as error:
        reason = getattr(error, "strerror", None) or error
        raise UsageError(f"cannot be read: {reason}") from None
    except (ValueError, TypeError, KeyError, InvalidInput, ElementTree.ParseError) as error:
        reason = str(error).splitlines()[0]
        raise UsageError(f"is no topography of its kind ({reason})") from None
    if heights.ndim != 2 or min(heights.shape) < 2:
        raise UsageError(f"has shape {heights.shape}; a map of at least 2 x 2 heights is needed")
    return heights, lengths, unit


def file_says(path: Path) -> tuple[tuple[float, float] | None, float | None]:
    """Return size of the patch [m] and unit of the heights [m] of a file; None for what it does not say.

    Raises
    ------
    UsageError
        For a file that cannot be read.
    """
    _, lengths, unit = _raw(path)
    return lengths, unit


def _real(values: Any) -> Array:
    """Heights as real numbers; complex ones are refused rather than halved."""
    array = np.asarray(values)
    if array.dtype.kind not in "biuf":
        raise ValueError(f"it holds {array.dtype.name} values; heights are real numbers")
    return array.astype(float)


def _read_npy(path: Path) -> _Raw:
    return _real(np.load(path, allow_pickle=False)), None, None


def _read_text(path: Path) -> _Raw:
    return _table(path), None, None


def _table(path: Path) -> Array:
    try:
        return np.loadtxt(path, ndmin=2)
    except ValueError as error:
        try:
            return np.loadtxt(path, ndmin=2, delimiter=",")
        except ValueError:
            raise error from None


def _read_netcdf(path: Path) -> _Raw:
    """Read the map called heights, height, h or z, or the only two-dimensional one; x and y give the size."""
    import netCDF4

    with netCDF4.Dataset(path) as file:
        maps: dict[str, Any] = {name: v for name, v in file.variables.items() if v.ndim == 2}
        names = ("heights", "height", "h", "z")
        named: list[str] = [name for name in names if name in maps] or list(maps)
        if not named or (len(named) > 1 and named[0] not in names):
            raise ValueError(f"no variable 'heights' among {', '.join(file.variables) or 'none'}")
        variable = maps[named[0]]
        values = np.ma.asarray(variable[...])
        _real(values.data)
        heights = np.ma.filled(values.astype(float), np.nan)
        unit = _metres(getattr(variable, "units", None))
        sizes = []
        for axis in variable.dimensions:
            if axis not in file.variables:
                return heights, None, unit
            position = file.variables[axis]
            step = _metres(getattr(position, "units", None))
            if step is None:
                return heights, None, unit
            x = np.asarray(position[...], dtype=float) * step
            sizes.append(float(x[-1] - x[0]) * x.size / (x.size - 1))
    return heights, (sizes[0], sizes[1]), unit


def _metres(unit: str | None) -> float | None:
    """Return a unit of length in metres; None for none."""
    if unit is None or not unit.strip():
        return None
    if unit.strip() == "m":
        return 1.0
    from validation.scenes.scene import unit_registry

    try:
        return float(unit_registry().Quantity(1, unit.strip()).to("m").magnitude)
    except Exception:
        raise ValueError(f"unit {unit!r} is not a length") from None


#: Types of the binary matrix of an X3P file.
_X3P_TYPES = {"I": "<i2", "L": "<i4", "F": "<f4", "D": "<f8"}


def _read_x3p(path: Path) -> _Raw:
    """Read ISO 25178-72 (X3P): a ZIP file with main.xml and a binary matrix, x fastest, in metres."""
    with zipfile.ZipFile(path) as archive:
        root = ElementTree.fromstring(archive.read("main.xml"))
        axes = {name: _child(root, "Axes", name) for name in ("CX", "CY", "CZ")}
        steps = [float(_text(axes[name], "Increment")) for name in ("CX", "CY")]
        size = _child(root, "Record3", "MatrixDimension")
        nx, ny = int(_text(size, "SizeX")), int(_text(size, "SizeY"))
        link = _text(root, "Record3", "DataLink", "PointDataLink")
        kind = np.dtype(_X3P_TYPES[_text(axes["CZ"], "DataType")])
        data = np.frombuffer(archive.read(link), dtype=kind)
        if data.size != nx * ny:
            raise ValueError(f"{data.size} heights where {nx} x {ny} are announced")
        heights = data.reshape(ny, nx).T.astype(float)
        if kind.kind == "i":
            heights *= float(_text(axes["CZ"], "Increment"))
        mask = root.find(".//{*}ValidPointsLink")
        if mask is not None and mask.text:
            bits = np.unpackbits(np.frombuffer(archive.read(mask.text.strip()), np.uint8), bitorder="little")
            heights[~bits[: nx * ny].reshape(ny, nx).T.astype(bool)] = np.nan
    return heights, (nx * steps[0], ny * steps[1]), 1.0


def _child(node: ElementTree.Element, *names: str) -> ElementTree.Element:
    for name in names:
        # Some writers put the tags into a namespace, some do not.
        found = next((child for child in node.iter() if child.tag.rpartition("}")[2] == name), None)
        if found is None:
            raise ValueError(f"main.xml has no {name}")
        node = found
    return node


def _text(node: ElementTree.Element, *names: str) -> str:
    return (_child(node, *names).text or "").strip()


def _read_other(path: Path) -> _Raw:
    if not path.exists():
        raise FileNotFoundError(2, "No such file or directory", str(path))
    try:
        from SurfaceTopography import read_topography as read
    except ImportError:
        raise UsageError(
            f"{path.suffix or 'no suffix'} is none of {', '.join(_READERS)}; for other formats install "
            "SurfaceTopography: pip install 'fem-contact[topography]'"
        ) from None
    try:
        found: Any = read(str(path))
    except Exception as error:  # every format reader of that library raises its own
        raise ValueError(f"SurfaceTopography: {error or type(error).__name__}") from None
    heights = np.ma.filled(np.ma.asarray(found.heights()).astype(float), np.nan)
    if heights.ndim != 2:
        raise ValueError("a line scan, not a map")
    unit, sizes = _metres(found.unit), found.physical_sizes
    if sizes is None or unit is None:  # its sizes are in the unit of the heights
        return heights, None, unit
    return heights, (float(sizes[0]) * unit, float(sizes[1]) * unit), unit


_READERS: dict[str, Callable[[Path], _Raw]] = {
    ".npy": _read_npy,
    ".txt": _read_text,
    ".csv": _read_text,
    ".dat": _read_text,
    ".asc": _read_text,
    ".nc": _read_netcdf,
    ".x3p": _read_x3p,
}


def write_topography(path: Path, field: HeightField) -> None:
    """Write heights [m]: .npy and .txt (numbers alone), .nc and .x3p (with size and unit).

    Raises
    ------
    UsageError
        For another suffix.
    """
    writers = {".npy": _write_npy, ".txt": _write_text, ".nc": _write_netcdf, ".x3p": _write_x3p}
    writer = writers.get(path.suffix.lower())
    if writer is None:
        raise UsageError(f"{path}: the suffix must be one of {', '.join(writers)}")
    with atomic_path(path) as draft:
        writer(draft, field)


def _write_npy(path: Path, field: HeightField) -> None:
    with path.open("wb") as file:
        np.save(file, field.heights)


def _write_text(path: Path, field: HeightField) -> None:
    lx, ly = field.lengths
    words = f"heights [m], rows along x, columns along y; size {lx!r} m x {ly!r} m"
    np.savetxt(path, field.heights, fmt="%.17g", header=words)


def _write_netcdf(path: Path, field: HeightField) -> None:
    import netCDF4

    with netCDF4.Dataset(path, "w", format="NETCDF4") as file:
        for axis, count, step in zip("xy", field.shape, field.spacing, strict=True):
            file.createDimension(axis, count)
            positions = file.createVariable(axis, "f8", (axis,))
            positions.units = "m"
            positions[...] = np.arange(count) * step
        variable = file.createVariable("heights", "f8", ("x", "y"), fletcher32=True)
        variable.setncatts({"units": "m", "long_name": "heights, positive towards the elastic body"})
        variable[...] = field.heights


def _write_x3p(path: Path, field: HeightField) -> None:
    (nx, ny), (dx, dy) = field.shape, field.spacing
    axes = "".join(
        f"<{name}><AxisType>{kind}</AxisType><DataType>D</DataType><Increment>{step!r}</Increment>"
        f"<Offset>0</Offset></{name}>"
        for name, kind, step in (("CX", "I", dx), ("CY", "I", dy), ("CZ", "A", 1.0))
    )
    xml = (
        '<?xml version="1.0" encoding="UTF-8"?>'
        '<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2">'
        f"<Record1><Revision>ISO5436 - "
        f"2000</Revision><FeatureType>SUR</FeatureType><Axes>{axes}</Axes></Record1>"
        f"<Record3><MatrixDimension><SizeX>{nx}</SizeX><SizeY>{ny}</SizeY><SizeZ>1</SizeZ></MatrixDimension>"
        "<DataLink><PointDataLink>bindata/data.bin</PointDataLink></DataLink></Record3></p:ISO5436_2>"
    )
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("main.xml", xml)
        archive.writestr("bindata/data.bin", np.ascontiguousarray(field.heights.T, dtype="<f8").tobytes())
