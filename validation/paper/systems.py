"""The systems Persson (2006) computes, with the values he states and the choices he leaves open.

Left open in the paper and chosen here: q_0 and q_1 of the polished steel (1e5 and 1e10 1/m, as for the rim),
the Poisson ratio of PMMA (0.35), the size of the Pyrex sample (L = 1 um, Sec. 2.2).
"""

from __future__ import annotations

import math
from typing import Any

from persson import elastic
from persson.adhesion import AdhesiveContact, Interface, solve_adhesion
from persson.capillary import CapillaryWaves
from persson.hardness import ContactAreas, constant_hardness
from persson.scale import Scale
from persson.spectrum import SelfAffine, Spectrum
from validation.arrays import Array

#: Polished steel, Secs. 3.4, 3.6 and 6: E = 1e11 Pa, nu = 0.3, sigma_0 = 10 MPa.
STEEL_MODULUS = 1e11 / (1 - 0.3**2)
STEEL_PRESSURE = 10e6

#: Tire rim, Sec. 8.3: E = 10 MPa, nu = 0.5, Delta gamma = 0.05 J/m^2, sigma_0 = 0.5 MPa.
RIM_MODULUS = 10e6 / (1 - 0.5**2)
RIM_WORK = 0.05
RIM_PRESSURE = 0.5e6

#: PMMA on silane, Sec. 10.1: E = 2.9 GPa, nu not stated, Delta gamma = 0.06 J/m^2.
PMMA_MODULUS = 2.9e9 / (1 - 0.35**2)
PMMA_WORK = 0.06

#: Pyrex, Sec. 10.2: E = 32 GPa in two captions ("E/2 = 32" in a third), nu = 0.2, Delta gamma = 0.43 J/m^2.
PYREX_MODULUS = 32e9 / (1 - 0.2**2)
PYREX_WORK = 0.43
PYREX_HARDNESS = 6e9
PYREX_PRESSURE = 20e6


def steel(*, smooth: bool = False) -> SelfAffine:
    """Polished steel: h_rms = 0.1 um, fractal dimension 2.2.

    With a smooth roll-off where curvature matters.
    """
    shape: dict[str, Any] = {"rolloff": "smooth", "q_min": 1e3} if smooth else {}
    return SelfAffine.from_rms_height(1e-7, hurst=0.8, q_long=1e5, q_short=1e10, **shape)


def rim() -> SelfAffine:
    """Rim of a wheel: h_rms = 0.5 um, fractal dimension 2.2, q from 1e5 to 1e10 1/m."""
    return SelfAffine.from_rms_height(0.5e-6, hurst=0.8, q_long=1e5, q_short=1e10)


def pmma() -> CapillaryWaves:
    """Frozen capillary waves of PMMA: T_g = 370 K, gamma = 0.04 J/m^2, L = 100 um."""
    return CapillaryWaves(
        temperature=370.0, surface_tension=0.04, q_bend=1.7e9, q_min=2 * math.pi / 100e-6, q_short=7e9
    )


def pyrex(*, q_min: float = 2 * math.pi / 1e-6) -> CapillaryWaves:
    """Frozen capillary waves of Pyrex: T_g = 1100 K, gamma = 1 J/m^2.

    Two equal surfaces added coherently give C x 4.
    """
    return CapillaryWaves(temperature=1100.0, surface_tension=1.0, q_bend=0.5e10, q_min=q_min, q_short=1e10)


def area(
    spectrum: Spectrum, modulus: float, pressure: float | Array, q: float | Array | None = None
) -> Array:
    """A/A0 of an elastic solid, of the waves up to q."""
    variance = elastic.stress_variance(spectrum.m2(q), contact_modulus=modulus)
    return elastic.contact_area(pressure, stress_variance=variance)


def yielded(
    spectrum: Spectrum, modulus: float, pressure: float, *, hardness: float, q: Array | None = None
) -> ContactAreas:
    """Elastic and plastic areas with one hardness, of the waves up to q."""
    variance = elastic.stress_variance(spectrum.m2(q), contact_modulus=modulus)
    return constant_hardness(pressure, stress_variance=variance, yield_stress=hardness)


def adhesive(spectrum: Spectrum, modulus: float, pressure: float, interface: Interface) -> AdhesiveContact:
    """Contact with adhesion at all magnifications."""
    scale = Scale(spectrum, contact_modulus=modulus)
    return solve_adhesion(scale, pressure=pressure, interface=interface).checked()
