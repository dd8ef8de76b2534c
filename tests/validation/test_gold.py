"""The gold numbers themselves: there is one of everything, a changed number is found, a renamed one again."""

import copy

import numpy as np
import pytest
import xarray as xr
from gold import check, make, shown
from gold.asked import COMPARED, SCENES, STUDIES

from validation.report.quantities import quantity
from validation.scenes.scene import builtin_scenes
from validation.studies import studies

ALL = (*STUDIES, *SCENES, *COMPARED)
DATA = xr.Dataset(
    {"kappa": (("load", "surface"), [[2.0, 2.5, 1.5], [1.8, np.nan, 1.7]])}, coords={"load": [0.1, 0.2]}
)


def told(gold, new, data=DATA, rtol=check.RTOL_HERE):
    return list(check.differences("planted", gold, new, data, rtol=rtol))


# From the end on: other files ask for the studies from the beginning, and who is second waits.
@pytest.mark.parametrize("name", ALL[::-1])
def test_the_numbers_are_those_of_the_gold_file(name, bench, numbers, tmp_path):
    assert check.disagreements(name, bench, tmp_path, known=numbers) == []


#: Studies work with ratios, which no choice of units changes, but for these quantities, times and bytes.
IN_UNITS = {"heights": {"rms_height"}, "sliding": {"velocity"}}


@pytest.mark.parametrize("name", STUDIES)
def test_what_has_a_unit_in_a_study_depends_on_the_units_that_were_asked_for(name, numbers):
    found = set()
    for name_, variable in numbers(name).variables.items():
        if variable.attrs.get("units", "1") not in ("1", "s", "byte"):
            found.add(quantity(str(name_).removesuffix("_error").removesuffix("_each")).name)
    assert found == IN_UNITS.get(name.partition(" ")[0], set())


@pytest.mark.parametrize("scene", builtin_scenes())
def test_what_is_explained_of_a_scene_is_what_it_was(scene):
    assert list(shown.differences(f"explain {scene}", shown.explained(scene))) == []


def test_every_study_and_every_scene_of_the_library_has_gold_numbers():
    assert {name.partition(" ")[0] for name in STUDIES} == set(studies())
    assert {scene for scene, _ in SCENES.values()} >= set(builtin_scenes())
    assert {path.name.removesuffix(".json.xz") for path in make.FOLDER.iterdir()} == {
        name.replace(" ", "-") for name in ALL
    }


@pytest.mark.parametrize("name", ["autopsy", "pressure", "scene quickstart"])
def test_any_number_that_moves_by_a_billionth_or_goes_is_found(name):
    for place, entry in {**make.read(name)["record"], **shown.read_said()["said"][name]}.items():
        if "numbers" not in entry:  # words are kept to be read
            continue
        numbers = np.array(entry["numbers"], dtype=float)
        assert told({place: entry}, {place: entry}) == []
        assert len(told({place: entry}, {}, xr.Dataset())) == 1
        if entry["dims"]:
            assert len(told({place: entry}, {place: {**entry, "dims": [*entry["dims"][:-1], "other"]}})) == 1
        if np.isfinite(numbers).any():
            k = int(np.nanargmax(np.abs(np.where(np.isfinite(numbers), numbers, np.nan))))
            for value in (numbers[k] * (1 + 1e-9) or 1e-9, np.nan):
                moved = copy.deepcopy(entry)
                moved["numbers"][k] = value
                assert len(told({place: entry}, {place: moved})) == 1, place


def test_a_number_that_is_not_stored_itself_is_found_by_the_sums():
    values = np.sin(np.arange(5000.0))
    moved = values.copy()
    moved[7] += 1e-9
    gold, new = ({"data.long": {"dims": ["x"], **make.numbers_of(one)}} for one in (values, moved))
    assert 7 % gold["data.long"]["every"]
    assert told(gold, gold) == []
    assert len(told(gold, new)) >= 1


def test_a_renamed_number_is_found_through_the_map_whatever_the_order_of_its_dimensions(monkeypatch):
    gold = {
        "data.kappa": {"dims": ["surface", "load"], **make.numbers_of(DATA.kappa.T)},
        "figure.old.kappa": {"dims": ["load", "surface"], **make.numbers_of(DATA.kappa)},
        "table.+- (95 %)": {"dims": ["row"], **make.numbers_of(1.96 * DATA.kappa.max("surface"))},
    }
    new = DATA.rename(kappa="secant")
    assert len(told(gold, {}, new)) == 3
    names = {"data.kappa": "secant", "table.+-*": lambda d: 1.96 * d.secant.max("surface")}
    monkeypatch.setattr(check, "maps_of", lambda name: (names, {}))
    assert told(gold, {}, new) == []
    assert len(told(gold, {}, new * (1 + 1e-9))) == 3
    changed = {"table.*": "Student's factor"}
    monkeypatch.setattr(check, "maps_of", lambda name: (names, changed))
    assert len(told(gold, {}, new * (1 + 1e-9))) == 2
