"""A closed form of the areas of the reference table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.optimize
import scipy.special
from numpy.typing import ArrayLike

from persson.spectrum import SelfAffine
from validation.arrays import Array

if TYPE_CHECKING:
    import xarray as xr

#: c_0, c_1, p_1 and n of `fitted_area`: least squares of the relative distance from the table.
FIT = (0.5606, 0.05449, 0.1893, 1.0067)


def nayak(*, hurst: float, bandwidth: float) -> float:
    """Nayak parameter alpha of a self-affine C(q), from its integrals."""
    spectrum = SelfAffine.from_rms_gradient(1.0, hurst=hurst, q_long=1.0, q_short=bandwidth)
    return float(1.5 * spectrum.m0() * spectrum.m4() / spectrum.m2() ** 2)


def fitted_area(
    reduced_pressure: ArrayLike, *, alpha: ArrayLike, constants: tuple[float, ...] = FIT
) -> Array:
    r"""A/A0 at p* for a Nayak parameter alpha, in a closed form.

    .. math:: A/A_0 = \operatorname{erf}(\sqrt2 \, g \, p^*), \qquad
              g = 1 + \frac{c_0 - c_1 \ln \alpha}{1 + (p^*/p_1)^n}

    g = 1 is Persson's theory. docs/reference_table.md has the largest error over the table.

    Parameters
    ----------
    reduced_pressure : float or array
        p* = p0 / (E* h'_rms).
    alpha : float or array
        Of C(q); it is to be one of the table's, 2.4 to 20 or so.
    constants : tuple of float
        c_0, c_1, p_1, n.

    Examples
    --------
    >>> round(float(fitted_area(0.05, alpha=nayak(hurst=0.8, bandwidth=8))), 3)
    0.109
    """
    load = np.asarray(reduced_pressure, dtype=float)
    light, slope, middle, power = constants
    excess = (light - slope * np.log(alpha)) / (1 + (load / middle) ** power)
    return np.asarray(scipy.special.erf(np.sqrt(2) * load * (1 + excess)))


def fitted(table: xr.Dataset) -> tuple[tuple[float, ...], xr.DataArray]:
    """Fit the closed form to a table of one kind of amplitudes: constants, relative distances."""
    import xarray as xr

    alpha = xr.DataArray(
        [[nayak(hurst=float(h), bandwidth=float(b)) for b in table.bandwidth] for h in table.hurst],
        dims=("hurst", "bandwidth"),
    )

    def distance(constants: Array) -> xr.DataArray:
        law = fitted_area(
            table.reduced_pressure.values, alpha=alpha.values[..., None], constants=tuple(constants)
        )
        areas: xr.DataArray = table.area.transpose("hurst", "bandwidth", "reduced_pressure")
        return xr.DataArray(law, dims=areas.dims) / areas - 1

    def misses(constants: Array) -> Array:
        values = distance(constants).values
        return np.asarray(values[np.isfinite(values)])

    best = scipy.optimize.least_squares(misses, np.array(FIT)).x
    return tuple(float(value) for value in best), distance(best)
