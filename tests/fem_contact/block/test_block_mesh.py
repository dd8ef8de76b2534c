import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fem_contact.block import graded_layers, plan_mesh
from fem_contact.errors import InvalidInput


@given(depth=st.floats(0.05, 5e3), growth=st.floats(1.0, 2.0))
def test_layers_fill_the_depth_and_grow_no_faster_than_asked(depth, growth):
    layers = graded_layers(depth, first=1.0, growth=growth)
    np.testing.assert_allclose(layers.sum(), depth, rtol=1e-12)
    ratios = layers[1:] / layers[:-1]
    assert np.all(ratios >= 1 - 1e-12)
    assert np.all(ratios <= growth * (1 + 1e-9))
    assert layers[0] <= 1 + 1e-9


def test_default_mesh_starts_with_cubes_and_is_one_period_deep():
    mesh = plan_mesh((40, 20), (2e-6, 1e-6))
    assert mesh.layers[-1] == pytest.approx(1, rel=1e-12)
    assert -mesh.planes[0] == pytest.approx(40, rel=1e-12)
    assert mesh.planes[-1] == 0
    assert mesh.unknowns == 3 * 40 * 20 * mesh.nz


def test_thin_block_still_has_several_layers():
    assert plan_mesh((64, 64), (1.0, 1.0), depth=0.01).nz == 4


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"first_layer": 1e-300}, "first_layer"),
        ({"first_layer": 1e-12, "growth": 1.0}, "at most 10,000"),
        ({"first_layer": 1e-6, "growth": 1 + 1e-12}, "at most 10,000"),
        ({"depth": 1e300}, "depth"),
        ({"depth": 1e20}, "cell widths"),
    ],
)
def test_impossible_layers_are_refused_by_name(changes, name):
    with pytest.raises(InvalidInput, match=name):
        plan_mesh((8, 8), (1.0, 1.0), **changes)


@pytest.mark.parametrize("lengths", [(1e30, 1e-30), (1e-30, 1e30), (1e-118, 1e-118), (0.0, 1.0), "x"])
def test_periods_that_no_cells_can_fill_are_refused(lengths):
    with pytest.raises(InvalidInput, match="lengths = "):
        plan_mesh((8, 8), lengths)


def test_growth_beyond_the_depth_makes_two_layers_and_no_overflow():
    layers = graded_layers(1000.0, first=1.0, growth=1e300)
    np.testing.assert_allclose(layers, [1, 999], rtol=1e-12)
