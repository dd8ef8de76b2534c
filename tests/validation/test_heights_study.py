"""The study `heights`: moments and areas are those of its surfaces, its outcomes those of its numbers."""

import numpy as np
import pytest
from scipy import stats

from fem_contact import HalfSpace, bem, contact_areas
from validation.measurements.measurement import grid_for
from validation.report.estimates import derive, mean, total_error
from validation.scenes.surfaces import spectrum_of
from validation.studies import heights


@pytest.fixture(scope="module")
def options(asked):
    return asked("heights")[0]


@pytest.fixture(scope="module")
def data(asked):
    return asked("heights")[1]


def test_the_moments_of_the_heights_are_those_of_the_surface(options, data):
    case = options.first(3.0).further(2)
    z = case.heights(grid_for(case, 4.0)).heights.ravel()
    assert float(data.skewness_each[1, 2]) == pytest.approx(stats.skew(z), abs=1e-10)
    assert float(data.excess_kurtosis_each[1, 2]) == pytest.approx(stats.kurtosis(z), abs=1e-10)
    assert float(data.height_distance_each[1, 2]) == pytest.approx(
        stats.kstest(z / z.std(), "norm").statistic, abs=1e-3
    )
    within = np.mean(np.abs(z / z.std()) <= 4)
    assert float(data.height_density_each[1, 2].sum() * 8 / 64) == pytest.approx(within, abs=1e-12)


def test_the_second_spectrum_has_longer_waves_and_the_same_short_ones(options):
    first, second = (spectrum_of(case.surface) for case in (options.first(3.0), options.second()))
    q = np.array([0.9, 1.0]) * first.q_short
    # The bend of the roll-off is felt by a part of its order (q_0 / q)^2.
    assert second(q) == pytest.approx(first(q), rel=0.02, abs=0)
    assert second.m0() > 2 * first.m0()


def test_both_spectra_are_pressed_with_the_same_load_and_common_phases(options, data):
    first, second = options.first(3.0).further(1), options.second().further(1)
    pressed = bem.solve(
        second.heights(grid_for(first, 4.0)),
        HalfSpace(solid=second.elastic),
        mean_pressure=0.2 * first.pressure_scale,
    ).checked()
    area = contact_areas(pressed, subcell=True).subcell
    assert float(data.area_each[1, 1, 1]) == pytest.approx(area, rel=1e-5)
    theory = data.area_persson_each.isel(surface=1, load=1)
    assert 0.8 < float(theory[1] / theory[0]) < 0.9


def planted(data, *, change):
    """Heights twice as high with the longer roll-off, whose areas change by a part."""
    told = data.copy(deep=True)
    told["skewness_each"][0] = [0.1, 0.2, 0.3]
    told["excess_kurtosis_each"][0] = [-0.1, 0.0, 0.2]
    told["area_change_each"][:], told["rms_height_change_each"][:] = change, 1.0
    told = mean(told, "skewness", "excess_kurtosis", "area_change", "rms_height_change")
    return derive(told, area_change_share="2 * area_change / rms_height_change")


def test_moments_are_compared_with_zero_and_the_area_with_the_heights(data):
    half = 4.302652729911275 * 0.1 / np.sqrt(3)  # Student, two degrees of freedom
    told = planted(data, change=-0.1)
    assert float(total_error(told, "skewness")[0]) == pytest.approx(half)
    skewness, kurtosis, _, longer = heights.views(told).findings
    assert skewness.outcomes[0] == "0"
    assert kurtosis.outcomes[0] == "0"
    assert longer.outcomes == ("within", "within")
    assert heights.views(planted(data, change=0.8)).findings[-1].outcomes == ("beyond", "beyond")


def test_what_longer_waves_change_is_the_mean_of_the_changes_of_the_surfaces(data):
    change = (data.area_each[1] / data.area_each[0] - 1).mean("surface")
    assert data.area_change.values == pytest.approx(change.values, rel=1e-12)
    assert float(data.rms_height_change) > 0.4
