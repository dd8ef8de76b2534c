"""Claims about PMMA (Persson 2006, Secs. 2.2, 8.4 and 10.1)."""

from __future__ import annotations

import math

from scipy.optimize import brentq

from persson.adhesion import Interface, detachment_stress
from persson.capillary import CapillaryWaves
from persson.sliding import adhesional_pressure, local_shear_stress, slip_energy
from validation.paper import systems as s
from validation.paper.claims import application

#: meV per square angstrom in J/m^2.
_MEV = 1e-3 * 1.602176634e-19 / 1e-20


def rough_pmma(rms_nm: float | None) -> CapillaryWaves:
    """PMMA as printed, or with C(q) scaled to an rms roughness."""
    waves = s.pmma()
    return waves if rms_nm is None else waves.scaled((rms_nm * 1e-9 / waves.moments().rms_height) ** 2)


def pmma_area(rms_nm: float | None, pressure: float) -> float:
    """A(zeta_1)/A0 with adhesion."""
    interface = Interface(work_of_adhesion=s.PMMA_WORK, energy="as_printed")
    return s.adhesive(rough_pmma(rms_nm), s.PMMA_MODULUS, pressure, interface).real_area


def _figure() -> str:
    parts = [
        f"{words}: " + ", ".join(f"{pmma_area(rms, 1e6 * p):.3f}" for p in (1, 20, 50, 100))
        for words, rms in (("as printed", None), ("0.6 nm", 0.6))
    ]
    return "A/A0 at 1, 20, 50, 100 MPa, " + "; ".join(parts) + "; the curve's own numbers are not printed"


def _crossing() -> float:
    """Wavevector [1/m] beyond which C(q) of PMMA is above that of polished steel."""
    plastic, steel = s.pmma(), s.steel()
    return 10 ** brentq(lambda x: math.log(float(plastic(10**x) / steel(10**x))), 6, math.log10(7e9))


PMMA = application(
    "PMMA",
    conventions={
        "printed parameters": None,
        "C(q) scaled to the 0.6 nm of the caption (C x 1.74)": 0.6,
    },
    values={
        "work": lambda: 2 * math.sqrt(0.04 * 0.02),
        "detachment": lambda: (
            1e-9
            * detachment_stress(
                s.PMMA_WORK,
                contact_modulus=s.PMMA_MODULUS,
                wavevector=7e9,
                interface=Interface(work_of_adhesion=s.PMMA_WORK),
            )
        ),
        "local_shear": lambda: local_shear_stress(50e6 * 30e6 / 300e6, pressure=30e6, hardness=300e6) / 50e6,
        "barrier": lambda: slip_energy(50e6, slip=3e-10) / _MEV,
        "adhesional": lambda: adhesional_pressure(_MEV, lift=1e-12) / 1e9,
        "rms": lambda rms: rough_pmma(rms).moments().rms_height * 1e9,
        "rms_caption": lambda rms: rough_pmma(rms).moments().rms_height * 1e9,
        "amplitude": lambda rms: 10 * rough_pmma(rms).moments().rms_height * 1e9,
        "spectrum_ratio": lambda rms: rough_pmma(rms)(7e9) / s.steel()(7e9),
        "load_dependence": lambda rms: pmma_area(rms, 100e6) / pmma_area(rms, 1e6),
        "local_pressure": lambda rms: 50e6 / s.area(rough_pmma(rms), s.PMMA_MODULUS, 50e6) / 1e9,
    },
    more={
        "spectrum_ratio": {"note": lambda: f"they cross at {_crossing():.2g} 1/m"},
        "load_dependence": {"note": _figure},
    },
)
