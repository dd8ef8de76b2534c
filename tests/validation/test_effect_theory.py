"""Theory and simulation side by side for scenes that yield or adhere."""

import math

import numpy as np
import pytest
from small_scene import HARD
from solving import solve_all

from fem_contact import Solid
from persson import SelfAffine, elastic
from validation.comparison.fields import with_distribution
from validation.comparison.numbers import scene_data
from validation.comparison.run_views import pressure_figure, run_views
from validation.effects.adhesion import Adhesion
from validation.effects.base import TheoryInputs
from validation.effects.hardness import Hardness
from validation.execution.press import solves_of
from validation.scenes.problem import realise
from validation.scenes.scene import load_scene
from validation.scenes.sweep import load_asked
from validation.solvers.theory import predict, stress_distribution, with_effects

SPECTRUM = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=2e5, q_short=8e5)
MODULUS, LOAD = 1e9, 5e6
VARIANCE = float(elastic.stress_variance(SPECTRUM.m2(), contact_modulus=MODULUS))
ELASTIC = float(elastic.contact_area(LOAD, stress_variance=VARIANCE))


def hard(pressure):
    return Hardness(kind="hardness", hardness=pressure)


def sticky(work):
    return Adhesion(kind="adhesion", work=work, reach=1e-8)


def areas(*effects):
    told = TheoryInputs.by(Solid(young=MODULUS, poisson=0.0), effects)
    return with_effects(told, LOAD, variance=VARIANCE, spectrum=SPECTRUM)


def test_adhesion_without_work_leaves_the_theory_of_hardness():
    # The theory with adhesion is solved to 1e-6 of the area, on nodes whose error it states below 1e-4.
    both, alone = areas(sticky(1e-9), hard(6e7)), areas(hard(6e7))
    assert both.area == pytest.approx(alone.area, rel=1e-3)
    assert both.other == pytest.approx(alone.area, rel=1e-3)
    assert both.plastic == pytest.approx(alone.plastic, rel=1e-3)


def test_where_the_theory_has_no_answer_the_reason_is_kept():
    found = areas(hard(LOAD / 2))
    assert math.isnan(found.area)
    assert found.note.startswith("no answer: pressure = ")
    assert np.isnan(found.area)
    # JSON has no NaN.


def test_a_scene_that_yields_is_set_beside_its_theory(read_scene, tmp_path):
    scene = read_scene(HARD.replace("60 kPa", "40 kPa"))
    problem = realise(scene)
    results = solve_all(solves_of(scene, problem), tmp_path)
    found = scene_data(scene, problem, results)
    assert 0 < float(found.area_plastic_persson) <= float(found.area_persson_own)
    assert (found.area_plastic_pixel > 0).sum() == found.area_pixel.notnull().sum()
    assert any("Yielded" in one.text and "by the theory" in one.text for one in run_views(found).findings)
    # P(sigma) is drawn between its walls: it holds the elastic area and ends at the hardness.
    drawn = with_distribution(found, {s: results[s] for s in results if s.is_own}, scene, problem)
    stress, density = drawn.stress_wide_exact.values, drawn.density_wide_persson.values
    elastic = float(found.area_persson_own - found.area_plastic_persson)
    assert np.trapezoid(density, stress) == pytest.approx(elastic, rel=2e-2)
    assert not np.any(density[stress * problem.pressure_scale > 40e3])
    # It ends where simulations do, however far down the theory goes, and a grid looks alike on both panels.
    drawn["density_wide_persson"] = np.maximum(drawn.density_wide_persson, 1e-300)
    near, wide = pressure_figure(drawn).panels
    counted = drawn.density_wide.values[drawn.density_wide.values > 0]
    assert counted.min() / 100 < wide.bottom < counted.min()
    assert counted.max() < wide.top < 10 * max(counted.max(), density.max())
    finest = [[mark.look["ls"] for mark in panel.marks if mark.steps][-1] for panel in (near, wide)]
    assert finest == ["-", "-"]


@pytest.mark.parametrize("name", ["quickstart", "hardness", "adhesion", "soft-layer"])
def test_the_distribution_of_the_theory_holds_its_area(name):
    scene = load_scene(name)
    problem, options = realise(scene), scene.methods.options("theory")
    found = predict(problem, scene.effects, options)
    stress = np.linspace(-4, 8, 40_001) * problem.pressure_scale
    density = stress_distribution(problem, scene.effects, options, stress)
    elastic = found.area - (found.plastic or 0.0)
    # The adhesive walls are told between nodes of the iteration.
    assert np.trapezoid(density, stress) == pytest.approx(elastic, rel=2e-4, abs=2e-7)


def test_without_an_answer_of_the_theory_there_is_no_distribution():
    scene = load_asked("hardness", ["hardness=1 MPa"])
    stress = np.linspace(0, 1, 5)
    assert stress_distribution(realise(scene), scene.effects, None, stress) is None
