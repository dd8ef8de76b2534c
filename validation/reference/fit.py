"""The areas of the reference table by the Nayak parameter, and whether H matters beside it."""

from collections.abc import Sequence

import numpy as np
import scipy.optimize
import xarray as xr

from validation.errors import UsageError
from validation.reference.interpolation import interpolated
from validation.reference.theory import lowest_wave, table_spectrum


def nayak(*, hurst: float, bandwidth: float, lowest: float = 1.0) -> float:
    """Nayak parameter alpha of a self-affine C(q) whose plateau goes from `lowest` to q_long = 1."""
    moments = table_spectrum(hurst=hurst, bandwidth=bandwidth, lowest=lowest).moments()
    return 1.5 * moments.m0 * moments.m4 / moments.m2**2


def bandwidth_at(*, hurst: float, alpha: float, lowest: float = 1.0) -> float:
    """lambda_long/lambda_short of the C(q) that has a Nayak parameter, which grows with it; as for `nayak`.

    Examples
    --------
    >>> round(bandwidth_at(hurst=0.8, alpha=nayak(hurst=0.8, bandwidth=8.0)), 9)
    8.0
    """

    def miss(logarithm: float) -> float:
        return nayak(hurst=hurst, bandwidth=float(np.exp(logarithm)), lowest=lowest) - alpha

    return float(np.exp(scipy.optimize.brentq(miss, 1e-3, np.log(1e4), xtol=1e-12)))


def at_equal_alpha(table: xr.Dataset, alphas: Sequence[float]) -> xr.Dataset:
    """Interpolate the areas of a table to equal Nayak parameters of C(q), along the bandwidth.

    `area`, `area_error` and `bandwidth` over (alpha, hurst, reduced_pressure); NaN outside of the table.

    Parameters
    ----------
    table : xarray.Dataset
        Of one kind of amplitudes, over (hurst, bandwidth, reduced_pressure).
    """
    hursts, loads = table.hurst.values, table.reduced_pressure.values
    lowest = lowest_wave(**table.attrs)
    bandwidths = np.array([[bandwidth_at(hurst=h, alpha=a, lowest=lowest) for h in hursts] for a in alphas])
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
