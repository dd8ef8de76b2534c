"""Surfaces with a lay: the same on nested grids, with the slopes that their spectrum says."""

import numpy as np
import pytest

from fem_contact import Patch, measured_lay, radial_spectrum, random_surface

STRETCH, Q_LONG, Q_SHORT = 3.0, 2 * np.pi * 8, 2 * np.pi * 60


def ground(qx, qy):
    q = np.hypot(STRETCH * qx, qy)
    return np.where((q >= Q_LONG) & (q <= Q_SHORT), STRETCH * np.maximum(q, 1.0) ** -3.6, 0.0)


def surface(n, spectrum=ground, *, isotropic=False):
    said = {"q_short": Q_SHORT, "lengths": (1.0, 1.0), "shape": (n, n), "seed": 7}
    return random_surface(spectrum, **said, isotropic=isotropic)


def test_nested_grids_agree_at_their_common_points():
    coarse, fine = surface(128), surface(384)
    np.testing.assert_allclose(fine.heights[::3, ::3], coarse.heights, atol=1e-12 * coarse.rms_height)


def test_slopes_across_the_lay_are_steeper_by_the_stretch():
    lay = measured_lay(surface(160))
    # Sums over 20 waves along x instead of integrals: a part of 1/20 of the slopes along it.
    assert lay.ratio == pytest.approx(STRETCH, rel=0.05)
    assert abs(lay.direction) < 1e-12
    assert lay.along**2 + lay.across**2 == pytest.approx(surface(160).rms_gradient ** 2, rel=1e-12)


def test_an_isotropic_function_of_both_components_makes_the_same_surface():
    both = surface(128)
    same = surface(128, lambda q: ground(q / STRETCH, 0 * q), isotropic=True)
    as_components = surface(128, lambda qx, qy: ground(np.hypot(qx, qy) / STRETCH, 0 * qx))
    np.testing.assert_array_equal(as_components.heights, same.heights)
    assert measured_lay(same).ratio == pytest.approx(1, abs=0.02)
    assert not np.allclose(both.heights, same.heights)


def test_a_turned_lay_is_found_where_it_lies():
    angle, cos, sin = 0.4, np.cos(0.4), np.sin(0.4)
    turned = surface(160, lambda qx, qy: ground(qx * cos + qy * sin, qy * cos - qx * sin))
    lay = measured_lay(turned)
    assert lay.direction == pytest.approx(angle, abs=0.02)
    assert lay.ratio == pytest.approx(STRETCH, rel=0.05)
    fine = turned.resampled((960, 960)).heights[:500, :500]
    patch = measured_lay(Patch(heights=fine, lengths=(500 / 960, 500 / 960)))
    assert patch.direction == pytest.approx(angle, abs=0.05)
    assert patch.ratio == pytest.approx(lay.ratio, rel=0.1)


def test_rings_of_the_spectrum_are_its_average_over_directions():
    rings = radial_spectrum(surface(160))
    angle = (np.arange(2000) + 0.5) * np.pi / 2000
    own = (rings.q > Q_LONG) & (rings.q < 0.9 * Q_SHORT)
    q = rings.q[own, None]
    average = ground(q * np.cos(angle), q * np.sin(angle)).mean(axis=1)
    assert np.median(rings.power[own] / average) == pytest.approx(1, abs=0.02)
