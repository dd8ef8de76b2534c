"""Problems with a closed answer, the orders in which a solver reaches it, and what must not matter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.arrays import Array
from validation.cases import Check
from validation.cases._closed_forms import HertzInPeriod, westergaard_mean_pressure, westergaard_pressure
from validation.cases.scorecard.subject import SOFT, NotTried, Pressed, Subject, rough
from validation.effects.base import Slots
from validation.measures.statistics import order_of_convergence

__all__ = ["hertz", "hertz_radius", "nested", "stress_near_zero", "symmetry", "units", "westergaard"]

#: Where the apex falls in a cell moves the count of one solve by more than the trend; not the mean over
#: these.
_SHIFTS = ((0.0, 0.0), (0.5, 0.5), (0.25, 0.5), (0.25, 0.25))
_WEIGHTS = (1, 1, 2, 4)
_HALF_WIDTH, _AMPLITUDE = 0.3, 0.01


def order(sizes: Sequence[int], errors: Sequence[float]) -> float:
    """Return the order at which errors fall with the spacing; NaN where one is not above zero."""
    if min(errors) <= 0:
        return float("nan")
    return order_of_convergence(1 / np.asarray(sizes), errors)


def _observed(
    subject: Subject, words: str, errors: Sequence[float], *, between: tuple[float, float]
) -> list[Check]:
    """Check an order, where the grids are far enough apart to observe one."""
    if not subject.doubles:
        return []
    return [Check.within(f"observed order of {words}", order(subject.ladder, errors), *between)]


def _needs_order(subject: Subject) -> None:
    if not subject.doubles:
        most = 4 * subject.points
        raise NotTried(
            f"an order is observed up to {most} x {most} points, which would take too long (--seconds)"
        )


def _hertz(subject: Subject) -> HertzInPeriod:
    """Return the paraboloid: on coarse grids a wider one, which is Hertz's up to (a/L)^5."""
    return HertzInPeriod(radius=max(0.15, 2.4 / subject.points))


def hertz(subject: Subject) -> Sequence[Check]:
    """Check that a paraboloid carries Hertz's pressure."""
    errors, peak, exact = [], 0.0, _hertz(subject)
    # A discretisation of second order, with room for the curvature of the edge.
    allowed = 0.01 * max(1.0, (64 / subject.ladder[-1]) ** 2 / 4)
    for n in subject.ladder:
        found = subject.press(exact.surface(n, (0.0, 0.0)), exact.load).claim.pressure
        r = exact.distance(n, (0.0, 0.0))
        # The same points on every grid: what lies nearer to the edge than a coarse cell is another question.
        inside = r < exact.radius - 1.5 / subject.points
        errors.append(float(np.abs(found - exact.pressure(r))[inside].mean()) / exact.peak)
        peak = float(found.max())
    return [
        Check.relative("peak pressure over Hertz's, finest grid", peak / exact.peak, 1.0, allowed),
        Check.below("mean error of p(r) over the peak, finest grid", errors[-1], allowed),
        *_observed(subject, "p(r)", errors, between=(0.5, 3.5)),
    ]


def hertz_radius(subject: Subject) -> Sequence[Check]:
    """Check that the counted contact radius converges to Hertz's in first order."""
    excess, exact = [], _hertz(subject)
    for n in subject.ladder:
        shares = [found.result.in_contact.mean() for found in _shifted(subject, n)]
        counted = float(np.sqrt(np.average(shares, weights=_WEIGHTS) / np.pi))
        excess.append(counted / exact.radius - 1)
    finest = 0.5 / (exact.radius * subject.ladder[-1])
    return [
        *_observed(subject, "the counted radius", excess, between=(0.6, 1.5)),
        Check.below("excess of the counted radius, finest grid", excess[-1], finest),
    ]


def _shifted(subject: Subject, n: int) -> list[Pressed]:
    exact = _hertz(subject)
    return [subject.press(exact.surface(n, shift), exact.load) for shift in _SHIFTS]


def stress_near_zero(subject: Subject) -> Sequence[Check]:
    r"""Check that P(sigma) starts from zero: what a grid puts there vanishes as dx^(1/2).

    With a share F of the area below a pressure eps ~ dx^(1/2), F/eps is of order dx^(1/2) if F = s eps^2 / 2
    + O(dx), and grows if points off the contact carry pressures of rounding size. For a paraboloid s = pi^3
    R^2 / (2 E*^2).
    """
    _needs_order(subject)
    exact, starts, slope = _hertz(subject), [], 0.0
    for n in subject.ladder:
        eps = exact.peak * float(np.sqrt(0.5 / (exact.radius * n)))
        parts = [((p := found.claim.pressure) > 0) & (p < eps) for found in _shifted(subject, n)]
        share = float(np.average([part.mean() for part in parts], weights=_WEIGHTS))
        starts.append(share / eps * exact.contact_modulus)
        slope = 2 * share / eps**2 / (np.pi**3 / 2)
    return [
        *_observed(subject, "P(0+)", starts, between=(0.25, 1.0)),
        Check.within("slope at zero over Hertz's with what the edge adds, finest grid", slope, 0.7, 2.0),
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
        *_observed(subject, "p(x)", errors, between=(0.5, 3.5)),
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
        found = subject.press(scaled, 0.05 * stress, slots=Slots(solid=solid)).claim.pressure / stress
        words = f"change of the pressure, L = {length:g} m, E* = {stress:g} Pa"
        checks.append(Check.below(words, _apart(found, plain), _twice(subject)))
    return checks


def nested(subject: Subject) -> Sequence[Check]:
    """Grids that contain each other approach one answer."""
    _needs_order(subject)
    coarse, middle, fine = (subject.press(rough(n, bandwidth=2), 0.05).claim.pressure for n in subject.ladder)
    steps = _apart(coarse, middle[::2, ::2]), _apart(middle, fine[::2, ::2])
    found = order(subject.ladder[:2], steps)
    return [Check.within("observed order of the pressure from grid to grid", found, 0.5, 3.5)]


def _apart(found: Array, reference: Array) -> float:
    return float(np.linalg.norm(found - reference) / np.linalg.norm(reference))


def _twice(subject: Subject) -> float:
    """Return by how much two answers of the same tolerance may differ."""
    return 2 * subject.pressure_error
