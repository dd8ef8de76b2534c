"""Claims about the tire rim (Persson 2006, Sec. 8.3)."""

from __future__ import annotations

import math
from functools import cache
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

_ENERGIES: dict[EnergyName, str] = {
    "as_printed": "energy of Eq. 50 as printed",
    "improved": "energy of Eq. 48",
    "old": "energy of Eq. 43",
}
_AREAS: dict[AreaName, str] = {"star": "A* with slope factor", "projected": "projected areas"}


@cache
def _pressed(reading: Interface) -> AdhesiveContact:
    """Return the rim at 0.5 MPa, from which several claims are read."""
    return s.adhesive(s.rim(), s.RIM_MODULUS, s.RIM_PRESSURE, reading)


def _gain(rim: Interface) -> float:
    """Least factor that adhesion adds, over pressures."""
    surface, modulus = s.rim(), s.RIM_MODULUS
    return min(
        s.adhesive(surface, modulus, p, rim).real_area / float(s.area(surface, modulus, p))
        for p in np.geomspace(0.05e6, 1e6, 5).tolist()
    )


def _onset(rim: Interface) -> float:
    state = _pressed(rim)
    plain = elastic.contact_area(s.RIM_PRESSURE, stress_variance=state.variance)
    return float(state.wavevectors[np.argmax(state.area > 1.1 * plain)] / 1e5)


def _critical() -> float:
    interface = Interface(work_of_adhesion=s.RIM_WORK, energy="as_printed")
    return critical_roughness(s.rim(), contact_modulus=s.RIM_MODULUS, interface=interface, tolerance=0.02)


def _seals() -> str:
    """Say of each reading whether the rim seals; the thresholds are those of contacts without adhesion."""
    low, high = COMPUTED_THRESHOLDS
    verdicts = []
    for name, reading in _READINGS.items():
        area = _pressed(reading).real_area
        verdict = "seals" if area > high else "leaks" if area < low else "not decided"
        verdicts.append(f"{name} {area:.4f}: {verdict}")
    return f"thresholds of {low:g} to {high:g}, without adhesion; " + ", ".join(verdicts)


#: The literal reading first.
_READINGS = {
    f"{words}, {formula}": Interface(work_of_adhesion=s.RIM_WORK, energy=energy, area=area)
    for area, words in _AREAS.items()
    for energy, formula in _ENERGIES.items()
}


RIM = application(
    "tire rim",
    conventions=_READINGS,
    values={
        "slope_factor": lambda: 100 * (area_factor(s.rim().m2()) - 1),
        "dry_area": lambda: s.area(s.rim(), s.RIM_MODULUS, s.RIM_PRESSURE),
        "onset_estimate": lambda: s.RIM_PRESSURE**2 / (10e6 * s.RIM_WORK) / 1e5,
        "wavelength": lambda: 2 * math.pi / (10 * 1e5) * 1e6,
        "shear_force": lambda: 0.05 * 0.25e6 / 1e3,
        "area": lambda rim: _pressed(rim).real_area,
        "area_gain": _gain,
        "onset": _onset,
        "free_work": lambda rim: s.adhesive(s.rim(), s.RIM_MODULUS, 0.0, rim).macroscopic_work / s.RIM_WORK,
        "friction": lambda rim: 0.05 * 0.25e6 * _pressed(rim).real_area / 1e3,
        "site_threshold": lambda rim: _pressed(rim).real_area,
        "computed_thresholds": lambda rim: _pressed(rim).real_area,
        "energy_share": lambda rim: _pressed(rim).energy_share[-1] / _pressed(rim).area[-1],
    },
    more={
        "area": {
            "note": lambda: (
                "each reading: " + ", ".join(f"{n} {_pressed(r).real_area:.4f}" for n, r in _READINGS.items())
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
