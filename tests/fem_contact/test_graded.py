import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose

from fem_contact import BondedLayer, ExponentialSolid, HalfSpace, LayeredSolid, Response, Solid
from fem_contact.block import ELEMENTS, BlockMesh, BlockResponse

Q = np.geomspace(1e-2, 1e3, 41)
ZERO = np.zeros_like(Q)
POISSON = [-0.5, 0.0, 0.3, 0.5]


def exponential(sublayers=64, ratio=5.0, depth=1.0):
    surface = Solid(young=1.0, poisson=0.3)
    return ExponentialSolid(surface=surface, bulk_young=ratio, depth=depth, sublayers=sublayers)


@pytest.mark.parametrize("poisson", POISSON)
def test_layers_of_one_material_are_a_half_space(poisson):
    solid = Solid(young=2.0, poisson=poisson)
    layered = LayeredSolid(layers=[solid] * 3, thicknesses=[0.1, 1.0, 30.0], base=solid)
    assert_allclose(layered.compliance(Q, ZERO), HalfSpace(solid=solid).compliance(Q, ZERO), rtol=1e-13)
    assert isinstance(layered, Response)


@pytest.mark.parametrize("poisson", [0.0, 0.3])
def test_a_layer_on_an_ever_stiffer_base_tends_to_the_bonded_layer_to_first_order(poisson):
    solid = Solid(young=2.0, poisson=poisson)
    exact = BondedLayer(solid=solid, thickness=1.0).compliance(Q, ZERO)
    errors = []
    for ratio in (1e3, 1e4):
        base = Solid(young=2.0 * ratio, poisson=poisson)
        found = LayeredSolid(layers=[solid], thicknesses=[1.0], base=base).compliance(Q, ZERO)
        errors.append(np.max(np.abs(found / exact - 1)[Q > 0.1]))
    assert errors[0] < 0.05
    assert errors[1] == pytest.approx(errors[0] / 10, rel=0.05)


@pytest.mark.parametrize("poisson", POISSON)
@pytest.mark.parametrize("contrast", [1e-4, 0.1, 10.0, 1e4])
def test_cutting_a_layer_in_two_changes_nothing(poisson, contrast):
    top, base = Solid(young=contrast, poisson=poisson), Solid(young=1.0, poisson=0.2)
    whole = LayeredSolid(layers=[top], thicknesses=[1.0], base=base).compliance(Q, ZERO)
    cut = LayeredSolid(layers=[top, top], thicknesses=[0.3, 0.7], base=base).compliance(Q, ZERO)
    assert np.all(whole > 0)
    assert_allclose(cut, whole, rtol=1e-8)


def test_short_waves_feel_the_coating_and_long_ones_the_base():
    top, base = Solid(young=1.0, poisson=0.4), Solid(young=10.0, poisson=0.2)
    coated = LayeredSolid(layers=[top], thicknesses=[1e-3], base=base)
    ends = np.array([1e-3, 1e6])
    expected = [2 / (solid.contact_modulus * q) for solid, q in zip((base, top), ends, strict=True)]
    assert_allclose(coated.compliance(ends, np.zeros(2)), expected, rtol=1e-4)
    assert coated.contact_modulus == top.contact_modulus


def test_finite_elements_find_the_same_two_layer_compliance():
    cells, width = 64, 1 / 64
    modulus = np.concatenate([np.ones(24), 4 * np.ones(8)])
    soft, hard = Solid(young=1.0, poisson=0.3), Solid(young=4.0, poisson=0.3)
    mesh = BlockMesh(cells=(cells, cells), aspect=1.0, layers=np.ones(32), element=ELEMENTS["Hex1"])
    block = BlockResponse(mesh=mesh, solid=soft, width=width, layer_modulus=modulus)
    rigid = Solid(young=1e9, poisson=0.3)
    layered = LayeredSolid(layers=[hard, soft], thicknesses=[0.125, 0.375], base=rigid)
    q = 2 * np.pi * np.array([1.0, 2.0, 4.0])
    # Trilinear elements: about a quarter of a percent at 64 nodes per wave, 1.6 % at 8.
    found = block.compliance(q[:, None], np.zeros((1, 1)))[:, 0]
    assert_allclose(found, layered.compliance(q, np.zeros(3)), rtol=0.01)


@pytest.mark.parametrize("ratio", [0.05, 5.0])
def test_sublayers_of_an_exponential_profile_converge_to_second_order(ratio):
    values = [exponential(n, ratio).compliance(Q, ZERO) for n in (32, 64, 128)]
    first, second = (np.max(np.abs(b / a - 1)) for a, b in itertools.pairwise(values))
    assert second == pytest.approx(first / 4, rel=0.1)
    assert second < 1e-3


@pytest.mark.parametrize("ratio", [100.0, 1000.0])
def test_few_sublayers_stand_for_a_soft_skin_on_a_stiff_body(ratio):
    few, many = (exponential(n, ratio).compliance(Q, ZERO) for n in (64, 512))
    assert_allclose(few, many, rtol=2e-4)


def test_many_waves_are_interpolated_to_far_below_the_error_of_the_sublayers():
    q = np.geomspace(0.1, 1e4, 5000)
    many = exponential().compliance(q, np.zeros_like(q))
    few = exponential().compliance(q[::50], np.zeros(100))
    assert_allclose(many[::50], few, rtol=1e-8)


def test_the_mean_is_left_out_and_directions_do_not_matter():
    graded = exponential()
    values = graded.compliance(np.array([0.0, 3.0, -3.0]), np.array([0.0, 4.0, -4.0]))
    assert values[0] == 0
    assert values[1] == values[2] == graded.compliance(np.array([5.0]), np.array([0.0]))[0]
