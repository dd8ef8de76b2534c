"""What studies ask Persson's theory: with the realised surface or from C(q) alone, and what its variants say of area and energy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from fem_contact.surface import HeightField
from persson import elastic
from persson.spectrum import Spectrum
from persson.variants import EnergyReading, Variant, corrected_contact_area, energy_share
from validation.arrays import Array
from validation.report.findings import Finding, finding, note
from validation.report.quantities import registry

#: The theory and its variants, and how the registry calls them.
VARIANTS: dict[Variant, str] = {
    name: registry()["qualifiers"][name]["words"] for name in ("persson", "yang_persson", "wang_mueser", "xu")
}

#: What a study names as its methods that ranks them: all are to be cited.
RANKED = "theory bem yang_persson wang_mueser xu"

#: Those that say what energy is stored; the others are about the area alone.
WITH_ENERGY: tuple[Variant, ...] = ("persson", "yang_persson", "wang_mueser")

#: Points of the pressure in the integral for the gap, and its end in standard deviations of the full-contact stress.
_PRESSURES = 500
_FULL = 8.0


def wave_powers(values: Array, spacing: tuple[float, float]) -> tuple[Array, Array, Array]:
    """Return qx, qy [1/m] and the squared amplitude of every wave of a periodic field, each of its shape."""
    qx, qy = (2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(values.shape, spacing, strict=True))
    x, y = np.meshgrid(qx, qy, indexing="ij")
    return x, y, np.abs(np.fft.fft2(values) / values.size) ** 2


@dataclass(frozen=True, kw_only=True, eq=False)
class Waves:
    """Roughness as the theory sees it, in units of E*: variance of the full-contact stress, and energy, wave after wave."""

    variance: Array  # (n,): V/E*^2 with the roughness up to each node
    energy: Array  # (n,): Elastic energy of full contact that each node adds, dV/(E*^2 q) [m] over E*

    @classmethod
    def of_field(cls, field: HeightField) -> Waves:
        """Return the waves of one realisation: the theory is told its moments (conditional)."""
        qx, qy, power = wave_powers(field.heights, field.spacing)
        q = np.hypot(qx, qy).ravel()
        # Waves of one length come as one ring, whatever the rounding of their wavevectors.
        rings, index = np.unique(np.round(q / q[q > 0].min(), 9), return_inverse=True)
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

    def elastic_energy(self, pressure: ArrayLike, variant: Variant | EnergyReading) -> Array:
        r"""Elastic energy per nominal area over E* [m], at nominal pressures over E* (loads,).

        .. math:: U_\mathrm{el} = \int \frac{dV}{E^* q}\, \tilde P

        P~ is `persson.variants.energy_share` of the variant; "persson" is Eq. 43.
        """
        load = np.asarray(pressure, dtype=float)[..., None]
        reading: EnergyReading = "old" if variant == "persson" else variant
        return energy_share(load, stress_variance=self.variance, energy=reading) @ self.energy

    def mean_gap(self, pressure: ArrayLike, variant: Variant | EnergyReading) -> Array:
        """Mean gap [m]: the work of the load is stored, p du = -dU, from full contact downwards.

        Arguments as for `elastic_energy`; the pressures must rise.
        """
        load = np.asarray(pressure, dtype=float)
        top = max(_FULL * np.sqrt(2 * self.variance.max()), 2 * load[-1])
        dense = np.unique(np.concatenate([np.geomspace(load[0], top, _PRESSURES), load]))
        step = np.diff(self.elastic_energy(dense, variant)) / np.sqrt(dense[1:] * dense[:-1])
        gap = np.concatenate([np.cumsum(step[::-1])[::-1], [0.0]])
        return np.asarray(gap[np.searchsorted(dense, load)])


def ensemble_area(
    spectrum: Spectrum | None, reduced_pressures: ArrayLike, *, rms_gradients: ArrayLike
) -> NDArray[np.float64]:
    r"""A/A0 of the theory from C(q) alone, for each surface and load, of shape (n, loads).

    .. math:: A_k/A_0 = \bigl\langle \operatorname{erf}(p_k / \sqrt{2 V_j}) \bigr\rangle_j,
              \qquad p_k = p^* E^* h'_k, \qquad V_j = \frac{m_2[C]}{4} \frac{h'^2_j}{\langle h'^2 \rangle}

    The surfaces are pressed with p* times their own realised gradient (n,), so that p_k differ; a generator
    whose surfaces are rougher than C(q) says shows here, while the theory with their gradient hides it. NaN where
    there is no C(q) but that of a measured period.
    """
    gradients = np.asarray(rms_gradients, dtype=float)
    pressure = np.multiply.outer(gradients, np.asarray(reduced_pressures, dtype=float))
    if spectrum is None:
        return np.full(pressure.shape, np.nan)
    squares = np.square(gradients)
    variance = elastic.stress_variance(spectrum.m2(), contact_modulus=1.0)
    variance = variance * squares / squares.mean()
    return np.asarray(
        elastic.contact_area(pressure[..., None], stress_variance=variance).mean(axis=-1), dtype=float
    )


def variant_areas(pressure: ArrayLike, *, stress_variance: ArrayLike) -> dict[str, Array]:
    """A/A0 of the theory and its variants, by name; pressure [Pa] and variance [Pa^2] in any unit."""
    return {
        f"area_{name}": corrected_contact_area(pressure, stress_variance=stress_variance, variant=name)
        for name in VARIANTS
    }


def with_variants(data: xr.Dataset) -> xr.Dataset:
    """Add ``area_<variant>``: A/A0 of the theory and its variants at each p* with the realised gradient."""
    full, pressure = elastic.stress_variance(1.0, contact_modulus=1.0), data.reduced_pressure
    areas = variant_areas(pressure.values, stress_variance=full)
    return data.assign({name: (pressure.dims, area) for name, area in areas.items()})


def modes_finding(data: xr.Dataset) -> Finding:
    """Say how far the two modes of the theory are apart over all of a dataset: ``area_ensemble``, ``area_persson``."""
    change = (data.area_ensemble / data.area_persson - 1).values
    if not change.size:
        return note("No place is shown at which C(q) and the realised gradient could be compared.")
    if not np.isfinite(change).any():
        return note(
            "There is no C(q) but that of the measured period itself, which the theory is told (conditional)."
        )
    form = "Told C(q) alone instead of the realised gradient, the theory's area changes by {low:+%} to {high:+%}: the sum "
    form += "over the waves of a finite period against the integral."
    return finding("comparison", form, low=float(np.nanmin(change)), high=float(np.nanmax(change)))
