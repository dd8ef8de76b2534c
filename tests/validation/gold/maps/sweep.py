"""Sweeps: the numbers of their cases gathered over the swept keys."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from gold.maps import Look

__all__ = ["CHANGED", "NAMES"]

_NORMAL = 1.959963984540054


def _as_listed(data: xr.Dataset) -> xr.Dataset:
    """Return the cases in the order in which values of hardness were listed, from the hardest."""
    return data.sortby("hardness", ascending=False) if "hardness" in data.dims else data


def _case(name: str, scale: float = 1.0) -> Callable[[xr.Dataset], Any]:
    def look(data: xr.Dataset) -> Any:
        here = _as_listed(data)
        values = here[name].sel(source="grid", drop=True) if name.endswith("_error") else here[name]
        like = here["contact_modulus"]
        return scale * values.broadcast_like(like).transpose(*like.dims).values.ravel()

    return look


def _method(name: str) -> Callable[[xr.Dataset], Any]:
    def look(data: xr.Dataset) -> Any:
        here = _as_listed(data)
        return here[name].transpose("solver", *here.contact_modulus.dims).values.ravel()

    return look


def _points(data: xr.Dataset) -> Any:
    here = _as_listed(data)
    finest = here.points_per_wave.max("grid")
    return np.tile(finest.values.ravel(), here.sizes["solver"])


_OF_CASES: dict[str, Look] = {
    "A/A0 limit": _case("area_own"),
    "A/A0 +-": _case("area_own_error", 1 / _NORMAL),
    "A/A0 theory": _case("area_persson_own"),
    "A/A0 theory, C(q)": _case("area_ensemble"),
    "A_pl/A0 theory": _case("area_plastic_ensemble"),
    "kappa": lambda d: _case("area_own")(d) / _case("reduced_pressure")(d),
    "kappa +-": lambda d: _case("area_own_error", 1 / _NORMAL)(d) / _case("reduced_pressure")(d),
    "BEM A_pl/A0": _method("area_plastic_pixel_finest"),
    "BEM A/A0 perimeter": _method("area_perimeter_finest"),
    "BEM A/A0 pixel": _method("area_pixel_finest"),
    "p[*]": _case("reduced_pressure"),
    "p0 [[]Pa]": _case("pressure"),
    "pressure [[]Pa]": _case("pressure"),
    "hardness [[]Pa]": _case("hardness"),
    "hurst": _case("hurst"),
    "scatter of surfaces": _case("scatter"),
}

NAMES: dict[str, Look] = {
    **{f"{place}.{name}": look for place in ("summary.cases", "table") for name, look in _OF_CASES.items()},
    "data.area": _case("area_own"),
    "data.area_error": _case("area_own_error", 1 / _NORMAL),
    "data.kappa": _OF_CASES["kappa"],
    "data.kappa_error": _OF_CASES["kappa +-"],
    "data.contact_modulus": _case("contact_modulus"),
    "data.rms_gradient": _case("rms_gradient"),
    "data.reduced_pressure": _case("reduced_pressure"),
    "data.scatter": _case("scatter"),
    "data.theory": _case("area_persson_own"),
    "data.theory_ensemble": _case("area_ensemble"),
    "data.theory_plastic": _case("area_plastic_ensemble"),
    "data.theory_kappa": lambda d: (
        _case("area_persson_own")(d) / _case("reduced_pressure")(d)
        if "area_persson_own" in d
        else _case("kappa_ensemble")(d)
    ),
    "data.perimeter": _method("area_perimeter_finest"),
    "data.pixel": _method("area_pixel_finest"),
    "data.plastic": _method("area_plastic_pixel_finest"),
    "data.residual": _method("residual_finest"),
    "data.points_per_wave": _points,
    "data.hardness": lambda d: _as_listed(d).hardness,
    "summary.sweep.load.pressure": "pressure",
    "summary.sweep.load.reduced_pressure": "reduced_pressure",
    "summary.sweep.effects.hardness.hardness": lambda d: _as_listed(d).hardness,
    "summary.sweep.surface.hurst": "hurst",
}
_DRAWN = "figures show variables of the dataset, which are compared"
CHANGED: dict[str, str] = {
    "data.pixel_error": "intervals of 95 % by source stand beside every counted area",
    "data@layered": "both moduli are in the dataset",
    "figure.*": _DRAWN,
    "shown.*": "tables as they are read are made of those in files",
    "summary.cases.scatter*": "of the surfaces of an ensemble",
    "answers": "cards are made of values",
    "findings": "findings are data",
}
