"""Reader of netCDF, that of SurfaceTopography included, whose sizes and units stand as `length` and `unit`."""

from __future__ import annotations

from typing import Any

import numpy as np

from validation.scenes.topography.raw import Array, Raw, check_shape, even_steps, plain_attribute, real

__all__ = ["read_netcdf"]

_NAMES = ("heights", "height", "h", "z")


def read_netcdf(data: bytes) -> Raw:
    """Read the map called heights, height, h or z, or the only two-dimensional one; x and y give the size."""
    import netCDF4

    with netCDF4.Dataset("heights.nc", memory=data) as file:
        variable = _map_of(file)
        kind = np.dtype(variable.dtype)
        if kind.kind not in "biuf":
            raise ValueError(f"it holds {kind.name} values; heights are real numbers")
        check_shape(variable.shape)
        axes = [_axis(file, name) for name in variable.dimensions]
        values = np.ma.asarray(variable[...])
        heights = np.ma.filled(np.ma.asarray(real(values.data), dtype=float), np.nan)
        heights = np.where(np.ma.getmaskarray(values), np.nan, heights)
        if "mask" in file.variables and file.variables["mask"].shape == variable.shape:
            heights = np.where(np.ma.getdata(file.variables["mask"][...]) != 0, np.nan, heights)
        unit = _unit_of(variable)
    heights = _turned(heights, axes)
    sizes = [axis["length"] for axis in axes]
    units = [axis["unit"] for axis in axes]
    # SurfaceTopography says one unit for all, on the axes.
    if unit is None and all(axis["says_length"] for axis in axes) and units[0] == units[1]:
        unit = units[0]
    # Positions without a unit may be plain numbers of points.
    if None in sizes or None in units:
        return Raw(heights=heights, unit=unit)
    return Raw(heights=heights, lengths=(sizes[0], sizes[1]), length_units=(units[0], units[1]), unit=unit)


def _map_of(file: Any) -> Any:
    maps: dict[str, Any] = {
        name: v for name, v in file.variables.items() if v.ndim == 2 and name.lower() != "mask"
    }
    named = [name for name in _NAMES if name in maps] or list(maps)
    if not named or (len(named) > 1 and named[0] not in _NAMES):
        listed = ", ".join(list(file.variables)[:8]) or "none"
        raise ValueError(f"no variable 'heights' among {listed}")
    return maps[named[0]]


def _unit_of(variable: Any) -> str | None:
    for key in ("units", "unit"):
        if key in variable.ncattrs():
            return plain_attribute(variable.getncattr(key), f"{key!r} of {variable.name!r}")
    return None


def _axis(file: Any, name: str) -> dict[str, Any]:
    """Return length, unit and direction of an axis; None for what it does not say."""
    axis: dict[str, Any] = {"length": None, "unit": None, "says_length": False, "falls": False}
    if name not in file.variables:
        return axis
    position = file.variables[name]
    if position.ndim != 1 or np.dtype(position.dtype).kind not in "biuf":
        raise ValueError(f"{name!r} holds no positions")
    axis["unit"] = _unit_of(position)
    x = np.ma.filled(np.ma.asarray(position[...]).astype(float), np.nan)
    try:
        step = even_steps(x, name)
    except ValueError as error:
        raise ValueError(f"{error}; interpolate the heights onto an even grid") from None
    axis["length"], axis["falls"] = abs(step) * x.size, step < 0
    if "length" in position.ncattrs():
        length = np.asarray(position.getncattr("length"))
        if length.shape not in ((), (1,)) or length.dtype.kind not in "iuf":
            raise ValueError(f"'length' of {name!r} is no number")
        said = float(length.reshape(-1)[0])
        if not abs(said - axis["length"]) <= 0.02 * axis["length"]:
            raise ValueError(f"'length' of {name!r} is {said:.6g}, its positions say {axis['length']:.6g}")
        axis["length"], axis["says_length"] = said, True
    return axis


def _turned(heights: Array, axes: list[dict[str, Any]]) -> Array:
    """Turn round what is listed against its axis."""
    return heights[:: -1 if axes[0]["falls"] else 1, :: -1 if axes[1]["falls"] else 1]
