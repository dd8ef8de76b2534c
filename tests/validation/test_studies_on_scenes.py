"""Studies on a scene: what it says is what is pressed, or it is refused by name."""

import dataclasses
import re

import numpy as np
import pytest
from pydantic import ValidationError
from small_scene import scene_in, small_scene

from fem_contact import Hardness, Solid, bem, contact_areas, located_limit, perimeter_limit, press_yielding
from fem_contact.response import HalfSpace
from fem_contact.surface import HeightField, random_surface
from validation.audit import audit
from validation.errors import UsageError
from validation.execution.press import solves_of
from validation.execution.results import show
from validation.measurements.measurement import truncated_heights
from validation.scenes.problem import realise
from validation.scenes.scene import load_scene
from validation.solvers.theory import predict
from validation.studies import (
    area,
    cross,
    find_study,
    magnification,
    pressure,
    refinement,
    studies,
    theory_verdict,
)
from validation.studies._outputs import run_study, study_page

LENGTHS = (12e-6, 9e-6)
GRIDS = ((96, 72), (120, 90), (144, 108))
SOLID = Solid(young=2e9, poisson=0.4)
MAP = """
[surface]
kind = "file"
path = "map.npy"
length = ["12 um", "9 um"]
unit = "1 m"
[solid]
young = "2 GPa"
poisson = 0.4
[load]
pressure = "8 MPa"
[methods.bem]
grids = [[96, 72], [120, 90], [144, 108]]
"""
YIELDING = small_scene('tolerance = 1e-9\n[[effects]]\nkind = "hardness"\nhardness = "30 kPa"\n')
#: One body of the E* of the two of the small scene: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.
BOTH = Solid(young=1 / ((1 - 0.3**2) / 2e6 + (1 - 0.45**2) / 5e6), poisson=0.0)


@pytest.fixture
def scene(tmp_path):
    """Return a scene from its text; a measured map of 48 x 36 points lies beside it."""
    waves = {"q_short": 2 * np.pi / 1e-6, "lengths": LENGTHS, "seed": 5}
    rough = random_surface(lambda q: q**-3.6, shape=(48, 36), **waves)
    np.save(tmp_path / "map.npy", rough.heights * (0.08 / rough.rms_gradient))

    def read(text, name="mine"):
        return scene_in(tmp_path, text, name=name)

    return read


def measured(tmp_path):
    return HeightField(heights=np.load(tmp_path / "map.npy"), lengths=LENGTHS)


def test_a_measured_map_is_what_the_study_of_the_load_presses(scene, bench, tmp_path):
    options = pressure.Options(scene=scene(MAP), reduced_pressures=(0.02,), shifts=1)
    data = pressure.run(options, bench=bench)
    surface = measured(tmp_path)
    reduced = 8e6 / (SOLID.contact_modulus * surface.rms_gradient)
    # The load of the scene joins the path.
    assert data.reduced_pressure.values == pytest.approx([0.02, reduced], rel=1e-12)
    body, fields = HalfSpace(solid=SOLID), [surface.resampled(grid) for grid in GRIDS]
    pressed = [bem.solve(field, body, mean_pressure=8e6).checked() for field in fields]
    limit = located_limit([contact_areas(one, subcell=True) for one in pressed])
    # The solver leaves 1e-8 of p |g|, and the study starts from the lighter load.
    assert float(data.area_each[0, 1]) == pytest.approx(limit.value, rel=1e-6)
    gap = pressed[-1].gap.mean() / surface.rms_height
    assert float(data.gap_finest_each[0, 1]) == pytest.approx(gap, rel=1e-6)
    assert data.sizes["surface"] == 1
    # A measured period has no C(q) but its own: told it alone, the theory says nothing.
    assert np.isnan(data.area_spectral).all()
    assert np.isfinite(data.area_predicted).all()


def test_another_map_is_another_recipe(scene, tmp_path):
    first = pressure.design(pressure.Options(scene=scene(MAP)))
    np.save(tmp_path / "map.npy", 1.01 * np.load(tmp_path / "map.npy"))
    other = pressure.design(pressure.Options(scene=scene(MAP)))
    assert first[0].recipe["surface"]["path"] != other[0].recipe["surface"]["path"]
    assert first[0].key != other[0].key
    assert first[0].recipe["solid"] == {"young": 2e9, "poisson": 0.4}
    assert [tuple(grid) for grid in first[0].recipe["grids"]] == list(GRIDS)


def test_a_scene_that_yields_is_pressed_with_its_hardness_and_shares_solves_with_its_run(scene, bench):
    mine = scene(YIELDING)
    options = area.Options(scene=mine, reduced_pressures=(0.05,), surfaces=1)
    data = area.run(options, bench=bench)
    field = realise(mine).heights((48, 32))
    load = 0.1 * realise(mine).pressure_scale
    response, fields = HalfSpace(solid=BOTH), map(realise(mine).heights, ((24, 16), (36, 24), (48, 32)))
    hard = {"hardness": Hardness(pressure=3e4), "mean_pressure": load}
    yielded = [press_yielding(one, response, **hard) for one in fields]
    limit = perimeter_limit([contact_areas(one) for one in yielded])
    assert float(data.area.sel(reduced_pressure=0.1)) == pytest.approx(limit.value, rel=1e-6)
    elastic = contact_areas(bem.solve(field, response, mean_pressure=load)).pixel
    assert contact_areas(yielded[-1]).pixel > 1.05 * elastic  # or this test would show nothing
    own = {solve.key for solve in solves_of(mine)}
    asked = {options.press(surface=0, reduced_pressure=0.1, grid=grid).key for grid in options.ladder}
    assert own == asked
    # The theory is told the hardness, too.
    told = predict(realise(mine), mine.effects).area
    assert float(data.area_persson.sel(reduced_pressure=0.1)) == pytest.approx(told, rel=1e-12)


def test_the_study_of_the_grid_takes_effects_grids_and_tolerance_from_a_scene(scene):
    options = refinement.Options(scene=scene(YIELDING), surfaces=2)
    cases = refinement.design(options)
    recipe = cases["grids", 1].recipe
    assert recipe["grids"] == [[24, 16], [36, 24], [48, 32]]
    assert recipe["effects"] == [{"kind": "hardness", "hardness": 3e4}]
    assert recipe["tolerance"] == 1e-9
    assert recipe["surface"]["seed"] == 78
    assert not options.ladders
    assert not options.blocks


def test_a_measured_map_without_its_short_waves_is_a_lower_magnification(scene, tmp_path):
    options = magnification.Options(scene=scene(MAP), magnifications=(3.0,), shifts=1)
    (case,) = magnification.design(options).values()
    partial = truncated_heights(case["problem"], GRIDS[0], truncation=case["truncation"])
    waves = np.abs(np.fft.fft2(partial.heights))
    nx, ny = GRIDS[0]
    qx, qy = np.fft.fftfreq(nx, 12e-6 / nx), np.fft.fftfreq(ny, 9e-6 / ny)
    q = 2 * np.pi * np.hypot(qx[:, None], qy[None, :])
    last = 3 * 2 * np.pi / 12e-6
    assert waves[q > last * (1 + 1e-6)].max() < 1e-9 * waves.max()
    whole = np.abs(np.fft.fft2(measured(tmp_path).resampled(GRIDS[0]).heights))
    kept = (q > 0) & (q < last)
    np.testing.assert_allclose(waves[kept], whole[kept], atol=1e-9 * whole.max())


@pytest.mark.parametrize("name", ["quickstart", "ground"])
def test_a_surface_that_lost_no_wave_is_itself(name):
    case = realise(load_scene(name))
    whole, heights = truncated_heights(case, (64, 64), truncation=1e9), case.heights((64, 64))
    np.testing.assert_allclose(whole.heights, heights.heights, atol=1e-12 * heights.rms_height)


def test_a_scene_is_refined_on_other_grids_than_its_own_and_on_one_surface(scene):
    text = small_scene("shifts = 3\n[ensemble]\nrealisations = 3\ngrids = [24, 36]")
    told = ["--points-per-wave", "4,8,16", "--surfaces", "1"]
    options = find_study("refinement").parse(told, scene=scene(text))
    assert options.scene.methods.bem.grids == options.grids_for(()) == ((16, 8), (32, 16), (64, 32))
    assert (options.points_per_wave, options.surfaces, options.shifts) == ((4, 8, 16), 1, 3)
    assert find_study("refinement").parse([], scene=scene(text)).surfaces == 3
    oblong = find_study("area").parse(["--grids", "64,96"], scene=scene(MAP))
    assert oblong.ladder == ((64, 48), (96, 72))


@pytest.mark.parametrize("name", [name for name, study in studies().items() if study.options.takes_scene()])
def test_help_names_the_options_that_are_refused_with_a_scene(scene, name):
    options, mine = find_study(name).options, scene(small_scene("[methods.fem]\ngrids = [24, 36, 48]"))
    for option, field in options.model_fields.items():
        if option == "scene":
            continue
        try:
            options.model_validate({option: field.default, "scene": mine})
            refusal = ""
        except ValidationError as error:
            refusal = str(error)
        flag = option.replace("_", "-")
        clash = rf"--{flag}: (the scene 'mine' says it|is of a part with surfaces of its own)"
        reason = options.fixed_by_scene().get(option, "")
        assert bool(re.search(clash, refusal)) == bool(reason), option
        assert f"        {field.description}{reason}" in options.help_lines()


@pytest.mark.parametrize(
    ("study", "text", "words"),
    [
        ("pressure", YIELDING, "'mine': [[effects]] 1 kind = 'hardness': not in this study: gap, stiff"),
        ("accuracy-cost", YIELDING, "kind = 'hardness': not in this study: what a digit costs"),
        ("magnification", MAP.replace("[methods.bem]", "[methods.fem]"), "methods.bem: missing"),
        ("cross", MAP, "must name another solver beside bem"),
        ("area", MAP.replace("[[96, 72], [120, 90], [144, 108]]", "[[96, 72]]"), "a limit needs two grids"),
        ("pressure", MAP.replace("[[96, 72], [120, 90], [144, 108]]", "[[96, 72]]"), "two grids of at least"),
        ("area", YIELDING.replace("reduced_pressure = 0.1", "pressure = 4e4"), "30 kPa: must not be below"),
    ],
)
def test_a_scene_that_a_study_cannot_honour_is_refused_by_name(scene, bench, study, text, words):
    found, planning = find_study(study), dataclasses.replace(bench, plan_only=True)
    with pytest.raises(UsageError, match=re.escape(words)):
        found.compute(found.parse([], scene=scene(text)), bench=planning)


def test_the_report_says_what_was_taken_from_the_scene_and_what_was_not(scene, bench, tmp_path):
    text = MAP.replace("[methods.bem]", "[methods.bem]\nshifts = 1\n") + "[methods.fem]\ngrids = [[16, 12]]\n"
    options = area.Options(scene=scene(text), reduced_pressures=(0.05,))
    outputs = run_study(find_study("area"), options, tmp_path, bench=bench, report=False)
    said = outputs.page.findings
    assert any("map.npy" in one and "grids 96, 120, 144" in one for one in said)
    assert "Not used of the scene, for this study presses by boundary elements: [methods.fem]." in said
    assert "Keys of the scene that this study has no use for: methods.bem.shifts." in said
    assert outputs.page.settings["scene"]["load"] == {"pressure": 8e6}
    assert "hurst" not in outputs.page.settings
    # Written again from the stored dataset, it says the same.
    assert show(tmp_path, study_page, report=False).page.findings == said


def test_finite_elements_of_a_scene_stand_beside_boundary_elements_with_its_effects(scene, bench):
    mine = scene(YIELDING + "[methods.fem]\ngrids = [[12, 8]]\ngrowth = 1.5\n")
    data = cross.run(cross.Options(scene=mine, surfaces=1), bench=bench)
    assert data.leg.values.tolist() == ["fem"]
    own = {solve.method: solve for solve in solves_of(mine) if solve.grid == (12, 8)}
    found, load = own["fem"].do().contact, own["fem"].problem.pressure
    field, body = own["fem"].height_field(), HalfSpace(solid=BOTH)
    ours = press_yielding(field, body, hardness=Hardness(pressure=3e4), mean_pressure=load)
    apart = np.linalg.norm(found.pressure - ours.pressure) / np.linalg.norm(ours.pressure)
    assert float(data.pressure_difference.squeeze()) == pytest.approx(apart, rel=1e-6)


def test_the_verdict_on_the_theory_over_one_measured_map_claims_no_scatter(scene, bench):
    options = theory_verdict.Options(scene=scene(MAP), reduced_pressures=(0.3,), shifts=1)
    data = theory_verdict.run(options, bench=bench)
    assert np.isfinite(data.area_over.sel(theory="Persson")).all()
    assert np.isnan(data.area_over_error.sel(source="surfaces")).all()
    assert theory_verdict.views(data).findings


def test_every_surface_bears_the_load_that_the_row_says(scene, bench):
    """Their gradients differ: the pressure of the scene is that p* for the first alone."""
    text = small_scene("[methods.theory]\n", load='pressure = "10 kPa"')
    asked = scene(text.replace("seed = 77", 'seed = 77\namplitudes = "gaussian"'))
    options = area.Options(scene=asked, reduced_pressures=(0.05,), surfaces=2)
    (own,) = set(options.reduced_pressures) - {0.05}
    solves = [options.press(surface=k, reduced_pressure=own, grid=(48, 48)) for k in (0, 1)]
    first, second = (solve.do(threads=1).contact for solve in solves)
    assert first.mean_pressure == pytest.approx(1e4, rel=1e-12)
    assert second.mean_pressure != pytest.approx(1e4, rel=1e-3)
    for problem, contact in zip(options.pressed, (first, second), strict=True):
        assert contact.mean_pressure == pytest.approx(own * problem.pressure_scale, rel=1e-9)


def test_a_study_of_a_scene_that_says_a_force_is_audited(scene, bench, tmp_path):
    """Its solves name the force, and no p*."""
    asked = scene(small_scene(load='force = "1 uN"', grids="[24, 36, 48]"))
    options = area.Options(scene=asked, reduced_pressures=(0.05,), surfaces=2)
    (tmp_path / "out").mkdir()
    run_study(find_study("area"), options, tmp_path / "out", bench=bench, report=False)
    ledger = audit(tmp_path / "out")
    assert [str(entry) for entry in ledger.wrong] == []
    assert any(entry.name.startswith("area_each") for entry in ledger.entries)
