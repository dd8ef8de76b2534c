import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from surfaces import rough_surface

from fem_contact import Solid
from fem_contact.block import estimate, solve
from fem_contact.surface import HeightField

SOLID = Solid(young=3e9, poisson=0.3)


def rough(shape, lengths=(1e-5, 1e-5), *, seed=7):
    return rough_surface(shape, lengths, seed=seed, waves=4)


def press(surface, reduced=0.05, **changes):
    pressure = reduced * SOLID.contact_modulus * surface.rms_gradient
    return solve(surface, SOLID, mean_pressure=pressure, **({"method": "full"} | changes))


@pytest.fixture(scope="module")
def solution():
    return press(rough((20, 20)))


@pytest.mark.parametrize("element", ["Hex1/P0", "Hex2/P1disc"])
def test_a_nearly_incompressible_block_ends_where_rounding_stops_it_and_is_right(element):
    """Its residual stays above 1e-12 of the forces: it was called stagnated, though right to 1e-12."""
    surface = rough((12, 12), seed=8)
    solid = Solid(young=3e9, poisson=0.4999)
    told = {"mean_pressure": 0.05 * solid.contact_modulus * surface.rms_gradient, "element": element}
    full = solve(surface, solid, method="full", tolerance=1e-13, **told).contact.checked()
    reduced = solve(surface, solid, tolerance=1e-14, **told).contact
    assert np.array_equal(full.in_contact, reduced.in_contact)
    assert np.abs(full.pressure - reduced.pressure).max() < 5e-12 * reduced.pressure.max()


@pytest.mark.parametrize(("method", "element"), [("full", "Hex1"), ("reduced", "Hex1"), ("reduced", "Hex2")])
def test_a_block_does_not_know_which_side_of_its_cells_is_longer(method, element):
    surface = rough((24, 10), (2e-5, 1e-5))
    swapped = HeightField(heights=surface.heights.T, lengths=surface.lengths[::-1])
    told = {"method": method, "element": element, "tolerance": 1e-12}
    pressure, turned = (press(one, **told).contact.pressure for one in (surface, swapped))
    assert_allclose(turned.T, pressure, atol=1e-9 * pressure.max())


def test_stress_carries_the_load_through_every_layer(solution):
    normal = solution.stress().tensor[..., 2].mean(axis=(0, 1))
    assert_allclose(normal, -solution.contact.mean_pressure, rtol=1e-7)


def test_solving_twice_gives_the_same_bits_and_leaves_the_global_generator_alone():
    surface = rough((16, 16))
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    first = press(surface).contact
    assert_array_equal(np.random.get_state()[1], before)  # noqa: NPY002
    np.random.seed(99)  # noqa: NPY002
    assert_array_equal(press(surface).contact.pressure, first.pressure)


def test_provenance_names_what_was_solved(solution):
    text = solution.contact.provenance
    assert {"method", "element", "layers", "depth", "scikit-fem"} <= set(text)
    assert "geometric multigrid" in text["method"]
    assert "Hex1" in text["element"]
    assert solution.contact.cost.unknowns == estimate((20, 20)).unknowns == 3 * 20 * 20 * solution.layers.size
    square = estimate((20, 20), depth=1.0)
    assert square == estimate((20, 20), (1.0, 1.0), depth=1.0) != estimate((20, 20), (1.5, 1.0), depth=1.0)


@pytest.mark.parametrize("method", ["full", "reduced"])
@pytest.mark.parametrize("reduced", [1e3, 1e12, 1e20])
def test_full_contact_far_beyond_the_roughness_is_exact(method, reduced):
    surface = rough((16, 16))
    flat = press(surface, 5.0, method="reduced").contact.checked()
    contact = press(surface, reduced, method=method).contact.checked()
    assert contact.in_contact.all()
    assert contact.residuals.worst < 1e-8
    assert contact.mean_pressure / flat.mean_pressure == pytest.approx(reduced / 5.0, rel=1e-8)
