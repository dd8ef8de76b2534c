"""The area at loads that are told by the gradient of C(q), read off surfaces that were solved at loads by their own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from validation.arrays import Array
from validation.measures.common import persson_area
from validation.measures.ensemble import Samples

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["BY_SPECTRUM", "LoadedSamples", "at_loads"]

#: A quantity beside those of `Samples`: the area at p* = p0 / (E* h'_rms) with the gradient of C(q).
BY_SPECTRUM = "area_by_spectrum"


def at_loads(
    areas: Array, *, loads: Array, wanted: Array, interpolator: Callable[..., Any] = CubicSpline
) -> Array:
    """Read A/A0 of a surface off between its loads: A over Persson's is interpolated in ln p*.

    Parameters
    ----------
    areas, loads : (n,) arrays
        A/A0 at p*, rising.
    wanted : (m,) array
        p*; a little beyond the first and the last it is extrapolated.
    interpolator : callable
        Of SciPy.
    """
    ratio = areas / persson_area(loads)
    return np.asarray(persson_area(wanted) * interpolator(np.log(loads), ratio)(np.log(wanted)))


@dataclass(frozen=True, kw_only=True)
class LoadedSamples(Samples):
    """Surfaces of one spectrum with the area at both kinds of p*.

    Attributes
    ----------
    loads : (n,) array
        p* of the solves, by the gradient of each surface.
    gradient : float
        h'_rms of C(q).
    """

    loads: Array
    gradient: float

    def _read(self, data: xr.Dataset, name: str, grid: int) -> Array:
        if name != BY_SPECTRUM:
            return super()._read(data, name, grid)
        return at_loads(super()._read(data, "area", grid), loads=self.loads, wanted=self._wanted(data))

    def _wanted(self, data: xr.Dataset) -> Array:
        """Return p* by the gradient of a surface where that by the gradient of C(q) is one of the loads."""
        return np.asarray(self.loads * self.gradient / data.attrs["rms_gradient"])

    def grid_errors(self, name: str) -> Array:
        """Half of the 95 % interval of what the grids leave; that of the area by either load."""
        return super().grid_errors("area" if name == BY_SPECTRUM else name)

    def reading_errors(self) -> Array:
        """Mean distance of `BY_SPECTRUM` by a cubic spline from that by monotone cubics, (load,)."""
        differences = []
        for data in self.ending[0]:
            areas, wanted = super()._read(data, "area", 0), self._wanted(data)
            smooth, monotone = (
                at_loads(areas, loads=self.loads, wanted=wanted, interpolator=kind)
                for kind in (CubicSpline, PchipInterpolator)
            )
            differences.append(smooth - monotone)
        return np.asarray(np.abs(np.mean(differences, axis=0)))
