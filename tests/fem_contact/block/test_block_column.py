import numpy as np
import pytest
import scipy.sparse.linalg as sla
from numpy.testing import assert_allclose

from fem_contact import Solid
from fem_contact.block import ELEMENTS, BlockMesh, BlockResponse, graded_layers, plan_mesh
from fem_contact.block.elements import element_for
from fem_contact.block.full.assembly import above_bottom, assemble
from fem_contact.block.reduced.column import fold, surface_compliance
from fem_contact.block.reduced.fields import FourierSource
from fem_contact.block.reduced.surface import surface_operator

UNIT = Solid(young=1.0, poisson=0.3)

#: Shares of a uniform pressure carried by the kinds of nodes: corner, two kinds of edges, centre.
SHARES = {1: np.ones(1), 2: np.array([1, 2, 2, 4]) / 9}


def bonded_layer(q, *, depth, poisson):
    """Compliance of a layer on a rigid base without tangential traction, times Young's modulus."""
    k, a = 3 - 4 * poisson, q * depth
    if a > 300:
        return 2 * (1 - poisson**2) / q
    shape = (k * np.sinh(2 * a) - 2 * a) / (k * np.cosh(2 * a) + 2 * a**2 + (k**2 + 1) / 2)
    return float(2 * (1 - poisson**2) / q * shape)


def mesh_of(element, *, growth=1.5):
    return plan_mesh((5 * element.order, 8), (1.0, 1.2), element=element, growth=growth)


def wave_error(element, poisson, *, nodes, growth, diagonal=False):
    """Relative error of the compliance of a wave of some nodes per wavelength on a deep block.

    Quadratic elements respond as a pressure wave of equal value at all kinds of nodes sees it: forces by node
    area, displacement averaged with the same areas.
    """
    mesh = plan_mesh((256, 256), (1.0, 1.0), element=element, growth=growth)
    phase = 2 * np.pi * element.order / nodes
    phases = np.array([[phase, phase]]) / np.sqrt(2) if diagonal else np.array([[phase, 0.0]])
    matrix = surface_compliance(fold(mesh, poisson=poisson), phases)[0]
    share = SHARES[element.order]
    found = share @ matrix @ share
    return float(found / bonded_layer(phase, depth=-mesh.planes[0], poisson=poisson) - 1)


@pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)
def test_surface_and_field_equal_the_inverse_of_the_assembled_matrix(element):
    mesh = mesh_of(element)
    matrix = above_bottom(assemble(mesh, poisson=0.3), mesh)
    force = np.random.default_rng(4).standard_normal(mesh.shape)
    planes = mesh.planes.size
    right = np.zeros((*mesh.shape, planes - 1, 3))
    right[:, :, -1, 2] = -force
    exact = sla.spsolve(matrix.tocsc(), right.ravel()).reshape(right.shape)
    response = BlockResponse(mesh=mesh, solid=UNIT, width=1.0)
    surface = np.empty(mesh.shape)
    surface_operator(response).apply(force * element.types / mesh.aspect, surface)
    assert_allclose(surface, -exact[:, :, -1, 2], atol=1e-12 * np.abs(exact).max())
    field = np.zeros((*mesh.shape, planes, 3))
    for layer in FourierSource(response=response, force=force, width=1.0).descend():
        first = element.order * layer.index
        field[:, :, first : first + element.order + 1] = np.moveaxis(layer.nodes, 0, 2)
    assert_allclose(field[:, :, 1:], exact, atol=1e-12 * np.abs(exact).max())
    assert not field[:, :, 0].any()


@pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)
def test_inverse_returns_the_force_up_to_a_uniform_pressure(element):
    mesh = mesh_of(element)
    operator = surface_operator(BlockResponse(mesh=mesh, solid=UNIT, width=1.0))
    force = np.random.default_rng(9).standard_normal(mesh.shape)
    moved, back = np.empty(mesh.shape), np.empty(mesh.shape)
    operator.apply(force, moved)
    operator.invert(moved, back)
    assert abs(back.mean()) < 1e-12
    difference = force - back
    again = np.empty(mesh.shape)
    operator.apply(difference, again)
    assert np.ptp(again) < 1e-11 * np.abs(again).max()


@pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)
@pytest.mark.parametrize("poisson", [-0.3, 0.3, 0.49])
def test_uniform_pressure_compresses_by_the_closed_form(element, poisson):
    mesh = mesh_of(element)
    share = SHARES[element.order]
    moved = surface_compliance(fold(mesh, poisson=poisson), np.zeros((1, 2)))[0] @ share * mesh.aspect
    exact = -mesh.planes[0] * (1 + poisson) * (1 - 2 * poisson) / (1 - poisson)
    assert_allclose(moved, exact, rtol=2e-12)


def test_incompressible_block_does_not_yield_to_uniform_pressure():
    element = element_for(None, poisson=0.5)
    mesh = mesh_of(element)
    matrix = surface_compliance(fold(mesh, poisson=0.5), np.zeros((1, 2)))[0]
    assert np.abs(matrix @ SHARES[2]).max() < 1e-13 * np.abs(matrix).max()
    assert np.linalg.eigvalsh(matrix)[1:].min() > 1e-3 * np.abs(matrix).max()


def solved_at_once(folded, phase):
    """Vertical displacement of the surface under unit vertical forces: all planes of one column together."""
    functions = [np.array([1, np.cos(t / 2), np.cos(t), np.sin(t / 2), np.sin(t)]) for t in phase]
    layers = np.einsum("lijrc,i,j->lrc", folded.coefficients, *functions)
    plane = folded.plane
    step = layers.shape[1] - plane
    matrix = np.zeros((len(layers) * step + plane,) * 2)
    for index, layer in enumerate(layers):
        own = slice(index * step, index * step + step + plane)
        matrix[own, own] += layer
    forces = np.zeros((len(matrix), folded.types))
    forces[-plane + 2 :: 3] = np.eye(folded.types)
    return np.linalg.solve(matrix[plane:, plane:], forces[plane:])[-plane + 2 :: 3]


@pytest.mark.parametrize("poisson", [-0.5, 0.3, 0.4])
@pytest.mark.parametrize(("growth", "first", "aspect"), [(1.2, 1.0, 1.0), (1.05, 0.1, 0.2), (3.0, 6.0, 5.0)])
def test_layers_that_no_wave_reaches_change_nothing(poisson, growth, first, aspect):
    layers = graded_layers(200.0, first=first, growth=growth)[::-1]
    mesh = BlockMesh(cells=(8, 8), aspect=aspect, layers=layers, element=element_for(None, poisson=poisson))
    moduli = np.random.default_rng(8).uniform(0.1, 10, mesh.nz)
    solid = Solid(young=1.0, poisson=poisson)
    response = BlockResponse(mesh=mesh, solid=solid, width=1.0, layer_modulus=moduli)
    angles = np.linspace(0, np.pi / 2, 5)
    for size in np.geomspace(0.01, np.pi, 9):
        phases = size * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        whole = surface_compliance(response.folded, phases, states=np.empty((mesh.nz, 5, 6)))
        short = surface_compliance(response.folded, phases)
        # Rounding of some hundred eliminations.
        assert_allclose(short, whole, rtol=0, atol=1e-12 * np.abs(whole).max())


@pytest.mark.parametrize("width", [1.0, 1.5])
def test_a_table_of_waves_is_that_of_each_alone(width):
    mesh = plan_mesh((12, 12), (1.0, width))
    response = BlockResponse(mesh=mesh, solid=Solid(young=2.0, poisson=0.3), width=0.25)
    qx, qy = np.linspace(-8, 8, 13)[:, None], np.linspace(0, 8, 7)[None, :]
    table = response.compliance(qx, qy)
    alone = np.array([[response.compliance(x, y) for y in qy[0]] for x in qx[:, 0]])
    assert_allclose(table, alone, rtol=1e-12)


PAIRS = [("Hex1", 0.3), ("Hex1/P0", 0.49), ("Hex2", 0.3), ("Hex2/P1disc", 0.3), ("Hex2/P1disc", 0.5)]


@pytest.mark.parametrize(("name", "poisson"), PAIRS)
def test_compiled_elimination_solves_whole_columns(name, poisson):
    mesh = mesh_of(ELEMENTS[name])
    folded = fold(mesh, poisson=poisson, modulus=np.random.default_rng(6).uniform(0.1, 10, mesh.nz))
    phases = np.random.default_rng(3).uniform(-np.pi, np.pi, (37, 2))
    phases[0], phases[1] = 0, np.pi
    twin = np.array([solved_at_once(folded, phase) for phase in phases])
    assert_allclose(surface_compliance(folded, phases), twin, atol=2e-12 * np.abs(twin).max())


def refined_error(element, poisson, nodes):
    """Error of one diagonal wave on a block whose growth - 1 shrinks with the cell."""
    shape, lengths = (nodes, 2 * element.order), (float(nodes), 2.0 * element.order)
    growth = 1 + 1.6 * element.order / nodes
    mesh = plan_mesh(shape, lengths, depth=float(nodes), element=element, growth=growth)
    phase = 2 * np.pi * element.order / nodes
    matrix = surface_compliance(fold(mesh, poisson=poisson), np.array([[phase, phase]]) / np.sqrt(2))[0]
    share = SHARES[element.order]
    return float(share @ matrix @ share) / bonded_layer(phase, depth=-mesh.planes[0], poisson=poisson) - 1


def test_incompressible_limit_over_grids_is_at_least_of_third_order():
    # The error of this element changes its sign on the way, so that no order can be read off a pair of grids.
    for nodes in (16, 32, 64, 128):
        assert abs(refined_error(ELEMENTS["Hex2/P1disc"], 0.5, nodes)) < 1e-3 * (16 / nodes) ** 3


def test_trilinear_elements_lock_where_the_projected_ones_do_not():
    locked = wave_error(ELEMENTS["Hex1"], 0.49, nodes=16, growth=1.2)
    free = wave_error(ELEMENTS["Hex1/P0"], 0.49, nodes=16, growth=1.2)
    assert locked < -0.1
    assert abs(free) < 0.015
