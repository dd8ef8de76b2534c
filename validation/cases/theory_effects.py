"""The theory of effects: hardness, adhesion, graded moduli, corrected energies, and the mean separation."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.integrate import cumulative_trapezoid

from persson.adhesion import AdhesiveContact, Interface, solve_adhesion
from persson.diffusion import solve_diffusion
from persson.graded import ExponentialLayers, GradedModulus, SurfaceLayer
from persson.hardness import constant_hardness
from persson.limits import critical_roughness, pull_off_stress
from persson.scale import Scale
from persson.separation import mean_separation
from persson.spectrum import SelfAffine, area_factor
from persson.variants import Variant, corrected_contact_area, energy_factor, light_load_kappa
from validation.cases import Checks, below, case, near, relative, within
from validation.cases._closed_forms import integral
from validation.measurements.statistics import largest_difference


def _eigenfunctions(x: float, v: float) -> tuple[float, float]:
    """Elastic and yielded area between absorbing walls at 0 and 1, by their eigenfunctions alone."""
    n = np.arange(1, 2001)
    decay = np.sin(n * math.pi * x) * np.exp(-0.5 * (n * math.pi) ** 2 * v) * 2 / (n * math.pi)
    return float(2 * np.sum(decay[::2])), float(x + np.sum(np.where(n % 2 == 1, -decay, decay)))


@case("theory-hardness", source="Persson 2006, Eqs. 27-32")
def _hardness() -> Checks:
    """Elastic and yielded areas are those of diffusion between two absorbing walls.

    Between both walls: few eigenfunctions at large V, images at small V, and the diffusion solver.
    """
    hardness = 2.0
    for x, v in ((0.1, 0.05), (0.4, 0.3), (0.4, 0.4), (0.7, 0.8)):
        areas = constant_hardness(x * hardness, stress_variance=v * hardness**2, yield_stress=hardness)
        elastic, plastic = _eigenfunctions(x, v)
        solved = solve_diffusion(
            [v * hardness**2], pressure=x * hardness, yield_stress=hardness, tolerance=1e-7
        ).checked()
        name = f"p0/H = {x}, V/H^2 = {v}"
        yield near(f"A_el/A0, {name}", areas.elastic, elastic, 1e-10)
        yield near(f"A_pl/A0, {name}", areas.plastic, plastic, 1e-10)
        yield near(f"sum of the areas, {name}", areas.elastic + areas.plastic + areas.detached, 1.0, 1e-10)
        yield near(f"A_pl/A0 by diffusion, {name}", solved.area_plastic[0], plastic, 1e-6)


@case("theory-diffusion", source="Persson 2006, Eqs. 17 and 48")
def _diffusion() -> Checks:
    """Diffusion before one tensile wall is the source less its image.

    One wall at -sigma_a: the image of the source in it; before any wall is felt, a Gaussian.
    """
    variance, pressure, wall = 5.0, 0.4, 1.5
    solved = solve_diffusion([variance], pressure=pressure, tensile_limit=wall, tolerance=1e-8).checked()
    width = math.sqrt(2 * variance)
    sigma = np.linspace(-wall, 8.0, 12)
    exact = (
        np.exp(-(((sigma - pressure) / width) ** 2)) - np.exp(-(((sigma + pressure + 2 * wall) / width) ** 2))
    ) / (width * math.sqrt(math.pi))
    # Eq. 48: d<(sigma - sigma_0)^2>/dV = P + (sigma_a + sigma_0)^2 dP/dV.
    grown = integral(lambda v: math.erf((wall + pressure) / math.sqrt(2 * v)), 0, variance)
    area = math.erf((wall + pressure) / width)
    second = (wall + pressure) ** 2 * (area - 1) + grown
    off = largest_difference(solved.distribution(0, sigma), exact)
    peak = solve_diffusion([1e-6], pressure=1.0).distribution(0, np.array(1.0))
    yield relative("area", solved.area_elastic[0], area, 1e-7)
    yield below("largest error of P(sigma) over its largest value", off, 1e-6)
    yield relative("<(sigma - sigma_0)^2>", solved.mean_square[0], second, 1e-6)
    yield relative("load", solved.load_elastic[0], pressure + wall * (1 - area), 1e-6)
    yield relative("P(sigma_0) before a wall is felt", peak, 1 / math.sqrt(2e-6 * math.pi), 1e-6)


@case("theory-variants", source="[yang2008]; [wang2017]")
def _variants() -> Checks:
    """Corrected theories solve dV = S(P) dV_full."""
    ratio = 0.45
    factors: dict[str, Callable[[float], float]] = {
        "yang_persson": lambda p: ratio + (1 - ratio) * p**2,
        "wang_mueser": lambda p: 5 / 9 - 2 / 9 * p**2 + 6 / 9 * p**4,
    }
    for variant, factor in factors.items():
        name: Variant = variant  # type: ignore[assignment]
        for p in (0.0, 0.6, 1.0):
            yield relative(f"S({p}) of {variant}", energy_factor(p, variant=name), factor(p), 1e-12)
        kappa = math.sqrt(8 / math.pi / factor(0.0))
        yield relative(f"kappa without load of {variant}", light_load_kappa(name), kappa, 1e-12)
        for variance in (0.5, 40.0):

            def slowed(v: float, factor: Callable[[float], float] = factor) -> float:
                return 1 / factor(math.erf(1 / math.sqrt(2 * v))) if v > 0 else 1.0

            full = integral(slowed, 0, variance)
            area = corrected_contact_area(1.0, stress_variance=full, variant=name)
            exact = math.erf(1 / math.sqrt(2 * variance))
            yield relative(f"A/A0 of {variant} at V = {variance}", area, exact, 1e-7)


_ROUGH = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=1e5, q_short=1e8)


@case("theory-graded", source="Persson 2006, Sec. 5")
def _profile() -> Checks:
    """A wave feels the modulus of a graded solid weighted by q exp(-q z).

    Weigh E(z) with q exp(-q z): both ends, closed forms, and what a quadrature makes of them.
    """
    poisson, thickness = 0.4, 2e-6
    strain = 1 - poisson**2
    exponential = ExponentialLayers(bulk=1e6, excess=[5e6], depths=[thickness], poisson=poisson)
    layer = SurfaceLayer(layer=6e6, bulk=1e6, thickness=thickness, poisson=poisson)
    general = GradedModulus(young=lambda z: 1e6 + 5e6 * np.exp(-z / thickness), poisson=poisson)
    for scaled in (1e-6, 0.3, 2.0, 1e6):
        q = scaled / thickness
        share = scaled / (1 + scaled)
        name = f"E~*(q) at q d = {scaled:g}"
        yield relative(f"{name}, exponential", exponential(q), (1e6 + 5e6 * share) / strain, 1e-12)
        yield relative(f"{name}, coating", layer(q), (1e6 - 5e6 * math.expm1(-scaled)) / strain, 1e-12)
        if 1e-3 < scaled < 1e3:
            yield relative(f"{name}, by quadrature", general(q), exponential(q), 1e-8)
    scale = Scale(_ROUGH, contact_modulus=exponential)

    def grown(x: float) -> float:
        q = math.exp(x)
        felt = (1e6 + 5e6 * q * thickness / (1 + q * thickness)) / strain
        return felt**2 / 4 * 2 * math.pi * q**4 * float(_ROUGH(q))

    exact = integral(grown, math.log(1e5), math.log(1e8))
    # Simpson's rule on 24 points per e-fold: h^4 / 2880, times a few powers of q.
    yield relative("V of a graded solid [Pa^2]", scale.variance(1e8), exact, 1e-7)


@case("theory-separation", source="[persson2007]")
def _separation() -> Checks:
    """The work of the load is the elastic energy, and at light load the separation is logarithmic.

    Sum what the load stores: u(p1) - u(p2) = int dU/dp dp / p, summed over waves and loads.
    """
    modulus = 4e6
    scale = Scale(_ROUGH, contact_modulus=modulus)
    low, high = 2e3, 4e4
    q_nodes, q_weights = np.polynomial.legendre.leggauss(200)
    span = math.log(1e8 / 1e5)
    # ln q = ln q_long + span t^2 takes out the root with which V begins.
    t = (1 + q_nodes) / 2
    q = 1e5 * np.exp(span * t**2)
    variance = np.asarray(scale.variance(q))
    growth = modulus**2 / 4 * 2 * math.pi * q**4 * _ROUGH(q) / (modulus * q) * q_weights * span * t
    p_nodes, p_weights = np.polynomial.legendre.leggauss(60)
    p = np.exp(math.log(low) + math.log(high / low) * (1 + p_nodes) / 2)[:, None]
    # dU/dp = int dV / (E* q) dA/dp, with A = erf(p / sqrt(2 V)).
    rate = np.sqrt(2 / (math.pi * variance)) * np.exp(-(p**2) / (2 * variance)) @ growth
    exact = np.sum(rate * p_weights) * math.log(high / low) / 2
    separation = mean_separation(np.array([low, high]), scale=scale)
    far = mean_separation(np.array([1e-2, 1e-3]), scale=scale)
    # At vanishing load A = p (2 / (pi V))^(1/2), so that the separation grows by this per e-fold.
    growth_per_efold = np.sqrt(2 / (math.pi * variance)) @ growth
    # Gauss's rule on both sides: panels of 1/8 in ln V there, 200 points in the root of ln q here.
    yield relative("u(p1) - u(p2) [m]", separation[0] - separation[1], exact, 1e-9)
    grown = (far[1] - far[0]) / math.log(10)
    yield relative("growth per e-fold at light load [m]", grown, growth_per_efold, 1e-4)


#: The rim of a tire on steel in Persson 2006, Sec. 8.3.
_RIM = SelfAffine.from_rms_height(0.5e-6, hurst=0.8, q_long=1e5, q_short=1e10)
_RIM_MODULUS, _RIM_PRESSURE = 10e6 / (1 - 0.5**2), 0.5e6
_RIM_INTERFACE = Interface(work_of_adhesion=0.05)


def _rim(interface: Interface, pressure: float = _RIM_PRESSURE) -> AdhesiveContact:
    scale = Scale(_RIM, contact_modulus=_RIM_MODULUS)
    return solve_adhesion(scale, pressure=pressure, interface=interface).checked()


@case("theory-adhesion", source="Persson 2006, Secs. 8.2-8.4")
def _adhesion() -> Checks:
    """Adhesion brings the area of a tire rim to .44, and its limits are exact."""
    variance = _RIM_MODULUS**2 / 4 * float(_RIM.m2())
    plain = math.erf(_RIM_PRESSURE / math.sqrt(2 * variance))
    printed = _rim(replace(_RIM_INTERFACE, energy="as_printed"))
    vanishing = _rim(replace(_RIM_INTERFACE, work_of_adhesion=1e-9))
    strong = _rim(replace(_RIM_INTERFACE, work_of_adhesion=50.0), pressure=0.0)
    # All energy is paid: U_el = (E*/4) 2 pi int q^2 C dq.
    strength = 1.6 * 0.5e-6**2 / (1 - 1e5**-1.6)
    energy = _RIM_MODULUS / 4 * strength * 1e5 * (1 - 1e5**-0.6) / 0.6
    weak = 0.02 * _RIM_PRESSURE
    bounded = _rim(replace(_RIM_INTERFACE, ideal_strength=weak))
    most = math.erf((_RIM_PRESSURE + weak) / math.sqrt(2 * variance))
    yield near("A/A0 of the rim with adhesion", printed.real_area, 0.44, 0.005)
    yield relative("A/A0 with vanishing adhesion", vanishing.real_area, plain, 1e-4)
    yield relative("A/A0 with great adhesion", strong.real_area, 1.0, 1e-6)
    left = area_factor(_RIM.m2()) * 50 - energy
    yield relative("energy left by great adhesion [J/m^2]", strong.macroscopic_work, left, 1e-5)
    # A wall at -sigma* at most: no more area than the load and that strength together press into contact.
    yield within("A/A0 of weak bonds", bounded.real_area, plain, most * (1 + 1e-4))


@case("theory-adhesion-energy", source="Persson 2006, Eqs. 37, 43, 48 and 50")
def _energies() -> Checks:
    """The adhesive energy left at each scale is what the waves beyond it have not cost.

    Write Eq. 37 in wavevectors, with each elastic energy, and sum it from the solution's own areas.
    """
    q = np.geomspace(1e5, 1e10, 20001)
    spectrum = 2 * math.pi * q**3 * _RIM(q)
    for energy, load in (("old", 0.0), ("improved", _RIM_PRESSURE), ("as_printed", 0.0)):
        contact = _rim(replace(_RIM_INTERFACE, energy=energy))  # type: ignore[arg-type]
        area = contact.area_at(q)
        if energy == "old":
            share = area
        else:
            # Eq. 48 over V, from d<(sigma - s)^2> = P dV + (sigma_a + s)^2 dP about s = sigma_0. Eq. 50
            # as it is printed is <sigma^2> - sigma_0^2, which is that about s = 0.
            limit = np.interp(np.log(q), np.log(contact.wavevectors), contact.tensile_limit)
            variance = np.interp(np.log(q), np.log(contact.wavevectors), contact.variance)
            grown = variance[0] * area[0] + cumulative_trapezoid(area, variance, initial=0)
            share = (grown + cumulative_trapezoid((limit + load) ** 2, area, initial=0)) / variance
        density = _RIM_MODULUS / 4 * spectrum / q * share
        paid = cumulative_trapezoid(density, q, initial=0)
        gained = contact.real_area * float(area_factor(_RIM.m2())) * _RIM_INTERFACE.work_of_adhesion
        exact = gained - (paid[-1] - paid)
        factor = area_factor(_RIM.m2(q))
        some = np.searchsorted(q, [1e7, 1e8, 1e9])
        left = (exact / (area * factor))[some] / _RIM_INTERFACE.work_of_adhesion
        work = contact.work_at(q[some]) / _RIM_INTERFACE.work_of_adhesion
        for place, computed, expected in zip(q[some], work, left, strict=True):
            name = f"gamma_eff / gamma at {place:g} 1/m, {energy} energy"
            # Interpolation between nodes .12 apart in ln V, and the trapezoidal rule.
            yield near(name, computed, expected, 2e-4)


#: As rough as `_ROUGH`, by two decades of waves.
_SHORT = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=1e5, q_short=1e7)


@case("theory-pull-off", source="Persson 2006, Secs. 8.3 and 10.2", tolerance="estimate")
def _ends() -> Checks:
    """Nearly flat surfaces come off at the detachment stress; rougher than critical none sticks."""
    interface = Interface(work_of_adhesion=0.05)
    smooth = Scale(_SHORT.scaled(1e-8), contact_modulus=4e6)
    strongest = math.sqrt(1.125 * 0.05 * 4e6 * 1e5)
    pull = pull_off_stress(smooth, interface=interface, tolerance=0.01)
    factor = critical_roughness(_SHORT, contact_modulus=4e6, interface=interface, tolerance=0.05)
    scales = [Scale(_SHORT.scaled((part * factor) ** 2), contact_modulus=4e6) for part in (0.93, 1.07)]
    smoother, rougher = (solve_adhesion(one, pressure=0.0, interface=interface).real_area for one in scales)
    # Bisection to a hundredth.
    yield relative("pull-off of a nearly flat surface [Pa]", pull, strongest, 0.015)
    yield within("A/A0 without load just below it", smoother, 1e-3, 1.0)
    yield below("A/A0 without load just above it", rougher, 0.0)
