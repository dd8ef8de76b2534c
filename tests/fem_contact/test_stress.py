"""Distribution of pressure."""

import numpy as np
import pytest

from fem_contact.bem import solve
from fem_contact.contact import ContactResult
from fem_contact.errors import InvalidInput
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.stress import density_at_zero, pressure_distribution
from fem_contact.surface import HeightField, random_surface

SOFT = HalfSpace(solid=Solid(young=1.0, poisson=0.0))


def paraboloid(n: int) -> ContactResult:
    x = (np.arange(n) + 0.37) / n - 0.5
    heights = -(x[:, None] ** 2 + x[None, :] ** 2) / 2
    return solve(
        HeightField(heights=heights, lengths=(1.0, 1.0)), SOFT, mean_pressure=4 * 0.1**3 / 3
    ).checked()


def rough_contact(n: int) -> ContactResult:
    surface = random_surface(
        lambda q: np.where(q > 10.0, q**-3.6, 0.0),
        q_short=2 * np.pi * 8,
        lengths=(1.0, 1.0),
        shape=(n, n),
        seed=3,
    )
    surface = HeightField(heights=surface.heights / surface.rms_gradient, lengths=(1.0, 1.0))
    return solve(surface, SOFT, mean_pressure=0.1).checked()


def test_distribution_integrates_to_the_contact_area() -> None:
    result = rough_contact(64)
    top = result.pressure.max()
    edges = top * np.linspace(0, 1.001, 40) ** 2
    distribution = pressure_distribution(result, edges)
    assert np.sum(distribution.density * np.diff(edges)) == pytest.approx(result.in_contact.mean(), rel=1e-12)
    assert np.sum(distribution.per_contact_area * np.diff(edges)) == pytest.approx(1.0, rel=1e-12)
    first_moment = np.sum(distribution.density * distribution.centres * np.diff(edges))
    assert first_moment == pytest.approx(result.mean_pressure, rel=0.02)


def test_hertzian_distribution_is_linear_in_pressure() -> None:
    """P(sigma) = 2 pi a^2 sigma / p_max^2 = (pi^3 R^2 / 2 E*^2) sigma per patch and nominal area."""
    result = paraboloid(384)
    edges = np.linspace(0.0, 0.06, 7)
    distribution = pressure_distribution(result, edges)
    np.testing.assert_allclose(distribution.density[1:], np.pi**3 / 2 * distribution.centres[1:], rtol=0.06)


def test_density_at_zero_falls_with_the_grid() -> None:
    values = [density_at_zero(rough_contact(n)) for n in (32, 64, 128, 256)]
    densities = [value.reduced for value in values]
    order = -np.polyfit(np.log([32, 64, 128, 256]), np.log(densities), 1)[0]
    assert order > 0.25
    assert all(value.points > 5 for value in values)
    thresholds = [value.threshold for value in values]
    np.testing.assert_allclose(np.array(thresholds[:-1]) / thresholds[1:], np.sqrt(2), rtol=1e-6)


def test_density_at_zero_is_free_of_units() -> None:
    result = rough_contact(32)
    doubled = solve(
        HeightField(heights=result.heights * 2.0**20, lengths=(2.0**20, 2.0**20)),
        HalfSpace(solid=Solid(young=2.0**-30, poisson=0.0)),
        mean_pressure=0.1 * 2.0**-30,
    )
    assert density_at_zero(doubled).reduced == density_at_zero(result).reduced


def test_flat_surface_and_wrong_edges_are_refused() -> None:
    flat = solve(HeightField(heights=np.zeros((8, 8)), lengths=(1.0, 1.0)), SOFT, mean_pressure=0.1)
    with pytest.raises(InvalidInput, match="flat"):
        density_at_zero(flat)
    with pytest.raises(InvalidInput, match="edges"):
        pressure_distribution(flat, [1.0, 0.5])
