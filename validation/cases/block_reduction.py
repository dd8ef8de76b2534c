"""The finite-element block: its exact reduction, its elements, and a modulus that varies sideways."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from fem_contact import block
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface
from persson.spectrum import SelfAffine
from validation.arrays import Array, Grid
from validation.cases import Case, Checks, below, case, order
from validation.measurements.statistics import largest_difference, relative_distance

_LAYER = "[johnson_book], Sec. 5.8: an elastic layer bonded to a rigid base"
_SAME = "code verification: two ways to solve one discrete system"


def _rough(shape: Grid) -> HeightField:
    spectrum = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=2 * math.pi, q_short=8 * math.pi)
    lengths = (1.0, shape[1] / shape[0])
    return random_surface(spectrum, q_short=spectrum.q_short, lengths=lengths, shape=shape, seed=31415)


def _both_ways(element: str, shape: Grid, poisson: float) -> Checks:
    surface, solid = _rough(shape), Solid(young=1.0, poisson=poisson)
    load = 0.05 * solid.contact_modulus * surface.rms_gradient
    full = block.solve(surface, solid, mean_pressure=load, method="full", element=element, tolerance=1e-11)
    reduced = block.solve(surface, solid, mean_pressure=load, element=element, tolerance=1e-12)
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
        surface, solid = _rough(shape), Solid(young=1.0, poisson=poisson)
        load = 0.05 * solid.contact_modulus * surface.rms_gradient
        options: dict[str, Any] = {"element": element, "modulus": _particle}
        contact = block.solve(surface, solid, mean_pressure=load, method="full", tolerance=1e-11, **options)
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
