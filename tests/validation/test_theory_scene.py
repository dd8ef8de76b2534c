"""Theory scenes: the paper's applications, effects listed and not, mistakes named."""

import subprocess
import sys

import pytest

from validation.errors import SceneError
from validation.paper.theory_scene import load_theory_scene, run_theory_scene, theory_scenes

RIM = """
name = "mine"
q_reference = "1e5 m^-1"
[surface]
kind = "self-affine"
hurst = 0.8
q_long = "1e5 m^-1"
q_short = "1e10 m^-1"
rms_height = "0.5 um"
[solid]
young = "10 MPa"
poisson = 0.5
[load]
pressures = ["0.5 MPa"]
"""


@pytest.fixture
def scene(tmp_path):
    def write(text):
        path = tmp_path / "mine.toml"
        path.write_text(text, encoding="utf-8")
        return load_theory_scene(str(path))

    return write


def test_the_applications_of_the_paper_are_there():
    assert set(theory_scenes()) == {"pmma-silane", "polished-steel", "pyrex", "pyrex-squeezed", "tire-rim"}


def test_tire_rim_gives_the_paper_s_area(tmp_path):
    results = run_theory_scene(load_theory_scene("tire-rim"), tmp_path / "out")
    areas = {r.pressure: r.area[-1] for r in results}
    assert areas[5e5] == pytest.approx(0.4355, abs=2e-4)
    lines = (tmp_path / "out" / "areas.csv").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 1 + len(results)
    assert (tmp_path / "out" / "magnification.csv").stat().st_size > 1000


def test_steel_yields_and_pyrex_sticks_only_after_squeezing():
    steel = run_theory_scene(load_theory_scene("polished-steel"))
    assert steel[1].area_plastic[-1] == pytest.approx(10e6 / 2e9, rel=0.01)
    (before,) = run_theory_scene(load_theory_scene("pyrex"))
    (after,) = run_theory_scene(load_theory_scene("pyrex-squeezed"))
    assert before.area[-1] == 0
    assert after.area[-1] > 0.9
    assert after.macroscopic_work / 0.43 == pytest.approx(0.45, abs=0.02)


def test_pmma_carries_its_area_by_adhesion():
    results = run_theory_scene(load_theory_scene("pmma-silane"))
    assert all(r.area[-1] > 0.8 for r in results)


def test_without_effects_the_contact_is_elastic(scene):
    (result,) = run_theory_scene(scene(RIM))
    assert result.area[-1] == pytest.approx(0.060086, abs=5e-7)
    assert result.work is None
    assert result.error_estimate == 0


def test_every_effect_changes_the_result(scene):
    (plain,) = run_theory_scene(scene(RIM))
    for effect in (
        'kind = "adhesion"\nwork_of_adhesion = "0.01 J/m^2"',
        'kind = "hardness"\nyield_stress = "5 MPa"',
        'kind = "hardness"\nyield_stress = "5 MPa"\nsize_wavevector = "1e7 m^-1"\nsize_exponent = 0.1',
        'kind = "graded"\nlayer_young = "2 MPa"\nthickness = "10 um"',
        'kind = "smoothing"\npressure = "0.5 MPa"\nyield_stress = "5 MPa"',
    ):
        (changed,) = run_theory_scene(scene(f"{RIM}\n[[effects]]\n{effect}\n"))
        assert changed.area[-1] > 1.01 * plain.area[-1], effect


def test_what_is_not_listed_is_not_imported(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(RIM, encoding="utf-8")
    code = (
        "import sys\n"
        "from validation.paper.theory_scene import load_theory_scene, run_theory_scene\n"
        f"run_theory_scene(load_theory_scene({str(path)!r}))\n"
        "unwanted = {'numba', 'matplotlib', 'persson.adhesion', 'persson.hardness', 'persson.graded'}\n"
        "print(sorted(unwanted & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("hurst = 0.8", "hurst = 1.8", "hurst"),
        ('rms_height = "0.5 um"', 'rms_height = "0.5 s"', "rms_height"),
        ('rms_height = "0.5 um"', "", "rms_height"),
        ('q_short = "1e10 m^-1"', 'q_short = "1e4 m^-1"', "q_short"),
        ('pressures = ["0.5 MPa"]', "pressures = [0.0]", "adhesion"),
        ('pressures = ["0.5 MPa"]', "pressures = []", "pressures"),
        ("poisson = 0.5", "poisson = 0.7", "poisson"),
        ("poisson = 0.5", "poisson = 0.5\ncolour = 3", "colour"),
        ("[load]", '[[effects]]\nkind = "magnetism"\n[load]', "effects"),
        ("hurst = 0.8", "hurst = ", "TOML"),
    ],
)
def test_mistakes_are_named(scene, old, new, named):
    with pytest.raises(SceneError, match=named):
        scene(RIM.replace(old, new))


def test_an_effect_listed_twice_and_an_unknown_scene_are_named(scene):
    twice = '\n[[effects]]\nkind = "hardness"\nyield_stress = "5 MPa"\n' * 2
    with pytest.raises(SceneError, match="2 times"):
        scene(RIM + twice)
    with pytest.raises(SceneError, match="tire-rim"):
        load_theory_scene("tyre-rim")
    with pytest.raises(SceneError, match="read"):
        load_theory_scene("nowhere.toml")
