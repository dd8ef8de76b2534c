"""`reference` on the kit: errors by source, and what figures showed in the dataset, of exact amplitudes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import xarray as xr

from gold.maps import Look
from gold.maps._estimates import Numbers
from gold.maps._ladders import part
from validation.measures.theory import VARIANTS
from validation.report.estimates import total_error

_AXES = ("amplitudes", "hurst", "bandwidth", "reduced_pressure")
#: New names by old.
_QUANTITIES = {
    "area": "area",
    "gap": "gap",
    "compliance": "compliance",
    "energy": "energy_ratio",
    "slope": "density_slope",
    "patches": "patch_density",
    "area_by_spectrum": "area_by_spectrum",
}


def _grid(name: str) -> Numbers:
    """What the grids leave, without what reading off between loads does."""

    def found(d: xr.Dataset) -> xr.DataArray:
        grid = part(name, "grid")(d)
        reading = d.get(f"{name}_reading")
        return grid if reading is None else (grid**2 - reading**2) ** 0.5

    return found


def _total(name: str) -> Numbers:
    def found(d: xr.Dataset) -> xr.DataArray:
        error = total_error(d, name)
        assert error is not None
        return error

    return found


def _of_quantity(old: str, new: str) -> dict[str, Numbers]:
    return {
        old: lambda d: d[new],
        f"{old}_half_width": part(new, "surfaces"),
        f"{old}_grid": _grid(new),
        f"{old}_error": _total(new),
        **({} if old == "area_by_spectrum" else {f"{old}_size": part(new, "size")}),
    }


_NUMBERS: dict[str, Numbers] = {
    "area_by_spectrum_reading": lambda d: d.area_by_spectrum_reading,
    "pairs": lambda d: d.pairs,
}
for _old, _new in _QUANTITIES.items():
    _NUMBERS |= _of_quantity(_old, _new)


def _exact(of: Numbers) -> Look:
    """Return what a figure showed: of exact amplitudes."""
    return lambda d: of(d).sel(amplitudes="exact")


def _rows(of: Callable[[xr.Dataset], xr.DataArray]) -> Look:
    """Return the rows of the table, of cells that were made."""

    def found(d: xr.Dataset) -> np.ndarray:
        area = d.area.transpose(*_AXES)
        values = of(d).broadcast_like(area).transpose(*_AXES).values
        return values[np.isfinite(area.values)]

    return found


def _percent(of: Numbers, name: str) -> Numbers:
    return lambda d: 100 * of(d) / d[name]


def _distances(d: xr.Dataset) -> xr.DataArray:
    exact = d.sel(amplitudes="exact")
    found = xr.concat([exact[f"theory_excess_{name}"] for name in VARIANTS], "theory")
    return found.transpose("theory", "reduced_pressure", "hurst", "bandwidth")


_TABLE: dict[str, Numbers] = {
    "H": lambda d: d.hurst,
    "lambda_long/lambda_short": lambda d: d.bandwidth,
    "p[*]": lambda d: d.reduced_pressure,
    "A/A0": lambda d: d.area,
    "+- total *": _percent(_total("area"), "area"),
    "+- surfaces *": _percent(part("area", "surfaces"), "area"),
    "+- grid *": _percent(_grid("area"), "area"),
    "kappa": lambda d: d.kappa,
    "gap/h_rms": lambda d: d.gap,
    "p0/(K h_rms)": lambda d: d.compliance,
    "U/U_full": lambda d: d.energy_ratio,
    "P'(0)": lambda d: d.density_slope,
    "patches": lambda d: d.patch_density,
    "A/A0 at p[*] by C(q)": lambda d: d.area_by_spectrum,
    "+- [[]%]": _percent(_total("area_by_spectrum"), "area_by_spectrum"),
    "A/Persson": lambda d: 1 + d.area_excess,
}
NAMES: dict[str, Look] = {
    **{f"data.{name}": of for name, of in _NUMBERS.items()},
    **{f"figure.reference.{name}": _exact(of) for name, of in _NUMBERS.items()},
    **{f"table.{title}": _rows(of) for title, of in _TABLE.items()},
    "figure.reference-verdict.distance": _distances,
    "figure.reference-alpha.area": "area_equal",
    "figure.reference-alpha.area_error": part("area_equal", "surfaces"),
    "figure.reference-alpha.bandwidth": "bandwidth_equal",
    "figure.reference-alpha.alpha": "nayak_equal",
}
CHANGED: dict[str, str] = {}
