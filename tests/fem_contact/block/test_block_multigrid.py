"""The full system on the grids of its multigrid: kernels, cycle, contact."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from surfaces import rough_surface

from fem_contact import Solid
from fem_contact.block import ELEMENTS, estimate, plan_mesh, solve
from fem_contact.block.full import kernels
from fem_contact.block.full.assembly import above_bottom, assemble
from fem_contact.block.full.block import Block
from fem_contact.block.full.cells import overlap_means
from fem_contact.block.full.linear import conjugate_gradients
from fem_contact.block.full.multigrid import Transfer, build_hierarchy
from fem_contact.block.full.quadratic import QuadraticBlock, parity_blocks, refined_hierarchy
from fem_contact.block.session import needed_bytes

SOLID = Solid(young=1.0, poisson=0.3)


def rough(shape=(32, 32), lengths=(1.0, 1.0), *, seed=17, waves=4):
    return rough_surface(shape, lengths, seed=seed, waves=waves)


def hierarchy_of(shape=(6, 8), lengths=(1.0, 1.1), *, element="Hex1", poisson=0.3, layered=False, **mesh):
    planned = plan_mesh(shape, lengths, element=ELEMENTS[element], **mesh)
    modulus = np.linspace(1.0, 7.0, planned.nz) if layered else None
    return planned, build_hierarchy(planned, poisson=poisson, modulus=modulus), modulus


def cell_moduli(mesh, contrast, *, seed=15):
    """Moduli of the cells, each for itself."""
    return contrast ** (np.random.default_rng(seed).random((*mesh.cells, mesh.nz)) - 0.5)


def some_tied(shape, *, seed=5):
    tied = np.random.default_rng(seed).random(shape) < 0.2
    tied[1:3, 2:4] = True
    return tied


def twin_interpolation(fine, coarse):
    """Dense matrix of linear interpolation between two periodic grids with node 0 in common."""
    matrix = np.zeros((fine, coarse))
    for i in range(fine):
        place = i * coarse / fine
        low = int(np.floor(place + 1e-12))
        matrix[i, low % coarse] += 1 - (place - low)
        matrix[i, (low + 1) % coarse] += place - low
    return matrix


@pytest.mark.parametrize("element", ["Hex1", "Hex1/P0"])
@pytest.mark.parametrize("shape", [(6, 8), (5, 7), (3, 4)])
@pytest.mark.parametrize("moduli", ["one", "layers", "cells"])
def test_the_stencil_is_the_assembled_matrix(element, shape, moduli):
    mesh, modulus = plan_mesh(shape, (1.0, 1.1), element=ELEMENTS[element]), None
    if moduli != "one":
        modulus = np.linspace(1.0, 7.0, mesh.nz) if moduli == "layers" else cell_moduli(mesh, 100.0)
    each = None if modulus is None else np.broadcast_to(modulus, (*mesh.cells, mesh.nz))
    matrix = above_bottom(assemble(mesh, poisson=0.41, modulus=each), mesh)
    u = np.random.default_rng(9).standard_normal(matrix.shape[0])
    exact, hierarchy = matrix @ u, build_hierarchy(mesh, poisson=0.41, modulus=modulus)
    found = Block(hierarchy=hierarchy, heights=np.zeros(shape)).apply(u)
    assert_allclose(found, exact, rtol=0, atol=1e-14 * np.abs(exact).max())


@pytest.mark.parametrize("shape", [(2, 1), (1, 1)])
def test_few_columns_bear_what_their_periods_do_on_a_larger_grid(shape):
    both = [hierarchy_of(cells, cells, layered=True, depth=2.0)[1] for cells in (shape, (6, 4))]
    few, many = (hierarchy.levels[0] for hierarchy in both)
    u, times = (
        np.random.default_rng(31).standard_normal(few.field_shape),
        (6 // shape[0], 4 // shape[1], 1, 1),
    )
    exact = many.apply(np.tile(u, times))
    assert_allclose(np.tile(few.apply(u), times), exact, atol=1e-13 * np.abs(exact).max())


GRIDS = {(8, 6): (4, 3), (7, 5): (4, 3), (6, 5): (6, 3), (2, 1): (1, 1)}


@pytest.mark.parametrize(("fine", "coarse"), GRIDS.items())
def test_transfer_between_grids_is_its_twin_and_transposed(fine, coarse):
    transfers = [Transfer.between(f, c) for f, c in zip(fine, coarse, strict=True)]
    tables = [table for t in transfers for table in (t.low, t.weight)]
    matrix = np.kron(*(twin_interpolation(f, c) for f, c in zip(fine, coarse, strict=True)))
    generator = np.random.default_rng(33)
    values, forces = generator.standard_normal((*coarse, 4)), generator.standard_normal((*fine, 4))
    up, down = np.zeros((*fine, 4)), np.zeros((*coarse, 4))
    kernels.transfer(values, *tables, up, False)
    kernels.transfer(down, *tables, forces, True)
    assert_allclose(up.reshape(-1, 4), matrix @ values.reshape(-1, 4), atol=1e-14)
    assert_allclose(down.reshape(-1, 4), matrix.T @ forces.reshape(-1, 4), atol=1e-14)


def test_a_coarser_grid_is_what_interpolation_makes_of_the_finer_one():
    _, hierarchy, _ = hierarchy_of((8, 6), layered=True)
    fine, coarse = hierarchy.levels[:2]
    u = np.random.default_rng(34).standard_normal(coarse.field_shape)
    exact = fine.restricted(fine.apply(fine.prolonged(u)))
    assert_allclose(coarse.apply(u), exact, atol=1e-12 * np.abs(exact).max())


@pytest.mark.parametrize("backward", [False, True])
@pytest.mark.parametrize("layered", [False, True])
def test_relaxing_cells_of_a_modulus_each_solves_one_column_after_the_other(layered, backward):
    mesh = plan_mesh((4, 6), (1.0, 1.1))
    modulus = np.linspace(1.0, 7.0, mesh.nz) if layered else cell_moduli(mesh, 100.0)
    moduli = np.broadcast_to(modulus, (*mesh.cells, mesh.nz))
    matrix = above_bottom(assemble(mesh, poisson=0.3, modulus=moduli), mesh).toarray()
    level = build_hierarchy(mesh, poisson=0.3, modulus=modulus).levels[0]
    u, f = np.random.default_rng(32).standard_normal((2, *level.field_shape))
    tied = some_tied((4, 6))
    exact, numbers = u.copy().ravel(), np.arange(u.size).reshape(4, 6, -1)
    for colour in (3, 2, 1, 0) if backward else (0, 1, 2, 3):
        for i in range(colour // 2, 4, 2):
            for j in range(colour % 2, 6, 2):
                free = numbers[i, j][: -1 if tied[i, j] else None]
                left = f.ravel()[free] - matrix[free] @ exact
                exact[free] += np.linalg.solve(matrix[np.ix_(free, free)], left)
    level.relax(f, tied, u, backward=backward)
    assert_allclose(u.ravel(), exact, atol=1e-12 * np.abs(exact).max())


@pytest.mark.parametrize("shape", [(8, 6), (7, 5), (2, 1)])
def test_moduli_that_are_the_same_sideways_make_the_same_cycle(shape):
    mesh, layered, modulus = hierarchy_of(shape, layered=True)
    cells = build_hierarchy(mesh, poisson=0.3, modulus=np.broadcast_to(modulus, (*shape, mesh.nz)))
    assert [level.shape for level in cells.levels] == [level.shape for level in layered.levels]
    forces = np.random.default_rng(37).standard_normal(layered.levels[0].field_shape)
    held = np.random.default_rng(5).random(shape) < 0.3
    forces[held, -1, 2] = 0
    exact, found = (grids.cycle(forces, grids.tied(held)) for grids in (layered, cells))
    assert_allclose(found, exact, atol=1e-11 * np.abs(exact).max())


def test_moduli_of_a_coarser_grid_are_means_over_its_cells():
    modulus = np.random.default_rng(38).random((6, 5, 3))
    halved = modulus.reshape(3, 2, 5, 3).mean(axis=1)
    assert_allclose(overlap_means(modulus, (3, 5)), halved, rtol=1e-14)
    # Five cells on three: each takes one cell and two thirds of the next, or of both beside it one third.
    odd = overlap_means(modulus, (6, 3))
    assert_allclose(odd[:, 0], 0.6 * modulus[:, 0] + 0.4 * modulus[:, 1], rtol=1e-14)
    thirds = 0.2 * modulus[:, 1] + 0.6 * modulus[:, 2] + 0.2 * modulus[:, 3]
    assert_allclose(odd[:, 1], thirds, rtol=1e-14)
    assert_allclose(odd.mean(axis=(0, 1)), modulus.mean(axis=(0, 1)), rtol=1e-14)


@pytest.mark.parametrize("shape", [(8, 6), (7, 5)])
@pytest.mark.parametrize("contrast", [1.0, 1e4])
def test_the_cycle_is_symmetric_and_positive(shape, contrast):
    mesh, hierarchy, _ = hierarchy_of(shape)
    if contrast > 1:
        hierarchy = build_hierarchy(mesh, poisson=0.3, modulus=cell_moduli(mesh, contrast))
    tied = hierarchy.tied(some_tied(shape))
    x, y = np.random.default_rng(35).standard_normal((2, *hierarchy.levels[0].field_shape))
    x[tied[0], -1, 2] = y[tied[0], -1, 2] = 0
    into_x, into_y = hierarchy.cycle(x, tied), hierarchy.cycle(y, tied)
    assert np.vdot(into_x, y) == pytest.approx(np.vdot(x, into_y), rel=1e-12)
    assert np.vdot(into_x, x) > 0
    assert not into_x[tied[0], -1, 2].any()


def test_a_single_column_is_solved_exactly():
    _, hierarchy, _ = hierarchy_of((1, 1), layered=True)
    level = hierarchy.levels[0]
    f = np.random.default_rng(36).standard_normal(level.field_shape)
    u = hierarchy.cycle(f, (np.zeros((1, 1), dtype=bool),))
    assert_allclose(level.apply(u), f, atol=1e-12)


def steps_of(hierarchy, tied, block=None):
    """Conjugate-gradient steps to 1e-8 under random forces with tied nodes."""
    block = block or Block(hierarchy=hierarchy, heights=np.zeros(tied.shape))
    masks, held = hierarchy.tied(tied), block.vertical(tied)
    shape = hierarchy.levels[0].field_shape

    def apply(u):
        forces = block.apply(u)
        forces[held] = 0
        return forces

    right = np.zeros(shape)
    right[:, :, -1, 2] = np.random.default_rng(3).standard_normal(tied.shape)
    right = right.ravel()
    right[held] = 0
    told = {"start": np.zeros_like(right), "scale": float(np.linalg.norm(right)), "tolerance": 1e-8}
    told["precondition"] = lambda r: hierarchy.cycle(r.reshape(shape), masks).ravel()
    found = conjugate_gradients(apply, right, max_iterations=300, **told)
    assert found.converged
    return found.iterations


def patches(shape):
    """Pairs of nodes on a side, wherever they fall on the coarser grids."""
    tied, generator = np.zeros(shape, dtype=bool), np.random.default_rng(3)
    for _ in range(shape[0] * shape[1] // 64):
        i, j = (int(generator.integers(n)) for n in shape)
        tied[i : i + 2, j : j + 2] = True
    return tied


def stripes(mesh, contrast):
    """Of four cells, the hardest pattern found."""
    rows = np.where(np.arange(mesh.cells[0]) % 8 < 4, contrast, 1.0)[:, None, None]
    return np.broadcast_to(rows, (*mesh.cells, mesh.nz))


def steps(*, shape=(32, 32), lengths=(1.0, 1.0), poisson=0.3, moduli=None, contrast=10.0, **options):
    mesh = plan_mesh(shape, lengths, **options)
    modulus = None if moduli is None else moduli(mesh, contrast)
    return steps_of(build_hierarchy(mesh, poisson=poisson, modulus=modulus), patches(shape))


@pytest.mark.parametrize(
    ("changes", "most"),
    [
        ({"shape": (16, 16)}, 13),
        ({"shape": (48, 48)}, 14),
        ({"shape": (33, 27)}, 14),
        ({"poisson": 0.45}, 21),
        ({"depth": 100.0}, 14),
        ({"depth": 0.01}, 14),
        ({"first_layer": 1e-6}, 14),
        ({"growth": 1.02}, 14),
        ({"lengths": (1.0, 8.0)}, 18),
        ({"lengths": (50.0, 1.0)}, 18),
        ({"shape": (16, 16), "moduli": cell_moduli}, 14),
        ({"moduli": cell_moduli}, 14),
        ({"moduli": cell_moduli, "contrast": 100.0}, 18),
        ({"moduli": stripes}, 18),
        ({"moduli": stripes, "contrast": 100.0}, 37),
    ],
)
def test_steps_depend_little_on_grid_cells_and_contrast(changes, most):
    """The limits are the steps that were counted, and some one in eight more."""
    assert steps(**changes) <= most


def quadratic(shape, *, element="Hex2", poisson=0.3, modulus=None, lengths=(1.0, 1.0), **mesh):
    """A block of triquadratic cells, whose moduli are a function of the mesh."""
    planned = plan_mesh(shape, lengths, element=ELEMENTS[element], **mesh)
    moduli = None if modulus is None else modulus(planned)
    return QuadraticBlock(
        mesh=planned,
        heights=np.zeros(shape),
        cells=parity_blocks(planned, poisson=poisson),
        modulus=np.ones((*planned.cells, planned.nz)) if moduli is None else moduli,
        hierarchy=refined_hierarchy(planned, poisson=poisson, modulus=moduli),
    )


@pytest.mark.parametrize(
    ("shape", "element", "poisson"),
    [((6, 8), "Hex2", 0.3), ((10, 6), "Hex2/P1disc", 0.4999), ((6, 6), "Hex2/P1disc", -0.4)],
)
def test_blocks_by_parity_sum_to_the_assembled_matrix(shape, element, poisson):
    told = {"element": element, "poisson": poisson, "lengths": (1.0, 1.1)}
    block = quadratic(shape, modulus=lambda mesh: cell_moduli(mesh, 100.0), **told)
    matrix = above_bottom(assemble(block.mesh, poisson=poisson, modulus=block.modulus), block.mesh)
    u = np.random.default_rng(39).standard_normal(matrix.shape[0])
    exact = matrix @ u
    assert_allclose(block.apply(u), exact, rtol=0, atol=1e-14 * np.abs(exact).max())


@pytest.mark.parametrize(
    ("n", "element", "poisson", "contrast", "most"),
    [
        (8, "Hex2", 0.3, 1.0, 30),
        (20, "Hex2", 0.3, 1.0, 30),
        (16, "Hex2", 0.45, 1.0, 38),
        (20, "Hex2/P1disc", 0.3, 1.0, 34),
        (16, "Hex2/P1disc", 0.49, 1.0, 86),
        (16, "Hex2/P1disc", 0.4999, 1.0, 177),
        (20, "Hex2", 0.3, 100.0, 35),
    ],
)
def test_trilinear_cells_between_nodes_precondition_triquadratic_ones(n, element, poisson, contrast, most):
    """26, 27, 33, 30, 76, 157 and 31 were counted."""
    depth = {} if contrast > 1 else {"depth": 0.7}
    moduli = (lambda mesh: cell_moduli(mesh, contrast)) if contrast > 1 else None
    block = quadratic((n, n), element=element, poisson=poisson, modulus=moduli, **depth)
    assert steps_of(block.hierarchy, patches((n, n)), block) <= most


def test_a_nested_first_set_saves_sets_and_changes_nothing():
    surface = rough((48, 48))
    load = 0.05 * SOLID.contact_modulus * surface.rms_gradient
    nested = solve(surface, SOLID, mean_pressure=load, method="full", tolerance=1e-9)
    everything = np.ones(surface.shape, dtype=bool)
    plain = solve(surface, SOLID, mean_pressure=load, method="full", tolerance=1e-9, start=everything)
    assert_array_equal(nested.contact.checked().in_contact, plain.contact.checked().in_contact)
    assert_allclose(nested.contact.pressure, plain.contact.pressure, atol=1e-8 * load)
    assert nested.contact.cost.iterations <= 4 < plain.contact.cost.iterations


def test_each_solver_of_the_full_system_is_named():
    surface = rough((10, 10))
    load = 0.05 * SOLID.contact_modulus * surface.rms_gradient

    def told(**options):
        options |= {"mean_pressure": load, "method": "full", "depth": 0.3}
        return solve(surface, SOLID, **options).contact.provenance

    for element in ("Hex1", "Hex1/P0"):
        assert "geometric multigrid" in told(element=element)["method"]
    assert "trilinear cells between the nodes" in told(element="Hex2")["method"]
    lateral = {"modulus": lambda x, y, z: 1 + 0.1 * np.cos(2 * np.pi * x) + 0 * z}
    assert "geometric multigrid" in told(**lateral)["method"]
    assert "trilinear cells between the nodes" in told(element="Hex2/P1disc", **lateral)["method"]


@pytest.mark.parametrize(
    "options",
    [{}, {"element": "Hex2"}, {"modulus": lambda x, y, z: 1 + 0.1 * np.cos(2 * np.pi * x) + 0 * z}],
    ids=["trilinear", "triquadratic", "sideways"],
)
def test_the_estimate_holds_the_memory_that_is_used(options):
    import tracemalloc

    surface = rough((32, 32))
    load = 0.05 * SOLID.contact_modulus * surface.rms_gradient
    solve(rough((16, 16)), SOLID, mean_pressure=load, method="full", **options)
    tracemalloc.start()
    found = solve(surface, SOLID, mean_pressure=load, method="full", **options)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # Fields alone, without the interpreter and its libraries.
    planned = needed_bytes(found.mesh, "full", lateral="modulus" in options)
    fields = planned - estimate((1, 1), method="full").bytes
    assert 0.6 * fields < peak < fields
