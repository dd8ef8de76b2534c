"""Each number is of what was asked: surfaces, loads, readings, bodies of the scene, on every path."""

import math

import numpy as np
import pytest
from commanding import invoke
from numpy.testing import assert_allclose
from refusing import refused
from small_scene import PRESSED, STICKY, ensemble, scene_in, small_scene, square_scene

import fem_contact as fc
from fem_contact import HalfSpace, Solid
from fem_contact.subsurface import fields_below
from persson.scale import Scale
from persson.separation import contact_stiffness
from validation.audit import audit
from validation.comparison.accuracy import reach
from validation.comparison.explain import explain
from validation.comparison.run import run_scene, run_sweep
from validation.comparison.sweep_views import sweep_views
from validation.errors import UsageError
from validation.execution.bench import Bench
from validation.measurements.common import base_case, base_surface
from validation.measurements.grids import on_grids
from validation.measurements.measurement import press_on_grids, truncated_heights
from validation.scenes.problem import realise
from validation.scenes.scene import load_scene
from validation.solvers.theory import TheoryOptions, predict
from validation.studies import area, magnification, refinement

CURRENT = '[quantities.electrical]\nresistivity = "20 nohm m"\n'
RANDOM = ("seed = 77", 'seed = 77\namplitudes = "gaussian"')
SCATTERED = small_scene(CURRENT + ensemble(3), load='pressure = "20 kPa"').replace(*RANDOM)
COATED = '[[effects]]\nkind = "coating"\nyoung = "8 MPa"\nthickness = "1 um"\n'


def rough(lambda_short, seed):
    waves = {"length": "10 um", "lambda_long": "5 um", "lambda_short": lambda_short}
    return fc.self_affine(**waves, hurst=0.8, rms_gradient=0.1, seed=seed)


ROUGH = rough("2 um", 5)
MAPS = f"""
[surface]
kind = "file"
path = "a.npy"
more_paths = ["b.npy"]
length = "10 um"
unit = "1 um"
{{more}}
{PRESSED}
[methods.bem]
grids = [48, 64]
[methods.theory]
{ensemble(2, [48, 64])}
"""


@pytest.fixture
def maps(tmp_path):
    """Scenes of two maps of a surface, the second four times as rough."""
    for name, seed, height in (("a", 31, 1.0), ("b", 32, 4.0)):
        np.save(tmp_path / f"{name}.npy", height * rough("1 um", seed).heights(24).values * 1e6)
    return lambda more: scene_in(tmp_path, MAPS.format(more=more))


def test_a_map_treated_otherwise_is_no_map_of_the_ensemble(maps, tmp_path):
    data = {}
    for word in ("true", "false"):
        folder = tmp_path / word
        bench = Bench.at(tmp_path / "solves")
        data[word] = run_scene(maps(f"treatment = {word}"), folder, bench=bench, report=False).data
        assert audit(folder).wrong == ()
    for name in ("area_each", "area_persson_each", "rms_gradient_each"):
        assert_allclose(data["true"][name], data["false"][name], rtol=1e-12)


def test_each_surface_of_an_ensemble_has_its_own_load_and_theory(tmp_path):
    scene = scene_in(tmp_path, SCATTERED.replace("[methods.bem]", "[methods.theory]\n[methods.bem]"))
    data = run_scene(scene, tmp_path / "out", report=False).data
    assert np.ptp(data.reduced_pressure_each.values) > 0.01
    own = data.area_persson_each / data.reduced_pressure_each
    assert float(data.kappa_persson) == pytest.approx(float(own.mean()), rel=1e-12)

    def stiffness_of(problem):
        scale = Scale(problem.own_spectrum, contact_modulus=problem.contact_modulus)
        return float(contact_stiffness(problem.pressure, scale=scale))

    stiffness = [stiffness_of(realise(scene).further(k)) for k in range(3)]
    one = data.electrical_conductance_persson / np.mean(stiffness)
    scene = scene_in(tmp_path, SCATTERED.replace(ensemble(3), "[methods.theory]\n"))
    alone = run_scene(scene, tmp_path / "alone", report=False).data
    assert float(one) == pytest.approx(float(alone.electrical_conductance_persson) / stiffness[0], rel=1e-9)


def test_surfaces_of_a_study_at_one_load_have_one_reduced_pressure(tmp_path):
    text = square_scene(load='pressure = "20 kPa"').replace(*RANDOM)
    options = refinement.Options(scene=text_in(tmp_path, text), surfaces=3)
    loads = [problem.reduced_pressure for problem in options.pressed]
    assert_allclose(loads, options.reduced_pressure, rtol=1e-12)
    assert len({problem.pressure for problem in options.pressed}) == 3


def test_the_theory_of_a_study_is_told_each_of_its_surfaces(bench, tmp_path):
    """At one p* the load over the hardness differs where amplitudes, and so gradients, do."""
    text = square_scene('[[effects]]\nkind = "hardness"\nhardness = "60 kPa"\n', grids="[16, 24]")
    scattered = text_in(tmp_path, text.replace("seed = 77", 'seed = 77\namplitudes = "gaussian"'))
    options = refinement.Options(scene=scattered, surfaces=2)
    told = [options.predicted(problem).area for problem in options.pressed]
    data = refinement.run(options, bench=bench)
    assert_allclose(data.area_persson_each, told, rtol=1e-12)
    assert np.ptp(told) > 0.01 * told[0]


def test_a_study_reads_the_theory_as_its_scene_does(tmp_path):
    text = square_scene(f'{STICKY}[methods.theory]\nenergy = "old"\n', grids="[12, 16]")
    options = area.Options(scene=text_in(tmp_path, text), reduced_pressures=(0.1,), surfaces=1)
    told = [predict(options.first, options.effects, one).area for one in (TheoryOptions(energy="old"), None)]
    assert options.predicted(options.first).area == told[0] != told[1]


def test_a_study_says_which_maps_it_leaves(maps, tmp_path):
    maps("treatment = false")
    options = refinement.Options(scene=text_in(tmp_path, MAPS.format(more="treatment = false")))
    assert "surface.more_paths" in " ".join(options.remarks())


def text_in(folder, text):
    (folder / "scene.toml").write_text(text)
    return str(folder / "scene.toml")


def test_the_gradient_of_a_cut_map_is_that_of_its_finest_grid(maps, tmp_path):
    text = MAPS.format(more="treatment = false").replace('more_paths = ["b.npy"]\n', "")
    text = text[: text.index("[methods.theory]")].replace("[48, 64]", "[16, 48, 64]\nunder_resolved = true")
    asked = {"magnifications": (8.0,), "reduced_pressures": (0.1,)}
    options = magnification.Options(scene=text_in(tmp_path, text), **asked)
    data = magnification.run(options, bench=Bench.at(tmp_path / "solves"))
    last = 8 * 2 * np.pi / options.first.longest
    finest = truncated_heights(options.first, (64, 64), truncation=last).rms_gradient
    assert float(data.truncated_gradient_each.squeeze()) == pytest.approx(finest, rel=1e-12)


def test_below_two_bodies_the_first_gives_way(tmp_path):
    both = {"young": "1 GPa", "poisson": 0.3, "second_young": "10 MPa", "second_poisson": 0.4}
    contact = fc.press(ROUGH, **both, reduced_pressure=0.1, grid=24)
    first = HalfSpace(solid=Solid(young=1e9, poisson=0.3))
    expected = fields_below(contact.result, first, depths=[1e-6])
    found = contact.below([1e-6])
    assert_allclose(found.displacement, expected.displacement, rtol=1e-12)
    assert_allclose(found.stress, expected.stress, rtol=1e-12)


def test_a_swept_pressure_of_an_effect_is_not_that_of_the_load(tmp_path):
    text = small_scene("[methods.theory]\n", grids="[[24, 16]]")
    loads = "sweep.load.pressure=[1e4, 2e4]"
    seeds = "sweep.surface.seed=[3, 4, 5]"
    named = scene_in(tmp_path, text, loads).keys[0].name
    assert named == "pressure"
    smooth = '[[effects]]\nkind = "smoothing"\npressure = "10 kPa"\nhardness = "50 kPa"\n'
    swept = scene_in(tmp_path, text + smooth, "sweep.effects.smoothing.pressure=[1e4, 2e4]")
    assert swept.keys[0].name == "smoothing_pressure"
    several = scene_in(tmp_path, text + ensemble(2, "[[24, 16], [36, 24]]"), seeds)
    data = run_sweep(several, tmp_path / "out", report=False).data
    texts = [found.text for found in sweep_views(data).findings]
    assert any("share surfaces" in words for words in texts)
    assert not any(words.startswith("Over 3 surfaces") for words in texts)


def test_long_waves_of_a_lay_are_counted_along_it():
    scene = load_scene("ground")
    problem, surface = realise(scene), scene.surface
    lx, ly = surface.length
    assert problem.periods == min(lx / (surface.lambda_long * surface.stretch), ly / surface.lambda_long)
    assert f"L/lambda_long = {problem.periods:.3g}" in str(dict(explain(scene).facts))


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("surface inspect quickstart --tilt plane", "--tilt: of a file"),
        ("surface inspect quickstart --missing nearest", "--missing: of a file"),
        ("reference --theory persson --hurst 0.8", "--hurst: not with --theory"),
        ("reference --theory persson --amplitudes gaussian", "--amplitudes: not with --theory"),
    ],
)
def test_what_would_be_ignored_is_refused(words, says):
    assert says in str(invoke(words).exception)


def test_an_accuracy_over_maps_is_refused(maps, tmp_path):
    with refused(UsageError, "draws as many surfaces as it takes"):
        reach(maps("treatment = false"), Bench.at(tmp_path / "solves"), target=0.1)


def test_contacts_that_are_held_apart_stand_in_a_table():
    held = [fc.press(ROUGH, young="1 GPa", poisson=0.3, offset=h, grid=24) for h in ("100 nm", "150 nm")]
    table = fc.table(held, along="reduced_pressure")
    assert_allclose(table.reduced_pressure, [float(c.data.reduced_pressure) for c in held], rtol=1e-9)
    coated = {"young": "1 GPa", "poisson": 0.3, "reduced_pressure": 0.05}
    coated["coating"] = {"young": "4 GPa", "thickness": "1 um", "poisson": 0.3}
    row = fc.table([fc.press(ROUGH, **coated, grid=24)], limit=True)
    assert_allclose(row.kappa_limit / row.limit, row.kappa / row.area, rtol=1e-9)


def test_a_map_on_fewer_points_than_its_own_is_moved_before_they_are_taken(maps):
    problem = realise(maps("treatment = false"))
    fine = problem.heights((24, 24)).heights
    for part, first in ((0.5, 1), (0.0, 0)):
        moved = problem.heights((12, 12), (part, part)).heights
        expected = fine[first::2, first::2]
        # To either side.
        off = min(abs(moved - one).max() for one in (expected, np.roll(expected, 1, (0, 1))))
        assert off < 1e-12 * fine.std()


def test_patches_are_counted_in_cells_on_oblong_cells_too(bench):
    base = base_case(base_surface(hurst=0.8, periods=1.6, bandwidth=2.5, seed=61), reduced_pressure=0.3)
    kept = {"reduced_pressures": (0.3,), "shifts": 1, "keep": ("distributions",)}
    cells = {}
    for grids in (((32, 32), (64, 64)), ((32, 32), (128, 64))):
        measured = press_on_grids(problem=base, grids=grids, **kept).do()
        share = base.shortest**2 / math.prod(base.lengths)
        cells[grids[-1]] = on_grids(measured, wave_share=share).cells_at_part_each.isel(grid=-1).values
    assert (cells[128, 64] / cells[64, 64] > 1.6).all()  # twice, but for the bins of their areas


def test_a_sweep_says_which_of_its_maps_are_doubtful(maps, tmp_path):
    maps("treatment = false")
    text = MAPS.format(more="treatment = false").replace('more_paths = ["b.npy"]\n', "")
    text = text[: text.index("[ensemble]")].replace("[48, 64]", "[48]")
    units = scene_in(tmp_path, text, "sweep.surface.unit=['1 um', '1 m']")
    data = run_sweep(units, tmp_path / "out", report=False).data
    said = " ".join(found.text for found in sweep_views(data).findings)
    assert "(in 1 of 2 cases)" in said
