"""A measurement that also keeps how pressure and patch sizes are distributed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem_contact.contact import ContactResult
from fem_contact.patches import find_patches
from validation.measures.measurement import Measurement

__all__ = ["PATCH_EDGES", "STRESS_EDGES", "Distributions", "weighted_percentile"]

#: Edges of the bins of sigma / (E* h'_rms); what lies above the last counts in the last bin.
STRESS_EDGES = np.linspace(0.0, 4.0, 321)

#: Edges of the bins of patch area / lambda_short^2; what lies outside counts in the first or last bin.
PATCH_EDGES = np.geomspace(1e-4, 1e4, 161)


@dataclass(frozen=True, kw_only=True)
class Distributions(Measurement):
    """A measurement with P(sigma) and patch sizes of every solve.

    It adds `stress` (share of the nominal area by pressure), `load` (share of p0 by pressure), `patch_number` and
    `patch_area` (number of patches, and share of the nominal area, by patch size), all as histograms over the edges above.
    """

    def profiles(self, result: ContactResult) -> dict[str, NDArray[np.float64]]:
        """Return the histograms of one solve."""
        unit = self.realised.pressure_scale
        contact = np.asarray(result.in_contact)
        pressure = np.asarray(result.pressure)[contact] / unit
        inside = np.clip(pressure, 0.0, STRESS_EDGES[-1])
        stress, _ = np.histogram(inside, bins=STRESS_EDGES)
        load, _ = np.histogram(inside, bins=STRESS_EDGES, weights=pressure)
        sizes = find_patches(contact, result.spacing).areas
        scaled = np.clip(sizes / self.realised.shortest**2, PATCH_EDGES[0], PATCH_EDGES[-1])
        number, _ = np.histogram(scaled, bins=PATCH_EDGES)
        cell = result.spacing[0] * result.spacing[1]
        area, _ = np.histogram(scaled, bins=PATCH_EDGES, weights=sizes / cell)
        nominal = float(np.mean(result.pressure)) / unit * contact.size
        return {
            "stress": stress / contact.size,
            "load": load / nominal,
            "patch_number": number.astype(float),
            "patch_area": area / contact.size,
        }


def weighted_percentile(shares: NDArray[np.float64], edges: NDArray[np.float64], part: float) -> float:
    """Value below which a part of a histogram lies, interpolated in the logarithm of the edges.

    Examples
    --------
    >>> round(weighted_percentile(np.array([1.0, 1.0]), np.array([1.0, 10.0, 100.0]), 0.5), 9)
    10.0
    """
    total = np.concatenate([[0.0], np.cumsum(shares)])
    return float(np.exp(np.interp(part * total[-1], total, np.log(edges))))
