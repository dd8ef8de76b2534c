"""How a distance from the theory goes on beyond the bands that were solved: laws in the Nayak parameter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from validation.arrays import Array

#: Laws of the distance at alpha: a - b ln alpha, which reaches zero; c alpha^-n, which tends to it; and
#: a + c alpha^-n with a >= 0, which ends beside the theory or at it.
LAWS = ("logarithm", "power", "saturation")
#: Range of n, how many are tried at a time, and samples of the data.
_LOW, _HIGH, _TRIED, _SAMPLES = 0.03, 3.0, 120, 1000
#: Constants of each.
_CONSTANTS = {"logarithm": 2, "power": 2, "saturation": 3}


@dataclass(frozen=True, kw_only=True)
class Fit:
    """A law through data, where it was asked for."""

    values: Array  # Of the law through the data
    halves: Array  # Half of the 95 % ranges, of the law through samples of the data
    chi_square: float
    freedom: int  # Points less constants


def fit(law: str, alpha: Array, distance: Array, half_width: Array, *, at: Array) -> Fit:
    """Fit a law to distances with their half widths (95 %, independent), and say what it is elsewhere.

    Parameters
    ----------
    law : str
        One of `LAWS`.
    alpha, distance, half_width : (n,) arrays
        At least as many as the law has constants.
    at : (m,) array
        Nayak parameters; infinity has no value by a logarithm.

    Examples
    --------
    >>> alpha = np.array([3.0, 6.0, 12.0, 24.0])
    >>> law = fit("logarithm", alpha, 0.5 - 0.1 * np.log(alpha), np.full(4, 1e-9), at=alpha[-1:] ** 2)
    >>> abs(law.values[0] - 0.5 + 0.2 * np.log(24)) < 1e-9
    np.True_
    """
    error = half_width / 1.96
    noise = np.random.default_rng(0).standard_normal((_SAMPLES, alpha.size))
    noise[0] = 0.0
    samples = distance / error + noise
    low, high = _LOW, _HIGH
    for _ in range(2):  # among all exponents, then closely about those that were best
        best = np.full((_SAMPLES, 2 + at.size), np.inf)  # exponent, chi^2, values
        for exponent in np.geomspace(low, high, 1 if law == "logarithm" else _TRIED):
            _improve(best, samples, law, exponent, (alpha, error), at)
        step = (high / low) ** (1 / _TRIED)
        low, high = np.percentile(best[:, 0], (0.5, 99.5)) * (1 / step, step)
    ends = np.percentile(best[1:, 2:], (2.5, 97.5), axis=0)
    return Fit(
        values=best[0, 2:],
        halves=(ends[1] - ends[0]) / 2,
        chi_square=float(best[0, 1]),
        freedom=alpha.size - _CONSTANTS[law],
    )


def _improve(
    best: Array, samples: Array, law: str, exponent: float, data: tuple[Array, Array], at: Array
) -> None:
    """Take over a law of this exponent for the samples that it fits better than any before."""
    alpha, error = data
    for name in (law, "power") if law == "saturation" else (law,):
        weighted = _design(name, alpha, exponent) / error[:, None]
        constants = samples @ np.linalg.pinv(weighted).T
        misses = np.sum((samples - constants @ weighted.T) ** 2, axis=1)
        if name == "saturation":
            misses[constants[:, 0] < 0] = np.inf
        better = misses < best[:, 1]
        values = constants[better] @ _design(name, at, exponent).T
        best[better] = np.column_stack([np.full(len(values), exponent), misses[better], values])


def _design(law: str, alpha: Array, exponent: float) -> Array:
    """Matrix of the constants that enter linearly."""
    if law == "logarithm":
        return np.stack([np.ones_like(alpha), np.where(np.isinf(alpha), np.nan, np.log(alpha))], axis=1)
    falling = alpha**-exponent
    return np.stack([np.ones_like(alpha), falling][law == "power" :], axis=1)
