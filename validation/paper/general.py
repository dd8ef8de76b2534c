"""Claims of Persson (2006) about theories, spheres, grids, polished steel and roads."""

from __future__ import annotations

import math

import numpy as np

from persson import elastic
from persson.adhesion import Interface, crossover_length
from persson.archard import archard_hierarchy
from persson.asperities import nayak_asperities, ring_asperities
from persson.capillary import maximum_height
from persson.diffusion import solve_diffusion
from persson.flaw_tolerance import FlawTolerance, optimal_modulus
from persson.limits import critical_roughness
from persson.percolation import SITE_THRESHOLD
from persson.separation import macroasperity_magnification, macroasperity_pressure
from persson.soft_structures import fibre_modulus
from persson.spectrum import Moments, SelfAffine
from persson.spheres import DoubleHertz, derjaguin_pull_off, jkr_pull_off
from persson.tensile import adhesion_load
from persson.viscoelastic import StandardSolid, crack_dissipation
from validation.paper import systems as s
from validation.paper.claims import Stated, application, percent


def _kappa(asymptote: float) -> float:
    variance = elastic.stress_variance(0.01, contact_modulus=1e9)
    area = elastic.contact_area(1e-6 * 1e9 * 0.1, stress_variance=variance)
    return float(elastic.kappa(area, reduced_pressure=1e-6)) / asymptote


#: For Greenwood and Williamson.
_BUMPS = ring_asperities(600.0, rms_height=1 / 600.0)


def _patches(quantity: str, load: float = 3.4e-4) -> float:
    """D ln A / d ln sigma_0, or of the patch, for Greenwood and Williamson; A/A0 = .001 at that load."""
    loads = np.array([0.99, 1.01]) * load
    contacts = [_BUMPS.contact_at(p, contact_modulus=1.0) for p in loads]
    values = [math.log(float(getattr(f, quantity))) for f in contacts]
    return (values[1] - values[0]) / math.log(loads[1] / loads[0])


#: At A/A0 = .001.
_LIGHT = _BUMPS.contact_at(3.4e-4, contact_modulus=1.0)
#: The exact summits of one wavelength, in units of it and of h_rms.
_SUMMITS = nayak_asperities(Moments(m0=1.0, m2=1.0, m4=1.0))


def _books() -> float:
    """(F + sigma_a A) / ((sigma_0 + sigma_a) A0) by diffusion, Eq. 41."""
    solved = solve_diffusion([4.0], pressure=0.3, tensile_limit=0.7, tolerance=1e-8).checked()
    return float(solved.load_elastic[0] + 0.7 * solved.area[0])


_RUBBER = StandardSolid(relaxed=1e6, unrelaxed=1e9, time=1e-3)


def _tolerant(rms_height: float) -> FlawTolerance:
    rough = SelfAffine.from_rms_height(rms_height, hurst=0.8, q_long=1e6, q_short=1e10)
    return optimal_modulus(rough, pressure=0.0, tensile_limit=5e7, interface=Interface(work_of_adhesion=0.05))


def _killing(q_long: float) -> float:
    """h_rms [um] at which rubber of 1 MPa no longer sticks."""
    rough = SelfAffine.from_rms_height(1e-6, hurst=0.8, q_long=q_long, q_short=1e10)
    interface = Interface(work_of_adhesion=0.05)
    return critical_roughness(rough, contact_modulus=1e6 / 0.75, interface=interface, tolerance=0.02)


def _cut_gaussian() -> float:
    """Area of a Gaussian cut at zero stress and rescaled to the same load, over the exact area."""
    share = 0.5 * math.erfc(-0.5)
    load = share + math.sqrt(1 / math.pi) * math.exp(-0.25)
    return share / load / float(elastic.contact_area(1.0, stress_variance=2.0))


def _edge_slope() -> float:
    contact = DoubleHertz(peak_pressure=1e9, tensile_limit=0.3e9, eta=1.1)
    inner = 1e9 + 0.3e9 * 1.1 / math.sqrt(1.1**2 - 1)
    return float(contact.distribution(-0.3e9 + 10.0) * inner**2 / 10.0)


GENERAL = application(
    "theories, spheres, grids",
    values={
        "archard": lambda: (
            archard_hierarchy(
                1.0, radii=[1e-2, 1e-4, 1e-6, 1e-8], densities=[1e9, 1e13, 1e17], contact_modulus=1e9
            ).exponent
        ),
        "ring_density": lambda: ring_asperities(1.0, rms_height=1.0).density,
        "gw_area": lambda: _patches("area"),
        "gw_patch": lambda: _patches("patch_area"),
        "gw_patches": lambda: _LIGHT.area / _LIGHT.density / _LIGHT.patch_area,
        "summit_height": lambda: _SUMMITS.rms_height,
        "summit_curvature": lambda: math.sqrt(2) * _SUMMITS.radius,
        "kappa": lambda: _kappa(elastic.KAPPA_PERSSON),
        "bgt": lambda: _kappa(elastic.KAPPA_BGT),
        # The slope of A(sigma_0) at A/A0 = .1 below that at light load [%].
        "linear": lambda: (
            100 * (1 - 0.1 / elastic.pressure_for_area(0.1, stress_variance=0.25) / elastic.KAPPA_PERSSON)
        ),
        "books": _books,
        # F / ((sigma_0 + sigma_a) A0) where A/A0 = .01, Eq. 42.
        "light_books": lambda: adhesion_load(0.3, stress_variance=6366.0, tensile_limit=0.7).contact_force,
        "crossover": lambda: 1e6 * crossover_length(0.03, contact_modulus=1.1e11, atomic_distance=5e-10),
        "tolerant_smooth": lambda: max(_tolerant(1e-11).growth),
        "tolerant_rough": lambda: _tolerant(1e-9).growth[0],
        "rubber": lambda: crack_dissipation(
            1e4, loss_compliance=_RUBBER.loss_compliance, relaxed=1e6, tip_radius=1e-9
        ),
        "killing": lambda: _killing(1e4),
        "setae": lambda: (
            fibre_modulus(1.5e9, radius=2.1e-6, length=106e-6, density=1.44e10, angle=0.75) / 1e6
        ),
        "cut_gaussian": lambda: 100 * (_cut_gaussian() - 1),
        "range_1e8": lambda: 2 * maximum_height(1e8),
        "range_1e4": lambda: 2 * maximum_height(1e4),
        "peak_1e8": lambda: maximum_height(1e8),
        "derjaguin": lambda: (
            derjaguin_pull_off(1.0, work_of_adhesion=1.0) / jkr_pull_off(1.0, work_of_adhesion=1.0)
        ),
        "edge_slope": _edge_slope,
    },
    more={
        "ring_density": {"note": f"{_SUMMITS.density:.3f} by Nayak's exact formula"},
        "gw_area": {"note": lambda: f"{_patches('area', 4.1e-3):.2f} at A/A0 of 1 %"},
        "bgt": {"stated": percent(2 / math.pi, 1e-4)},
        "killing": {
            "note": lambda: f"{_killing(1e5):.2f} um for q_0 = 1e5 1/m, {_killing(1e3):.1f} um for 1e3"
        },
        "derjaguin": {"stated": percent(4 / 3, 1e-4)},
    },
)


#: Where macroasperities are looked for.
_STEEL = {"contact_modulus": s.STEEL_MODULUS, "q_reference": 1e5}


def _pressure(load: float) -> float:
    return macroasperity_pressure(s.steel(smooth=True), pressure=load, **_STEEL)


STEEL = application(
    "polished steel and roads",
    values={
        "roads": lambda: 2 * math.pi / 1000 * 100,
        "magnification": lambda: macroasperity_magnification(
            s.steel(smooth=True), pressure=s.STEEL_PRESSURE, **_STEEL
        ),
        "area_share": lambda: s.STEEL_PRESSURE / _pressure(s.STEEL_PRESSURE),
        "pressure_share": lambda: _pressure(10e6) / _pressure(1e6),
        "plastic_limit": lambda: (
            s.yielded(s.steel(), s.STEEL_MODULUS, s.STEEL_PRESSURE, hardness=2e9).plastic
            * 2e9
            / s.STEEL_PRESSURE
        ),
    },
    more={
        "area_share": {"stated": Stated(SITE_THRESHOLD, 0.0, SITE_THRESHOLD, "below it")},
        "pressure_share": {
            "note": lambda: (
                f"{_pressure(1e6) / 1e6:.0f} and {_pressure(10e6) / 1e6:.0f} MPa, but "
                f"{_pressure(100e6) / 1e6:.0f} at 100 MPa, where the contact is not light any more"
            )
        },
    },
)
