"""Area, elastic energy, mean gap and stiffness of the theory and its variants, for waves that are known one by one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fem_contact.surface import HeightField
from persson import elastic
from persson.spectrum import Spectrum
from persson.variants import Variant, corrected_contact_area, energy_factor

__all__ = ["VARIANTS", "WITH_ENERGY", "Waves"]

#: The theory and its variants, and how they are called.
VARIANTS: dict[Variant, str] = {
    "persson": "Persson",
    "yang_persson": "Yang, Persson 2008",
    "wang_mueser": "Wang, Mueser 2017",
    "xu": "Xu et al. 2024",
}

#: Those that say what energy is stored; the others are about the area alone.
WITH_ENERGY: tuple[Variant, ...] = ("persson", "yang_persson", "wang_mueser")

#: Points of the pressure in the integral for the gap, and its end in standard deviations of the full-contact stress.
_PRESSURES = 500
_FULL = 8.0

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Waves:
    """Roughness as the theory sees it, in units of E*: variance of the full-contact stress, and energy, wave after wave.

    Attributes
    ----------
    variance : (n,) array
        V/E*^2 with the roughness up to each node.
    energy : (n,) array
        Elastic energy of full contact that each node adds, dV/(E*^2 q) [m] over E*.
    """

    variance: Array
    energy: Array

    @classmethod
    def of_field(cls, field: HeightField) -> Waves:
        """Return the waves of one realisation: the theory is told its moments (conditional)."""
        nx, ny = field.shape
        power = np.abs(np.fft.fft2(field.heights) / (nx * ny)) ** 2
        qx, qy = (2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(field.shape, field.spacing, strict=True))
        q = np.hypot(qx[:, None], qy[None, :]).ravel()
        # Waves of one length come as one ring, whatever the rounding of their wavevectors.
        key = np.round(q / q[q > 0].min(), 9)
        rings, index = np.unique(key, return_inverse=True)
        wave = rings * q[q > 0].min()
        added = np.bincount(index.ravel(), weights=(q**2 * power.ravel())) / 4
        keep = added > 1e-20 * added.sum()
        return cls._over(wave[keep], added[keep])

    @classmethod
    def of_spectrum(cls, spectrum: Spectrum, *, intervals: int = 200) -> Waves:
        """Return the waves of C(q) alone (ensemble)."""
        edges = np.geomspace(max(spectrum.q_min, spectrum.q_long * 1e-3), spectrum.q_short, intervals + 1)
        added = np.diff(spectrum.m2(edges)) / 4
        middle = np.sqrt(edges[1:] * edges[:-1])
        keep = added > 0
        return cls._over(middle[keep], added[keep])

    @classmethod
    def _over(cls, wave: Array, added: Array) -> Waves:
        """Four Gauss points inside what each ring adds, since the contact opens while it is added."""
        points, weights = np.polynomial.legendre.leggauss(4)
        start = np.concatenate([[0.0], np.cumsum(added)[:-1]])
        variance = start[:, None] + added[:, None] * (1 + points) / 2
        energy = (added / wave)[:, None] * weights / 2
        return cls(variance=variance.ravel(), energy=energy.ravel())

    @property
    def full_energy(self) -> float:
        """Elastic energy of full contact over E* [m]."""
        return float(self.energy.sum())

    def elastic_energy(self, pressure: ArrayLike, variant: Variant) -> Array:
        r"""Elastic energy per nominal area over E* [m].

        .. math:: U_\mathrm{el} = \int \frac{dV}{E^* q}\, P\, S(P)

        Persson 2006, Eq. 43 for S = 1. As in Yang and Persson (2008), "yang_persson" takes P of the original theory and
        S = g + (1 - g) P^2; "wang_mueser" takes the area that follows from its own S.

        Parameters
        ----------
        pressure : (loads,) array
            Nominal pressure over E*.
        variant : str
            One of `WITH_ENERGY`.
        """
        load = np.asarray(pressure, dtype=float)[..., None]
        if variant == "wang_mueser":
            area = corrected_contact_area(load, stress_variance=self.variance, variant=variant)
        else:
            area = elastic.contact_area(load, stress_variance=self.variance)
        return np.asarray((area * energy_factor(area, variant=variant)) @ self.energy)

    def mean_gap(self, pressure: ArrayLike, variant: Variant) -> Array:
        """Mean gap [m]: the work of the load is stored, p du = -dU, from full contact downwards.

        Arguments as for `elastic_energy`; the pressures must rise.
        """
        load = np.asarray(pressure, dtype=float)
        top = max(_FULL * float(np.sqrt(2 * self.variance.max())), 2 * float(load[-1]))
        dense = np.unique(np.concatenate([np.geomspace(load[0], top, _PRESSURES), load]))
        energy = self.elastic_energy(dense, variant)
        step = np.diff(energy) / np.sqrt(dense[1:] * dense[:-1])
        gap = np.concatenate([np.cumsum(step[::-1])[::-1], [0.0]])
        return np.asarray(gap[np.searchsorted(dense, load)])
