"""Capillary waves and tabulated spectra: moments, the paper's roughness values, conventions, smoothing."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import quad

from persson import CapillaryWaves, SelfAffine, Spectrum, Tabulated, smoothed

BAND = {"q_bend": 5e9, "q_min": 2 * math.pi / 1e-6, "q_short": 1e10}
PYREX = CapillaryWaves(temperature=1100.0, surface_tension=1.0, **BAND)


@pytest.mark.parametrize("gravity", [0.0, 3e5, 8.4e8])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_moments_of_capillary_waves_equal_the_integrals(gravity, order):
    band = {"q_bend": 1.7e9, "q_min": 6e4, "q_short": 7e9, "q_gravity": gravity}
    waves = CapillaryWaves(temperature=370.0, surface_tension=0.04, **band)
    for q_upper in (1e5, 1e8, 7e9):
        exact = (waves.m0, waves.m2, waves.m4)[order](q_upper)
        density = lambda t: math.exp(t) ** (2 * order + 2) * float(waves(math.exp(t)))  # noqa: E731
        ends, how = (math.log(waves.q_min), math.log(q_upper)), {"epsrel": 1e-11, "epsabs": 0, "limit": 400}
        integral, _ = quad(density, *ends, **how)
        assert exact == pytest.approx(2 * math.pi * integral, rel=1e-9)


def test_narrow_bands_keep_their_digits():
    width = 1e-6 * PYREX.q_min
    band = dataclasses.replace(PYREX, q_short=PYREX.q_min + width)
    middle = PYREX.q_min + width / 2
    power = 2 * math.pi * float(PYREX(middle)) * (band.q_short - band.q_min)
    for order, moment in enumerate((band.m0(), band.m2(), band.m4())):
        expected = power * middle ** (2 * order + 1)
        assert moment == pytest.approx(expected, rel=1e-10)


def test_table_of_a_power_law_is_the_power_law():
    rough = SelfAffine(hurst=0.8, q_long=3.0, q_short=3e4, amplitude=0.2)
    q = np.geomspace(3.0, 3e4, 17)
    table = Tabulated(wavevectors=q, power=rough(q))
    assert isinstance(table, Spectrum)
    for upper in (3.0, 50.0, 1.7e4, 1e9):
        assert table.m0(upper) == pytest.approx(float(rough.m0(upper)), rel=1e-12)
        assert table.m2(upper) == pytest.approx(float(rough.m2(upper)), rel=1e-12)
        assert table.m4(upper) == pytest.approx(float(rough.m4(upper)), rel=1e-12)
    assert table.scaled(9.0).m0() == pytest.approx(9 * float(table.m0()), rel=1e-14)


def test_areal_psd_makes_a_round_trip_and_differs_by_four_pi_squared():
    q = np.array([1.0, 2.0, 7.0])
    psd = np.array([5.0, 3.0, 0.1])
    table = Tabulated.from_areal_psd(q, psd)
    assert 4 * np.pi**2 * table(q) == pytest.approx(psd, rel=1e-14)
    assert table(2.0) * 4 * math.pi**2 == pytest.approx(3.0, rel=1e-14)


def test_a_share_that_vanishes_like_a_tail_smooths_nothing():
    q = np.geomspace(PYREX.q_min, PYREX.q_short, 5)
    plain = smoothed(PYREX, wavevectors=q, yielded=np.zeros(5))
    tail = smoothed(PYREX, wavevectors=q, yielded=[0.0, 5e-324, 3.9e-318, 1e-310, 1e-301])
    np.testing.assert_array_equal(tail.power, plain.power)


def test_smoothing_removes_short_waves_only():
    q = np.geomspace(PYREX.q_min, PYREX.q_short, 200)
    yielded = np.clip(np.log(q / 1e9), 0, 1)
    gradual = smoothed(PYREX, wavevectors=q, yielded=yielded)
    sharp = smoothed(PYREX, wavevectors=q, yielded=yielded, form="sharp")
    low = q < 0.9e9
    assert gradual(q[low]) == pytest.approx(PYREX(q[low]), rel=1e-12)
    assert gradual.m2() < PYREX.m2()
    assert sharp.q_short == pytest.approx(1e9 * math.exp(0.5), rel=0.04)
