"""A measurement as the studies use it: areas of one surface in the limit over its grids, and what was counted."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from validation.measures.budget import grid_drift
from validation.measures.measurement import area_limits
from validation.report.estimates import NORMAL, error_of
from validation.solves.bench import Bench
from validation.solves.solve import Solve

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["limits_of", "solved"]

Case = TypeVar("Case")


def solved(bench: Bench, cases: Mapping[Case, Solve]) -> dict[Case, xr.Dataset]:
    """Solve cases on a bench, and return each dataset under the name of its case; it says which solve it is of."""
    results = bench.solve(cases.values())
    return {case: results[solve].assign_attrs(solve=solve.key) for case, solve in cases.items()}


def limits_of(measured: xr.Dataset, *, drift: bool = True) -> xr.Dataset:
    """Reduce one `Measurement` to A/A0 over (load): its limit with the 95 % interval of the grids, and counts.

    Parameters
    ----------
    measured : xarray.Dataset
    drift : bool
        Whether the limit without the coarsest grid is taken, too: the order of a fit is a systematic error.

    Returns
    -------
    xarray.Dataset
        ``area_each`` with its error and drift, ``area_pixel_each`` (grid, load) and ``area_perimeter_each`` on the
        finest grid, means over the shifts; p* is a coordinate.
    """
    import xarray as xr

    value, error = area_limits(measured)
    plain = measured.drop_vars(["points", "cells"], errors="ignore")
    limit = xr.DataArray(value, dims="load", coords={"reduced_pressure": plain.reduced_pressure})
    made: dict[str, Any] = {
        "area_each": limit.assign_attrs(reduction="limit", of="subcell"),
        "area_each_error": error_of(limit, grid=NORMAL * xr.DataArray(error, dims="load"), **_ABSENT),
        "area_pixel_each": plain.pixel.mean("shift").assign_attrs(reduction="shift mean", of="pixel"),
        "area_perimeter_each": plain.perimeter.isel(grid=-1, drop=True)
        .mean("shift")
        .assign_attrs(reduction="shift mean", of="perimeter"),
        "rms_gradient_each": measured.attrs["rms_gradient"],
        "nayak_each": measured.attrs["nayak"],
        "seconds_each": plain.seconds.sum(),
    }
    if drift:
        made["area_each_drift"] = ("load", grid_drift(measured), {"reduction": "drift", "of": "subcell"})
    data = xr.Dataset(made)
    kept = {name: measured.attrs[name] for name in ("solve",) if name in measured.attrs}
    return data.assign_attrs(kept)


#: What no area of a plain half-space depends on.
_ABSENT = {"depth": "boundary elements press a half-space", "theory": "it is simulated"}
