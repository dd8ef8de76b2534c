"""Contact problems with a known answer, to hold solvers against."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem_contact.surface import HeightField

__all__ = ["HertzInPeriod", "westergaard_mean_pressure", "westergaard_pressure"]

Array = NDArray[np.float64]

#: Sums over a square lattice of period 1 without its origin: of 1/R^3, and of 1/R less a uniform background.
_LATTICE_CUBE, _LATTICE_MADELUNG = 9.03362168, -3.90026492


@dataclass(frozen=True, kw_only=True)
class HertzInPeriod:
    r"""A paraboloid repeated in a square of side 1, pressed until its contact radius is `radius`.

    .. math:: p = \frac{2 E^* a}{\pi R}\sqrt{1 - r^2/a^2}, \qquad F = \frac{4 E^* a^3}{3 R}

    The images of the load bend the surface near the origin like F sum R^-3 r^2 / (4 pi E*); the paraboloid is
    made flatter by that much, so that Hertz's solution holds with R = 1 up to terms in (a/L)^5.

    Attributes
    ----------
    radius : float
        Contact radius a over the period.
    contact_modulus : float
        E* [Pa].
    """

    radius: float = 0.1
    contact_modulus: float = 1.0

    @property
    def load(self) -> float:
        """F / L^2 [Pa]: the mean pressure."""
        return 4 * self.contact_modulus * self.radius**3 / 3

    @property
    def peak(self) -> float:
        """Largest pressure [Pa]."""
        return 2 * self.contact_modulus * self.radius / math.pi

    @property
    def approach(self) -> float:
        """Approach of the apex over the period, without the mean displacement."""
        return self.radius**2 + self.load / self.contact_modulus * _LATTICE_MADELUNG / math.pi

    def distance(self, n: int, shift: tuple[float, float] = (0.5, 0.5)) -> Array:
        """Distance of n x n points from the apex, which lies `shift` cells beside a point."""
        x, y = ((np.arange(n) + part) / n - 0.5 for part in shift)
        return np.hypot(x[:, None], y[None, :])

    def surface(self, n: int, shift: tuple[float, float] = (0.5, 0.5)) -> HeightField:
        """Return the paraboloid on n x n points."""
        curvature = 1 - self.load / self.contact_modulus * _LATTICE_CUBE / (2 * math.pi)
        return HeightField(heights=-(self.distance(n, shift) ** 2) * curvature / 2, lengths=(1.0, 1.0))

    def pressure(self, r: Array) -> Array:
        """Exact pressure [Pa] at a distance from the apex."""
        return np.asarray(self.peak * np.sqrt(np.maximum(1 - (r / self.radius) ** 2, 0)))


def westergaard_mean_pressure(amplitude: float, *, half_width: float, contact_modulus: float = 1.0) -> float:
    r"""Mean pressure at which a wave of period 1 touches over a strip of width 2 `half_width`.

    .. math:: p_0 = \pi E^* h \sin^2(\pi b)

    Source: H. M. Westergaard, J. Appl. Mech. 6, 49 (1939).
    """
    return math.pi * contact_modulus * amplitude * math.sin(math.pi * half_width) ** 2


def westergaard_pressure(x: Array, *, half_width: float, mean_pressure: float) -> Array:
    r"""Pressure under a wave of period 1 whose crest is at x = 0.

    .. math:: p = \frac{2 p_0 \cos \pi x}{\sin^2 \pi b} \sqrt{\sin^2 \pi b - \sin^2 \pi x}
    """
    edge = math.sin(math.pi * half_width) ** 2
    root = np.sqrt(np.maximum(edge - np.sin(np.pi * x) ** 2, 0))
    return np.asarray(2 * mean_pressure * np.cos(np.pi * x) / edge * root)
