"""A one-dimensional wave at partial contact: Westergaard's pressure, by both solvers."""

from __future__ import annotations

from functools import partial

import numpy as np

from fem_contact import bem, block
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.cases import Case, Check
from validation.cases._closed_forms import westergaard_mean_pressure, westergaard_pressure

__all__ = ["CASES"]

_SOLID = Solid(young=1.0, poisson=0.3)
_HALF_WIDTH, _AMPLITUDE = 0.3, 0.01


def _wave(method: str, n: int, tolerance: float) -> list[Check]:
    x = (np.arange(n) + 0.5) / n - 0.5
    heights = _AMPLITUDE * np.cos(2 * np.pi * x)[:, None] * np.ones(4)
    surface = HeightField(heights=heights, lengths=(1.0, 4 / n))
    modulus = _SOLID.contact_modulus
    load = westergaard_mean_pressure(_AMPLITUDE, half_width=_HALF_WIDTH, contact_modulus=modulus)
    if method == "bem":
        result = bem.solve(surface, HalfSpace(solid=_SOLID), mean_pressure=load).checked()
    else:
        result = block.solve(surface, _SOLID, method="full", mean_pressure=load, growth=1.1).contact.checked()
    exact = westergaard_pressure(x, half_width=_HALF_WIDTH, mean_pressure=load)
    inside = np.abs(x) < 0.9 * _HALF_WIDTH
    worst = np.max(np.abs(result.pressure[:, 1] - exact)[inside]) / exact.max()
    width = np.count_nonzero(result.in_contact[:, 1]) / n
    return [
        Check.relative("peak pressure [Pa]", result.pressure.max(), exact.max(), tolerance),
        Check.below("largest error of p(x) over the peak, inside", worst, tolerance),
        Check.near("contact width", width, 2 * _HALF_WIDTH, 2 / n),
    ]


_SOURCE = "H. M. Westergaard, J. Appl. Mech. 6, 49 (1939)"
CASES = (
    Case(
        name="westergaard-bem",
        claim="Boundary elements give the pressure under a wave within 1 %, and its contact width to a cell.",
        run=partial(_wave, "bem", 256, 0.01),
        source=_SOURCE,
    ),
    Case(
        name="westergaard-fem",
        claim="Finite elements give the pressure under a wave within 1 %, and its contact width to a cell.",
        run=partial(_wave, "fem", 96, 0.01),
        source=_SOURCE,
    ),
)
