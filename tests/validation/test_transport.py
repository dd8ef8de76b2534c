"""What passes through contact and gap where a scene asks for it: with units, and nothing unless asked."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from small_scene import HARD, OBLONG, ensemble, scene_in

from fem_contact import HalfSpace, Solid, flow_conductance, frozen_contact, open_gap
from persson.leakage import effective_medium
from validation.comparison.numbers import scene_data
from validation.comparison.run import run_scene
from validation.errors import SceneError
from validation.execution.press import solves_of
from validation.scenes.problem import realise
from validation.scenes.scene import load_scene

ELECTRICAL = '[quantities.electrical]\nresistivity = ["17 nohm m", "0.4 uohm m"]\n'
THERMAL = '[quantities.thermal]\nconductivity = "4 W/(cm K)"\n'
LEAK = '[quantities.leak]\nviscosity = "2 mPa s"\npressure_drop = "3 kPa"\n'


@pytest.fixture
def written(tmp_path):
    def write(more="", *, pressure="10 kPa"):
        text = OBLONG.replace("10 kPa", pressure) + more
        (tmp_path / "mine.toml").write_text(text)
        return str(tmp_path / "mine.toml")

    return write


def read_off(scene):
    """Solve a scene, and return its dataset, and its solves with their results."""
    results = {solve: solve.do().contact for solve in solves_of(scene)}
    return scene_data(scene, realise(scene), results), results


def test_conductances_are_those_of_the_frozen_contact_in_the_units_of_the_scene(written):
    found, results = read_off(load_scene(written(ELECTRICAL + THERMAL)))
    solid = HalfSpace(solid=Solid(young=2e6, poisson=0.3))
    stiffness = {solve.grid: frozen_contact(result, solid).stiffness for solve, result in results.items()}
    fine = stiffness[48, 24]
    per = 2 / solid.contact_modulus
    electrical, thermal = found["electrical_conductance"], found["thermal_conductance"]
    assert_allclose(electrical, per * fine / (17e-9 + 0.4e-6), rtol=1e-9)
    half = found["electrical_conductance_error"].sel(source="grid")
    # Of what two coarser grids say, Student's of two samples.
    ratios = {(24, 12): 1 / 2, (32, 16): 2 / 3}
    samples = [(stiffness[grid] - fine) * ratio**1.5 for grid, ratio in ratios.items()]
    student = 4.302652729911275
    assert_allclose(half, student * per * np.sqrt(np.mean(np.square(samples))) / 0.417e-6, rtol=1e-6)
    assert electrical.attrs["units"] == "1/(ohm m^2)"
    assert_allclose(thermal, per * fine / (2 / 400), rtol=1e-9)  # 1/400 m K/W on each side


def test_the_leak_is_a_volume_per_time_through_one_period_along_either_axis(written):
    found, results = read_off(load_scene(written(LEAK)))
    finest = list(results.values())[-1]
    gap = open_gap(finest)
    for axis, along, across in (("x", 10e-6, 5e-6), ("y", 5e-6, 10e-6)):
        conductance = flow_conductance(gap, finest.lengths, axis=axis).conductance
        expected = conductance / 2e-3 * (3e3 / along) * across
        assert float(found[f"leak_rate_{axis}"]) == pytest.approx(expected, rel=1e-12, abs=0)


def test_the_mean_is_that_of_the_surfaces_of_the_ensemble_on_its_finest_grid(written):
    scene = load_scene(written(THERMAL + ensemble(3, "[[24, 12], [32, 16]]")))
    found, results = read_off(scene)
    solid = HalfSpace(solid=Solid(young=2e6, poisson=0.3))
    values = [frozen_contact(result, solid).stiffness for s, result in results.items() if s.grid == (32, 16)]
    assert len(values) == 3
    each = found["thermal_conductance_each"]
    assert each.values / each.values[0] == pytest.approx(np.array(values) / values[0], rel=1e-9)
    assert_allclose(found["thermal_conductance"], each.mean(), rtol=1e-12)
    half = 4.302652729911275 * float(each.std(ddof=1)) / 3**0.5
    error = found["thermal_conductance_error"]
    assert_allclose(error.sel(source="surfaces"), half, rtol=1e-9)
    own = found["thermal_conductance_own_error"].sel(source="grid") / found["thermal_conductance_own"]
    share = error.sel(source="grid") / found["thermal_conductance"]
    assert_allclose(share, own, rtol=1e-9)


def test_bruggeman_is_told_the_gaps_of_every_surface_of_an_ensemble(written):
    found, results = read_off(load_scene(written(LEAK + ensemble(3, "[[24, 12], [32, 16]]"))))
    gaps = [open_gap(result).ravel() for solve, result in results.items() if solve.grid == (32, 16)]
    media = [effective_medium(gap**3 / 12, np.full(gap.size, 1 / gap.size)) for gap in gaps]
    assert len({*media}) == 3
    assert_allclose(found["leak_rate_x_bruggeman"], np.mean(media) / 2e-3 * (3e3 / 10e-6) * 5e-6, rtol=1e-12)


def test_yielded_points_conduct_too(written):
    found, results = read_off(load_scene(written(THERMAL + HARD)))
    finest = list(results.values())[-1]
    assert finest.at_bound.any()
    solid = HalfSpace(solid=Solid(young=2e6, poisson=0.3))
    elastic_alone = frozen_contact(finest, solid).stiffness * 2 / solid.contact_modulus * 200
    assert float(found["thermal_conductance"]) > 1.01 * elastic_alone
    assert "thermal_conductance_persson" not in found  # the elastic theory says nothing of it


# At the second load the theory has a stiffness still, of 1e60 and more.
@pytest.mark.parametrize("pressure", ["1 GPa", "1.2 MPa"])
def test_complete_contact_conducts_without_bound_and_does_not_leak(written, tmp_path, pressure):
    scene = load_scene(written(THERMAL + LEAK, pressure=pressure))
    outputs = run_scene(scene, tmp_path / "out", report=False)
    assert np.isinf(outputs.data.thermal_conductance)
    assert float(outputs.data.leak_rate_x) == 0


def test_what_is_not_asked_for_is_not_there(written):
    scene = load_scene(written())
    assert scene.quantities is None
    assert "quantities" not in scene.model_dump(exclude_none=True)
    found, _ = read_off(scene)
    assert not any("conductance" in str(name) or "leak" in str(name) for name in found)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("[quantities]\n", "give at least one of the tables [quantities.electrical]"),
        ('[quantities.thermal]\nconductivity = "4 W/m"\n', "is not a thermal conductivity"),
        ('[quantities.leak]\nviscosity = "1 mPa s"\n', "quantities.leak.pressure_drop: missing"),
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
    with pytest.raises(SceneError, match="quantities: are read off a contact"):
        scene_in(tmp_path, text + THERMAL, name="alone")
