import numpy as np
import pytest
from surfaces import rough_surface

from fem_contact.block import BlockSolution, plan_mesh, solve, solve_displacement, solve_path
from fem_contact.block.full.assembly import assemble
from fem_contact.block.reduced.heterogeneous import HeterogeneousBlock
from fem_contact.errors import InvalidInput
from fem_contact.solid import Solid
from fem_contact.surface import HeightField

SOLID = Solid(young=3e9, poisson=0.3)
LENGTH = 1e-5


def rough(n: int) -> HeightField:
    return rough_surface((n, n), (LENGTH, LENGTH), seed=7, waves=4)


def particle(surface: HeightField, contrast: float):
    """A ball of another modulus just below the highest point."""
    i, j = np.unravel_index(surface.heights.argmax(), surface.shape)
    x0, y0 = i * surface.spacing[0], j * surface.spacing[1]

    def modulus(x, y, z):
        across = (x - x0 + LENGTH / 2) % LENGTH - LENGTH / 2, (y - y0 + LENGTH / 2) % LENGTH - LENGTH / 2
        inside = across[0] ** 2 + across[1] ** 2 + (z + 0.12 * LENGTH) ** 2 < (0.1 * LENGTH) ** 2
        return np.where(inside, contrast, 1.0)

    return modulus


def press(surface: HeightField, contrast: float, **changes: object) -> BlockSolution:
    pressure = 0.05 * SOLID.contact_modulus * surface.rms_gradient
    modulus = particle(surface, contrast)
    return solve(surface, SOLID, mean_pressure=pressure, modulus=modulus, **({"tolerance": 1e-9} | changes))


def most_steps(solution: BlockSolution) -> int:
    text = solution.contact.provenance["tolerance"]
    return int(text.split("at most ")[1].split(" steps")[0])


@pytest.mark.parametrize("contrast", [0.1, 10.0, 100.0])
def test_particle_under_a_contact_agrees_with_the_full_system(contrast: float) -> None:
    surface = rough(16)
    full = press(surface, contrast, method="full", tolerance=1e-11)
    free = press(surface, contrast, tolerance=1e-11)
    a, b = full.contact.checked(), free.contact.checked()
    np.testing.assert_array_equal(a.in_contact, b.in_contact)
    assert np.linalg.norm(a.pressure - b.pressure) < 1e-9 * np.linalg.norm(a.pressure)
    assert np.abs(full.field - free.field).max() < 1e-9 * np.abs(full.field).max()
    plain = solve(surface, SOLID, mean_pressure=a.mean_pressure).contact
    assert np.linalg.norm(plain.pressure - a.pressure) > 0.02 * np.linalg.norm(a.pressure)


def test_steps_depend_on_the_contrast_and_not_on_the_grid() -> None:
    steps = {n: most_steps(press(rough(n), 10.0)) for n in (16, 32)}
    assert max(steps.values()) <= 35
    assert steps[32] <= steps[16] + 4
    assert most_steps(press(rough(16), 1.0 + 1e-9)) <= 2


def test_stiff_particle_raises_the_peak_pressure_and_a_soft_one_lowers_it() -> None:
    peaks = [press(rough(16), contrast).contact.checked().pressure.max() for contrast in (0.1, 1.0, 10.0)]
    assert peaks == sorted(peaks)


def test_compiled_operator_equals_the_assembled_matrix_on_odd_grids() -> None:
    mesh = plan_mesh((5, 4), (1.0, 1.1))
    rng = np.random.default_rng(12)
    modulus = rng.uniform(0.1, 10, (5, 4, mesh.nz))
    block = HeterogeneousBlock(mesh=mesh, heights=np.zeros((5, 4)), poisson=0.3, modulus=modulus)
    field = rng.standard_normal(mesh.unknowns)
    expected = assemble(mesh, poisson=0.3, modulus=modulus).free() @ field
    np.testing.assert_allclose(block.apply(field), expected, atol=1e-13 * np.abs(expected).max())


def test_fourier_solve_inverts_a_layered_block() -> None:
    mesh = plan_mesh((6, 5), (1.0, 1.1))
    rng = np.random.default_rng(13)
    layers = np.broadcast_to(rng.uniform(0.1, 10, mesh.nz), (6, 5, mesh.nz)).copy()
    block = HeterogeneousBlock(mesh=mesh, heights=np.zeros((6, 5)), poisson=0.3, modulus=layers)
    field = rng.standard_normal(mesh.unknowns)
    again = block.solve_layered(block.apply(field))
    np.testing.assert_allclose(again, field, atol=1e-11 * np.abs(field).max())


def test_quadratic_cells_are_refused_by_name() -> None:
    with pytest.raises(InvalidInput, match=r"Hex2.*trilinear"):
        press(rough(16), 10.0, element="Hex2")


def test_paths_and_approaches_agree_with_single_loads() -> None:
    surface = rough(14)
    modulus = particle(surface, 5.0)
    unit = SOLID.contact_modulus * surface.rms_gradient
    loads = [0.03 * unit, 0.2 * unit, 0.05 * unit]
    path = list(solve_path(surface, SOLID, mean_pressures=loads, modulus=modulus, tolerance=1e-10))
    alone = solve(surface, SOLID, mean_pressure=loads[-1], modulus=modulus, tolerance=1e-10).contact
    last = path[-1].contact.checked()
    np.testing.assert_array_equal(last.in_contact, alone.checked().in_contact)
    np.testing.assert_allclose(last.pressure, alone.pressure, atol=1e-7 * alone.pressure.max())
    placed = solve_displacement(surface, SOLID, offset=last.offset, modulus=modulus, tolerance=1e-10).contact
    np.testing.assert_array_equal(placed.checked().in_contact, last.in_contact)
    np.testing.assert_allclose(placed.pressure, last.pressure, atol=1e-6 * last.pressure.max())
