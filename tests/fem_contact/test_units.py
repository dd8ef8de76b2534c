"""Another unit system changes no bit of a dimensionless result: lengths times 2^20, pressures times 2^-30."""

from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from surfaces import rough_surface

from fem_contact import BondedLayer, HalfSpace, HeightField, Solid, adhesion, bem, block, random_surface
from fem_contact.creeping import creep
from fem_contact.graded import ExponentialSolid, LayeredSolid
from fem_contact.hardness import Hardness, press_yielding
from fem_contact.sliding import slide
from fem_contact.stress import density_at_zero
from fem_contact.subsurface import strongest_point
from fem_contact.viscoelastic import PronySolid


def rough(length, shape=(24, 20)):
    surface = rough_surface(shape, (1.0, shape[1] / shape[0]), seed=31, waves=6)
    return HeightField(heights=surface.heights * length, lengths=(length, length * shape[1] / shape[0]))


def solid(stress, *, young=1.0):
    return Solid(young=young * stress, poisson=0.3)


def contact_fields(contact, length, stress):
    return contact.pressure / stress, contact.gap / length


def drawn(length, _, *, amplitudes):
    told = {"q_short": 15 * np.pi / length, "lengths": (length, 1.1 * length), "amplitudes": amplitudes}
    power = lambda q: 1e-6 * np.maximum(q * length, 9.0) ** -3.6 * length**4  # noqa: E731
    made = random_surface(power, **told, shape=(20, 27), seed=7)
    moved = (made, made.resampled((33, 16)), made.shifted((0.3, -0.6)))
    heights = [one.heights / length for one in moved]
    return *heights, made.rms_gradient, made.nayak, made.rms_height / length


def near_zero(length, stress):
    found = bem.solve(rough(length), HalfSpace(solid=solid(stress)), mean_pressure=0.01 * stress)
    return [density_at_zero(found).reduced]


def yielding(length, stress):
    hard = Hardness(pressure=0.045 * stress, length=0.02 * length, exponent=0.7)
    body = HalfSpace(solid=solid(stress))
    found = press_yielding(rough(length), body, hardness=hard, mean_pressure=0.005 * stress)
    assert found.at_bound.any()
    return contact_fields(found, length, stress)


def sticking(length, stress):
    law = adhesion.Exponential(work=1e-4 * length * stress, reach=4e-3 * length)
    load = {"hardness": 0.06 * stress, "mean_pressure": 0.01 * stress}
    found = adhesion.solve(rough(length), HalfSpace(solid=solid(stress)), law=law, **load, threads=1)
    return contact_fields(found.contact, length, stress)


def graded(length, stress):
    q = np.geomspace(1e-2, 1e3, 41) / length
    top, base = solid(stress), solid(stress, young=7.0)
    layers = LayeredSolid(layers=[top], thicknesses=[length], base=base)
    profile = ExponentialSolid(surface=top, bulk_young=7 * stress, depth=length)
    return [response.compliance(q, 0 * q) * (stress / length) for response in (layers, profile)]


def below(length, stress):
    layer = BondedLayer(solid=solid(stress), thickness=0.15 * length)
    found = strongest_point(bem.solve(rough(length), layer, mean_pressure=0.3 * stress), layer)
    return found.von_mises / stress, found.depth / length


def of_block(length, stress, *, method):
    found = block.solve(rough(length, (16, 12)), solid(stress), mean_pressure=0.01 * stress, method=method)
    numbers = found.contact.residuals.worst, found.contact.cost.linear_iterations or 0
    return found.contact.pressure / stress, found.field / length, *numbers


def sliding(length, stress):
    rubber = PronySolid.standard(relaxed=stress, unrelaxed=100 * stress, time=1.0, poisson=0.3)
    found = slide(rough(length), rubber, velocity=0.1 * length, mean_pressure=0.01 * stress)
    return found.friction, *contact_fields(found.contact, length, stress)


def creeping(length, stress):
    rubber = PronySolid(relaxed=stress, moduli=(2 * stress,), times=(length,), poisson=0.3)
    loads = np.array([1e-3, 2e-3, 1e-3, 1e-3]) * stress
    path = creep(rough(length), rubber, times=np.array([0, 0.5, 0.5, 1]) * length, mean_pressure=loads)
    return [field for one in path for field in contact_fields(one, length, stress)]


QUANTITIES = [near_zero, yielding, sticking, graded, below, sliding, creeping]
QUANTITIES += [partial(drawn, amplitudes=kind) for kind in ("exact", "gaussian")]
QUANTITIES += [partial(of_block, method=method) for method in ("full", "reduced")]


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_another_unit_system_changes_no_bit(quantity):
    for one, other in zip(quantity(1.0, 1.0), quantity(2.0**20, 2.0**-30), strict=True):
        assert np.all(np.isfinite(one))
        assert_array_equal(other, one)
