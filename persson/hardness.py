"""Elastoplastic contact: a solid that yields at its indentation hardness (Persson 2006, Secs. 6 and 7)."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erf, erfc

from persson._checks import Array, function, instance, non_negative, positive
from persson.diffusion import Diffusion, solve_diffusion
from persson.errors import InvalidInput, OutsideTheory
from persson.scale import Scale, of_variance

#: V / sigma_Y^2 up to which images converge faster than the eigenfunction series.
_IMAGES = 0.35


@dataclass(frozen=True, kw_only=True)
class ContactAreas:
    """Parts of the nominal area; they add up to 1.

    Attributes
    ----------
    elastic, plastic, detached : array
        A_el/A0, A_pl/A0 and the non-contact area.
    """

    elastic: Array
    plastic: Array
    detached: Array


def constant_hardness(pressure: float, *, stress_variance: ArrayLike, yield_stress: float) -> ContactAreas:
    r"""Elastic and plastic contact area of a solid with one hardness, in closed form.

    .. math:: \frac{A_\mathrm{pl}}{A_0} = \sum_{k \ge 0} \operatorname{erfc}\frac{2k+1-x}{\sqrt{2v}}
              - \operatorname{erfc}\frac{2k+1+x}{\sqrt{2v}}
              = x + \sum_{n \ge 1} \frac{2 (-1)^n}{n\pi} \sin(n\pi x)\, e^{-n^2\pi^2 v/2}

    with x = sigma_0/sigma_Y and v = V/sigma_Y^2; the first form is summed at small v, the second at large v.

    Parameters
    ----------
    pressure : float
        sigma_0 [Pa], in (0, sigma_Y).
    stress_variance : float or array
        V [Pa^2].
    yield_stress : float
        Hardness sigma_Y [Pa].

    Notes
    -----
    Persson 2006, Eqs. 27-32: P(sigma) vanishes at 0 and at sigma_Y. As V grows A_pl tends to sigma_0/sigma_Y.

    Examples
    --------
    >>> areas = constant_hardness(1e7, stress_variance=1e30, yield_stress=1e9)
    >>> float(areas.plastic), float(areas.elastic)
    (0.01, 0.0)
    """
    load = positive("pressure", pressure)
    hardness = positive("yield_stress", yield_stress)
    if load >= hardness:
        raise OutsideTheory(f"pressure = {load!r} Pa: must stay below yield_stress = {hardness!r} Pa")
    variance = non_negative("stress_variance", stress_variance, power=2)
    root = np.sqrt(variance) / hardness
    v = root * root
    x, y = load / hardness, (hardness - load) / hardness
    near = v < _IMAGES
    width = math.sqrt(2) * np.where(near & (root > 0), root, 1.0)
    late = np.where(near, _IMAGES, np.minimum(v, 500.0))
    plastic = np.where(near, _crossed(x, width), _crossed_series(x, late))
    detached = np.where(near, _crossed(y, width), _crossed_series(y, late))
    elastic = np.where(near, _staying(min(x, y), width), _staying_series(min(x, y), late))
    still = root == 0
    return ContactAreas(
        elastic=np.where(still, 1.0, elastic)[()],
        plastic=np.where(still, 0.0, plastic)[()],
        detached=np.where(still, 0.0, detached)[()],
    )


def _erf_band(middle: ArrayLike, half: ArrayLike) -> Array:
    """Erf(m + h) - erf(m - h) without loss of digits for small h."""
    m, h = np.asarray(middle, dtype=float), np.asarray(half, dtype=float)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    t = m[..., None] + h[..., None] * nodes
    narrow = 2 / math.sqrt(math.pi) * h * (np.exp(-t * t) @ weights)
    wide = np.where(m > h, erfc(m - h) - erfc(m + h), erf(m + h) - erf(m - h))
    return np.where(h < 0.1, narrow, wide)


def _crossed(x: float, width: Array) -> Array:
    """Share that has reached 1 before 0 when started at x, by images; six reach exp(-300)."""
    return sum((_erf_band((2 * k + 1) / width, x / width) for k in range(6)), start=np.zeros(width.shape))


def _staying(x: float, width: Array) -> Array:
    bands = ((-1) ** j * _erf_band(j / width, x / width) for j in range(1, 12))
    return sum(bands, start=erf(x / width))


def _crossed_series(x: float, v: Array) -> Array:
    """Return the same by eigenfunctions, for v >= 0.35, where twelve terms leave exp(-250)."""
    return sum(((-1) ** n * _eigenfunction(n, x, v) for n in range(1, 13)), start=np.full(v.shape, x))


def _staying_series(x: float, v: Array) -> Array:
    return sum((2 * _eigenfunction(n, x, v) for n in range(1, 13, 2)), start=np.zeros(v.shape))


def _eigenfunction(n: int, x: float, v: Array) -> Array:
    wave = n * math.pi
    return 2 / wave * math.sin(wave * x) * np.exp(-0.5 * wave**2 * v)


def size_dependent_hardness(
    scale: Scale,
    *,
    pressure: float,
    yield_stress: Callable[[Array], Array],
    wavevectors: ArrayLike,
    tolerance: float = 1e-6,
) -> Diffusion:
    """Elastoplastic contact with a hardness that rises towards short wavelengths.

    Parameters
    ----------
    scale : Scale
        Stress variance against wavevector, of a spectrum and a modulus.
    pressure : float
        sigma_0 [Pa].
    yield_stress : callable
        sigma_Y(q) [Pa] for an array of wavevectors [1/m]; must not decrease.
    wavevectors : (n,) array
        Cut-offs q [1/m] at which results are wanted, increasing.
    tolerance : float
        As for `persson.diffusion.solve_diffusion`.

    Raises
    ------
    OutsideTheory
        For a hardness that falls with q: the density at the yield stress would have to be negative.

    Notes
    -----
    Persson 2006, Eqs. 33 and 34.
    """
    instance("scale", scale, Scale)
    function("yield_stress", yield_stress)
    q = np.atleast_1d(non_negative("wavevectors", wavevectors))
    if q.ndim != 1 or q.size == 0 or np.any(np.diff(q) < 0):
        raise InvalidInput("wavevectors: must be a sequence of values that increase")
    return solve_diffusion(
        scale.variance(q),
        pressure=pressure,
        yield_stress=of_variance(yield_stress, scale),
        tolerance=tolerance,
    )
