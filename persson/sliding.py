"""Shear stress of sliding contacts (Persson 2006, Sec. 10.1), and friction by viscoelastic losses."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from persson._checks import (
    GREATEST,
    Array,
    function,
    non_negative,
    poisson_ratio,
    positive,
    real,
    returned,
    scalar,
    within,
)
from persson._quadrature import gauss
from persson.elastic import contact_area
from persson.errors import InvalidInput
from persson.spectrum import Spectrum, check_spectrum
from persson.variants import energy_factor

#: Rings of the integral over q for each e-fold, and directions in a quarter of each.
_RINGS, _DIRECTIONS = 40, 64
#: Wavevectors whose lengths agree to this many digits of the shortest make one ring.
_DIGITS = 9


def nominal_shear_stress(area: ArrayLike, *, local_shear_stress: float) -> Array:
    """Nominal shear stress tau = tau_f A/A0 [Pa]: tau_f holds in the real contact, whatever its pressure.

    Persson 2006, Sec. 10.1; `area` is A/A0 in [0, 1], `local_shear_stress` tau_f [Pa].

    Examples
    --------
    >>> float(nominal_shear_stress(0.25, local_shear_stress=50e6))
    12500000.0
    """
    share = non_negative("area", area)
    if np.any(share > 1):
        raise InvalidInput(f"area = {float(np.max(share))!r}: must lie in [0, 1]")
    return share * positive("local_shear_stress", local_shear_stress)


def local_shear_stress(nominal: ArrayLike, *, pressure: float, hardness: float) -> Array:
    """Local shear stress tau_f = tau H / sigma_0 [Pa] of a contact that has yielded, A/A0 = sigma_0/H.

    Persson 2006, Sec. 10.1; `nominal` is tau [Pa], `pressure` sigma_0 [Pa], `hardness` H [Pa].

    Examples
    --------
    >>> float(local_shear_stress(5e6, pressure=30e6, hardness=300e6))
    50000000.0
    """
    load, limit = positive("pressure", pressure), positive("hardness", hardness)
    if load > limit:
        raise InvalidInput(f"pressure = {load!r} Pa: must not exceed hardness = {limit!r} Pa")
    return non_negative("nominal", nominal) * (limit / load)


def slip_energy(shear_stress: ArrayLike, *, slip: float) -> Array:
    """Barrier of a local slip per area, delta epsilon / a^2 = tau_f b [J/m^2], if all of it is lost.

    Persson 2006, Sec. 10.1, footnote; `shear_stress` is tau_f [Pa], `slip` b [m], about a lattice constant.

    Examples
    --------
    >>> round(float(slip_energy(50e6, slip=3e-10)), 6)
    0.015
    """
    return non_negative("shear_stress", shear_stress) * positive("slip", slip)


def adhesional_pressure(barrier: ArrayLike, *, lift: float) -> Array:
    """Pressure p_ad = delta epsilon / (a^2 delta h) [Pa], below which pressure hardly matters to shear.

    Persson 2006, Sec. 10.1; `barrier` is delta epsilon / a^2 [J/m^2], `lift` delta h [m], by which the
    surfaces part locally when they slip.

    Examples
    --------
    >>> round(float(adhesional_pressure(0.016, lift=1e-12)) / 1e9)
    16
    """
    return non_negative("barrier", barrier) / positive("lift", lift)


@dataclass(frozen=True, kw_only=True)
class SlidingFriction:
    """What the theory says of a rigid surface that slides on a viscoelastic solid.

    Attributes
    ----------
    friction : float
        Friction coefficient mu.
    area : float
        A/A0.
    stress_variance : float
        V [Pa^2], variance of the stress at full contact and this velocity.
    """

    friction: float
    area: float
    stress_variance: float


def friction_of_waves(
    qx: ArrayLike,
    qy: ArrayLike,
    *,
    power: ArrayLike,
    pressure: float,
    velocity: float,
    modulus: Callable[[Array], Any],
    poisson: float,
    energy_ratio: float = 1.0,
) -> SlidingFriction:
    r"""Friction of a given sum of waves: `rubber_friction` told the realised surface.

    .. math:: \mu = \frac{1}{\sigma_0} \sum_{\mathbf q} |h(\mathbf q)|^2\,
              \frac{|\mathbf q|\,|q_x|}{2}\, \frac{\operatorname{Im} E(|q_x| v)}{1-\nu^2}\, S P(|\mathbf q|),
              \qquad
              V(q) = \frac14 \sum_{|\mathbf q'| < q} q'^2\, |h(\mathbf q')|^2
              \left|\frac{E(|q_x'| v)}{1-\nu^2}\right|^2

    Parameters
    ----------
    qx, qy : (n,) arrays
        Wavevectors [1/m] of both signs, none 0; the surface slides along x.
    power : (n,) array
        \|h(q)\|^2 [m^2] with h(x) = sum h(q) exp(i q x).
    pressure, velocity, modulus, poisson, energy_ratio
        As for `rubber_friction`.
    """
    x, y = np.atleast_1d(real("qx", qx)), np.atleast_1d(real("qy", qy))
    weight = np.atleast_1d(non_negative("power", power, unit="m^2", power=2, vanishing=True))
    if not x.shape == y.shape == weight.shape or x.ndim != 1:
        raise InvalidInput(
            f"qx, qy, power of shapes {x.shape}, {y.shape}, {weight.shape}: must be alike and flat"
        )
    q = np.hypot(x, y)
    if not np.all(q > 0):
        raise InvalidInput("qx, qy: no wavevector must be 0")
    load = positive("pressure", pressure)
    ratio = within("energy_ratio", energy_ratio, "(0, 1]")
    omega = np.abs(x) * abs(scalar("velocity", velocity))
    function("modulus", modulus)
    given, plane = np.asarray(modulus(omega)), 1 - poisson_ratio(poisson) ** 2
    stored, lost = (
        returned("modulus", part, omega.shape, unit="Pa") / plane for part in (given.real, given.imag)
    )
    if not (np.all(stored > 0) and np.all(lost >= 0) and np.all(np.hypot(stored, lost) <= GREATEST)):
        raise InvalidInput(
            f"modulus: must have a positive storage and no negative loss part, up to {GREATEST:g} Pa"
        )
    # In units of the pressure; |E|^2 as two squares, since the parts differ by decades.
    variance = weight * q**2 / 4 * ((stored / load) ** 2 + (lost / load) ** 2)
    heat = weight * q * np.abs(x) / 2 * lost / load
    _, ring = np.unique(np.round(q / q.min(), _DIGITS), return_inverse=True)
    added, heats = np.bincount(ring, weights=variance), np.bincount(ring, weights=heat)
    # Four Gauss points inside what each ring adds, since the contact opens while it is added.
    points, weights = gauss(4)
    before = np.append(0.0, np.cumsum(added)[:-1])
    inside = before[:, None] + added[:, None] * points
    share = contact_area(1.0, stress_variance=inside)
    retained = share * energy_factor(share, variant="yang_persson", energy_ratio=ratio)
    total = float(added.sum())
    return SlidingFriction(
        friction=float(np.sum(heats * (retained @ weights))),
        area=float(contact_area(1.0, stress_variance=total)),
        stress_variance=total * load**2,
    )


def rubber_friction(
    spectrum: Spectrum,
    *,
    pressure: float,
    velocity: float,
    modulus: Callable[[Array], Any],
    poisson: float,
    energy_ratio: float = 1.0,
) -> SlidingFriction:
    r"""Friction coefficient and contact area of a viscoelastic solid on a rough, rigid surface.

    .. math:: \mu = \frac12 \int dq\, q^3 C(q)\, S(q) P(q) \int_0^{2\pi} d\phi\, \cos\phi\,
              \operatorname{Im} \frac{E(q v \cos\phi)}{(1-\nu^2)\sigma_0},
              \qquad P = \operatorname{erf}\frac{1}{2\sqrt{G}},

    .. math:: G(q) = \frac18 \int^q dq'\, q'^3 C(q') \int_0^{2\pi} d\phi\,
              \left|\frac{E(q' v \cos\phi)}{(1-\nu^2)\sigma_0}\right|^2

    Parameters
    ----------
    spectrum : Spectrum
    pressure : float
        Nominal pressure sigma_0 [Pa].
    velocity : float
        v [m/s] along x, that of a lay; its sign does not matter.
    modulus : callable
        E(omega) [Pa], complex, for an array of frequencies omega >= 0 [1/s]; Im E >= 0 is the loss modulus.
    poisson : float
        nu.
    energy_ratio : float
        g in S(P) = g + (1 - g) P^2, the share of the full-contact energy that partial contact stores: 1 is
        the theory of 2001, 1/2 what Persson has used since.

    Returns
    -------
    SlidingFriction

    Notes
    -----
    B. N. J. Persson, J. Chem. Phys. 115, 3840 (2001); S of C. Yang and B. N. J. Persson, J. Phys.
    Condens. Matter 20, 215214 (2008), as in M. Scaraggi and B. N. J. Persson, J. Phys. Condens. Matter 27,
    105102 (2015). The solid is isothermal, strains are small, and nothing but its losses resists.

    Examples
    --------
    >>> from persson import SelfAffine, StandardSolid
    >>> road = SelfAffine.from_rms_gradient(0.5, hurst=0.8, q_long=1e3, q_short=1e6)
    >>> rubber = StandardSolid(relaxed=1e6, unrelaxed=1e9, time=1e-3)
    >>> told = {"pressure": 2e5, "modulus": rubber.modulus, "poisson": 0.5}
    >>> slow, fast = (rubber_friction(road, velocity=v, **told) for v in (1e-9, 1e-3))
    >>> bool(slow.area > fast.area), bool(slow.friction < fast.friction)
    (True, True)
    """
    check_spectrum(spectrum)
    low = max(spectrum.q_min, spectrum.q_long * 1e-3)
    count = math.ceil(_RINGS * math.log(spectrum.q_short / low)) + 1
    edges = np.geomspace(low, spectrum.q_short, count + 1)
    middle = np.sqrt(edges[1:] * edges[:-1])
    # <|grad h|^2> of each ring, exactly, over q^2, shared out over a quarter of the directions.
    ring = np.diff(spectrum.m2(edges)) / middle**2 / _DIRECTIONS
    angle = (np.arange(_DIRECTIONS) + 0.5) * (math.pi / 2 / _DIRECTIONS)
    qx, qy = np.outer(middle, np.cos(angle)), np.outer(middle, np.sin(angle))
    power = np.repeat(ring[:, None], _DIRECTIONS, axis=1)
    if (lay := getattr(spectrum, "directional", None)) is not None:
        along = np.asarray(lay(qx, qy))
        power *= along / np.maximum(along.mean(axis=1, keepdims=True), np.finfo(float).tiny)
    return friction_of_waves(
        qx.ravel(),
        qy.ravel(),
        power=power.ravel(),
        pressure=pressure,
        velocity=velocity,
        modulus=modulus,
        poisson=poisson,
        energy_ratio=energy_ratio,
    )
