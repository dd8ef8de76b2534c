"""The sentences of a report are computed: other numbers make them change or reverse."""

from __future__ import annotations

import dataclasses

import pytest

from fem_contact.area import Limit
from validation.comparison import Scatter
from validation.findings import findings
from validation.run import run_scene
from validation.scene import load_scene


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
