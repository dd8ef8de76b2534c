"""The block at finite strain: closed forms of its law, balance, and the linear block as its limit."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from fem_contact import block
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.cases import Checks, below, case, order, relative
from validation.cases._closed_forms import periodic
from validation.measurements.statistics import relative_distance

_SOLID = Solid(young=2.0, poisson=0.3)
_SHEAR, _BULK = 1 / 1.3, 2 / (3 * 0.4)


def _wavy(amplitude: float, points: int) -> HeightField:
    """Two waves that no symmetry of the grid holds in place."""
    x, y = np.meshgrid(*2 * [2 * math.pi * np.arange(points) / points], indexing="ij")
    return periodic(amplitude * (np.cos(x + 0.4) + np.cos(y) * np.cos(x) + 0.5 * np.sin(x + y)))


@case(
    "finite-strain-flat",
    source="W = mu/2 (J^(-2/3) tr C - 3) + K/2 (J - 1)^2 with two stretches 1",
    tolerance="solver",
)
def _flat() -> Checks:
    """A neo-Hookean block pressed flat takes the closed form of confined compression.

    Press a block whose sides cannot move to half of Young's modulus, far from small strain.
    """
    load = 1.0
    solution = block.solve_finite_strain(
        _wavy(1e-9, 6), _SOLID, mean_pressure=load, depth=0.5, growth=2.0, tolerance=1e-6
    )

    def excess(j: float) -> float:
        pressure: float = _SHEAR * 2 / 3 * (j ** (1 / 3) - j ** (-5 / 3)) + _BULK * (j - 1)
        return -pressure - load

    j = brentq(excess, 0.1, 1.0, xtol=1e-14)
    stored = _SHEAR / 2 * (j ** (-2 / 3) * (2 + j**2) - 3) + _BULK / 2 * (j - 1) ** 2
    yield relative("thickness over that before", 1 + solution.offset / 0.5, j, 1e-7)
    yield relative("stored energy [J/m^2]", solution.energy, 0.5 * stored, 1e-6)
    yield relative("projected area in contact", solution.area, 1.0, 1e-12)


@case("finite-strain-steep", source="equilibrium; a conservative body", tolerance="solver")
def _steep() -> Checks:
    """Under steep waves forces balance, and the work of the load is the energy stored."""
    surface = _wavy(0.05, 8)
    loads = 0.2 * _SOLID.contact_modulus * surface.rms_gradient * np.array([1, 1.0005, 1.001])
    path = [
        block.solve_finite_strain(surface, _SOLID, mean_pressure=float(p), depth=0.5, growth=2.0)
        for p in loads
    ]
    last = path[-1]
    offsets = np.array([each.offset for each in path])
    work = loads[0] * offsets[0] - loads[2] * offsets[2] + (loads[1] - loads[0]) / 3 * (offsets @ [1, 4, 1])
    rise = path[2].energy - path[0].energy
    yield below("unbalanced over contact forces", last.residual, 1e-8)
    gap, mean = last.gap[last.in_contact] / surface.rms_height, np.mean(last.pressure * last.shares)
    yield below("gap where there is contact, over h_rms", gap, 1e-8)
    yield relative("mean of pressure over projected area [Pa]", mean, loads[2], 1e-9)
    yield relative("rise of the stored energy: work of the load [J/m^2]", rise, work, 1e-6)
    yield below("force along the plane over the load", last.sideways, 0.03)


@case("finite-strain-limit", source="the full linear system on the same mesh", tolerance="estimate")
def _limit() -> Checks:
    """At small slopes the block of finite strain is the linear one, in first order."""
    surface = _wavy(0.01, 8)
    load = 0.2 * _SOLID.contact_modulus * surface.rms_gradient
    linear = block.solve(
        surface, _SOLID, mean_pressure=load, method="full", depth=0.5, growth=2.0, tolerance=1e-11
    )
    expected = linear.contact.pressure / load
    slopes = (1e-4, 2e-4, 4e-4)
    path = block.solve_slopes(surface, _SOLID, mean_pressure=load, slopes=slopes, depth=0.5, growth=2.0)
    errors = [relative_distance(each.pressure / each.mean_pressure, expected) for each in path]
    steps = [1 / h for h in slopes[::-1]]
    yield order("order in the slope", steps, errors[::-1], expected=1.0, tolerance=0.05)
    yield below("difference of pressure at h' = 1e-4", errors[0], 1e-3)
