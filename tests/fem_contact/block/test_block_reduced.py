from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from surfaces import rough_surface

from fem_contact import HeightField, InsufficientMemory, Solid, Status, bem
from fem_contact.block import ELEMENTS, BlockResponse, plan_mesh, solve, solve_displacement, solve_path
from fem_contact.block.full.assembled import assembled_field
from fem_contact.block.solution import ArraySource

SOLID = Solid(young=3e9, poisson=0.3)


def rough(shape, lengths=(1e-5, 1e-5), *, seed=7):
    return rough_surface(shape, lengths, seed=seed, waves=4)


def press(surface, solid=SOLID, reduced=0.05, **changes):
    pressure = reduced * solid.contact_modulus * surface.rms_gradient
    return solve(surface, solid, mean_pressure=pressure, **({"tolerance": 1e-12} | changes))


@pytest.mark.parametrize(
    ("element", "shape", "poisson"),
    [
        ("Hex1", (32, 32), 0.3),
        ("Hex1", (15, 21), 0.3),
        ("Hex2", (16, 16), 0.3),
        ("Hex1/P0", (12, 16), 0.4999),
        ("Hex2/P1disc", (12, 12), 0.4999),
        ("Hex2/P1disc", (10, 10), 0.41),
        ("Hex2/P1disc", (10, 10), 1e-9),
        ("Hex2/P1disc", (10, 10), 0.0),
    ],
)
def test_reduced_and_full_systems_have_one_solution(element, shape, poisson):
    surface = rough(shape, (1e-5, 1e-5 * shape[1] / shape[0]))
    solid = Solid(young=3e9, poisson=poisson)
    # Rounded displacements move the forces by eps |K| |u|. At nu = 0.4999 the bulk modulus in K is 1667 E,
    # and that is 3e-12 of the contact forces: no residual gets below it.
    full = press(surface, solid, method="full", element=element, tolerance=1e-11)
    reduced = press(surface, solid, element=element)
    a, b = full.contact.checked(), reduced.contact.checked()
    assert_array_equal(a.in_contact, b.in_contact)
    assert np.linalg.norm(a.pressure - b.pressure) < 1e-9 * np.linalg.norm(a.pressure)
    assert abs(a.offset - b.offset) < 1e-9 * np.ptp(surface.heights)
    assert np.abs(full.field - reduced.field).max() < 1e-9 * np.abs(full.field).max()
    stress = full.stress().tensor
    assert np.abs(stress - reduced.stress().tensor).max() < 1e-8 * np.abs(stress).max()


@pytest.mark.parametrize("element", ["Hex1", "Hex1/P0", "Hex2", "Hex2/P1disc"])
def test_field_balances_the_contact_forces_and_stores_their_work(element):
    solution = press(rough((14, 12), (1e-5, 0.9e-5)), element=element)
    found = solution.equilibrium()
    assert found.residual < 1e-12
    assert found.energy == pytest.approx(solution.energy, rel=1e-11)


def test_imbalance_of_a_wrong_field_is_seen():
    solution = press(rough((12, 12)))
    field = solution.field.copy()
    field[3, 4, -2, 2] += 1e-6 * np.abs(field).max()
    wrong = replace(solution, source=ArraySource(field=field))
    assert wrong.equilibrium().residual > 1e-9


def test_field_of_graded_and_of_patchy_blocks_balances():
    surface = rough((12, 12))
    assert press(surface, modulus=_crust).equilibrium().residual < 1e-10
    k = 2e5 * np.pi
    patchy = press(surface, modulus=lambda x, y, z: 1.5 + np.sin(k * x) * np.cos(k * y) + 0 * z)
    assert patchy.equilibrium().residual < 1e-10


def test_incompressible_block_keeps_its_volume_and_transmits_the_load():
    surface = rough((16, 16))
    solution = press(surface, Solid(young=3e9, poisson=0.5))
    contact = solution.contact.checked()
    assert contact.provenance["element"] == "Hex2/P1disc"
    weights = contact.weights
    assert weights is not None
    mean = np.mean(weights * contact.displacement)
    assert abs(mean) < 1e-12 * np.ptp(contact.displacement)
    strain = solution.strain()
    for layer in solution.source.descend():
        size = (*solution.cell_size, float(solution.layers[layer.index]))
        dilatation = layer.mean_dilatation(size, solution.mesh.element)
        assert np.abs(dilatation).max() < 1e-11 * np.abs(strain).max()
    bottom = solution.stress().tensor[..., 2][:, :, 0]
    assert bottom.mean() == pytest.approx(-contact.mean_pressure, rel=5e-2)


def test_incompressible_limit_is_reached_continuously():
    surface = rough((16, 16))
    limit = press(surface, Solid(young=3e9, poisson=0.5)).contact
    errors = []
    for gap in (1e-3, 1e-5):
        near = press(surface, Solid(young=3e9, poisson=0.5 - gap), element="Hex2/P1disc").contact
        errors.append(np.linalg.norm(near.pressure - limit.pressure) / np.linalg.norm(limit.pressure))
    assert errors[0] < 1e-2
    assert errors[1] < 2e-2 * errors[0]


@pytest.mark.parametrize("depth", [1e-7, 1e-4])
def test_very_thin_and_very_deep_blocks_are_solved(depth):
    solution = press(rough((24, 24)), depth=depth)
    nu, contact = SOLID.poisson, solution.contact.checked()
    uniaxial = depth * (1 + nu) * (1 - 2 * nu) / (1 - nu) / SOLID.young
    assert contact.displacement.mean() == pytest.approx(uniaxial * contact.mean_pressure, rel=1e-9)
    if depth == 1e-7:
        # Far thinner than any wave, the block is a bed of springs.
        local = contact.displacement[contact.in_contact] / contact.pressure[contact.in_contact]
        assert np.median(local) == pytest.approx(uniaxial, rel=0.05)


@pytest.mark.parametrize(("slope", "shape"), [(1e-6, (17, 19)), (10.0, (23, 13))])
def test_faint_and_steep_roughness_on_prime_grids_is_solved(slope, shape):
    surface = rough(shape, (1e-5, 1e-5 * shape[1] / shape[0]))
    scaled = HeightField(heights=surface.heights * (slope / 0.1), lengths=surface.lengths)
    reference, contact = press(surface).contact.checked(), press(scaled).contact.checked()
    assert_array_equal(contact.in_contact, reference.in_contact)
    exact = reference.pressure / 0.1
    assert_allclose(contact.pressure / slope, exact, atol=1e-9 * exact.max())


@pytest.mark.parametrize("method", ["full", "reduced"])
def test_surfaces_held_apart_bear_nothing(method):
    surface = rough((12, 12))
    solution = solve_displacement(surface, SOLID, offset=1.01 * float(surface.heights.max()), method=method)
    contact = solution.contact.checked()
    assert contact.mean_pressure == 0
    assert not contact.in_contact.any()
    assert contact.gap.min() > 0
    assert not solution.field.any()
    assert "nothing to solve" in contact.provenance["method"]
    assert solution.equilibrium().residual == 0
    assert not assembled_field(solution, tolerance=1e-8).any()


def test_flat_surface_driven_in_by_an_approach_compresses_uniformly():
    surface = HeightField(heights=np.full((6, 8), 2e-7), lengths=(1e-5, 1e-5))
    nu, approach = SOLID.poisson, 1e-8
    exact = approach / 1e-5 * SOLID.young * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    for method in ("full", "reduced"):
        asked = {"offset": 2e-7 - approach, "method": method, "tolerance": 1e-11}
        contact = solve_displacement(surface, SOLID, **asked).contact
        assert_allclose(contact.checked().pressure, exact, rtol=1e-9)


@pytest.mark.parametrize("method", ["full", "reduced"])
def test_a_path_up_and_down_equals_its_single_solves(method):
    surface = rough((16, 12), (1e-5, 0.75e-5))
    unit = SOLID.contact_modulus * surface.rms_gradient
    loads = [unit * p for p in (0.03, 0.2, 0.05)]
    path = solve_path(surface, SOLID, mean_pressures=loads, method=method, tolerance=1e-11)
    for load, solution in zip(loads, path, strict=True):
        alone = solve(surface, SOLID, mean_pressure=load, tolerance=1e-11).contact
        contact = solution.contact.checked()
        assert_array_equal(contact.in_contact, alone.in_contact)
        assert_allclose(contact.pressure, alone.pressure, atol=1e-8 * alone.pressure.max())


def _crust(x, y, z):
    return np.where(z > -2e-6, 1e4, 1.0)


def _alternating(x, y, z):
    return np.where(np.arange(z.size) % 2 == 0, 1e4, 1.0)[None, None]


def _tied():
    surface = rough((20, 20))
    step = surface.rms_height / 2
    return HeightField(heights=np.round(surface.heights / step) * step, lengths=surface.lengths)


HARD = {
    "stiff crust, contrast 1e4": {"modulus": _crust},
    "alternating layers, contrast 1e4": {"modulus": _alternating},
    "depth L/100": {"depth": 1e-7},
    "depth 100 L": {"depth": 1e-3},
    "depth 100 L of quadratic cells": {"depth": 1e-3, "element": "Hex2"},
    "thin first layer": {"first_layer": 1e-9},
    "equal layers": {"growth": 1.0, "depth": 5e-6},
    "layers of fast growth": {"growth": 50.0},
    "flat cells": {"depth": 1e-6, "first_layer": 1e-8, "growth": 2.0},
    "oblong": {"surface": rough((16, 16), (1e-5, 3e-5))},
    "heights with ties": {"surface": _tied()},
    "nearly no load": {"reduced": 1e-5},
    "nearly full contact": {"reduced": 0.9},
    "locking element, nearly incompressible": {"solid": Solid(young=3e9, poisson=0.4999), "element": "Hex1"},
    "negative Poisson ratio": {"solid": Solid(young=3e9, poisson=-0.9)},
}


@pytest.mark.parametrize("name", HARD)
def test_hard_cases_have_one_solution_by_both_methods(name):
    told = {"surface": rough((12, 10))} | HARD[name]
    full = press(**(told | {"method": "full", "tolerance": 1e-10})).contact.checked()
    reduced = press(**told).contact.checked()
    assert full.cost.linear_iterations < 3000
    assert_array_equal(full.in_contact, reduced.in_contact)
    assert np.linalg.norm(full.pressure - reduced.pressure) < 1e-8 * np.linalg.norm(full.pressure)


def test_field_beyond_memory_is_refused_while_layers_still_flow(monkeypatch):
    import psutil

    solution = press(rough((16, 16)))
    scarce = psutil.virtual_memory()._replace(available=1000)
    monkeypatch.setattr(psutil, "virtual_memory", lambda: scarce)
    for ask in (lambda: solution.field, solution.stress, solution.strain):
        with pytest.raises(InsufficientMemory, match="stress_layers"):
            ask()
    assert sum(1 for _ in solution.stress_layers()) == solution.layers.size
    quadratic = replace(solution, source=replace(solution.source, response=_quadratic_response((16, 16))))
    with pytest.raises(InsufficientMemory, match="trilinear"):
        next(quadratic.stress_layers())


def _quadratic_response(shape):
    mesh = plan_mesh(shape, (1.0, 1.0), element=ELEMENTS["Hex2"])
    return BlockResponse(mesh=mesh, solid=Solid(young=1.0, poisson=0.3), width=1.0)


def test_boundary_element_solver_accepts_the_block_as_its_response():
    surface = rough((40, 36), (1e-5, 0.9e-5))
    mesh = plan_mesh(surface.shape, surface.lengths)
    response = BlockResponse(mesh=mesh, solid=SOLID, width=surface.spacing[0])
    pressure = 0.05 * SOLID.contact_modulus * surface.rms_gradient
    through = bem.solve(surface, response, mean_pressure=pressure, tolerance=1e-12).checked()
    direct = solve(surface, SOLID, mean_pressure=pressure, tolerance=1e-12).contact.checked()
    assert_array_equal(through.in_contact, direct.in_contact)
    assert np.linalg.norm(through.pressure - direct.pressure) < 1e-9 * np.linalg.norm(direct.pressure)
    assert through.offset == pytest.approx(direct.offset, abs=1e-9 * np.ptp(surface.heights))


@pytest.mark.parametrize("left", [1e-3, float("nan")])
def test_a_direct_answer_is_converged_only_where_its_residual_says_so(monkeypatch, left):
    from fem_contact.block.problem import Problem

    surface = rough((12, 12))
    assert press(surface, reduced=10.0).contact.status is Status.CONVERGED
    monkeypatch.setattr(Problem, "violation", lambda *_: left)
    assert press(surface, reduced=10.0).contact.status is Status.STAGNATED
