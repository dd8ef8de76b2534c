"""The studies of hardness and adhesion: limits they must meet, and sentences that follow from the numbers."""

import pytest

from validation.studies import adhesion, hardness


@pytest.fixture(scope="module")
def yielding(numbers):
    return numbers("hardness")


@pytest.fixture(scope="module")
def sticking(numbers):
    return numbers("adhesion")


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
