"""`pressure` on the kit: gap and energy are limits over the grids, those of the finest are kept beside."""

from __future__ import annotations

import numpy as np
import xarray as xr

from gold.maps import Look
from gold.maps._estimates import Numbers, grid_error, per_load

__all__ = ["CHANGED", "NAMES", "change", "modes"]


def change(name: str) -> Numbers:
    """By how much a quantity moves between the two finest grids, of each surface."""

    def found(d: xr.Dataset) -> xr.DataArray:
        ratio = float(d.points_per_wave[-1] / d.points_per_wave[-2])
        return grid_error(name)(d) * (ratio**2 - 1)

    return found


def modes(name: str, *, silent: tuple[int, ...] = ()) -> Look:
    """What the theory and its variants say, told the surface and C(q) alone; some said nothing."""

    def found(d: xr.Dataset) -> np.ndarray:
        both = [d[f"{name}_{mode}"].transpose("theory", "load")[:4] for mode in ("predicted", "spectral")]
        values = np.array([one.values for one in both])
        values[:, list(silent)] = np.nan
        return values

    return found


def _gamma(d: xr.Dataset) -> np.ndarray:
    told = modes("gap", silent=(3,))
    assert callable(told)
    values = xr.DataArray(told(d), dims=("mode", "variant", "load"))
    return per_load(values, d).values


NAMES: dict[str, Look] = {
    "data.area": "area_each",
    "*.area_error": grid_error("area"),
    "data.area_drift": "area_each_drift",
    "data.pixel": lambda d: d.area_pixel_each.isel(grid=-1),
    "*.gap": "gap_finest_each",
    "*.energy": "energy_ratio_finest_each",
    "*.gamma": lambda d: per_load(d.gap_finest_each, d),
    "data.patches": "patches_each",
    "data.patch_size": "patch_size_each",
    "data.gap_error": change("gap"),
    "data.energy_error": change("energy_ratio"),
    "*.stress_share": "stress_share_each",
    "*.patch_area_share": "patch_area_share_each",
    "*.patch_number_share": "patch_number_share_each",
    "*.theory_area": modes("area"),
    "*.theory_energy": modes("energy_ratio", silent=(3,)),
    "*.theory_gap": modes("gap", silent=(3,)),
    "*.theory_gamma": _gamma,
    "table.A/A0 limit": "area",
    "table.+- (95 %)": lambda d: d.area_error.sel(source="surfaces"),
    "table.A/A0 Persson, conditional": "area_persson",
    "table.A/A0 Persson, ensemble": "area_ensemble",
    "table.gap/h_rms": lambda d: d.gap_finest_each.mean("surface"),
    "table.p0/(K h_rms)": lambda d: per_load(d.gap_finest_each.mean("surface"), d),
    # Three columns had this title; the last but one is what was kept.
    "table.Persson": lambda d: _gamma(d)[0, 0],
    "table.U/U_full": lambda d: d.energy_ratio_finest_each.mean("surface"),
    "table.Persson (Eq. 43)": lambda d: d.energy_ratio_predicted.isel(theory=0),
    "table.mean patch/lambda_short^2": "patch_size",
    "table.distance of the pressure distribution": "moved_stress",
    "table.distance of the patch size by area distribution": "moved_patch_area",
    "table.distance of the patch size by number distribution": "moved_patch_number",
    "figure.*@hurst": lambda d: d.attrs["hurst"],
    "figure.*@periods": lambda d: d.attrs["periods"],
    "figure.*@bandwidth": lambda d: d.attrs["bandwidth"],
}
CHANGED: dict[str, str] = {
    "data.energy_error": "a difference of ratios, not a ratio of differences: 3e-12 of it"
}
