"""Claims of Persson (2006) about theories, spheres and grids, which belong to no application."""

from __future__ import annotations

import math

import numpy as np

from persson import elastic
from persson.adhesion import Interface, crossover_length
from persson.archard import archard_hierarchy
from persson.asperities import ring_asperities
from persson.capillary import maximum_height
from persson.diffusion import solve_diffusion
from persson.flaw_tolerance import FlawTolerance, optimal_modulus
from persson.limits import critical_roughness
from persson.soft_structures import fibre_modulus
from persson.spectrum import SelfAffine
from persson.spheres import DoubleHertz, derjaguin_pull_off, jkr_pull_off
from persson.tensile import adhesion_load
from persson.viscoelastic import StandardSolid, crack_dissipation
from validation.paper.claims import Application, Stated, claim, digit, factor, percent


def _kappa(asymptote: float, reduced: float = 1e-6) -> float:
    variance = elastic.stress_variance(0.01, contact_modulus=1e9)
    area = elastic.contact_area(reduced * 1e9 * 0.1, stress_variance=variance)
    return float(elastic.kappa(area, reduced_pressure=reduced)) / asymptote


def _linear() -> float:
    """Slope of A(sigma_0) at A/A0 = .1 below that at light load [%]."""
    load = float(elastic.pressure_for_area(0.1, stress_variance=0.25))
    return 100 * (1 - 0.1 / load / elastic.KAPPA_PERSSON)


def _patches(quantity: str, load: float = 3.4e-4) -> float:
    """D ln A / d ln sigma_0, or of the patch, for Greenwood and Williamson; A/A0 = .001 at that load."""
    bumps = ring_asperities(600.0, rms_height=1 / 600.0)
    loads = np.array([0.99, 1.01]) * load
    found = [bumps.contact_at(p, contact_modulus=1.0) for p in loads]
    values = [math.log(float(getattr(f, quantity))) for f in found]
    return (values[1] - values[0]) / math.log(loads[1] / loads[0])


def _archard() -> float:
    return archard_hierarchy(
        1.0, radii=[1e-2, 1e-4, 1e-6, 1e-8], densities=[1e9, 1e13, 1e17], contact_modulus=1e9
    ).exponent


def _books() -> float:
    """(F + sigma_a A) / ((sigma_0 + sigma_a) A0) by diffusion, Eq. 41."""
    solved = solve_diffusion([4.0], pressure=0.3, tensile_limit=0.7, tolerance=1e-8).checked()
    return float(solved.load_elastic[0] + 0.7 * solved.area[0])


def _light_books() -> float:
    """F / ((sigma_0 + sigma_a) A0) where A/A0 = .01, Eq. 42."""
    held = adhesion_load(0.3, stress_variance=6366.0, tensile_limit=0.7)
    return float(held.contact_force)


def _tolerant(rms_height: float) -> FlawTolerance:
    rough = SelfAffine.from_rms_height(rms_height, hurst=0.8, q_long=1e6, q_short=1e10)
    interface = Interface(work_of_adhesion=0.05)
    return optimal_modulus(rough, pressure=0.0, tensile_limit=5e7, interface=interface)


def _rubber_factor() -> float:
    rubber = StandardSolid(relaxed=1e6, unrelaxed=1e9, time=1e-3)
    return crack_dissipation(1e4, loss_compliance=rubber.loss_compliance, relaxed=1e6, tip_radius=1e-9)


def _killing(q_long: float) -> float:
    """h_rms [um] at which rubber of 1 MPa no longer sticks."""
    rough = SelfAffine.from_rms_height(1e-6, hurst=0.8, q_long=q_long, q_short=1e10)
    interface = Interface(work_of_adhesion=0.05)
    return critical_roughness(rough, contact_modulus=1e6 / 0.75, interface=interface, tolerance=0.02)


def cut_gaussian_ratio(diffusion: float = 1.0) -> float:
    """Area of a Gaussian cut at zero stress and rescaled to the same load, over the exact area."""
    variance = 2 * diffusion
    exact = float(elastic.contact_area(1.0, stress_variance=variance))
    t = 1 / math.sqrt(2 * variance)
    share = 0.5 * math.erfc(-t)
    load = share + math.sqrt(variance / (2 * math.pi)) * math.exp(-t * t)
    return share / load / exact


def _edge_slope() -> float:
    contact = DoubleHertz(peak_pressure=1e9, tensile_limit=0.3e9, eta=1.1)
    inner = 1e9 + 0.3e9 * 1.1 / math.sqrt(1.1**2 - 1)
    return float(contact.distribution(-0.3e9 + 10.0) * inner**2 / 10.0)


GENERAL = Application(
    name="theories, spheres, grids",
    claims=(
        claim(
            "Archard's hierarchy: d ln A / d ln F with four levels, 'proportional'",
            "1",
            percent(1.0, 2.0),
            fixed=_archard,
            choice="four levels: 1 - 3^-4",
        ),
        claim(
            "asperities per area over q_m^2, one wavelength",
            "3.2",
            digit(0.029, 0.001),
            fixed=lambda: ring_asperities(1.0, rms_height=1.0).density,
        ),
        claim(
            "Greenwood and Williamson: d ln A / d ln sigma_0, '(weakly) non-linear'",
            "3.2",
            Stated(1.0, 0.9, 1.0, "below 1 by at most a tenth"),
            fixed=lambda: _patches("area"),
            choice="at A/A0 of 0.1 %",
            note=lambda: f"{_patches('area', 4.1e-3):.2f} at A/A0 of 1 %",
        ),
        claim(
            "Greenwood and Williamson: d ln a / d ln sigma_0 of the patches, which grow",
            "3.2",
            Stated(0.0, 0.0, math.inf, "above 0"),
            fixed=lambda: _patches("patch_area"),
            choice="at A/A0 of 0.1 %",
        ),
        claim(
            "kappa of the theory over sqrt(8/pi), at light load",
            "3.4",
            Stated(1.0, 1 - 1e-6, 1 + 1e-6, "1e-6, an identity"),
            fixed=lambda: _kappa(elastic.KAPPA_PERSSON),
        ),
        claim(
            "area of the theory over that of Bush, Gibson and Thomas (2/pi)",
            "3.5",
            percent(2 / math.pi, 1e-4),
            fixed=lambda: _kappa(elastic.KAPPA_BGT),
        ),
        claim(
            "A proportional to the load up to A/A0 = 0.1: departure [%]",
            "3.5",
            Stated(0.0, -1.0, 1.0, "1 %"),
            fixed=_linear,
        ),
        claim(
            "(F + sigma_a A) / ((sigma_0 + sigma_a) A_0), Eq. 41",
            "8.1",
            percent(1.0, 1e-4),
            fixed=_books,
        ),
        claim(
            "F / ((sigma_0 + sigma_a) A_0) at A/A0 = 0.01, Eq. 42",
            "8.1",
            percent(1.0, 1.0),
            fixed=_light_books,
        ),
        claim(
            "passivated silicon: crossover length l_c [um], 'of order'",
            "8.4",
            factor(1.0, 3.0, words="of order"),
            fixed=lambda: 1e6 * crossover_length(0.03, contact_modulus=1.1e11, atomic_distance=5e-10),
            choice="E* = 110 GPa, Delta gamma = 0.03 J/m^2, a = 0.5 nm; a = 0.25 nm gives 0.23 um",
        ),
        claim(
            "flaw tolerance: d ln E / d ln z where gamma_eff does not depend on magnification",
            "8.5",
            percent(1.0, 1.0),
            fixed=lambda: float(_tolerant(1e-11).growth.max()),
            choice="Delta gamma = 0.05 J/m^2, sigma_a = 50 MPa, h_rms = 0.01 nm",
        ),
        claim(
            "the same on a rough surface, where E 'must increase faster than z': at the longest wave",
            "8.5",
            Stated(1.0, 1.0, math.inf, "above 1"),
            fixed=lambda: float(_tolerant(1e-9).growth[0]),
            choice="Delta gamma = 0.05 J/m^2, sigma_a = 50 MPa, h_rms = 1 nm",
        ),
        claim(
            "rubber: f(v) at high velocity, '10^3'",
            "8.6",
            factor(1e3, 3.0, words="~"),
            fixed=_rubber_factor,
            choice="E from 1 MPa to 1 GPa, one retardation time",
        ),
        claim(
            "rms roughness that kills adhesion at E = 1 MPa [um], 'a few'",
            "8.7",
            Stated(3.0, 2.0, 8.0, "2 to 8, for 'a few'"),
            fixed=lambda: _killing(1e4),
            choice="Delta gamma = 0.05 J/m^2, D_f = 2.2, nu = 0.5, q_0 = 1e4 1/m",
            note=lambda: f"{_killing(1e5):.2f} um for q_0 = 1e5 1/m, {_killing(1e3):.1f} um for 1e3",
        ),
        claim(
            "setae of keratin: effective modulus over that of rubber, 1 MPa, 'very low'",
            "8.7",
            Stated(1.0, 0.0, 1.0, "below 1"),
            fixed=lambda: (
                fibre_modulus(1.5e9, radius=2.1e-6, length=106e-6, density=1.44e10, angle=0.75) / 1e6
            ),
            choice="E = 1.5 GPa and the dimensions of a gecko's setae",
        ),
        claim(
            "coarse grid: excess of contact area [%]",
            "12",
            digit(22.0, 1.0),
            fixed=lambda: 100 * (cut_gaussian_ratio() - 1),
            choice="G = 1, and a Gaussian cut at 0 and rescaled to the load",
        ),
        claim(
            "highest to lowest point over h_rms for N = 1e8",
            "App. A",
            percent(12.0, 10.0),
            fixed=lambda: 2 * maximum_height(1e8),
        ),
        claim(
            "highest to lowest point over h_rms for N = 1e4",
            "App. A",
            percent(8.0, 10.0),
            fixed=lambda: 2 * maximum_height(1e4),
        ),
        claim(
            "highest point over h_rms for N = 1e8",
            "App. A",
            digit(6.0, 1.0),
            fixed=lambda: maximum_height(1e8),
        ),
        claim(
            "Derjaguin's pull-off force over that of JKR",
            "3.1",
            percent(4 / 3, 1e-4),
            fixed=lambda: (
                derjaguin_pull_off(1.0, work_of_adhesion=1.0) / jkr_pull_off(1.0, work_of_adhesion=1.0)
            ),
        ),
        claim(
            "adhesive spheres: P(sigma) sigma_1^2 / (sigma + sigma_a) at the detachment stress",
            "App. B",
            percent(2.0, 0.1),
            fixed=_edge_slope,
        ),
    ),
)
