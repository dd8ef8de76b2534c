"""Power spectra against quadrature, closed forms, limits and changes of unit."""

import dataclasses
import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from persson.spectrum import SelfAffine, Spectrum, area_factor

ROLLOFFS = ("sharp", "smooth", "plateau")


def by_quadrature(spectrum, order, q_upper):
    """2 pi int q^(2k+2) C d(ln q), panel by panel (scipy's error estimate is below 1e-10 of the result)."""
    lowest = max(spectrum.q_min, 1e-9 * spectrum.q_long)
    panels = np.unique(np.concatenate([np.geomspace(lowest, q_upper, 12), [min(spectrum.q_long, q_upper)]]))
    total = 0.0
    for a, b in itertools.pairwise(panels):
        density = lambda t: math.exp(t) ** (2 * order + 2) * float(spectrum(math.exp(t)))  # noqa: E731
        total += quad(density, math.log(a), math.log(b), epsrel=1e-12, epsabs=0)[0]
    return 2 * math.pi * total


@pytest.mark.parametrize("rolloff", ROLLOFFS)
@pytest.mark.parametrize("hurst", [0.0, 0.3, 0.5, 0.8, 1.0])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_moments_equal_the_integrals_of_the_spectrum(rolloff, hurst, order):
    shape = {"hurst": hurst, "rolloff": rolloff, "q_min": None if rolloff == "sharp" else 0.4}
    spectrum = SelfAffine(q_long=3.0, q_short=700.0, amplitude=0.2, **shape)
    for q_upper in (3.5, 40.0, 700.0):
        exact = (spectrum.m0, spectrum.m2, spectrum.m4)[order](q_upper)
        assert exact == pytest.approx(by_quadrature(spectrum, order, q_upper), rel=1e-10)


@pytest.mark.parametrize("rolloff", ROLLOFFS)
def test_a_narrow_band_of_waves_keeps_all_digits(rolloff):
    """Over a band dq << q the moment is 2 pi q^(2k+1) C(q) dq at the middle, up to (dq/q)^2.

    A difference of primitives is not.
    """
    q = 5.0
    width = 1e-6 * q
    spectrum = SelfAffine(hurst=0.7, q_long=q, q_short=q + width, amplitude=1.5, rolloff=rolloff, q_min=q)
    middle = q + width / 2
    for order, moment in enumerate((spectrum.m0(), spectrum.m2(), spectrum.m4())):
        expected = 2 * math.pi * middle ** (2 * order + 1) * float(spectrum(middle)) * (spectrum.q_short - q)
        assert moment == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("hurst", [1e-13, 0.5, 1 - 1e-13])
def test_moments_are_continuous_where_a_power_becomes_a_logarithm(hurst):
    shapes = [{"hurst": one, "q_long": 1.0, "q_short": 1e8} for one in (hurst, round(hurst * 2) / 2)]
    near, at = (SelfAffine(**shape, amplitude=1.0, rolloff="sharp").moments() for shape in shapes)
    for a, b in ((near.m0, at.m0), (near.m2, at.m2), (near.m4, at.m4)):
        assert a == pytest.approx(b, rel=1e-11)


@pytest.mark.parametrize("rolloff", ROLLOFFS)
def test_partial_moments_end_in_the_whole_and_never_decrease(rolloff):
    spectrum = SelfAffine.from_rms_gradient(0.3, hurst=0.6, q_long=10.0, q_short=1e4, rolloff=rolloff)
    q = np.geomspace(1.0, 1e5, 200)
    m2 = spectrum.m2(q)
    assert np.all(np.diff(m2) >= 0)
    assert m2[-1] == pytest.approx(0.09, rel=1e-13)
    assert m2[q <= spectrum.q_min].sum() == 0
    part = dataclasses.replace(spectrum, q_short=300.0)
    assert part.m2() == pytest.approx(float(spectrum.m2(300.0)), rel=1e-14)


def test_spectrum_vanishes_outside_its_range_and_keeps_its_edges():
    spectrum = SelfAffine(hurst=0.8, q_long=2 * math.pi / 0.3, q_short=2 * math.pi / 0.01, amplitude=1.0)
    edges = np.array([spectrum.q_long * (1 - 5e-13), spectrum.q_short * (1 + 5e-13)])
    assert np.all(spectrum(edges) > 0)
    outside = np.array([spectrum.q_long * (1 - 1e-11), spectrum.q_short * (1 + 1e-11), 0.0])
    assert np.all(spectrum(outside) == 0)
    assert isinstance(spectrum, Spectrum)


@given(st.floats(0, 1), st.floats(0.1, 10), st.sampled_from(ROLLOFFS), st.floats(1e-3, 3))
@settings(max_examples=60)
def test_dimensionless_moments_do_not_know_the_unit_of_length(hurst, decades, rolloff, gradient):
    unit, q, told = 2.0**20, np.array([7.0, 7 * 10**decades]), {"hurst": hurst, "rolloff": rolloff}
    bands = [{"q_long": low, "q_short": high} for low, high in (q, q / unit)]
    small, large = (SelfAffine.from_rms_gradient(gradient, **band, **told) for band in bands)
    assert large.moments().rms_gradient == small.moments().rms_gradient
    assert large.moments().nayak == small.moments().nayak
    assert large.moments().rms_height == small.moments().rms_height * unit
    assert small.moments().nayak >= 1.5 * (1 - 1e-12)


def test_scaling_the_spectrum_scales_every_moment():
    spectrum = SelfAffine.from_rms_height(2e-6, hurst=0.8, q_long=1e4, q_short=1e7)
    assert spectrum.moments().rms_height == pytest.approx(2e-6, rel=1e-14)
    four = spectrum.scaled(4.0).moments()
    assert four.rms_height == pytest.approx(4e-6, rel=1e-14)
    assert four.nayak == pytest.approx(spectrum.moments().nayak, rel=1e-14)


def test_the_rim_has_the_gradient_and_area_the_paper_builds_on():
    """Persson 2006, Sec. 8.3: h_rms = 0.5 um, H = 0.8, q = 1e5 ... 1e10 1/m.

    Surface area 38 % above the projected one.
    """
    rim = SelfAffine.from_rms_height(0.5e-6, hurst=0.8, q_long=1e5, q_short=1e10)
    assert rim.m2() == pytest.approx(0.99000, abs=5e-6)
    assert area_factor(rim.m2()) == pytest.approx(1.37583, abs=5e-6)


def test_area_factor_is_the_average_over_gaussian_slopes():
    for m2 in (0.04, 1.0, 30.0):
        mean, _ = quad(lambda s, m: math.sqrt(1 + s * m) * math.exp(-s), 0, 60, (m2,), epsabs=1e-13)
        assert area_factor(m2) == pytest.approx(mean, rel=1e-12)
    assert area_factor(1e-8) - 1 == pytest.approx(0.5e-8, rel=1e-6)
    assert area_factor(1e12) == pytest.approx(math.sqrt(math.pi) / 2 * 1e6, rel=2e-6)
