r"""A one-dimensional wave that yields at its crests and touches everywhere: Westergaard's solution, mirrored.

With q = H - p the bound p <= H becomes q >= 0, and where the troughs keep some pressure nothing else bounds
it: H - p is the pressure of Westergaard's contact between the trough and its mirror image at the mean
pressure H - p_0, and what has yielded is where that contact is open.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from fem_contact import bem, block
from fem_contact.hardness import yielded
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.cases import Case, Check
from validation.cases._closed_forms import westergaard_mean_pressure, westergaard_pressure

__all__ = ["CASES"]

_SOLID = Solid(young=1.0, poisson=0.3)
#: Half of the width that stays elastic, around a trough, over the period.
_HALF_WIDTH, _AMPLITUDE = 0.3, 0.01


def _wave(method: str, n: int, tolerance: float) -> list[Check]:
    x = (np.arange(n) + 0.5) / n - 0.5
    heights = -_AMPLITUDE * np.cos(2 * np.pi * x)[:, None] * np.ones(4)
    surface = HeightField(heights=heights, lengths=(1.0, 4 / n))
    short = westergaard_mean_pressure(
        _AMPLITUDE, half_width=_HALF_WIDTH, contact_modulus=_SOLID.contact_modulus
    )
    missing = westergaard_pressure(x, half_width=_HALF_WIDTH, mean_pressure=short)
    # Twice what the troughs lack: they stay pressed.
    hardness = 2 * float(missing.max())
    load = hardness - short
    if method == "bem":
        found = bem.solve(surface, HalfSpace(solid=_SOLID), mean_pressure=load, pressure_bound=hardness)
    else:
        found = block.solve(
            surface, _SOLID, method="full", mean_pressure=load, pressure_bound=hardness, growth=1.1
        ).contact
    contact, parts = found.checked(), yielded(found)
    inside = np.abs(x) < 0.9 * _HALF_WIDTH
    worst = np.max(np.abs(hardness - contact.pressure[:, 1] - missing)[inside]) / missing.max()
    width = np.count_nonzero(contact.at_bound[:, 1]) / n
    return [
        Check.relative("lowest pressure [Pa]", contact.pressure.min(), hardness - missing.max(), tolerance),
        Check.below("largest error of p(x) over what the troughs lack, inside", worst, tolerance),
        Check.near("yielded width", width, 1 - 2 * _HALF_WIDTH, 2 / n),
        Check.below("open area", parts.open_area, 1e-12),
    ]


_SOURCE = "H. M. Westergaard, J. Appl. Mech. 6, 49 (1939), mirrored"
CASES = (
    Case(
        name="yielding-wave-bem",
        claim="Boundary elements give the pressure of yielding crests within 1 %, their width to a cell.",
        run=partial(_wave, "bem", 256, 0.01),
        source=_SOURCE,
    ),
    Case(
        name="yielding-wave-fem",
        claim="The active set gives the pressure of yielding crests within 1 %, their width to a cell.",
        run=partial(_wave, "fem", 96, 0.01),
        source=_SOURCE,
    ),
)
