"""The study `heights`: moments and areas are those of its surfaces, its sentences those of its numbers."""

import numpy as np
import pytest
from scipy import stats

from fem_contact import HalfSpace, bem, contact_areas
from validation.measures.measurement import grid_for
from validation.scenes.surfaces import spectrum_of
from validation.solves.bench import Bench
from validation.studies import heights


@pytest.fixture(scope="module")
def options():
    return heights.Options(
        periods=(1.0, 3.0), reduced_pressures=(0.05, 0.2), bandwidth=4.0, surfaces=3, seed=17
    )


@pytest.fixture(scope="module")
def data(options, tmp_path_factory):
    return heights.run(options, bench=Bench.at(tmp_path_factory.mktemp("solves")))


def test_the_moments_of_the_heights_are_those_of_the_surface(options, data):
    case = options.first(3.0).further(2)
    z = case.heights(grid_for(case, 4.0)).heights.ravel()
    assert float(data.skewness[1, 2]) == pytest.approx(stats.skew(z), abs=1e-10)
    assert float(data.excess[1, 2]) == pytest.approx(stats.kurtosis(z), abs=1e-10)
    assert float(data.distance[1, 2]) == pytest.approx(stats.kstest(z / z.std(), "norm").statistic, abs=1e-3)
    within = np.mean(np.abs(z / z.std()) <= 4)
    assert float(data.density[1, 2].sum() * 8 / 64) == pytest.approx(within, abs=1e-12)


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
    assert float(data.area[1, 1, 1]) == pytest.approx(area, rel=1e-5)
    theory = data.theory[1, 1, 1] / data.theory[0, 1, 1]
    assert 0.8 < float(theory) < 1


def planted(data, *, change):
    told = data.copy(deep=True)
    told["rms_height"][0], told["rms_height"][1] = 1.0, 2.0
    told["area"][0], told["area"][1] = 0.1, 0.1 * change
    told["skewness"][0] = [0.1, 0.2, 0.3]
    told["excess"][0] = [-0.1, 0.0, 0.2]
    return told


def test_what_is_not_told_from_zero_is_said_and_what_the_area_follows(data):
    half = 4.302652729911275 * 0.1 / np.sqrt(3)  # Student, two degrees of freedom
    said = heights.findings(planted(data, change=0.9))
    assert f"skewness 0.2 +- {half:.2g} (not told from zero)" in said[0]
    assert "-10.0 +- 0.0 % at p* = 0.05" in said[-1]
    assert said[-1].endswith("it follows the gradient, not the heights.")
    assert not heights.findings(planted(data, change=1.8))[-1].endswith("not the heights.")


def test_table_and_figure_hold_every_sample(data):
    assert [row[0] for row in heights.table(data).rows] == [1.0, 3.0]
    (drawing,) = heights.figures(data)
    assert drawing.name == "heights"
