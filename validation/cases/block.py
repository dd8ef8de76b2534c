"""The finite-element block: its exact reduction, its elements, a modulus that varies, finite strain."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import brentq

from fem_contact import block
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface
from persson.spectrum import SelfAffine
from validation.arrays import Array, Grid
from validation.cases import Case, Checks, below, case, order, relative
from validation.cases._closed_forms import periodic
from validation.measurements.statistics import largest_difference, relative_distance

_LAYER = "[johnson_book], Sec. 5.8: an elastic layer bonded to a rigid base"
_SAME = "code verification: two ways to solve one discrete system"


def _rough(shape: Grid) -> HeightField:
    spectrum = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=2 * math.pi, q_short=8 * math.pi)
    lengths = (1.0, shape[1] / shape[0])
    return random_surface(spectrum, q_short=spectrum.q_short, lengths=lengths, shape=shape, seed=31415)


def _solved(element: str, shape: Grid, poisson: float, **settings: Any) -> block.BlockSolution:
    surface, solid = _rough(shape), Solid(young=1.0, poisson=poisson)
    load = 0.05 * solid.contact_modulus * surface.rms_gradient
    return block.solve(surface, solid, mean_pressure=load, element=element, **settings)


def _both_ways(element: str, shape: Grid, poisson: float) -> Checks:
    full = _solved(element, shape, poisson, method="full", tolerance=1e-11)
    reduced = _solved(element, shape, poisson, tolerance=1e-12)
    a, b = full.contact.checked(), reduced.contact.checked()
    forces = relative_distance(b.pressure, a.pressure)
    fields = largest_difference(reduced.field, full.field)
    yield below("relative L2 difference of nodal forces", forces, 1e-9)
    yield below("nodes in contact in one solution only", np.sum(a.in_contact != b.in_contact), 0.0)
    yield below("largest difference of displacement in the block", fields, 1e-9)
    yield below("forces that nothing balances, reduced", reduced.equilibrium().residual, 1e-9)


@case("block-assembled", source=_SAME, tolerance="solver")
def _assembled() -> Checks:
    """scikit-fem's assembled matrix and pyamg find the same field under the contact forces."""
    for element, poisson, shape in (("Hex1", 0.3, (24, 16)), ("Hex2/P1disc", 0.45, (16, 12))):
        contact = _solved(element, shape, poisson, modulus=_particle, method="full", tolerance=1e-11)
        difference = largest_difference(block.assembled_field(contact, tolerance=1e-11), contact.field)
        yield below(f"largest difference of displacement, {element}", difference, 1e-9)


#: Element, Poisson ratio, growth, nodes per wave, bounds on the errors along the axis and the diagonal.
_WAVES = (
    ("Hex1", 0.3, 1.2, 12, 3e-3, 1.5e-2),
    ("Hex1/P0", 0.3, 1.2, 12, 3e-2, 3e-2),
    ("Hex1/P0", 0.49, 1.2, 12, 3e-2, 3e-2),
    ("Hex1/P0", 0.4999, 1.2, 12, 3e-2, 3e-2),
    ("Hex2", 0.3, 1.5, 16, 2e-3, 2e-3),
    ("Hex2", 0.3, 1.1, 32, 2e-4, 2e-4),
    ("Hex2/P1disc", 0.4999, 1.5, 16, 2e-3, 2e-3),
    ("Hex2/P1disc", 0.5, 1.5, 16, 2e-3, 2e-3),
    ("Hex2/P1disc", 0.5, 1.1, 32, 2e-4, 2e-4),
)


@case("block-waves", source=_LAYER, tolerance="grid")
def _waves() -> Checks:
    """Every element meets the compliance of the bonded layer, to the accuracy it is chosen for."""
    for element, poisson, growth, nodes, axis, diagonal in _WAVES:
        (errors,) = block.wave_errors(
            (256, 256), (1.0, 1.0), [nodes / 256], poisson=poisson, growth=growth, element=element
        )
        name = f"{element}, nu = {poisson}, {nodes} nodes per wave, growth {growth}"
        yield below(f"error along the axis: {name}", errors.along_axis, axis)
        yield below(f"error along the diagonal: {name}", errors.along_diagonal, diagonal)


@case("block-order", source=_LAYER, tolerance="grid")
def _orders() -> Checks:
    """With growth - 1 in proportion to the cell the finite-element limit is the elastic limit."""
    for element, poisson, expected in (("Hex1", 0.3, 2), ("Hex1/P0", 0.49, 2), ("Hex2", 0.3, 4)):
        sizes, errors = (32, 64, 128), []
        for n in sizes:
            (wave,) = block.wave_errors(
                (n, n), (1.0, 1.0), [1.0], poisson=poisson, element=element, growth=1 + 1.6 * expected / 2 / n
            )
            errors.append(abs(wave.along_diagonal))
        yield order(f"observed order, {element}", sizes, errors, expected=expected, tolerance=0.4)


def _particle(x: Array, y: Array, z: Array) -> Array:
    return np.where((x - 0.5) ** 2 + (y - 0.3) ** 2 + (z + 0.12) ** 2 < 0.1**2, 10.0, 1.0)


CASES = tuple(
    Case(
        name=f"block-reduction-{name}",
        claim=f"The reduced and the full block have one solution: {element}, nu = {nu}.",
        run=partial(_both_ways, element, shape, nu),
        source=_SAME,
        quick=quick,
        tolerance="solver",
    )
    for name, element, shape, nu, quick in (
        ("hex1", "Hex1", (32, 32), 0.3, False),
        ("hex1-rectangle", "Hex1", (15, 22), 0.3, True),
        ("hex2", "Hex2", (16, 16), 0.3, False),
        ("hex2-fine", "Hex2", (32, 32), 0.3, False),
        ("p0", "Hex1/P0", (16, 16), 0.4999, False),
        ("p1disc", "Hex2/P1disc", (12, 12), 0.4999, True),
    )
)


_SOLID = Solid(young=2.0, poisson=0.3)
_SHEAR, _BULK = 1 / 1.3, 2 / (3 * 0.4)
_MESH: dict[str, Any] = {"depth": 0.5, "growth": 2.0}


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
    solution = block.solve_finite_strain(_wavy(1e-9, 6), _SOLID, mean_pressure=load, tolerance=1e-6, **_MESH)

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
    path = [block.solve_finite_strain(surface, _SOLID, mean_pressure=p, **_MESH) for p in loads.tolist()]
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
    linear = block.solve(surface, _SOLID, mean_pressure=load, method="full", tolerance=1e-11, **_MESH)
    expected = linear.contact.pressure / load
    slopes = (1e-4, 2e-4, 4e-4)
    path = block.solve_slopes(surface, _SOLID, mean_pressure=load, slopes=slopes, **_MESH)
    errors = [relative_distance(each.pressure / each.mean_pressure, expected) for each in path]
    steps = [1 / h for h in slopes[::-1]]
    yield order("order in the slope", steps, errors[::-1], expected=1.0, tolerance=0.05)
    yield below("difference of pressure at h' = 1e-4", errors[0], 1e-3)
