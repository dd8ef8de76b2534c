"""Distribution of pressure."""

import numpy as np
import pytest
from surfaces import SOFT, rough_surface

from fem_contact import HeightField, gap_distribution, pressure_distribution
from fem_contact.bem import solve, solve_path
from fem_contact.stress import contact_stiffness, density_at_zero, elastic_energy, window_slope


def rough(n):
    return rough_surface((n, n), seed=3, waves=8, longest=1.6, gradient=1.0)


def rough_contact(n):
    return solve(rough(n), SOFT, mean_pressure=0.1).checked()


def test_distribution_integrates_to_the_contact_area():
    result = rough_contact(64)
    top = result.pressure.max()
    edges = top * np.linspace(0, 1.001, 40) ** 2
    distribution = pressure_distribution(result, edges)
    assert np.sum(distribution.density * np.diff(edges)) == pytest.approx(result.in_contact.mean(), rel=1e-12)
    assert np.sum(distribution.per_contact_area * np.diff(edges)) == pytest.approx(1.0, rel=1e-12)
    first_moment = np.sum(distribution.density * distribution.centres * np.diff(edges))
    assert first_moment == pytest.approx(result.mean_pressure, rel=0.02)


def test_density_at_zero_falls_like_the_root_of_the_spacing():
    found = [density_at_zero(rough_contact(n)) for n in (64, 96, 128, 192, 256, 384)]
    spacing, density = np.log([one.spacing for one in found]), np.log([one.reduced for one in found])
    assert 0.3 < np.polyfit(spacing, density, 1, w=np.sqrt([one.points for one in found]))[0] < 0.7


def test_initial_slope_of_one_hertzian_contact_is_the_closed_form():
    """One patch: P' = pi^3 R^2 / (2 E*^2 A0), whatever its size."""
    for n, shift in ((384, 0.37), (512, 0.11)):
        x = (np.arange(n) + shift) / n - 0.5
        heights = -(x[:, None] ** 2 + x[None, :] ** 2) / 2
        result = solve(HeightField(heights=heights, lengths=(1.0, 1.0)), SOFT, mean_pressure=4 * 0.1**3 / 3)
        stress = HeightField(heights=heights, lengths=(1.0, 1.0)).rms_gradient
        slope = window_slope(result, window=(0.015 / stress, 0.055 / stress), bins=4)
        assert slope.slope == pytest.approx(np.pi**3 / 2, rel=0.04)
        assert slope.reduced == pytest.approx(slope.slope * stress**2)
        inside = np.abs(result.pressure / result.contact_modulus - 0.035) < 0.02
        assert slope.uncertainty == pytest.approx(slope.reduced / np.sqrt(np.count_nonzero(inside)), rel=1e-6)
        assert slope.patches == 1


def test_gap_distribution_integrates_to_the_non_contact_area():
    result = rough_contact(64)
    edges = np.linspace(-1e-6, result.gap.max() * 1.0001, 50)
    distribution = gap_distribution(result, edges)
    shares, centres = distribution.density * np.diff(edges), 0.5 * (edges[1:] + edges[:-1])
    assert shares.sum() == pytest.approx(1 - result.in_contact.mean(), rel=1e-12)
    assert np.sum(shares * centres) == pytest.approx(distribution.mean, rel=5e-3)


def test_energy_of_full_contact_is_the_sum_over_waves():
    """U = (E*/4) sum q |h(q)|^2 per area at full contact (Persson 2006, Eq. 43 with P = 1)."""
    surface = rough(48)
    result = solve(surface, SOFT, mean_pressure=5.0).checked()
    assert result.in_contact.all()
    numbers = np.fft.fftfreq(48) * 48
    q = 2 * np.pi * np.hypot(numbers[:, None], numbers[None, :])
    power = np.abs(np.fft.fft2(surface.heights, norm="forward")) ** 2
    assert elastic_energy(result) == pytest.approx(0.25 * np.sum(q * power), rel=1e-12)
    assert surface.spectral_sum(lambda q: q / 4) == pytest.approx(0.25 * np.sum(q * power), rel=1e-12)


def test_stiffness_of_a_periodic_hertzian_contact_is_two_modulus_radius():
    """dF/d(approach) = 2 E* a, less the share of the periodic images."""
    n, radius = 256, 0.06
    x = (np.arange(n) + 0.41) / n - 0.5
    surface = HeightField(heights=-(x[:, None] ** 2 + x[None, :] ** 2) / 2, lengths=(1.0, 1.0))
    loads = 4 / 3 * radius**3 * np.array([0.8, 0.9, 1.0, 1.1, 1.2])
    stiffness = contact_stiffness(solve_path(surface, SOFT, mean_pressures=loads, tolerance=1e-10))[2]
    # The lattice of images lowers the displacement at the origin by 3.90026 F / (pi E* L).
    assert 1 / stiffness == pytest.approx(1 / (2 * radius) - 3.90026492 / np.pi, rel=0.01)
