"""Persson's theory and its variants with a corrected elastic energy."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from scipy.special import erfinv

from persson import elastic
from persson.variants import Variant, corrected_contact_area
from validation.arrays import Array
from validation.measures.theory import VARIANTS, WITH_ENERGY
from validation.theories.base import Rough, Theory

__all__ = ["Persson", "WangMueser", "Xu", "YangPersson"]


class Persson(Theory):
    """Persson (2001): A/A0 = erf(p0 / sqrt(2 V)), V = E*^2 m2 / 4."""

    name = "persson"
    variant: ClassVar[Variant] = "persson"
    papers = ("B. N. J. Persson, J. Chem. Phys. 115, 3840 (2001).",)

    def __init__(self) -> None:
        self.label = VARIANTS[self.variant]

    def area(self, pressure: Array, rough: Rough) -> Array:
        """Return A/A0."""
        full = elastic.stress_variance(rough.moments.m2, contact_modulus=rough.contact_modulus)
        return corrected_contact_area(pressure, stress_variance=full, variant=self.variant)

    def pressure_distribution(self, stress: Array, pressure: float, rough: Rough) -> Array:
        """Return the distribution of the theory with the variance that makes its area."""
        area = float(self.area(np.array([pressure]), rough)[0])
        full = elastic.stress_variance(rough.moments.m2, contact_modulus=rough.contact_modulus)
        variance = full if area >= 1 else (pressure / erfinv(area)) ** 2 / 2
        return elastic.pressure_distribution(stress, pressure=pressure, stress_variance=variance)

    def mean_gap(self, pressure: Array, rough: Rough) -> Array | None:
        """Return the gap whose work is the energy stored."""
        if self.variant not in WITH_ENERGY:
            return None
        return rough.waves.mean_gap(pressure / rough.contact_modulus, self.variant)

    def elastic_energy(self, pressure: Array, rough: Rough) -> Array | None:
        """Return the energy of Eq. 43, with the factor of the variant."""
        if self.variant not in WITH_ENERGY:
            return None
        unit = rough.waves.elastic_energy(pressure / rough.contact_modulus, self.variant)
        return np.asarray(unit * rough.contact_modulus)


class YangPersson(Persson):
    """Yang and Persson (2008): dV = [g + (1 - g) P^2] dV_full."""

    name = "yang-persson"
    variant = "yang_persson"
    papers = ("C. Yang, B. N. J. Persson, J. Phys. Condens. Matter 20, 215214 (2008).",)


class WangMueser(Persson):
    """Wang and Mueser (2017): dV = (5 - 2 P^2 + 6 P^4) / 9 dV_full."""

    name = "wang-mueser"
    variant = "wang_mueser"
    papers = ("A. Wang, M. H. Mueser, Lubricants 5, 35 (2017).",)


class Xu(Persson):
    """Xu, Xu and Chen (2024): V = [g + (1 - g) P] V_full."""

    name = "xu"
    variant = "xu"
