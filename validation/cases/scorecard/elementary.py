"""Claims that all others rest on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem_contact.surface import HeightField
from persson import elastic
from validation.arrays import Array, Pair
from validation.cases import Check, Checks, NotJudged, below, case, near, relative
from validation.cases._closed_forms import periodic
from validation.cases.scorecard.subject import SOFT, Pressed, Subject, rough
from validation.effects.base import ContactModel

Wave = tuple[int, int, float, float]
#: Waves of the full contact, and their amplitudes and phases: no symmetry is left.
WAVES: tuple[Wave, ...] = ((1, 0, 1.0, 0.3), (0, 1, 0.8, 1.1), (1, 1, 0.5, 2.0), (2, 1, 0.3, 0.7))
#: Largest difference, in cells, of a wave's place from where the two longest put it.
_SAME_PLACE = 0.05
#: Load of the full contact over the one that presses them flat: so does a solver three times as stiff.
_FLATTENING = 4.0
#: Middling, light and very light loads p*, for a surface of unit gradient and E* = 1.
LOADS = (0.05, 0.005, 1e-5)


@dataclass(frozen=True, kw_only=True, eq=False)
class Transfer:
    """p-hat(q) over h-hat(q) / C(q) at full contact: 1, if the compliance is that of the solid."""

    ratio: NDArray[np.complex128]  # Of each wave
    allowed: Array  # Error of a discretisation of second order, (q dx)^2 / 4, of each wave
    exact: Array  # The pressure that is right
    pressed: Pressed

    @property
    def shift(self) -> Pair | None:
        """Cells by which the pressure lies beside the heights, along x and y; None where waves disagree."""
        angles = np.angle(self.ratio) / (2 * np.pi / len(self.exact))
        shift = (-float(angles[0]), -float(angles[1]))
        agree = [
            abs(angle + kx * shift[0] + ky * shift[1]) < 2 * _SAME_PLACE
            for (kx, ky, *_), angle in zip(WAVES, angles, strict=True)
        ]
        return shift if all(agree) else None

    @property
    def factor(self) -> float | None:
        """Stiffness over that of the solid; None where waves disagree."""
        sizes = np.abs(self.ratio)
        mean = sizes[:2].mean()
        return mean if bool(np.all(np.abs(sizes / mean - 1) <= 2 * self.allowed)) else None


def full_contact_transfer(
    subject: Subject, *, model: ContactModel | None = None, waves: Sequence[Wave] = WAVES
) -> Transfer:
    """Press all of some waves flat on the half-space, or on the solid of the model."""
    n = 2 * subject.points
    x = np.arange(n) / n
    response = (model or ContactModel(solid=SOFT)).felt_response
    heights, linear, sizes = np.zeros((n, n)), np.zeros((n, n)), []
    for kx, ky, amplitude, phase in waves:
        wave = 1e-3 * amplitude * np.cos(2 * np.pi * (kx * x[:, None] + ky * x[None, :]) + phase)
        soft = float(response.compliance(*(np.array([2.0 * np.pi * k]) for k in (kx, ky)))[0])
        heights, linear = heights + wave, linear + wave / soft
        sizes.append(2 * np.pi * np.hypot(kx, ky))
    surface, load = periodic(heights), -_FLATTENING * linear.min()
    pressed = subject.press(surface, load, model=model)
    over = np.fft.fft2(pressed.pressure), np.fft.fft2(linear)
    ratio = np.array([over[0][kx, ky] / over[1][kx, ky] for kx, ky, *_ in waves])
    allowed = (np.array(sizes) / n) ** 2 / 4
    return Transfer(ratio=ratio, allowed=allowed, exact=load + linear, pressed=pressed)


def solves(subject: Subject) -> list[tuple[HeightField, float, Pressed]]:
    """Return one rough surface at three loads."""
    surface = subject.rough
    return [(surface, load, subject.press(surface, load)) for load in LOADS]


@case("tension", source="definition", tolerance="solver")
def tension(subject: Subject) -> Checks:
    """No pressure is below zero."""
    lowest = min(pressed.pressure.min() for _, _, pressed in solves(subject))
    yield below("lowest pressure over E* h'_rms", min(lowest, 0.0), 10 * subject.tolerance)


@case("repeatable", source="definition", tolerance="solver")
def repeatable(subject: Subject) -> Checks:
    """The same question has the same answer."""
    surface = subject.rough
    first = subject.press(surface, LOADS[0]).pressure
    subject.press(surface, LOADS[-1])
    again = subject.press(surface, LOADS[0], again=True).pressure
    apart = np.linalg.norm(again - first) / (np.linalg.norm(first) or 1.0)
    yield below("change of the pressure when it is asked again", apart, subject.tolerance)


@case("full-contact", source="exact", tolerance="grid")
def full_contact(subject: Subject) -> Checks:
    """Each wave is pressed flat by E* q h / 2."""
    transfer = full_contact_transfer(subject)
    result = transfer.pressed.result
    surface = HeightField(heights=result.heights, lengths=result.lengths)
    variance = elastic.stress_variance(surface.moments[1], contact_modulus=SOFT.contact_modulus)
    exact = subject.built_in and subject.solver.score_element == "bem"
    yield from wave_errors(transfer, exact=exact)
    yield relative("A/A0", np.mean(transfer.pressed.pressure > 0), 1.0, 0.0)
    allowed = 1e-9 if exact else 2 * transfer.allowed.max()
    computed = np.var(transfer.pressed.pressure) / variance
    yield relative("<(p - p0)^2> over E*^2 m2 / 4", computed, 1.0, allowed)


def wave_errors(transfer: Transfer, *, exact: bool = False) -> Checks:
    """Check the pressure of every wave: to the error of second order, or exactly."""
    for (kx, ky, *_), ratio, allowed in zip(WAVES, transfer.ratio, transfer.allowed, strict=True):
        name = f"error of the pressure of the wave ({kx}, {ky})"
        yield below(name, abs(ratio - 1), 1e-9 if exact else allowed)


@case("load", source="definition", tolerance="solver")
def load(subject: Subject) -> Checks:
    """The mean pressure is the one asked for."""
    for _, p, pressed in solves(subject):
        share = pressed.pressure.mean() / p
        yield relative(f"mean pressure over p0 at p* = {p:g}", share, 1.0, 10 * subject.tolerance)


@case("contact-set", source="definition", tolerance="solver")
def contact_set(subject: Subject) -> Checks:
    """What is called contact carries load on a closed gap.

    Compare what is called contact with what carries load; who names none is read by p > 0.
    """
    checks: list[Check] = []
    for _, p, pressed in solves(subject):
        named = pressed.claim.in_contact
        words = "points with p > 0" if named is None else "points called contact"
        counted = np.count_nonzero(pressed.pressure > 0 if named is None else named)
        touching = np.count_nonzero(pressed.result.in_contact)
        if touching == 0:
            raise NotJudged("no point carries load on a closed gap: it is not solved")
        # A point at an edge, whose pressure and gap are both within the tolerance, may be either.
        allowed = 0.02 + 2 / touching
        checks.append(near(f"{words} over points that touch, p* = {p:g}", counted / touching, 1.0, allowed))
    return judge_residuals(subject, checks)


@case("honesty", source="definition", tolerance="solver")
def honesty(subject: Subject) -> Checks:
    """Recomputed residuals are within the tolerance asked for."""
    checks: list[Check] = []
    for _, p, pressed in solves(subject):
        residuals = pressed.result.residuals
        checks.append(below(f"complementarity, p* = {p:g}", residuals.complementarity, subject.tolerance))
        words = f"penetration over h_rms, p* = {p:g}"
        checks.append(below(words, residuals.penetration, 10 * subject.tolerance))
    return judge_residuals(subject, checks)


def residuals_fall(subject: Subject) -> bool:
    """Whether the residual falls where a hundredth of the tolerance is asked for."""
    surface = subject.rough
    sharper = subject.press(surface, LOADS[0], more={"tolerance": subject.tolerance / 100})
    plain = subject.press(surface, LOADS[0])
    return sharper.result.residuals.complementarity < 0.5 * plain.result.residuals.complementarity


def judge_residuals(subject: Subject, checks: Sequence[Check]) -> Checks:
    """Return checks of residuals, unless they are missed for being those of another discretisation.

    Its own equations may be met to any tolerance; those of the half-space at the grid points are not, by
    the error of its cells: waves are right but for the grid, a smaller tolerance changes nothing, and a
    finer grid lessens the residuals: a NotJudged.
    """
    if all(check.passed for check in checks):
        return checks
    transfer = full_contact_transfer(subject)
    off = np.abs(transfer.ratio - 1)
    if np.any(off > transfer.allowed) or off.max() < subject.pressure_error or residuals_fall(subject):
        return checks
    coarse, fine = (
        subject.press(rough(n), LOADS[0]).result.residuals.complementarity
        for n in (2 * subject.points, 4 * subject.points)
    )
    if fine < 0.8 * coarse:
        raise NotJudged(
            "residuals are those of another discretisation: a hundredth of the tolerance changes nothing, a "
            f"finer grid makes {fine:.2g} of {coarse:.2g}"
        )
    return checks
