"""Problems with a closed answer, the orders in which a solver reaches it, and what must not matter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.cases import Check
from validation.cases._closed_forms import HertzInPeriod, westergaard_mean_pressure, westergaard_pressure
from validation.cases.scorecard.subject import SOFT, Subject, rough

__all__ = ["hertz", "hertz_radius", "nested", "symmetry", "units", "westergaard"]

Array = NDArray[np.float64]

_HERTZ = HertzInPeriod(radius=0.15)
#: Where the apex falls in a cell moves the count of one solve by more than the trend; not the mean over
#: these.
_SHIFTS = ((0.0, 0.0), (0.5, 0.5), (0.25, 0.5), (0.25, 0.25))
_WEIGHTS = (1, 1, 2, 4)
_HALF_WIDTH, _AMPLITUDE = 0.3, 0.01


def order(sizes: Sequence[int], errors: Sequence[float]) -> float:
    """Return the order at which errors fall with the spacing; NaN where one is not above zero."""
    if min(errors) <= 0:
        return float("nan")
    return -float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def hertz(subject: Subject) -> Sequence[Check]:
    """Check that a paraboloid carries Hertz's pressure."""
    errors, peak = [], 0.0
    for n in subject.ladder:
        found = subject.press(_HERTZ.surface(n, (0.0, 0.0)), _HERTZ.load).claim.pressure
        r = _HERTZ.distance(n, (0.0, 0.0))
        # The same points on every grid: what lies nearer to the edge than a coarse cell is another question.
        inside = r < _HERTZ.radius - 1.5 / subject.points
        errors.append(float(np.abs(found - _HERTZ.pressure(r))[inside].mean()) / _HERTZ.peak)
        peak = float(found.max())
    return [
        Check.relative("peak pressure over Hertz's, finest grid", peak / _HERTZ.peak, 1.0, 0.01),
        Check.below("mean error of p(r) over the peak, finest grid", errors[-1], 0.01),
        Check.within("observed order of p(r)", order(subject.ladder, errors), 0.5, 3.5),
    ]


def hertz_radius(subject: Subject) -> Sequence[Check]:
    """Check that the counted contact radius converges to Hertz's in first order."""
    excess = []
    for n in subject.ladder:
        shares = [
            subject.press(_HERTZ.surface(n, shift), _HERTZ.load).result.in_contact.mean() for shift in _SHIFTS
        ]
        counted = float(np.sqrt(np.average(shares, weights=_WEIGHTS) / np.pi))
        excess.append(counted / _HERTZ.radius - 1)
    finest = 0.5 / (_HERTZ.radius * subject.ladder[-1])
    return [
        Check.within("observed order of the counted radius", order(subject.ladder, excess), 0.6, 1.5),
        Check.below("excess of the counted radius, finest grid", excess[-1], finest),
    ]


def strip(subject: Subject, n: int, *, across: tuple[int, float], axis: int) -> tuple[Array, Array]:
    """Press a wave whose crest is in the middle, uniform along the other axis; return x and p(x)."""
    x = (np.arange(n) + 0.5) / n - 0.5
    points, length = across
    heights = _AMPLITUDE * np.cos(2 * np.pi * x)[:, None] * np.ones(points)
    surface = HeightField(heights=np.ascontiguousarray(heights), lengths=(1.0, length))
    if axis == 1:
        surface = HeightField(heights=np.ascontiguousarray(heights.T), lengths=(length, 1.0))
    mean = westergaard_mean_pressure(_AMPLITUDE, half_width=_HALF_WIDTH)
    found = subject.press(surface, mean).claim.pressure
    return x, (found if axis == 0 else found.T)[:, 1]


def strip_error(x: Array, pressure: Array) -> float:
    """Return the mean error of p(x) over the peak, away from the edge."""
    mean = westergaard_mean_pressure(_AMPLITUDE, half_width=_HALF_WIDTH)
    exact = westergaard_pressure(x, half_width=_HALF_WIDTH, mean_pressure=mean)
    inside = np.abs(x) < 0.8 * _HALF_WIDTH
    return float(np.abs(pressure - exact)[inside].mean() / exact.max())


def westergaard(subject: Subject) -> Sequence[Check]:
    """Check that a wave carries Westergaard's pressure."""
    errors = [strip_error(*strip(subject, n, across=(4, 4 / n), axis=0)) for n in subject.ladder]
    return [
        Check.below("mean error of p(x) over the peak, finest grid", errors[-1], 0.01),
        Check.within("observed order of p(x)", order(subject.ladder, errors), 0.5, 3.5),
    ]


def symmetry(subject: Subject) -> Sequence[Check]:
    """Pressing the mirrored or transposed surface mirrors or transposes the pressure."""
    surface = rough(2 * subject.points)
    plain = subject.press(surface, 0.05).claim.pressure
    checks = []
    for words, turn in (("mirrored in x", lambda a: a[::-1]), ("transposed", np.transpose)):
        other = HeightField(heights=np.ascontiguousarray(turn(surface.heights)), lengths=surface.lengths)
        found = turn(subject.press(other, 0.05).claim.pressure)
        checks.append(Check.below(f"change of the pressure, {words}", _apart(found, plain), _twice(subject)))
    return checks


def units(subject: Subject) -> Sequence[Check]:
    """Neither the unit of length nor that of pressure changes the answer."""
    surface = rough(2 * subject.points)
    plain = subject.press(surface, 0.05).claim.pressure
    checks = []
    for length, stress in ((1e-9, 2e11), (1e6, 1e-9)):
        scaled = HeightField(heights=surface.heights * length, lengths=(length, length))
        solid = Solid(young=stress, poisson=SOFT.poisson)
        found = subject.press(scaled, 0.05 * stress, solid=solid).claim.pressure / stress
        words = f"change of the pressure, L = {length:g} m, E* = {stress:g} Pa"
        checks.append(Check.below(words, _apart(found, plain), _twice(subject)))
    return checks


def nested(subject: Subject) -> Sequence[Check]:
    """Grids that contain each other approach one answer."""
    coarse, middle, fine = (subject.press(rough(n, bandwidth=2), 0.05).claim.pressure for n in subject.ladder)
    steps = _apart(coarse, middle[::2, ::2]), _apart(middle, fine[::2, ::2])
    found = order(subject.ladder[:2], steps)
    return [Check.within("observed order of the pressure from grid to grid", found, 0.5, 3.5)]


def _apart(found: Array, reference: Array) -> float:
    return float(np.linalg.norm(found - reference) / np.linalg.norm(reference))


def _twice(subject: Subject) -> float:
    """Return by how much two answers of the same tolerance may differ."""
    return 2 * subject.pressure_error
