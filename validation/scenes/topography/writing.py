"""Writers of topographies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from fem_contact.surface import HeightField
from validation.errors import UsageError
from validation.files import atomic_path


def heights_over_places(field: HeightField) -> xr.DataArray:
    """Return heights [m] over x and y [m]."""
    axes = {
        axis: (axis, np.arange(n) * step, {"units": "m"})
        for axis, n, step in zip("xy", field.shape, field.spacing, strict=True)
    }
    about = {"units": "m", "long_name": "height, positive towards the elastic body"}
    return xr.DataArray(field.heights, dims=("x", "y"), coords=axes, name="heights", attrs=about)


def write_topography(path: Path, field: HeightField) -> None:
    """Write heights [m]: .npy and .txt (numbers alone), .nc and .x3p (with size and unit).

    A UsageError for another suffix, and for .x3p without SurfaceTopography, which writes it.
    """
    suffix, lengths = path.suffix.lower(), field.lengths
    if suffix not in (".npy", ".txt", ".nc", ".x3p"):
        raise UsageError(f"{path}: the suffix must be one of .npy, .txt, .nc, .x3p")
    with atomic_path(path) as draft:
        if suffix == ".npy":
            with draft.open("wb") as file:
                np.save(file, field.heights)
        elif suffix == ".txt":
            size = f"{lengths[0]!r} m x {lengths[1]!r} m"
            header = f"heights [m], rows along x, columns along y; size {size}"
            np.savetxt(draft, field.heights, fmt="%.17g", header=header)
        elif suffix == ".nc":
            heights_over_places(field).to_netcdf(
                draft, encoding={"heights": {"fletcher32": True}}, engine="netcdf4"
            )
        else:
            try:
                from SurfaceTopography import Topography
            except ImportError:
                raise UsageError(
                    ".x3p is written by SurfaceTopography: pip install 'fem-contact[topography]'"
                ) from None
            with draft.open("wb") as file:
                Topography(np.array(field.heights), lengths, unit="m").to_x3p(file)
