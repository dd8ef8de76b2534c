"""`hurst` on the kit: spectra are families of Hurst exponents; ladders are in `_ladders`."""

from __future__ import annotations

import xarray as xr

from gold.maps import Look
from gold.maps._estimates import Numbers, grid_error
from gold.maps._ladders import LADDERS, budget, grid_two, part


def _named(name: str) -> Numbers:
    return lambda d: d[name]


def _spectra(of: Numbers) -> Look:
    """Return numbers by spectrum: all Hurst exponents of a family after each other."""
    return lambda d: _both(of(d), d).stack(spectrum=("family", "hurst"))


def _both(values: xr.DataArray, d: xr.Dataset) -> xr.DataArray:
    return values.broadcast_like(d.kappa.isel(load=0, drop=True))


def _rows(of: Numbers) -> Look:
    """Return numbers by spectrum and load."""
    return lambda d: of(d).broadcast_like(d.kappa).transpose(*d.kappa.dims).values.ravel()


def _kappa(what: str) -> dict[str, Look]:
    return {f"data.{what}": _spectra(_named(f"{what}_each"))}


_TABLE: dict[str, Numbers] = {
    "table.H": _named("hurst"),
    "table.lambda_long/lambda_short": _named("bandwidth"),
    "table.Nayak*": _named("nayak"),
    "table.p?": _named("reduced_pressure"),
    "table.kappa limit": _named("kappa"),
    "table.+- (95 %, surfaces)": part("kappa", "surfaces"),
    "table.+- (95 %, grid)": grid_two("kappa"),
    "table.counted at lambda_short*": lambda d: d.kappa_pixel.isel(grid=-1),
    "table.counted at ?": lambda d: d.kappa_pixel.isel(grid=0),
    "table.Persson, conditional": _named("kappa_persson"),
    "table.Persson, ensemble": _named("kappa_ensemble"),
    "table.Yang, Persson 2008": _named("kappa_yang_persson"),
    "table.Wang, Mueser 2017": _named("kappa_wang_mueser"),
    "table.Xu et al. 2024": _named("kappa_xu"),
    "budget.value": _named("kappa"),
}


def _budget(*, ladders: bool) -> dict[str, Look]:
    return {f"budget.{title} *": _rows(of) for title, of in budget("kappa", ladders=ladders).items()}


NAMES: dict[str, Look] = {
    **_kappa("kappa"),
    **_kappa("kappa_pixel"),
    **_kappa("kappa_perimeter"),
    **_kappa("kappa_ensemble"),
    **_kappa("nayak"),
    "data.kappa_grid_error": _spectra(grid_error("kappa")),
    "data.kappa_grid_drift": _spectra(_named("kappa_each_drift")),
    "data.hurst": _spectra(_named("hurst")),
    "data.bandwidth": _spectra(_named("bandwidth")),
    "data.family": _spectra(_named("family")),
    "data.solver_error": lambda d: (part("kappa", "solver")(d) / d.kappa).values.flat[0],
    **{title: _rows(of) for title, of in _TABLE.items()},
}
CHANGED: dict[str, str] = {}
CASES: dict[str, tuple[dict[str, Look], dict[str, str]]] = {
    "hurst": ({**LADDERS, **_budget(ladders=True)}, {}),
    "hurst of equal Nayak parameter": (
        _budget(ladders=False),
        {"*@ladder_reduced_pressure": "there are no ladders"},
    ),
}
