import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from surfaces import SOFT, rough_surface

from fem_contact import FreeHalfSpace, InvalidInput, Solid, Status, bem, find_patches
from fem_contact.hardness import Hardness, press_by_patches, press_yielding, yielded
from fem_contact.surface import Patch

LOAD = 0.01


def rough(points=64, *, waves=8, gradient=0.1):
    return rough_surface((points, points), seed=31, waves=waves, gradient=gradient)


def pressed(hardness, load=LOAD, **options):
    hard = {"hardness": Hardness(pressure=hardness), "mean_pressure": load, "threads": 1}
    return press_yielding(rough(), SOFT, **hard, **options).checked()


@pytest.mark.parametrize("hardness", [0.011, 0.03, 0.1, 0.3])
def test_areas_add_up_to_the_nominal_area_and_loads_to_the_load(hardness):
    found = yielded(pressed(hardness))
    assert found.elastic_area + found.plastic_area + found.open_area == pytest.approx(1, abs=1e-14)
    assert found.elastic_load + found.plastic_load == pytest.approx(LOAD, rel=1e-12)
    assert found.plastic_load == pytest.approx(hardness * found.plastic_area, rel=1e-12)


def test_a_hardness_above_every_pressure_changes_nothing():
    elastic = bem.solve(rough(), SOFT, mean_pressure=LOAD, threads=1).checked()
    found = pressed(2 * float(elastic.pressure.max()))
    assert yielded(found).plastic_area == 0
    assert yielded(found).volume == 0
    assert_allclose(found.pressure, elastic.pressure, atol=1e-6 * elastic.pressure.max())


def test_plastic_area_tends_to_load_over_hardness_as_the_solid_gets_softer():
    shares = [yielded(pressed(hardness)).plastic_area * hardness / LOAD for hardness in (0.2, 0.05, 0.0125)]
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1, abs=0.05)


def test_pressing_the_smoothed_surface_again_is_elastic_and_gives_the_same_pressure():
    first = pressed(0.05, tolerance=1e-10)
    smooth = yielded(first).surface
    again = bem.solve(smooth, SOFT, mean_pressure=LOAD, tolerance=1e-10, threads=1).checked()
    assert_allclose(again.pressure, first.pressure, atol=1e-4 * 0.05)
    assert again.offset == pytest.approx(first.offset, rel=1e-6)


def test_what_is_shown_of_a_yielded_contact_has_no_arrays():
    found = yielded(press_yielding(rough(), SOFT, hardness=Hardness(pressure=1.0), mean_pressure=0.3))
    assert "array" not in repr(found)


def test_unloading_is_elastic_and_has_more_contact_than_loading():
    first = pressed(0.05)
    (back,) = bem.solve_path(yielded(first).surface, SOFT, mean_pressures=[LOAD / 4], threads=1)
    loading = pressed(0.05, load=LOAD / 4)
    assert back.checked().pressure.max() < 0.05
    assert back.in_contact.mean() > loading.in_contact.mean()


def test_a_field_of_hardness_bounds_every_point_by_its_own():
    points = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    field = 0.06 * (1.5 + np.sin(points))[:, None] * np.ones(64)
    contact = pressed(field)
    assert np.all(contact.pressure <= field * (1 + 1e-12))
    assert contact.at_bound.any()
    assert_allclose(contact.pressure[contact.at_bound], field[contact.at_bound], rtol=1e-12)
    found = yielded(contact)
    assert found.elastic_load + found.plastic_load == pytest.approx(LOAD, rel=1e-12)


def test_load_equal_to_hardness_yields_everywhere_and_above_it_is_refused():
    found = yielded(pressed(LOAD))
    assert found.plastic_area == 1
    assert found.surface.rms_height < rough().rms_height
    with pytest.raises(InvalidInput, match="pressure_bound"):
        pressed(0.9 * LOAD)


SIZED = Hardness(pressure=0.045, length=0.02, exponent=0.7)


def by_hand(contact, hardness):
    patches = find_patches(contact.in_contact, contact.spacing)
    sizes = [math.sqrt(4 * area / math.pi) for area in patches.areas]
    bears = [hardness.pressure * (1 + hardness.length / size) ** 0.7 for size in sizes]
    return np.array([0.0, *bears])[patches.labels]


def test_every_patch_bears_what_its_size_allows_and_not_more():
    contact = press_yielding(rough(), SOFT, hardness=SIZED, mean_pressure=LOAD / 4).checked()
    bears = by_hand(contact, SIZED)
    assert contact.at_bound.sum() > 50
    assert contact.pressure[contact.at_bound] == pytest.approx(bears[contact.at_bound], rel=1e-12)
    assert (contact.pressure <= bears * (1 + 1e-9)).all()
    assert np.unique(bears[contact.at_bound]).size == 3
    # Harder than the bulk everywhere, softer than single cells.
    single = SIZED.of_patches(np.zeros(contact.shape, bool), contact.spacing)[0, 0]
    plain, cells = (yielded(pressed(p, load=LOAD / 4)).plastic_area for p in (SIZED.pressure, single))
    assert cells < 0.9 * yielded(contact).plastic_area < yielded(contact).plastic_area < 0.9 * plain
    assert contact.cost.fft_pairs > 20


@pytest.mark.parametrize("shape", [(8, 8), (64,), (1, 64), (1, 1)])
def test_a_hardness_of_another_shape_is_refused(shape):
    field = replace(SIZED, pressure=np.full(shape, SIZED.pressure))
    with pytest.raises(InvalidInput, match="pressure"):
        press_yielding(rough(), SOFT, hardness=field, mean_pressure=LOAD / 4)


def test_what_has_yielded_on_a_patch_is_a_patch():
    patch = Patch(heights=rough().heights, lengths=rough().lengths)
    free = FreeHalfSpace(solid=Solid(young=1.0, poisson=0.3))
    found = press_yielding(patch, free, hardness=Hardness(pressure=0.05), mean_pressure=1e-3)
    assert isinstance(yielded(found).surface, Patch)


def test_a_hardness_without_a_size_is_the_plain_one():
    plain = press_yielding(rough(), SOFT, hardness=Hardness(pressure=SIZED.pressure), mean_pressure=LOAD / 4)
    for length, exponent in ((0.0, 0.7), (0.1, 0.0)):
        same = Hardness(pressure=SIZED.pressure, length=length, exponent=exponent)
        found = press_yielding(rough(), SOFT, hardness=same, mean_pressure=LOAD / 4)
        assert np.array_equal(found.pressure, plain.pressure)


def test_patches_that_do_not_settle_and_solves_that_fail_are_said():
    contact = press_yielding(rough(), SOFT, hardness=SIZED, mean_pressure=LOAD / 4)
    rounds = []

    def endless(limits):
        rounds.append(limits)
        in_contact = np.zeros(contact.shape, bool)
        in_contact.flat[: len(rounds) + 1] = True
        return replace(contact, in_contact=in_contact)

    last, once = press_by_patches(rough(), SIZED, endless), contact.cost
    assert last.status is Status.ITERATION_LIMIT
    assert last.cost.fft_pairs == pytest.approx(len(rounds) * once.fft_pairs)
    assert (last.cost.unknowns, last.cost.peak_bytes) == (once.unknowns, once.peak_bytes)
    failed = replace(contact, status=Status.STAGNATED)
    assert press_by_patches(rough(), SIZED, lambda limits: failed).status is Status.STAGNATED
