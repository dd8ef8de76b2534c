"""A patch with free surroundings: Hertz without images, no matter how large the patch or where the ball."""

import itertools
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import dblquad
from surfaces import rough_surface

from fem_contact import FreeHalfSpace, HalfSpace, InvalidInput, Solid, UnsupportedEffect, adhesion, bem
from fem_contact.area import contact_areas, subcell_area
from fem_contact.complementarity import FreeOperator
from fem_contact.hardness import Hardness, press_yielding
from fem_contact.patches import find_patches
from fem_contact.stress import density_at_zero, elastic_energy, loading_work, window_slope
from fem_contact.subsurface import fields_below
from fem_contact.surface import HeightField, Patch

SOLID = Solid(young=1.0, poisson=0.3)
FREE, MODULUS = FreeHalfSpace(solid=SOLID), SOLID.contact_modulus
RADIUS, CONTACT = 1.0, 0.1
FORCE = 4 * MODULUS * CONTACT**3 / (3 * RADIUS)


def ball(n, *, side=0.3, centre=(0.0, 0.0)):
    x, y = ((np.arange(n) + 0.5) * side / n - side / 2 - c for c in centre)
    return Patch(heights=-(x[:, None] ** 2 + y[None, :] ** 2) / (2 * RADIUS), lengths=(side, side))


def pressed(n, **place):
    surface = ball(n, **place)
    area = surface.lengths[0] * surface.lengths[1]
    return bem.solve(surface, FREE, mean_pressure=FORCE / area, tolerance=1e-9).checked()


def test_the_operator_is_the_sum_over_all_cells_of_the_patch():
    shape, lengths = (5, 4), (1.0, 1.2)
    operator = FreeOperator(FREE, shape, lengths, threads=1)
    rng = np.random.default_rng(3)
    force, out = rng.random(shape), np.empty(shape)
    operator.apply(force, out)
    dx, dy = lengths[0] / shape[0], lengths[1] / shape[1]

    def cell(i, j):
        """Displacement i, j cells beside a cell under unit pressure; by quarters at its pole."""
        if i == j == 0:
            sides = (0, dx / 2, 0, dy / 2)
            quarter = dblquad(lambda y, x: 1 / math.hypot(x, y), *sides, epsabs=1e-9, epsrel=1e-9)[0]
            return 4 * quarter / (math.pi * MODULUS)
        x, y = (np.linspace(-0.5, 0.5, 801)[:-1] + 0.5 / 800 for _ in range(2))
        distance = np.hypot((i - x[:, None]) * dx, (j - y[None, :]) * dy)
        return float(np.mean(1 / distance)) * dx * dy / (math.pi * MODULUS)

    table = np.array([[cell(i, j) for j in range(4)] for i in range(5)])
    at = np.zeros(shape)
    for i, j, k, m in itertools.product(range(5), range(4), range(5), range(4)):
        at[i, j] += force[k, m] * table[abs(i - k), abs(j - m)]
    assert_allclose(out, at, rtol=3e-6)


def test_neither_the_size_of_the_patch_nor_the_place_on_it_matters():
    here, larger = pressed(48, side=0.24), pressed(96, side=0.48)
    assert_allclose(larger.pressure[24:72, 24:72], here.pressure, atol=1e-5 * here.pressure.max())
    assert larger.offset == pytest.approx(here.offset, rel=1e-6)
    aside = pressed(96, side=0.48, centre=(0.05, -0.1))
    moved = np.roll(aside.pressure, (-10, 20), (0, 1))
    assert_allclose(moved, larger.pressure, atol=1e-5 * here.pressure.max())


def test_images_of_a_period_fade_with_its_size():
    free = pressed(32, side=0.24).pressure.max()
    periodic = []
    for n in (32, 64, 128):
        surface = ball(n, side=0.24 * n / 32)
        area = surface.lengths[0] ** 2
        around = bem.solve(surface, HalfSpace(solid=SOLID), mean_pressure=FORCE / area, tolerance=1e-9)
        periodic.append(abs(around.pressure.max() / free - 1))
    assert periodic[0] > 4 * periodic[1]
    assert periodic[2] < 0.005


def test_the_load_is_kept_and_its_work_is_stored():
    surface = ball(40, side=0.3)
    loads = list(np.linspace(0.02, 1, 40) ** 1.5 * FORCE / 0.09)
    path = bem.solve_path(surface, FREE, mean_pressures=loads, tolerance=1e-9)
    assert [result.mean_pressure for result in path] == pytest.approx(loads, rel=1e-12)
    grown = elastic_energy(path[-1]) - elastic_energy(path[0])
    assert loading_work(path)[-1] == pytest.approx(grown, rel=2e-3)


def test_what_needs_a_period_refuses_it_by_name():
    surface = ball(16)
    result = bem.solve(surface, FREE, mean_pressure=0.001)
    law = adhesion.Exponential(work=1e-4, reach=0.02)
    for ask in (
        lambda: FREE.compliance(np.ones(1), np.ones(1)),
        lambda: bem.solve_displacement(surface, FREE, offset=-0.001),
        lambda: adhesion.solve(surface, FREE, law=law, mean_pressure=0.001),
        lambda: fields_below(result, FREE, depths=[0.1, 0.2]),
    ):
        with pytest.raises(UnsupportedEffect, match="FreeHalfSpace"):
            ask()


def test_a_patch_knows_its_slopes_and_keeps_its_edges():
    def heights(n):
        x = (np.arange(n) + 0.5) / n
        return 0.3 * x[:, None] ** 2 + 0.1 * np.sin(3 * x)[None, :]

    patch = Patch(heights=heights(40), lengths=(1.0, 1.0))
    exact = math.sqrt(0.36 / 3 + 0.09 * (0.5 + math.sin(6) / 12))
    # Half a cell at each edge has no difference.
    assert patch.rms_gradient == pytest.approx(exact, rel=1 / 40)
    for n in (20, 57, 80):
        assert_allclose(patch.resampled((n, n)).heights, heights(n), atol=1e-6)
    jumping = HeightField(heights=patch.heights, lengths=(1.0, 1.0))
    assert jumping.rms_gradient > 2 * patch.rms_gradient
    again = pickle.loads(pickle.dumps(patch))
    assert isinstance(again, Patch)
    assert isinstance(patch.resampled((40, 40)), Patch)
    with pytest.raises(InvalidInput, match="cannot be moved"):
        patch.shifted((0.5, 0.0))


def test_a_wave_under_a_window_keeps_its_power():
    x = (np.arange(64) + 0.5) / 64
    patch = Patch(heights=np.cos(16 * np.pi * x)[:, None] * np.ones(64), lengths=(1.0, 1.0))
    assert patch.spectral_sum(np.ones_like) == pytest.approx(0.5, rel=1e-9)
    assert patch.moments[0] == pytest.approx(np.mean((patch.heights - patch.heights.mean()) ** 2), rel=1e-12)


def test_a_rough_patch_pressed_to_its_edges_takes_few_steps():
    surface = rough_surface((96, 96), seed=5, waves=12)
    load = 0.3 * MODULUS * surface.rms_gradient
    assert bem.solve(surface, FREE, mean_pressure=load).checked().cost.iterations <= 18


def test_edges_at_one_side_of_a_patch_know_nothing_of_the_other():
    """A ball that one side cuts, alone and beside one at the other side."""
    found = pressed(48, centre=(-0.15, 0.0))
    alone = subcell_area(found)
    pressure, gap = found.pressure.copy(), found.gap.copy()
    pressure[24:], gap[24:] = pressure[23::-1], gap[23::-1]
    both = replace(found, pressure=pressure, gap=gap, in_contact=pressure > 0)
    assert found.in_contact[0].any()
    assert not found.in_contact[20:].any()
    assert subcell_area(both) == pytest.approx(2 * alone, rel=1e-12)


def test_what_lies_at_opposite_sides_of_a_patch_does_not_touch():
    """Two strips at the sides are two patches, whose outer sides are no edges of contact."""
    x = (np.arange(48) + 0.5) / 48
    heights = np.where(abs(x - 0.5) > 0.3, 0.0, -0.2)[:, None] * np.ones(48)
    body = FreeHalfSpace(solid=Solid(young=1.0, poisson=0.0))
    hardness = Hardness(pressure=0.05, length=0.3, exponent=1)
    patch = Patch(heights=heights, lengths=(1.0, 1.0))
    found = press_yielding(patch, body, hardness=hardness, mean_pressure=0.028).checked()
    assert not found.periodic
    assert find_patches(found.in_contact, found.spacing, periodic=False).count == 2
    assert find_patches(found.in_contact, found.spacing).count == 1
    strip = found.in_contact.mean() / 2
    bears = 0.05 * (1 + 0.3 / (2 * (strip / np.pi) ** 0.5))
    assert found.pressure.max() == pytest.approx(bears, rel=1e-9)
    assert contact_areas(found).edge_fraction == pytest.approx(2 / 48)
    assert window_slope(found).patches == 2
    tilted = Patch(heights=heights + 0.2 * x[:, None], lengths=(1.0, 1.0))
    tried = bem.solve(tilted, body, mean_pressure=0.01).checked()
    density = density_at_zero(tried)
    assert density.reduced == pytest.approx(density.density * tilted.rms_gradient, rel=1e-12)
