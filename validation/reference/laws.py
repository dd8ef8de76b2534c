"""How a distance from the theory goes on beyond the bands that were solved: laws in the Nayak parameter."""

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
    low, high, best = _LOW, _HIGH, np.full((_SAMPLES, 2 + at.size), np.inf)
    for _ in range(2):  # among all exponents, then closely about those that were best
        exponents = np.geomspace(low, high, 1 if law == "logarithm" else _TRIED)
        laws = (law, "power") if law == "saturation" else (law,)
        every = [best, *(_best_of(name, exponents, samples, (alpha, error), at) for name in laws)]
        least = np.argmin([rows[:, 1] for rows in every], axis=0)
        best = np.stack(every)[least, np.arange(_SAMPLES)]
        step = (high / low) ** (1 / _TRIED)
        low, high = np.percentile(best[:, 0], (0.5, 99.5)) * (1 / step, step)
    ends = np.percentile(best[1:, 2:], (2.5, 97.5), axis=0)
    return Fit(
        values=best[0, 2:],
        halves=(ends[1] - ends[0]) / 2,
        chi_square=float(best[0, 1]),
        freedom=alpha.size - _CONSTANTS[law],
    )


def _best_of(law: str, exponents: Array, samples: Array, data: tuple[Array, Array], at: Array) -> Array:
    """Return exponent, chi^2 and values of the law that fits each sample best: (samples, 2 + m)."""
    alpha, error = data
    weighted = _designs(law, alpha, exponents) / error[:, None]
    constants = samples @ np.swapaxes(np.linalg.pinv(weighted), 1, 2)  # (exponents, samples, constants)
    misses = np.sum((samples - constants @ np.swapaxes(weighted, 1, 2)) ** 2, axis=2)
    if law == "saturation":
        misses[constants[:, :, 0] < 0] = np.inf
    which, sample = np.argmin(misses, axis=0), np.arange(len(samples))
    values = np.einsum("sc,smc->sm", constants[which, sample], _designs(law, at, exponents)[which])
    return np.column_stack([exponents[which], misses[which, sample], values])


def _designs(law: str, alpha: Array, exponents: Array) -> Array:
    """Matrices of the constants that enter linearly, one for each exponent: (exponents, n, constants)."""
    falling = alpha ** -exponents[:, None]
    if law == "logarithm":
        falling = np.broadcast_to(np.where(np.isinf(alpha), np.nan, np.log(alpha)), falling.shape)
    return np.stack([np.ones_like(falling), falling][law == "power" :], axis=2)
