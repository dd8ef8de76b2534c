"""Distances of distributions of pressure and patch size, and their intervals by resampling, a second time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import erf

from validation.audit.stored import Array

__all__ = ["Moved", "apart", "moved", "predicted_shares", "reference_of"]

#: Area from which on a light contact serves as reference; seed and number of resamplings.
_REFERENCE, _SEED, _RESAMPLES = 0.015, 20062, 1000


def reference_of(area: Array) -> int:
    """Lightest load of enough contact; `area` is (surface, load)."""
    enough = np.flatnonzero(area.mean(axis=0) >= _REFERENCE)
    return int(enough[0]) if enough.size else area.shape[1] - 1


def apart(first: Array, second: Array) -> Array:
    """Largest difference of two cumulated histograms, each over its own sum."""
    a, b = (np.cumsum(h, axis=-1) / np.sum(h, axis=-1)[..., None] for h in (first, second))
    return np.asarray(np.max(np.abs(a - b), axis=-1))


@dataclass(frozen=True)
class Moved:
    """Distances from the reference load: of all surfaces, the 95 % interval, and what is not told from zero."""

    value: Array
    low: Array
    high: Array
    noise: Array


def moved(shares: Array, reference: int) -> Moved:
    """Distances of (surface, load, bin) histograms from the reference load, surfaces pooled and resampled."""
    n = shares.shape[0]
    rng = np.random.default_rng(_SEED)
    picks = rng.multinomial(n, np.full(n, 1 / n), size=_RESAMPLES)
    resampled = np.tensordot(picks, shares, axes=(1, 0))
    order = rng.permutation(_RESAMPLES)
    twins = np.percentile(apart(resampled, resampled[order]), 95, axis=0) * np.sqrt(n / (n - 1))
    own = apart(resampled, resampled[:, [reference]])
    pooled = shares.sum(axis=0)
    low, high = np.percentile(own, [2.5, 97.5], axis=0)
    noise = np.sqrt((twins**2 + twins[reference] ** 2) / 2)
    return Moved(apart(pooled, pooled[reference]), low, high, noise)


def predicted_shares(upper: Array, loads: Array, width: Array) -> Array:
    """Shares of the area by pressure of the theory, (load, bin): images of opposite sign, V = width^2 / 2."""
    edges = np.concatenate([[0.0], upper[:-1], [np.inf]])
    s, p = edges / width[:, None], loads[:, None] / width[:, None]
    return np.diff(0.5 * (erf(s - p) - erf(s + p)), axis=1)
