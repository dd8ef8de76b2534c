"""Asperities that yield: the elastoplastic model of Greenwood and Williamson (Persson 2006, Sec. 3.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from persson._checks import Array, instance, positive, real
from persson.asperities import Asperities, tail_moment

#: Standard deviations above the mean beyond which there are no summits.
_HIGHEST = 12.0


@dataclass(frozen=True, kw_only=True)
class YieldingContact:
    """Contact of asperities some of which have yielded.

    Attributes
    ----------
    area, area_plastic : array
        Area of contact and its yielded part, over the nominal area.
    pressure : array
        Nominal pressure [Pa].
    """

    area: Array
    area_plastic: Array
    pressure: Array


def yielding_asperities(
    separation: ArrayLike, *, asperities: Asperities, contact_modulus: float, hardness: float
) -> YieldingContact:
    r"""Contact of equal spheres of Gaussian heights that yield where their mean pressure would exceed H.

    .. math:: s_c = R\Bigl(\frac{3\pi H}{4E^*}\Bigr)^2, \qquad
              A_i = \pi R\,(2s - s_c), \quad F_i = H A_i \quad (s > s_c)

    Parameters
    ----------
    separation : float or array
        d [m] between the plane and the mean summit height.
    asperities : Asperities
        Density, radius and height scatter.
    contact_modulus : float
        E* [Pa].
    hardness : float
        H [Pa], the indentation hardness.

    Notes
    -----
    Below the approach s_c each asperity is that of Hertz, Eqs. 10-12. Above, its volume is kept (W. R.
    Chang, I. Etsion and D. B. Bogy, J. Tribol. 109, 257, 1987), with H for their pressure at yield, so
    that area and load of an asperity are continuous. Great H is Greenwood and Williamson's contact; small
    H gives A/A0 = sigma_0/H.
    """
    instance("asperities", asperities, Asperities, what="`Asperities`")
    modulus = positive("contact_modulus", contact_modulus, unit="Pa")
    limit = positive("hardness", hardness, unit="Pa")
    height, radius = asperities.rms_height, asperities.radius
    t = real("separation", separation, unit="m") / height
    onset = radius / height * min(0.75 * math.pi * limit / modulus, 1e15) ** 2
    late = t + onset
    beyond = tail_moment(1, late)
    scale = asperities.density * radius * height
    plastic = math.pi * scale * (2 * beyond + onset * tail_moment(0, late))
    below = np.maximum(tail_moment(1, t) - beyond - onset * tail_moment(0, late), 0.0)
    slope = math.sqrt(height / radius)
    elastic = 4 / 3 * modulus * scale * slope * _partial(t, onset)
    return YieldingContact(
        area=(math.pi * scale * below + plastic)[()],
        area_plastic=np.asarray(plastic)[()],
        pressure=(elastic + limit * plastic)[()],
    )


def _partial(t: Array, span: float) -> Array:
    """Int_t^(t + span) (x - t)^(3/2) phi(x) dx; x = t + w y^2 takes the root away."""
    points, weights = np.polynomial.legendre.leggauss(160)
    y = (1 + points) / 2
    width = np.minimum(span, np.maximum(_HIGHEST - t, 0.0))
    x = t[..., None] + width[..., None] * y * y
    with np.errstate(under="ignore"):
        density = np.exp(-0.5 * np.minimum(x * x, 1400.0)) / math.sqrt(2 * math.pi)
    return np.asarray(width * width * np.sqrt(width) * ((y**4 * density) @ weights))
