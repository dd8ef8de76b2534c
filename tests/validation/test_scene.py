"""Scenes: units are converted once and exactly; a mistake is one line: key, value and what is allowed."""

import json
import re
import tomllib
from fractions import Fraction
from pathlib import Path
from typing import Annotated

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError
from refusing import refused
from small_scene import GRIDS, scene_in, square_scene

from validation import units
from validation.comparison.explain import explain
from validation.comparison.run import run_scene
from validation.errors import SceneError, UsageError
from validation.execution.attempt import Progress
from validation.execution.bench import Bench
from validation.scenes.checks import check_scene
from validation.scenes.keys import scene_keys
from validation.scenes.mistakes import problems
from validation.scenes.problem import realise
from validation.scenes.scene import Scene, builtin_scenes, load_scene, usual_grids
from validation.scenes.sweep import load_asked
from validation.solvers import find_method

LOAD = "reduced_pressure = 0.1"
WRONG = [
    # what is replaced, by what, words of the message
    ("[load]", '[quantities.subsurface]\ndepths = "1 um"\n[load]', "depths = '1 um'", "a list in brackets"),
    ("[load]", '[quantities.electrical]\nresistivity = "3 V"\n[load]', "= '3 V': is not a resistivity"),
    ("[load]", "[quantities.subsurface]\ndepths = []\n[load]", "depths = []", "at least 2 values"),
    ("hurst = 0.7", "", "surface.hurst: missing", "[0, 1]"),
    ("[load]", '[[effects]]\nkind = "thickness"\n[load]', "[[effects]] 1 thickness: missing", "of the layer"),
    ("[load]", "[sweeps]\n[load]", "unknown key 'sweeps'; did you mean 'sweep'?", "run, sweep"),
    ("hurst = 0.7", "hurts = 0.7", "unknown key 'hurts'", "did you mean 'hurst'?"),
    ("hurst = 0.7", "hurst = 0.7\nlay = 2", "unknown key 'lay'", "did you mean 'stretch'?"),
    ("hurst = 0.7", "hurst = 0.7\nanisotropy = 2", "unknown key 'anisotropy'", "did you mean 'stretch'?"),
    ("hurst = 0.7", "hurst = 1.2", "surface.hurst = 1.2", "less than or equal to 1"),
    ("hurst = 0.7", "hurst = nan", "surface.hurst = nan", "finite"),
    ("hurst = 0.7", 'hurst = "0.7"', "surface.hurst = '0.7'", "number"),
    ('young = "2 MPa"', 'young = "2 kg"', "solid.young = '2 kg'", "is not a pressure"),
    ('young = "2 MPa"', 'young = "2 MPaa"', "solid.young = '2 MPaa'", "unknown unit"),
    ('young = "2 MPa"', 'young = "2"', "solid.young = '2'", "has no unit", "or a number in Pa without quo"),
    ('young = "2 MPa"', 'young = "-2 MPa"', "solid.young = '-2 MPa'", "greater than 0"),
    ("poisson = 0.3", "poisson = 0.62", "solid.poisson = 0.62", "less than or equal to 0.5"),
    (LOAD, "reduced_pressure = -0.1", "load.reduced_pressure = -0.1", "greater than or equal to 0"),
    (LOAD, 'pressure = "-3 MPa"', "load.pressure = '-3 MPa'", "greater than or equal to 0"),
    (LOAD, "", "load: give exactly one of 'pressure', 'reduced_pressure', 'force', 'mean_", "found none"),
    ('lambda_short = "2.5 um"', 'lambda_short = "6 um"', "lambda_short = 6 um", "must be below"),
    ('lambda_long = "5 um"', "lambda_long = 11.1234567e-6", "lambda_long = 11.1235 um", "must not exceed"),
    (GRIDS, "grids = [8, 24]", "methods.bem.grids = [8, 8]", "at least [9, 5]", "under_resolved"),
    (GRIDS, "grids = []", "methods.bem.grids", "at least 1"),
    (GRIDS, "grids = [12.5]", "methods.bem.grids (item 1) = 12.5", "whole number"),
    (GRIDS, "grids = 48", "methods.bem.grids = 48", "must be a list of grids such as [48]"),
    ('length = ["10 um", "5 um"]', "length = 100", "methods.bem.grids = [12, 8]: too", "read as 100 m"),
    ("[load]", "[laod]", "unknown key 'laod'", "did you mean 'load'?"),
    ("[solid]", '[[effects]]\nkind = "magnetism"\n[solid]', "[[effects]] 1 kind = 'magnetism'", "'hardness'"),
    ('kind = "self-affine"', "", "surface.kind: missing", "self-affine"),
    ('name = "small"', 'name = "../up"', "name = '../up'"),
    (
        f"[methods.bem]\n{GRIDS}\nshifts = 2",
        "[ensemble]\nrealisations = 2\ngrids = [12, 24]",
        "ensemble: add the table of a method that is quick enough for it: bem",
    ),
]


@pytest.mark.parametrize("wrong", WRONG, ids=[" ".join(words) for _, _, *words in WRONG])
def test_a_wrong_scene_gives_one_line_naming_key_value_and_what_is_allowed(write_scene, wrong):
    old, new, *words = wrong
    path = write_scene((old, new))
    with refused(SceneError, re.escape(str(path))) as caught:
        load_scene(str(path))
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(("key", "info"), scene_keys({}).items(), ids=scene_keys({}))
def test_every_key_has_a_meaning_and_an_example_that_it_takes(key, info):
    assert info.description
    example = tomllib.loads(f"key = {units.example_of(info)}")["key"]
    TypeAdapter(Annotated[info.annotation, info]).validate_python(example)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (("load.pressure=1e3", "force=1e-9"), "load.force: excludes load.pressure, which is set, too"),
        (("force=1e-9", "force=2e-9"), "load.force: is set twice"),
        (("sweep.force=[1e-9]", "load.pressure=1e3"), "load.pressure: excludes load.force, which is swept"),
        (("rms_gradient=0.1", "rms_height='1 nm'"), "surface.rms_height: excludes surface.rms_gradient"),
    ],
)
def test_settings_that_contradict_each_other_are_refused(write_scene, settings, words):
    with pytest.raises(UsageError, match=f"^--set {words}"):
        load_asked(str(write_scene()), settings)


def test_grids_that_nobody_names_have_4_8_and_16_points_on_the_shortest_wave(write_scene):
    path = str(write_scene((GRIDS, ""), "[ensemble]\nrealisations = 2\n", fem=False))
    scene = load_scene(path)
    assert scene.methods.bem.grids == usual_grids(scene.surface.length, scene.surface.lambda_short)
    assert scene.ensemble.grids == scene.methods.bem.grids[:2]
    per_wave = [realise(scene).points_per_wave(grid) for grid in scene.methods.bem.grids]
    assert per_wave == [4, 8, 16]
    # An oblong period has cells of one size; the shortest wave of a sweep is that of each case.
    swept = load_asked(path, ["length=['10 um', '20 um']", "sweep.lambda_short=['2.5 um', '1 um']"])
    assert [s.methods.bem.grids[0] for s in swept.scenes] == [(16, 32), (40, 80)]


def test_a_grid_of_finite_elements_that_carries_no_wave_is_told_so(write_scene):
    scene = load_scene(str(write_scene()))
    problem, coarse = realise(scene), scene.methods.fem.model_copy(update={"grids": ((2, 2), (24, 16))})
    told = dict(find_method("fem").facts(coarse, problem))
    cells = problem.longest / max(problem.spacing((2, 2)))
    words = f"carry no wave of this surface, whose longest is {cells:.3g} cells long"
    assert told["finite elements, 2 x 2"] == words
    assert not told["finite elements, 24 x 16"].startswith("carry no wave")


def test_a_method_is_given_the_grids_that_it_can_afford_or_asks_for_some(write_scene):
    path, fem = str(write_scene(fem=False)), "methods.fem.growth=1.2"
    scene = load_asked(path, [fem, "lambda_short='0.2 um'", "methods.bem.grids=[400]"])
    assert scene.methods.fem.grids == ((200, 100), (400, 200))
    words = dict(explain(scene).facts)["grids of fem"]
    assert words.startswith("800 x 400 would take more than 2 GiB or ten minutes; list it in methods.fem")
    with pytest.raises(SceneError, match=r"methods\.fem\.grids: missing; 4 points .* are 4000 x 2000, more"):
        load_asked(path, [fem, "lambda_short='0.01 um'", "methods.bem.grids=[4000]"])


def test_what_was_written_with_a_unit_is_printed_in_it_and_computed_in_si(read_scene, tmp_path):
    given = ('young = "2 MPa"', 'young = "2000kPa"'), ("reduced_pressure = 0.1", 'pressure = "0.25 bar"')
    grid = (GRIDS, "grids = [24]"), ('"10 um"', '"0.01 mm"')
    scene = read_scene(*given, *grid, fem=False)
    facts = dict(explain(scene).facts)
    assert facts["E*"] == "1627 kPa"
    assert facts["load"].startswith("p0 = 0.25 bar; p* =")
    outputs = run_scene(scene, tmp_path / "run", report=False)
    assert "(p0 = 0.25 bar, E* = 1627 kPa," in outputs.page.lead
    shown, asked = outputs.page.settings["scene"], outputs.result.settings["scene"]
    assert (shown["surface"]["length"], asked["surface"]["length"]) == (["0.01 mm", "5 um"], [1e-5, 5e-6])
    assert (shown["solid"]["young"], asked["solid"]["young"]) == ("2000 kPa", 2e6)
    pushed = load_asked(str(tmp_path / "scene.toml"), ["load.force='50 uN'"])
    assert dict(explain(pushed).facts)["load"].startswith("force = 50 uN; p0 = 1 MPa; p* =")


@given(exponent=st.integers(-9, 9), digits=st.integers(1, 9999))
def test_a_quantity_is_the_correctly_rounded_number_in_si(exponent, digits):
    from validation.scenes.tables import SolidSpec

    found = SolidSpec.model_validate({"young": f"{digits}e{exponent} kPa", "poisson": 0.2}).young
    assert found == float(f"{digits}e{exponent + 3}")


@pytest.mark.parametrize("name", builtin_scenes())
def test_every_built_in_scene_is_valid_and_bears_its_name(name):
    assert load_scene(name).name == name


def test_the_quickstart_is_the_scene_it_promises_to_be():
    scene = load_scene("quickstart")
    surface = scene.surface
    assert surface.hurst == 0.8
    assert surface.lambda_long == pytest.approx(surface.length[0] / 2, rel=1e-15)
    assert surface.lambda_short == pytest.approx(surface.length[0] / 8, rel=1e-15)
    assert scene.load.reduced_pressure == 0.05
    assert [grid[0] for grid in scene.methods.bem.grids] == [32, 64, 128, 256, 512]
    assert [grid[0] for grid in scene.methods.fem.grids] == [32, 64, 128]


def test_a_scene_without_a_name_is_named_after_its_file(write_scene, tmp_path):
    path = write_scene(('name = "small"', ""))
    assert load_scene(str(path)).name == "scene"
    odd = path.rename(tmp_path / "what is this.toml")
    with pytest.raises(SceneError, match="name: missing; names the results folder"):
        load_scene(str(odd))


def test_the_scene_in_the_first_page_is_a_scene(tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "getting_started.md").read_text()
    (text,) = re.findall(r"```toml\n(\[surface\].*?)```", page, re.DOTALL)
    scene = scene_in(tmp_path, text, name="mine")
    assert (scene.name, scene.surface.length) == ("mine", (1e-4, 1e-4))
    check_scene(scene, realise(scene))


@pytest.mark.parametrize("unit", sorted(units._PLAIN))
def test_units_that_are_read_without_the_registry_are_those_of_the_registry(unit):
    assert len(units._PLAIN[unit]) == 7
    for symbol, factor in units._PLAIN[unit].items():
        assert factor == units._converted(Fraction(1), symbol, unit), symbol


@pytest.mark.parametrize(
    ("sides", "square"),
    [(("10 um", "5 um"), "[24, 12]"), ((5e-6, 1e-5), "[12, 24]")],
)
def test_a_grid_of_oblong_cells_is_said_before_it_is_pressed(sides, square, tmp_path):
    scene, notes = scene_in(tmp_path, square_scene(length=json.dumps(sides), grids=f"[24, {square}]")), []
    ((_, words),) = [fact for fact in explain(scene).facts if fact[0] == "grids of bem"]
    assert words == f"24 x 24 has oblong cells, in which no edge is located; {square} has square ones"
    progress = Progress()
    progress.note = notes.append
    bench = Bench.at(tmp_path / "solves", progress=progress)
    run_scene(scene, tmp_path / "results", bench=bench, report=False)
    assert notes == [f"grids of bem: {words}"]


def test_a_pair_of_one_value_is_told_once():
    text = square_scene('[quantities.electrical]\nresistivity = ["1e-8 ohm m"]\n', length='["10 um"]')
    with pytest.raises(ValidationError) as found:
        Scene.model_validate({"name": "short", **tomllib.loads(text)})
    assert problems(found.value) == [
        "surface.length = ['10 um']: must have at least 2 values",
        "quantities.electrical.resistivity = ['1e-8 ohm m']: must have at least 2 values",
    ]
