"""Claims about polished steel and roads (Persson 2006, Secs. 2.1, 3.6, 3.7 and 6)."""

from __future__ import annotations

import math

from persson import elastic
from persson.hardness import constant_hardness
from persson.percolation import SITE_THRESHOLD
from persson.separation import macroasperity_magnification, macroasperity_pressure
from validation.paper import systems as s
from validation.paper.claims import Application, Stated, claim, percent

_ROLL_OFF = "a smooth roll-off at q_0 = 1e5 1/m, q_1 = 1e10 1/m"


def _magnification() -> float:
    return macroasperity_magnification(
        s.steel(smooth=True), pressure=s.STEEL_PRESSURE, contact_modulus=s.STEEL_MODULUS, q_reference=1e5
    )


def _pressure(load: float) -> float:
    return macroasperity_pressure(
        s.steel(smooth=True), pressure=load, contact_modulus=s.STEEL_MODULUS, q_reference=1e5
    )


def _plastic_limit() -> float:
    variance = float(elastic.stress_variance(s.steel().m2(), contact_modulus=s.STEEL_MODULUS))
    areas = constant_hardness(s.STEEL_PRESSURE, stress_variance=variance, yield_stress=2e9)
    return float(areas.plastic) * 2e9 / s.STEEL_PRESSURE


STEEL = Application(
    name="polished steel and roads",
    claims=(
        claim(
            "roads: roll-off wavelength for q_0 = 1000 1/m [cm]",
            "2.1",
            percent(1.0, 10.0),
            fixed=lambda: 2 * math.pi / 1000 * 100,
            failure="2 pi / q_0 is 6.3 mm",
        ),
        claim(
            "macroasperity magnification at 10 MPa, expected in 1 ... 5",
            "3.6",
            Stated(3.0, 1.0, 5.0, "the range the paper names"),
            fixed=_magnification,
            choice=_ROLL_OFF,
            failure="ln A bends most already below the roll-off",
        ),
        claim(
            "A/A0 of the macroasperities, 'below the percolation threshold'",
            "3.6",
            Stated(SITE_THRESHOLD, 0.0, SITE_THRESHOLD, "below it"),
            fixed=lambda: s.STEEL_PRESSURE / _pressure(s.STEEL_PRESSURE),
            choice=_ROLL_OFF,
        ),
        claim(
            "pressure in the macroasperities at 10 MPa over that at 1 MPa, 'independent of the load'",
            "3.7",
            percent(1.0, 2.0),
            fixed=lambda: _pressure(10e6) / _pressure(1e6),
            choice=_ROLL_OFF,
            note=lambda: (
                f"{_pressure(1e6) / 1e6:.0f} and {_pressure(10e6) / 1e6:.0f} MPa, but "
                f"{_pressure(100e6) / 1e6:.0f} at 100 MPa, where the contact is not light any more"
            ),
        ),
        claim(
            "A_pl sigma_Y / (sigma_0 A_0) at the highest magnification",
            "6",
            percent(1.0, 1.0),
            fixed=_plastic_limit,
            choice="q_0 and q_1 of the steel, sigma_Y = 2 GPa",
        ),
    ),
)
