"""What passes through contact and gap where a scene asks for it: with units, and nothing unless asked."""

import json

import numpy as np
import pytest
from small_scene import OBLONG

from fem_contact import HalfSpace, flow_conductance, frozen_contact, open_gap
from fem_contact.solid import Solid
from validation.comparison.passing import passing
from validation.comparison.run import load_run, run_scene
from validation.comparison.sweep import run_sweep
from validation.errors import SceneError
from validation.scenes.realised import realise
from validation.scenes.scene import load_scene
from validation.scenes.sweep import load_asked
from validation.solves.press import solves_of
from validation.solves.running import Solves

ELECTRICAL = '[quantities.electrical]\nresistivity = ["17 nohm m", "0.4 uohm m"]\n'
THERMAL = '[quantities.thermal]\nconductivity = "4 W/(cm K)"\n'
LEAK = '[quantities.leak]\nviscosity = "2 mPa s"\npressure_drop = "3 kPa"\n'
ENSEMBLE = "[ensemble]\nrealisations = 3\ngrids = [[24, 12], [32, 16]]\n"


@pytest.fixture
def written(tmp_path):
    def write(more="", *, pressure="10 kPa"):
        text = OBLONG.replace("10 kPa", pressure) + more
        (tmp_path / "mine.toml").write_text(text)
        return str(tmp_path / "mine.toml")

    return write


def read_off(scene):
    """Solve a scene, and return what passes by name, and its solves with their results."""
    results = {solve: solve.do().contact for solve in solves_of(scene)}
    return {one.name: one for one in passing(scene, realise(scene), results)}, results


def test_conductances_are_those_of_the_frozen_contact_in_the_units_of_the_scene(written):
    found, results = read_off(load_scene(written(ELECTRICAL + THERMAL)))
    solid = HalfSpace(solid=Solid(young=2e6, poisson=0.3))
    coarse, fine = (frozen_contact(result, solid).stiffness for result in list(results.values())[1:])
    per = 2 / solid.contact_modulus
    electrical, thermal = found["electrical_conductance"], found["thermal_conductance"]
    assert electrical.value == pytest.approx(per * fine / (17e-9 + 0.4e-6), rel=1e-9)
    assert electrical.grid_error == pytest.approx(per * abs(fine - coarse) / 0.417e-6, rel=1e-6)
    assert electrical.unit == "1/(ohm m^2)"
    assert thermal.value == pytest.approx(per * fine / (2 / 400), rel=1e-9)  # 1/400 m K/W on each side
    assert thermal.grid == (48, 24)


def test_the_leak_is_a_volume_per_time_through_one_period_along_either_axis(written):
    found, results = read_off(load_scene(written(LEAK)))
    finest = list(results.values())[-1]
    gap = open_gap(finest)
    for axis, along, across in (("x", 10e-6, 5e-6), ("y", 5e-6, 10e-6)):
        conductance = flow_conductance(gap, finest.lengths, axis=axis).conductance
        expected = conductance / 2e-3 * (3e3 / along) * across
        assert found[f"leak_rate_{axis}"].value == pytest.approx(expected, rel=1e-12, abs=0)


def test_the_scatter_is_that_of_the_surfaces_of_the_ensemble_on_its_finest_grid(written):
    scene = load_scene(written(THERMAL + ENSEMBLE))
    found, results = read_off(scene)
    solid = HalfSpace(solid=Solid(young=2e6, poisson=0.3))
    values = [frozen_contact(result, solid).stiffness for s, result in results.items() if s.grid == (32, 16)]
    assert len(values) == 3
    one = found["thermal_conductance"]
    assert one.surfaces == 3
    assert one.scatter == pytest.approx(np.std(values, ddof=1) / np.mean(values), rel=1e-9)


def test_yielded_points_conduct_too(written):
    yields = '[[effects]]\nkind = "hardness"\nhardness = "60 kPa"\n'
    found, results = read_off(load_scene(written(THERMAL + yields)))
    finest = list(results.values())[-1]
    assert finest.at_bound.any()
    solid = HalfSpace(solid=Solid(young=2e6, poisson=0.3))
    elastic_alone = frozen_contact(finest, solid).stiffness * 2 / solid.contact_modulus * 200
    assert found["thermal_conductance"].value > 1.01 * elastic_alone
    assert np.isnan(found["thermal_conductance"].theory)  # the elastic theory says nothing of it


def test_complete_contact_conducts_without_bound_and_does_not_leak(written, tmp_path):
    scene = load_scene(written(THERMAL + LEAK, pressure="1 GPa"))
    outputs = run_scene(scene, tmp_path / "out", report=False)
    said = " ".join(outputs.comparison.findings)
    assert "thermal conductance of the contact is infinite: contact is complete" in said
    assert "The leak through one period along x is 0 m^3/s: closed, no path leads through" in said


def test_page_and_records_have_the_quantities_with_unit_and_uncertainty_and_can_be_made_again(
    written, tmp_path
):
    scene = load_scene(written(ELECTRICAL + LEAK))
    outputs = run_scene(scene, tmp_path / "out", report=False)
    (electrical, *_) = found = outputs.comparison.passing
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["quantities"][0]["value"] == electrical.value
    assert summary["quantities"][0]["unit"] == "1/(ohm m^2)"
    (table,) = (t for t in outputs.page.tables if t.title == "What passes through contact and gap")
    assert [row[:2] for row in table.rows] == [(one.words, one.unit) for one in found]
    assert " +- " in table.rows[0][2]
    assert any("electrical conductance" in said and " +- " in said for said in outputs.comparison.findings)
    asked, store = load_run(tmp_path / "out")
    assert asked.quantities.electrical.resistivity == (1.7e-8, 4e-7)
    stored = Solves(solves=solves_of(asked), store=store)
    assert repr(passing(asked, realise(asked), stored)) == repr(found)


def test_a_sweep_has_them_over_the_load(written, tmp_path):
    asked = load_asked(written(THERMAL + '[sweep]\nmode = "zip"\n"load.pressure" = ["5 kPa", "10 kPa"]\n'))
    data = run_sweep(asked, tmp_path / "out", report=False).data
    assert data.thermal_conductance.attrs["units"] == "W/(m^2 K)"
    light, heavy = data.thermal_conductance.values
    assert heavy > 1.5 * light


def test_what_is_not_asked_for_is_not_there(written):
    scene = load_scene(written())
    assert scene.quantities is None
    assert "quantities" not in scene.model_dump(exclude_none=True)
    assert passing(scene, realise(scene), {}) == ()


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("[quantities]\n", "give at least one of the tables [quantities.electrical]"),
        ('[quantities.thermal]\nconductivity = "4 W/m"\n', "is not a thermal conductivity"),
        (
            '[quantities.leak]\nviscosity = "1 mPa s"\n',
            "quantities.leak.pressure_drop: missing; of the fluid",
        ),
        ('[quantities.electrical]\nresistivity = "-1 ohm m"\n', "greater than 0"),
        ("[quantities.leek]\nviscosity = 1.0\n", "did you mean 'leak'?"),
    ],
)
def test_a_table_that_says_too_little_or_something_else_is_refused(written, more, said):
    with pytest.raises(SceneError) as refused:
        load_scene(written(more))
    assert said in str(refused.value)


def test_the_theory_alone_has_no_contact_to_read_them_off(written, tmp_path):
    text = OBLONG.replace("[methods.bem]\ngrids = [[24, 12], [32, 16], [48, 24]]", "[methods.theory]")
    (tmp_path / "alone.toml").write_text(text + THERMAL)
    with pytest.raises(SceneError, match="quantities: are read off a contact"):
        load_scene(str(tmp_path / "alone.toml"))
