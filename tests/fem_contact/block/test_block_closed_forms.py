import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose
from surfaces import periodic_paraboloid

from fem_contact import HeightField, Solid, contact_areas
from fem_contact.area import EDGE_CONSTANTS
from fem_contact.block import solve


def press_paraboloid(n, edge, *, shift=(0.0, 0.0), poisson=0.3, **changes):
    """Contact of radius `edge` on a paraboloid of radius 1 in a unit period, the distances, and the peak."""
    solid = Solid(young=1.0, poisson=poisson)
    surface, load, r = periodic_paraboloid(n, edge, shift, modulus=solid.contact_modulus)
    contact = solve(surface, solid, mean_pressure=load, **changes).contact.checked()
    return contact, r, 3 * load / (2 * np.pi * edge**2)


@pytest.mark.parametrize(("element", "poisson"), [("Hex1", 0.3), ("Hex1/P0", 0.49)])
def test_hertz_peak_and_profile_at_six_cells_per_radius(element, poisson):
    contact, r, peak = press_paraboloid(60, 0.1, element=element, poisson=poisson)
    assert contact.pressure.max() == pytest.approx(peak, rel=4e-3)
    inside = r < 0.1 - 1.5 / 60
    exact = peak * np.sqrt(np.maximum(1 - (r / 0.1) ** 2, 0))
    assert np.abs(contact.pressure - exact)[inside].max() < 5e-3 * peak


def test_quadratic_peak_pressure_converges():
    # Corner, edge and centre nodes share the load by shape functions: a steep profile makes them differ.
    errors = []
    for n in (60, 120):
        contact, _, peak = press_paraboloid(n, 0.1, element="Hex2")
        errors.append(abs(contact.pressure.max() / peak - 1))
    assert errors[1] < 0.4 * errors[0] < 0.4 * 2e-2


def test_one_row_of_nodes_is_plane_strain():
    n, solid = 64, Solid(young=1.0, poisson=0.3)
    wave = 0.01 * np.cos(2 * np.pi * np.arange(n) / n)[:, None]
    pressures = []
    for rows in (1, 4):
        surface = HeightField(heights=wave * np.ones(rows), lengths=(1.0, rows / n))
        contact = solve(surface, solid, mean_pressure=0.01, tolerance=1e-11).contact.checked()
        pressures.append(contact.pressure[:, 0])
    assert_allclose(pressures[0], pressures[1], atol=1e-9 * pressures[1].max())


SLOW = pytest.param("Hex2", 0.3, marks=pytest.mark.slow)


@pytest.mark.parametrize(("name", "poisson"), [("Hex1", 0.3), ("Hex1/P0", 0.45), SLOW])
def test_edge_constant_makes_the_counted_area_right_on_average(name, poisson):
    excess, fraction, places = [], [], 16
    for shift in 2 * np.random.default_rng(23).random((places, 2)):
        meshed = {"element": name, "growth": 1.05}
        contact, *_ = press_paraboloid(96, 1 / 8, shift=tuple(shift), poisson=poisson, **meshed)
        areas = contact_areas(contact)
        excess.append(areas.pixel - np.pi / 64)
        fraction.append(areas.edge_fraction)
    scatter = np.std(excess, ddof=1) / np.mean(fraction) / np.sqrt(places)
    constant = np.mean(excess) / np.mean(fraction)
    assert constant == pytest.approx(EDGE_CONSTANTS[name], abs=3.5 * scatter)
    assert scatter < 0.015


@pytest.mark.parametrize("element", ["Hex1", "Hex2"])
def test_even_pressure_strains_the_block_like_confined_compression(element):
    """Stress p vertically and p nu / (1 - nu) sideways, E (1 - nu) / ((1 + nu) (1 - 2 nu)) against strain."""
    solid, load = Solid(young=2.0, poisson=0.3), 0.01
    flat = HeightField(heights=np.zeros((4, 6)), lengths=(1.0, 1.5))
    even = solve(flat, solid, mean_pressure=load, element=element, growth=1.5, depth=0.5)
    sideways, strain = -load * 0.3 / 0.7, load / (2.0 * 0.7 / (1.3 * 0.4))
    stress = even.stress()
    assert_allclose(stress.tensor - [sideways, sideways, -load, 0, 0, 0], 0, atol=1e-9 * load)
    assert_allclose(even.strain()[..., 2], -strain, rtol=1e-8)
    assert even.energy == pytest.approx(0.5 * load * strain * even.depth, rel=1e-9)
    sheared = dataclasses.replace(stress, tensor=np.array([0.0, 0.0, 0.0, 0.0, 0.2, 0.0]))
    assert float(sheared.von_mises) == pytest.approx(0.2 * np.sqrt(3), rel=1e-12)
