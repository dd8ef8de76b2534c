"""The studies of hardness and adhesion: limits they must meet, and sentences that follow from the numbers."""

import pytest

from validation.errors import UsageError
from validation.studies import adhesion, find_study, hardness


@pytest.fixture(scope="module")
def yielding(numbers):
    return numbers("hardness")


@pytest.fixture(scope="module")
def sticking(numbers):
    return numbers("adhesion")


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


def test_the_dials_meet_where_they_stand_for_the_same_case(sticking):
    # work = 0.1 at p* = 0.05 with all waves is the second work.
    same, waves = along(sticking, "work").isel(case=1), along(sticking, "waves").isel(case=-1)
    for name in ("area", "area_plain", "area_improved", "interface_energy", "interface_energy_improved"):
        assert waves[name] == same[name]
    assert along(sticking, "load").area[-1] > same.area


def test_numbers_of_one_surface_are_called_so(yielding, sticking):
    for study, data in ((hardness, yielding), (adhesion, sticking)):
        one, several = data.isel(surface=[0]), data.isel(surface=[0, 0])
        kinds = [[found.kind for found in study.views(these).findings] for these in (one, several)]
        assert [kind.count("note") for kind in kinds] == [1, 0]
