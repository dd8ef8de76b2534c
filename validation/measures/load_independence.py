"""Does a distribution stay the same while the load grows? Distances between pooled histograms, with their uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Distance", "distance_to_reference", "largest_difference"]

Array = NDArray[np.float64]

_RESAMPLES = 1000


def largest_difference(first: Array, second: Array) -> Array:
    """Kolmogorov-Smirnov distance of two histograms over the last axis: largest difference of their cumulated shares.

    Examples
    --------
    >>> float(largest_difference(np.array([1.0, 1.0]), np.array([3.0, 1.0])))
    0.25
    """
    shares = [np.cumsum(h, axis=-1) / h.sum(axis=-1, keepdims=True) for h in (first, second)]
    return np.asarray(np.abs(shares[0] - shares[1]).max(axis=-1))


@dataclass(frozen=True, kw_only=True)
class Distance:
    """Distance of the distributions at several loads from that at the reference load.

    Attributes
    ----------
    value : (loads,) array
        Of the pooled surfaces.
    low, high : (loads,) arrays
        95 % interval by resampling the surfaces, each with all its loads.
    noise : (loads,) array
        Distance that two sets of as many surfaces have from each other, 95th percentile, root mean square of that load and
        the reference: less is not told from zero. The two loads are of the same surfaces, so that this is on the safe side.
    """

    value: Array
    low: Array
    high: Array
    noise: Array


def distance_to_reference(histograms: Array, reference: int, *, seed: int = 20062) -> Distance:
    """Measure how far distributions are from that at one load.

    Parameters
    ----------
    histograms : (surfaces, loads, bins) array
        Counts or shares; those of the surfaces are pooled, never their distances.
    reference : int
        Index of the load that the others are compared with.
    seed : int
        Of the resampling.
    """
    surfaces = histograms.shape[0]
    pooled = histograms.sum(axis=0)
    rng = np.random.default_rng(seed)
    picks = rng.multinomial(surfaces, np.full(surfaces, 1 / surfaces), size=_RESAMPLES)
    sampled = np.einsum("rs,slb->rlb", picks, histograms)
    value = largest_difference(pooled, pooled[reference])
    spread = largest_difference(sampled, sampled[:, reference : reference + 1])
    # Two samples of the surfaces at one load; the bootstrap scatter of n surfaces is too small by (n - 1)/n.
    apart = largest_difference(sampled, sampled[rng.permutation(_RESAMPLES)])
    twin = np.percentile(apart, 95, axis=0) * np.sqrt(surfaces / (surfaces - 1))
    noise = np.sqrt((twin**2 + twin[reference] ** 2) / 2)
    low, high = np.percentile(spread, [2.5, 97.5], axis=0)
    return Distance(value=value, low=low, high=high, noise=noise)
