"""The limit of the located area: known answers of its law, and whether its uncertainty holds."""

import dataclasses

import numpy as np
import pytest
from made_results import made_areas
from surfaces import SOFT

from fem_contact import HeightField, contact_areas, located_limit, perimeter_limit
from fem_contact.bem import solve
from fem_contact.extrapolation import PlannedGrid, predicted_uncertainty, too_small

#: Of the coefficients of the law, by power of the width.
MEANS = {1.0: -0.00359, 1.5: 0.00919, 2.0: -0.00678, 3.0: 0.00087}


def areas_on(n, *, limit=0.1, terms, edge=6.0, repeats=1):
    """Areas that follow the law exactly: f = `edge`/n, and beyond its means `terms` by power of the width.

    A contact that `repeats` itself in the period has that many times the cells, and less noise.
    """
    fraction = edge / n
    width = fraction / (limit * (1 - limit) ** 1.25)
    both = [*MEANS.items(), *terms.items()]
    error = sum(c * fraction * width**power for power, c in both)
    areas = {"pixel": limit + 0.1 * fraction, "subcell": limit + error, "cells": n * n * repeats}
    return made_areas(limit, n, fraction, edge_constant=0.103, **areas)


GRIDS = (48, 64, 96, 128, 192, 256)


#: Deviations of coefficients by power of the width, of 80 patches; noise a, b z; each grid anew.
LOCATED = {0.0: 0.00011, 1.0: 0.0003, 1.5: 0.00055, 2.0: 0.00015, 3.0: 0.00025}
LAWS = {"subcell": (LOCATED, (0.006, 0.026), 0.0005), "perimeter": ({0.0: 0.02, 1.0: 0.01}, (0.23, 0.0), 0.0)}


@pytest.mark.parametrize(
    ("definition", "grids"), [("subcell", (96,)), ("subcell", (48, 64, 96)), ("perimeter", (48, 64, 96))]
)
def test_limits_hold_what_was_planted_as_often_as_they_say(definition, grids):
    """Errors f z^k of a surface and noise of each grid, drawn 1000 times by the law."""
    generator, plants = np.random.default_rng(len(grids)), 1000
    deviations, noise, odd = LAWS[definition]
    width = 6 / np.array(grids) / (0.1 * 0.9**1.25)
    # 6^2 / (.1 .9^1.25) / 20 patches: fewer than 80 differ by more.
    spread = (80 * 20 * 0.1 * 0.9**1.25 / 36) ** 0.25 if definition == "subcell" else 1.0
    held = 0
    for _ in range(plants):
        terms = {k: (spread if k else 1) * s * generator.standard_normal() for k, s in deviations.items()}
        areas = []
        for n, z in zip(grids, width, strict=True):
            scatter = (6 / n) ** 0.5 / n * np.hypot(noise[0], noise[1] * z)
            off = np.hypot(scatter, odd * spread * 6 / n * z**2) * generator.standard_normal()
            area = areas_on(n, terms=terms)
            if definition == "perimeter":
                off += 0.1 - area.perimeter + sum(c * 6 / n * z**k for k, c in terms.items())
            areas.append(dataclasses.replace(area, **{definition: getattr(area, definition) + off}))
        limit = (located_limit if definition == "subcell" else perimeter_limit)(areas)
        held += abs(limit.value - 0.1) <= 1.96 * limit.uncertainty
    # Intervals are a tenth wider on one grid, and where grids disagree by more than the law, by that factor.
    x, rest = generator.standard_normal(10**6), generator.chisquare(max(len(grids) - 1, 1), 10**6)
    factor = np.sqrt(np.maximum(1, rest / (len(grids) - 1))) if len(grids) > 1 else 1.1
    expected = np.mean(abs(x) <= 1.96 * factor)
    assert held / plants == pytest.approx(expected, abs=3 * (expected * (1 - expected) / plants) ** 0.5)


@pytest.mark.parametrize("edge_constant", [0.103, 0.137, 0.198, 0.260])
def test_cells_that_are_too_soft_are_off_by_means_of_their_own(edge_constant):
    """f (k_0 + k_1 z), in proportion to what their edge constant exceeds that of boundary elements by."""
    areas, soft = [], edge_constant - 0.103
    for area in (areas_on(n, terms={}) for n in GRIDS):
        f = area.edge_fraction
        off = f * soft * 0.15 * (f / (0.1 * 0.9**1.25) - 1)
        areas.append(dataclasses.replace(area, perimeter=0.1 + off, edge_constant=edge_constant))
    limit = perimeter_limit(areas)
    assert limit.value == pytest.approx(0.1, abs=0.1 * limit.uncertainty)


@pytest.mark.parametrize("grids", [GRIDS[-1:], GRIDS])
def test_where_all_that_was_counted_is_edge_there_is_no_limit(grids):
    limit = perimeter_limit([dataclasses.replace(areas_on(n, terms={}), perimeter=0.0) for n in grids])
    assert np.isnan(limit.value)
    assert np.isnan(limit.uncertainty)


def test_what_is_predicted_from_a_coarse_grid_is_what_fine_ones_claim():
    areas = [areas_on(n, terms={}) for n in GRIDS]
    plan = [PlannedGrid(spacing=area.spacing, cells=area.cells) for area in areas]
    # The coarse grid's own area stands for that of the finest.
    assert predicted_uncertainty(areas[0], plan) == pytest.approx(located_limit(areas).uncertainty, rel=1e-3)
    single = predicted_uncertainty(areas[0], plan[:1])
    assert predicted_uncertainty(dataclasses.replace(areas[0], pixel=0.0, edge_fraction=0.0), plan) == np.inf
    assert single == pytest.approx(located_limit(areas[:1]).uncertainty, rel=1e-9)


def test_full_contact_is_certain():
    area = dataclasses.replace(areas_on(64, terms={}), subcell=1.0, edge_fraction=0.0)
    limit = located_limit([area, dataclasses.replace(area, spacing=(1 / 32, 1 / 32))])
    assert (limit.value, limit.uncertainty) == (1.0, 0.0)


@pytest.mark.parametrize("points", [1, 15])
def test_a_contact_of_a_few_points_has_no_limit_whatever_its_located_area(points):
    """One grid point held at each of 32, 64, 128 had given A/A0 = -.00006 +- .00000."""
    few = [(areas_on(n, terms={}), {"pixel": points / n**2, "subcell": -1e-4 / n}) for n in (32, 64, 128)]
    areas = [dataclasses.replace(one, **told) for one, told in few]
    limit = located_limit(areas)
    assert np.isnan(limit.value)
    assert np.isnan(limit.uncertainty)
    assert f"{points} point" in limit.doubt
    assert not limit.determinable
    assert too_small([dataclasses.replace(areas[-1], pixel=16 / 128**2)]) == ""


@pytest.mark.parametrize("value", [-0.01, 0.0, 1.001])
def test_an_estimate_that_is_no_share_of_an_area_is_not_claimed(value):
    limit = located_limit([dataclasses.replace(areas_on(n, terms={}), subcell=value) for n in (64, 128)])
    assert np.isnan(limit.value)
    assert "no share" in limit.doubt


def test_a_coarse_grid_without_area_inside_its_edges_is_left_out():
    fine = [areas_on(n, terms={1.0: 4e-4}) for n in (128, 256)]
    empty = dataclasses.replace(areas_on(16, terms={}), subcell=-0.01)
    assert located_limit([empty, *fine]).value == located_limit(fine).value


def test_no_accuracy_is_predicted_for_grids_too_coarse_for_the_contact():
    coarse = dataclasses.replace(areas_on(64, terms={}), pixel=0.001, subcell=0.001)
    plan = [PlannedGrid(spacing=(1 / n, 1 / n), cells=n * n) for n in (96, 120)]
    assert predicted_uncertainty(coarse, plan) == np.inf
    plan = [PlannedGrid(spacing=(1 / n, 1 / n), cells=n * n) for n in (96, 192)]
    assert predicted_uncertainty(coarse, plan) < np.inf


def straight_wave(n, area, *, shift, along=(1, 0)):
    """Westergaard's wave, pressed until it touches over `area` of all; `along` are its periods."""
    count = n if along[1] else 4
    x, y = (np.arange(n) + shift) / n, np.arange(count) / n
    heights = 0.02 / np.hypot(*along) * np.cos(2 * np.pi * (along[0] * x[:, None] + along[1] * y))
    field = HeightField(heights=heights, lengths=(1.0, count / n))
    load = np.pi * 0.02 * np.sin(np.pi * area / 2) ** 2
    return contact_areas(solve(field, SOFT, mean_pressure=load, threads=1).checked(), subcell=True)


@pytest.mark.parametrize(("along", "grids"), [((1, 0), (64, 128, 256)), ((1, 1), (48, 64, 96))])
def test_the_limit_of_a_straight_wave_holds_its_closed_form(along, grids):
    """Its edges all lie alike between the grid points, and do not average: it had been off by 6 errors."""
    generator = np.random.default_rng(61)
    misses = []
    for _ in range(20 if along == (1, 0) else 5):
        area, shift = generator.uniform(0.1, 0.9), generator.random()
        limit = located_limit([straight_wave(n, area, shift=shift, along=along) for n in grids])
        misses.append((limit.value - area) / limit.uncertainty)
        # It says something, still: the two edges are placed to some hundredths of a cell.
        assert limit.uncertainty < 2 * 0.05 / grids[-1] * np.hypot(*along)
    assert np.max(np.abs(misses)) < 2
    assert np.sqrt(np.mean(np.square(misses))) > 0.2


def test_a_contour_of_all_directions_is_even_and_a_line_is_not():
    assert straight_wave(32, 0.4, shift=0.3).alignment == 1
    assert straight_wave(32, 0.4, shift=0.3, along=(1, 1)).alignment == 1
    x = (np.arange(64) + 0.3) / 64 - 0.5
    cap = HeightField(heights=-(x[:, None] ** 2 + x**2) / 2, lengths=(1.0, 1.0))
    disc = solve(cap, SOFT, mean_pressure=0.01, threads=1).checked()
    assert contact_areas(disc, subcell=True).alignment == 0
    assert contact_areas(disc).alignment == 0


def test_what_is_predicted_knows_of_edges_that_run_alike():
    areas = [straight_wave(n, 0.4, shift=0.3) for n in (32, 48)]
    plan = [PlannedGrid(spacing=area.spacing, cells=area.cells) for area in areas]
    predicted = predicted_uncertainty(areas[0], plan)
    assert predicted == pytest.approx(located_limit(areas).uncertainty, rel=0.05)
    assert predicted > 2 * predicted_uncertainty(dataclasses.replace(areas[0], alignment=0.0), plan)


def kinked_on(n, *, off):
    """Area of a surface with kinks, which converges in first order only."""
    area = areas_on(n, terms={}, repeats=10**4)
    return dataclasses.replace(area, subcell=area.subcell + off * area.edge_fraction, unresolved=0.5)


@pytest.mark.parametrize("grids", [(64, 128), (96, 128), (64, 96, 128)])
def test_the_limit_at_kinks_holds_an_area_of_first_order_however_well_the_law_knows_others(grids):
    """A few per cent off, it had been 30 standard errors off."""
    kinked = located_limit([kinked_on(n, off=0.1) for n in grids])
    assert abs(kinked.value - 0.1) < 1.2 * kinked.uncertainty < 0.02
    smooth = located_limit([dataclasses.replace(kinked_on(n, off=0.0), unresolved=0.0) for n in grids])
    assert smooth.uncertainty < 0.05 * kinked.uncertainty


def test_grids_that_agree_at_kinks_may_do_so_by_chance_and_one_alone_says_less():
    agree = located_limit([kinked_on(n, off=0.0) for n in (64, 128)])
    less = dataclasses.replace(kinked_on(128, off=0.0), unresolved=0.125)
    alone = located_limit([less])
    assert agree.uncertainty > 0.02 * less.edge_fraction
    assert alone.uncertainty > 0.5 * 0.15 * less.edge_fraction
    plan = [PlannedGrid(spacing=(1 / 128, 1 / 128), cells=128**2 * 10**4)]
    coarse = dataclasses.replace(kinked_on(64, off=0.0), unresolved=0.125)
    assert predicted_uncertainty(coarse, plan) == pytest.approx(alone.uncertainty, rel=0.01)
    assert "one grid" in located_limit([kinked_on(128, off=0.0)]).doubt


def test_full_contact_with_kinks_that_the_grid_does_not_resolve_has_no_limit():
    told = {"subcell": 1.0, "edge_fraction": 0.0, "unresolved": 0.4}
    full = [dataclasses.replace(areas_on(n, terms={}), **told) for n in (64, 128)]
    assert "touches everywhere" in located_limit(full).doubt


def test_steps_are_refused_by_name_even_where_grids_agree():
    """Terraces at p* = .6 gave .80, .78 and .75 at 4, 6 and 8 points per wave, where the truth is .52."""
    stepped = [dataclasses.replace(areas_on(n, terms={}), unresolved=0.85) for n in (64, 96, 128)]
    assert "steps" in located_limit(stepped).doubt
    x = np.arange(48) / 48
    heights = np.round(3 * np.cos(2 * np.pi * x)[:, None] * np.cos(2 * np.pi * (x + 0.2))[None, :])
    terraces = HeightField(heights=0.01 * heights, lengths=(1.0, 1.0))
    pressed = solve(terraces, SOFT, mean_pressure=0.01, threads=1).checked()
    assert contact_areas(pressed).unresolved > 0.7


def test_the_limit_of_a_wavy_surface_holds_a_finer_grid():
    """Westergaard contacts of two crossed waves, no surface of the kind the law was measured on."""

    def areas(n):
        x = np.cos(2 * np.pi * (np.arange(n) + 0.3) / n)
        field = HeightField(heights=0.1 * (x[:, None] + x[None, :]), lengths=(1.0, 1.0))
        return contact_areas(solve(field, SOFT, mean_pressure=0.05, threads=1).checked(), subcell=True)

    limit = located_limit([areas(n) for n in (20, 32, 50)])
    truth = located_limit([areas(n) for n in (144, 180, 256)])
    assert abs(limit.value - truth.value) < 2 * np.hypot(limit.uncertainty, truth.uncertainty)
    assert 2 * limit.uncertainty < 0.01 * limit.value
