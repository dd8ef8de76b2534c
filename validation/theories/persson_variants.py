"""Persson's theory and its variants with a corrected elastic energy."""

from typing import ClassVar

import numpy as np
from scipy.special import erfinv

from persson import elastic
from persson.variants import EnergyReading, Variant, corrected_contact_area
from validation.arrays import Array
from validation.measurements.theory import VARIANTS
from validation.report.papers import CITED_FOR
from validation.theories.base import Rough, Theory


class Persson(Theory):
    """Persson (2001): A/A0 = erf(p0 / sqrt(2 V)), V = E*^2 m2 / 4.

    Parameters
    ----------
    reading, label
        Another reading of its elastic energy, which says nothing of the area, and what it is called.
    """

    name = "persson"
    variant: ClassVar[Variant] = "persson"
    reading: EnergyReading = "old"
    papers = ("[persson2001].",)

    def __init__(self, reading: EnergyReading | None = None, *, label: str = "") -> None:
        self.label = label or VARIANTS[self.variant]
        self.reading, self._has_area = reading or self.reading, reading is None

    def area(self, pressure: Array, rough: Rough) -> Array:
        """Return A/A0."""
        if not self._has_area:
            return np.full(np.shape(pressure), np.nan)
        full = elastic.stress_variance(rough.moments.m2, contact_modulus=rough.contact_modulus)
        return corrected_contact_area(pressure, stress_variance=full, variant=self.variant)

    def pressure_distribution(self, stress: Array, pressure: float, rough: Rough) -> Array | None:
        """Return the distribution of the theory with the variance that makes its area."""
        if not self._has_area:
            return None
        variance = self.stress_variance(pressure, rough)
        return elastic.pressure_distribution(stress, pressure=pressure, stress_variance=variance)

    def stress_variance(self, pressure: float, rough: Rough) -> float:
        """Return the variance of the stress that makes the area: V = p0^2 / (2 erfinv(A/A0)^2) [Pa^2]."""
        area = float(self.area(np.array([pressure]), rough)[0])
        # Where the area is 1 to rounding, it is that of full contact.
        if area > 1 - 1e-9:
            return float(elastic.stress_variance(rough.moments.m2, contact_modulus=rough.contact_modulus))
        return float((pressure / erfinv(area)) ** 2 / 2)

    def mean_gap(self, pressure: Array, rough: Rough) -> Array:
        """Return the gap whose work is the energy stored."""
        return rough.waves.mean_gap(pressure / rough.contact_modulus, self.reading)

    def elastic_energy(self, pressure: Array, rough: Rough) -> Array:
        """Return the energy of Eq. 43, with the factor of the reading."""
        unit = rough.waves.elastic_energy(pressure / rough.contact_modulus, self.reading)
        return unit * rough.contact_modulus


class YangPersson(Persson):
    """Yang and Persson (2008): dV = [g + (1 - g) P^2] dV_full."""

    name = "yang-persson"
    variant = reading = "yang_persson"
    papers = (CITED_FOR["yang_persson"],)


class WangMueser(Persson):
    """Wang and Mueser (2017): dV = (5 - 2 P^2 + 6 P^4) / 9 dV_full."""

    name = "wang-mueser"
    variant = reading = "wang_mueser"
    papers = (CITED_FOR["wang_mueser"],)


class Xu(Persson):
    """Xu and others (2024): V = [g + (1 - g) P] V_full."""

    name = "xu"
    variant = reading = "xu"
    papers = (CITED_FOR["xu"],)


def persson_variants() -> tuple[Theory, ...]:
    """Return the theory and its variants."""
    return (Persson(), YangPersson(), WangMueser(), Xu())


def persson_readings() -> tuple[Theory, ...]:
    """Return them with the other readings of the elastic energy of the paper and of Xu et al."""
    hybrid = Xu("xu_hybrid", label=f"{VARIANTS['xu']}, hybrid")
    others = (Persson("improved", label="Persson, Eq. 48"), Persson("as_printed", label="Persson, Eq. 50"))
    return (*persson_variants(), *others, hybrid)
