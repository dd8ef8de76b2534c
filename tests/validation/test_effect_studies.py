"""The studies of hardness and adhesion: limits they must meet, and sentences that follow from the numbers."""

import numpy as np
import pytest

from validation.errors import UsageError
from validation.solves.bench import Bench
from validation.studies import adhesion, find_study, hardness


@pytest.fixture(scope="module")
def yielding(tmp_path_factory):
    bench = Bench.at(tmp_path_factory.mktemp("hardness"))
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
def sticking(tmp_path_factory):
    bench = Bench.at(tmp_path_factory.mktemp("adhesion"))
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


def test_adhesion_enlarges_the_contact_in_proportion_and_vanishes_with_the_work(sticking):
    gain = sticking["area"].values / sticking["plain"].values
    assert 1 <= gain[0] < 1.1
    assert gain[1] > 1.2
    theory = sticking["improved"].values / sticking["persson_plain"].values
    assert theory[0] == pytest.approx(1, abs=0.01)
    assert theory[1] > theory[0]
    assert np.all(sticking["reach"].values < 0.5)


def test_the_dials_meet_where_they_stand_for_the_same_case(sticking):
    # work = 0.1 at p* = 0.05 with all waves is the second work.
    for name in ("area", "plain", "improved", "interface", "macroscopic"):
        assert sticking[f"{name}_magnification"].values[0] == sticking[name].values[1]
    assert sticking["area_reduced_pressure"].values[0] > sticking["area"].values[1]


def test_the_interface_gains_less_than_its_work_and_yielding_adds_contact(sticking):
    assert np.all(sticking["interface"].values < 1)
    assert sticking["interface"].values[1] > sticking["interface"].values[0]
    assert sticking["area_hardness"].values[0] > sticking["area"].values[1]
    assert 0 < sticking["yielded_hardness"].values[0] < sticking["yielded_persson_hardness"].values[0]


def test_findings_of_adhesion_say_where_the_theory_gives_no_answer(sticking):
    assert "multiplies the area by" in adhesion.findings(sticking)[1]
    silent = sticking.assign(old=np.nan * sticking["old"])
    assert "the theory (old) gives no answer" in adhesion.findings(silent)[1]


def test_adhesion_is_averaged_over_surfaces_and_its_error_holds_their_scatter(sticking, tmp_path):
    assert adhesion.findings(sticking)[0].startswith("Means over 2 surfaces")
    assert "mean over 2 surfaces" in adhesion.figures(sticking)[0].caption
    options = {"works": (0.1,), "reduced_pressures": (0.2,), "magnifications": (3.0,), "hardnesses": (0.6,)}
    options |= {"grids": (64, 96), "bandwidth": 3.0, "surfaces": 1}
    bench = Bench.at(tmp_path)
    single = [adhesion.run(adhesion.Options(**options, seed=seed), bench=bench) for seed in (13, 14)]
    areas = [float(one["area"][0]) for one in single]
    assert float(sticking["area"][1]) == pytest.approx(np.mean(areas), rel=1e-12)
    grids = np.mean([float(one["area_error"][0]) for one in single])
    scatter = np.std(areas, ddof=1) / np.sqrt(2)
    assert scatter > 0
    assert float(sticking["area_error"][1]) == pytest.approx(np.hypot(grids, scatter), rel=1e-12)
    assert "of one surface" in adhesion.findings(single[0])[0]


def test_adhesion_is_found_by_name_and_draws(sticking):
    assert [d.name for d in find_study("adhesion").figures(sticking)] == [
        "adhesive-area",
        "adhesive-area-reduced-pressure",
        "adhesive-area-magnification",
        "adhesive-area-hardness",
        "adhesive-area-yielded",
        "interface-energy",
    ]
