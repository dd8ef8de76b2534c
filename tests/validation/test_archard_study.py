"""The study `archard`: its surface is the hierarchy it says, its powers are those of its areas."""

import numpy as np
import pytest

from validation.studies import archard
from validation.studies.archard import bumps, press_bumps, radii_of


@pytest.fixture(scope="module")
def data(numbers):
    return numbers("archard")


def test_tops_of_every_level_have_the_radius_that_the_theory_is_told():
    waves, levels = (1, 8), (1.0, 0.2)
    heights = bumps(waves, levels, ((0.0, 0.0),) * 2, points=2048).heights
    # Both levels have a top at the origin: their curvatures add.
    curvature = (2 * heights[0, 0] - heights[1, 0] - heights[-1, 0]) * 2048**2
    assert curvature == pytest.approx(sum(1 / radius for radius in radii_of(waves, levels)), rel=1e-3)


def test_a_single_level_is_a_sphere_in_light_contact(data):
    # Neighbours add to the curvature in the third power of a over the period: a/L = .09 to .13.
    assert data.area_each[0, :, -1].values == pytest.approx(
        np.broadcast_to(data.area_archard[0].values, (2, 3)), rel=0.06
    )
    assert float(data.load_exponent_archard[0]) == pytest.approx(2 / 3)


def test_a_path_of_loads_with_a_contact_too_small_has_no_power(data):
    told = data.copy(deep=True)
    told["area_each"][0, 0, 1, 0] = np.nan
    told = archard.with_exponents(told)
    assert np.isnan(told.load_exponent[0])
    assert np.isfinite(told.load_exponent[1])


def test_a_contact_of_a_few_points_has_no_area():
    light = press_bumps(waves=(1,), heights=(1.0,), places=((0.3, 0.1),), loads=(1e-5, 0.02), points=32)
    first, second = light.do().area_each.values
    assert np.isnan(first)
    assert second > 0
