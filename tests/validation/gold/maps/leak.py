"""`leak` on the kit: thresholds by phase, variants of the theory as names."""

from __future__ import annotations

import numpy as np
import xarray as xr

from gold.maps import Look
from validation.measures.flow import GAP_THEORIES

__all__ = ["CHANGED", "NAMES"]


def _threshold(phase: str) -> Look:
    return lambda d: d.percolation_area_axis_each.sel(phase=phase)


def _rows(name: str) -> Look:
    return lambda d: d[name].transpose("bandwidth", "asked")


_AXES = {
    "balance": "balance",
    "closed": "closed",
    "conductance": "gap_conductance",
    "constriction": "constriction",
    "effective_medium": "gap_conductance_bruggeman",
    "located": "area_located",
}
NAMES: dict[str, Look] = {
    **{f"data.{old}": f"{new}_axis_each" for old, new in _AXES.items()},
    "data.contact_threshold": _threshold("contact"),
    "data.gap_threshold": _threshold("gap"),
    "data.gap_density": "gap_density_each",
    "data.reduced_pressure": "reduced_pressure_each",
    "data.area": "area_asked",
    "data.theory_density": lambda d: np.stack([d[f"gap_density_{n}_each"].values for n in GAP_THEORIES]),
    "data.gap": "local_gap",
    "data.variant": lambda d: ["Persson", "Yang, Persson 2008"],
    "table.lambda_long/lambda_short": lambda d: np.repeat(d.bandwidth.values, d.sizes["asked"]),
    "table.A/A0": lambda d: np.tile(d.area_asked.values, d.sizes["bandwidth"]),
    "table.K/gap^3": _rows("gap_conductance"),
    "table.+- (95 %)": lambda d: d.gap_conductance_error.sel(source="surfaces"),
    "table.Bruggeman": _rows("gap_conductance_bruggeman"),
    "table.K/Bruggeman": _rows("gap_conductance_ratio"),
    "table.u_c^3/12": _rows("gap_conductance_constriction"),
    "table.closed [[]%[]]": lambda d: 100 * xr.DataArray(d.closed),
}
NAMES |= {f"figure.*{name[4:]}": look for name, look in NAMES.items() if name.startswith("data.")}
CHANGED: dict[str, str] = {}
