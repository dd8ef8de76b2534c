"""Another unit system changes no bit of a dimensionless result: lengths times 2^20, pressures times 2^-30."""

import math

import numpy as np
import pytest

from persson import FullerTabor, archard_hierarchy, bush_gibson_thomas, nayak_asperities, yielding_asperities
from persson.adhesion import solve_adhesion
from persson.capillary import CapillaryWaves
from persson.flaw_tolerance import optimal_modulus
from persson.gaps import gap_distribution
from persson.graded import ElasticPlate, ExponentialLayers
from persson.hardness import size_dependent_hardness
from persson.interface import Interface
from persson.limits import critical_roughness
from persson.percolation import percolation_magnification
from persson.scale import Scale
from persson.separation import contact_stiffness, elastic_energy, macroasperity_magnification, mean_separation
from persson.soft_structures import fibre_modulus
from persson.spectrum import SelfAffine
from persson.spheres import hertz, maugis_pull_off, tabor_parameter
from persson.tabulated import Tabulated
from persson.variants import corrected_contact_area
from persson.viscoelastic import StandardSolid, crack_dissipation

SI = (1.0, 1.0)
OTHER = (2.0**20, 2.0**-30)


def rough(units, rolloff="smooth"):
    band = {"q_long": 1e5 / units[0], "q_short": 3e8 / units[0]}
    return SelfAffine.from_rms_gradient(0.2, hurst=0.7, **band, rolloff=rolloff)


def separation(units):
    length, stress = units
    scale = Scale(rough(units), contact_modulus=2e9 * stress)
    return mean_separation(np.array([1e3, 1e6]) * stress, scale=scale, energy_ratio=0.45) / length


def macroasperities(units):
    length, stress = units
    asked = {"pressure": 1e6 * stress, "contact_modulus": 2e9 * stress, "q_reference": 1e5 / length}
    return macroasperity_magnification(rough(units), **asked)


def variants(units):
    asked = {"stress_variance": 1e16 * units[1] ** 2, "variant": "wang_mueser"}
    return corrected_contact_area(np.array([1e5, 1e8]) * units[1], **asked)


def yielding(units):
    length, stress = units
    scale = Scale(rough(units, "sharp"), contact_modulus=2e9 * stress)
    hard = {"yield_stress": lambda q: 1e8 * stress * np.sqrt(1 + q * length / 1e7)}
    q = np.array([2e5, 1e7, 3e8]) / length
    result = size_dependent_hardness(scale, pressure=1e6 * stress, wavevectors=q, **hard)
    return np.concatenate([result.area_elastic, result.area_plastic])


def asperities(units):
    length, stress = units
    moments = rough(units).moments()
    found = bush_gibson_thomas(2 * moments.rms_height, moments=moments, contact_modulus=2e9 * stress)
    told = {"contact_modulus": 2e7 * stress, "work_of_adhesion": 0.05 * stress * length}
    sticky = FullerTabor(asperities=nayak_asperities(moments), **told)
    return np.array([found.area, found.pressure / stress, sticky.pull_off() / stress])


def graded(units):
    length, stress = units
    excess, depths = (3e9 * stress,), (1e-6 * length,)
    layers = ExponentialLayers(bulk=1e9 * stress, excess=excess, depths=depths, poisson=0.3)
    scale = Scale(rough(units, "plateau"), contact_modulus=layers)
    return scale.variance(np.array([1e4, 1e6, 1e8]) / length) / stress**2


def tables(units):
    length, _ = units
    spectrum = rough(units, "sharp")
    q = np.geomspace(1.0, 3e3, 20) * (1e5 / length)
    found = Tabulated(wavevectors=q, power=spectrum(q)).moments()
    return np.array([found.rms_gradient, found.nayak, found.rms_height / length])


def spheres(units):
    length, stress = units
    contact = hertz(0.3 * stress * length**2, radius=2e-3 * length, contact_modulus=5e9 * stress)
    sticks = {"work_of_adhesion": 0.05 * stress * length, "range_": 3e-10 * length}
    mu = tabor_parameter(2e-3 * length, contact_modulus=5e9 * stress, **sticks)
    return np.array([contact.radius / length, contact.peak_pressure / stress, mu, maugis_pull_off(mu)])


def interface(units):
    length, stress = units
    scale = Scale(rough(units), contact_modulus=2e9 * stress)
    load = np.array([1e6, 1e8]) * stress
    gaps = gap_distribution(np.array([1e-9, 1e-7]) * length, pressure=1e7 * stress, scale=scale)
    zeta = percolation_magnification(scale, pressure=1e7 * stress, q_reference=1e5 / length)
    energy = elastic_energy(load, scale=scale) / (stress * length)
    stiffness = contact_stiffness(load, scale=scale, energy_ratio=0.45) / stress * length
    return np.concatenate([energy, stiffness, gaps * length, [zeta]])


def structures(units):
    length, stress = units
    balls = {"radii": [1e-2 * length, 1e-4 * length], "densities": [1e9 / length**2]}
    forces = np.array([0.1, 2.0]) * stress * length**2
    levels = archard_hierarchy(forces, **balls, contact_modulus=3e9 * stress)
    bumps = {"asperities": nayak_asperities(rough(units).moments()), "hardness": 3e8 * stress}
    yielded = yielding_asperities(2e-8 * length, contact_modulus=2e9 * stress, **bumps)
    rubber = StandardSolid(relaxed=1e6 * stress, unrelaxed=1e9 * stress, time=1e-3)
    crack = {"relaxed": 1e6 * stress, "tip_radius": 1e-9 * length}
    f = crack_dissipation(1e-4 * length, loss_compliance=rubber.loss_compliance, **crack)
    plate = ElasticPlate(young=1e9 * stress, poisson=0.3, thickness=1e-6 * length)
    hairs = {"radius": 1e-6 * length, "length": 1e-4 * length, "density": 1e10 / length**2}
    fibres = fibre_modulus(1e9 * stress, **hairs, angle=0.7)
    found = [yielded.area, yielded.pressure / stress, f, plate(1e6 / length) / stress, fibres / stress]
    return np.concatenate([levels.area / length**2, found])


def sticky(units):
    length, stress = units
    return Interface(work_of_adhesion=0.05 * stress * length)


def sticking(units):
    length, stress = units
    rim = SelfAffine.from_rms_height(0.5e-6 * length, hurst=0.8, q_long=1e5 / length, q_short=1e10 / length)
    scale, interface = Scale(rim, contact_modulus=1.3e7 * stress), sticky(units)
    found = solve_adhesion(scale, pressure=5e5 * stress, interface=interface)
    return np.array([found.real_area, found.macroscopic_work / (stress * length)])


def tolerance(units):
    _, stress = units
    asked = {"pressure": 0.0, "tensile_limit": 1e6 * stress, "interface": sticky(units)}
    found = optimal_modulus(rough(units, "sharp").scaled(1e-6), **asked)
    return np.concatenate([found.modulus / stress, found.area, found.growth])


QUANTITIES = [separation, macroasperities, variants, yielding, asperities, graded, tables, spheres]
QUANTITIES += [interface, structures, sticking, tolerance]


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_another_unit_system_changes_no_bit(quantity):
    one, two = np.asarray(quantity(SI)), np.asarray(quantity(OTHER))
    assert np.all(np.isfinite(one))
    assert np.array_equal(one, two)


def test_capillary_waves_scale_with_the_thermal_length():
    """k_B T sets their only stress: q times 1/s and gamma times 1/s^2 keep every slope."""
    s = 2.0**20
    shape = {"q_bend": 1.7e9, "q_min": 6e4, "q_short": 7e9}
    one = CapillaryWaves(temperature=370.0, surface_tension=0.04, **shape)
    scaled = {name: q / s for name, q in shape.items()}
    two = CapillaryWaves(temperature=370.0, surface_tension=0.04 / s**2, **scaled)
    assert two.moments().rms_gradient == one.moments().rms_gradient
    assert two.moments().rms_height == one.moments().rms_height * s


@pytest.mark.slow
def test_critical_roughness_does_not_depend_on_where_it_starts():
    surface = SelfAffine.from_rms_gradient(0.2, hurst=0.8, q_long=1e5, q_short=1e8)
    asked = {"contact_modulus": 1e7, "interface": Interface(work_of_adhesion=0.05), "tolerance": 0.03}
    first, second = (critical_roughness(one, **asked) for one in (surface, surface.scaled(25.0)))
    assert first == pytest.approx(5 * second, rel=0.06)
    assert math.isfinite(first)
