"""Claims about the tire rim (Persson 2006, Sec. 8.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from persson import elastic
from persson.adhesion import AdhesiveContact, Interface
from persson.limits import critical_roughness
from persson.percolation import COMPUTED_THRESHOLDS, SITE_THRESHOLD
from persson.spectrum import area_factor
from validation.paper import systems as s
from validation.paper.claims import Stated, application

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
        return s.adhesive(s.rim(), s.RIM_MODULUS, s.RIM_PRESSURE, self.interface)


_ENERGIES: dict[EnergyName, str] = {
    "as_printed": "energy of Eq. 50 as printed",
    "improved": "energy of Eq. 48",
    "old": "energy of Eq. 43",
}
_AREAS: dict[AreaName, str] = {"star": "A* with slope factor", "projected": "projected areas"}


def _gain(rim: Rim) -> float:
    """Least factor that adhesion adds, over pressures."""
    surface, modulus = s.rim(), s.RIM_MODULUS
    return min(
        s.adhesive(surface, modulus, p, rim.interface).real_area / float(s.area(surface, modulus, p))
        for p in np.geomspace(0.05e6, 1e6, 5).tolist()
    )


def _onset(rim: Rim) -> float:
    state = rim.pressed
    plain = elastic.contact_area(s.RIM_PRESSURE, stress_variance=state.variance)
    return float(state.wavevectors[np.argmax(state.area > 1.1 * plain)] / 1e5)


def _critical() -> float:
    interface = Rim(energy="as_printed", area="star").interface
    return critical_roughness(s.rim(), contact_modulus=s.RIM_MODULUS, interface=interface, tolerance=0.02)


def _seals() -> str:
    """Say of each reading whether the rim seals; the thresholds are those of contacts without adhesion."""
    low, high = COMPUTED_THRESHOLDS
    verdicts = []
    for name, reading in _READINGS.items():
        area = reading.pressed.real_area
        verdict = "seals" if area > high else "leaks" if area < low else "not decided"
        verdicts.append(f"{name} {area:.4f}: {verdict}")
    return f"thresholds of {low:g} to {high:g}, without adhesion; " + ", ".join(verdicts)


#: The literal reading first.
_READINGS = {
    f"{words}, {formula}": Rim(energy=energy, area=area)
    for area, words in _AREAS.items()
    for energy, formula in _ENERGIES.items()
}


RIM = application(
    "tire rim",
    conventions=_READINGS,
    fixed={
        "slope_factor": lambda: 100 * (float(area_factor(s.rim().m2())) - 1),
        "dry_area": lambda: float(s.area(s.rim(), s.RIM_MODULUS, s.RIM_PRESSURE)),
        "onset_estimate": lambda: s.RIM_PRESSURE**2 / (10e6 * s.RIM_WORK) / 1e5,
        "wavelength": lambda: 2 * math.pi / (10 * 1e5) * 1e6,
        "shear_force": lambda: 0.05 * 0.25e6 / 1e3,
    },
    under={
        "area": lambda rim: rim.pressed.real_area,
        "area_gain": _gain,
        "onset": _onset,
        "free_work": lambda rim: (
            s.adhesive(s.rim(), s.RIM_MODULUS, 0.0, rim.interface).macroscopic_work / s.RIM_WORK
        ),
        "friction": lambda rim: 0.05 * 0.25e6 * rim.pressed.real_area / 1e3,
        "site_threshold": lambda rim: rim.pressed.real_area,
        "computed_thresholds": lambda rim: rim.pressed.real_area,
        "energy_share": lambda rim: float(rim.pressed.energy_share[-1] / rim.pressed.area[-1]),
    },
    more={
        "area": {
            "note": lambda: (
                "each reading: " + ", ".join(f"{n} {r.pressed.real_area:.4f}" for n, r in _READINGS.items())
            )
        },
        "free_work": {"note": lambda: f"without load contact is lost from h/h_0 = {_critical():.2f} on"},
        "site_threshold": {"stated": Stated(SITE_THRESHOLD, SITE_THRESHOLD, 1.0, "above it")},
        "computed_thresholds": {
            "stated": Stated(COMPUTED_THRESHOLDS[1], COMPUTED_THRESHOLDS[1], 1.0, "above all of them"),
            "note": _seals,
        },
    },
)
