"""Claims about polished steel and roads (Persson 2006, Secs. 2.1, 3.6, 3.7 and 6)."""

from __future__ import annotations

import math

from persson.percolation import SITE_THRESHOLD
from persson.separation import macroasperity_magnification, macroasperity_pressure
from validation.paper import systems as s
from validation.paper.claims import Stated, application


def _magnification() -> float:
    return macroasperity_magnification(
        s.steel(smooth=True), pressure=s.STEEL_PRESSURE, contact_modulus=s.STEEL_MODULUS, q_reference=1e5
    )


def _pressure(load: float) -> float:
    return macroasperity_pressure(
        s.steel(smooth=True), pressure=load, contact_modulus=s.STEEL_MODULUS, q_reference=1e5
    )


STEEL = application(
    "polished steel and roads",
    fixed={
        "roads": lambda: 2 * math.pi / 1000 * 100,
        "magnification": _magnification,
        "area_share": lambda: s.STEEL_PRESSURE / _pressure(s.STEEL_PRESSURE),
        "pressure_share": lambda: _pressure(10e6) / _pressure(1e6),
        "plastic_limit": lambda: (
            float(s.yielded(s.steel(), s.STEEL_MODULUS, s.STEEL_PRESSURE, hardness=2e9).plastic)
            * 2e9
            / s.STEEL_PRESSURE
        ),
    },
    more={
        "area_share": {"stated": Stated(SITE_THRESHOLD, 0.0, SITE_THRESHOLD, "below it")},
        "pressure_share": {
            "note": lambda: (
                f"{_pressure(1e6) / 1e6:.0f} and {_pressure(10e6) / 1e6:.0f} MPa, but "
                f"{_pressure(100e6) / 1e6:.0f} at 100 MPa, where the contact is not light any more"
            )
        },
    },
)
