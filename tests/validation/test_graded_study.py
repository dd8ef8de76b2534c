"""The study of graded solids, and the scenes of an oxide and of a soft layer."""

import numpy as np
import pytest

from validation.comparison.explain import explain
from validation.execution.press import solves_of
from validation.scenes.scene import load_scene


@pytest.fixture(scope="module")
def data(numbers):
    return numbers("graded")


def test_the_worst_errors_are_those_of_the_waves_and_of_those_where_the_claim_holds(data):
    error = data.felt_ratio_profile - 1
    mild = error.where(data.grading < 1)
    np.testing.assert_allclose(data.felt_error_profile, [error[0].max(), error[1].min()], rtol=1e-12)
    np.testing.assert_allclose(data.felt_error_mild, [mild[0].max(), mild[1].min()], rtol=1e-12)
    assert (abs(data.felt_error_mild) <= abs(data.felt_error_profile)).all()
    assert float(data.felt_error_coating[0]) > float(data.felt_error_profile[0]) > 0.1


@pytest.mark.parametrize(("name", "less"), [("oxide-layer", True), ("soft-layer", False)])
def test_a_stiff_layer_has_less_contact_and_a_soft_one_more_than_the_solid_below(name, less):
    scene = load_scene(name)
    assert explain(scene).effects[0].verdict.startswith("matters")
    solve = solves_of(scene)[0]
    plain = scene.model_copy(update={"effects": ()})
    coated, bare = (
        one.do(threads=1).contact.checked().in_contact.mean() for one in (solve, solves_of(plain)[0])
    )
    assert (coated < 0.9 * bare) if less else (coated > 1.1 * bare)
