"""Claims about the tire rim (Persson 2006, Sec. 8.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from persson import elastic
from persson.adhesion import AdhesiveContact, Interface, solve_adhesion
from persson.limits import critical_roughness
from persson.percolation import COMPUTED_THRESHOLDS, SITE_THRESHOLD
from persson.spectrum import area_factor
from validation.paper import systems as s
from validation.paper.claims import Application, Convention, Stated, claim, digit, factor, percent

EnergyName = Literal["improved", "old", "as_printed"]
AreaName = Literal["star", "projected"]


@dataclass(frozen=True, kw_only=True)
class Rim:
    """What Sec. 8 leaves open: the elastic energy, and whether the areas of Eq. 37 carry the slope factor."""

    energy: EnergyName
    area: AreaName

    @property
    def interface(self) -> Interface:
        """Delta gamma with this reading."""
        return Interface(work_of_adhesion=s.RIM_WORK, energy=self.energy, area=self.area)

    @cached_property
    def pressed(self) -> AdhesiveContact:
        """The rim at 0.5 MPa, from which several claims are read."""
        scale = s.scale_of(s.rim(), s.RIM_MODULUS)
        return solve_adhesion(scale, pressure=s.RIM_PRESSURE, interface=self.interface).checked()


_ENERGIES: dict[EnergyName, str] = {
    "as_printed": "energy of Eq. 50 as printed",
    "improved": "energy of Eq. 48",
    "old": "energy of Eq. 43",
}
_AREAS: dict[AreaName, str] = {"star": "A* with slope factor", "projected": "projected areas"}


def _plain_area() -> float:
    variance = elastic.stress_variance(s.rim().m2(), contact_modulus=s.RIM_MODULUS)
    return float(elastic.contact_area(s.RIM_PRESSURE, stress_variance=variance))


def _onset(rim: Rim) -> float:
    state = rim.pressed
    plain = elastic.contact_area(s.RIM_PRESSURE, stress_variance=state.variance)
    return float(state.wavevectors[np.argmax(state.area > 1.1 * plain)] / 1e5)


def _macroscopic(rim: Rim) -> float:
    scale = s.scale_of(s.rim(), s.RIM_MODULUS)
    free = solve_adhesion(scale, pressure=0.0, interface=rim.interface).checked()
    return free.macroscopic_work / s.RIM_WORK


def _critical() -> float:
    interface = Rim(energy="as_printed", area="star").interface
    return critical_roughness(s.rim(), contact_modulus=s.RIM_MODULUS, interface=interface, tolerance=0.02)


def _share(rim: Rim) -> float:
    state = rim.pressed
    return float(state.energy_share[-1] / state.area[-1])


def _seals() -> str:
    """Say of each reading whether the rim seals; the thresholds are those of contacts without adhesion."""
    low, high = COMPUTED_THRESHOLDS

    def verdict(area: float) -> str:
        return "seals" if area > high else "leaks" if area < low else "not decided"

    told = (
        f"{c.name} {c.value.pressed.real_area:.4f}: {verdict(c.value.pressed.real_area)}" for c in _READINGS
    )
    return f"thresholds of {low:g} to {high:g}, without adhesion; " + ", ".join(told)


#: The literal reading first.
_READINGS: tuple[Convention, ...] = tuple(
    Convention(name=f"{words}, {formula}", value=Rim(energy=energy, area=area))
    for area, words in _AREAS.items()
    for energy, formula in _ENERGIES.items()
)


def _each_reading() -> str:
    return "each reading: " + ", ".join(f"{c.name} {c.value.pressed.real_area:.4f}" for c in _READINGS)


RIM = Application(
    name="tire rim",
    conventions=_READINGS,
    claims=(
        claim(
            "surface area above the projected one [%]",
            "8.3",
            digit(38.0, 1.0),
            fixed=lambda: 100 * (float(area_factor(s.rim().m2())) - 1),
        ),
        claim("A/A0 at 0.5 MPa without adhesion", "8.3", digit(0.06, 0.01), fixed=_plain_area),
        claim(
            "A/A0 at 0.5 MPa with adhesion",
            "8.3",
            digit(0.44, 0.01),
            under=lambda rim: rim.pressed.real_area,
            note=_each_reading,
        ),
        claim(
            "adhesion becomes important near magnification",
            "8.3",
            factor(10.0, 2.0, words="about"),
            under=_onset,
            choice="the magnification where adhesion has added a tenth to the area",
        ),
        claim(
            "estimate sigma_0^2 / (E Delta gamma q_0) of that magnification",
            "8.3",
            percent(5.0),
            fixed=lambda: s.RIM_PRESSURE**2 / (10e6 * s.RIM_WORK) / 1e5,
        ),
        claim(
            "wavelength at zeta = 10 [um]",
            "8.3",
            percent(10.0, 10.0),
            fixed=lambda: 2 * math.pi / (10 * 1e5) * 1e6,
            failure="2 pi / (10 q_0) is 6.3 um",
        ),
        claim(
            "gamma_eff(1)/Delta gamma without load at h = h_0",
            "8.3",
            Stated(0.0, -0.01, 0.01, "1 % of Delta gamma"),
            under=_macroscopic,
            note=lambda: f"without load contact is lost from h/h_0 = {_critical():.2f} on",
        ),
        claim(
            "friction force of 0.05 m^2 at 0.25 MPa [kN]",
            "8.3",
            percent(5.7),
            under=lambda rim: 0.05 * 0.25e6 * rim.pressed.real_area / 1e3,
            note=lambda: "the paper rounds 12.5 kN up to 13 kN before multiplying by 0.44",
        ),
        claim(
            "shear force in perfect contact [kN]",
            "8.3",
            percent(13.0),
            fixed=lambda: 0.05 * 0.25e6 / 1e3,
        ),
        claim(
            "A/A0 above the percolation threshold 1 - p_c: no leak",
            "8.3",
            Stated(SITE_THRESHOLD, SITE_THRESHOLD, 1.0, "above it"),
            under=lambda rim: rim.pressed.real_area,
        ),
        claim(
            "A/A0 above the thresholds that were computed since: no leak",
            "8.3",
            Stated(COMPUTED_THRESHOLDS[1], COMPUTED_THRESHOLDS[1], 1.0, "above all of them"),
            under=lambda rim: rim.pressed.real_area,
            note=_seals,
            failure="the area lies among or below the thresholds",
        ),
        claim(
            "P~/P at the highest magnification, 'below 1'",
            "8.2",
            Stated(1.0, 0.0, 1.0, "below 1"),
            under=_share,
            failure="under load P~ may exceed P, and without adhesion it tends to 2 P (docs/errata.md)",
        ),
    ),
)
