"""Elastic contact without adhesion: the closed forms of the theory (Persson 2006, Secs. 3.4 and 4).

All functions take numbers or arrays, broadcast together, and return scalars for scalars. Fed with the
integrals of C(q) they describe the ensemble; fed with the moments of one realisation, that surface.
"""

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erf, erfc, erfinv

from persson._checks import Array, alike, non_negative, positive, real
from persson.errors import InvalidInput
from persson.spectrum import Spectrum, check_spectrum

#: Slope of A/A0 against p* = p0/(E* h'_rms) at light load, Persson 2006, Eqs. 13 and 22:
#: sqrt(8/pi) = 1.596.
KAPPA_PERSSON = math.sqrt(8 / math.pi)
#: The same slope in the asperity theory of Bush, Gibson and Thomas (1975): sqrt(2 pi) = 2.507.
KAPPA_BGT = math.sqrt(2 * math.pi)
#: Why there is no distribution without roughness.
_DELTA = "the stress distribution is a delta function at the nominal pressure"


def stress_variance(m2: ArrayLike, *, contact_modulus: float) -> Array:
    r"""Variance of the interfacial stress at full contact.

    .. math:: V(\zeta) = \tfrac14 E^{*2}\, m_2(\zeta) = 2\int_1^\zeta f\,d\zeta'

    Parameters
    ----------
    m2 : float or array
        Mean square gradient of the roughness that is resolved, ``spectrum.m2(zeta * q_reference)`` [-].
    contact_modulus : float
        E* [Pa].

    Notes
    -----
    Persson 2006, Eqs. 17 and 18.

    Examples
    --------
    >>> float(stress_variance(0.01, contact_modulus=2.0e6))
    10000000000.0
    """
    half = positive("contact_modulus", contact_modulus) / 2
    return non_negative("m2", m2, power=2) * (half * half)


def diffusion_parameter(pressure: float, *, stress_variance: ArrayLike) -> Array:
    """G = V / (2 sigma0^2) [-] of Persson 2006, Eq. 21, for pressure sigma0 > 0 [Pa] and V [Pa^2]."""
    load = positive("pressure", pressure)
    return non_negative("stress_variance", stress_variance, power=2) / (2 * load * load)


def _argument(pressure: ArrayLike, variance: ArrayLike) -> Array:
    """sigma0 / sqrt(2 V), infinite where V = 0 under load and 0 without load."""
    load = non_negative("pressure", pressure)
    width = np.sqrt(2 * non_negative("stress_variance", variance, power=2))
    alike(pressure=load, stress_variance=width)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.where(load > 0, load / width, 0.0)


def contact_area(pressure: ArrayLike, *, stress_variance: ArrayLike) -> Array:
    r"""Relative area of real contact of an elastic solid, without adhesion.

    .. math:: A/A_0 = \operatorname{erf}\bigl(\sigma_0/\sqrt{2V}\bigr)

    Parameters
    ----------
    pressure : float or array
        Nominal pressure sigma_0 [Pa], not negative.
    stress_variance : float or array
        V, the variance of the interfacial stress at full contact [Pa^2]. With V = 0 any load closes the
        contact.

    Raises
    ------
    InvalidInput
        For a negative or non-finite argument.

    Notes
    -----
    Persson 2006, Eq. 20 with the upper limit of its integral corrected to 1/sqrt(G). Exact at full
    contact. At A/A0 from .03 to .1 and H = .8 it lies below converged computations by 30 % where the
    waves span a factor 8 and by 20 % where they span 100; at A/A0 = .27 by 28 and 15 %, near full contact
    by nothing (docs/theory.md). The digits of 1 - A/A0 are in `non_contact_area`.

    Examples
    --------
    >>> round(float(contact_area(1.0, stress_variance=1.0)), 6)
    0.682689
    """
    return erf(_argument(pressure, stress_variance))


def non_contact_area(pressure: ArrayLike, *, stress_variance: ArrayLike) -> Array:
    """1 - A/A0 = erfc(sigma0 / sqrt(2V)), without loss of digits near full contact.

    Arguments as for `contact_area`.
    """
    return erfc(_argument(pressure, stress_variance))


def pressure_for_area(area: ArrayLike, *, stress_variance: ArrayLike) -> Array:
    """Nominal pressure [Pa] at which `contact_area` equals `area`, in [0, 1).

    Examples
    --------
    >>> p = pressure_for_area(0.25, stress_variance=9.0)
    >>> round(float(contact_area(p, stress_variance=9.0)), 12)
    0.25
    """
    fraction = non_negative("area", area)
    if np.any(fraction >= 1):
        raise InvalidInput(
            f"area = {float(np.max(fraction))!r}: must lie in [0, 1); full contact needs infinite pressure"
        )
    variance = non_negative("stress_variance", stress_variance, power=2)
    alike(area=fraction, stress_variance=variance)
    return np.sqrt(2 * variance) * erfinv(fraction)


def area_against_magnification(
    spectrum: Spectrum,
    *,
    pressure: ArrayLike,
    contact_modulus: float,
    magnification: ArrayLike,
    q_reference: float,
) -> Array:
    """Relative contact area A(zeta)/A0 seen with the roughness up to q = zeta q_reference.

    Parameters
    ----------
    spectrum : Spectrum
        C(q).
    pressure : float or array
        Nominal pressure [Pa].
    contact_modulus : float
        E* [Pa].
    magnification : float or array
        zeta [-], broadcast against the pressure.
    q_reference : float
        Wavevector at zeta = 1 [1/m]: 2 pi / L, or q_long where the paper uses q0.

    Notes
    -----
    Persson 2006, Eqs. 18, 20 and 21.
    """
    check_spectrum(spectrum)
    q_upper = non_negative("magnification", magnification) * positive("q_reference", q_reference)
    variance = stress_variance(spectrum.m2(q_upper), contact_modulus=contact_modulus)
    return contact_area(pressure, stress_variance=variance)


def pressure_distribution(stress: ArrayLike, *, pressure: ArrayLike, stress_variance: ArrayLike) -> Array:
    r"""Distribution of contact pressure, P(sigma).

    .. math:: P(\sigma) = \frac{1}{\sqrt{2\pi V}}
              \left[e^{-(\sigma-\sigma_0)^2/2V} - e^{-(\sigma+\sigma_0)^2/2V}\right],\quad \sigma > 0

    Parameters
    ----------
    stress : float or array
        sigma [Pa]; P vanishes for sigma <= 0.
    pressure : float or array
        sigma_0 [Pa].
    stress_variance : float or array
        V [Pa^2], positive: at V = 0 the distribution is a delta function.

    Returns
    -------
    array
        P [1/Pa] per nominal area: it integrates to A/A0 (Persson 2006, Eq. 16). The delta function of the
        non-contact area at sigma = 0 is left out. Divide by `contact_area` for the distribution per contact
        area.

    Examples
    --------
    >>> float(pressure_distribution(0.0, pressure=1.0, stress_variance=2.0))
    0.0
    """
    load = non_negative("pressure", pressure)
    width = np.sqrt(non_negative("stress_variance", stress_variance, power=2, zero=_DELTA))
    sigma = np.maximum(real("stress", stress), 0.0)
    alike(stress=sigma, pressure=load, stress_variance=width)
    sigma = sigma / width
    mean = load / width
    # One Gaussian times 1 - exp(-2 sigma sigma0 / V): the difference itself would cancel for small sigma
    # sigma0.
    with np.errstate(under="ignore"):
        gauss = np.exp(-0.5 * (sigma - mean) ** 2) / math.sqrt(2 * math.pi)
        return -gauss * np.expm1(-2 * sigma * mean) / width


def initial_slope(pressure: ArrayLike, *, stress_variance: ArrayLike) -> Array:
    r"""Slope of P(sigma) at sigma = 0 [1/Pa^2].

    .. math:: P'(0) = \frac{2\sigma_0}{V\sqrt{2\pi V}}\,e^{-\sigma_0^2/2V}

    Parameters
    ----------
    pressure : float or array
        sigma_0 [Pa].
    stress_variance : float or array
        V [Pa^2], positive.

    Notes
    -----
    dA/dV = -P'(0)/2: the area lost per added roughness. Below computed distributions by 2.35 at p* = .05 and
    1.7 at .3 (H = .8, waves that span a factor 32).
    """
    width = np.sqrt(non_negative("stress_variance", stress_variance, power=2, zero=_DELTA))
    load = non_negative("pressure", pressure)
    alike(pressure=load, stress_variance=width)
    mean = load / width
    with np.errstate(under="ignore"):
        return 2 * mean * np.exp(-0.5 * mean**2) / math.sqrt(2 * math.pi) / width / width


def reduced_pressure(pressure: ArrayLike, *, contact_modulus: float, rms_gradient: float) -> Array:
    """p* = p0 / (E* h'_rms) [-] for pressure [Pa], contact modulus [Pa] and rms gradient [-]."""
    scale = positive("contact_modulus", contact_modulus) * positive("rms_gradient", rms_gradient)
    return real("pressure", pressure) / scale


def kappa(area: ArrayLike, *, reduced_pressure: ArrayLike) -> Array:
    """Secant slope kappa = (A/A0) / p* [-] of any relative area, computed or theoretical, at p* > 0."""
    needed = "the secant slope needs a load; its limit in the theory is KAPPA_PERSSON"
    load = non_negative("reduced_pressure", reduced_pressure, zero=needed)
    fraction = non_negative("area", area)
    alike(area=fraction, reduced_pressure=load)
    return fraction / load


def persson_kappa(reduced_pressure: ArrayLike) -> Array:
    """Secant slope erf(sqrt(2) p*) / p* of the theory; KAPPA_PERSSON at p* = 0.

    Examples
    --------
    >>> float(persson_kappa(0.0)) == KAPPA_PERSSON
    True
    """
    load = non_negative("reduced_pressure", reduced_pressure)
    safe = np.where(load > 0, load, 1.0)
    return np.where(load > 0, erf(math.sqrt(2) * safe) / safe, KAPPA_PERSSON)[()]
