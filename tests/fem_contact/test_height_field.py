"""Height fields as values: what they refuse, and that nobody can change one."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest

from fem_contact import HeightField, InvalidInput


def rough():
    return HeightField(heights=np.random.default_rng(19).standard_normal((16, 17)), lengths=(2.0, 3.0))


def test_masked_heights_are_refused_with_the_remedy():
    masked = np.ma.masked_greater(rough().heights, 1.0)
    with pytest.raises(InvalidInput, match=r"heights: \d+ of 272 points are masked: fill them"):
        HeightField(heights=masked, lengths=(1.0, 1.0))
    whole = np.ma.masked_array(rough().heights)
    assert HeightField(heights=whole, lengths=(2.0, 3.0)).rms_height == rough().rms_height


def test_a_height_field_cannot_be_changed():
    original = np.arange(6.0).reshape(2, 3)
    surface = HeightField(heights=original, lengths=(1.0, 1.0))
    with pytest.raises(ValueError, match="read-only"):
        surface.heights[0, 0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        surface.lengths = (2.0, 2.0)  # type: ignore[misc]
    original[0, 0] = 99.0
    assert surface.heights[0, 0] == 0.0
    assert surface.spacing == (0.5, 1 / 3)


@pytest.mark.parametrize("copied", [lambda value: pickle.loads(pickle.dumps(value)), copy.deepcopy])
def test_a_copied_height_field_is_the_same_surface_and_read_only(copied):
    original = rough()
    assert original.rms_gradient > 0
    arrived = copied(original)
    np.testing.assert_array_equal(arrived.heights, original.heights)
    assert arrived.lengths == original.lengths
    assert arrived.rms_gradient == original.rms_gradient
    assert not arrived.heights.flags.writeable
    assert arrived != original


@pytest.mark.parametrize("shape", [(16, 17), (15, 12), (1, 8), (9, 1)])
def test_the_spectral_sum_of_even_powers_are_the_moments(shape):
    surface = HeightField(heights=np.random.default_rng(23).standard_normal(shape), lengths=(2.0, 3.0))
    sums = [surface.spectral_sum(lambda q, n=n: q**n) for n in (0, 2, 4)]
    np.testing.assert_allclose(sums, surface.moments, rtol=1e-12)


def test_the_nayak_parameter_of_one_wave_is_three_halves():
    """All of its moments are those of one q: m0 m4 = m2^2."""
    x = 2 * np.pi * np.arange(24) / 24
    wave = HeightField(heights=np.cos(3 * x)[:, None] + np.zeros(16), lengths=(3.0, 2.0))
    assert wave.nayak == pytest.approx(1.5, rel=1e-12)


def test_a_mean_height_is_no_roughness_to_the_spectral_sum():
    flat = HeightField(heights=np.full((6, 8), 7.0), lengths=(1.0, 1.0))
    assert flat.spectral_sum(lambda q: 1 / q) == 0


@pytest.mark.parametrize("factor", [2.0**-396, 2.0**-300, 2.0**60])
def test_moments_hold_in_any_unit_of_length(factor):
    heights = np.random.default_rng(3).standard_normal((9, 8))
    m0, m2, m4 = HeightField(heights=heights, lengths=(3.0, 2.0)).moments
    small = HeightField(heights=factor * heights, lengths=(3.0 * factor, 2.0 * factor)).moments
    assert small == (m0 * factor**2, m2, m4 / factor**2)
