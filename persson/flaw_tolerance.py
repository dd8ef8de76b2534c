"""Adhesion that no flaw weakens: how the modulus must grow with depth (Persson 2006, Secs. 8.4 and 8.5)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from persson._checks import (
    Array,
    alike,
    in_proportion,
    instance,
    non_negative,
    poisson_ratio,
    positive,
    scalar,
)
from persson.elastic import contact_area
from persson.errors import InvalidInput, NotConverged, OutsideTheory
from persson.interface import Interface
from persson.spectrum import Spectrum, area_factor, check_sample, check_spectrum, sampled_wavevectors
from persson.variants import energy_share

#: Wavevectors of the optimal modulus, evenly spaced in ln q; its relative change at which the iteration
#: stops, and rounds allowed.
_NODES, _SETTLED, _ROUNDS = 300, 1e-8, 400


def crack_stress(work: ArrayLike, *, contact_modulus: float, length: ArrayLike) -> Array:
    r"""Detachment stress [Pa] of an interfacial crack of size lambda.

    .. math:: \sigma_a = \sqrt{\gamma_\mathrm{eff} E^* / \lambda}

    Parameters
    ----------
    work : float or array
        gamma_eff [J/m^2].
    contact_modulus : float
        E* [Pa], at the depth lambda in a graded solid.
    length : float or array
        lambda [m], positive.

    Notes
    -----
    Persson 2006, Eq. 51: Eq. 36 up to a number of order 1. At the atomic distance a it is the ideal
    strength if gamma is E* a (Sec. 8.4).
    """
    energy = non_negative("work", work)
    size = non_negative("length", length, zero="must be positive, in m")
    alike(work=energy, length=size)
    return np.sqrt(energy / size * positive("contact_modulus", contact_modulus))


def flaw_tolerant_gradient(
    work_of_adhesion: float, *, ideal_strength: float, poisson: float, alpha: float = 1.125
) -> float:
    r"""Gradient dE/dz [Pa/m] with which flaws of every size let go at the ideal strength.

    .. math:: E(z) = \frac{(1-\nu^2)\,\sigma^{*2}}{\alpha\,\Delta\gamma}\, z

    Parameters
    ----------
    work_of_adhesion : float
        Delta gamma [J/m^2], the same at every magnification: smooth surfaces.
    ideal_strength : float
        sigma* = Delta gamma / a [Pa].
    poisson : float
        nu.
    alpha : float
        Number of order 1 in Eq. 36.

    Notes
    -----
    Persson 2006, Sec. 8.5, after Yao and Gao: E~(q) = q int E exp(-qz) dz of a linear profile is its
    gradient over q, so that sigma_a of Eq. 36 does not depend on q. Rough surfaces need a faster growth,
    see `optimal_modulus`.

    Examples
    --------
    >>> gradient = flaw_tolerant_gradient(0.05, ideal_strength=5e8, poisson=0.0)
    >>> round(gradient * 1e-9 / 1e9, 2)  # E [GPa] at a depth of 1 nm
    4.44
    """
    energy = positive("work_of_adhesion", work_of_adhesion) * positive("alpha", alpha)
    strength = positive("ideal_strength", ideal_strength)
    return (1 - poisson_ratio(poisson) ** 2) * strength * (strength / energy)


@dataclass(frozen=True, kw_only=True)
class FlawTolerance:
    """A graded solid whose detachment stress is the same at every magnification.

    Attributes
    ----------
    wavevectors : (n,) array
        q [1/m].
    modulus : (n,) array
        E~*(q) [Pa], the modulus that a wave q must feel.
    work : (n,) array
        gamma_eff(q) [J/m^2].
    area : (n,) array
        A(q)/A0.
    """

    wavevectors: Array
    modulus: Array
    work: Array
    area: Array

    @property
    def growth(self) -> Array:
        """-d ln E~*/d ln q: 1 where E grows in proportion to depth, more where it must grow faster."""
        modulus, q = self.modulus / self.modulus[0], self.wavevectors / self.wavevectors[0]
        return np.asarray(-np.gradient(np.log(modulus), np.log(q)))


def optimal_modulus(
    spectrum: Spectrum, *, pressure: float, tensile_limit: float, interface: Interface
) -> FlawTolerance:
    r"""Find the graded modulus with which sigma_a does not depend on the magnification, on a rough surface.

    .. math:: \alpha\,\gamma_\mathrm{eff}(q)\,\tilde E^*(q)\, q = \sigma_a^2

    Parameters
    ----------
    spectrum : Spectrum
        C(q), with q_min > 0.
    pressure : float
        sigma_0 [Pa], above -sigma_a.
    tensile_limit : float
        sigma_a [Pa] that is wanted at every magnification, such as the ideal strength.
    interface : Interface
        Delta gamma, alpha, the energy ("old" or "improved") and the areas of Eq. 37.

    Raises
    ------
    OutsideTheory
        Where the elastic energy exceeds the adhesive energy at some magnification: no profile does it.
    NotConverged
        Where the iteration does not settle.

    Notes
    -----
    Persson 2006, Sec. 8.5: gamma_eff rises with magnification, so that E must grow faster than z, and how
    depends on the spectrum. With constant sigma_a the area is erf((sigma_0 + sigma_a)/sqrt(2V)), and P~
    of Eqs. 48 and 49 needs no diffusion; V, the energy of Eq. 37 and E~* are iterated.
    """
    check_spectrum(spectrum)
    instance("interface", interface, Interface)
    limit = positive("tensile_limit", tensile_limit)
    held = scalar("pressure", pressure) + limit
    if held <= 0:
        raise OutsideTheory(f"pressure = {pressure!r} Pa: the tension must stay below the tensile limit")
    if interface.energy == "as_printed":
        raise InvalidInput("interface.energy = 'as_printed': must be 'improved' or 'old' here")
    check_sample(spectrum, "must be positive")
    q = sampled_wavevectors(spectrum, _NODES)
    added = np.diff(spectrum.m2(q)) / 4
    star = area_factor(spectrum.m2(q)) if interface.area == "star" else np.ones_like(q)
    bond = interface.work_of_adhesion
    unit = limit / interface.alpha * (limit / bond) / q
    relative = np.ones_like(q)
    with in_proportion():
        for _ in range(_ROUNDS):
            modulus = unit * relative
            square = modulus * modulus
            variance = np.append(0.0, np.cumsum(added * (square[1:] + square[:-1]) / 2))
            area = contact_area(held, stress_variance=variance)
            density = energy_share(held, stress_variance=variance, energy=interface.energy) * modulus / q
            # U_el(q)/A0 [J/m^2] of the waves beyond q, by the trapezoidal rule over the nodes.
            pieces = added * (density[1:] + density[:-1]) / 2
            energy = np.append(np.cumsum(pieces[::-1])[::-1], 0.0)
            work = (area[-1] * star[-1] * bond - energy) / (np.maximum(area, 1e-300) * star)
            if np.any(work <= 0):
                raise OutsideTheory(
                    "the elastic energy exceeds the adhesive energy: no profile of the modulus makes this "
                    "surface flaw tolerant; take a smoother one or a smaller tensile_limit"
                )
            change = np.log(bond / work / relative)
            relative = relative * np.exp(0.5 * change)
            if np.max(np.abs(change)) < _SETTLED:
                return FlawTolerance(wavevectors=q, modulus=unit * relative, work=work, area=area)
    raise NotConverged(f"the optimal modulus still changes by {float(np.max(np.abs(change))):.3g} in a round")
