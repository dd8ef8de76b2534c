"""Contact as a sum over independent asperities (Persson 2006, Secs. 3.2 and 3.3).

Greenwood and Williamson (1966) with equal spheres, which may yield, Bush, Gibson and Thomas (1975) with the
ellipsoidal summits of a Gaussian surface, Fuller and Tabor (1975) with adhesion. The statistics of summits
are those of Nayak (1971).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import binom, ellipe, ellipk, ellipkm1, gamma, pbdv

from persson._checks import Array, instance, positive, positive_fields, real
from persson._quadrature import gauss, panels
from persson.errors import InvalidInput
from persson.spectrum import Moments

#: Height in standard deviations beyond which series replace parabolic cylinder functions.
_FAR = 12.0
#: Standard deviations above the mean beyond which there are no summits.
_HIGHEST = 12.0


def tail_moment(order: float, height: ArrayLike) -> Array:
    """Int_t^inf (x - t)^n phi(x) dx for the normal density phi, in parabolic cylinder functions."""
    t = np.asarray(height, dtype=float)
    safe = np.clip(t, -_FAR, 3 * _FAR)
    value, _ = pbdv(-order - 1, safe)
    near = gamma(order + 1) * np.exp(-0.25 * safe * safe) * value / math.sqrt(2 * math.pi)
    # Far below the mean nearly everything touches: the moments of x about -t, term by term.
    depth = np.maximum(-t, _FAR)
    far = sum(
        binom(order, 2 * k) * depth ** (order - 2 * k) * math.prod(range(1, 2 * k, 2)) for k in range(6)
    )
    return np.where(t < -_FAR, far, np.where(t > 3 * _FAR, 0.0, near))


@dataclass(frozen=True, kw_only=True)
class AsperityContact:
    """Contact of a surface of asperities with a plane.

    Attributes
    ----------
    area : array
        A/A0.
    pressure : array
        Nominal pressure [Pa].
    density : array
        Asperities in contact per area [1/m^2].
    patch_area : array
        Mean patch sum A_i^2 / sum A_i [m^2]; nan where the theory does not give it.
    area_plastic : array
        The part of the area that has yielded.
    """

    area: Array
    pressure: Array
    density: Array
    patch_area: Array
    area_plastic: ArrayLike = 0.0


@dataclass(frozen=True, kw_only=True)
class Asperities:
    """Spherical asperities of one radius with Gaussian heights.

    Parameters
    ----------
    density : float
        n_0 [1/m^2].
    radius : float
        R [m].
    rms_height : float
        h* [m], of the summits about their mean.
    """

    density: float
    radius: float
    rms_height: float

    def __post_init__(self) -> None:
        positive_fields(self, "density", "radius", "rms_height")

    def contact(self, separation: ArrayLike, *, contact_modulus: float) -> AsperityContact:
        """Contact at separations d [m] from the mean summit height (Persson 2006, Eqs. 10-12)."""
        modulus = positive("contact_modulus", contact_modulus)
        t = real("separation", separation) / self.rms_height
        one = tail_moment(1, t)
        scale = self.density * self.radius * self.rms_height
        # Where nothing touches there is no patch.
        patch = math.pi * self.radius * self.rms_height * tail_moment(2, t) / np.where(one > 0, one, 1.0)
        # R^(1/2) h^(3/2) = R h sqrt(h / R): the ratio is dimensionless.
        slope = math.sqrt(self.rms_height / self.radius)
        return AsperityContact(
            area=math.pi * scale * one,
            pressure=4 / 3 * modulus * scale * slope * tail_moment(1.5, t),
            density=self.density * tail_moment(0, t),
            patch_area=np.where(one > 0, patch, np.nan)[()],
        )

    def contact_at(self, pressure: float, *, contact_modulus: float) -> AsperityContact:
        """Contact at a nominal pressure [Pa]."""
        target = math.log(positive("pressure", pressure))

        def miss(t: float) -> float:
            contact = self.contact(t * self.rms_height, contact_modulus=contact_modulus)
            return math.log(float(contact.pressure)) - target

        if miss(30.0) > 0 or miss(-30.0) < 0:
            raise InvalidInput(f"pressure = {pressure!r} Pa: no separation within 30 rms heights carries it")
        root = brentq(miss, -30.0, 30.0, xtol=1e-13, rtol=1e-14)
        return self.contact(root * self.rms_height, contact_modulus=contact_modulus)


def ring_asperities(wavevector: float, *, rms_height: float) -> Asperities:
    """Estimates for roughness near one wavevector q_m [1/m] with h_rms [m] (Persson 2006, Sec. 3.2).

    n_0 = q_m^2 / (2 pi^2 sqrt 3) = 0.029 q_m^2, 1/R = sqrt 2 q_m^2 h_rms, h* = 0.6 h_rms.

    Examples
    --------
    >>> round(ring_asperities(1.0, rms_height=1.0).density, 4)
    0.0292
    """
    q, h = positive("wavevector", wavevector), positive("rms_height", rms_height)
    return Asperities(
        density=q * q / (2 * math.pi**2 * math.sqrt(3)),
        radius=1 / (math.sqrt(2) * q * (q * h)),
        rms_height=0.6 * h,
    )


def _check_moments(moments: Moments) -> None:
    instance("moments", moments, Moments, what="`Moments`")
    if not (moments.m0 > 0 and moments.m2 > 0 and moments.nayak > 1.5 * (1 - 1e-9)):
        raise InvalidInput("moments: a flat surface has no summits, and none has m0 m4 below m2^2")


def nayak_asperities(moments: Moments) -> Asperities:
    r"""Density, mean curvature and height scatter of the summits of a Gaussian surface, exact.

    .. math:: n_0 = \frac{m_4}{8\pi\sqrt3\, m_2}, \quad
              \frac1R = \frac83\sqrt{\frac{3 m_4}{8\pi}}, \quad
              h^{*2} = m_0\left[1 - \frac{3}{2\alpha}\left(\frac23 + \frac{32}{3\pi} - 2\sqrt3\right)\right]

    with the areal moments of `persson.spectrum.Moments` and alpha their Nayak parameter.

    Notes
    -----
    Nayak, J. Lubr. Technol. 93, 398 (1971); the bracket is 1 - 0.8968/alpha.

    Examples
    --------
    >>> ring = nayak_asperities(Moments(m0=1.0, m2=1.0, m4=1.0))
    >>> round(ring.density, 4), round(ring.rms_height, 3)
    (0.023, 0.634)
    """
    _check_moments(moments)
    reduction = 1.5 / moments.nayak * (2 / 3 + 32 / (3 * math.pi) - 2 * math.sqrt(3))
    return Asperities(
        density=moments.m4 / moments.m2 / (8 * math.pi * math.sqrt(3)),
        radius=1 / (8 / 3 * math.sqrt(3 * moments.m4 / (8 * math.pi))),
        rms_height=math.sqrt(moments.m0 * (1 - reduction)),
    )


def bush_gibson_thomas(separation: ArrayLike, *, moments: Moments, contact_modulus: float) -> AsperityContact:
    """Contact of a Gaussian surface by Hertz theory on each of its ellipsoidal summits, at any separation.

    Parameters
    ----------
    separation : float or array
        Distance d [m] of the plane from the mean plane of the surface.
    moments : Moments
        Areal moments of the surface.
    contact_modulus : float
        E* [Pa].

    Notes
    -----
    Bush, Gibson and Thomas, Wear 35, 87 (1975), with Nayak's joint distribution of summit height and
    curvatures. As d grows A/A0 tends to sqrt(2 pi) p0 / (E* h'_rms), the slower the larger the Nayak
    parameter; it leaves that limit already at very small areas (Carbone and Bottiglione, J. Mech. Phys.
    Solids 56, 2555, 2008).
    """
    modulus = positive("contact_modulus", contact_modulus)
    _check_moments(moments)
    alpha = moments.nayak
    if not alpha > 1.5 * (1 + 1e-9):
        raise InvalidInput(
            f"Nayak parameter = {alpha!r}: must exceed 1.5, where the roughness has one wavelength only"
        )
    d = real("separation", separation) / math.sqrt(moments.m0)
    rho = math.sqrt(1.5 / alpha)
    scatter = math.sqrt(1 - rho * rho)
    # Standard deviation of half the sum of curvatures: sqrt(8/3 m4 of a profile) / 2, and that moment is 3/8
    # m4.
    curvature = math.sqrt(moments.m4) / 2
    t, w, weight = _summits()
    shape_area, shape_load = _ellipse(w)
    threshold = (d[..., None, None] - rho * t[:, None]) / scatter
    height = scatter * math.sqrt(moments.m0)
    weights = weight * 2 * math.sqrt(3)
    # With mean curvature k = T * curvature: area = pi shape delta / k, load = 4/3 E* shape delta^(3/2) /
    # sqrt(k).
    k = t[:, None]
    one, three = tail_moment(1, threshold), tail_moment(1.5, threshold)
    count = nayak_asperities(moments).density
    scale = count * height / curvature
    area = math.pi * scale * np.sum(weights * shape_area * one / k, axis=(-2, -1))
    slope = math.sqrt(height * curvature)
    carried = np.sum(weights * shape_load * three / np.sqrt(k), axis=(-2, -1))
    pressure = 4 / 3 * modulus * scale * slope * carried
    density = count * np.sum(weights * tail_moment(0, threshold), axis=(-2, -1))
    return AsperityContact(
        area=area, pressure=pressure, density=density, patch_area=np.full(np.shape(area), np.nan)
    )


def _summits() -> tuple[Array, Array, Array]:
    """Quadrature over summits: normalised curvature T, w = (k1 - k2)/(k1 + k2), and weights up to 2 sqrt 3.

    Their density is phi(T) (T^2 - y) exp(-y), with y = (w T)^2 < T^2.
    """
    (t, wt), (w, ww) = panels(np.array([0.0, 13.0]), 80), gauss(40)
    y = np.square(t[:, None] * w)
    density = np.exp(-0.5 * t * t)[:, None] / math.sqrt(2 * math.pi) * (t[:, None] ** 2 - y) * np.exp(-y)
    jacobian = 2 * t[:, None] ** 2 * w
    return t, w, density * jacobian * wt[:, None] * ww


def _ellipse(w: Array) -> tuple[Array, Array]:
    """Area and load of an elliptic Hertz contact over those of a sphere of equal mean curvature and approach.

    With semi-axes a > b, e^2 = 1 - b^2/a^2 and complete elliptic integrals K, E of e: curvatures k1 > k2 have
    k1/k2 = [(a/b)^2 E - K] / (K - E) (Johnson, Contact Mechanics, Sec. 4.2).
    """
    target = (1 + w) / (1 - w)
    ratios = np.array([_axis_ratio(float(value)) for value in target])
    e2 = 1 - ratios * ratios
    k, e = ellipkm1(ratios * ratios), ellipe(e2)
    # k2 = 1 - w in units of the mean curvature; a^2 = 2 delta (K - E) / (k2 e^2 K).
    with np.errstate(invalid="ignore"):
        part = np.where(e2 > 1e-6, (k - e) / np.where(e2 > 0, e2, 1.0), math.pi / 4)
    a2 = 2 * part / ((1 - w) * k)
    area = a2 * ratios
    load = np.sqrt(a2) * math.pi / (2 * k)
    return area, load


def _axis_ratio(curvatures: float) -> float:
    """b/a of the contact ellipse for a ratio of principal curvatures >= 1."""
    if curvatures < 1 + 1e-9:
        return 1.0

    def miss(log: float) -> float:
        ratio = math.exp(log)
        e2 = 1 - ratio * ratio
        k, e = float(ellipk(e2)), float(ellipe(e2))
        return (e / (ratio * ratio) - k) / (k - e) - curvatures

    return math.exp(brentq(miss, -12.0, -1e-5, xtol=1e-13)) if miss(-1e-5) < 0 else 1.0


def yielding_asperities(
    separation: ArrayLike, *, asperities: Asperities, contact_modulus: float, hardness: float
) -> AsperityContact:
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
    modulus = positive("contact_modulus", contact_modulus)
    limit = positive("hardness", hardness)
    height, radius = asperities.rms_height, asperities.radius
    t = real("separation", separation) / height
    onset = radius / height * min(0.75 * math.pi * limit / modulus, 1e15) ** 2
    late = t + onset
    beyond = tail_moment(1, late)
    scale = asperities.density * radius * height
    plastic = math.pi * scale * (2 * beyond + onset * tail_moment(0, late))
    below = np.maximum(tail_moment(1, t) - beyond - onset * tail_moment(0, late), 0.0)
    slope = math.sqrt(height / radius)
    elastic = 4 / 3 * modulus * scale * slope * _unyielded(t, onset)
    area = math.pi * scale * below + plastic
    return AsperityContact(
        area=area,
        area_plastic=plastic,
        pressure=elastic + limit * plastic,
        density=asperities.density * tail_moment(0, t),
        patch_area=np.full(np.shape(area), np.nan)[()],
    )


def _unyielded(t: Array, span: float) -> Array:
    """Int_t^(t + span) (x - t)^(3/2) phi(x) dx, where phi is; x = low + w y^2 takes the root at t away."""
    y, weights = gauss(160)
    low = np.maximum(t, -_HIGHEST)
    width = np.maximum(np.minimum(t + span, _HIGHEST) - low, 0.0)
    rise = width[..., None] * y * y
    deep = (low - t)[..., None] + rise
    density = np.exp(-0.5 * (low[..., None] + rise) ** 2) / math.sqrt(2 * math.pi)
    return np.asarray(2 * width * ((deep * np.sqrt(deep) * y * density) @ weights))


@dataclass(frozen=True, kw_only=True)
class FullerTabor:
    """Adhesive contact of Gaussian asperities, each by the theory of Johnson, Kendall and Roberts.

    Parameters
    ----------
    asperities : Asperities
        Density, radius and height scatter.
    contact_modulus : float
        E* [Pa].
    work_of_adhesion : float
        w [J/m^2].

    Notes
    -----
    Fuller and Tabor, Proc. R. Soc. A 345, 327 (1975). Asperities stay stuck until stretched by delta_c.
    """

    asperities: Asperities
    contact_modulus: float
    work_of_adhesion: float

    def __post_init__(self) -> None:
        instance("asperities", self.asperities, Asperities, what="`Asperities`")
        positive_fields(self, "contact_modulus", "work_of_adhesion")

    @property
    def _length(self) -> float:
        """Contact radius (pi w R^2 / E*)^(1/3) [m] that scales the problem of one asperity."""
        big = self.asperities.radius
        return big * math.cbrt(math.pi * self.work_of_adhesion / self.contact_modulus / big)

    @property
    def stretch(self) -> float:
        """delta_c [m]: the stretch at which an asperity lets go; adhesion is lost where h* is much larger."""
        return 0.75 * self._length * (self._length / self.asperities.radius)

    def pressure(self, separation: ArrayLike) -> Array:
        """Nominal pressure [Pa] at separations d [m] from the mean summit height, on pulling apart.

        Negative is tension.
        """
        d = real("separation", separation)
        a, big = self._length, self.asperities.radius
        unit = a * (a / big)
        h = self.asperities.rms_height / unit
        offset = d / unit
        # Summits from d - 3/4 up stick; t = low + span u^2 removes the square root where they let go.
        low = np.clip((offset - 0.75) / h, -9.0, 9.0)
        u, weights = gauss(240)
        span = 9.0 - low
        t = low[..., None] + span[..., None] * u * u
        x = _jkr_radius(h * t - offset[..., None])
        force = 4 / 3 * x * x * x - math.sqrt(8) * x * np.sqrt(x)
        density = np.exp(-0.5 * t * t) / math.sqrt(2 * math.pi)
        total = 2 * span * ((density * force * u) @ weights)
        return self.asperities.density * self.contact_modulus * a * unit * total

    def pull_off(self) -> float:
        """Largest nominal tension [Pa], as a positive number."""
        h, c = self.asperities.rms_height, self.stretch
        d = np.linspace(-2 * h - 2 * c, 4 * h + 2 * c, 1200)
        return float(max(-np.min(self.pressure(d)), 0.0))


def _jkr_radius(approach: Array) -> Array:
    """Contact radius x >= 1/2 with x^2 - sqrt(2x) = approach >= -3/4, in units of the length, length^2/R."""
    excess = np.maximum(approach + 0.75, 0.0)
    # Near the end (x - 1/2)^2 grows like 2/3 of the excess, far away x^2 like the approach; Newton from
    # above.
    x = 0.5 + np.sqrt(excess) + np.where(excess > 0, 1e-9, 0.0)
    for _ in range(40):
        slope = 2 * x - 1 / np.sqrt(2 * x)
        miss = (x - 0.5) * (x + 0.5) - np.sqrt(2 * x) + 1 - excess
        step = miss / np.where(slope > 0, slope, np.inf)
        x = np.maximum(x - step, 0.5)
        if np.all(np.abs(step) < 1e-14 * x):
            break
    return x
