"""The calculated figures of Persson (2006) as numbers; nothing is drawn here."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from persson import elastic
from persson.adhesion import AdhesiveContact, Interface, solve_adhesion
from persson.asperities import nayak_asperities, ring_asperities
from persson.hardness import constant_hardness
from persson.spectrum import Moments, Spectrum
from persson.spheres import DoubleHertz, hertz_pressure_distribution
from validation.arrays import Array
from validation.paper import systems as s
from validation.paper.pmma import rough_pmma
from validation.paper.pyrex import smoothed_pyrex
from validation.paper.rim import EnergyName

__all__ = ["FIGURES", "Curve", "Panel", "PaperFigure"]

Axis = Literal["linear", "log"]


@dataclass(frozen=True, kw_only=True)
class Curve:
    """One line: label, abscissae and ordinates."""

    label: str
    x: Array
    y: Array


@dataclass(frozen=True, kw_only=True)
class Panel:
    """One pair of axes."""

    x: str
    y: str
    curves: tuple[Curve, ...]
    x_scale: Axis = "linear"
    y_scale: Axis = "linear"


@dataclass(frozen=True, kw_only=True)
class PaperFigure:
    """One figure of the paper.

    Attributes
    ----------
    name : str
        File name without suffix.
    title : str
        What it shows, with the choices made.
    panels : tuple of Panel
    """

    name: str
    title: str
    panels: tuple[Panel, ...]


def _area(
    spectrum: Spectrum, modulus: float, pressure: float | Array, q: float | Array | None = None
) -> Array:
    variance = elastic.stress_variance(spectrum.m2(q), contact_modulus=modulus)
    return elastic.contact_area(pressure, stress_variance=variance)


def spectra() -> PaperFigure:
    """Power spectra of polished steel and PMMA."""
    curves = []
    for label, spectrum in (
        ("polished steel, h_rms = 0.1 um", s.steel()),
        ("PMMA, frozen capillary waves", s.pmma()),
    ):
        q = np.geomspace(spectrum.q_min, spectrum.q_short, 200)
        curves.append(Curve(label=label, x=q, y=spectrum(q)))
    panel = Panel(x="q [1/m]", y="C(q) [m^4]", curves=tuple(curves), x_scale="log", y_scale="log")
    return PaperFigure(name="spectra", title="Power spectra, Sec. 2.2", panels=(panel,))


def greenwood_williamson() -> PaperFigure:
    """Area and patch size of the Greenwood-Williamson model, q_m = 600 1/m and q_m h_rms = 1."""
    q = 600.0
    models = (
        ("estimates of Sec. 3.2", ring_asperities(q, rms_height=1 / q)),
        ("Nayak's relations", nayak_asperities(Moments(m0=1 / q**2, m2=1.0, m4=q**2))),
    )
    areas, patches = [], []
    for label, bumps in models:
        found = bumps.contact(bumps.rms_height * np.linspace(4.5, 0.0, 80), contact_modulus=1.0)
        areas.append(Curve(label=label, x=found.pressure, y=found.area))
        patches.append(Curve(label=label, x=found.pressure, y=found.patch_area))
    load = "sigma_0 / E*"
    return PaperFigure(
        name="greenwood_williamson",
        title="Greenwood-Williamson model, one wavelength, Sec. 3.2",
        panels=(
            Panel(x=load, y="A / A_0", curves=tuple(areas), x_scale="log", y_scale="log"),
            Panel(x=load, y="mean patch [m^2]", curves=tuple(patches), x_scale="log", y_scale="log"),
        ),
    )


def polished_steel() -> PaperFigure:
    """Contact area of polished steel against pressure and magnification."""
    load = np.geomspace(1e-4, 1.0, 120)
    zeta = np.geomspace(1.0, 1e5, 200)
    against_load = Curve(label="full magnification", x=load, y=_area(s.steel(), 1.0, load))
    against_zeta = Curve(label="sigma_0 / E* = 0.001", x=zeta, y=_area(s.steel(), 1.0, 1e-3, zeta * 1e5))
    return PaperFigure(
        name="polished_steel",
        title="Polished steel, elastic, Sec. 3.4 (q_0 = 1e5 1/m chosen)",
        panels=(
            Panel(x="sigma_0 / E*", y="A / A_0", curves=(against_load,), x_scale="log", y_scale="log"),
            Panel(x="zeta", y="A / A_0", curves=(against_zeta,), x_scale="log", y_scale="log"),
        ),
    )


def macroasperities() -> PaperFigure:
    """Logarithm of the area and its second derivative, polished steel at 10 MPa."""
    x = np.linspace(math.log(0.05), math.log(1e4), 1200)
    area = _area(s.steel(smooth=True), s.STEEL_MODULUS, s.STEEL_PRESSURE, 1e5 * np.exp(x))
    bend = np.gradient(np.gradient(np.log(area), x), x)
    return PaperFigure(
        name="macroasperities",
        title="Macroasperities of polished steel at 10 MPa, Sec. 3.6 (smooth roll-off)",
        panels=(
            Panel(
                x="zeta",
                y="A / A_0",
                curves=(Curve(label="area", x=np.exp(x), y=area),),
                x_scale="log",
                y_scale="log",
            ),
            Panel(
                x="zeta",
                y="d^2 ln A / d(ln zeta)^2",
                curves=(Curve(label="curvature", x=np.exp(x[2:-2]), y=bend[2:-2]),),
                x_scale="log",
            ),
        ),
    )


def elastoplastic() -> PaperFigure:
    """Elastic and plastic area of polished steel at 10 MPa for several hardnesses."""
    zeta = np.geomspace(1.001, 1e5, 240)
    variance = elastic.stress_variance(s.steel().m2(1e5 * zeta), contact_modulus=s.STEEL_MODULUS)
    elastic_curves, plastic_curves = [], []
    for hardness in (1e9, 2e9, 4e9, 8e9):
        areas = constant_hardness(s.STEEL_PRESSURE, stress_variance=variance, yield_stress=hardness)
        label = f"sigma_Y = {hardness / 1e9:g} GPa"
        # Below 1e-12 the elastic area is of no use and only stretches the axis.
        shown = areas.elastic > 1e-12
        elastic_curves.append(Curve(label=label, x=zeta[shown], y=areas.elastic[shown]))
        plastic_curves.append(Curve(label=label, x=zeta, y=areas.plastic * hardness / s.STEEL_PRESSURE))
    return PaperFigure(
        name="elastoplastic",
        title="Polished steel at 10 MPa with constant hardness, Sec. 6",
        panels=(
            Panel(x="zeta", y="A_el / A_0", curves=tuple(elastic_curves), x_scale="log", y_scale="log"),
            Panel(x="zeta", y="A_pl sigma_Y / (A_0 sigma_0)", curves=tuple(plastic_curves), x_scale="log"),
        ),
    )


def _adhesive(spectrum: Spectrum, modulus: float, pressure: float, interface: Interface) -> AdhesiveContact:
    return solve_adhesion(s.scale_of(spectrum, modulus), pressure=pressure, interface=interface).checked()


def _sweep(
    make: Callable[[float], Spectrum], ratios: Array, modulus: float, interface: Interface, label: str
) -> tuple[Curve, Curve]:
    found = [_adhesive(make(float(r)), modulus, 0.0, interface) for r in ratios]
    area = np.array([f.real_area for f in found])
    work = np.array([f.macroscopic_work for f in found]) / interface.work_of_adhesion
    return Curve(label=label, x=ratios, y=area), Curve(label=label, x=ratios, y=work)


def rim_roughness() -> PaperFigure:
    """Area and macroscopic energy of the rim without load against roughness, with both energies."""
    ratios = np.concatenate([np.linspace(0.05, 0.3, 4), np.linspace(0.34, 0.58, 9), [0.8, 1.0]])
    names: tuple[tuple[str, EnergyName], ...] = (
        ("old energy, Eq. 43", "old"),
        ("improved energy, Eqs. 44-50", "improved"),
    )
    pairs = [
        _sweep(s.rim, ratios, s.RIM_MODULUS, Interface(work_of_adhesion=s.RIM_WORK, energy=energy), label)
        for label, energy in names
    ]
    return PaperFigure(
        name="rim_roughness",
        title="Tire rim without load, Sec. 8.3",
        panels=(
            Panel(x="h / h_0", y="A(zeta_1) / A_0", curves=tuple(p[0] for p in pairs)),
            Panel(x="h / h_0", y="gamma_eff(1) / Delta gamma", curves=tuple(p[1] for p in pairs)),
        ),
    )


def rim_magnification() -> PaperFigure:
    """Area and effective energy of the rim at 0.5 MPa against magnification."""
    areas, works = [], []
    for label, energy in (
        ("old energy, Eq. 43", "old"),
        ("Eq. 48", "improved"),
        ("Eq. 50 as printed", "as_printed"),
    ):
        interface = Interface(work_of_adhesion=s.RIM_WORK, energy=energy)  # type: ignore[arg-type]
        found = _adhesive(s.rim(), s.RIM_MODULUS, s.RIM_PRESSURE, interface)
        zeta = found.wavevectors / 1e5
        areas.append(Curve(label=label, x=zeta, y=found.area))
        works.append(Curve(label=label, x=zeta, y=found.work / s.RIM_WORK))
    q = np.geomspace(1.0, 1e5, 150)
    areas.append(
        Curve(label="without adhesion", x=q, y=_area(s.rim(), s.RIM_MODULUS, s.RIM_PRESSURE, 1e5 * q))
    )
    return PaperFigure(
        name="rim_magnification",
        title="Tire rim at 0.5 MPa, Sec. 8.3",
        panels=(
            Panel(x="zeta", y="A / A_0", curves=tuple(areas), x_scale="log"),
            Panel(x="zeta", y="gamma_eff / Delta gamma", curves=tuple(works), x_scale="log"),
        ),
    )


def _against_pressure(
    spectrum: Spectrum, modulus: float, interface: Interface, load: Array
) -> tuple[Curve, Curve]:
    with_adhesion = np.array([_adhesive(spectrum, modulus, float(p), interface).real_area for p in load])
    return (
        Curve(label="with adhesion", x=load / 1e6, y=with_adhesion),
        Curve(label="without adhesion", x=load / 1e6, y=_area(spectrum, modulus, load)),
    )


def rim_pressure() -> PaperFigure:
    """Real contact area of the rim against pressure."""
    interface = Interface(work_of_adhesion=s.RIM_WORK, energy="as_printed")
    curves = _against_pressure(s.rim(), s.RIM_MODULUS, interface, np.linspace(0.02e6, 1.5e6, 20))
    panel = Panel(x="sigma_0 [MPa]", y="A(zeta_1) / A_0", curves=curves)
    return PaperFigure(name="rim_pressure", title="Tire rim, Sec. 8.3 (Eq. 50 as printed)", panels=(panel,))


def pmma_pressure() -> PaperFigure:
    """Real contact area of PMMA on a silanised wafer against pressure."""
    interface = Interface(work_of_adhesion=s.PMMA_WORK, energy="as_printed")
    load = np.linspace(1e6, 100e6, 23)
    panels = []
    for words, rms in (("parameters as printed", None), ("C(q) scaled to 0.6 nm", 0.6)):
        pair = _against_pressure(rough_pmma(rms), s.PMMA_MODULUS, interface, load)
        panels.append(Panel(x=f"sigma_0 [MPa], {words}", y="A(zeta_1) / A_0", curves=pair))
    return PaperFigure(
        name="pmma_pressure", title="PMMA on silane, Sec. 10.1 (nu = 0.35)", panels=tuple(panels)
    )


def pyrex_spectra() -> PaperFigure:
    """Power spectrum of Pyrex before and after plastic smoothing."""
    before, after = s.pyrex(surfaces=2), smoothed_pyrex(4.0)
    q = np.geomspace(before.q_min, before.q_short, 200)
    rough = np.asarray(after.wavevectors)
    curves = (
        Curve(label="as cast", x=q, y=before(q)),
        Curve(label="smoothed by yielding at 20 MPa", x=rough, y=after(rough)),
    )
    panel = Panel(x="q [1/m]", y="C(q) [m^4]", curves=curves, x_scale="log", y_scale="log")
    return PaperFigure(name="pyrex_spectra", title="Pyrex, two surfaces, Sec. 10.2", panels=(panel,))


def pyrex_roughness() -> PaperFigure:
    """Area and macroscopic energy of Pyrex without load against roughness, before and after smoothing."""
    interface = Interface(work_of_adhesion=s.PYREX_WORK, energy="old")
    after = smoothed_pyrex(4.0)
    before_ratios = np.concatenate([np.linspace(0.2, 0.8, 5), np.linspace(0.86, 1.0, 8), [1.2]])
    pairs = (
        _sweep(
            lambda r: s.pyrex(r, surfaces=2), before_ratios, s.PYREX_MODULUS, interface, "original surface"
        ),
        _sweep(
            lambda r: after.scaled(r * r),
            np.linspace(0.2, 1.6, 12),
            s.PYREX_MODULUS,
            interface,
            "smoothed surface",
        ),
    )
    return PaperFigure(
        name="pyrex_roughness",
        title="Pyrex without load, Sec. 10.2 (C x 4, E = 32 GPa, energy of Eq. 43)",
        panels=(
            Panel(x="h / h_0", y="A(zeta_1) / A_0", curves=tuple(p[0] for p in pairs)),
            Panel(x="h / h_0", y="gamma_eff(1) / Delta gamma", curves=tuple(p[1] for p in pairs)),
        ),
    )


def pyrex_yielding() -> PaperFigure:
    """Elastic and plastic contact area of Pyrex at 20 MPa against magnification q / (1e6 1/m)."""
    spectrum = s.pyrex(surfaces=2)
    q = np.geomspace(spectrum.q_min * 1.001, spectrum.q_short, 240)
    variance = elastic.stress_variance(spectrum.m2(q), contact_modulus=s.PYREX_MODULUS)
    areas = constant_hardness(s.PYREX_PRESSURE, stress_variance=variance, yield_stress=s.PYREX_HARDNESS)
    plain = elastic.contact_area(s.PYREX_PRESSURE, stress_variance=variance)
    zeta = q / 1e6
    shown = areas.elastic > 1e-8
    return PaperFigure(
        name="pyrex_yielding",
        title="Pyrex at 20 MPa, sigma_Y = 6 GPa, Sec. 10.2",
        panels=(
            Panel(
                x="zeta",
                y="A_el / A_0",
                curves=(
                    Curve(label="infinite hardness", x=zeta, y=plain),
                    Curve(label="sigma_Y = 6 GPa", x=zeta[shown], y=areas.elastic[shown]),
                ),
                x_scale="log",
                y_scale="log",
            ),
            Panel(
                x="zeta",
                y="A_pl / A_0",
                curves=(Curve(label="sigma_Y = 6 GPa", x=zeta, y=areas.plastic),),
                x_scale="log",
            ),
        ),
    )


def coarse_grid() -> PaperFigure:
    """Exact stress distribution at G = 1, and the Gaussian cut at zero that carries the same load."""
    stress = np.linspace(0.0, 5.0, 300)
    exact = elastic.pressure_distribution(stress, pressure=1.0, stress_variance=2.0)
    gaussian = np.exp(-((stress - 1.0) ** 2) / 4) / math.sqrt(4 * math.pi)
    load = 0.5 * math.erfc(-0.5) + math.exp(-0.25) / math.sqrt(math.pi)
    return PaperFigure(
        name="coarse_grid",
        title="Too coarse a grid, Sec. 12 (G = 1)",
        panels=(
            Panel(
                x="sigma / sigma_0",
                y="P(sigma) sigma_0",
                curves=(
                    Curve(label="exact", x=stress, y=exact),
                    Curve(label="finite at sigma = 0, same load", x=stress, y=gaussian / load),
                ),
            ),
        ),
    )


def adhesive_spheres() -> PaperFigure:
    """Stress distribution in an adhesive contact of spheres and without adhesion."""
    stress = np.linspace(-0.35, 1.05, 400)
    contact = DoubleHertz(peak_pressure=1.0, tensile_limit=0.3, eta=1.1)
    curves = (
        Curve(label="sigma_a = 0.3 GPa, eta = 1.1", x=stress, y=contact.distribution(stress)),
        Curve(label="Hertz", x=stress, y=hertz_pressure_distribution(stress, peak_pressure=1.0)),
    )
    panel = Panel(x="sigma [GPa]", y="P(sigma) [1/GPa]", curves=curves)
    return PaperFigure(name="adhesive_spheres", title="Smooth spheres, App. B", panels=(panel,))


#: All calculated figures, in the order of the paper.
FIGURES: tuple[Callable[[], PaperFigure], ...] = (
    spectra,
    greenwood_williamson,
    polished_steel,
    macroasperities,
    elastoplastic,
    rim_roughness,
    rim_magnification,
    rim_pressure,
    pmma_pressure,
    pyrex_spectra,
    pyrex_roughness,
    pyrex_yielding,
    coarse_grid,
    adhesive_spheres,
)
