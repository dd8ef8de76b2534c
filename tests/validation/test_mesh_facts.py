"""What `explain` says of a finite-element mesh."""

import tomllib

import pytest
from small_scene import square_scene

from fem_contact.block import wave_errors
from validation.comparison.explain import explain
from validation.scenes.scene import Scene

SCENE = {"name": "mesh", **tomllib.loads(square_scene())}


def facts(**methods):
    return dict(explain(Scene.model_validate(SCENE | {"methods": methods})).facts)


@pytest.mark.parametrize("growth", [1.2, 2.0])
def test_explanation_states_the_error_of_every_finite_element_grid(growth):
    said = facts(fem={"grids": [64, 32], "growth": growth})
    for n in (32, 64):
        short, long = wave_errors((n, n), (1e-5, 1e-5), [2.5e-6, 5e-6], poisson=0.3, growth=growth)
        words = said[f"finite elements, {n} x {n}"]
        for error in (short.along_axis, short.along_diagonal, long.along_axis):
            assert f"{error:+.2%}" in words


def test_the_error_does_not_depend_on_which_side_of_the_cells_is_longer():
    said, turned = (facts(fem={"grids": [grid]}) for grid in ([32, 64], [64, 32]))
    assert said["finite elements, 32 x 64"] == turned["finite elements, 64 x 32"]


def test_a_scene_without_finite_elements_states_none():
    assert not any("finite elements" in name for name in facts(bem={"grids": [32]}))
