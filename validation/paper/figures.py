"""The calculated figures of Persson (2006) as numbers: which quantities on which axes, and their curves."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from persson import elastic
from persson.adhesion import Interface
from persson.asperities import nayak_asperities, ring_asperities
from persson.limits import ScalableSpectrum
from persson.spectrum import Moments, Spectrum
from persson.spheres import DoubleHertz, hertz_pressure_distribution
from validation.arrays import Array, padded
from validation.paper import systems as s
from validation.paper.pmma import rough_pmma
from validation.paper.pyrex import smoothed_pyrex
from validation.report.marks import Figure, Line, against

#: Curves by label, each with the values of its quantities.
Curves = Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True, kw_only=True)
class PaperFigure:
    """One figure of the paper."""

    name: str  # It tells its variables from those of others, as a qualifier of the registry
    title: str  # What it shows, with the choices made
    # Quantity along the axis, quantity up the axis, and which axes are logarithmic.
    panels: tuple[tuple[str, str, str], ...]
    curves: Callable[[], Curves]

    def compute(self) -> xr.Dataset:
        """Return its quantities over curve and point; NaN where a curve has no more."""
        curves = self.curves()
        dims = f"curve_{self.name}", f"point_{self.name}"
        names = dict.fromkeys(name for values in curves.values() for name in values)
        rows = padded(values.get(name, ()) for name in names for values in curves.values())
        tables = zip(names, rows.reshape(len(names), len(curves), -1), strict=True)
        made = {f"{name}_{self.name}": (dims, table) for name, table in tables}
        return xr.Dataset(made, coords={dims[0]: list(curves)})

    def declared(self) -> Figure:
        """Return what is drawn of them."""
        curve = f"curve_{self.name}"
        line: dict[str, Any] = {"by": curve, "label": f"{{{curve}}}", "look": {"marker": "", "lw": 1.6}}
        panels = [
            against(f"{x}_{self.name}", Line(f"{y}_{self.name}", **line), log=log)
            for x, y, log in self.panels
        ]
        return Figure(self.name.replace("_", "-"), f"{self.title}.", panels)


#: All calculated figures, in the order of the paper.
FIGURES: list[PaperFigure] = []


def _figure(title: str, *panels: tuple[str, str, str]) -> Callable[[Callable[[], Curves]], None]:
    """Add a `PaperFigure` of the function below, which returns its curves, by its name."""

    def added(curves: Callable[[], Curves]) -> None:
        name = curves.__name__.removeprefix("_")
        FIGURES.append(PaperFigure(name=name, title=title, panels=panels, curves=curves))

    return added


def _spectrum(spectrum: Spectrum, q: Array | None = None) -> Mapping[str, Array]:
    q = np.geomspace(spectrum.q_min, spectrum.q_short, 200) if q is None else q
    return {"wavevector": q, "power_spectrum": np.asarray(spectrum(q))}


@_figure("Power spectra, Sec. 2.2", ("wavevector", "power_spectrum", "xy"))
def _spectra() -> Curves:
    return {
        "polished steel, h_rms = 0.1 um": _spectrum(s.steel()),
        "PMMA, frozen capillary waves": _spectrum(s.pmma()),
    }


@_figure(
    "Greenwood-Williamson model, one wavelength, q_m = 600 1/m and q_m h_rms = 1, Sec. 3.2",
    ("load_modulus", "area", "xy"),
    ("load_modulus", "patch_mean", "xy"),
)
def _greenwood_williamson() -> Curves:
    q, curves = 600.0, {}
    for label, bumps in (
        ("estimates of Sec. 3.2", ring_asperities(q, rms_height=1 / q)),
        ("Nayak's relations", nayak_asperities(Moments(m0=1 / q**2, m2=1.0, m4=q**2))),
    ):
        contact = bumps.contact(bumps.rms_height * np.linspace(4.5, 0.0, 80), contact_modulus=1.0)
        load, area, patch = contact.pressure, contact.area, contact.patch_area
        curves[label] = {"load_modulus": load, "area": area, "patch_mean": patch}
    return curves


@_figure(
    "Polished steel, elastic, Sec. 3.4 (q_0 = 1e5 1/m chosen)",
    ("load_modulus", "area", "xy"),
    ("magnification", "area", "xy"),
)
def _polished_steel() -> Curves:
    load, zeta = np.geomspace(1e-4, 1.0, 120), np.geomspace(1.0, 1e5, 200)
    magnified = s.area(s.steel(), 1.0, 1e-3, zeta * 1e5)
    return {
        "full magnification": {"load_modulus": load, "area": s.area(s.steel(), 1.0, load)},
        "sigma_0 / E* = 0.001": {"magnification": zeta, "area": magnified},
    }


@_figure(
    "Macroasperities of polished steel at 10 MPa, Sec. 3.6 (smooth roll-off)",
    ("magnification", "area", "xy"),
    ("magnification", "area_bend", "x"),
)
def _macroasperities() -> Curves:
    x = np.linspace(math.log(0.05), math.log(1e4), 1200)
    area = s.area(s.steel(smooth=True), s.STEEL_MODULUS, s.STEEL_PRESSURE, 1e5 * np.exp(x))
    bend = np.gradient(np.gradient(np.log(area), x), x)
    # Differences at the ends are one-sided.
    bend[:2] = bend[-2:] = np.nan
    return {"polished steel": {"magnification": np.exp(x), "area": area, "area_bend": bend}}


@_figure(
    "Polished steel at 10 MPa with constant hardness, Sec. 6",
    ("magnification", "area_elastic", "xy"),
    ("magnification", "plastic_load_share", "x"),
)
def _elastoplastic() -> Curves:
    zeta, curves = np.geomspace(1.001, 1e5, 240), {}
    for hardness in (1e9, 2e9, 4e9, 8e9):
        areas = s.yielded(s.steel(), s.STEEL_MODULUS, s.STEEL_PRESSURE, hardness=hardness, q=1e5 * zeta)
        curves[f"sigma_Y = {hardness / 1e9:g} GPa"] = {
            "magnification": zeta,
            # Below 1e-12 the elastic area is of no use and only stretches the axis.
            "area_elastic": np.where(areas.elastic > 1e-12, areas.elastic, np.nan),
            "plastic_load_share": areas.plastic * hardness / s.STEEL_PRESSURE,
        }
    return curves


def _against_roughness(
    spectrum: ScalableSpectrum, ratios: Array, modulus: float, interface: Interface
) -> Mapping[str, Array]:
    answers = [s.adhesive(spectrum.scaled(r * r), modulus, 0.0, interface) for r in ratios.tolist()]
    return {
        "roughness_ratio": ratios,
        "area": np.array([f.real_area for f in answers]),
        "work_share": np.array([f.macroscopic_work for f in answers]) / interface.work_of_adhesion,
    }


@_figure(
    "Tire rim without load, Sec. 8.3",
    ("roughness_ratio", "area", ""),
    ("roughness_ratio", "work_share", ""),
)
def _rim_roughness() -> Curves:
    ratios = np.concatenate([np.linspace(0.05, 0.3, 4), np.linspace(0.34, 0.58, 9), [0.8, 1.0]])
    old, improved = (Interface(work_of_adhesion=s.RIM_WORK, energy=energy) for energy in ("old", "improved"))
    return {
        "old energy, Eq. 43": _against_roughness(s.rim(), ratios, s.RIM_MODULUS, old),
        "improved energy, Eqs. 44-50": _against_roughness(s.rim(), ratios, s.RIM_MODULUS, improved),
    }


@_figure(
    "Tire rim at 0.5 MPa, Sec. 8.3",
    ("magnification", "area", "x"),
    ("magnification", "work_share", "x"),
)
def _rim_magnification() -> Curves:
    curves: dict[str, Mapping[str, Any]] = {}
    named = {"old energy, Eq. 43": "old", "Eq. 48": "improved", "Eq. 50 as printed": "as_printed"}
    for label, energy in named.items():
        interface = Interface(work_of_adhesion=s.RIM_WORK, energy=energy)  # type: ignore[arg-type]
        answer = s.adhesive(s.rim(), s.RIM_MODULUS, s.RIM_PRESSURE, interface)
        zeta, share = answer.wavevectors / 1e5, answer.work / s.RIM_WORK
        curves[label] = {"magnification": zeta, "area": answer.area, "work_share": share}
    zeta = np.geomspace(1.0, 1e5, 150)
    area = s.area(s.rim(), s.RIM_MODULUS, s.RIM_PRESSURE, 1e5 * zeta)
    return {**curves, "without adhesion": {"magnification": zeta, "area": area}}


def _against_pressure(
    spectrum: Spectrum, modulus: float, interface: Interface, pressure: Array, *, label: str = ""
) -> Curves:
    """A/A0 at nominal pressures [Pa], with adhesion and without; the modulus is E* [Pa]."""
    adhesive = np.array([s.adhesive(spectrum, modulus, float(p), interface).real_area for p in pressure])
    plain = s.area(spectrum, modulus, pressure)
    return {
        f"with adhesion{label}": {"pressure_nominal": pressure, "area": adhesive},
        f"without adhesion{label}": {"pressure_nominal": pressure, "area": plain},
    }


@_figure("Tire rim, Sec. 8.3 (Eq. 50 as printed)", ("pressure_nominal", "area", ""))
def _rim_pressure() -> Curves:
    interface = Interface(work_of_adhesion=s.RIM_WORK, energy="as_printed")
    return _against_pressure(s.rim(), s.RIM_MODULUS, interface, np.linspace(0.02e6, 1.5e6, 20))


@_figure("PMMA on silane, Sec. 10.1 (nu = 0.35)", ("pressure_nominal", "area", ""))
def _pmma_pressure() -> Curves:
    interface = Interface(work_of_adhesion=s.PMMA_WORK, energy="as_printed")
    load = np.linspace(1e6, 100e6, 23)
    curves: dict[str, Mapping[str, Any]] = {}
    for words, rms in (("parameters as printed", None), ("C(q) scaled to 0.6 nm", 0.6)):
        curves |= _against_pressure(rough_pmma(rms), s.PMMA_MODULUS, interface, load, label=f", {words}")
    return curves


#: Of two equal surfaces, added coherently.
_PYREX = s.pyrex().scaled(4.0)


@_figure("Pyrex, two surfaces, Sec. 10.2", ("wavevector", "power_spectrum", "xy"))
def _pyrex_spectra() -> Curves:
    after = smoothed_pyrex()
    return {
        "as cast": _spectrum(_PYREX),
        "smoothed by yielding at 20 MPa": _spectrum(after, np.asarray(after.wavevectors)),
    }


@_figure(
    "Pyrex without load, Sec. 10.2 (C x 4, E = 32 GPa, energy of Eq. 43)",
    ("roughness_ratio", "area", ""),
    ("roughness_ratio", "work_share", ""),
)
def _pyrex_roughness() -> Curves:
    interface = Interface(work_of_adhesion=s.PYREX_WORK, energy="old")
    ratios = np.concatenate([np.linspace(0.2, 0.8, 5), np.linspace(0.86, 1.0, 8), [1.2]])
    made: dict[str, tuple[ScalableSpectrum, Array]] = {
        "original surface": (_PYREX, ratios),
        "smoothed surface": (smoothed_pyrex(), np.linspace(0.2, 1.6, 12)),
    }
    return {name: _against_roughness(*how, s.PYREX_MODULUS, interface) for name, how in made.items()}


@_figure(
    "Pyrex at 20 MPa, sigma_Y = 6 GPa, zeta = q / (1e6 1/m), Sec. 10.2",
    ("magnification", "area_elastic", "xy"),
    ("magnification", "area_plastic", "x"),
)
def _pyrex_yielding() -> Curves:
    q = np.geomspace(_PYREX.q_min * 1.001, _PYREX.q_short, 240)
    areas = s.yielded(_PYREX, s.PYREX_MODULUS, s.PYREX_PRESSURE, hardness=s.PYREX_HARDNESS, q=q)
    soft = s.area(_PYREX, s.PYREX_MODULUS, s.PYREX_PRESSURE, q)
    hard = np.where(areas.elastic > 1e-8, areas.elastic, np.nan)
    return {
        "infinite hardness": {"magnification": q / 1e6, "area_elastic": soft},
        "sigma_Y = 6 GPa": {"magnification": q / 1e6, "area_elastic": hard, "area_plastic": areas.plastic},
    }


@_figure("Too coarse a grid, Sec. 12 (G = 1)", ("stress_over_load", "density_over_load", ""))
def _coarse_grid() -> Curves:
    stress = np.linspace(0.0, 5.0, 300)
    exact = elastic.pressure_distribution(stress, pressure=1.0, stress_variance=2.0)
    # Cut at zero, and scaled to carry the same load.
    gaussian = np.exp(-((stress - 1.0) ** 2) / 4) / math.sqrt(4 * math.pi)
    load = 0.5 * math.erfc(-0.5) + math.exp(-0.25) / math.sqrt(math.pi)
    densities = {"exact": exact, "finite at sigma = 0, same load": gaussian / load}
    return {name: {"stress_over_load": stress, "density_over_load": d} for name, d in densities.items()}


@_figure(
    "Smooth spheres of 1 GPa at the centre, App. B",
    ("stress_local", "density_local", ""),
)
def _adhesive_spheres() -> Curves:
    stress = np.linspace(-0.35, 1.05, 400)
    contact = DoubleHertz(peak_pressure=1.0, tensile_limit=0.3, eta=1.1)
    densities = {
        "sigma_a = 0.3 GPa, eta = 1.1": contact.distribution(stress),
        "Hertz": hertz_pressure_distribution(stress, peak_pressure=1.0),
    }
    return {name: {"stress_local": 1e9 * stress, "density_local": d / 1e9} for name, d in densities.items()}
