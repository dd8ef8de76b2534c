"""Writers of topographies."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from fem_contact.surface import HeightField
from validation.errors import UsageError
from validation.files import atomic_path

__all__ = ["write_topography"]


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
