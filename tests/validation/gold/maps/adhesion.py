"""`adhesion` on the kit: one axis of cases in place of one variable for each dial."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from gold.maps import Look

__all__ = ["CHANGED", "NAMES"]

_DIALS = {
    "work": ("work", "work_ratio"),
    "reduced_pressure": ("load", "reduced_pressure"),
    "magnification": ("waves", "magnification"),
    "hardness": ("hardness", "hardness_ratio"),
}


def _at(dial: str, name: str) -> Look:
    return lambda d: d[name].isel(case=(d.varied == _DIALS[dial][0]).values)


def _standard_error(dial: str) -> Look:
    """Of the surfaces, and the step of each to its limit."""

    def found(data: xr.Dataset) -> Any:
        here = data.isel(case=(data.varied == _DIALS[dial][0]).values)
        scatter = here.area_each.std("surface", ddof=1) / here.sizes["surface"] ** 0.5
        return np.hypot(abs(here.area_each_drift).mean("surface"), scatter)

    return found


_NEW = {
    "area": "area",
    "plain": "area_plain",
    "improved": "area_improved",
    "old": "area_old",
    "persson_plain": "area_plain_persson",
    "interface": "interface_energy",
    "macroscopic": "interface_energy_improved",
    "macroscopic_old": "interface_energy_old",
    "yielded": "area_plastic",
    "yielded_persson": "area_plastic_improved",
}
NAMES: dict[str, Look] = {
    **{f"data.{old}_{dial}": _at(dial, new) for dial in _DIALS for old, new in _NEW.items()},
    **{f"data.{old}": _at("work", new) for old, new in _NEW.items()},
    **{f"data.area_{dial}_error": _standard_error(dial) for dial in _DIALS},
    **{f"data.{dial}": _at(dial, name) for dial, (_, name) in _DIALS.items()},
    **{f"figure.*.{dial}": _at(dial, name) for dial, (_, name) in _DIALS.items()},
    "data.area_error": _standard_error("work"),
    "data.reach": _at("work", "attraction_range"),
    "data@grids": "points",
    "data@surfaces": lambda d: d.sizes["surface"],
}
#: Some names of figures' numbers stand in the new dataset, too, for all cases.
NAMES |= {
    f"figure.*.{name.removeprefix('data.')}": look for name, look in NAMES.items() if name.startswith("data.")
}
CHANGED: dict[str, str] = {}
