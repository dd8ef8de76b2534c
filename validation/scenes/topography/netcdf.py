"""Reader of netCDF, that of SurfaceTopography included, which says `length` and `unit` of its axes."""

from __future__ import annotations

from typing import Any

import numpy as np

from validation.arrays import Array
from validation.errors import UsageError
from validation.scenes.topography.raw import Raw, check_shape, even_steps, plain_attribute, real

__all__ = ["read_netcdf"]

_NAMES = ("heights", "height", "h", "z")


def read_netcdf(data: bytes) -> Raw:
    """Read the map called heights, height, h or z, or the only two-dimensional one; x and y give the size."""
    import netCDF4

    try:
        with netCDF4.Dataset("heights.nc", memory=data) as file:
            heights, unit, axes = _read(file)
    except (OSError, RuntimeError) as error:
        said = getattr(error, "strerror", None) or error
        raise UsageError(
            f"cannot be read: it is damaged, cut short or no netCDF (its library says {str(said)[:80]!r})"
        ) from None
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


def _read(file: Any) -> tuple[Array, str | None, list[dict[str, Any]]]:
    """Return heights, their unit, and what the axes say."""
    variable = _map_of(file)
    kind = np.dtype(variable.dtype)
    if kind.kind not in "biuf":
        raise ValueError(f"it holds {kind.name} values; heights are real numbers")
    check_shape(variable.shape)
    for key in {"scale_factor", "add_offset"} & set(variable.ncattrs()):
        # The library would leave the heights unscaled, with a warning that nobody reads.
        _number(variable.getncattr(key), f"{key!r} of {variable.name!r}")
    axes = [_axis(file, name) for name in variable.dimensions]
    values = np.ma.asarray(variable[...])
    heights = np.where(np.ma.getmaskarray(values), np.nan, real(values.data))
    mask = file.variables.get("mask")
    if mask is not None and mask.shape == variable.shape and np.dtype(mask.dtype).kind in "biu":
        heights = np.where(np.ma.getdata(mask[...]) != 0, np.nan, heights)
    return heights, _unit_of(variable), axes


def _number(value: Any, what: str) -> float:
    array = np.asarray(value)
    if array.size != 1 or array.dtype.kind not in "iuf" or not np.isfinite(array).all():
        raise ValueError(f"{what} is no number")
    return float(array.reshape(-1)[0])


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
        said = _number(position.getncattr("length"), f"'length' of {name!r}")
        if not abs(said - axis["length"]) <= 0.02 * axis["length"]:
            raise ValueError(f"'length' of {name!r} is {said:.6g}, its positions say {axis['length']:.6g}")
        axis["length"], axis["says_length"] = said, True
    return axis


def _turned(heights: Array, axes: list[dict[str, Any]]) -> Array:
    """Turn round what is listed against its axis."""
    return heights[:: -1 if axes[0]["falls"] else 1, :: -1 if axes[1]["falls"] else 1]
