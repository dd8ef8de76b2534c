"""Closed forms of elastic contact: limits, conservation, digits at the extremes, units."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from persson import InvalidInput, SelfAffine
from persson.elastic import (
    KAPPA_BGT,
    KAPPA_PERSSON,
    area_against_magnification,
    contact_area,
    diffusion_parameter,
    initial_slope,
    kappa,
    non_contact_area,
    persson_kappa,
    pressure_distribution,
    pressure_for_area,
    reduced_pressure,
    stress_variance,
)

RATIOS = (0.03, 0.4, 1.0, 3.0, 8.0)


def test_light_load_gives_the_constant_of_the_theory():
    """Persson 2006, Eq. 21: A/A0 = kappa p0/(E* h'), kappa = sqrt(8/pi), 2/pi of the asperity theory."""
    pressure = 1e-7 * 2e9 * 0.1
    area = contact_area(pressure, stress_variance=stress_variance(0.1**2, contact_modulus=2e9))
    p = reduced_pressure(pressure, contact_modulus=2e9, rms_gradient=0.1)
    assert kappa(area, reduced_pressure=p) == pytest.approx(KAPPA_PERSSON, rel=1e-13)
    assert pytest.approx(2 / math.pi, rel=1e-15) == KAPPA_PERSSON / KAPPA_BGT
    assert persson_kappa(p) == pytest.approx(KAPPA_PERSSON, rel=1e-13)


@pytest.mark.parametrize("ratio", RATIOS)
def test_area_is_erf_of_one_over_twice_the_root_of_g(ratio):
    variance = 5.0
    pressure = ratio * math.sqrt(variance)
    exact = math.erf(0.5 / math.sqrt(float(diffusion_parameter(pressure, stress_variance=variance))))
    assert contact_area(pressure, stress_variance=variance) == pytest.approx(exact, rel=1e-14)


@pytest.mark.parametrize("ratio", RATIOS)
def test_pressure_distribution_diffuses(ratio):
    """P_V = P_ss / 2 (Persson 2006, Eq. 17).

    Central differences in V and sigma agree up to their O(step^2) errors.
    """
    v, h, k = 1.0, 2e-3, 2e-4
    s = np.linspace(0.2, 4.0, 20)

    def p(stress, variance):
        return pressure_distribution(stress, pressure=ratio, stress_variance=variance)

    rate = (p(s, v + k) - p(s, v - k)) / (2 * k)
    curvature = (p(s + h, v) - 2 * p(s, v) + p(s - h, v)) / h**2
    assert rate == pytest.approx(curvature / 2, abs=2e-6)


@pytest.mark.parametrize("ratio", RATIOS)
def test_initial_slope_is_the_derivative_and_the_rate_of_area_loss(ratio):
    v = 2.3
    pressure = ratio * math.sqrt(v)
    slope = float(initial_slope(pressure, stress_variance=v))
    eps = 1e-9 * math.sqrt(v)
    near = pressure_distribution(eps, pressure=pressure, stress_variance=v)
    assert near / eps == pytest.approx(slope, rel=1e-6)
    dv = 1e-4 * v
    lost = contact_area(pressure, stress_variance=v - dv) - contact_area(pressure, stress_variance=v + dv)
    # Rounding of A over 2 dv limits the difference quotient: 1e-16 / (2e-4) relative to slope V.
    assert lost / (2 * dv) == pytest.approx(slope / 2, rel=1e-6, abs=1e-11 / v)


def test_extremes_neither_overflow_nor_lose_digits():
    light = 2e-19 / math.sqrt(2 * math.pi)
    assert contact_area(1e-9, stress_variance=1e20) == pytest.approx(light, rel=1e-13)
    assert contact_area(3.0, stress_variance=0.0) == 1
    assert contact_area(0.0, stress_variance=0.0) == 0
    assert contact_area(5.0, stress_variance=1e-300) == 1
    assert non_contact_area(10.0, stress_variance=1.0) == pytest.approx(1.523970604832105e-23, rel=1e-12)
    # sigma sigma0 / V = 1e-20: the difference of two Gaussians would be exactly 0.
    p = pressure_distribution(1e-10, pressure=1e-10, stress_variance=1.0)
    assert p == pytest.approx(2e-20 / math.sqrt(2 * math.pi), rel=1e-13)
    assert pressure_distribution(1e6, pressure=1.0, stress_variance=1.0) == 0
    assert pressure_distribution(-1.0, pressure=1.0, stress_variance=1.0) == 0


@given(area=st.floats(1e-12, 1 - 1e-9))
@settings(max_examples=50)
def test_pressure_for_area_inverts_contact_area(area):
    pressure = pressure_for_area(area, stress_variance=4.0)
    assert contact_area(pressure, stress_variance=4.0) == pytest.approx(area, rel=1e-12)
    with pytest.raises(InvalidInput, match="area"):
        pressure_for_area(1.0, stress_variance=1.0)


def test_area_falls_with_magnification_and_rises_with_load():
    spectrum = SelfAffine.from_rms_gradient(0.2, hurst=0.8, q_long=1e5, q_short=1e9)
    zeta = np.geomspace(0.5, 1e4, 60)
    asked = {"pressure": np.array([[1e6], [1e7], [1e8]]), "magnification": zeta}
    area = area_against_magnification(spectrum, contact_modulus=1e9, q_reference=1e5, **asked)
    assert area.shape == (3, 60)
    assert np.all(np.diff(area, axis=1) <= 0)
    assert np.all(np.diff(area, axis=0) >= 0)
    assert np.all(area[:, zeta <= 1] == 1)
    full = stress_variance(spectrum.m2(), contact_modulus=1e9)
    assert area[0, -1] == contact_area(1e6, stress_variance=full)
