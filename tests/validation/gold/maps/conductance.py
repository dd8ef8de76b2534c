"""`conductance` on the kit: variants of the theory are names in place of a dimension."""

from __future__ import annotations

import numpy as np

from gold.maps import Look
from validation.measures.theory import WITH_ENERGY

__all__ = ["CHANGED", "NAMES"]


def _rows(name: str) -> Look:
    return lambda d: d[name].transpose("periods", "load")


_TITLES = {"persson": "Persson", "yang_persson": "Yang, Persson 2008", "wang_mueser": "Wang, Mueser 2017"}
NAMES: dict[str, Look] = {
    "data.stiffness": "stiffness_each",
    "data.grid_error": lambda d: abs(d.stiffness_each_drift),
    "data.gap": "gap_each",
    "data.area": "area_perimeter_each",
    "data.exponent": "stiffness_exponent_each",
    "data.theory": lambda d: np.stack([d[f"stiffness_{v}"].values for v in WITH_ENERGY], axis=1),
    "data.step_pressure": "reduced_pressure_between",
    "data.variant": lambda d: list(WITH_ENERGY),
    "table.L/lambda_long": lambda d: np.repeat(d.periods.values, d.sizes["load"]),
    "table.p*": lambda d: np.tile(d.reduced_pressure.values, d.sizes["periods"]),
    "table.A/A0": _rows("area_perimeter"),
    "table.K h_rms/p0": _rows("stiffness"),
    "table.+- surfaces (95 %)": lambda d: d.stiffness_error.sel(source="surfaces"),
    "table.+- grid": lambda d: (d.stiffness_each_drift**2).mean("surface") ** 0.5,
    **{f"table.{title}": _rows(f"stiffness_{variant}") for variant, title in _TITLES.items()},
}
NAMES |= {f"figure.*{name[4:]}": look for name, look in NAMES.items() if name.startswith("data.")}
CHANGED: dict[str, str] = {}
