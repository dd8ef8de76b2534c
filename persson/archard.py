"""Archard's hierarchy: spheres on spheres on a sphere (Persson 2006, Sec. 1)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from persson._checks import Array, in_proportion, non_negative, positive, positives
from persson.errors import InvalidInput


@dataclass(frozen=True, kw_only=True)
class HierarchyContact:
    """Contact of a hierarchy of spheres.

    Attributes
    ----------
    area : array
        Area of real contact [m^2], on the spheres of the last level.
    exponent : float
        b in A ~ F^b: 2/3, 8/9, 26/27, ... 1 - 3^-n for n levels.
    """

    area: Array
    exponent: float


def archard_hierarchy(
    force: ArrayLike, *, radii: Sequence[float], densities: Sequence[float], contact_modulus: float
) -> HierarchyContact:
    r"""Area of real contact of a sphere covered with smaller spheres, which are covered with smaller ones.

    .. math:: S_k(f) = m_{k+1} \int S_{k+1}\!\bigl(p(r)/m_{k+1}\bigr)\, d^2r, \qquad
              S_n(f) = \pi \Bigl(\frac{3 R_n f}{4 E^*}\Bigr)^{2/3}

    with the pressure p(r) of Hertz for the sphere of level k under the force f.

    Parameters
    ----------
    force : float or array
        On the whole body [N].
    radii : sequence of float
        R_0 > R_1 > ... > R_n [m].
    densities : sequence of float
        m_1 ... m_n [1/m^2]: spheres of a level per area of the sphere they sit on.
    contact_modulus : float
        E* [Pa].

    Raises
    ------
    InvalidInput
        For radii that do not fall, or as many densities as radii.

    Notes
    -----
    J. F. Archard, Proc. R. Soc. A 243, 190 (1957). Every level is a power law, S_k = c_k f^(b_k) with b_k
    = (2 + b_(k+1)) / 3, so the integral over the Hertzian pressure is 2/(2 + b_(k+1)) of its peak's.
    Spheres of one level do not feel each other, and all of them stand equally high: with more levels the
    area becomes proportional to the load although each contact only grows.

    Examples
    --------
    >>> levels = archard_hierarchy(1.0, radii=[1e-2, 1e-4], densities=[1e8], contact_modulus=1e9)
    >>> round(9 * levels.exponent, 12)
    8.0
    """
    load = non_negative("force", force)
    modulus = positive("contact_modulus", contact_modulus)
    sizes = positives("radii", radii)
    counts = positives("densities", densities)
    if not sizes or len(counts) != len(sizes) - 1:
        raise InvalidInput(
            f"{len(sizes)} radii and {len(counts)} densities: there must be one radius more than densities"
        )
    if np.any(np.diff(sizes) >= 0):
        raise InvalidInput("radii: each level must be smaller than the one it sits on")
    # S_k = R_k^2 share (f / E* R_k^2)^exponent, from the last level up.
    exponent = 2 / 3
    with in_proportion():
        share = math.pi * 0.75**exponent
        peak = 1.5 / (math.pi * 0.75 ** (2 / 3))
        for size, count in zip(sizes[:0:-1], counts[::-1], strict=True):
            crowd = count * size * size
            share *= crowd ** (1 - exponent) * math.pi * 0.75 ** (2 / 3) * peak**exponent * 2 / (2 + exponent)
            exponent = (2 + exponent) / 3
        area = share * sizes[0] * sizes[0] * (load / modulus / sizes[0] / sizes[0]) ** exponent
    return HierarchyContact(area=area, exponent=exponent)
