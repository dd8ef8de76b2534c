"""Mean separation, elastic energy and stiffness of an elastic contact, and the macroasperities in it."""

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erf, exp1

from persson._checks import Array, instance, non_negative, positive, within
from persson._quadrature import panels
from persson.elastic import area_against_magnification
from persson.errors import OutsideTheory
from persson.scale import Scale
from persson.spectrum import Spectrum, check_spectrum
from persson.stretched import Stretched
from persson.tabulated import Tabulated
from persson.variants import EnergyReading, energy_share

#: Least d^2 ln A / d(ln zeta)^2 that is a bend: second differences of rounded areas leave some 1e-10.
_BEND = 1e-6


def elastic_energy(pressure: ArrayLike, *, scale: Scale, energy: EnergyReading = "old") -> Array:
    r"""Elastic energy stored at the interface, per nominal area, without adhesion.

    .. math:: \frac{U_\mathrm{el}}{A_0} = \int \frac{dV}{E^* q}\, \tilde P, \qquad
              \tilde P = P = \operatorname{erf}\frac{\sigma_0}{\sqrt{2V}} \text{ ("old")}

    Parameters
    ----------
    pressure : float or (n,) array
        Nominal pressure sigma_0 [Pa].
    scale : Scale
        Spectrum and modulus.
    energy : str
        P~ as `persson.variants.energy_share` has it: "old", Eq. 43 of Persson 2006; "improved", Eqs. 44-49;
        "as_printed", Eq. 50; and the variants.

    Returns
    -------
    array
        U_el/A_0 [J/m^2]; at full contact (E*/4) int d^2q q C, whatever the reading.

    Notes
    -----
    Persson 2006, Secs. 8.2 and 8.3. Without adhesion P~ exceeds P at light load and tends to 2 P
    (docs/errata.md); computed energies lie below Eq. 43 there, by half at p* = .05 and more below Eq. 48.
    """
    load = non_negative("pressure", pressure)
    variance, length = _waves(scale)
    share = energy_share(load[..., None], stress_variance=variance, energy=energy)
    return share @ length


def contact_stiffness(pressure: ArrayLike, *, scale: Scale, energy_ratio: float = 1.0) -> Array:
    r"""Stiffness of the interface, by how much the pressure rises as the surfaces approach.

    .. math:: K = -\frac{d\sigma_0}{d\bar u} = \sigma_0 \Big/ \frac{d(U_\mathrm{el}/A_0)}{d\sigma_0}

    Parameters
    ----------
    pressure : float or (n,) array
        Nominal pressure [Pa], positive.
    scale, energy_ratio
        As for `mean_separation`.

    Returns
    -------
    array
        K per nominal area [Pa/m]: of the roughness alone, without the solid behind it. At light load it is
        proportional to the pressure; infinite where nothing is left to close.

    Notes
    -----
    From p du = -dU, as `mean_separation`; the derivative of the energy is taken under the integral. Near full
    contact the computed gap is several times the theory's, and so the stiffness is too large.
    """
    load, s, length = _loaded_waves(pressure, scale, energy_ratio)
    with np.errstate(under="ignore"):
        rate = (energy_ratio + 3 * (1 - energy_ratio) * erf(s) ** 2) * np.exp(-np.minimum(s * s, 700.0))
        softness = 2 / math.sqrt(math.pi) * (rate @ length)
    with np.errstate(divide="ignore", over="ignore"):
        return load / softness


def _loaded_waves(pressure: ArrayLike, scale: Scale, energy_ratio: float) -> tuple[Array, Array, Array]:
    """Load [Pa], s = sigma_0 / sqrt(2 V) of the waves, and their energy of full contact over sqrt(2 V)."""
    within("energy_ratio", energy_ratio, "(0, 1]")
    apart = "must be positive; without load the surfaces are not held together"
    load = non_negative("pressure", pressure, zero=apart)
    variance, length = _waves(scale)
    root = np.sqrt(2 * variance)
    return load, load[..., None] / root, length / root


def _waves(scale: Scale) -> tuple[Array, Array]:
    """V [Pa^2] and the energy of full contact dV/(E* q) [J/m^2] that belongs to it, to sum over."""
    instance("scale", scale, Scale)
    top = float(scale.variance(scale.q_short))
    t, weight = panels(np.linspace(-30.0, 0.0, 241), 5)
    variance = top * np.exp(t)
    wave = scale.wavevector(variance)
    return variance, variance / (scale.modulus(wave) * wave) * weight


def mean_separation(pressure: ArrayLike, *, scale: Scale, energy_ratio: float = 1.0) -> Array:
    r"""Mean distance of the surfaces under load.

    .. math:: \bar u(p) = \int_p^\infty \frac{dp'}{p'} \frac{dU_\mathrm{el}}{dp'}, \qquad
              U_\mathrm{el} = \int \frac{dV}{E^* q}\, P\,[g + (1-g) P^2]

    Parameters
    ----------
    pressure : float or (n,) array
        Nominal pressure [Pa], positive.
    scale : Scale
        Spectrum and modulus.
    energy_ratio : float
        g in (0, 1]: 1 for the energy of Persson 2006, Eq. 43; 0.45 with the correction of Yang and Persson
        (2008).

    Returns
    -------
    array
        Mean gap [m]; at light load it falls with the logarithm of the pressure.

    Notes
    -----
    The work of the load is stored elastically, p du = -dU (Persson, Phys. Rev. Lett. 99, 125502, 2007; Yang
    and Persson, J. Phys. Condens. Matter 20, 215214, 2008), with dV = (E*^2/4) 2 pi q^3 C dq.
    """
    _, s, length = _loaded_waves(pressure, scale, energy_ratio)
    return 2 / math.sqrt(math.pi) * (opening_integral(s, energy_ratio) @ length)


def opening_integral(s: Array, energy_ratio: float) -> Array:
    """Int_s^inf [g + 3 (1 - g) erf(t)^2] exp(-t^2) dt / t, for s > 0."""
    integral = energy_ratio * 0.5 * exp1(np.minimum(s * s, 700.0))
    if energy_ratio < 1:
        # Int_s^inf erf(t)^2 exp(-t^2) dt / t, by Gauss-Legendre on [s, s + 7] in panels.
        points, weights = panels(np.arange(8.0), 10)
        t = s[..., None] + points
        with np.errstate(under="ignore"):
            partial = (erf(t) ** 2 * np.exp(-t * t) / t) @ weights
        integral = integral + 3 * (1 - energy_ratio) * partial
    return integral


def macroasperity_magnification(
    spectrum: Spectrum, *, pressure: float, contact_modulus: float, q_reference: float
) -> float:
    """Magnification zeta_m at which the logarithm of the contact area bends most, d^2 ln A / d(ln zeta)^2.

    The contact regions seen at zeta_m are the macroasperities (Persson 2006, Sec. 3.6); the paper expects 1
    to 5.

    Parameters
    ----------
    spectrum : Spectrum
        C(q) with a smooth roll-off.
    pressure, contact_modulus : float
        sigma_0 and E* [Pa].
    q_reference : float
        Wavevector at zeta = 1 [1/m], the roll-off q_0 in the paper.

    Raises
    ------
    OutsideTheory
        For a spectrum that begins or bends with a kink, which would itself be the point of largest
        curvature, or where the curvature has no maximum inside the spectrum.
    """
    q0 = positive("q_reference", q_reference)
    check_spectrum(spectrum)
    load = positive("pressure", pressure)
    isotropic = spectrum.spectrum if isinstance(spectrum, Stretched) else spectrum
    if isinstance(isotropic, Tabulated) or getattr(isotropic, "rolloff", "smooth") != "smooth":
        raise OutsideTheory(
            "the spectrum has a kink, at q_long or at each point of a table: ln A bends most there; use a "
            "`SelfAffine` with rolloff='smooth'"
        )
    low = max(spectrum.q_min, spectrum.q_long * 1e-2)
    x = np.linspace(math.log(low / q0), math.log(spectrum.q_short / q0), 4001)[1:-1]
    area = area_against_magnification(
        spectrum, pressure=load, contact_modulus=contact_modulus, magnification=np.exp(x), q_reference=q0
    )
    bend = np.diff(np.log(area), 2) / (x[1] - x[0]) ** 2
    top = int(np.argmax(bend))
    if top in (0, bend.size - 1) or bend[top] < _BEND:
        raise OutsideTheory(
            "ln A bends up most at an end of the spectrum, or nowhere: there is no macroasperity scale"
        )
    y0, y1, y2 = bend[top - 1 : top + 2]
    shift = 0.5 * (y0 - y2) / (y0 - 2 * y1 + y2)
    return float(math.exp(x[top + 1] + shift * (x[1] - x[0])))


def macroasperity_pressure(
    spectrum: Spectrum, *, pressure: float, contact_modulus: float, q_reference: float
) -> float:
    """Mean pressure [Pa] in the macroasperities, sigma_0 A_0 / A(zeta_m).

    Arguments and errors as for `macroasperity_magnification`.

    Notes
    -----
    Persson 2006, Sec. 3.7, which calls it independent of the load: so it is while A(zeta_m) is proportional
    to the load.
    """
    given = {"pressure": pressure, "contact_modulus": contact_modulus, "q_reference": q_reference}
    zeta = macroasperity_magnification(spectrum, **given)
    area = area_against_magnification(spectrum, **given, magnification=zeta)
    return float(positive("pressure", pressure) / area)
