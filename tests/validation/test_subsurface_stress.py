"""The stress below a contact, as a scene asks for it: absent unless asked, refused before a solve."""

import meshio
import numpy as np
import pytest

from fem_contact import HalfSpace, strongest_point
from validation import press, self_affine
from validation.comparison.run import report_scene, run_scene
from validation.comparison.run_views import run_views
from validation.errors import SceneError, UsageError
from validation.execution.press import solves_of
from validation.execution.store import Store
from validation.scenes.checks import check_scene
from validation.scenes.problem import realise
from validation.scenes.scene import Scene, load_scene
from validation.scenes.sweep import load_asked

ROUGH = {"length": "4 um", "lambda_long": "2 um", "lambda_short": "0.5 um"}
ROUGH |= {"hurst": 0.8, "rms_gradient": 0.1, "seed": 8}
PLAIN = {"name": "asked", "surface": {"kind": "self-affine", **ROUGH}, "load": {"reduced_pressure": 0.1}}
PLAIN |= {"solid": {"young": "1 GPa", "poisson": 0.3}, "methods": {"bem": {"grids": [24, 32]}}}
DEPTHS = ["0 um", "0.05 um", "0.1 um", "0.2 um", "0.4 um"]


def asked(**changed):
    quantities = {"subsurface": {"depths": DEPTHS, "vtu": True}}
    return Scene.model_validate(PLAIN | {"quantities": quantities} | changed)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return run_scene(asked(), tmp_path_factory.mktemp("asked"), report=False)


def test_a_run_says_where_the_solid_yields_first(run):
    coarse, fine = run.data.von_mises.sel(solver="bem").values
    (found,) = [f for f in run_views(run.data).findings if "von Mises" in f.text]
    assert found.values["von_mises"].value == fine
    assert found.values["von_mises_change"].value == pytest.approx(fine / coarse - 1, rel=1e-12)
    assert 0.05e-6 < float(run.data.von_mises_depth.sel(solver="bem")[-1]) < 0.4e-6
    assert any(table.title == "Below the surface" for table in run.page.tables)


def test_the_number_is_that_of_the_pressures_on_the_finest_grid(run):
    scene, fine = asked(), run.data.sel(solver="bem").isel(grid=-1)
    solve = solves_of(scene)[-1]
    contact = Store(folder=run.folder / "solves").read(solve).result
    depths = scene.subsurface.depths[1:]
    point = strongest_point(contact, HalfSpace(solid=realise(scene).elastic), depths=depths)
    told = [float(fine[f"von_mises{end}"]) for end in ("", "_depth", "_x", "_y")]
    assert told == [point.von_mises, point.depth, *point.place]


def test_the_fields_are_written_for_the_finest_grid_and_again_by_report(run):
    def stress():
        (path,) = (run.folder / "fields").glob("*-below.vtu")
        assert path.name == "bem-32x32-below.vtu"
        mesh = meshio.read(path)
        assert mesh.point_data["stress"].shape == (33 * 33 * len(DEPTHS), 6)
        return mesh.point_data["stress"]

    before = stress()
    np.testing.assert_array_equal((report_scene(run.folder), stress())[1], before)


def test_a_scene_that_does_not_ask_has_nothing_of_it(small_run):
    assert "von_mises" not in small_run.data
    assert not any("von Mises" in text for text in small_run.page.findings)
    assert not any("-below" in path.name for path in small_run.files)


def test_a_key_on_the_command_line_asks(tmp_path):
    assert load_scene("quickstart").subsurface is None
    loaded = load_asked("quickstart", ["quantities.subsurface.vtu=true"])
    assert (loaded.subsurface.vtu, loaded.subsurface.depths) == (True, None)
    with pytest.raises(SceneError, match=r"subsurface: depths = .*: must rise"):
        load_asked("quickstart", ['quantities.subsurface.depths=["1 um", "0.5 um"]'])


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"methods": {"fem": {"grids": [24]}}}, r"subsurface: .* add \[methods.bem\]"),
        ({"effects": [{"kind": "thickness", "thickness": "0.3 um"}]}, r"0.4 um, lies below the base of the"),
    ],
)
def test_what_has_no_answer_is_refused_before_anything_is_solved(changed, words):
    scene = asked(**changed)
    with pytest.raises(UsageError, match=words):
        check_scene(scene, realise(scene))


def test_a_pressed_surface_gives_the_same_in_a_line(tmp_path):
    surface = self_affine(**ROUGH)
    contact = press(surface, young="1 GPa", poisson=0.3, reduced_pressure=0.1, grid=24)
    below = contact.below([0.0, 1e-7])
    np.testing.assert_allclose(below.stress[:, :, 0, 2], -contact.result.pressure, atol=1e-9 * 1e9)
    assert contact.to_vtu(tmp_path / "below.vtu").stat().st_size > 10_000
    meshed = press(surface, young="1 GPa", poisson=0.3, reduced_pressure=0.1, grid=24, method="fem")
    with pytest.raises(UsageError, match="meshes its body"):
        meshed.below()
