"""The study `heights`: moments and areas are those of its surfaces, its outcomes those of its numbers."""

import numpy as np
import pytest
from scipy import stats

from fem_contact import HalfSpace, bem, contact_areas
from validation.measurements.measurement import grid_for
from validation.scenes.surfaces import spectrum_of


def test_the_moments_of_the_heights_are_those_of_the_surface(asked):
    options, data = asked("heights")
    case = options.first(3.0).further(2)
    z = case.heights(grid_for(case, 4.0)).heights.ravel()
    assert float(data.skewness_each[1, 2]) == pytest.approx(stats.skew(z), abs=1e-10)
    assert float(data.excess_kurtosis_each[1, 2]) == pytest.approx(stats.kurtosis(z), abs=1e-10)
    assert float(data.height_distance_each[1, 2]) == pytest.approx(
        stats.kstest(z / z.std(), "norm").statistic, abs=1e-3
    )
    within = np.mean(np.abs(z / z.std()) <= 4)
    assert float(data.height_density_each[1, 2].sum() * 8 / 64) == pytest.approx(within, abs=1e-12)


def test_the_second_spectrum_has_longer_waves_and_the_same_short_ones(asked):
    options, _ = asked("heights")
    first, second = (spectrum_of(case.surface) for case in (options.first(3.0), options.second()))
    q = np.array([0.9, 1.0]) * first.q_short
    # The bend of the roll-off is felt by a part of its order (q_0 / q)^2.
    assert second(q) == pytest.approx(first(q), rel=0.02, abs=0)
    assert second.m0() > 2 * first.m0()


def test_both_spectra_are_pressed_with_the_same_load_and_common_phases(asked):
    options, data = asked("heights")
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
