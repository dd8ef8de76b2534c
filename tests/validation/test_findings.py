"""What a run finds is decided by values with intervals: other numbers change or reverse it."""

import re

import numpy as np
import pytest
import xarray as xr
from small_scene import GRIDS, HARD, STICKY

from validation.comparison.numbers import scene_data
from validation.comparison.run_views import run_views
from validation.errors import UsageError
from validation.execution.press import solves_of
from validation.report.estimates import claim, derive
from validation.report.findings import finding
from validation.scenes.problem import realise


def _found(data, words):
    (found,) = [one for one in run_views(data).findings if words in one.form]
    return found


def _apart(data, ratio, error):
    """The dataset with another distance from the theory."""
    data = data.assign(area_ratio=ratio + 0 * data.area_ratio)
    return derive(claim(data, "area_ratio", grid=error, solver=error), area_excess="area_ratio - 1")


@pytest.mark.parametrize(
    ("ratio", "error", "outcome"), [(1.25, 0.1, "+"), (0.8, 0.1, "-"), (1.05, 0.1, "0"), (1.5, np.nan, "?")]
)
def test_the_distance_to_the_theory_is_decided_by_its_interval(small_run, ratio, error, outcome):
    found = _found(_apart(small_run.data, ratio, error), "{verdict} Persson's theory")
    assert found.outcomes == (outcome,)
    assert found.values["area_excess"].value == pytest.approx(ratio - 1)


def test_a_theory_without_a_number_is_said_and_nothing_is_compared_with_it(small_run):
    data = small_run.data.assign(area_persson_own=np.nan, area_excess=np.nan, theory_note="no number: why")
    said = [one.text for one in run_views(data).findings if "Persson's theory" in one.text]
    assert said == ["Persson's theory gives no number: why."]


def test_methods_without_a_grid_in_common_are_said_where_it_is_not_their_failure(small_run):
    data = small_run.data.assign(pressure_difference=np.nan * small_run.data.pressure_difference)
    words = "share no grid: their pressures are not compared"
    assert _found(data, words).text.startswith("FEM and BEM ")
    assert not any(words in one.form for one in run_views(data.assign(failures="one")).findings)


def test_at_most_six_things_are_found(small_run):
    data = small_run.data
    sure = data.assign(area_own_error=0.01 * data.area_own_error)
    # Which solve is within 1 % of a limit that is not known to 1 % cannot be said.
    assert [len(run_views(one).findings) for one in (data, sure)] == [5, 6]


def test_counting_is_said_to_err_to_the_side_to_which_it_does(small_run):
    data = small_run.data
    over = _found(data, "Counted points")
    assert [row["area_pixel_off"].value > 0 for row in over.rows] == [True, True]
    under = data.assign(area_pixel_off=data.area_pixel / (2 * data.area_own) - 1)
    assert all(row["area_pixel_off"].value < 0 for row in _found(under, "Counted points").rows)


def test_an_ensemble_says_its_mean_and_a_plain_run_that_it_is_one_surface(small_run, ensemble_run):
    assert _found(small_run.data, "One surface").kind == "note"
    data, page = ensemble_run.data, ensemble_run.page
    found = _found(data, "the mean is A/A0")
    assert found.values["area"].value == float(data.area) == pytest.approx(float(data.area_each.mean()))
    assert found.values["surfaces"].value == 3
    (card, *_) = page.answers
    assert card.basis.startswith("mean over 3 surfaces; this one ")
    assert page.answers[-1].basis.endswith("unknowns; without those of the mean")


def test_complete_contact_is_said_where_it_is(small_run, solved):
    runs = small_run, solved(("reduced_pressure = 0.1", "reduced_pressure = 8.0"))
    said = [any("Contact is complete" in text for text in run.page.findings) for run in runs]
    assert said == [False, True]


def test_a_contact_of_one_point_has_no_area_in_the_limit(solved):
    data = solved(("reduced_pressure = 0.1", "reduced_pressure = 1e-6")).data
    assert np.isnan(data.area)
    assert "on the finest grid" in str(data.no_limit.item())
    assert np.isnan(data.density_at_zero_order)


def test_pulled_points_are_in_the_distribution_with_adhesion_alone(solved):
    data = solved(STICKY).data
    assert float(data.stress_near[0]) < 0
    assert np.isnan(data.density_at_zero).all()
    assert not any("P(sigma)" in one.form for one in run_views(data).findings)


def test_the_yielded_area_stands_on_a_card(solved):
    outputs = solved(HARD)
    (card,) = [card for card in outputs.page.answers if "yielded" in card.question]
    coarser, plastic = outputs.data.area_plastic_pixel.sel(solver="bem").values[-2:]
    assert float(outputs.data.area_plastic) == plastic
    assert f"+- {float(outputs.data.area_plastic_error.sum()):.2g} (grid)" in card.answer
    assert card.answer.startswith(f"{plastic:.2g}")
    assert coarser != plastic
    assert f"theory: {float(outputs.data.area_plastic_persson):.4g}" in card.basis


def test_an_under_resolved_grid_is_named_and_in_no_limit(read_scene):
    scene = read_scene((f"{GRIDS}\nshifts = 2", "grids = [6, 16, 32]\nunder_resolved = true"), fem=False)
    results = {solve: solve.do().contact for solve in solves_of(scene)}
    data = scene_data(scene, realise(scene), results)
    assert "6 x 6" in _found(data, "Under-resolved").text
    fine = {solve: result for solve, result in results.items() if solve.grid != (6, 6)}
    assert float(scene_data(scene, realise(scene), fine).area_own) == float(data.area_own)


def test_a_part_in_brackets_is_said_where_its_values_are():
    data, form = (
        xr.Dataset({"area": 0.1, "kappa": np.nan}),
        "A/A0 = {area}[, kappa = {kappa}][ ({scatter:.2%})].",
    )
    assert finding("value", form, data).text == "A/A0 = 0.1."
    assert finding("value", form, data, kappa=2.0).text == "A/A0 = 0.1, kappa = 2."
    with pytest.raises(UsageError, match="no such quantity"):
        finding("value", "[{no_such}]", data)


@pytest.mark.parametrize(("kind", "strange"), [("equivalence", "+"), ("trend", "within"), ("value", "0")])
def test_words_of_outcomes_that_a_kind_has_not_are_refused(kind, strange):
    data = claim(xr.Dataset({"area": 0.1}), "area", grid=0.01)
    with pytest.raises(UsageError, match=f"{re.escape(strange)}: no outcome of the kind '{kind}'"):
        finding(kind, "A/A0 = {area}", data, by="area", words={strange: "so"})


@pytest.mark.parametrize(("kind", "by"), [("comparison", ""), ("value", "area"), ("no kind", "area")])
def test_a_verdict_takes_a_kind_that_decides_and_a_value_to_decide_by(kind, by):
    data = claim(xr.Dataset({"area": 0.1}), "area", grid=0.01)
    with pytest.raises(UsageError, match=f"the kind '{kind}' says no verdict, or 'by' names no value"):
        finding(kind, "The area is {verdict} nothing: {area}.", data, by=by)
