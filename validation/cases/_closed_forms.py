"""Contact problems with a known answer, to hold solvers against."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad

from fem_contact.surface import HeightField
from validation.arrays import Array, Pair

#: Sums over a square lattice of period 1 without its origin: of 1/R^3, and of 1/R less a uniform background.
LATTICE_CUBE, LATTICE_MADELUNG = 9.03362168, -3.90026492


def periodic(heights: Array) -> HeightField:
    """Return heights as a surface of period 1 along both sides."""
    return HeightField(heights=heights, lengths=(1.0, 1.0))


def places(n: int, part: float = 0.5) -> Array:
    """Return n places across the period, from its middle: each this part of a cell inside its own."""
    return (np.arange(n) + part) / n - 0.5


@dataclass(frozen=True, kw_only=True)
class HertzInPeriod:
    r"""A paraboloid repeated in a square of side 1, pressed until its contact radius is `radius`.

    .. math:: p = \frac{2 E^* a}{\pi R}\sqrt{1 - r^2/a^2}, \qquad F = \frac{4 E^* a^3}{3 R}

    The images of the load bend the surface near the origin like F sum R^-3 r^2 / (4 pi E*); the paraboloid is
    made flatter by that much, so that Hertz's solution holds with R = 1 up to terms in (a/L)^5.
    """

    radius: float = 0.1  # Contact radius a over the period
    contact_modulus: float = 1.0  # E* [Pa]

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
        """Approach of the apex over the period, without the mean displacement.

        Images of the load F, of the second moment <r^2> = 2 a^2 / 5, add F <r^2> sum R^-3 / (4 pi E*) to
        what they do as points.
        """
        images = LATTICE_MADELUNG + self.radius**2 * LATTICE_CUBE / 10
        return self.radius**2 + self.load / self.contact_modulus * images / math.pi

    def distance(self, n: int, shift: Pair = (0.0, 0.0)) -> Array:
        """Distance of n x n points from the apex, which lies `shift` cells beside a point."""
        x, y = (places(n, part) for part in shift)
        return np.hypot(x[:, None], y[None, :])

    def surface(self, n: int, shift: Pair = (0.0, 0.0)) -> HeightField:
        """Return the paraboloid on n x n points."""
        curvature = 1 - self.load / self.contact_modulus * LATTICE_CUBE / (2 * math.pi)
        return periodic(-(self.distance(n, shift) ** 2) * curvature / 2)

    def stress(self, x: Array, y: Array, depth: float, *, poisson: float) -> Array:
        r"""Stress [Pa] below the apex, (..., 6): Huber's, with what the images add near the axis.

        .. math:: \Delta\sigma_{xx} = \Delta\sigma_{yy} = -\frac{F}{2\pi} (1 + \nu)\, z \sum R^{-3}
                  + \Bigl(\tfrac12 + \nu - \frac{\nu}{1 - \nu}\Bigr) \frac{F}{L^2}

        The sum over all loads has the mean -(1/2 + nu) F/L^2 sideways; a given period has -nu/(1 - nu) F/L^2.
        """
        stress = huber_stress(x, y, depth, radius=self.radius, peak=self.peak, poisson=poisson)
        images = -(1 + poisson) * depth * LATTICE_CUBE / (2 * math.pi)
        stress[..., :2] += self.load * (images + 0.5 + poisson - poisson / (1 - poisson))
        return stress

    def pressure(self, r: Array) -> Array:
        """Exact pressure [Pa] at a distance from the apex."""
        return np.asarray(self.peak * np.sqrt(np.maximum(1 - (r / self.radius) ** 2, 0)))


#: D of the egg box D cos(2 pi x) cos(2 pi y), and the mean pressure at which it is pressed flat where E* = 1:
#: E* q D / 2 with q = 2 pi sqrt 2.
EGG_BOX_DEPTH = 0.01
EGG_BOX_FLAT = math.sqrt(2) * math.pi * EGG_BOX_DEPTH


def egg_box(n: int) -> HeightField:
    """Return the egg box on n x n points, none of which is a peak."""
    x = np.cos(2 * np.pi * (np.arange(n) + 0.5) / n)
    return periodic(EGG_BOX_DEPTH * x[:, None] * x[None, :])


@dataclass(frozen=True, kw_only=True)
class Westergaard:
    r"""A wave h cos(2 pi x) of period 1, pressed until it touches over a strip of width 2b.

    .. math:: p_0 = \pi E^* h \sin^2 \pi b, \qquad
              p = \frac{2 p_0 \cos \pi x}{\sin^2 \pi b} \sqrt{\sin^2 \pi b - \sin^2 \pi x}

    Source: [westergaard1939].
    """

    half_width: float = 0.3  # b
    amplitude: float = 0.01  # h
    contact_modulus: float = 1.0  # E* [Pa]

    @property
    def load(self) -> float:
        """Mean pressure p0 [Pa]."""
        return math.pi * self.contact_modulus * self.amplitude * math.sin(math.pi * self.half_width) ** 2

    def surface(self, n: int, across: tuple[int, float] | None = None) -> HeightField:
        """Return the wave, its crest midway between two of n points, with `across`: points and length."""
        points, length = across or (4, 4 / n)
        heights = self.amplitude * np.cos(2 * np.pi * places(n))[:, None] * np.ones(points)
        return HeightField(heights=heights, lengths=(1.0, length))

    def pressure(self, x: Array) -> Array:
        """Pressure [Pa] at a distance from the crest."""
        edge = math.sin(math.pi * self.half_width) ** 2
        root = np.sqrt(np.maximum(edge - np.sin(np.pi * x) ** 2, 0))
        return np.asarray(2 * self.load * np.cos(np.pi * x) / edge * root)

    def stress(self, x: Array, depth: float, *, poisson: float) -> Array:
        r"""Stress [Pa] below the wave in plane strain, (..., 6): xx, yy, zz, yz, xz, xy.

        .. math:: \sigma_{zz} = -\Re Z + d\, \Im Z', \quad \sigma_{xx} = -\Re Z - d\, \Im Z', \quad
                  \sigma_{xz} = -d\, \Re Z', \qquad w = x - i d

        Z is analytic below the surface, with the pressure as its real part there: p of complex x, less what
        grows downwards. The mean is that of a solid which cannot expand sideways.
        """
        w = np.pi * (np.asarray(x) - 1j * np.asarray(depth))
        edge = math.sin(math.pi * self.half_width) ** 2
        sine, cosine = np.sin(w), np.cos(w)
        # The branch that is positive in the contact, and i sin(w) deep down.
        root = np.sqrt(edge - sine**2)
        root = np.where((root * np.conj(1j * sine)).real < 0, -root, root)
        scale = 2 * self.load / edge
        potential = scale * cosine * (root - 1j * sine)
        slope = np.pi * scale * (-sine * (root - 1j * sine) + cosine * (-sine * cosine / root - 1j * cosine))
        stress = np.zeros((*potential.shape, 6))
        stress[..., 0] = -potential.real - depth * slope.imag
        stress[..., 2] = -potential.real + depth * slope.imag
        stress[..., 4] = -depth * slope.real
        # Along the ridges nothing moves; sideways the mean is that of the confined solid.
        stress[..., 0] += self.load * (1 - poisson / (1 - poisson))
        stress[..., 1] = poisson * (stress[..., 0] + stress[..., 2])
        return stress


def integral(function: Callable[[float], float], low: float, high: float) -> float:
    """Integrate to eleven digits by an adaptive quadrature, which knows nothing of the integrand."""
    return float(quad(function, low, high, epsabs=0, epsrel=1e-11)[0])


def huber_stress(
    x: ArrayLike, y: ArrayLike, depth: ArrayLike, *, radius: float, peak: float, poisson: float
) -> Array:
    """Stress (..., 6) [Pa] below Hertz's pressure on a circle, at depths above 0.

    Source: [huber1904]; A. C. Fischer-Cripps, Introduction to Contact Mechanics,
    Sec. 5.4.
    """
    a, nu = radius, poisson
    x, y, z = (np.asarray(part, dtype=float) for part in (x, y, depth))
    r = np.hypot(x, y)
    excess = r**2 + z**2 - a**2
    u = (excess + np.sqrt(excess**2 + 4 * a**2 * z**2)) / 2
    w, bend = z / np.sqrt(u), a**2 * u / (u**2 + a**2 * z**2)
    arc = (1 + nu) * np.sqrt(u) / a * np.arctan(a / np.sqrt(u))
    far = np.where(r > 0, r, 1.0)
    ring = (1 - 2 * nu) / 3 * np.where(r > 0, (a / far) ** 2 * (1 - w**3), 1.5 * a**2 / (a**2 + z**2))
    radial = ring + w**3 * bend + w * (u * (1 - nu) / (a**2 + u) + arc - 2)
    hoop = -(ring + w * (2 * nu + u * (1 - nu) / (a**2 + u) - arc))
    shear = r * z**2 / (u**2 + a**2 * z**2) * a**2 * np.sqrt(u) / (u + a**2)
    cos, sin = np.where(r > 0, x / far, 1.0), np.where(r > 0, y / far, 0.0)
    components = (
        radial * cos**2 + hoop * sin**2,
        radial * sin**2 + hoop * cos**2,
        -(w**3) * bend,
        shear * sin,
        shear * cos,
        (radial - hoop) * cos * sin,
    )
    return np.asarray(peak * np.stack(components, axis=-1))
