"""Contact radius of a paraboloid by the full finite-element system, with the observed order."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import LATTICE_CUBE

from fem_contact.block import solve
from fem_contact.solid import Solid
from fem_contact.surface import HeightField

SOLID = Solid(young=1.0, poisson=0.3)

#: Sum of 1 / r^3 over the points of a unit square lattice other than the origin.


@pytest.mark.slow
def test_counted_radius_converges_to_hertz_in_first_order() -> None:
    load = 4 * SOLID.contact_modulus * (5 / 32) ** 3 / 3
    curvature = 1 + load / (2 * np.pi * SOLID.contact_modulus) * LATTICE_CUBE
    edge = (3 * load / (4 * SOLID.contact_modulus * curvature)) ** (1 / 3)
    # Where the centre falls in a cell moves the count of one solve by more than the trend; not the mean.
    centres = [(0, 0), (0.5, 0), (0.5, 0.5), (0.25, 0.25), (0.25, 0.5)]
    weights = [1, 2, 1, 4, 2]
    sizes, excess = (16, 32, 48), []
    for n in sizes:
        radii = []
        for shift in centres:
            x, y = ((np.arange(n) + s + n / 2) % n / n - 0.5 for s in shift)
            heights = -(x[:, None] ** 2 + y[None, :] ** 2) / 2
            surface = HeightField(heights=heights, lengths=(1.0, 1.0))
            contact = solve(surface, SOLID, mean_pressure=load).contact
            radii.append(np.sqrt(contact.checked().in_contact.mean() / np.pi))
        excess.append(float(np.average(radii, weights=weights)) / edge - 1)
    order = -np.polyfit(np.log(sizes), np.log(excess), 1)[0]
    assert excess == sorted(excess, reverse=True)
    assert excess[-1] < 0.04
    assert 0.6 < order < 1.5
