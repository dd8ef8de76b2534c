"""Hardness in the block: pressures between 0 and H, by an active set of three kinds of nodes or reduced."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from surfaces import rough_surface

from fem_contact import BondedLayer, InvalidInput, Solid, bem, block, yielded

SOLID = Solid(young=1.0, poisson=0.3)
LOAD = 0.01
MESH = {"depth": 0.3, "growth": 1.5}


def rough(points=12, *, waves=4):
    return rough_surface((points, points), seed=31, waves=waves)


def pressed(hardness, *, surface=None, load=LOAD, method="reduced", **options):
    asked = {"mean_pressure": load, "method": method, "pressure_bound": hardness, "tolerance": 1e-9}
    found = block.solve(surface or rough(), SOLID, **(asked | MESH | options))
    return found.contact.checked()


@pytest.mark.parametrize("ratio", [1.01, 1.5, 4.0])
def test_the_active_set_and_the_reduction_solve_the_same_bounded_problem(ratio):
    full, reduced = (pressed(ratio * LOAD, method=method) for method in ("full", "reduced"))
    # Both stop at 1e-9 of their own residuals; displacements follow forces within a few times that.
    assert np.max(np.abs(full.pressure - reduced.pressure)) < 1e-6 * ratio * LOAD
    assert full.offset == pytest.approx(reduced.offset, abs=1e-7 * rough().rms_height)
    assert_array_equal(full.at_bound, reduced.at_bound)
    assert_array_equal(full.in_contact, reduced.in_contact)
    for contact in (full, reduced):
        found = yielded(contact)
        assert found.plastic_area > 0
        assert found.elastic_area + found.plastic_area + found.open_area == pytest.approx(1, abs=1e-14)
        assert found.elastic_load + found.plastic_load == pytest.approx(LOAD, rel=1e-8)
        assert found.plastic_load == pytest.approx(ratio * LOAD * found.plastic_area, rel=1e-8)
        assert contact.pressure.max() <= ratio * LOAD * (1 + 1e-9)
        assert contact.residuals.worst < 1e-7


def test_a_hardness_above_every_pressure_changes_no_bit_of_the_active_set():
    plain, bounded = pressed(None, method="full"), pressed(10.0, method="full")
    assert_array_equal(bounded.pressure, plain.pressure)
    assert_array_equal(bounded.gap, plain.gap)
    assert bounded.offset == plain.offset
    assert not bounded.at_bound.any()


@pytest.mark.parametrize("method", ["full", "reduced"])
def test_a_load_equal_to_the_hardness_yields_everywhere_and_above_it_is_refused(method):
    found = pressed(LOAD, method=method)
    assert yielded(found).plastic_area == 1
    # The offset of least indentation: one node is just touched.
    assert np.max(found.gap) == pytest.approx(0, abs=1e-7 * rough().rms_height)
    with pytest.raises(InvalidInput, match=r"pressure_bound with mean 0\.0099"):
        pressed(0.99 * LOAD, method=method)


@pytest.mark.parametrize("method", ["full", "reduced"])
def test_a_field_of_hardness_bounds_every_node_by_its_own(method):
    x = 2 * np.pi * np.arange(12) / 12
    field = 0.03 * (1.2 + np.sin(x))[:, None] * np.ones(12)
    contact = pressed(field, method=method)
    assert np.all(contact.pressure <= field * (1 + 1e-8))
    assert contact.at_bound.any()
    assert_allclose(contact.pressure[contact.at_bound], field[contact.at_bound], rtol=1e-8)
    with pytest.raises(InvalidInput, match="shape"):
        pressed(field[:6], method=method)


def test_quadratic_cells_count_areas_and_loads_by_the_weights_of_their_nodes():
    found = yielded(pressed(0.03, element="Hex2"))
    assert found.plastic_area > 0
    assert found.plastic_load == pytest.approx(0.03 * found.plastic_area, rel=1e-9)
    assert found.elastic_load + found.plastic_load == pytest.approx(LOAD, rel=1e-9)


def test_elements_approach_boundary_elements_as_the_grid_is_refined():
    hardness = 0.05
    layer = BondedLayer(solid=SOLID, thickness=1.0)
    differences = []
    for points in (16, 32, 64):
        surface = rough(points)
        finite = pressed(hardness, surface=surface, depth=1.0, growth=1.2)
        boundary = bem.solve(surface, layer, mean_pressure=LOAD, pressure_bound=hardness, threads=1).checked()
        apart = np.linalg.norm(finite.pressure - boundary.pressure)
        differences.append(apart / np.linalg.norm(boundary.pressure))
    # The pressure has kinks where it meets its bounds: better than first order in dx is not to be expected,
    # and cells that change sides scatter about it.
    assert differences[1] < 0.7 * differences[0]
    assert differences[2] < 0.7 * differences[1]
    assert differences[2] < 0.05
