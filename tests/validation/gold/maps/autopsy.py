"""`autopsy` on the kit: raw sums of every ring keep their order, what was read off them are variables."""

from __future__ import annotations

import numpy as np

from gold.maps import Look
from validation.report.estimates import NORMAL

#: What is read off every ring, and off single ones (probes).
_SUMS = {
    "composed": "inflow_composed",
    "crossed": "pressure_cross_change",
    "crossed_once": "contact_crossed",
    "diffused": "area_diffused",
    "diffused_square": "bin_change_square",
    "drifted": "bin_change",
    "entered": "area_entered",
    "entered_load": "load_entered",
    "entered_square": "square_entered",
    "leaving": "bin_lost",
    "lost": "area_lost",
    "moved": "pressure_change",
    "nominal": "nominal",
    "out_at": "contact_out",
    "out_points": "points_out",
    "pressure": "bin_pressure",
    "returned": "points_returned",
    "spread": "pressure_change_square",
    "square": "mean_square",
    "square_change": "square_change",
    "touching": "bin_contact",
    "two_step": "inflow",
    "variance": "variance_share",
}
#: Means over the surfaces, with their intervals, along which dimensions figures had them.
_MEANS = {
    "budget.change": ("square_growth", ("octave", "hurst", "load")),
    "budget.diffusion": ("square_diffusion", ("octave", "hurst", "load")),
    "budget.drift": ("square_drift", ("octave", "hurst", "load")),
    "budget.re_entry": ("square_reentry", ("octave", "hurst", "load")),
    "budget.told": ("square_told", ("octave", "hurst", "load")),
    "budget.path": ("square_growth_path", ("octave", "hurst", "load")),
    "restarts.over_persson": ("area_ratio", ("hurst", "load", "level")),
    "restarts.restarted": ("area_diffused_ratio", ("octave", "hurst", "load", "level")),
    "fluxes.lost": ("share_lost", ("probe", "hurst", "load", "variance_step")),
    "fluxes.entered": ("share_entered", ("probe", "hurst", "load", "variance_step")),
    "fluxes.net": ("area_exponent_probe", ("probe", "hurst", "load", "variance_step")),
    "memory.returns": ("return_chance", ("hurst", "load", "age")),
}
_COLUMNS = {
    "d<p^2>/(A dV)": "square_growth",
    "D": "square_diffusion",
    "2 <mu p>": "square_drift",
    "re-entry": "square_reentry",
    "told by D(p), mu(p)": "square_told",
    "d ln A/d ln V": "area_exponent",
    "counted": "area_exponent_pixel",
    "Persson": "area_exponent_persson",
    "restarted loss over true": "loss_ratio",
    "A/Persson at its end": "area_ratio_end",
}
_WIDTHS = {
    "+- d<p^2>/(A dV) (95 %)": "square_growth",
    "+- d ln A/d ln V (95 %)": "area_exponent",
    "+- restarted loss over true (95 %)": "loss_ratio",
    "+- A/Persson (95 %)": "area_ratio_end",
}


def _signs(which: str, level: str, *, error: bool = False) -> Look:
    """With the ring and with its negative, along a dimension in front of the levels."""

    def values(d):
        parts = [d[f"{name}{which}_each{'_error' if error else ''}"] for name in ("area", "area_negative")]
        parts = [part.sel(source="grid") / NORMAL if error else part for part in parts]
        return np.stack([part.transpose(..., level).values for part in parts], axis=-2)

    return values


def _mean(name: str, dims: tuple[str, ...]) -> Look:
    return lambda d: d[name].transpose(*dims)


def _width(name: str, dims: tuple[str, ...]) -> Look:
    return lambda d: d[f"{name}_error"].sel(source="surfaces").transpose(*dims)


def _light(name: str) -> Look:
    """Of the load whose profiles were drawn, on the finest grid of single rings."""
    dims = ("probe", "hurst", "probe_surface", "variance_step", "bin")

    def values(d):
        load = int(np.argmin(np.abs(np.log(d.reduced_pressure.values / 0.05))))
        return d[f"{name}_probe_each"].isel(load=load, probe_grid=-1).transpose(*dims)

    return values


_CASES = ("hurst", "load", "octave")
NAMES: dict[str, Look] = {
    **{f"data.{old}": f"{new}_each" for old, new in _SUMS.items()},
    **{f"data.probe_{old}": f"{new}_probe_each" for old, new in _SUMS.items()},
    **{f"figure.{old}": _mean(*new) for old, new in _MEANS.items()},
    **{f"figure.{old}_half_width": _width(*new) for old, new in _MEANS.items()},
    **{f"figure.drift-and-diffusivity.probe_{old}": _light(_SUMS[old]) for old in _SUMS},
    **{f"table.{old}": _mean(new, _CASES) for old, new in _COLUMNS.items()},
    **{f"table.{old}": _width(new, _CASES) for old, new in _WIDTHS.items()},
    "data.area": _signs("", "level"),
    "data.area_error": _signs("", "level", error=True),
    "data.probe_area": _signs("_probe", "probe_level"),
    "data.probe_area_error": _signs("_probe", "probe_level", error=True),
    "data.spacing": "grid_spacing",
    "data.probe_spacing": "grid_spacing_probe",
    "data.slope": "slope_ratio",
    "data.slope_half_width": lambda d: (
        (d.slope_ratio_error.sel(source=["surfaces", "grid"]) ** 2).sum("source") ** 0.5
    ),
    "data.zeta": "magnification",
    "data.restart_zeta": "octave_start",
    "data.probe_zeta": lambda d: [float(words.partition("= ")[2]) for words in d.probe.values],
    "table.p*": lambda d: [p for _ in d.hurst for p in d.reduced_pressure.values for _ in d.octave],
    "table.H": lambda d: [h for h in d.hurst.values for _ in d.reduced_pressure for _ in d.octave],
    "figure.drift-and-diffusivity.reduced_pressure": lambda d: d.reduced_pressure.values[
        np.argmin(np.abs(np.log(d.reduced_pressure.values / 0.05)))
    ],
}
CHANGED: dict[str, str] = {
    "*@octaves": "octaves are a coordinate",
    "figure.budget.told_half_width": "scatter by rounding alone is none",
    "figure.budget.path_half_width": "scatter by rounding alone is none",
    "figure.restarts.restarted_half_width": "scatter by rounding alone is none",
}
