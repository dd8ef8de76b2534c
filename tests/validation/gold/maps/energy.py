"""`energy` on the kit, on the path of loads of `pressure`."""

from __future__ import annotations

import numpy as np
import scipy.special
import xarray as xr

from gold.maps import Look
from gold.maps._estimates import deviation, grid_error, surfaces_error

#: The readings in their old order, by their new place.
_OLD = [0, 4, 5, 1, 2, 3, 6]
_QUANTITIES = ("energy_ratio", "gap", "compliance")


def _told(name: str) -> Look:
    return lambda d: d[f"{name}_predicted"].transpose("theory", "load")[_OLD]


def _rows(ending: str, source: str = "") -> Look:
    """All three quantities below each other, as the rows of the old table."""

    def found(d: xr.Dataset) -> np.ndarray:
        values = [d[f"{name}{ending}"] for name in _QUANTITIES]
        return np.concatenate([one.sel(source=source).values if source else one.values for one in values])

    return found


def _over(place: int) -> Look:
    return lambda d: np.concatenate([d[f"{n}_over"].isel(theory=place).values for n in _QUANTITIES])


def _scatter(d: xr.Dataset) -> np.ndarray:
    """Student's half widths, those of rounding included."""
    student = scipy.special.stdtrit(d.sizes["surface"] - 1, 0.975)
    return student * np.concatenate([surfaces_error(name)(d) for name in _QUANTITIES])


def _grid(d: xr.Dataset) -> np.ndarray:
    return 1.96 * np.concatenate([deviation(name)(d) for name in _QUANTITIES])


NAMES: dict[str, Look] = {
    "*.area": "area_each",
    "*.area_error": grid_error("area"),
    "*.energy": "energy_ratio_each",
    "*.energy_error": grid_error("energy_ratio"),
    "*.theory_energy": _told("energy_ratio"),
    "*.left_energy": "left_energy_ratio",
    "*.gap": "gap_each",
    "*.gap_error": grid_error("gap"),
    "*.theory_gap": _told("gap"),
    "*.compliance": "compliance_each",
    "*.compliance_error": grid_error("compliance"),
    "*.theory_compliance": _told("compliance"),
    "*.work": "work_check",
    "*.path_work": "path_work_check",
    "*.first_energy": "energy_ratio_first",
    "*.first_gap": "gap_first",
    "table.p[*]": lambda d: np.tile(d.reduced_pressure, 3),
    "table.A/A0": lambda d: np.tile(d.area, 3),
    "table.limit": _rows(""),
    "table.+- surfaces (95 %)": _scatter,
    "table.+- grid": _grid,
    "table.+- solver": _rows("_error", "solver"),
    "table.over Persson, Eq. 43": _over(0),
    "table.over Persson, Eq. 48": _over(4),
    "table.over Persson, Eq. 50": _over(5),
    "table.over Yang, Persson 2008": _over(1),
    "table.over Wang, Mueser 2017": _over(2),
    "table.over Xu et al. 2024": _over(3),
    "table.over Xu et al. 2024, hybrid": _over(6),
    "*@hurst": lambda d: d.attrs["hurst"],
    "*@periods": lambda d: d.attrs["periods"],
    "*@bandwidth": lambda d: d.attrs["bandwidth"],
    "*@surfaces": lambda d: d.sizes["surface"],
    "*@solver_tolerance": lambda d: d.attrs["solver_tolerance"],
}
CHANGED: dict[str, str] = {}
