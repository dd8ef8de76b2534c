"""`refinement` on the kit: areas of surfaces are `_each`, blocks have names of their own."""

from __future__ import annotations

import numpy as np
import xarray as xr

from gold.maps import Look
from gold.maps._estimates import Numbers, grid_error
from gold.maps._ladders import LADDERS, budget, grid_two, part
from validation.report.estimates import NORMAL


def _named(name: str) -> Numbers:
    return lambda d: d[name]


def _rows(of: Numbers, blocks: Numbers | None = None) -> Look:
    """Return numbers of all grids, then those of the finite elements; NaN where they have none."""

    def found(d: xr.Dataset) -> np.ndarray:
        more = d.sizes["element"] * d.sizes["fem_grid"] if "element" in d.dims else 0
        those = blocks(d).values.ravel() if more and blocks else np.full(more, np.nan)
        return np.concatenate([of(d).values.ravel(), those])

    return found


def _distance(name: str, *, blocks: bool) -> dict[str, Look]:
    """Distances from the limit in per cent, and the intervals that the surfaces leave."""
    new = {"subcell": "located"}.get(name, name)

    def both(of: str, source: str = "") -> Numbers:
        return lambda d: 100 * (part(of, source)(d) if source else d[of])

    own, fem = f"distance_{new}", f"distance_fem_{new}"
    return {
        f"table.{name} - limit *": _rows(both(own), both(fem) if blocks else None),
        f"table.{name} +- *": _rows(both(own, "surfaces"), both(fem, "surfaces") if blocks else None),
    }


def _cells(k: int) -> Look:
    return _rows(lambda d: d.cells_at_part.isel(part=k))


def _grid_of_blocks(d: xr.Dataset) -> xr.DataArray:
    """What the grids of the blocks leave, with two standard errors, and how far both limits are apart."""
    random = grid_two("kappa_fem")(d)
    return (random**2 + (d.distance_fem * d.kappa_fem) ** 2) ** 0.5


def _budget(*, ladders: bool = False, blocks: bool = False) -> dict[str, Look]:
    """Rows of the boundary elements and of the blocks."""
    own = budget("kappa", ladders=ladders)
    fem = budget("kappa_fem", grid=_grid_of_blocks, depth=True) if blocks else {}
    return {
        "budget.value": lambda d: np.append(d.kappa.values, d.kappa_fem.values if blocks else []),
        **{f"budget.{title} *": _pair(own.get(title), fem.get(title)) for title in own | fem},
    }


def _pair(own: Numbers | None, fem: Numbers | None) -> Look:
    return lambda d: np.append(own(d).values if own else np.nan, fem(d).values if fem else [])


NAMES: dict[str, Look] = {
    **{f"data.{name}": f"area_{name}_each" for name in ("pixel", "perimeter")},
    "data.subcell": "area_located_each",
    "data.limit": "area_each",
    "data.limit_error": grid_error("area"),
    "data.limit_drift": "area_each_drift",
    **{
        f"data.{name}": f"{name}_each"
        for name in (
            "density_at_zero",
            "patches",
            "cells_per_patch",
            "edge_fraction",
            "residual",
            "first_moment",
        )
    },
    "data.density": "stress_density",
    "data.cells": "cells_at_part_each",
    "data.kappa_grid_scale": "kappa_protocol_each",
    "data.protocol_points": "points_protocol",
    "data.solver_error": lambda d: part("kappa", "solver")(d) / d.kappa,
    "data.ensemble": lambda d: d.area_ensemble_each.mean("surface"),
    "data.theory": "area_persson",
    **{f"data.fem_{name}": f"area_fem_{name}_each" for name in ("pixel", "perimeter")},
    "data.fem_limit": "area_fem_each",
    "data.fem_limit_error": lambda d: d.area_fem_each_error.sel(source="grid", drop=True) / NORMAL,
    "data.fem_solver_error": lambda d: part("kappa_fem", "solver")(d) / d.kappa_fem,
    "data.fem_points_per_wave": "points_per_wave_fem",
    "data.depth_error": "depth_share",
    "data@reduced_pressure": "reduced_pressure",
    # Without effects the theory has a P(sigma).
    "data@bare": lambda d: float(d.stress_density_persson.notnull().any()),
    "table.lambda_short/dx": _rows(_named("points_per_wave"), _named("points_per_wave_fem")),
    "table.cells in the median patch": _rows(_named("cells_per_patch")),
    "table.kappa, counted *": _rows(_named("kappa_pixel"), _named("kappa_fem_pixel")),
    **_distance("pixel", blocks=True),
    **_distance("perimeter", blocks=True),
    **_distance("subcell", blocks=False),
    "table.first moment / p0": _rows(_named("first_moment")),
    "table.P(0+) E?h'": _rows(_named("density_at_zero")),
    "table.patches": _rows(_named("patches")),
    **{f"table.cells at {share} % of the area": _cells(k) for k, share in enumerate((10, 50, 90))},
}
CHANGED: dict[str, str] = {}
CASES: dict[str, tuple[dict[str, Look], dict[str, str]]] = {
    "refinement": (_budget(blocks=True), {}),
    "refinement on a scene": (_budget(), {}),
    "refinement with ladders": ({**LADDERS, **_budget(ladders=True)}, {}),
}
