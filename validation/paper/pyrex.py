"""Claims about Pyrex (Persson 2006, Secs. 2.2 and 10.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from persson.adhesion import Interface
from persson.capillary import CapillaryWaves, maximum_height
from persson.limits import critical_roughness
from persson.squeezed_spheres import (
    RoughnessBarrier,
    hertz_pressure,
    roughness_barrier,
    yielded_pull_off,
    yielded_share,
)
from persson.tabulated import Tabulated
from validation.paper import systems as s
from validation.paper.claims import application
from validation.paper.rim import EnergyName

#: Radius of the sphere [m] and the force of the text [N].
_RADIUS, _FORCE = 1.8e-3, 0.06**3


@dataclass(frozen=True, kw_only=True)
class Pyrex:
    """What Sec. 10.2 leaves open: how the roughness of two surfaces adds up, moduli, energies."""

    # Of C(q): 1 for one surface, 2 for two independent ones, 4 for two equal ones added coherently.
    multiple: float = 1.0
    # Composite Young's modulus [Pa]: 32 GPa as in the captions, or 16 if that is the modulus of each body.
    young: float = 32e9
    work: float = s.PYREX_WORK  # Delta gamma [J/m^2]: .43 as in the caption, or twice that, as Eq. 53 wants
    energy: EnergyName = "improved"  # Elastic energy at partial contact

    @property
    def name(self) -> str:
        """In words."""
        two = {2.0: "two independent surfaces", 4.0: "two equal surfaces added coherently"}
        return (
            f"{two.get(self.multiple, 'one surface')} (C x {self.multiple:g}), E = {self.young / 1e9:g} GPa, "
            f"Delta gamma = {self.work:g} J/m^2, energy of Eq. {'48' if self.energy == 'improved' else '43'}"
        )

    @property
    def modulus(self) -> float:
        """E* [Pa]."""
        return self.young / (1 - 0.2**2)

    @property
    def interface(self) -> Interface:
        """Delta gamma with this reading."""
        return Interface(work_of_adhesion=self.work, energy=self.energy)

    @property
    def spectrum(self) -> CapillaryWaves:
        """C(q)."""
        return s.pyrex().scaled(self.multiple)


@cache
def _squeezed(pyrex: Pyrex, pressure: float = s.PYREX_PRESSURE) -> RoughnessBarrier:
    """Adhesion before and after squeezing with a pressure [Pa]."""
    return roughness_barrier(
        pyrex.spectrum,
        contact_modulus=pyrex.modulus,
        pressure=pressure,
        yield_stress=s.PYREX_HARDNESS,
        interface=pyrex.interface,
    )


#: The literal reading, then what a second surface, the other moduli and energies make of it.
_SETS = (
    Pyrex(),
    Pyrex(energy="old"),
    Pyrex(multiple=2.0),
    Pyrex(multiple=2.0, energy="old"),
    Pyrex(multiple=4.0),
    Pyrex(multiple=4.0, energy="old"),
    Pyrex(multiple=4.0, energy="old", young=16e9),
    Pyrex(multiple=4.0, energy="old", work=2 * s.PYREX_WORK),
)


def _critical(pyrex: Pyrex) -> float:
    asked = {"contact_modulus": pyrex.modulus, "tolerance": 0.008}
    return critical_roughness(pyrex.spectrum, interface=pyrex.interface, **asked)


def _half_yielded(pyrex: Pyrex) -> float:
    q = np.geomspace(1.001 * pyrex.spectrum.q_min, pyrex.spectrum.q_short, 20000)
    areas = s.yielded(pyrex.spectrum, pyrex.modulus, s.PYREX_PRESSURE, hardness=s.PYREX_HARDNESS, q=q)
    return float(np.interp(0.5, areas.plastic * s.PYREX_HARDNESS / s.PYREX_PRESSURE, q)) / 1e6


def smoothed_pyrex() -> Tabulated:
    """Pyrex, two equal surfaces, after squeezing with 20 MPa (Sec. 10.2)."""
    return _squeezed(Pyrex(multiple=4.0, energy="old")).spectrum


def _rms(q_min: float) -> float:
    return s.pyrex(q_min=q_min).moments().rms_height * 1e9


def _pair(pyrex: Pyrex) -> dict[str, float]:
    """Sphere and flat for the formulas of Hertz: E* of both bodies together."""
    return {"radius": _RADIUS, "contact_modulus": pyrex.modulus}


def _after(pyrex: Pyrex, force: float) -> float:
    """gamma_eff(1) over Delta gamma after squeezing with a force [N]."""
    pressure = float(hertz_pressure(force, **_pair(pyrex)))
    return _squeezed(pyrex, pressure).after.macroscopic_work / pyrex.work


def _line() -> str:
    given = {"radius": _RADIUS, "hardness": s.PYREX_HARDNESS, "work_of_adhesion": 2 * s.PYREX_WORK}
    forces = [
        float(yielded_pull_off(_FORCE, contact_modulus=young / 2 / 0.96, **given)) for young in (32e9, 64e9)
    ]
    return (
        "the line of the figure, Eq. 56 with gamma_sl = 0.43, is at "
        f"{forces[0] * 1e6:.1f} or {forces[1] * 1e6:.1f} uN at 0.06 N^(1/3), for 32 or 64 GPa "
        "of each body; the figure's own numbers are not printed"
    )


PYREX = application(
    "Pyrex",
    conventions={one.name: one for one in _SETS},
    values={
        "rms": lambda: _rms(1e6),
        "amplitude": lambda: 10 * _rms(1e6),
        "young_ratio": lambda: 64e9 / 2.9e9,
        "range": lambda: 2.0 / 0.15,
        "critical": _critical,
        "half_yielded": _half_yielded,
        "yielded_region": lambda pyrex: (2 * math.pi / (_half_yielded(pyrex) * 1e-3)) ** 2,
        "work_after": lambda pyrex: _squeezed(pyrex).after.macroscopic_work / pyrex.work,
        "threshold": lambda pyrex: _after(pyrex, 1e-8),
        "area_after": lambda pyrex: _squeezed(pyrex).after.real_area,
        "nominal_pressure": lambda pyrex: hertz_pressure(_FORCE, **_pair(pyrex)) / 1e6,
        "pull_off": lambda pyrex: yielded_share(_FORCE, hardness=s.PYREX_HARDNESS, **_pair(pyrex)),
    },
    more={
        "rms": {
            "choice": "q_L = 1e6 1/m, the q_0 of the figures; 2 pi / 1 um gives "
            + f"{_rms(2e6 * math.pi):.3f} nm"
        },
        "critical": {
            "note": lambda: (
                "two independent surfaces (C x 2) with Eq. 43: "
                f"{_critical(Pyrex(multiple=2.0, energy='old')):.2f}, half yielded at "
                f"{_half_yielded(Pyrex(multiple=2.0)):.0f}"
            )
        },
        "threshold": {
            "note": lambda: (
                f"the same after 1e-4 N, one surface: {_after(_SETS[0], 1e-4):.4f}, and "
                f"{_after(_SETS[0], 1e-8):.4f} after 1e-8 N"
            )
        },
        "pull_off": {"note": _line},
        "range": {
            "note": lambda: (
                f"512 x 512 independent points would show {2 * maximum_height(512.0**2):.1f} h_rms"
            )
        },
    },
)
