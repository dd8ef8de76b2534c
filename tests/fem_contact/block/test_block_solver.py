import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from surfaces import rough_surface

from fem_contact.block import BlockSolution, estimate, solve, solve_path
from fem_contact.errors import InsufficientMemory, InvalidInput
from fem_contact.solid import Solid
from fem_contact.surface import HeightField

SOLID = Solid(young=3e9, poisson=0.3)


def rough(
    shape: tuple[int, int], lengths: tuple[float, float] = (1e-5, 1e-5), *, seed: int = 7
) -> HeightField:
    return rough_surface(shape, lengths, seed=seed, waves=4)


def press(surface: HeightField, reduced: float = 0.05, **changes: object) -> BlockSolution:
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


def test_too_large_a_block_is_refused_before_anything_is_assembled():
    surface = HeightField(heights=np.zeros((4096, 4096)), lengths=(1.0, 1.0))
    with pytest.raises(InsufficientMemory, match="GiB are available"):
        solve(surface, SOLID, mean_pressure=1e6, method="full")


def test_an_incompressible_solid_is_sent_to_the_reduced_method():
    surface, solid = rough((12, 12)), Solid(young=1.0, poisson=0.5)
    with pytest.raises(InvalidInput, match=r"poisson = 0\.5.*method = 'reduced'"):
        solve(surface, solid, mean_pressure=1e-3, method="full")
    solve(surface, solid, mean_pressure=1e-3).contact.checked()


@pytest.mark.parametrize("method", ["full", "reduced"])
@pytest.mark.parametrize("reduced", [1e3, 1e12, 1e20])
def test_full_contact_far_beyond_the_roughness_is_exact(method, reduced):
    surface = rough((16, 16))
    flat = press(surface, 5.0, method="reduced").contact.checked()
    contact = press(surface, reduced, method=method).contact.checked()
    assert contact.in_contact.all()
    assert contact.residuals.worst < 1e-8
    assert contact.mean_pressure / flat.mean_pressure == pytest.approx(reduced / 5.0, rel=1e-8)


@pytest.mark.parametrize(("young", "pressure"), [(1e30, 1e-35), (1e-35, 1e30)])
def test_pressures_out_of_the_range_of_the_arithmetic_are_refused(young, pressure):
    with pytest.raises(InvalidInput, match=r"mean_pressure.*range of the arithmetic"):
        solve(rough((10, 11)), Solid(young=young, poisson=0.3), mean_pressure=pressure)


@pytest.mark.parametrize("pressure", [1e-306, 3e38, 1e306])
def test_pressures_that_nothing_can_be_computed_with_are_refused_at_the_door(pressure):
    with pytest.raises(InvalidInput, match="mean_pressure = "):
        solve(rough((10, 11)), SOLID, mean_pressure=pressure)
    with pytest.raises(InvalidInput, match="mean_pressures = "):
        solve_path(rough((10, 11)), SOLID, mean_pressures=[1e5, pressure])


def test_an_option_that_the_mesh_does_not_have_is_refused():
    with pytest.raises(InvalidInput, match=r"first = 1e-06: is no option.*first_layer"):
        solve(rough((10, 11)), SOLID, mean_pressure=1e5, **{"first": 1e-6})


@pytest.mark.parametrize("method", ["full", "reduced"])
@pytest.mark.parametrize(
    ("argument", "value"),
    [
        ("method", np.array([])),
        ("modulus", 2.0),
        ("tolerance", 5e-324),
        ("start", np.ones((3, 3), dtype=bool)),
        ("growth", [1.2]),
        ("first_layer", 10**400),
        ("element", []),
    ],
)
def test_what_cannot_be_is_refused_by_name(method, argument, value):
    given = {"surface": rough((10, 11)), "solid": SOLID, "mean_pressure": 1e5, "method": method}
    with pytest.raises(InvalidInput, match=f"^{argument} (=|of shape) "):
        solve(**(given | {argument: value}))
