"""The study `archard`: its surface is the hierarchy it says, its powers are those of its areas."""

import numpy as np
import pytest

from validation.report.estimates import total_error
from validation.studies import archard
from validation.studies.archard import bumps, press_bumps, radii_of

LOADS = (0.016, 0.032, 0.064)


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


def test_powers_are_the_slopes_of_the_areas_and_bumps_raise_them(data):
    for n in range(2):
        slope, _ = np.polyfit(np.log(LOADS), np.log(data.area_each[n, 1, 1].values), 1)
        assert float(data.load_exponent_grid_each[n, 1, 1]) == pytest.approx(slope, rel=1e-10)
    assert np.all(data.load_exponent_each[1] > data.load_exponent_each[0])


def planted(data, powers, *, grid=0.0):
    """Areas that go with these powers, other on two positions and, by `grid`, on the coarser grid."""
    told = data.copy(deep=True)
    for n, power in enumerate(powers):
        for k, g in np.ndindex(2, 2):
            own = power + (-0.001, 0.001)[k] + (grid, 0.0)[g]
            told["area_each"][n, k, g] = 0.1 * told.relative_load.values**own
    return archard.with_exponents(told)


def test_a_power_that_rises_by_more_than_it_is_uncertain_is_said_to_rise(data):
    half = 12.706204736432095 * 0.001  # Student, one degree of freedom
    told = planted(data, (0.67, 0.9))
    assert told.load_exponent.values == pytest.approx([0.67, 0.9])
    assert total_error(told, "load_exponent").values == pytest.approx(half)
    assert total_error(told, "level_rise").values[1] == pytest.approx(half * 2**0.5)
    powers, rise, _ = archard.views(told).findings
    assert (powers.outcomes, rise.outcomes) == (("+", "+"), ("+",))
    assert archard.views(planted(data, (0.67, 0.68))).findings[1].outcomes == ("0",)
    assert archard.views(planted(data, (0.67, 0.9), grid=0.3)).findings[1].outcomes == ("0",)
    assert archard.views(planted(data, (0.67, 1.2))).findings[0].outcomes == ("+", "-")


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
