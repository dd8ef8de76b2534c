"""The theory's further closed forms: second methods, size effects, double Hertz, smoothing, pull-off."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy.integrate import quad
from scipy.special import erfinv

from persson import elastic, spheres
from persson.adhesion import Interface, solve_adhesion
from persson.diffusion import solve_diffusion
from persson.hardness import constant_hardness, nix_gao_hardness, size_dependent_hardness
from persson.interface import closing_work, crossover_length, detachment_stress, opening_work
from persson.limits import critical_roughness, pull_off_stress
from persson.scale import Scale
from persson.separation import mean_separation
from persson.sine import sine_expansion
from persson.spectrum import SelfAffine
from persson.tabulated import smoothed
from persson.variants import corrected_contact_area, energy_share
from validation.cases import Check, below, case, relative, within

_ROUGH = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=1e5, q_short=1e7)
_MODULUS = 4e6


@case(
    "theory-magnification",
    "At each magnification the area is the error function of the load over the waves seen.",
    source="Persson 2006, Eqs. 15 and 20",
)
def _magnification() -> Iterator[Check]:
    pressure, zeta = 5e4, np.array([2.0, 10.0, 100.0])
    found = elastic.area_against_magnification(
        _ROUGH, pressure=pressure, contact_modulus=_MODULUS, magnification=zeta, q_reference=1e5
    )
    # m2 of q^-3.6 up to zeta grows like (zeta^.4 - 1).
    share = (zeta**0.4 - 1) / (100.0**0.4 - 1)
    argument = pressure / (_MODULUS * 0.1 * np.sqrt(share)) * math.sqrt(2)
    exact = np.array([math.erf(value) for value in argument])
    reduced = float(elastic.reduced_pressure(pressure, contact_modulus=_MODULUS, rms_gradient=0.1))
    apart = float(elastic.non_contact_area(4.0, stress_variance=0.5))
    yield below("largest relative error of A(zeta)", found / exact - 1, 1e-9)
    yield relative("p*", reduced, pressure / _MODULUS / 0.1, 1e-12)
    yield relative("kappa", elastic.kappa(0.3, reduced_pressure=reduced), 0.3 / reduced, 1e-12)
    yield relative("1 - A/A0 near full contact", apart, math.erfc(4.0), 1e-9)


@case(
    "theory-second-methods",
    "Sines and diffusion agree between walls, and variants and energies by their own equations.",
    source="Persson 2006, Sec. 9; Y. Xu, L. Zhu, F. Xiao, Y. Zhou (2024); C. Yang, B. N. J. Persson (2008)",
)
def _second_methods() -> Iterator[Check]:
    """Expand in sines what diffusion solves, and invert the variant that needs no integration."""
    sine = sine_expansion(0.8, pressure=0.6, tensile_limit=0.5, yield_stress=2.0, modes=60)
    solved = solve_diffusion(
        [0.8], pressure=0.6, tensile_limit=0.5, yield_stress=2.0, tolerance=1e-9
    ).checked()
    sigma = np.linspace(-0.5, 2.0, 30)
    apart = float(np.max(np.abs(solved.distribution(0, sigma) - sine.distribution(sigma))))
    yield relative("area between two walls, by sines", sine.area_elastic, solved.area_elastic[0], 1e-7)
    yield below("largest difference of P(sigma)", apart, 1e-7)
    for area in (0.05, 0.7):
        variance = 1 / (2 * float(erfinv(area)) ** 2)
        # g = .42 as in the code that they published.
        full = variance / (0.42 + 0.58 * area)
        found = float(corrected_contact_area(1.0, stress_variance=full, variant="xu"))
        yield relative(f"A/A0 of Xu et al. where it is {area}", found, area, 1e-9)
    yield from _energy_of_separation()


def _energy_of_separation() -> Iterator[Check]:
    """Give the separation the energy of Yang and Persson: dU/dp = int dV/(E* q) (g + 3 (1 - g) P^2) dP/dp."""
    ratio, low, high = 0.45, 2e3, 4e4
    scale = Scale(_ROUGH, contact_modulus=_MODULUS)
    nodes, weights = np.polynomial.legendre.leggauss(120)
    t, span = (1 + nodes) / 2, math.log(100.0)
    q = 1e5 * np.exp(span * t**2)
    variance = np.asarray(scale.variance(q))
    growth = _MODULUS / 4 * 2 * math.pi * q**3 * _ROUGH(q) * weights * span * t

    def rate(x: float) -> float:
        p = math.exp(x)
        area = np.asarray(elastic.contact_area(p, stress_variance=variance))
        rise = np.sqrt(2 / (math.pi * variance)) * np.exp(-(p**2) / (2 * variance))
        return float(np.sum(growth * rise * (ratio + 3 * (1 - ratio) * area**2)))

    exact = quad(rate, math.log(low), math.log(high), epsabs=0, epsrel=1e-8)[0]
    found = mean_separation(np.array([low, high]), scale=scale, energy_ratio=ratio)
    yield relative("u(p1) - u(p2) with corrected energy [m]", found[0] - found[1], exact, 1e-4)
    yield from _energy_shares()


def _energy_shares() -> Iterator[Check]:
    """Sum Eqs. 48 and 50 without adhesion over V, and differentiate the variance of Xu et al."""
    load, variance = 0.2, 0.7
    area = math.erf(load / math.sqrt(2 * variance))
    mean = (
        quad(lambda v: math.erf(load / math.sqrt(2 * v)), 0, variance, epsabs=0, epsrel=1e-10)[0] / variance
    )
    lost = load**2 * (1 - area) / variance
    for energy, exact in (("old", area), ("as_printed", mean), ("improved", mean - lost)):
        found = energy_share(load, stress_variance=variance, energy=energy)  # type: ignore[arg-type]
        yield relative(f"P~ at p0^2/V = {load**2 / variance:.2g}, {energy}", found, exact, 1e-8)
    around = variance * np.array([1 - 1e-4, 1.0, 1 + 1e-4])
    areas = corrected_contact_area(load, stress_variance=around, variant="xu")
    own = (load / erfinv(areas)) ** 2 / 2
    found = energy_share(load, stress_variance=variance, energy="xu")
    exact = float(areas[1] * (own[2] - own[0]) / (around[2] - around[0]))
    yield relative("P~ of Xu et al.", found, exact, 1e-6)


@case(
    "theory-sizes",
    "A hardness without size effect is the constant one, and interfaces hold what they should.",
    source="Persson 2006, Secs. 7 and 8; W. D. Nix, H. Gao, J. Mech. Phys. Solids 46, 411 (1998)",
)
def _sizes() -> Iterator[Check]:
    """Take effects of size to their limits, and interfaces to theirs."""
    pressure, hardness = 5e4, 3e5
    scale = Scale(_ROUGH, contact_modulus=_MODULUS)
    q = np.array([3e5, 2e6, 1e7])
    same = size_dependent_hardness(
        scale, pressure=pressure, yield_stress=lambda wave: np.full(wave.shape, hardness), wavevectors=q
    ).checked()
    plain = constant_hardness(pressure, stress_variance=scale.variance(q), yield_stress=hardness)
    stress = detachment_stress(
        0.05,
        contact_modulus=_MODULUS,
        wavevector=2e6,
        interface=Interface(work_of_adhesion=0.05, ideal_strength=4e5),
    )
    bare = math.sqrt(1.125 * 0.05 * _MODULUS * 2e6)
    crossed = crossover_length(0.05, contact_modulus=_MODULUS, atomic_distance=1e-9)
    worst = float(np.max(np.abs(same.area_plastic - plain.plastic)))
    nix = float(nix_gao_hardness(5e-7, bulk=6e8, length=1.5e-6))
    yield below("A_pl/A0 of a hardness that does not change with size, off by", worst, 2e-6)
    yield relative("hardness where h* is three times the depth [Pa]", nix, 1.2e9, 1e-12)
    yield relative("bounded tensile limit [Pa]", stress, bare / (1 + bare / 4e5), 1e-12)
    yield relative("length below which bonds are the bound [m]", crossed, 1e-18 * _MODULUS / 0.05, 1e-12)
    yield relative("work of an opening crack [J/m^2]", opening_work(0.05, dissipation=3.0), 0.2, 1e-12)
    yield relative("work of a closing crack [J/m^2]", closing_work(0.05, dissipation=3.0), 0.0125, 1e-12)


@case(
    "theory-pull-off",
    "Nearly flat surfaces come off at the detachment stress; rougher than critical none sticks.",
    source="Persson 2006, Secs. 8.3 and 10.2",
    tolerance="estimate",
)
def _ends() -> Iterator[Check]:
    """Pull off a nearly flat surface, and roughen one until it does not stick."""
    interface = Interface(work_of_adhesion=0.05)
    smooth = Scale(_ROUGH.scaled(1e-8), contact_modulus=_MODULUS)
    strongest = math.sqrt(1.125 * 0.05 * _MODULUS * 1e5)
    pull = pull_off_stress(smooth, interface=interface, tolerance=0.01)
    factor = critical_roughness(_ROUGH, contact_modulus=_MODULUS, interface=interface, tolerance=0.05)
    smoother, rougher = (
        solve_adhesion(
            Scale(_ROUGH.scaled((part * factor) ** 2), contact_modulus=_MODULUS),
            pressure=0.0,
            interface=interface,
        ).real_area
        for part in (0.93, 1.07)
    )
    # Bisection to a hundredth.
    yield relative("pull-off of a nearly flat surface [Pa]", pull, strongest, 0.015)
    yield within("A/A0 without load just below it", smoother, 1e-3, 1.0)
    yield below("A/A0 without load just above it", rougher, 0.0)


@case(
    "theory-double-hertz",
    "A double Hertz contact carries the integral of its pressures.",
    source="J. A. Greenwood, K. L. Johnson, J. Phys. D 31, 3279 (1998)",
)
def _double_hertz() -> Iterator[Check]:
    contact = spheres.DoubleHertz(peak_pressure=1.0, tensile_limit=0.3, eta=1.2)

    def force(low: float, high: float) -> float:
        return quad(lambda r: 2 * math.pi * r * float(contact.pressure(r)), low, high, epsabs=0, epsrel=1e-9)[
            0
        ]

    inside, outside = force(0, 1), force(1, 1.2)
    # P per contact area: its integral is 1, and its mean the force inside over the area.
    whole = quad(lambda s: float(contact.distribution(s)), -0.3, 1.0, points=[-0.29, 0.99], limit=200)[0]
    mean = quad(lambda s: s * float(contact.distribution(s)), -0.3, 1.0, points=[-0.29, 0.99], limit=200)[0]
    yield relative("pressure at the centre", contact.pressure(0.0), 1.0, 1e-12)
    yield relative("pressure at the edge of contact", contact.pressure(1.0), -0.3, 1e-12)
    yield relative("load at a = 2", contact.load(2.0), 4 * (inside + outside), 1e-6)
    yield relative("force in contact at a = 2", contact.contact_force(2.0), 4 * inside, 1e-6)
    yield relative("integral of P(sigma)", whole, 1.0, 1e-4)
    yield relative("mean of P(sigma)", mean, inside / math.pi, 1e-4)
    yield relative("radius of two spheres", spheres.effective_radius(2.0, 3.0), 1.2, 1e-12)


@case(
    "theory-smoothing",
    "Plastic flow takes from each wave the share that has yielded at it.",
    source="Persson 2006, Sec. 10.2",
)
def _smoothing() -> Iterator[Check]:
    """Flatten short waves, gradually or at once."""
    q = np.geomspace(1e5, 1e7, 200)
    share = np.linspace(0, 0.8, 200)
    gradual = smoothed(_ROUGH, wavevectors=q, yielded=share)
    sharp = smoothed(_ROUGH, wavevectors=q, yielded=share, form="sharp")
    left = float(np.max(np.abs(gradual(q) / _ROUGH(q) / (1 - share) - 1)))
    cut = float(q[share <= 0.5][-1])
    yield below("error of C(q) (1 - A_pl(q)/A_pl)", left, 1e-9)
    yield relative("last wave where half has yielded [1/m]", sharp.q_short, cut, 1e-12)
    yield relative("roughness cut there", sharp.m2(), _ROUGH.truncated(cut).m2(), 1e-3)
