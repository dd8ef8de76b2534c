"""`hardness` on the kit: one axis of cases in place of a variable for loads and one for waves."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from gold.maps import Look

__all__ = ["CHANGED", "NAMES"]


def _at(varied: str, name: str) -> Look:
    def found(data: xr.Dataset) -> Any:
        here = data[name].isel(case=(data.varied == varied).values)
        return here.isel(grid=-1) if "grid" in here.dims else here

    return found


def _standard_error(varied: str, name: str) -> Look:
    """Of the surfaces, and the step of each to its limit."""

    def found(data: xr.Dataset) -> Any:
        here = data.isel(case=(data.varied == varied).values)
        each, steps = here[f"{name}_each"], abs(here[f"{name}_each_drift"]).mean("surface")
        return np.hypot(steps, each.std("surface", ddof=1) / each.sizes["surface"] ** 0.5)

    return found


_ENDS = {"": "", "_finest": "_pixel", "_persson": "_persson"}
NAMES: dict[str, Look] = {
    f"data.{part}{grown}{end}": _at(varied, f"area_{part}{now}")
    for part in ("plastic", "elastic")
    for grown, varied in (("", "load"), ("_grown", "waves"))
    for end, now in _ENDS.items()
}
NAMES |= {
    f"data.{part}{grown}_error": _standard_error(varied, f"area_{part}")
    for part in ("plastic", "elastic")
    for grown, varied in (("", "load"), ("_grown", "waves"))
}
NAMES |= {
    "data.kept": "spectrum_kept",
    "data.kept_persson": "spectrum_kept_persson",
    "data.reduced_pressure": _at("load", "reduced_pressure"),
    "data.magnification": _at("waves", "magnification"),
    "figure.*.reduced_pressure": _at("load", "reduced_pressure"),
    "figure.*.magnification": _at("waves", "magnification"),
    "data@surfaces": lambda d: d.sizes["surface"],
    "data@gradient_kept_inside": "gradient_kept",
}
CHANGED: dict[str, str] = {}
