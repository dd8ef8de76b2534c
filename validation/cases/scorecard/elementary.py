"""Claims that all others rest on; each names the fault of a solver that fails it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem_contact.surface import HeightField
from validation.arrays import Array
from validation.cases import Check
from validation.cases.scorecard.subject import SOFT, Inconclusive, Pressed, Subject, rough
from validation.effects.base import Slots

__all__ = [
    "WAVES",
    "contact_set",
    "factor",
    "full_contact",
    "full_contact_transfer",
    "honesty",
    "load",
    "place",
    "tension",
]

#: Waves of the full contact, and their amplitudes and phases: no symmetry is left.
WAVES = ((1, 0, 1.0, 0.3), (0, 1, 0.8, 1.1), (1, 1, 0.5, 2.0), (2, 1, 0.3, 0.7))
#: Largest difference, in cells, of a wave's place from where the two longest put it.
_SAME_PLACE = 0.05
#: Very light, light and middling loads p*, for a surface of unit gradient and E* = 1.
_LOADS = (1e-5, 0.005, 0.05)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Transfer:
    """p-hat(q) over h-hat(q) / C(q) at full contact: 1, if the compliance is that of the solid.

    Attributes
    ----------
    ratio : (waves,) array, complex
    allowed : (waves,) array
        Error of a discretisation of second order, (q dx)^2 / 4.
    points : int
    """

    ratio: NDArray[np.complex128]
    allowed: Array
    points: int

    @property
    def shift(self) -> tuple[float, float]:
        """Cells by which the pressure lies beside the heights, along x and y."""
        angles = np.angle(self.ratio) / (2 * np.pi / self.points)
        shift = (-float(angles[0]), -float(angles[1]))
        for (kx, ky, *_), angle in zip(WAVES, angles, strict=True):
            if not abs(angle + kx * shift[0] + ky * shift[1]) < 2 * _SAME_PLACE:
                raise Inconclusive("waves of the full contact lie in different places: it is not solved")
        return shift


def full_contact_transfer(subject: Subject, *, slots: Slots | None = None) -> _Transfer:
    """Press all of `WAVES` flat on the half-space, or on the solid of the slots."""
    n = 2 * subject.points
    x = np.arange(n) / n
    response = (slots or Slots(solid=SOFT)).felt_response
    heights, linear, sizes = np.zeros((n, n)), np.zeros((n, n)), []
    for kx, ky, amplitude, phase in WAVES:
        wave = amplitude * np.cos(2 * np.pi * (kx * x[:, None] + ky * x[None, :]) + phase)
        size = 2 * np.pi * float(np.hypot(kx, ky))
        soft = float(response.compliance(*(np.array([2.0 * np.pi * k]) for k in (kx, ky)))[0])
        heights, linear = heights + 1e-3 * wave, linear + 1e-3 / soft * wave
        sizes.append(size)
    surface = HeightField(heights=heights, lengths=(1.0, 1.0))
    found = subject.press(surface, -1.2 * float(linear.min()), slots=slots).claim.pressure
    over = np.fft.fft2(found), np.fft.fft2(linear)
    ratio = np.array([over[0][kx, ky] / over[1][kx, ky] for kx, ky, *_ in WAVES])
    return _Transfer(ratio=ratio, allowed=(np.array(sizes) / n) ** 2 / 4, points=n)


def _solves(subject: Subject) -> list[tuple[HeightField, float, Pressed]]:
    surface = rough(2 * subject.points)
    return [(surface, load, subject.press(surface, load)) for load in _LOADS]


def tension(subject: Subject) -> Sequence[Check]:
    """Check that no pressure is below zero."""
    lowest = min(float(pressed.claim.pressure.min()) for _, _, pressed in _solves(subject))
    return [Check.below("lowest pressure over E* h'_rms", min(lowest, 0.0), 10 * subject.tolerance)]


def place(subject: Subject) -> Sequence[Check]:
    """Check that the pressure lies where the heights are."""
    shift = full_contact_transfer(subject).shift
    return [
        Check.below(f"pressure beside the heights along {axis} [cells]", value, _SAME_PLACE)
        for axis, value in zip("xy", shift, strict=True)
    ]


def factor(subject: Subject) -> Sequence[Check]:
    """Check that the stiffness of the longest waves is that of E*."""
    found = full_contact_transfer(subject)
    sizes = np.abs(found.ratio)
    mean = float(sizes[:2].mean())
    spread = np.abs(sizes / mean - 1)
    if not np.all(spread <= 4 * found.allowed):
        raise Inconclusive("waves of the full contact have different factors: it is not solved")
    return [Check.relative("stiffness over that of E*", mean, 1.0, float(found.allowed[:2].max()))]


def full_contact(subject: Subject) -> Sequence[Check]:
    """Check that every wave is pressed flat by E* q h / 2."""
    found = full_contact_transfer(subject)
    return [
        Check.below(f"error of the pressure of the wave ({kx}, {ky})", abs(ratio - 1), float(allowed))
        for (kx, ky, *_), ratio, allowed in zip(WAVES, found.ratio, found.allowed, strict=True)
    ]


def load(subject: Subject) -> Sequence[Check]:
    """Check that the mean pressure is the one asked for."""
    return [
        Check.relative(
            f"mean pressure over p0 at p* = {p:g}",
            pressed.claim.pressure.mean() / p,
            1.0,
            10 * subject.tolerance,
        )
        for _, p, pressed in _solves(subject)
    ]


def contact_set(subject: Subject) -> Sequence[Check]:
    """Check that what is called contact carries load; a solver that names none is read by its p > 0."""
    checks = []
    for _, p, pressed in _solves(subject):
        named = pressed.claim.in_contact
        words = "points with p > 0" if named is None else "points called contact"
        counted = np.count_nonzero(pressed.claim.pressure > 0 if named is None else named)
        touching = np.count_nonzero(pressed.result.in_contact)
        if touching == 0:
            raise Inconclusive("no point carries load on a closed gap: it is not solved")
        # A point at an edge, whose pressure and gap are both within the tolerance, may be either.
        allowed = 0.02 + 2 / touching
        checks.append(
            Check.near(f"{words} over points that touch, p* = {p:g}", counted / touching, 1.0, allowed)
        )
    return checks


def honesty(subject: Subject) -> Sequence[Check]:
    """Check that the residuals of the returned pressure, recomputed, are what was asked for."""
    checks = []
    for _, p, pressed in _solves(subject):
        residuals = pressed.result.residuals
        checks += [
            Check.below(f"complementarity, p* = {p:g}", residuals.complementarity, subject.tolerance),
            Check.below(f"penetration over h_rms, p* = {p:g}", residuals.penetration, 10 * subject.tolerance),
        ]
    return checks
