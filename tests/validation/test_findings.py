"""What a run finds is decided by values with intervals: other numbers change or reverse it."""

import numpy as np
import pytest
import xarray as xr
from small_scene import GRIDS

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


def test_counting_is_said_to_err_to_the_side_to_which_it_does(small_run):
    data = small_run.data
    over = _found(data, "Counted points")
    assert [row["area_pixel_off"].value > 0 for row in over.rows] == [True, True]
    under = data.assign(area_pixel_off=data.area_pixel / (2 * data.area_own) - 1)
    assert all(row["area_pixel_off"].value < 0 for row in _found(under, "Counted points").rows)


def test_complete_contact_is_said_where_it_is(small_run, solved):
    runs = small_run, solved(("reduced_pressure = 0.1", "reduced_pressure = 8.0"))
    said = [any("Contact is complete" in text for text in run.page.findings) for run in runs]
    assert said == [False, True]


def test_an_under_resolved_grid_is_named_and_in_no_limit(read_scene):
    scene = read_scene((f"{GRIDS}\nshifts = 2", "grids = [6, 16, 32]\nunder_resolved = true"), fem=False)
    results = {solve: solve.do().contact for solve in solves_of(scene)}
    data = scene_data(scene, realise(scene), results)
    assert "6 x 6" in _found(data, "Under-resolved").text
    fine = {solve: result for solve, result in results.items() if solve.grid != (6, 6)}
    assert float(scene_data(scene, realise(scene), fine).area_own) == float(data.area_own)


def test_a_part_in_brackets_is_said_where_its_values_are():
    data = xr.Dataset({"area": 0.1, "kappa": np.nan})
    form = "A/A0 = {area}[, kappa = {kappa}][ ({scatter:.2%})]."
    assert finding("value", form, data).text == "A/A0 = 0.1."
    assert finding("value", form, data, kappa=2.0).text == "A/A0 = 0.1, kappa = 2."
    with pytest.raises(UsageError, match="no such quantity"):
        finding("value", "[{no_such}]", data)


@pytest.mark.parametrize(
    ("kind", "asked", "words"),
    [
        ("equivalence", {"by": "area", "words": {"+": "so"}}, r"\+: no outcome of the kind 'equivalence'"),
        ("trend", {"by": "area", "words": {"within": "so"}}, "within: no outcome of the kind 'trend'"),
        ("comparison", {"by": ""}, "says no verdict, or 'by' names no value"),
        ("value", {"by": "area"}, "says no verdict, or 'by' names no value"),
    ],
)
def test_a_verdict_takes_a_kind_that_decides_its_outcomes_and_a_value(kind, asked, words):
    data = claim(xr.Dataset({"area": 0.1}), "area", grid=0.01)
    form = "A/A0 = {area}" if "words" in asked else "The area is {verdict} nothing: {area}."
    with pytest.raises(UsageError, match=words):
        finding(kind, form, data, **asked)
