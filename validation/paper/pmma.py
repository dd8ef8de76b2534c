"""Claims about PMMA (Persson 2006, Secs. 2.2, 8.4 and 10.1)."""

from __future__ import annotations

import math

from scipy.optimize import brentq

from persson import elastic
from persson.adhesion import Interface, detachment_stress, solve_adhesion
from persson.capillary import CapillaryWaves
from persson.sliding import adhesional_pressure, local_shear_stress, slip_energy
from validation.paper import systems as s
from validation.paper.claims import Application, Convention, Stated, claim, digit, factor, percent

#: meV per square angstrom in J/m^2.
_MEV = 1e-3 * 1.602176634e-19 / 1e-20


def rough_pmma(rms_nm: float | None) -> CapillaryWaves:
    """PMMA as printed, or with C(q) scaled to an rms roughness."""
    waves = s.pmma()
    return waves if rms_nm is None else waves.scaled((rms_nm * 1e-9 / waves.moments().rms_height) ** 2)


def pmma_area(rms_nm: float | None, pressure: float) -> float:
    """A(zeta_1)/A0 with adhesion."""
    interface = Interface(work_of_adhesion=s.PMMA_WORK, energy="as_printed")
    scale = s.scale_of(rough_pmma(rms_nm), s.PMMA_MODULUS)
    return solve_adhesion(scale, pressure=pressure, interface=interface).checked().real_area


def _local_pressure(rms_nm: float | None) -> float:
    variance = elastic.stress_variance(rough_pmma(rms_nm).m2(), contact_modulus=s.PMMA_MODULUS)
    return 50e6 / float(elastic.contact_area(50e6, stress_variance=variance)) / 1e9


def _figure() -> str:
    parts = [
        f"{words}: " + ", ".join(f"{pmma_area(rms, 1e6 * p):.3f}" for p in (1, 20, 50, 100))
        for words, rms in (("as printed", None), ("0.6 nm", 0.6))
    ]
    return "A/A0 at 1, 20, 50, 100 MPa, " + "; ".join(parts) + "; the curve's own numbers are not printed"


def _crossing() -> float:
    """Wavevector [1/m] beyond which C(q) of PMMA is above that of polished steel."""
    plastic, steel = s.pmma(), s.steel()
    return math.exp(
        brentq(
            lambda x: math.log(float(plastic(math.exp(x)) / steel(math.exp(x)))), math.log(1e6), math.log(7e9)
        )
    )


def _strongest() -> float:
    stress = detachment_stress(
        s.PMMA_WORK,
        contact_modulus=s.PMMA_MODULUS,
        wavevector=7e9,
        interface=Interface(work_of_adhesion=s.PMMA_WORK),
    )
    return float(stress) / 1e9


PMMA = Application(
    name="PMMA",
    conventions=(
        Convention(name="printed parameters", value=None),
        Convention(name="C(q) scaled to the 0.6 nm of the caption (C x 1.74)", value=0.6),
    ),
    claims=(
        claim(
            "rms roughness [nm], text",
            "2.2",
            digit(0.5, 0.1),
            under=lambda rms: rough_pmma(rms).moments().rms_height * 1e9,
        ),
        claim(
            "rms roughness [nm], caption of the spectra",
            "2.2",
            digit(0.6, 0.1),
            under=lambda rms: rough_pmma(rms).moments().rms_height * 1e9,
            failure="the formulas with the stated parameters give 0.455 nm",
        ),
        claim(
            "maximum roughness amplitude [nm]",
            "2.2",
            percent(5.0, 10.0),
            under=lambda rms: 10 * rough_pmma(rms).moments().rms_height * 1e9,
            choice="ten times h_rms, App. A",
        ),
        claim(
            "C(q) over that of polished steel at q_1 = 7e9 1/m, 'larger'",
            "2.2",
            Stated(1.0, 1.0, math.inf, "above 1"),
            under=lambda rms: float(rough_pmma(rms)(7e9) / s.steel()(7e9)),
            choice="q_0 and q_1 of the steel",
            note=lambda: f"they cross at {_crossing():.2g} 1/m",
        ),
        claim(
            "figure of the area: A/A0 at 100 MPa over that at 1 MPa, 'depends on the load'",
            "10.1",
            Stated(2.0, 2.0, math.inf, "at least a factor 2"),
            under=lambda rms: pmma_area(rms, 100e6) / pmma_area(rms, 1e6),
            choice="nu = 0.35",
            failure="with the printed parameters the area is flat and cannot show a dependence on the load",
            note=_figure,
        ),
        claim(
            "local pressure in the contacts [GPa]",
            "10.1",
            percent(2.0, 25.0),
            under=_local_pressure,
            choice="nu = 0.35, nominal pressure 50 MPa",
            failure="load over real area at 50 MPa is three times smaller, and smaller still with adhesion",
            note=lambda: "the same section has 50-100 MPa for the local pressure, which is the nominal one",
        ),
        claim(
            "Delta gamma = 2 (gamma_1 gamma_2)^(1/2) [J/m^2]",
            "10.1",
            digit(0.07, 0.01),
            fixed=lambda: 2 * math.sqrt(0.04 * 0.02),
            failure="the paper's own 0.04 and 0.02 J/m^2 give 0.057; it computes with 0.06",
        ),
        claim(
            "detachment stress at the highest magnification [GPa], 'about'",
            "8.4",
            factor(1.0, 2.0, words="about"),
            fixed=_strongest,
            choice="nu = 0.35",
        ),
        claim(
            "shear stress tau H / sigma_0 of a yielded contact over tau_f",
            "10.1",
            percent(1.0, 1e-6),
            fixed=lambda: (
                float(local_shear_stress(50e6 * 30e6 / 300e6, pressure=30e6, hardness=300e6)) / 50e6
            ),
        ),
        claim(
            "barrier of a slip, tau_f b [meV/A^2], 'about'",
            "10.1",
            factor(1.0, 2.0, words="about"),
            fixed=lambda: float(slip_energy(50e6, slip=3e-10)) / _MEV,
        ),
        claim(
            "adhesional pressure [GPa], 'about'",
            "10.1",
            factor(10.0, 2.0, words="about"),
            fixed=lambda: float(adhesional_pressure(_MEV, lift=1e-12)) / 1e9,
        ),
    ),
)
