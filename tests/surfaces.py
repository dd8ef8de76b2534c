"""Surfaces that the tests of solvers share, and the lattice sum behind Hertz's contact on a period."""

import numpy as np

from fem_contact import HalfSpace, HeightField, Solid, random_surface

#: A half-space of E* = 1.
SOFT = HalfSpace(solid=Solid(young=1.0, poisson=0.0))
#: Sum of |n|^-3 over the points of the square lattice but the origin: what the images of a load do to
#: the curvature below it.
LATTICE_CUBE = 9.03362168


def rough_surface(shape, lengths=(1.0, 1.0), *, seed, waves, longest=0.0, gradient=0.1):
    """Heights of H = 0.8 with waves of 1/`longest` to 1/`waves` of the longer side, and that rms gradient."""
    unit = 2 * np.pi / max(lengths)

    def power(q):
        return np.where(q >= longest * unit * (1 - 1e-9), (q / unit) ** -3.6, 0.0)

    surface = random_surface(power, q_short=waves * unit, lengths=lengths, shape=shape, seed=seed)
    return HeightField(heights=surface.heights * (gradient / surface.rms_gradient), lengths=lengths)


def periodic_paraboloid(n, radius, shift=(0.0, 0.0), *, modulus=1.0):
    """Tip of radius 1 in a unit period, the pressure whose contact has that radius, and distances from it.

    The periodic images add F / (2 pi E*) sum 1 / r^3 to the curvature, which the paraboloid is given less.
    """
    load = 4 * modulus * radius**3 / 3
    curvature = 1 - load * LATTICE_CUBE / (2 * np.pi * modulus)
    x, y = ((np.arange(n) + part) / n % 1 - 0.5 for part in shift)
    distance = np.hypot(x[:, None], y[None, :])
    return HeightField(heights=-curvature * distance**2 / 2, lengths=(1.0, 1.0)), load, distance
