"""A thin elastic plate on a rough surface: the modulus its waves feel (Persson 2006, Sec. 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from persson._checks import Array, poisson_ratio, positive
from persson.graded import checked_wavevectors


@dataclass(frozen=True, kw_only=True)
class ElasticPlate:
    r"""Modulus felt at wavevector q by a plate whose other face is free, as a contact modulus.

    .. math:: E^*(q) = \frac{E}{1-\nu^2}\,\frac{\sinh^2 x - x^2}{\sinh x\cosh x + x}, \qquad x = q d

    Parameters
    ----------
    young, poisson : float
        E [Pa] and nu.
    thickness : float
        d [m].

    Notes
    -----
    Exact in plane strain without friction, from the stress function of a strip. Long waves bend the
    plate: E*(q) tends to (E*/6) (q d)^3, which is the bending stiffness E d^3 / 12 (1 - nu^2) times 2
    q^3, the limit that Persson (2006), Sec. 5, names (B. N. J. Persson and S. Gorb, J. Chem. Phys. 119,
    11437, 2003). Short waves feel the bulk. An instance goes to `persson.scale.Scale` as its modulus, and
    from there into sigma_a and the elastic energy. Where V grows by waves with q d < 1 only, the plate
    lies on the roughness almost without resistance.

    Examples
    --------
    >>> plate = ElasticPlate(young=1e9, poisson=0.0, thickness=1e-6)
    >>> round(float(plate(1e4)) / 1e3, 4), round(float(plate(1e8)) / 1e9, 6)
    (0.1667, 1.0)
    """

    young: float
    poisson: float
    thickness: float

    def __post_init__(self) -> None:
        positive("young", self.young, unit="Pa")
        poisson_ratio(self.poisson)
        positive("thickness", self.thickness, unit="m")

    def __call__(self, wavevector: ArrayLike) -> Array:
        """E*(q) [Pa] for wavevectors [1/m]."""
        x = checked_wavevectors(wavevector) * self.thickness
        bulk = self.young / (1 - self.poisson * self.poisson)
        thin = np.minimum(x, 0.3)
        y = 4 * thin * thin
        # sinh^2 x - x^2 and sinh x cosh x + x as series of cosh 2x and sinh 2x, where they would cancel.
        above = y * y / 48 * (1 + y / 30 * (1 + y / 56 * (1 + y / 90 * (1 + y / 132))))
        under = thin * (2 + y / 6 * (1 + y / 20 * (1 + y / 42 * (1 + y / 72))))
        wide = np.clip(x, 0.3, 30.0)
        thick = (np.sinh(wide) ** 2 - wide * wide) / (np.sinh(wide) * np.cosh(wide) + wide)
        return np.asarray(bulk * np.where(x < 0.3, above / under, np.where(x < 30, thick, 1.0)))[()]
