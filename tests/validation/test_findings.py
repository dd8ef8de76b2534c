"""The sentences of a report are computed: other numbers make them change or reverse."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from fem_contact.extrapolation import Limit
from validation.comparison.compare import compare
from validation.comparison.compared import Scatter
from validation.comparison.figure_data import pressure_at_zero_data
from validation.comparison.findings import findings
from validation.comparison.report import run_page
from validation.comparison.run import run_scene
from validation.effects.adhesion import Adhesion
from validation.effects.hardness import Hardness
from validation.report.page import render
from validation.scenes.realised import realise
from validation.scenes.scene import load_scene
from validation.solves.press import solves_of
from validation.solves.running import solve_all
from validation.solves.store import Store


def _sentence(comparison, word):
    (found,) = [text for text in findings(comparison) if word in text]
    return found


def _with_limit(comparison, value, uncertainty=1e-6):
    return dataclasses.replace(
        comparison, limit=Limit(value=value, uncertainty=uncertainty, edge_constant=0.1, grids=12)
    )


def test_the_distance_to_the_theory_changes_sign_with_the_limit(small_run):
    c = small_run.comparison
    above = _sentence(_with_limit(c, 1.25 * c.theory.area), "Persson's theory gives")
    below = _sentence(_with_limit(c, 0.8 * c.theory.area), "Persson's theory gives")
    assert "25 % above it" in above
    assert "20 % below it" in below


def test_a_limit_within_its_uncertainty_of_the_theory_is_said_to_agree(small_run):
    c = small_run.comparison
    near = _sentence(_with_limit(c, 1.001 * c.theory.area, 0.01 * c.theory.area), "Persson's theory gives")
    assert "agrees" in near


def test_counting_is_said_to_underestimate_where_it_does(small_run):
    c = small_run.comparison
    over, _ = [t for t in findings(c) if "Counting contact cells" in t]
    assert "(BEM) overestimates" in over
    too_large = _with_limit(c, 2 * c.rows[0].pixel)
    under, _ = [t for t in findings(too_large) if "Counting contact cells" in t]
    assert "(BEM) underestimates" in under
    assert "by 50 %" in under


def test_a_difference_between_solvers_that_grows_is_said_to_grow(small_run):
    c = small_run.comparison
    assert "in pressure shrinks" in _sentence(c, "On the same surface")
    reversed_checks = dataclasses.replace(c, cross=tuple(reversed(c.cross)))
    assert "in pressure does not shrink" in _sentence(reversed_checks, "On the same surface")


def test_scatter_decides_whether_the_distance_means_anything(small_run):
    c = small_run.comparison
    assert "One surface proves little" in _sentence(c, "proves little")
    tight = dataclasses.replace(
        c, scatter=Scatter(areas=(0.1,) * 4, ratios=(1.29, 1.3, 1.31, 1.3), grid_error=0.001)
    )
    wide = dataclasses.replace(
        c, scatter=Scatter(areas=(0.1,) * 4, ratios=(0.7, 1.5, 1.3, 0.9), grid_error=0.001)
    )
    assert "not an accident" in _sentence(tight, "4 realisations")
    assert "cannot tell it from zero" in _sentence(wide, "4 realisations")


def test_nothing_is_claimed_of_a_limit_that_one_grid_cannot_give(write_scene, tmp_path):
    path = write_scene(("grids = [12, 24, 48]\nshifts = 2", "grids = [24]\nshifts = 2"), fem=False)
    comparison = run_scene(load_scene(str(path)), tmp_path / "results").comparison
    assert comparison.limit is None
    assert "not determinable" in comparison.findings[0]


@pytest.mark.parametrize(("pressure", "words"), [(0.02, "above it"), (6.0, "agrees with it")])
def test_a_scene_near_full_contact_reverses_the_verdict(write_scene, tmp_path, pressure, words):
    path = write_scene(("reduced_pressure = 0.1", f"reduced_pressure = {pressure}"), fem=False)
    comparison = run_scene(load_scene(str(path)), tmp_path / "results").comparison
    assert words in _sentence(comparison, "Persson's theory gives")
    assert any("Contact is complete" in text for text in comparison.findings) == (pressure > 1)


def test_a_contact_of_one_point_has_no_limit_and_no_law_of_its_edge(write_scene, tmp_path):
    path = write_scene(("reduced_pressure = 0.1", "reduced_pressure = 1e-6"), fem=False)
    comparison = run_scene(load_scene(str(path)), tmp_path / "results").comparison
    assert comparison.limit is None
    said = "the contact has 1 point on the finest grid"
    assert f"not determinable: {said}" in comparison.findings[0]
    assert not any(
        word in text for text in findings(comparison) for word in (" it (", "agrees", "falls with")
    )
    assert said in render(run_page(comparison))


def test_agreement_within_an_uncertainty_says_how_large_that_is(small_run):
    c = small_run.comparison
    near = _sentence(_with_limit(c, 1.5 * c.theory.area, 0.3 * c.theory.area), "Persson's theory gives")
    assert "within twice its uncertainty (difference 50 %, uncertainty 30 %)" in near


def _with_effects(comparison, *effects):
    scene = comparison.scene.model_copy(update={"effects": effects})
    return dataclasses.replace(comparison, scene=scene)


STICKY = Adhesion(kind="adhesion", work=1e-3, reach=4e-8)
HARD = Hardness(kind="hardness", hardness=4e4)


def test_nothing_is_said_of_pressures_that_start_at_zero_where_adhesion_pulls(small_run):
    plain, sticky = small_run.comparison, _with_effects(small_run.comparison, STICKY)
    assert any("P(sigma)" in text for text in findings(plain))
    assert not any("P(sigma)" in text for text in findings(sticky))
    assert [run_page(c).tables[0].sums[0][7] for c in (plain, sticky)] == ["0", ""]


def test_a_report_names_its_effects_and_cites_what_solved_them(small_run):
    plain, sticky = small_run.comparison, _with_effects(small_run.comparison, STICKY)
    assert "elastic, no adhesion" in run_page(plain).lead
    assert "effects: adhesion" in run_page(sticky).lead
    page = render(run_page(sticky))
    assert "effects: adhesion" in page
    assert "Runs: adhesion: Pastewka-Robbins number" in page
    assert "Left out: hardness" in page
    assert "Bertsekas" in page
    assert "Polonsky" not in page
    assert "Polonsky" in render(run_page(plain))


def test_the_yielded_area_stands_on_a_card(small_run):
    c = _with_effects(small_run.comparison, HARD)
    assert "How much has yielded" not in render(run_page(c))
    rows = tuple(dataclasses.replace(row, plastic=0.0123) for row in c.rows)
    page = render(run_page(dataclasses.replace(c, rows=rows)))
    assert page.count("How much has yielded") == 1
    assert "0.01230" in page


def test_a_run_to_an_accuracy_is_not_told_to_refine(small_run):
    c = _with_limit(small_run.comparison, 3 * small_run.comparison.rows[0].pixel)
    assert any("refine the grids" in text for text in findings(c))
    accurate = dataclasses.replace(c, accurate={"mean": None})
    assert not any("refine the grids" in text for text in findings(accurate))


@pytest.mark.parametrize(("error", "verdict"), [(0.05, "does not reach"), (0.2, "holds")])
def test_the_mean_over_surfaces_is_put_beside_the_theory(small_run, error, verdict):
    c = small_run.comparison
    mean = 1.1 * c.theory.area
    reached = {"mean": mean, "mean_error": error, "surfaces": 48, "scatter": 0.07, "located": True}
    (said,) = [text for text in findings(dataclasses.replace(c, accurate=reached)) if "spectrum" in text]
    assert f"A/A0 = {mean:.6g} +- {100 * error:.2g}" in said
    assert "from 48 solved in pairs h, -h; single ones scatter by 7.0 %" in said
    assert said.endswith(f"it lies 10 % above the theory, which its interval {verdict}.")


def test_pulled_points_are_in_the_distribution_with_adhesion_alone(write_scene, tmp_path):
    path = write_scene(
        ("[solid]", '[[effects]]\nkind = "adhesion"\nwork = "1 mJ/m^2"\nreach = "40 nm"\n[solid]'),
        ("grids = [12, 24, 48]\nshifts = 2", "grids = [48]"),
        fem=False,
    )
    scene = load_scene(str(path))
    (solve,) = solves_of(scene)
    store = Store(folder=tmp_path)
    store.save(solve, solve.do(threads=1))
    realised = realise(scene)
    comparison = compare(scene, realised, solve_all([solve], store))
    contact = store.load(solve)
    solves = {"BEM 48 x 48": [contact]}
    data = pressure_at_zero_data(comparison, solves)
    unit = comparison.contact_modulus * comparison.rms_gradient
    lowest = contact.pressure[contact.in_contact].min() / unit
    assert data.lower.values[0] == pytest.approx(lowest, rel=1e-12)
    assert lowest < 0
    # Nothing in contact is lost at the lower end: what is above 0.6 is what is not drawn.
    drawn = float((data.density * (data.upper - data.lower))[data.curve.values != "Persson"].sum())
    below = np.mean(contact.in_contact & (contact.pressure <= 0.6 * unit))
    assert drawn == pytest.approx(below, abs=1e-12)
    assert np.isnan(comparison.rows[0].density_at_zero)
    plain = pressure_at_zero_data(_with_effects(comparison), solves)
    assert plain.lower.values[0] == 0


def test_two_solvers_of_one_discrete_problem_are_not_said_to_differ_more_on_finer_grids(small_run):
    c = small_run.comparison
    same = tuple(
        dataclasses.replace(check, pressure=size, pixel=0.0)
        for check, size in zip(c.cross, (1e-8, 3e-8), strict=True)
    )
    said = _sentence(dataclasses.replace(c, cross=same), "On the same surface")
    assert said.endswith("no more than their tolerances leave.")
    assert "shrink" not in said
