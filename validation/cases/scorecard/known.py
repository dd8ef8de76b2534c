"""Problems with a closed answer, the orders in which a solver reaches it, and what must not matter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fem_contact import bem
from fem_contact.area import contact_areas
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.arrays import Array
from validation.cases import Checks, NotJudged, below, case, near, order, relative, within
from validation.cases._closed_forms import HertzInPeriod, Westergaard, places
from validation.cases.scorecard.elementary import full_contact_transfer, wave_errors
from validation.cases.scorecard.subject import SOFT, Pressed, Subject, rough
from validation.effects.base import ContactModel
from validation.effects.hardness import Hardness
from validation.effects.thickness import Thickness
from validation.measurements.statistics import relative_distance
from validation.solvers.bem import Bem

_HERTZ = "[hertz1882]; [johnson_book], Sec. 4.2"
_WESTERGAARD = "[westergaard1939]"

#: Where the apex falls in a cell moves the count of one solve by more than the trend; not the mean over
#: these.
_SHIFTS = ((0.0, 0.0), (0.5, 0.5), (0.25, 0.5), (0.25, 0.25))
_WEIGHTS = (1, 1, 2, 4)
_WAVE = Westergaard()
_THICKNESS = 0.25


def _observed(
    subject: Subject, quantity: str, errors: Sequence[float], *, expected: float, tolerance: float
) -> Checks:
    """Check an order, where the grids are far enough apart to observe one."""
    if subject.doubles:
        sizes = subject.ladder[: len(errors)]
        yield order(f"observed order of {quantity}", sizes, errors, expected=expected, tolerance=tolerance)


def _needs_order(subject: Subject) -> None:
    if not subject.doubles:
        most = 4 * subject.points
        raise NotJudged(
            f"not tried: an order is observed up to {most} x {most} points, which would take too long "
            "(--seconds)"
        )


def _hertz(subject: Subject) -> HertzInPeriod:
    """Return the paraboloid: on coarse grids a wider one, which is Hertz's up to (a/L)^5."""
    return HertzInPeriod(radius=max(0.15, 2.4 / subject.points))


@case("hertz", source=_HERTZ, tolerance="grid")
def hertz(subject: Subject) -> Checks:
    """A paraboloid carries Hertz's pressure."""
    errors, worst, exact = [], 0.0, _hertz(subject)
    for n in subject.ladder:
        pressed = subject.press(exact.surface(n), exact.load)
        r = exact.distance(n)
        # The same points on every grid: what lies nearer to the edge than a coarse cell is another question.
        inside = r < exact.radius - 1.5 / subject.points
        off = np.abs(pressed.pressure - exact.pressure(r)) / exact.peak
        errors.append(off[inside].mean())
        worst = off[r < exact.radius - 1.5 / n].max()
    # Of a discretisation of second order, (dx/a)^2 / 2.
    allowed = 0.5 / (exact.radius * subject.ladder[-1]) ** 2
    # A clamped body is pressed together, besides.
    approach = -(pressed.result.offset + pressed.result.displacement.mean())
    peak = pressed.pressure.max() / exact.peak
    yield relative("peak pressure over Hertz's, finest grid", peak, 1.0, allowed)
    yield below("mean error of p(r) over the peak, finest grid", errors[-1], allowed)
    yield below("largest error of p(r) over the peak, finest grid", worst, 0.01)
    yield relative("approach over Hertz's, finest grid", approach / exact.approach, 1.0, 0.01)
    yield from _observed(subject, "p(r)", errors, expected=2, tolerance=1)


@case("hertz-radius", source=_HERTZ, tolerance="grid")
def hertz_radius(subject: Subject) -> Checks:
    """The counted radius converges to Hertz's in first order."""
    excess, exact = [], _hertz(subject)
    for n in subject.ladder:
        results = [pressed.result for pressed in _shifted(subject, n)]
        areas = [contact_areas(one, edge_constant=subject.solver.edge_constant(one)) for one in results]
        both = [[area.pixel, area.perimeter] for area in areas]
        radii = np.sqrt(np.average(both, axis=0, weights=_WEIGHTS) / np.pi)
        pixel, corrected = (radii / exact.radius - 1).tolist()
        excess.append(pixel)
    cell = 1 / (exact.radius * subject.ladder[-1])
    yield from _observed(subject, "the counted radius", excess, expected=1, tolerance=0.4)
    yield below("excess of the counted radius, finest grid", excess[-1], 0.5 * cell)
    # A quarter of a cell is what a count can be off; the correction must take most of that away.
    yield below("error of the corrected radius, finest grid", corrected, 0.15 * cell)


def _shifted(subject: Subject, n: int) -> list[Pressed]:
    exact = _hertz(subject)
    return [subject.press(exact.surface(n, shift), exact.load) for shift in _SHIFTS]


@case("stress-near-zero", source=_HERTZ, tolerance="grid")
def stress_near_zero(subject: Subject) -> Checks:
    r"""P(sigma) starts from zero, but for the grid.

    What a grid puts there vanishes as dx^(1/2). With a share F of the area below a pressure eps ~ dx^(1/2),
    F/eps is of order dx^(1/2) if F = s eps^2 / 2 + O(dx), and grows if points off the contact carry pressures
    of rounding size. For a paraboloid s = pi^3 R^2 / (2 E*^2).
    """
    _needs_order(subject)
    exact, starts, slope = _hertz(subject), [], 0.0
    for n in subject.ladder:
        eps = exact.peak * np.sqrt(0.5 / (exact.radius * n))
        parts = [((p := pressed.pressure) > 0) & (p < eps) for pressed in _shifted(subject, n)]
        share = np.average([part.mean() for part in parts], weights=_WEIGHTS)
        starts.append(share / eps * exact.contact_modulus)
        slope = 2 * share / eps**2 / (np.pi**3 / 2)
    yield from _observed(subject, "P(0+)", starts, expected=0.5, tolerance=0.25)
    yield within("slope at zero over Hertz's with what the edge adds, finest grid", slope, 0.7, 2.0)


def strip(
    subject: Subject, n: int, *, across: tuple[int, float] | None = None, axis: int = 0
) -> tuple[Array, Array, Pressed]:
    """Press a wave with its crest in the middle, uniform along the other axis: p(x), its error, and all."""
    surface, x = _WAVE.surface(n, across), places(n)
    if axis == 1:
        surface = HeightField(heights=np.ascontiguousarray(surface.heights.T), lengths=surface.lengths[::-1])
    pressed, exact = subject.press(surface, _WAVE.load), _WAVE.pressure(x)
    pressure = (pressed.pressure if axis == 0 else pressed.pressure.T)[:, 1]
    return pressure / exact.max(), np.abs(pressure - exact) / exact.max(), pressed


def mean_inside(off: Array) -> float:
    """Return the mean error away from the edge."""
    return float(off[_within(off.size, 0.8)].mean())


def _within(n: int, share: float) -> NDArray[np.bool_]:
    """Points of a wave in the middle of what touches, or stays elastic."""
    return np.abs(places(n)) < share * _WAVE.half_width


def _second_order(n: int) -> float:
    """Share of the peak by which a discretisation of second order may miss the pressure of a wave."""
    return 1 / (_WAVE.half_width * n) ** 2


@case("westergaard", source=_WESTERGAARD, tolerance="grid")
def westergaard(subject: Subject) -> Checks:
    """A wave carries Westergaard's pressure."""
    strips = [strip(subject, n) for n in subject.ladder]
    errors = [mean_inside(off) for _, off, _ in strips]
    (pressure, off, pressed), n = strips[-1], subject.ladder[-1]
    allowed = _second_order(n)
    yield relative("peak pressure over Westergaard's, finest grid", pressure.max(), 1.0, allowed)
    yield below("mean error of p(x) over the peak, finest grid", errors[-1], allowed)
    yield below("largest error of p(x) over the peak, finest grid", off[_within(n, 0.9)].max(), 0.01)
    yield near("contact width", pressed.result.in_contact.mean(), 2 * _WAVE.half_width, 2 / n)
    yield from _observed(subject, "p(x)", errors, expected=2, tolerance=1)


@case("layer", source="[johnson_book], Sec. 5.8", tolerance="grid")
def layer(subject: Subject) -> Checks:
    """On a bonded layer each wave is pressed flat by h / C(q)."""
    subject.needs(effect=Thickness)
    model = ContactModel.filled(SOFT, [Thickness(thickness=_THICKNESS)])
    return wave_errors(full_contact_transfer(subject, model=model))


@case("yielding-wave", source=f"{_WESTERGAARD}, mirrored", tolerance="grid")
def yielding(subject: Subject) -> Checks:
    """Crests yield over the width that Westergaard's solution says."""
    subject.needs(effect=Hardness)
    n = 2 * subject.ladder[-1]
    wave = _WAVE.surface(n)
    surface = HeightField(heights=-wave.heights, lengths=wave.lengths)
    missing = _WAVE.pressure(places(n))
    # Twice what the troughs lack: they stay pressed.
    peak, hardness = missing.max(), 2 * missing.max()
    model = ContactModel.filled(SOFT, [Hardness(hardness=hardness)])
    pressed = subject.press(surface, hardness - _WAVE.load, model=model)
    pressure = pressed.pressure
    off = (np.abs(hardness - pressure[:, 1] - missing) / peak)[_within(n, 0.9)]
    above = max(pressure.max() / hardness - 1, 0.0)
    yield relative("lowest pressure over H", pressure.min() / hardness, 0.5, _second_order(n))
    yield below("mean error of H - p(x) over its peak, inside", off.mean(), _second_order(n))
    yield below("largest error of H - p(x) over its peak, inside", off.max(), 0.01)
    yield near("yielded width", pressed.result.at_bound.mean(), 1 - 2 * _WAVE.half_width, 2 / n)
    yield below("open area", np.mean(~(pressure > 0)), 0.0)
    yield below("largest pressure above H, over H", above, 10 * subject.tolerance)


@case("symmetry", source="symmetry", tolerance="solver")
def symmetry(subject: Subject) -> Checks:
    """A mirrored surface has the mirrored pressure."""
    surface = subject.rough
    # Our own are solved far enough that nothing but rounding is left between the two.
    more, allowed = ({"tolerance": 1e-11}, 1e-8) if subject.built_in else (None, _solver_error(subject))
    plain = subject.press(surface, 0.05, more=more).pressure
    for words, turn, back in (
        ("mirrored in x", np.flipud, np.flipud),
        ("transposed", np.transpose, np.transpose),
        ("turned by 90 degrees", np.rot90, lambda a: np.rot90(a, -1)),
        (
            "moved by (7, 3) points",
            lambda a: np.roll(a, (7, 3), (0, 1)),
            lambda a: np.roll(a, (-7, -3), (0, 1)),
        ),
    ):
        other = HeightField(heights=np.ascontiguousarray(turn(surface.heights)), lengths=surface.lengths)
        turned = back(subject.press(other, 0.05, more=more).pressure)
        yield below(f"change of the pressure, {words}", relative_distance(turned, plain), allowed)


@case("units", source="symmetry", tolerance="solver")
def units(subject: Subject) -> Checks:
    """Units of length and pressure change nothing."""
    surface = subject.rough
    plain = subject.press(surface, 0.05)
    for length, stress in ((1e-9, 2e11), (1e6, 1e-9), (2.0**20, 2.0**-30)):
        scaled = HeightField(heights=surface.heights * length, lengths=(length, length))
        model = ContactModel(solid=Solid(young=stress, poisson=SOFT.poisson))
        pressed = subject.press(scaled, 0.05 * stress, model=model)
        words = f"change of the pressure, L = {length:g} m, E* = {stress:g} Pa"
        exact = subject.built_in and length == 2.0**20
        apart = relative_distance(pressed.pressure / stress, plain.pressure)
        yield below(words, apart, 0.0 if exact else _solver_error(subject))
        if exact:
            gap = np.count_nonzero(pressed.result.gap / length != plain.result.gap)
            other = pressed.result.residuals != plain.result.residuals
            yield below("points whose gap differs", gap, 0)
            yield below("residuals that differ", other, 0)


@case("nested-grids", source="self-consistency", tolerance="grid")
def nested(subject: Subject) -> Checks:
    """Finer and finer grids approach one answer."""
    _needs_order(subject)
    coarse, middle, fine = (subject.press(rough(n, bandwidth=2), 0.05) for n in subject.ladder)
    p = [pressed.pressure for pressed in (coarse, middle, fine)]
    steps = relative_distance(p[0], p[1][::2, ::2]), relative_distance(p[1], p[2][::2, ::2])
    gaps = fine.result.mean_gap / middle.result.mean_gap - 1
    # At an edge p grows like the square root of the distance: the cells there leave an error of order 1.
    yield from _observed(subject, "the pressure from grid to grid", steps, expected=1, tolerance=0.7)
    # A grid of second order may miss the mean gap by (q_short dx)^2 / 4, of the middle grid.
    yield below("change of the mean gap to the finest grid", gaps, (8 * np.pi / subject.ladder[1]) ** 2 / 4)


@case("against-bem", source="code verification: no shared contact algorithm", tolerance="grid")
def against_bem(subject: Subject) -> Checks:
    """Pressures approach those of boundary elements as the grid is refined."""
    if type(subject.solver) is Bem:
        raise NotJudged("they are boundary elements")
    differences, areas = [], []
    for n in subject.ladder:
        surface = rough(n, bandwidth=2)
        pressed = subject.press(surface, 0.05)
        other = bem.solve(surface, HalfSpace(solid=SOFT), mean_pressure=0.05).checked()
        differences.append(relative_distance(pressed.pressure, other.pressure))
        areas.append(float(pressed.result.in_contact.mean() / other.in_contact.mean() - 1))
    # Both err in first order at the edges of contact, with constants that partly cancel on coarse grids.
    edge = 4 / subject.ladder[-1]
    yield below("relative L2 difference of pressure, finest grid", differences[-1], edge)
    if subject.doubles:  # counts on a few points are further apart
        yield below("relative difference in counted area, finest grid", areas[-1], edge)
    if differences[0] >= _solver_error(subject):  # else it has no order
        words = "the difference to boundary elements"
        yield from _observed(subject, words, differences, expected=1, tolerance=0.6)


def _solver_error(subject: Subject) -> float:
    """Return by how much two answers of the same tolerance may differ."""
    return 2 * subject.pressure_error
