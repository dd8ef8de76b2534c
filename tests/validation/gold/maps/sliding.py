"""`sliding` on the kit: shares of the energy and variants of the theory are names in place of dimensions."""

from __future__ import annotations

import numpy as np
import xarray as xr

from gold.maps import Look
from validation.measures.sliding import SHARES
from validation.measures.theory import VARIANTS

__all__ = ["CHANGED", "NAMES"]


def _rms(difference: xr.DataArray) -> xr.DataArray:
    return (difference**2).mean("surface") ** 0.5


_TITLES = {"persson": "Persson", "yang_persson": "Yang, Persson 2008"}
_TITLES |= {"wang_mueser": "Wang, Mueser 2017", "xu": "Xu et al. 2024"}
NAMES: dict[str, Look] = {
    "data.area": "area_grid_each",
    "data.friction": "friction_grid_each",
    "data.dissipation": "friction_dissipated_grid_each",
    **{f"data.{name}": f"{name}_each" for name in ("contraction", "fft_pairs", "residual", "steps")},
    "data.theory": lambda d: np.stack([d[f"friction_{name}_each"].values for name in SHARES]),
    "data.theory_area": lambda d: np.stack([d[f"area_{name}_each"].values for name in VARIANTS]),
    "data.memory": "modulus_passing",
    "data.v": "velocity",
    "data.share": lambda d: list(SHARES.values()),
    "data.variant": lambda d: list(VARIANTS),
    "table.v [[]m/s[]]": "velocity",
    "table.mu/h'_rms": "friction",
    "table.+- surfaces (95 %)": lambda d: d.friction_error.sel(source="surfaces"),
    "table.+- grid": lambda d: _rms(d.friction_each_drift),
    "table.by dissipation": "friction_dissipated",
    "table.Persson, S = 1": "friction_full_energy",
    "table.S = 1/2 + P^2/2": "friction_half_energy",
    "table.A/A0": "area",
    "table.+- surfaces (95 %) ": lambda d: d.area_error.sel(source="surfaces"),
    "table.+- grid ": lambda d: _rms(d.area_each_drift),
    **{f"table.{title}": f"area_{name}" for name, title in _TITLES.items()},
}
NAMES |= {f"figure.*{name[4:]}": look for name, look in NAMES.items() if name.startswith("data.")}
CHANGED: dict[str, str] = {}
