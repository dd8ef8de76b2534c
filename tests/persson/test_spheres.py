"""Smooth spheres: Hertz, adhesion between its two limits, double-Hertz distributions."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from persson import hertz
from persson.spheres import DoubleHertz, effective_radius, hertz_pressure_distribution, maugis_pull_off


def test_hertz_relations_hold_together():
    """Persson 2006, Eqs. 4, 6-8; the pressure integrates to the force."""
    radius = effective_radius(3e-3, 6e-3)
    assert radius == pytest.approx(2e-3, rel=1e-14)
    assert effective_radius(3e-3, math.inf) == 3e-3
    contact = hertz(0.4, radius=radius, contact_modulus=5e9)
    assert contact.radius**2 == pytest.approx(radius * contact.approach, rel=1e-13)
    assert 4 / 3 * 5e9 * contact.approach**1.5 * math.sqrt(radius) == pytest.approx(0.4, rel=1e-13)
    force, _ = quad(lambda r: 2 * math.pi * r * float(contact.pressure(r)), 0, contact.radius, epsabs=1e-14)
    assert force == pytest.approx(0.4, rel=1e-8)
    assert contact.pressure(2 * contact.radius) == 0


def test_hertz_distribution_has_area_one_and_two_thirds_of_the_peak_as_mean():
    area, _ = quad(lambda s: float(hertz_pressure_distribution(s, peak_pressure=3.0)), 0, 3)
    mean, _ = quad(lambda s: s * float(hertz_pressure_distribution(s, peak_pressure=3.0)), 0, 3)
    assert (area, mean) == pytest.approx((1.0, 2.0), rel=1e-12)


def test_pull_off_falls_from_derjaguin_to_jkr_with_the_tabor_parameter():
    values = [maugis_pull_off(mu) for mu in (1e-4, 1e-2, 0.1, 1.0, 5.0, 100.0)]
    assert np.all(np.diff(values) < 0)
    assert values[0] == pytest.approx(2, abs=2e-3)
    assert values[-1] == pytest.approx(1.5, abs=1e-3)
    # Carpick, Ogletree and Salmeron (1999) fit Maugis by 7/4 - 1/4 (4.04 L^1.4 - 1)/(4.04 L^1.4 + 1) to about
    # 1 %.
    for mu in (0.1, 0.5, 1.0, 3.0):
        power = 4.04 * (1.157 * mu) ** 1.4
        assert maugis_pull_off(mu) == pytest.approx(1.75 - 0.25 * (power - 1) / (power + 1), rel=0.015)


def test_double_hertz_forces_and_distribution_are_those_of_its_stress_field():
    """Persson 2006, App. B: sigma_max = 1, sigma_a = .3, eta = 1.1."""
    contact = DoubleHertz(peak_pressure=1.0, tensile_limit=0.3, eta=1.1)
    assert contact.distribution(1.0) == pytest.approx(1.77781, abs=5e-6)
    assert contact.load(1.0) == pytest.approx(1.777670, abs=5e-7)
    assert contact.pressure(1.0) == pytest.approx(-0.3, rel=1e-12)
    assert contact.pressure(0.0) == pytest.approx(1.0, rel=1e-12)
    ring = lambda r: 2 * math.pi * r * float(contact.pressure(r))  # noqa: E731
    total, inside = (quad(ring, 0, end, points=[1.0], epsabs=1e-12)[0] for end in (1.1, 1.0))
    assert total == pytest.approx(contact.load(1.0), rel=1e-8)
    assert inside == pytest.approx(contact.contact_force(1.0), rel=1e-8)
    area, _ = quad(lambda s: float(contact.distribution(s)), -0.3, 1.0, epsabs=1e-12)
    mean, _ = quad(lambda s: s * float(contact.distribution(s)), -0.3, 1.0, epsabs=1e-12)
    assert area == pytest.approx(1, rel=1e-9)
    assert mean * math.pi == pytest.approx(contact.contact_force(1.0), rel=1e-8)


def test_double_hertz_starts_linearly_and_contains_hertz():
    contact = DoubleHertz(peak_pressure=1.0, tensile_limit=0.3, eta=1.1)
    inner = 1 + 0.3 * 1.1 / math.sqrt(0.21)
    assert contact.distribution(-0.3 + 1e-7) == pytest.approx(2e-7 / inner**2, rel=1e-5)
    assert contact.distribution(-0.31) == 0
    plain = DoubleHertz(peak_pressure=3.0, tensile_limit=0.0, eta=1.5)
    s = np.linspace(0.01, 3.0, 9)
    exact = hertz_pressure_distribution(s, peak_pressure=3.0)
    assert plain.distribution(s) == pytest.approx(exact, rel=1e-12)
