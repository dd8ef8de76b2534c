"""A lay: the average over directions of a stretched spectrum, by closed moments and by sums over a grid."""

import numpy as np
import pytest

from persson import SelfAffine, Stretched, Tabulated

ROUGH = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=1.0, q_short=16.0)
PLATEAU = SelfAffine.from_rms_height(0.1, hurst=0.4, q_long=2.0, q_short=9.0, rolloff="plateau", q_min=0.5)
TABLE = Tabulated(wavevectors=[1.0, 2.0, 5.0], power=[1.0, 0.3, 0.02])


@pytest.mark.parametrize("spectrum", [ROUGH, PLATEAU, TABLE])
@pytest.mark.parametrize("factor", [1.0, 1.5, 4.0, 12.0])
def test_moments_are_those_of_the_stretched_plane(spectrum, factor):
    lay = Stretched(spectrum=spectrum, factor=factor)
    # Inside a table the power law changes at points that are no ends of the spectrum.
    exact = 1e-6 if spectrum is TABLE else 1e-11
    inverse = factor**-2
    assert lay.m0() == pytest.approx(spectrum.m0(), rel=exact)
    assert lay.m2() == pytest.approx(spectrum.m2() * (1 + inverse) / 2, rel=exact)
    assert lay.m4() == pytest.approx(spectrum.m4() * (3 + 2 * inverse + 3 * inverse**2) / 8, rel=exact)


def test_without_a_stretch_it_is_the_spectrum():
    lay, q = Stretched(spectrum=PLATEAU, factor=1), np.array([0.6, 1.0, 3.0, 8.9])
    np.testing.assert_allclose(lay(q), PLATEAU(q), rtol=1e-12)
    np.testing.assert_allclose(lay.m2(q), PLATEAU.m2(q), rtol=1e-12)


def test_partial_moments_are_sums_over_a_fine_lattice_of_wavevectors():
    lay = Stretched(spectrum=ROUGH, factor=3.0)
    step = 0.005
    qx, qy = np.arange(0, 5.5, step) + step / 2, np.arange(0, 16.1, step) + step / 2
    power = 4 * lay.directional(qx[:, None], qy[None, :]) * step**2
    q = np.hypot(qx[:, None], qy[None, :])
    # The sharp ends of the spectrum cut cells of the lattice, a hundredth of its narrowest band.
    for upper in (0.5, 1.5, 6.0, 16.0):
        inside = q <= upper
        assert lay.m0(upper) == pytest.approx(power[inside].sum(), rel=1e-2)
        assert lay.m2(upper) == pytest.approx((power * q**2)[inside].sum(), rel=1e-2)


def test_the_average_over_directions_integrates_to_the_moments():
    lay = Stretched(spectrum=ROUGH, factor=5.0)
    q = np.geomspace(lay.q_min, lay.q_short, 20_001)
    assert 2 * np.pi * np.trapezoid(q**4 * lay(q), np.log(q)) == pytest.approx(lay.m2(), rel=2e-6)
    assert lay(lay.q_min * 0.99) == 0
    assert lay(lay.q_short * 1.01) == 0


def test_wavevectors_enter_as_ratios_only():
    here, far = Stretched(spectrum=ROUGH, factor=3.0), 2.0**40
    scaled = SelfAffine(hurst=0.8, q_long=far, q_short=16 * far, amplitude=ROUGH.amplitude * far**-4)
    there = Stretched(spectrum=scaled, factor=3.0)
    assert there.m2(3 * far) == here.m2(3.0)
    assert here.scaled(4).m2() == pytest.approx(4 * here.m2(), rel=1e-14)


@pytest.mark.parametrize("spectrum", [ROUGH, PLATEAU])
def test_the_average_over_directions_is_cut_where_the_spectrum_ends(spectrum):
    lay = Stretched(spectrum=spectrum, factor=3.0)
    angle = (np.arange(400_000) + 0.5) * np.pi / 800_000
    for q in (0.7, 3.5, 6.0):
        power = lay.directional(q * np.cos(angle), q * np.sin(angle))
        assert lay(q) == pytest.approx(power.mean(), rel=1e-5)
