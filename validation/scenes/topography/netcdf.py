"""Reader of netCDF, with the units, positions and fill values that SurfaceTopography's does not know."""

from __future__ import annotations

from typing import Any

import numpy as np

from validation.errors import UsageError
from validation.scenes.topography.raw import Raw, check_shape, even_steps, plain_attribute, real

_NAMES = ("heights", "height", "h", "z")


def read_netcdf(data: bytes) -> Raw:
    """Read the map called heights, height, h or z, or the only two-dimensional one; x and y give the size."""
    import netCDF4

    try:
        with netCDF4.Dataset("heights.nc", memory=data) as file:
            return _read(file)
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise UsageError(
            f"cannot be read: it is damaged, cut short or no netCDF (its library says {str(reason)[:80]!r})"
        ) from None


def _read(file: Any) -> Raw:
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
