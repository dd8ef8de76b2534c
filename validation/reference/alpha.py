"""The reference table at equal Nayak parameter: whether the Hurst exponent matters beside it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import scipy.optimize

from validation.errors import UsageError
from validation.reference.fit import nayak
from validation.reference.interpolation import interpolated

if TYPE_CHECKING:
    import xarray as xr


def bandwidth_at(*, hurst: float, alpha: float) -> float:
    """lambda_long/lambda_short of the self-affine C(q) that has a Nayak parameter, which grows with it.

    Examples
    --------
    >>> round(bandwidth_at(hurst=0.8, alpha=nayak(hurst=0.8, bandwidth=8.0)), 9)
    8.0
    """

    def miss(logarithm: float) -> float:
        return nayak(hurst=hurst, bandwidth=float(np.exp(logarithm))) - alpha

    return float(np.exp(scipy.optimize.brentq(miss, 1e-3, np.log(1e4), xtol=1e-12)))


def at_equal_alpha(table: xr.Dataset, alphas: Sequence[float]) -> xr.Dataset:
    """Interpolate the areas of a table to equal Nayak parameters of C(q), along the bandwidth.

    `area`, `area_error` and `bandwidth` over (alpha, hurst, reduced_pressure); NaN outside of the table.

    Parameters
    ----------
    table : xarray.Dataset
        Of one kind of amplitudes, over (hurst, bandwidth, reduced_pressure).
    """
    import xarray as xr

    hursts, loads = table.hurst.values, table.reduced_pressure.values
    bandwidths = np.array([[bandwidth_at(hurst=h, alpha=a) for h in hursts] for a in alphas])
    values = np.full((2, *bandwidths.shape, loads.size), np.nan)
    for (i, j, k), _ in np.ndenumerate(values[0]):
        point = {"hurst": hursts[j], "bandwidth": bandwidths[i, j], "reduced_pressure": loads[k]}
        try:
            value = interpolated(table.isel(hurst=[j]), "area", point)
        except UsageError:
            continue  # outside of the table, or beside a cell that it has not
        values[:, i, j, k] = value.value, value.uncertainty
    dims = ("alpha", "hurst", "reduced_pressure")
    return xr.Dataset(
        {"area": (dims, values[0]), "area_error": (dims, values[1]), "bandwidth": (dims[:2], bandwidths)},
        coords={"alpha": list(alphas), "hurst": hursts, "reduced_pressure": loads},
    )
