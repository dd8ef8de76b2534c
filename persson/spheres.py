"""Contact of smooth spheres: Hertz, JKR, Derjaguin and between (Persson 2006, Secs. 3.1, 4 and App. B)."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar

from persson._checks import Array, non_negative, positive, real
from persson.errors import InvalidInput


def effective_radius(first: float, second: float) -> float:
    """R = R1 R2 / (R1 + R2) [m] of two spheres; infinite second radius for a flat."""
    a = positive("first", first, unit="m")
    if isinstance(second, float) and second == math.inf:
        return a
    b = positive("second", second, unit="m")
    return a * (b / (a + b))


@dataclass(frozen=True, kw_only=True)
class HertzContact:
    """Contact of two elastic spheres without adhesion.

    Attributes
    ----------
    radius : float
        r_0 [m] of the contact circle.
    approach : float
        s [m].
    peak_pressure : float
        sigma_max = 3/2 F / (pi r_0^2) [Pa].
    """

    radius: float
    approach: float
    peak_pressure: float

    def pressure(self, distance: ArrayLike) -> Array:
        """Pressure [Pa] at distances r [m] from the centre; 0 outside."""
        ratio = real("distance", distance, unit="m") / self.radius
        return self.peak_pressure * np.sqrt(np.maximum(1 - ratio * ratio, 0.0))


def hertz(force: float, *, radius: float, contact_modulus: float) -> HertzContact:
    """Contact radius, approach and peak pressure for a force [N], R [m] and E* [Pa].

    Persson 2006, Eqs. 4 and 6-8; the peak pressure is 3/2 of the mean (as in Sec. 4; the factor is missing in
    Sec. 3.1).

    Examples
    --------
    >>> contact = hertz(1.0, radius=1e-2, contact_modulus=1e9)
    >>> bool(abs(contact.radius**2 / 1e-2 - contact.approach) < 1e-18)
    True
    """
    load = positive("force", force)
    big = positive("radius", radius)
    modulus = positive("contact_modulus", contact_modulus)
    circle = big * math.cbrt(0.75 * load / (modulus * big * big))
    return HertzContact(
        radius=circle,
        approach=circle * (circle / big),
        peak_pressure=1.5 * load / (math.pi * circle * circle),
    )


def hertz_pressure_distribution(stress: ArrayLike, *, peak_pressure: float) -> Array:
    """P(sigma) = 2 sigma / sigma_max^2 [1/Pa] per contact area in (0, sigma_max) (Persson 2006, Eq. 23)."""
    peak = positive("peak_pressure", peak_pressure)
    sigma = real("stress", stress)
    return np.where((sigma > 0) & (sigma <= peak), 2 * (sigma / peak) / peak, 0.0)


def jkr_load(
    contact_radius: ArrayLike, *, radius: float, contact_modulus: float, work_of_adhesion: float
) -> Array:
    """Force [N] at which the contact radius is a [m] with short-ranged adhesion.

    F = 4 E* a^3 / (3 R) - sqrt(8 pi w E* a^3) (Johnson, Kendall and Roberts, Proc. R. Soc. A 324, 301, 1971).
    """
    a = non_negative("contact_radius", contact_radius)
    big = positive("radius", radius)
    modulus = positive("contact_modulus", contact_modulus)
    w = positive("work_of_adhesion", work_of_adhesion)
    cube = a * a * a
    return 4 * modulus * cube / (3 * big) - np.sqrt(8 * math.pi * w * modulus * cube)


def jkr_pull_off(radius: float, *, work_of_adhesion: float) -> float:
    """Pull-off force 3/2 pi w R [N], positive, of soft spheres."""
    return 1.5 * math.pi * positive("work_of_adhesion", work_of_adhesion) * positive("radius", radius)


def derjaguin_pull_off(radius: float, *, work_of_adhesion: float) -> float:
    """Pull-off force 2 pi w R [N], positive, of stiff spheres (Persson 2006, Eq. 53)."""
    return 2 * math.pi * positive("work_of_adhesion", work_of_adhesion) * positive("radius", radius)


def tabor_parameter(
    radius: float, *, contact_modulus: float, work_of_adhesion: float, range_: float
) -> float:
    """Tabor's mu = (R w^2 / (E*^2 z0^3))^(1/3) [-]: large for JKR, small for Derjaguin.

    Parameters
    ----------
    radius, contact_modulus, work_of_adhesion : float
        R [m], E* [Pa], w [J/m^2].
    range_ : float
        z0 [m], the range of the attraction.
    """
    z0 = positive("range_", range_)
    strain = positive("work_of_adhesion", work_of_adhesion) / (
        positive("contact_modulus", contact_modulus) * z0
    )
    return math.cbrt(positive("radius", radius) / z0 * strain * strain)


def maugis_pull_off(tabor: float) -> float:
    """Pull-off force over pi w R for a Tabor parameter: from 2 (Derjaguin) to 3/2 (JKR).

    Parameters
    ----------
    tabor : float
        mu; the attraction is a constant stress sigma_th over w / sigma_th, with lambda = 1.157 mu.

    Notes
    -----
    Maugis, J. Colloid Interface Sci. 150, 243 (1992); the load is minimised along his two equations, which
    are quadratic in the contact radius at a given ratio m of the outer to the inner radius.

    Examples
    --------
    >>> round(maugis_pull_off(1e-3), 3), round(maugis_pull_off(30.0), 3)
    (2.0, 1.5)
    """
    strength = 1.157 * positive("tabor", tabor)

    def load(logarithm: float) -> float:
        excess = math.exp(logarithm)
        root = math.sqrt(excess * (2 + excess))
        # arcsec m, and the combinations of Maugis without cancellation near m = 1.
        arc = math.atan(root)
        m = 1 + excess
        first = root + (m * m - 2) * arc
        second = root * arc - excess
        if excess < 1e-3:
            first = 8 / 3 * math.sqrt(2) * excess * math.sqrt(excess)
            second = excess
        a, b = 0.5 * strength * first, 4 / 3 * strength * strength * second
        radius = 2 / (b + math.sqrt(b * b + 4 * a))
        return radius**3 - strength * radius * radius * (root + m * m * arc)

    grid = np.linspace(math.log(1e-9), math.log(1e9), 2000)
    values = np.array([load(float(x)) for x in grid])
    low = int(np.argmin(values))
    bounds = (grid[max(low - 1, 0)], grid[min(low + 1, grid.size - 1)])
    best = minimize_scalar(load, bounds=bounds, method="bounded", options={"xatol": 1e-10})
    return float(-best.fun)


@dataclass(frozen=True, kw_only=True)
class DoubleHertz:
    r"""Adhesive contact as the difference of two Hertzian pressures, of radii a and b = eta a.

    .. math:: \sigma(r) = \sigma_1\sqrt{1-r^2} - \frac{\sigma_a}{\sqrt{\eta^2-1}}\sqrt{\eta^2-r^2}, \qquad
              \sigma_1 = \sigma_\mathrm{max} + \frac{\sigma_a\eta}{\sqrt{\eta^2-1}}

    with r in units of a; the surfaces touch for r < 1 and attract each other up to r = eta.

    Parameters
    ----------
    peak_pressure : float
        sigma_max [Pa] at the centre.
    tensile_limit : float
        sigma_a [Pa] at r = 1; 0 is Hertz.
    eta : float
        b/a > 1.

    Notes
    -----
    Persson 2006, App. B, after Greenwood and Johnson, J. Phys. D 31, 3279 (1998). Forces carry the factor
    a^2 that the paper leaves out by setting a = 1.

    Examples
    --------
    >>> contact = DoubleHertz(peak_pressure=1.0, tensile_limit=0.3, eta=1.1)
    >>> round(contact.load(1.0), 5), round(float(contact.distribution(1.0)), 5)
    (1.77767, 1.77781)
    """

    peak_pressure: float
    tensile_limit: float
    eta: float

    def __post_init__(self) -> None:
        positive("peak_pressure", self.peak_pressure)
        non_negative("tensile_limit", self.tensile_limit)
        if not positive("eta", self.eta) > 1:
            raise InvalidInput(f"eta = {self.eta!r}: must exceed 1")

    @property
    def _ring(self) -> float:
        return math.sqrt((self.eta - 1) * (self.eta + 1))

    @property
    def _inner(self) -> float:
        return self.peak_pressure + self.tensile_limit * self.eta / self._ring

    def pressure(self, distance: ArrayLike) -> Array:
        """Pressure [Pa] at r/a; negative where the surfaces attract, 0 beyond eta."""
        r2 = np.square(non_negative("distance", distance))
        inner = self._inner * np.sqrt(np.maximum(1 - r2, 0.0))
        outer = self.tensile_limit / self._ring * np.sqrt(np.maximum(self.eta**2 - r2, 0.0))
        return np.asarray(inner - outer)[()]

    def load(self, contact_radius: float) -> float:
        """Return the applied force F_N = (2 pi/3) a^2 (sigma_max - eta sqrt(eta^2 - 1) sigma_a)."""
        a = positive("contact_radius", contact_radius)
        return 2 * math.pi / 3 * a * a * (self.peak_pressure - self.eta * self._ring * self.tensile_limit)

    def contact_force(self, contact_radius: float) -> float:
        """Force in the contact area, load and adhesion load: F_N + (2 pi/3) a^2 sigma_a (eta^2 - 1) [N]."""
        a = positive("contact_radius", contact_radius)
        return self.load(a) + 2 * math.pi / 3 * a * a * self.tensile_limit * self._ring * self._ring

    def distribution(self, stress: ArrayLike) -> Array:
        """P(sigma) [1/Pa] per contact area; starts as 2 (sigma + sigma_a) / sigma_1^2 at -sigma_a."""
        sigma = real("stress", stress)
        inside = (sigma >= -self.tensile_limit) & (sigma <= self.peak_pressure)
        s = np.where(inside, sigma, 0.0)
        s1, sa = self._inner, self.tensile_limit
        b = sa / self._ring
        # v = sqrt(1 - r^2) solves s1 v - b sqrt(ring^2 + v^2) = sigma.
        difference = (s1 - b) * (s1 + b)
        root = np.sqrt(np.square(b * s) + difference * sa * sa)
        v = (s1 * s + root) / difference
        outer = np.sqrt(self._ring * self._ring + v * v)
        with np.errstate(divide="ignore"):
            density = 2 * v * outer / (s1 * outer - b * v)
        return np.where(inside, density, 0.0)[()]
