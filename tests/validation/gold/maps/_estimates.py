"""Numbers that datasets held before errors were kept by source: standard errors, and what they come to."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import xarray as xr

from validation.report.estimates import NORMAL

__all__ = ["deviation", "grid_error", "joined", "per_load", "surfaces_error"]

Numbers = Callable[[xr.Dataset], xr.DataArray]


def grid_error(name: str) -> Numbers:
    """Standard error of the grids, of each surface."""
    return lambda d: d[f"{name}_each_error"].sel(source="grid", drop=True) / NORMAL


def deviation(name: str) -> Numbers:
    """Standard error of the grids, root mean square over the surfaces."""
    return lambda d: (grid_error(name)(d) ** 2).mean("surface") ** 0.5


def surfaces_error(name: str) -> Numbers:
    """Standard error of the surfaces."""
    return lambda d: d[f"{name}_each"].std("surface", ddof=1) / d.sizes["surface"] ** 0.5


def joined(name: str) -> Numbers:
    """Both together."""
    return lambda d: np.hypot(surfaces_error(name)(d), deviation(name)(d))


def per_load(values: xr.DataArray, d: xr.Dataset) -> xr.DataArray:
    """Return minus the difference quotient against the logarithm of the load."""
    axis = values.get_axis_num("load")
    return values.copy(data=-np.gradient(values.values, np.log(d.reduced_pressure.values), axis=axis))
