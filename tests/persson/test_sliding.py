"""Friction of a viscoelastic solid on a rough surface, by the theory."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from persson import SelfAffine, StandardSolid, friction_of_waves, rubber_friction
from persson.elastic import contact_area, stress_variance
from persson.stretched import Stretched

ROAD = SelfAffine.from_rms_gradient(0.3, hurst=0.8, q_long=1e3, q_short=1e5)
RUBBER = StandardSolid(relaxed=1e6, unrelaxed=3e7, time=1e-2)
TOLD = {"pressure": 1e5, "modulus": RUBBER.modulus, "poisson": 0.5}


def by_quadrature(velocity, energy_ratio):
    """The double integral of the definition, nested and adaptive, with V from a quadrature of its own."""
    plane = 1 - 0.5**2

    def around(q, weight):
        part = lambda angle: weight(q * velocity * math.cos(angle), angle)  # noqa: E731
        return 4 * quad(part, 0, math.pi / 2, limit=200)[0]

    def grown(q):
        stiff = around(q, lambda w, _: abs(complex(RUBBER.modulus(w)) / plane) ** 2)
        return q**3 * float(ROAD(q)) / 4 * stiff

    def lossy(q):
        loss = around(q, lambda w, angle: math.cos(angle) * complex(RUBBER.modulus(w)).imag / plane)
        return q**4 * float(ROAD(q)) / 2 * loss

    nodes = np.geomspace(1e3, 1e5, 400)
    rates = np.array([grown(q) for q in nodes]) * nodes
    variance = np.concatenate([[0], np.cumsum((rates[1:] + rates[:-1]) / 2 * np.diff(np.log(nodes)))])
    share = np.where(variance > 0, [math.erf(1e5 / math.sqrt(2 * max(v, 1e-300))) for v in variance], 1.0)
    kept = share * (energy_ratio + (1 - energy_ratio) * share**2)
    lost = np.array([lossy(q) for q in nodes])
    return float(np.trapezoid(kept * lost, np.log(nodes))) / 1e5, share[-1]


@pytest.mark.parametrize(("velocity", "energy_ratio"), [(1e-4, 1.0), (1e-2, 0.5)])
def test_friction_is_the_double_integral(velocity, energy_ratio):
    found = rubber_friction(ROAD, velocity=velocity, energy_ratio=energy_ratio, **TOLD)
    friction, area = by_quadrature(velocity, energy_ratio)
    # Trapezoids of 400 nodes are good for 1e-4 each.
    assert found.friction == pytest.approx(friction, rel=1e-3)
    assert found.area == pytest.approx(area, rel=1e-3)


@pytest.mark.parametrize(("velocity", "young"), [(1e-12, 1e6), (1e6, 3e7)])
def test_slow_and_fast_it_is_the_elastic_theory_without_friction(velocity, young):
    found = rubber_friction(ROAD, velocity=velocity, **TOLD)
    full = stress_variance(ROAD.m2(), contact_modulus=young / 0.75)
    assert found.area == pytest.approx(float(contact_area(1e5, stress_variance=full)), rel=1e-5)
    assert found.friction < 1e-6


def test_full_contact_loses_what_every_wave_loses():
    q, velocity = np.array([2e3, 5e3, 5e3]), 1e-3
    qx, power = np.array([2e3, 3e3, -3e3]), np.array([1e-12, 4e-13, 4e-13])
    told = TOLD | {"pressure": 1e9, "power": power, "velocity": velocity}
    found = friction_of_waves(qx, np.sqrt(q**2 - qx**2), **told)
    lost = RUBBER.modulus(np.abs(qx) * velocity).imag / 0.75
    assert found.friction == pytest.approx(np.sum(power * q * np.abs(qx) * lost) / 2 / 1e9, rel=1e-12)
    assert found.area == 1.0


def test_modulus_and_loss_compliance_of_the_standard_solid_belong_together():
    omega = np.geomspace(1e-3, 1e6, 30)
    assert RUBBER.loss_compliance(omega) == pytest.approx(-(1 / RUBBER.modulus(omega)).imag, rel=1e-9)


def test_along_a_lay_friction_is_that_of_its_waves():
    lay = Stretched(spectrum=ROAD, factor=5.0)
    q, angle = np.geomspace(lay.q_min, lay.q_short, 1500), (np.arange(720) + 0.5) * 2 * np.pi / 720
    middle = np.sqrt(q[1:] * q[:-1])
    x, y = (np.outer(middle, part(angle)) for part in (np.cos, np.sin))
    power = lay.directional(x, y) * (middle * np.diff(q))[:, None] * 2 * np.pi / 720
    there = power > 0
    expected = friction_of_waves(x[there], y[there], power=power[there], velocity=0.1, **TOLD)
    found = rubber_friction(lay, velocity=0.1, **TOLD)
    assert found.friction == pytest.approx(expected.friction, rel=0.01)
    even = rubber_friction(ROAD, velocity=0.1, **TOLD)
    assert found.friction < 0.5 * even.friction
