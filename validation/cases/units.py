"""Other units: lengths times 2^20 and pressures times 2^-30 change no bit of any dimensionless result."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from fem_contact import bem, block
from fem_contact.contact import ContactResult
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface
from persson import elastic
from persson.spectrum import SelfAffine
from validation.cases import Case, Check

__all__ = ["CASES"]

_LENGTH, _STRESS = 2.0**20, 2.0**-30


def _solve(method: str, length: float, stress: float) -> ContactResult:
    spectrum = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=4 * math.pi, q_short=8 * math.pi)
    plain = random_surface(spectrum, q_short=spectrum.q_short, lengths=(1.0, 1.0), shape=(24, 20), seed=1414)
    surface = HeightField(heights=plain.heights * length, lengths=(length, length))
    solid = Solid(young=stress, poisson=0.3)
    load = 0.01 * stress
    if method == "bem":
        return bem.solve(surface, HalfSpace(solid=solid), mean_pressure=load).checked()
    return block.solve(surface, solid, method="full", mean_pressure=load).contact.checked()


def _solvers(method: str) -> list[Check]:
    plain, scaled = _solve(method, 1.0, 1.0), _solve(method, _LENGTH, _STRESS)
    pressure = int(np.count_nonzero(plain.pressure != scaled.pressure / _STRESS))
    gap = int(np.count_nonzero(plain.gap != scaled.gap / _LENGTH))
    contact = int(np.count_nonzero(plain.in_contact != scaled.in_contact))
    return [
        Check.below("points whose pressure differs", pressure, 0),
        Check.below("points whose gap differs", gap, 0),
        Check.below("points whose contact differs", contact, 0),
        Check.below("residuals that differ", float(plain.residuals != scaled.residuals), 0),
    ]


def _theory() -> list[Check]:
    areas = []
    for length, stress in ((1.0, 1.0), (_LENGTH, _STRESS)):
        spectrum = SelfAffine.from_rms_gradient(
            0.1, hurst=0.8, q_long=4 * math.pi / length, q_short=400 * math.pi / length
        )
        variance = elastic.stress_variance(spectrum.m2(), contact_modulus=stress)
        areas.append(float(elastic.contact_area(0.01 * stress, stress_variance=variance)))
    return [Check.near("A/A0", areas[1], areas[0], 0.0)]


_CLAIM = "Lengths times 2^20 and pressures times 2^-30 leave every dimensionless result {} bit for bit."
CASES = (
    Case(name="units-bem", claim=_CLAIM.format("of boundary elements"), run=partial(_solvers, "bem")),
    Case(name="units-fem", claim=_CLAIM.format("of finite elements"), run=partial(_solvers, "fem")),
    Case(name="units-theory", claim=_CLAIM.format("of the theory"), run=_theory),
)
