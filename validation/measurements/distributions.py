"""How pressure and patch sizes are distributed, and how far two distributions are apart."""

from __future__ import annotations

import numpy as np

from fem_contact.contact import ContactResult
from fem_contact.patches import find_patches
from validation.arrays import Array
from validation.scenes.problem import ContactProblem

#: Of surfaces, for the intervals of distances.
_RESAMPLES = 1000

#: Edges of the bins of sigma / (E* h'_rms); what lies above the last counts in the last bin.
STRESS_EDGES = np.linspace(0.0, 4.0, 321)

#: Edges of the bins of patch area / lambda_short^2; what lies outside counts in the first or last bin.
PATCH_EDGES = np.geomspace(1e-4, 1e4, 161)


def histograms_of(result: ContactResult, problem: ContactProblem) -> dict[str, Array]:
    """Return P(sigma) and patch sizes of one solve, as histograms over the edges above.

    ``stress``, share of the nominal area by pressure, and ``load``, share of p0; ``patch_number`` and
    ``patch_area``, number of patches and share of the nominal area, by patch size.
    """
    unit = problem.pressure_scale
    contact = result.in_contact
    pressure = result.pressure[contact] / unit
    inside = np.clip(pressure, 0.0, STRESS_EDGES[-1])
    stress, _ = np.histogram(inside, bins=STRESS_EDGES)
    load, _ = np.histogram(inside, bins=STRESS_EDGES, weights=pressure)
    sizes = find_patches(contact, result.spacing).areas
    scaled = np.clip(sizes / problem.shortest**2, PATCH_EDGES[0], PATCH_EDGES[-1])
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


def weighted_percentile(shares: Array, edges: Array, part: float) -> float:
    """Value below which a part of a histogram lies, interpolated in the logarithm of the edges.

    >>> round(weighted_percentile(np.array([1.0, 1.0]), np.array([1.0, 10.0, 100.0]), 0.5), 9)
    10.0
    """
    total = np.concatenate([[0.0], np.cumsum(shares)])
    return float(np.exp(np.interp(part * total[-1], total, np.log(edges))))


def largest_difference(first: Array, second: Array) -> Array:
    """Kolmogorov-Smirnov distance of two histograms over the last axis: largest difference of their cumulated shares.

    >>> float(largest_difference(np.array([1.0, 1.0]), np.array([3.0, 1.0])))
    0.25
    """
    shares = [np.cumsum(h, axis=-1) / h.sum(axis=-1, keepdims=True) for h in (first, second)]
    return np.asarray(np.abs(shares[0] - shares[1]).max(axis=-1))


def distance_to_reference(histograms: Array, reference: int) -> dict[str, Array]:
    """Measure how far distributions (surfaces, loads, bins) are from that at one load, (loads,).

    The distance itself ("") is of the pooled surfaces; ``_lower``, ``_upper`` are its 95 % interval by
    resampling the surfaces, each with all its loads; ``_noise`` is the distance that two sets of as many
    surfaces have from each other, 95th percentile, root mean square of that load and the reference, NaN for
    a single surface. Less is not told from zero: the two loads are of the same surfaces, so that this is on
    the safe side.
    """
    surfaces = histograms.shape[0]
    pooled = histograms.sum(axis=0)
    rng = np.random.default_rng(20062)
    picks = rng.multinomial(surfaces, np.full(surfaces, 1 / surfaces), size=_RESAMPLES)
    sampled = np.einsum("rs,slb->rlb", picks, histograms)
    value = largest_difference(pooled, pooled[reference])
    spread = largest_difference(sampled, sampled[:, reference : reference + 1])
    # Two samples of the surfaces at one load; the bootstrap scatter of n surfaces is too small by (n - 1)/n.
    apart = largest_difference(sampled, sampled[rng.permutation(_RESAMPLES)])
    factor = np.sqrt(surfaces / (surfaces - 1)) if surfaces > 1 else np.nan
    twin = np.percentile(apart, 95, axis=0) * factor
    noise = np.sqrt((twin**2 + twin[reference] ** 2) / 2)
    low, high = np.percentile(spread, [2.5, 97.5], axis=0)
    return {"": value, "_lower": low, "_upper": high, "_noise": noise}
