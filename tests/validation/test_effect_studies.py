"""The studies of hardness and adhesion: limits they must meet, and sentences that follow from the numbers."""

import numpy as np
import pytest

from validation.bench import Bench
from validation.errors import UsageError
from validation.studies import adhesion, find_study, hardness


@pytest.fixture(scope="module")
def yielding(tmp_path_factory):
    bench = Bench.at(tmp_path_factory.mktemp("hardness"))
    return hardness.run(
        bench=bench,
        pressures=(0.02, 0.2),
        seeds=(13,),
        grids=(32, 64),
        periods=2.0,
        bandwidth=3.0,
        hardness=0.3,
    )


@pytest.fixture(scope="module")
def sticking(tmp_path_factory):
    bench = Bench.at(tmp_path_factory.mktemp("adhesion"))
    return adhesion.run(bench=bench, works=(1e-3, 0.1), seed=13, grid=64, bandwidth=3.0)


def test_yielded_area_grows_with_load_and_theory_has_more_of_it(yielding):
    assert np.all(yielding["elastic"].values + yielding["plastic"].values < 1)
    assert np.all(yielding["plastic_persson"] > yielding["plastic"])
    assert np.all(np.diff(yielding["plastic"].values) > 0)


def test_findings_of_hardness_turn_with_the_numbers(yielding):
    above = hardness.findings(yielding)
    assert all("above it" in sentence for sentence in above)
    swapped = yielding.assign(
        plastic_persson=yielding["plastic"] / 2, elastic_persson=yielding["elastic"] / 2
    )
    assert all("50 % below it" in sentence for sentence in hardness.findings(swapped))


def test_one_grid_has_no_limit(tmp_path):
    with pytest.raises(UsageError, match=r"--grids = \(64,\): at least two"):
        hardness.run(bench=Bench.at(tmp_path), grids=(64,))


def test_adhesion_enlarges_the_contact_in_proportion_and_vanishes_with_the_work(sticking):
    gain = sticking["area"].values / sticking["plain"].values
    assert 1 <= gain[0] < 1.1
    assert gain[1] > 1.2
    theory = sticking["improved"].values / sticking["persson_plain"].values
    assert theory[0] == pytest.approx(1, abs=0.01)
    assert theory[1] > theory[0]
    assert np.all(sticking["reach"].values < 0.5)


def test_findings_of_adhesion_say_where_the_theory_gives_no_answer(sticking):
    assert "multiplies the area by" in adhesion.findings(sticking)[0]
    silent = sticking.assign(old=np.nan * sticking["old"])
    assert "the theory (old) gives no answer" in adhesion.findings(silent)[0]


def test_both_are_found_by_name_and_draw(yielding, sticking):
    assert [d.name for d in find_study("hardness").figures(yielding)] == ["plastic-area", "elastic-area"]
    assert [d.name for d in find_study("adhesion").figures(sticking)] == ["adhesive-area"]
