"""`area` on the kit: intervals by source."""

from __future__ import annotations

import xarray as xr

from gold.maps import Look
from gold.maps._estimates import deviation, joined, surfaces_error


def _grids(d: xr.Dataset) -> str:
    solves = str(d.solve.values.ravel()[0]).split()
    return ", ".join(" x ".join(name.split("-")[1].split("x")) for name in solves)


NAMES: dict[str, Look] = {
    "*.area_error": joined("area"),
    "*.scatter_error": surfaces_error("area"),
    "*.grid_error": deviation("area"),
    "*.kappa_error": joined("kappa"),
    "*.persson": "area_persson",
    "*.persson_kappa": "kappa_persson",
    "*@surfaces": lambda d: d.sizes["surface"],
    "*@grids": _grids,
}
CHANGED: dict[str, str] = {}
