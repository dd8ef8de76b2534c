"""Counted, corrected and extrapolated contact areas."""

import dataclasses

import numpy as np
import pytest
from made_results import made_areas, made_contact
from surfaces import SOFT, periodic_paraboloid, rough_surface

from fem_contact import FreeHalfSpace, HeightField, InvalidInput, Patch, Solid, block, contact_areas
from fem_contact.area import (
    EDGE_CONSTANTS,
    EDGE_MAPS,
    contact_edges,
    mean_areas,
    subcell_area,
    subgrid_shifts,
)
from fem_contact.bem import solve
from fem_contact.height_traits import height_traits


def test_edges_are_counted_along_both_directions_per_nominal_area():
    contact = np.zeros((8, 10), dtype=bool)
    contact[2:5, 3:9] = True
    lengths = (4.0, 20.0)
    areas = contact_areas(made_contact(contact, lengths=lengths), edge_constant=0.25)
    dx, dy = 0.5, 2.0
    assert areas.pixel == 18 / 80
    assert areas.edge_length == pytest.approx((2 * 3 * dx + 2 * 6 * dy) / 80)
    assert areas.edge_fraction == 18 / 80
    assert areas.perimeter == pytest.approx(18 / 80 - 0.25 * 18 / 80)


def test_the_edge_constant_is_that_of_the_element_that_made_the_result():
    contact = np.zeros((4, 4), dtype=bool)
    contact[0, 0] = True
    result = made_contact(contact)
    for name in block.ELEMENTS:
        made = dataclasses.replace(result, provenance={"method": "finite elements", "element": name})
        assert contact_areas(made).edge_constant == EDGE_CONSTANTS[name]
        assert contact_areas(made, edge_constant=0.1).edge_constant == 0.1
    assert contact_areas(result).edge_constant == EDGE_CONSTANTS["bem"]


@pytest.mark.parametrize("told", [{}, {"method": "by hand"}, {"method": "finite elements", "element": "x"}])
def test_a_result_of_unknown_making_has_no_edge_constant_and_no_edge_map(told):
    result = dataclasses.replace(made_contact(np.eye(8, dtype=bool)), provenance=told)
    with pytest.raises(InvalidInput, match="edge_constant: none is known"):
        contact_areas(result)
    with pytest.raises(InvalidInput, match="edge_map: none is known"):
        subcell_area(result)
    assert contact_areas(result, edge_constant=0.2).pixel == 1 / 8


def test_edges_across_the_period_count():
    contact = np.zeros((6, 6), dtype=bool)
    contact[0] = True
    assert contact_areas(made_contact(contact)).edge_length == pytest.approx(2.0)


def test_points_count_by_their_weight():
    contact = np.zeros((4, 4), dtype=bool)
    contact[0, 0] = True
    weights = np.full((4, 4), 14 / 15)
    weights[0, 0] = 2.0
    assert contact_areas(made_contact(contact, weights=weights)).pixel == pytest.approx(2 / 16)


def areas_on(n, *, limit, constant, edge=10.0, noise=0.0):
    pixel = limit + constant * edge / n + noise
    return made_areas(pixel, n, edge / n, perimeter=pixel - 0.1 * edge / n, subcell=None)


def test_constants_are_named_by_discretisation():
    assert set(EDGE_CONSTANTS) == {"bem", "bem free", "fem", *block.ELEMENTS}
    # The same cells, by two sets of contacts.
    assert EDGE_CONSTANTS["Hex1"] == EDGE_CONSTANTS["fem"]
    with pytest.raises(TypeError):
        EDGE_CONSTANTS["bem"] = 1.0  # type: ignore[index]


def paraboloid(n, radius, shift):
    """Hertzian contact with the curvature that periodic images add; its true relative area."""
    surface, load, _ = periodic_paraboloid(n, radius, shift)
    return solve(surface, SOFT, mean_pressure=load).checked(), float(np.pi * radius**2)


def test_located_area_of_a_disc_is_right_to_two_per_mille_at_six_cells_and_a_tenth_of_a_cell_beyond():
    """Without the second part of the edge map each disc was half a cell too small, on every grid."""
    generator = np.random.default_rng(77)
    for n in (64, 128, 256):
        cells = []
        for _ in range(6):
            result, area = paraboloid(n, 0.1 * (0.9 + 0.2 * generator.random()), tuple(generator.random(2)))
            cells.append((subcell_area(result) - area) * n**2)
        assert abs(np.mean(cells)) < 0.15
        assert np.sqrt(np.mean(np.square(cells))) < (0.002 * np.pi * 6.4**2 if n == 64 else 0.3)


def test_edge_constant_removes_the_excess_of_counted_discs():
    generator = np.random.default_rng(78)
    excess, fraction = 0.0, 0.0
    for _ in range(24):
        result, area = paraboloid(192, 0.11 * (0.8 + 0.4 * generator.random()), tuple(generator.random(2)))
        areas = contact_areas(result)
        excess, fraction = excess + areas.pixel - area, fraction + areas.edge_fraction
    # One disc of about 21 cells in radius scatters by .02 about the constant.
    assert excess / fraction == pytest.approx(EDGE_CONSTANTS["bem"], abs=3 * 0.02 / np.sqrt(24))


def test_discs_on_a_patch_with_free_surroundings_have_an_edge_of_their_own():
    """By the map of periodic grids they were .5 % too small at 5 to 9 cells in radius."""
    generator = np.random.default_rng(79)
    off, excess, fraction = [], 0.0, 0.0
    for _ in range(24):
        radius = (5 + 4 * generator.random()) / 64
        x, y = ((np.arange(64) + part) / 64 - 0.5 for part in generator.random(2))
        patch = Patch(heights=-(x[:, None] ** 2 + y**2) / 2, lengths=(1.0, 1.0))
        free = FreeHalfSpace(solid=Solid(young=1.0, poisson=0.0))
        areas = contact_areas(solve(patch, free, mean_pressure=4 * radius**3 / 3).checked(), subcell=True)
        off.append(areas.subcell / (np.pi * radius**2) - 1)
        excess, fraction = excess + areas.pixel - np.pi * radius**2, fraction + areas.edge_fraction
        # The paraboloid is smooth, and its sides are not.
        assert areas.unresolved < 1e-3
    assert abs(np.mean(off)) < 1e-3
    assert excess / fraction == pytest.approx(EDGE_CONSTANTS["bem free"], abs=3 * 0.03 / np.sqrt(24))
    assert areas.edge_constant == EDGE_CONSTANTS["bem free"]


def traits_of(heights, lengths=(1.0, 1.0)):
    surface = HeightField(heights=heights, lengths=lengths)
    return contact_areas(solve(surface, SOFT, mean_pressure=0.01 * surface.rms_gradient, threads=1))


def test_what_heights_are_like_follows_from_their_waves():
    """Waves of 12 points along x and of 3 along y, on cells that are not square."""
    x, y = np.arange(48)[:, None] / 48, np.arange(24)[None, :] / 24
    long, short, ratio = 2 * np.pi * 4, 2 * np.pi * 8 / 1.5, 0.3
    areas = traits_of(0.01 * (np.cos(2 * np.pi * 4 * x) + ratio * np.cos(2 * np.pi * 8 * y)), (1.0, 1.5))
    slopes = sorted([long**2, (ratio * short) ** 2])
    assert areas.anisotropy == pytest.approx(1 - np.sqrt(slopes[0] / slopes[1]), rel=1e-9)
    curvature = np.array([long**4, ratio**2 * short**4])
    assert areas.unresolved == pytest.approx(curvature[1] / curvature.sum(), rel=1e-9)
    mean = np.sqrt(curvature @ [long**2, short**2] / curvature.sum())
    assert areas.wavenumber == pytest.approx(mean * np.sqrt(1.5 / 48 / 24), rel=1e-9)


def test_a_patch_two_points_wide_is_not_level():
    heights = np.random.default_rng(0).standard_normal((2, 16))
    assert height_traits(heights, (1.0, 1.0), patch=True).wavenumber > 1


def test_what_heights_are_like_does_not_depend_on_how_their_axes_were_laid():
    noise = np.random.default_rng(17).standard_normal((12, 8))
    laid = ((noise, (1.0, 0.5)), (noise.T, (0.5, 1.0)), (noise[::-1], (1.0, 0.5)))
    traits = [height_traits(h, spacing, patch=False) for h, spacing in laid]
    for other in traits[1:]:
        assert vars(other) == pytest.approx(vars(traits[0]), rel=1e-12)
    assert traits[0].anisotropy > 0.1


def test_isotropic_heights_that_the_grid_resolves_show_nothing_and_kinks_a_third_on_any_grid():
    areas = traits_of(rough(7).heights)
    assert areas.anisotropy < 0.15
    assert areas.unresolved < 1e-12
    for n in (64, 128):
        x = (np.arange(n) + 0.3) / n - 0.5
        assert traits_of(-np.hypot(x[:, None], x)).unresolved > 0.3
        assert traits_of(np.tile(np.sign(x)[:, None], (1, n))).unresolved > 0.7


def rough(seed):
    return rough_surface((64, 64), seed=seed, waves=16, longest=1.95, gradient=1.0)


def rough_areas(seed, resolution):
    surface = rough(seed).resampled((16 * resolution, 16 * resolution))
    return contact_areas(solve(surface, SOFT, mean_pressure=0.05).checked(), subcell=True)


def test_located_area_of_rough_surfaces_is_right_to_three_per_mille_at_eight_points_per_wave():
    errors = []
    for seed in (301, 302, 303):
        fine, coarse = rough_areas(seed, 32), rough_areas(seed, 8)
        errors.append(coarse.subcell / fine.subcell - 1)
        assert coarse.pixel > 1.04 * fine.subcell
    assert np.sqrt(np.mean(np.square(errors))) < 3e-3


def test_edges_come_in_pairs_along_each_direction():
    result, _ = paraboloid(64, 0.15, (0.3, 0.8))
    edges = contact_edges(result)
    for axis in (0, 1):
        along = edges.axis == axis
        assert np.count_nonzero(along & (edges.sign > 0)) == np.count_nonzero(along & (edges.sign < 0))
    count = contact_areas(result).edge_fraction * 64**2
    assert edges.axis.size == round(count)
    assert np.all(result.in_contact.ravel()[edges.inside])


def test_located_area_of_full_and_no_contact():
    full = made_contact(np.ones((8, 8), dtype=bool))
    assert subcell_area(full) == 1.0
    assert subcell_area(made_contact(np.zeros((8, 8), dtype=bool))) == 0.0


def test_shifts_average_out_the_noise_of_the_lattice():
    result, area = paraboloid(96, 0.1, (0.0, 0.0))
    values = []
    for shift in subgrid_shifts(4):
        result, area = paraboloid(96, 0.1, shift)
        values.append(contact_areas(result))
    mean = mean_areas(values)
    single = np.sqrt(np.mean([(value.perimeter / area - 1) ** 2 for value in values]))
    assert abs(mean.perimeter / area - 1) < 0.5 * single
    assert mean.edge_fraction == pytest.approx(mean.edge_length / 96)
    assert mean.subcell is None
    located = [dataclasses.replace(values[0], subcell=area) for area in (0.1, 0.2, 0.6)]
    assert mean_areas(located).subcell == pytest.approx(0.3)
    with pytest.raises(InvalidInput, match="one grid"):
        mean_areas([values[0], areas_on(32, limit=0.1, constant=0.1)])
    with pytest.raises(InvalidInput, match="per_axis"):
        subgrid_shifts(0)


@pytest.mark.parametrize("pressure", [0.05, 0.01])
def test_located_areas_of_finite_and_boundary_elements_agree(pressure):
    surface = rough(309).resampled((256, 256))
    solid = Solid(young=1 - 0.3**2, poisson=0.3)
    by_boundary = solve(surface, SOFT, mean_pressure=pressure).checked()
    meshed = block.solve(surface, solid, mean_pressure=pressure, growth=1.1, element="Hex1")
    edges = {"edge_map": EDGE_MAPS["fem"], "edge_constant": EDGE_CONSTANTS["fem"]}
    one = contact_areas(by_boundary, subcell=True)
    other = contact_areas(meshed.contact.checked(), subcell=True, **edges)
    assert other.pixel > 1.015 * one.pixel
    assert other.subcell == pytest.approx(one.subcell, rel=4e-3)
