"""Runs of scenes, and the theory alone: one dataset over method, grid, shift and surface."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from scipy.special import stdtrit

from gold.maps import Look

__all__ = ["CASES", "CHANGED", "NAMES"]

#: Half width of a 95 % interval over a standard error.
_NORMAL = 1.959963984540054


def _solved(data: xr.Dataset) -> xr.DataArray:
    return data.area_pixel.stack(row=("solver", "grid")).dropna("row").row


def _rows(name: str, scale: float = 1.0) -> Callable[[xr.Dataset], Any]:
    """Read a variable in the order of the old rows: every method on its grids."""

    def look(data: xr.Dataset) -> Any:
        values = data[name] if name in data else xr.full_like(data.area_pixel, np.nan)
        values = values.broadcast_like(data.area_pixel).stack(row=("solver", "grid"))
        return scale * values.sel(row=_solved(data)).values

    return look


def _standard_error(data: xr.Dataset) -> Any:
    """Return the standard error over shifts, of which the interval is Student's."""
    half = _rows("area_pixel_error")(data.assign(area_pixel_error=data.area_pixel_error.sel(source="grid")))
    count = _rows("shifts")(data)
    return half / stdtrit(np.maximum(count - 1, 1), 0.975)


def _sides(k: int) -> Callable[[xr.Dataset], Any]:
    return lambda data: [int(str(grid).split(" x ")[k]) for grid in _solved(data).grid.values]


def _grids(data: xr.Dataset) -> Any:
    return [n for grid in _solved(data).grid.values for n in map(int, str(grid).split(" x "))]


def _source(name: str, source: str = "grid") -> Callable[[xr.Dataset], Any]:
    return lambda data: data[f"{name}_error"].sel(source=source).values / _NORMAL


def _flat(name: str) -> Callable[[xr.Dataset], Any]:
    def look(data: xr.Dataset) -> Any:
        values = data[name].values.ravel()
        there = np.isfinite(np.broadcast_to(data.magnification, data.magnified_area.shape)).ravel()
        return values[there]

    return look


def _pressures(data: xr.Dataset) -> Any:
    there = (
        data.pressure.broadcast_like(data.magnification).where(data.magnification.notnull()).values.ravel()
    )
    return there[np.isfinite(there)]


def _cost(data: xr.Dataset) -> Any:
    each = [_rows(f"area_{name}_off")(data) for name in ("pixel", "perimeter")]
    return np.stack(each, axis=-1).ravel()


def _passing(read: Callable[[xr.Dataset, str], float]) -> Callable[[xr.Dataset], Any]:
    names = ("electrical_conductance", "thermal_conductance", "leak_rate_x", "leak_rate_y")
    return lambda data: [read(data, name) for name in names if name in data]


def _theory_of(data: xr.Dataset, name: str) -> float:
    return next(float(data[f"{name}_{who}"]) for who in ("persson", "bruggeman") if f"{name}_{who}" in data)


def _crossed(name: str) -> Callable[[xr.Dataset], Any]:
    def look(data: xr.Dataset) -> Any:
        return data[f"{name}_difference"].stack(row=("solver", "grid")).dropna("row").values

    return look


def _crossed_on(name: str) -> Callable[[xr.Dataset], Any]:
    def look(data: xr.Dataset) -> Any:
        there = data.pressure_difference.stack(row=("solver", "grid")).dropna("row").row
        if name == "grid":
            return [n for grid in there.grid.values for n in map(int, str(grid).split(" x "))]
        return (
            data[name].broadcast_like(data.pressure_difference).stack(row=("solver", "grid")).sel(row=there)
        )

    return look


_OF_ROWS = {
    "points_per_wave": _rows("points_per_wave"),
    "solves": _rows("shifts"),
    "pixel": _rows("area_pixel"),
    "pixel_scatter": _standard_error,
    "pixel_error": _standard_error,
    "perimeter": _rows("area_perimeter"),
    "kappa": _rows("kappa_perimeter"),
    "density_at_zero": _rows("density_at_zero"),
    "residual": _rows("residual"),
    "unknowns": _rows("unknowns"),
    "plastic": _rows("area_plastic_pixel"),
    "spacing": _rows("spacing"),
    "nx": _sides(0),
    "ny": _sides(1),
    "grid": _grids,
}

NAMES: dict[str, Look] = {
    "summary.pressure_Pa": "pressure",
    "summary.reduced_pressure": "reduced_pressure",
    "summary.contact_modulus_Pa": "contact_modulus",
    "summary.realised.rms_height_m": "rms_height",
    "summary.realised.rms_gradient": "rms_gradient",
    "summary.realised.nayak": "nayak",
    "summary.continuum.rms_height_m": "rms_height_spectrum",
    "summary.continuum.rms_gradient": "rms_gradient_spectrum",
    "summary.spectrum.rms_height_m": "rms_height",
    "summary.spectrum.rms_gradient": "rms_gradient_spectrum",
    "summary.cross_checks.grid": _crossed_on("grid"),
    "summary.cross_checks.points_per_wave": _crossed_on("points_per_wave"),
    "summary.cross_checks.pressure": _crossed("pressure"),
    "summary.cross_checks.pixel": _crossed("area_pixel"),
    "summary.cross_checks.perimeter": _crossed("area_perimeter"),
    "summary.limit.value": "area_own",
    "summary.limit.uncertainty": _source("area_own"),
    "summary.theory.area": "area_persson_own",
    "summary.theory.ensemble_area": "area_ensemble",
    "summary.theory.stress_variance": lambda d: d.stress_variance * d.contact_modulus**2,
    "summary.theory.plastic": lambda d: d.get("area_plastic_persson", xr.DataArray(np.nan)),
    "summary.theory.other": lambda d: d.get("area_other_energy", xr.DataArray(np.nan)),
    "summary.scatter.areas": "area_each",
    "summary.scatter.ratios": lambda d: d.get("area_ratio_each", d.get("area_each")),
    "summary.scatter.grid_error": lambda d: (
        float(((d.area_each_error.sel(source="grid") / d.area_each / _NORMAL) ** 2).mean()) ** 0.5
    ),
    "summary.below.von_mises": _rows("von_mises"),
    "summary.below.depth": _rows("von_mises_depth"),
    "summary.below.place": lambda d: np.stack(
        [_rows("von_mises_x")(d), _rows("von_mises_y")(d)], axis=-1
    ).ravel(),
    "summary.below.grid": _grids,
    "summary.quantities.value": _passing(lambda d, n: float(d[n])),
    "summary.quantities.grid_error": _passing(lambda d, n: float(d[f"{n}_error"].sel(source="grid"))),
    "summary.quantities.theory": _passing(_theory_of),
    "figure.area@limit": "area_own",
    "figure.area@limit_error": _source("area_own"),
    "figure.area@persson": "area_persson_own",
    "figure.area@persson_from_spectrum": "area_ensemble",
    "figure.cost.error": _cost,
    "figure.below@lambda_short": "wave_short",
    "figure.below@unit": "pressure_scale",
    "figure.below.depth": lambda d: np.nan_to_num(d.plane_depth[0] * d.wave_short),
    "figure.below.largest": lambda d: d.plane_stress_largest[0] * d.pressure_scale,
    "figure.below.rms": lambda d: d.plane_stress_rms[0] * d.pressure_scale,
    "figure.*@stress_unit_Pa": "pressure_scale",
    **{
        f"figure.{name}-against-magnification.{x}": look
        for name in ("area", "energy")
        for x, look in (("pressure", _pressures), ("magnification", _flat("magnification")))
    },
    "figure.cost.nx": lambda d: np.repeat(_sides(0)(d), 2),
    "figure.cost.ny": lambda d: np.repeat(_sides(1)(d), 2),
    "figure.area-against-magnification.area": _flat("magnified_area"),
    "figure.energy-against-magnification.work": _flat("magnified_work"),
    "summary.answers.pressure_Pa": "pressure",
    "summary.answers.reduced_pressure": "reduced_pressure",
    "summary.answers.area": "area_ensemble",
    "summary.answers.plastic": lambda d: d.get("area_plastic_ensemble", np.nan * d.pressure),
    "summary.answers.macroscopic_work_J_m2": lambda d: d.get("work_left", np.nan * d.pressure),
    "summary.answers.error_estimate": "error_estimate",
    **{
        f"{place}.{name}": look
        for place in ("summary.rows", "table", "figure.area")
        for name, look in _OF_ROWS.items()
    },
}

_COUNTED = "counts of what is listed beside, or words among numbers"
_BINS = "all curves of a figure have the same bins"
CHANGED: dict[str, str] = {
    "summary.limit.edge_constant": "the fitted excess of a limit, which is shown nowhere",
    "summary.limit.grids": _COUNTED,
    "summary.quantities.scatter": "surfaces have values of their own, over which the interval is",
    "summary.quantities.surfaces": _COUNTED,
    "summary.quantities.grid": _COUNTED,
    "summary.theory": "is there or is not, field by field",
    "summary.scatter": "is there or is not, field by field",
    "summary.limit": "is there or is not, field by field",
    "summary.continuum": "is there or is not, field by field",
    "summary.cross_checks": "is there or is not, field by field",
    "summary.treatment": _COUNTED,
    "figure.pressure-at-zero.*": _BINS,
    "figure.pressure-distribution.*": _BINS,
    "figure.pressure-maps.*": "maps stand on cell centres, over x and y",
    "figure.area-against-magnification.area_plastic": "where nothing can yield no yielded area is drawn",
    "figure.*@[a-oq-z]*": "attributes are those of the dataset",
    "shown.*": "tables as they are read are made of those in files",
    "areas.*": "in the dataset at every digit",
    "magnification.*": "in the dataset at every digit",
    "answers": "cards are made of values",
    "findings": "findings are data",
}

_CLAIMED = {
    "summary.limit.uncertainty": "a run to an accuracy shows what it claims",
    "figure.area@limit_error": "a run to an accuracy shows what it claims",
}
CASES: dict[str, tuple[dict[str, Look], dict[str, str]]] = {"scene to an accuracy": ({}, _CLAIMED)}
