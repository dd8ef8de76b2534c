import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fem_contact.block import ELEMENTS, BlockMesh, graded_layers, plan_mesh


@given(depth=st.floats(0.05, 5e3), growth=st.floats(1.0, 2.0))
def test_layers_fill_the_depth_and_grow_no_faster_than_asked(depth, growth):
    layers = graded_layers(depth, first=1.0, growth=growth)
    np.testing.assert_allclose(layers.sum(), depth, rtol=1e-12)
    ratios = layers[1:] / layers[:-1]
    assert np.all(ratios >= 1 - 1e-12)
    assert np.all(ratios <= growth * (1 + 1e-9))
    assert layers[0] <= 1 + 1e-9


def test_layers_may_be_a_list():
    mesh = BlockMesh(cells=(2, 2), aspect=1.0, layers=[1.0, 2.0], element=ELEMENTS["Hex1"])
    assert mesh.nz == 2


def test_default_mesh_starts_with_cubes_and_is_one_period_deep():
    mesh = plan_mesh((40, 20), (2e-6, 1e-6))
    assert mesh.layers[-1] == pytest.approx(1, rel=1e-12)
    assert -mesh.planes[0] == pytest.approx(40, rel=1e-12)
    assert mesh.planes[-1] == 0
    assert mesh.unknowns == 3 * 40 * 20 * mesh.nz


def test_thin_block_still_has_several_layers():
    assert plan_mesh((64, 64), (1.0, 1.0), depth=0.01).nz == 4


def test_growth_beyond_the_depth_makes_two_layers_and_no_overflow():
    layers = graded_layers(1000.0, first=1.0, growth=1e300)
    np.testing.assert_allclose(layers, [1, 999], rtol=1e-12)
