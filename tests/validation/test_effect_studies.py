"""The studies of hardness and adhesion: limits they must meet, and sentences that follow from the numbers."""

import numpy as np
import pytest

from validation.errors import UsageError
from validation.studies import adhesion, find_study, hardness


@pytest.fixture(scope="module")
def yielding(bench):
    options = hardness.Options(
        reduced_pressures=(0.02, 0.2),
        magnifications=(1.5, 3.0),
        seed=13,
        surfaces=1,
        grids=(32, 64),
        periods=2.0,
        bandwidth=3.0,
        hardness=0.3,
    )
    return hardness.run(options, bench=bench)


@pytest.fixture(scope="module")
def sticking(bench):
    options = adhesion.Options(
        works=(1e-3, 0.1),
        reduced_pressures=(0.2,),
        magnifications=(3.0,),
        hardnesses=(0.6,),
        seed=13,
        surfaces=2,
        grids=(64, 96),
        bandwidth=3.0,
    )
    return adhesion.run(options, bench=bench)


def test_yielded_area_grows_with_load_and_theory_has_more_of_it(yielding):
    by_load = yielding.isel(case=(yielding.varied == "load").values)
    assert np.all(by_load.area_elastic + by_load.area_plastic < 1)
    assert np.all(by_load.area_plastic_persson > by_load.area_plastic)
    assert np.all(by_load.area_plastic_excess < 0)
    assert np.all(np.diff(by_load.area_plastic) > 0)


def test_as_waves_are_added_more_yields_and_the_last_is_the_whole_surface(yielding):
    few, all_waves = (
        yielding.isel(case=(yielding.varied == "waves").values).transpose("case", ...).area_plastic
    )
    elastic = yielding.area_elastic.values[yielding.varied == "waves"]
    assert few < all_waves
    assert elastic[0] > elastic[1]
    # All waves at p* = 0.1 lie between the loads 0.02 and 0.2 of the same surface.
    low, high = yielding.area_plastic.values[yielding.varied == "load"]
    assert low < all_waves < high
    theory = yielding.area_plastic_persson.values
    assert theory[0] < theory[-1] < theory[1]


def test_the_smoothed_surface_keeps_its_long_waves_and_loses_gradient_where_it_yielded(yielding):
    kept, theory = yielding.spectrum_kept.values, yielding.spectrum_kept_persson.values
    assert np.all(kept <= 1)
    assert np.all(np.diff(theory) < 0)
    # Persson smooths the whole surface, boundary elements a part of it.
    assert kept[-1] > theory[-1]
    assert 0 < yielding.gradient_kept < 0.8


@pytest.mark.parametrize("name", ["hardness", "adhesion"])
def test_a_magnification_beyond_the_bandwidth_is_refused(name):
    with pytest.raises(UsageError, match="magnifications = 5: must lie above 1, at most bandwidth = 4"):
        find_study(name).parse(["--magnifications", "5", "--bandwidth", "4"])


@pytest.mark.parametrize(
    ("name", "grids", "words"),
    [
        ("hardness", "64", "grids = 64: at least two"),
        ("hardness", "64,64", "grids = 64, 64: at least two"),
        ("adhesion", "96,64", "grids = 96, 64: must rise"),
    ],
)
def test_one_grid_has_no_limit(name, grids, words):
    with pytest.raises(UsageError, match=words):
        find_study(name).parse(["--grids", grids])


def along(data, dial):
    return data.isel(case=(data.varied == dial).values)


def test_adhesion_enlarges_the_contact_in_proportion_and_vanishes_with_the_work(sticking):
    by_work = along(sticking, "work")
    gain = by_work.area_gain.values
    assert 1 <= gain[0] < 1.1
    assert gain[1] > 1.2
    theory = by_work.area_gain_improved.values
    assert theory[0] == pytest.approx(1, abs=0.01)
    assert theory[1] > theory[0]
    assert np.all(sticking.attraction_range < 0.5)


def test_the_dials_meet_where_they_stand_for_the_same_case(sticking):
    # work = 0.1 at p* = 0.05 with all waves is the second work.
    same, waves = along(sticking, "work").isel(case=1), along(sticking, "waves").isel(case=0)
    for name in ("area", "area_plain", "area_improved", "interface_energy", "interface_energy_improved"):
        assert waves[name] == same[name]
    assert along(sticking, "load").area[0] > same.area


def test_the_interface_gains_less_than_its_work_and_yielding_adds_contact(sticking):
    by_work, hard = along(sticking, "work"), along(sticking, "hardness").isel(case=0)
    assert np.all(by_work.interface_energy < 1)
    assert by_work.interface_energy[1] > by_work.interface_energy[0]
    assert hard.area > by_work.area[1]
    assert 0 < hard.area_plastic < hard.area_plastic_improved


def test_numbers_of_one_surface_are_called_so(yielding, sticking):
    for study, data in ((hardness, yielding), (adhesion, sticking)):
        one, several = data.isel(surface=[0]), data.isel(surface=[0, 0])
        kinds = [[found.kind for found in study.views(these).findings] for these in (one, several)]
        assert [kind.count("note") for kind in kinds] == [1, 0]
