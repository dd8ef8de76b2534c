"""The distribution of heights of a randomly rough surface (Persson 2006, Sec. 2.1, Eq. 9 and App. A)."""

import math

import numpy as np
from numpy.typing import ArrayLike

from persson._checks import Array, positive, real


def height_distribution(height: ArrayLike, *, rms_height: float) -> Array:
    r"""Distribution of heights P_h = <delta(h - h(x))> of a surface whose waves have independent phases.

    .. math:: P_h = \frac{1}{\sqrt{2\pi}\, h_\mathrm{rms}}\, e^{-h^2/2h_\mathrm{rms}^2}

    Parameters
    ----------
    height : float or array
        h [m] above the mean plane.
    rms_height : float
        h_rms [m], ``spectrum.moments().rms_height``; for asperities h*, that of their summits (Eq. 9).

    Returns
    -------
    array
        P_h [1/m], which integrates to 1.

    Notes
    -----
    It depends on the spectrum through h_rms alone, that is on the long waves: two surfaces with one P_h
    may touch quite differently (Sec. 2.1). `persson.capillary.maximum_height` gives its highest point.

    Examples
    --------
    >>> round(float(height_distribution(0.0, rms_height=1.0)), 4)
    0.3989
    """
    width = positive("rms_height", rms_height)
    z = real("height", height) / width
    with np.errstate(under="ignore", over="ignore"):
        return np.exp(-0.5 * z * z) / (math.sqrt(2 * math.pi) * width)
