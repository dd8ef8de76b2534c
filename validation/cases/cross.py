"""Full finite elements against boundary elements on one rough surface: two codes, two contact algorithms."""

from __future__ import annotations

import math

import numpy as np

from fem_contact import bem, block
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import random_surface
from persson.spectrum import SelfAffine
from validation.cases import Check, case


def _differences(n: int) -> tuple[float, float]:
    """Relative L2 difference of pressure, and of pixel area, on n x n points."""
    solid = Solid(young=1.0, poisson=0.3)
    spectrum = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=4 * math.pi, q_short=8 * math.pi)
    surface = random_surface(spectrum, q_short=spectrum.q_short, lengths=(1.0, 1.0), shape=(n, n), seed=1618)
    load = 0.1 * solid.contact_modulus * surface.rms_gradient
    fem = block.solve(surface, solid, method="full", mean_pressure=load).contact.checked()
    other = bem.solve(surface, HalfSpace(solid=solid), mean_pressure=load).checked()
    pressure = np.linalg.norm(fem.pressure - other.pressure) / np.linalg.norm(other.pressure)
    return float(pressure), float(fem.in_contact.mean() / other.in_contact.mean() - 1)


@case(
    "fem-against-bem",
    "Full finite elements and boundary elements approach each other as the grid is refined.",
    source="code verification: no shared contact algorithm",
)
def _shrinking() -> list[Check]:
    sizes = (16, 32, 48)
    found = [_differences(n) for n in sizes]
    pressures, areas = ([pair[k] for pair in found] for k in (0, 1))
    name = "order at which the difference in pressure vanishes"
    return [
        # Both err in first order at the edges of contact, with constants that partly cancel on coarse grids.
        Check.order(name, sizes, pressures, expected=1, tolerance=0.5),
        Check.below(f"relative L2 difference of pressure at n = {sizes[-1]}", pressures[-1], 0.06),
        Check.below(f"relative difference in pixel area at n = {sizes[-1]}", areas[-1], 0.06),
        Check.below("difference in area, finest over coarsest grid", abs(areas[-1] / areas[0]), 1.0),
    ]
