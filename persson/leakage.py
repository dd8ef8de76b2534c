"""Conductance of a heterogeneous film in two dimensions: the effective medium of Bruggeman."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from persson._checks import non_negative
from persson.errors import InvalidInput


def effective_medium(conductances: ArrayLike, shares: ArrayLike) -> float:
    r"""Conductance of a plane patchwork, by Bruggeman's effective medium.

    .. math:: \sum_i w_i\, \frac{k_i - K}{k_i + K} = 0

    Parameters
    ----------
    conductances : (n,) array
        k_i, not negative: u^3/12 [m^3] for a gap u, 0 in contact.
    shares : (n,) array
        w_i, share of the area, not negative; they are brought to the sum 1.

    Returns
    -------
    float
        K in the unit of k_i; 0 where half of the area or more does not conduct, which is where this theory
        puts the percolation threshold.

    Notes
    -----
    D. A. G. Bruggeman, Ann. Phys. 416, 636 (1935); for seals B. Lorenz and B. N. J. Persson, Eur. Phys. J. E
    31, 159 (2010).

    Examples
    --------
    Two equal halves have their geometric mean:

    >>> round(effective_medium([1.0, 4.0], [0.5, 0.5]), 12)
    2.0
    """
    k, w = non_negative("conductances", conductances), non_negative("shares", shares)
    if k.ndim != 1 or k.shape != w.shape or k.size == 0:
        raise InvalidInput(
            f"conductances of shape {k.shape}, shares of shape {w.shape}: must be two sequences of one length"
        )
    total, top = float(w.sum()), float(k.max())
    if not total > 0:
        raise InvalidInput("shares: all are 0; they must say where each conductance is found")
    k, w = k / (top or 1.0), w / total

    def excess(logarithm: float) -> float:
        guess = np.exp(logarithm)
        return float(np.sum(w * (k - guess) / (k + guess)))

    # For K -> 0 the sum is the conducting share less the rest.
    least = float(np.log(np.finfo(float).tiny))
    if top == 0 or excess(least) <= 0:
        return 0.0
    return top * float(np.exp(brentq(excess, least, 0.0, xtol=1e-14))) if excess(0.0) < 0 else top
