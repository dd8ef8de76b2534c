"""Adhesion and hardness together: a law of the gap on a wall that yields."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from surfaces import SOFT, rough_surface

from fem_contact import Hardness, adhesion, press_yielding, yielded
from fem_contact.adhesion.descent import Landscape
from fem_contact.adhesion.laws import Dugdale, Exponential

LOAD, POINTS = 0.01, 64
TOLERANCE = 1e-9


def rough():
    return rough_surface((POINTS, POINTS), seed=31, waves=8)


def law(work, kind=Exponential):
    """Return the law of that work whose process zone spans three cells."""
    return kind(work=work, reach=math.sqrt(3 / POINTS * work))


def sticky(work, hardness, *, kind=Exponential, **options):
    said = {"mean_pressure": LOAD, "tolerance": TOLERANCE, "threads": 1} | options
    return adhesion.solve(rough(), SOFT, law=law(work, kind), hardness=hardness, **said).checked()


@pytest.mark.parametrize("kind", [Exponential, Dugdale])
@pytest.mark.parametrize("hardness", [0.1, 0.03, 0.012])
def test_pressure_obeys_the_bound_where_it_sinks_and_the_law_where_it_is_open(kind, hardness):
    state = sticky(1e-4, hardness, kind=kind)
    contact, found = state.contact, yielded(state.contact)
    allowed = TOLERANCE * max(state.law.strength, hardness)
    assert_allclose(contact.pressure[contact.at_bound], hardness, atol=allowed)
    assert contact.pressure.max() <= hardness + allowed
    open_ = contact.gap > 0
    assert_allclose(contact.pressure[open_], -state.law.traction(contact.gap[open_]), atol=2 * allowed)
    assert found.elastic_area + found.plastic_area + found.open_area == pytest.approx(1, abs=1e-14)
    assert found.elastic_load + found.plastic_load == pytest.approx(LOAD, rel=1e-12)
    assert found.volume > 0


def test_a_hardness_is_a_number_of_any_kind_or_a_list_of_them():
    found = sticky(1e-4, 1.0, tolerance=1e-6).contact.pressure
    whole = np.ones((POINTS, POINTS), dtype=np.uint32)
    for hardness in (np.uint32(1), whole, whole.tolist()):
        assert_array_equal(sticky(1e-4, hardness, tolerance=1e-6).contact.pressure, found)


def test_a_hardness_above_every_pressure_leaves_adhesion_as_it_is():
    plain, bounded = sticky(1e-4, None), sticky(1e-4, 10.0)
    assert_array_equal(bounded.contact.pressure, plain.contact.pressure)
    assert bounded.energy == plain.energy
    assert not bounded.contact.at_bound.any()


def test_without_much_adhesion_the_answer_is_that_of_hardness_alone():
    hardness = 0.06
    asked = {"mean_pressure": LOAD, "tolerance": 1e-10, "threads": 1}
    alone = press_yielding(rough(), SOFT, hardness=Hardness(pressure=hardness), **asked)
    distances = []
    for work in (1e-5, 1e-6, 1e-7):
        contact = sticky(work, hardness).contact
        distances.append(np.linalg.norm(contact.pressure - alone.pressure) / np.linalg.norm(alone.pressure))
    # Attraction is of the strength w / reach ~ sqrt(w) around contacts and carries the load away from them.
    assert distances[1] < 0.6 * distances[0]
    assert distances[2] < 0.6 * distances[1]
    assert distances[2] < 0.02


def test_the_state_is_lower_in_energy_than_its_perturbed_neighbours():
    state = sticky(1e-4, 0.03)
    contact, rng = state.contact, np.random.default_rng(23)
    land = Landscape(contact.heights, response=SOFT, lengths=contact.lengths, law=state.law, hardness=0.03)

    def potential(gap):
        shape = gap + land.heights
        return float(np.mean(0.5 * land.stiff(shape) * shape + land.stored(gap) + LOAD * gap))

    least = potential(contact.gap)
    for size in (1e-3, 1e-2, 0.1):
        noise = size * state.law.reach * rng.standard_normal(contact.gap.shape)
        assert potential(contact.gap + noise) > least
    assert adhesion.stability(state, SOFT).is_minimum
