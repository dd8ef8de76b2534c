"""Writers of topographies."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fem_contact.surface import HeightField
from validation.errors import UsageError
from validation.files import atomic_path


def write_topography(path: Path, field: HeightField) -> None:
    """Write heights [m]: .npy and .txt (numbers alone), .nc and .x3p (with size and unit).

    A UsageError for another suffix, and for .x3p without SurfaceTopography, which writes it.
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
    import xarray as xr

    words = {"units": "m", "long_name": "heights, positive towards the elastic body"}
    positions = {
        axis: (axis, np.arange(count) * step, {"units": "m"})
        for axis, count, step in zip("xy", field.shape, field.spacing, strict=True)
    }
    data = xr.Dataset({"heights": (("x", "y"), field.heights, words)}, positions)
    data.to_netcdf(path, encoding={"heights": {"fletcher32": True}}, engine="netcdf4")


def _write_x3p(path: Path, field: HeightField) -> None:
    try:
        from SurfaceTopography import Topography
    except ImportError:
        raise UsageError(
            ".x3p is written by SurfaceTopography: pip install 'fem-contact[topography]'"
        ) from None
    with path.open("wb") as file:
        Topography(np.array(field.heights), field.lengths, unit="m").to_x3p(file)
