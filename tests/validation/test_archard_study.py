"""The study `archard`: its surface is the hierarchy it says, its powers are those of its areas."""

import numpy as np
import pytest

from validation.errors import UsageError
from validation.solves.bench import Bench
from validation.studies import archard, find_study
from validation.studies.archard import Hierarchy

LOADS = (0.016, 0.032, 0.064)


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    options = archard.Options(waves=(8,), heights=(0.2,), loads=LOADS, surfaces=2, grids=(96, 128), seed=17)
    return archard.run(options, bench=Bench.at(tmp_path_factory.mktemp("solves")))


def test_tops_of_every_level_have_the_radius_that_the_theory_is_told():
    one = Hierarchy(waves=(1, 8), heights=(1.0, 0.2), places=((0.0, 0.0),) * 2, loads=LOADS, points=2048)
    heights = one.field().heights
    # Both levels have a top at the origin: their curvatures add.
    curvature = (2 * heights[0, 0] - heights[1, 0] - heights[-1, 0]) * 2048**2
    assert curvature == pytest.approx(sum(1 / radius for radius in one.radii), rel=1e-3)


def test_a_single_level_is_a_sphere_in_light_contact(data):
    # Neighbours add to the curvature in the third power of a over the period: a/L = .09 to .13.
    assert data.area[0, :, -1].values == pytest.approx(
        np.broadcast_to(data.theory[0].values, (2, 3)), rel=0.06
    )
    assert float(data.theory_exponent[0]) == pytest.approx(2 / 3)


def test_powers_are_the_slopes_of_the_areas_and_bumps_raise_them(data):
    for n in range(2):
        slope, _ = np.polyfit(np.log(LOADS), np.log(data.area[n, 1, 1].values), 1)
        assert float(data.exponent[n, 1, 1]) == pytest.approx(slope, rel=1e-10)
    assert np.all(data.exponent[1, :, -1] > data.exponent[0, :, -1])


def planted(data, powers, *, grid=0.0):
    told = data.copy(deep=True)
    for n, power in enumerate(powers):
        told["exponent"][n] = power + np.array([-0.001, 0.001])[:, None] + np.array([grid, 0.0])[None, :]
    return told


def test_a_power_that_rises_by_more_than_it_is_uncertain_approaches_one(data):
    half = 12.706204736432095 * 0.001  # Student, one degree of freedom
    said = archard.findings(planted(data, (0.67, 0.9)))
    assert f"to the power 0.9 +- {half:.2g} (95 % over 2 positions" in said[1]
    assert said[-1].startswith("The power rises towards 1 with every level")
    assert "is not told to rise" in archard.findings(planted(data, (0.67, 0.68)))[-1]
    assert "is not told to rise" in archard.findings(planted(data, (0.67, 0.9), grid=0.3))[-1]
    assert "is not told to rise" in archard.findings(planted(data, (0.67, 1.2)))[-1]


def test_bumps_that_no_grid_resolves_are_refused():
    with pytest.raises(UsageError, match="take 512 points or more"):
        find_study("archard").parse(["--grids", "256,512"])
    with pytest.raises(UsageError, match="one for each of --waves"):
        find_study("archard").parse(["--waves", "16"])


def test_a_contact_of_a_few_points_has_no_area():
    light = Hierarchy(waves=(1,), heights=(1.0,), places=((0.3, 0.1),), loads=(1e-5, 0.02), points=32)
    first, second = light.measure().area.values
    assert np.isnan(first)
    assert second > 0


def test_table_and_figure_hold_every_case(data):
    assert len(archard.table(data).rows) == 6
    (drawing,) = archard.figures(data)
    assert drawing.name == "archard"
