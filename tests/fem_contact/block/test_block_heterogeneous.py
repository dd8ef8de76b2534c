import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from surfaces import rough_surface

from fem_contact import InvalidInput, Solid
from fem_contact.block import solve, solve_displacement, solve_path

SOLID = Solid(young=3e9, poisson=0.3)
LENGTH = 1e-5


def rough(n):
    return rough_surface((n, n), (LENGTH, LENGTH), seed=7, waves=4)


def particle(surface, contrast):
    """A ball of another modulus just below the highest point."""
    i, j = np.unravel_index(surface.heights.argmax(), surface.shape)
    x0, y0 = i * surface.spacing[0], j * surface.spacing[1]

    def modulus(x, y, z):
        across = (x - x0 + LENGTH / 2) % LENGTH - LENGTH / 2, (y - y0 + LENGTH / 2) % LENGTH - LENGTH / 2
        inside = across[0] ** 2 + across[1] ** 2 + (z + 0.12 * LENGTH) ** 2 < (0.1 * LENGTH) ** 2
        return np.where(inside, contrast, 1.0)

    return modulus


def press(surface, contrast, **changes):
    pressure = 0.05 * SOLID.contact_modulus * surface.rms_gradient
    modulus = particle(surface, contrast)
    return solve(surface, SOLID, mean_pressure=pressure, modulus=modulus, **({"tolerance": 1e-9} | changes))


def test_a_modulus_that_varies_sideways_is_solved_in_full_whatever_the_method():
    found, full = press(rough(12), 10.0), press(rough(12), 10.0, method="full")
    assert "full system" in found.contact.provenance["method"]
    assert_array_equal(found.contact.pressure, full.contact.pressure)
    half = Solid(young=3e9, poisson=0.5)
    with pytest.raises(InvalidInput, match=r"poisson = 0\.5: .*varies in depth only"):
        solve(rough(12), half, mean_pressure=1e6, modulus=particle(rough(12), 10.0))


def test_paths_and_approaches_agree_with_single_loads():
    surface = rough(14)
    modulus = particle(surface, 5.0)
    unit = SOLID.contact_modulus * surface.rms_gradient
    loads = [0.03 * unit, 0.2 * unit, 0.05 * unit]
    path = list(solve_path(surface, SOLID, mean_pressures=loads, modulus=modulus, tolerance=1e-10))
    alone = solve(surface, SOLID, mean_pressure=loads[-1], modulus=modulus, tolerance=1e-10).contact
    last = path[-1].contact.checked()
    assert_array_equal(last.in_contact, alone.checked().in_contact)
    assert_allclose(last.pressure, alone.pressure, atol=1e-7 * alone.pressure.max())
    placed = solve_displacement(surface, SOLID, offset=last.offset, modulus=modulus, tolerance=1e-10).contact
    assert_array_equal(placed.checked().in_contact, last.in_contact)
    assert_allclose(placed.pressure, last.pressure, atol=1e-6 * last.pressure.max())
