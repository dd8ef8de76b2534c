"""A paraboloid: peak pressure, profile, approach, and the order at which the contact radius converges."""

from __future__ import annotations

from functools import partial

import numpy as np

from fem_contact import bem, block
from fem_contact.area import contact_areas
from fem_contact.contact import ContactResult
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from validation.cases import Case, Check
from validation.cases._closed_forms import HertzInPeriod

__all__ = ["CASES"]

_SOLID = Solid(young=1.0, poisson=0.3)
_SOURCE = "H. Hertz, J. reine angew. Math. 92, 156 (1882); K. L. Johnson, Contact Mechanics, Sec. 4.2"
#: Where the apex falls in a cell moves the count of one solve by more than the trend; not the mean over
#: these.
_SHIFTS = ((0.0, 0.0), (0.5, 0.5), (0.25, 0.5), (0.25, 0.25))
_WEIGHTS = (1, 1, 2, 4)


def _press(method: str, case: HertzInPeriod, n: int, shift: tuple[float, float]) -> ContactResult:
    surface = case.surface(n, shift)
    if method == "bem":
        return bem.solve(surface, HalfSpace(solid=_SOLID), mean_pressure=case.load).checked()
    return block.solve(surface, _SOLID, method="full", mean_pressure=case.load).contact.checked()


def _pressure(method: str, n: int, radius: float) -> list[Check]:
    case = HertzInPeriod(radius=radius, contact_modulus=_SOLID.contact_modulus)
    shift = (0.0, 0.0)
    result, r = _press(method, case, n, shift), case.distance(n, shift)
    inside = r < radius - 1.5 / n
    worst = np.max(np.abs(result.pressure - case.pressure(r))[inside]) / case.peak
    checks = [
        Check.relative("peak pressure [Pa]", result.pressure.max(), case.peak, 0.01),
        Check.below("largest error of p(r) over the peak, inside", worst, 0.01),
    ]
    if method == "bem":
        checks.append(Check.relative("approach", -result.offset, case.approach, 0.01))
    return checks


def _radius(method: str, sizes: tuple[int, ...], radius: float) -> list[Check]:
    case = HertzInPeriod(radius=radius, contact_modulus=_SOLID.contact_modulus)
    excess, corrected = [], []
    for n in sizes:
        areas = [contact_areas(_press(method, case, n, shift)) for shift in _SHIFTS]
        pixel = np.average([area.pixel for area in areas], weights=_WEIGHTS)
        perimeter = np.average([area.perimeter for area in areas], weights=_WEIGHTS)
        excess.append(float(np.sqrt(pixel / np.pi)) / radius - 1)
        corrected.append(float(np.sqrt(perimeter / np.pi)) / radius - 1)
    return [
        Check.order("observed order of the counted radius", sizes, excess, expected=1, tolerance=0.4),
        Check.below(
            f"excess of the counted radius at n = {sizes[-1]}", excess[-1], 0.5 / (radius * sizes[-1])
        ),
        # A quarter of a cell is what a count can be off; the correction must take most of that away.
        Check.below(
            f"error of the corrected radius at n = {sizes[-1]}", corrected[-1], 0.15 / (radius * sizes[-1])
        ),
    ]


CASES = (
    Case(
        name="hertz-bem",
        claim="Boundary elements give Hertz's peak, profile and approach within 1 %.",
        run=partial(_pressure, "bem", 192, 0.1),
        source=_SOURCE,
    ),
    Case(
        name="hertz-fem",
        claim="The full finite-element system gives Hertz's peak and profile within 1 %.",
        run=partial(_pressure, "fem", 32, 5 / 32),
        source=_SOURCE,
    ),
    Case(
        name="hertz-radius-bem",
        claim="The radius counted by boundary elements converges to Hertz's in first order.",
        run=partial(_radius, "bem", (48, 96, 192), 0.1),
        source=_SOURCE,
    ),
    Case(
        name="hertz-radius-fem",
        claim="The radius counted by finite elements converges to Hertz's in first order.",
        run=partial(_radius, "fem", (16, 32, 48), 5 / 32),
        source=_SOURCE,
        quick=False,
    ),
)
