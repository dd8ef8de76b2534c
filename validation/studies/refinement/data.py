"""From the measurements of the study `refinement` to its dataset."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.area import ContactAreas
from fem_contact.extrapolation import limit_area
from validation.measures.budget import grid_drift
from validation.measures.common import named
from validation.measures.distributions import PATCH_EDGES, STRESS_EDGES, weighted_percentile
from validation.measures.measurement import area_limits, limit_over
from validation.measures.side_by_side import areas_by_method

if TYPE_CHECKING:
    import xarray as xr

    from validation.scenes.realised import Realised
    from validation.studies._scene import Asked

__all__ = ["AREAS", "finite_elements", "on_grids", "other_methods", "overestimate"]

AREAS = ("pixel", "perimeter", "subcell")

#: Parts of the contact area at which patch sizes are read: newborn patches are one cell on every grid, and count little.
_PARTS = (0.1, 0.5, 0.9)


def overestimate(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return the relative distance of an area from the limit of its own surface, (surface, grid)."""
    return dataset[name] / dataset["limit"] - 1


def on_grids(measured: Sequence[xr.Dataset]) -> xr.Dataset:
    """Areas, moments of P(sigma), patches and limits of the boundary elements."""
    import xarray as xr

    names = (*AREAS, "density_at_zero", "patches", "cells_per_patch", "edge_fraction", "residual")
    first = [d.isel(load=0) for d in measured]
    data: dict[str, Any] = {
        name: (("surface", "grid"), np.array([d[name].mean("shift").values for d in first])) for name in names
    }
    data["seconds"] = (("surface", "grid"), np.array([d.seconds.sum("shift").values for d in first]))
    data["first_moment"] = named(
        ("surface", "grid"),
        np.array([d.load_profile.sum("load_bin").values for d in first]),
        "first moment of P(sigma) over p0",
    )
    width = float(np.diff(STRESS_EDGES)[0])
    data["density"] = named(
        ("grid", "stress_bin"),
        np.mean([d.stress_profile.values for d in first], axis=0) / width,
        "P(sigma) E* h'_rms per nominal area, mean over surfaces",
    )
    cells = [
        [
            [weighted_percentile(row, PATCH_EDGES, part) * per_wave**2 for part in _PARTS]
            for row, per_wave in zip(d.patch_area_profile.values, d.points_per_wave.values, strict=True)
        ]
        for d in first
    ]
    data["cells"] = named(
        ("surface", "grid", "part"),
        np.array(cells),
        "cells of the patch below which a part of the contact area lies",
    )
    limits = [area_limits(d) for d in measured]
    data["limit"] = (("surface",), np.array([value[0] for value, _ in limits]))
    data["limit_error"] = (("surface",), np.array([error[0] for _, error in limits]))
    data["limit_drift"] = (("surface",), np.array([grid_drift(d)[0] for d in measured]))
    return xr.Dataset(
        data,
        coords={
            "points_per_wave": named("grid", measured[0].points_per_wave.values, "lambda_short / dx"),
            "points": ("grid", measured[0].points.values),
            "stress": named("stress_bin", (STRESS_EDGES[1:] + STRESS_EDGES[:-1]) / 2, "sigma / (E* h'_rms)"),
            "part": ("part", list(_PARTS)),
        },
    )


def finite_elements(
    fem: Mapping[tuple[str, int, float], xr.Dataset],
    elements: tuple[str, ...],
    per_wave: tuple[float, ...],
    *,
    surfaces: int,
) -> xr.Dataset:
    """Areas of the finite elements on every grid, their limit, and what the finite depth does to the area.

    Parameters
    ----------
    fem : mapping
        Results by element, number of the surface, and points per wave.
    elements, per_wave, surfaces
        Which of them there are.
    """
    import xarray as xr

    from fem_contact.block import ELEMENTS

    shape = (len(elements), surfaces, len(per_wave))
    fields = {
        name: np.array(
            [[[float(fem[e, k, n][name]) for n in per_wave] for k in range(surfaces)] for e in elements]
        )
        for name in ("pixel", "perimeter", "pixel_bem", "pixel_layer")
    }
    limit, error = np.empty(shape[:2]), np.empty(shape[:2])
    for e, k in itertools.product(range(shape[0]), range(surfaces)):
        constant = ELEMENTS[elements[e]].edge_constant
        areas = [
            ContactAreas(
                pixel=pixel,
                perimeter=perimeter,
                edge_length=np.nan,
                edge_fraction=(pixel - perimeter) / constant,
                edge_constant=constant,
                spacing=(1 / n, 1 / n),
            )
            for pixel, perimeter, n in zip(
                fields["pixel"][e, k], fields["perimeter"][e, k], per_wave, strict=True
            )
        ]
        found = limit_area(areas)
        limit[e, k], error[e, k] = found.value, found.uncertainty
    # On the finest grid, where one node is least.
    depth = np.abs(fields["pixel_layer"] / fields["pixel_bem"] - 1)[..., -1].mean()
    dims = ("element", "surface", "fem_grid")
    return xr.Dataset(
        {
            "fem_pixel": named(dims, fields["pixel"], "A/A0, contact nodes counted"),
            "fem_perimeter": named(dims, fields["perimeter"], "A/A0, with the element's edge constant"),
            "fem_limit": named(dims[:2], limit, "A/A0, limit over the grids of the element"),
            "fem_limit_error": named(dims[:2], error, "standard error of that limit"),
            "depth_error": named((), depth, "relative change of the area by a layer as deep as the block"),
        },
        coords={"element": list(elements), "fem_points_per_wave": ("fem_grid", list(per_wave))},
    )


#: What is kept of the other methods, and what it is.
_OTHER = {
    "pixel": "A/A0, contact points counted, by another method",
    "perimeter": "A/A0, with its edge constant, by another method",
    "subcell": "A/A0, edge located inside the cells, by another method",
    "residual": "largest contact residual of another method",
    "converged": "1 where its residuals are what it was asked for",
    "seconds": "processor time of another method [s]",
}


def other_methods(
    answers: Mapping[tuple[str, int, int], xr.Dataset],
    others: Sequence[Asked],
    *,
    first: Realised,
    surfaces: int,
) -> xr.Dataset:
    """Areas of other methods on every grid, and their limits where their grids allow one.

    Parameters
    ----------
    answers : mapping
        By name of the method, number of the surface, and number of the grid.
    others : sequence of Asked
    first : Realised
        The first surface.
    surfaces : int
    """
    import xarray as xr

    cases = [(asked, g) for asked in others for g in range(len(asked.grids))]
    rows = {
        name: [[float(answers[asked.name, k, g][name]) for k in range(surfaces)] for asked, g in cases]
        for name in _OTHER
    }
    limits = [[_limit(answers, asked, k) for k in range(surfaces)] for asked in others]
    grids = [asked.grids[g] for asked, g in cases]
    data: dict[str, Any] = {
        f"other_{name}": named(("case", "surface"), np.array(values), _OTHER[name])
        for name, values in rows.items()
    }
    found = np.array(limits).reshape(len(others), surfaces, 2)
    data["other_limit"] = named(("other_method", "surface"), found[..., 0], "its limit over grids")
    data["other_limit_error"] = named(("other_method", "surface"), found[..., 1], "standard error")
    return xr.Dataset(
        data,
        coords={
            "other": ("case", [asked.name for asked, _ in cases]),
            "other_grid": ("case", [f"{nx} x {ny}" for nx, ny in grids]),
            "other_points_per_wave": ("case", [first.points_per_wave(grid) for grid in grids]),
            "other_method": [asked.name for asked in others],
        },
    )


def _limit(answers: Mapping[tuple[str, int, int], xr.Dataset], asked: Asked, k: int) -> tuple[float, float]:
    """Limit of the area over the grids of a method and its standard error; NaN where they are too few."""
    areas = [areas_by_method(answers[asked.name, k, g], grid) for g, grid in enumerate(asked.grids)]
    spacings = {area.spacing for area in areas}
    located = all(area.subcell is not None for area in areas)
    if len(spacings) < 2 or (not located and len(areas) < 3):
        return float("nan"), float("nan")
    found = limit_over(areas)
    return found.value, found.uncertainty
