"""What follows from the areas of a scene: how methods differ, what came close, the contact in numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr

from fem_contact.extrapolation import LEAST_CONTACT_POINTS
from validation.arrays import Array
from validation.comparison.reductions import Case, Reading, grid_name, is_adhesive
from validation.effects.base import ContactModel
from validation.measurements.statistics import order_of_convergence, relative_distance
from validation.report.estimates import derive, error_of, gather
from validation.solvers import find_method

#: Within which relative distance from the limit the cheapest solve is looked for.
_CLOSE = 0.01
_SIMULATED = {"theory": "it is simulated"}


def beside_each_other(data: xr.Dataset, readings: Sequence[Reading]) -> xr.Dataset:
    """Put every other method beside the first, on the grids they share; how differences shrink with dx."""
    methods, grids = data.solver.values.tolist(), data.grid.values.tolist()
    if len(methods) < 2:
        return data
    still = {(r.solve.method, r.solve.grid): r for r in readings if r.pressure is not None}
    names = [f"{name}_difference" for name in ("pressure", "area_pixel", "area_perimeter")]
    # The first method is not beside itself; where all others failed, nothing else says what is asked.
    cases = {(methods[0], grids[0]): xr.Dataset(dict.fromkeys(names, math.nan))}
    for (method, grid), reading in still.items():
        first = still.get((methods[0], grid))
        if first is None or method == methods[0]:
            continue
        assert reading.pressure is not None
        assert first.pressure is not None
        values = (
            relative_distance(reading.pressure, first.pressure),
            reading.areas.pixel / first.areas.pixel - 1,
            reading.areas.perimeter / first.areas.perimeter - 1,
        )
        cases[method, grid_name(grid)] = xr.Dataset(dict(zip(names, values, strict=True)))
    data = data.assign(gather(cases, solver=methods, grid=grids).data_vars)
    for name in names[:2]:
        made = {"reduction": "order", "of": name}
        orders = [_order(data.spacing.values, row) for row in np.abs(data[name].values)]
        data[f"{name}_order"] = ("solver", orders, made)
    return data


def _order(spacing: Array, values: Array) -> float:
    """Power of dx with which something shrinks, where three grids tell."""
    known = np.isfinite(values) & (values > 0)
    return order_of_convergence(spacing[known], values[known]) if known.sum() > 2 else math.nan


def cost_and_orders(data: xr.Dataset) -> xr.Dataset:
    """Add how far every area is from the limit, what it took to come close, and how P(0+) falls with dx."""
    limit = float(data.area_own) if str(data.no_limit.item()) == "" else math.nan
    if not 0 < limit < 1 - 1e-12:
        limit = math.nan
    for name in ("pixel", "perimeter"):
        data[f"area_{name}_off"] = data[f"area_{name}"] / limit - 1
        data[f"deviation_{name}"] = np.maximum(abs(data[f"area_{name}_off"]), 1e-6)
    if "area_persson_own" in data:
        data["deviation_persson"] = np.maximum(abs(data.area_persson_own / limit - 1), 1e-6)
    data["seconds_total"] = data.seconds.sum()
    data["unknowns_largest"] = data.unknowns.max()
    ways = {"perimeter": "corrected at its edge", "pixel": "points counted"}
    near = xr.concat([abs(data[f"area_{way}_off"]) <= _CLOSE for way in ways], "way").transpose(..., "way")
    seconds = data.seconds.where(near & (data.resolved > 0))
    if bool(seconds.notnull().any()):
        at = seconds.argmin(["solver", "grid", "way"])
        way, here = list(ways)[int(at.pop("way"))], data.isel(at)
        data = data.assign(
            cheapest=f"{find_method(str(here.solver.item())).label} on {here.grid.item()}, {ways[way]}",
            seconds_cheapest=float(here.seconds),
            area_cheapest_off=float(here[f"area_{way}_off"]),
        )
    first = data.isel(solver=0)
    cells = np.array([math.prod(map(int, str(g).split(" x "))) for g in data.grid.values])
    enough = (data.resolved.values > 0) & (first.area_pixel.values * cells >= LEAST_CONTACT_POINTS)
    density = np.where(enough, first.density_at_zero.values, math.nan)
    return data.assign(density_at_zero_order=_order(data.spacing.values, density))


def finest_of(data: xr.Dataset) -> xr.Dataset:
    """Add what every method says on its finest resolved grid, or on its finest where none resolves."""
    names = {"area_pixel", "area_perimeter", "area_plastic_pixel", "residual"} & set(data)
    chosen = []
    for solved in data.area_pixel.notnull().values:
        resolved = np.flatnonzero(solved & (data.resolved.values > 0))
        candidates = resolved if resolved.size else np.flatnonzero(solved)
        # A method that failed on every grid has NaN on the last one, too.
        chosen.append(int(candidates[-1]) if candidates.size else -1)
    at = xr.DataArray(chosen, dims="solver")
    values = {f"{name}_finest": data[name].isel(grid=at).drop_vars("grid") for name in sorted(names)}
    return data.assign({**values, "grid_finest": ("solver", data.grid.values[chosen])})


def in_numbers(data: xr.Dataset, case: Case) -> xr.Dataset:
    """Add what one asks of a contact, on the finest resolved grid of the first method."""
    from fem_contact.conductance import frozen_contact
    from fem_contact.patches import find_patches

    solves, height = case.ladder(case.own[0].solve.method)[-2:], case.problem.field.rms_height
    results = [case.results[solve] for solve in solves]
    rows = [
        {
            "mean_gap": float(np.mean(result.gap)),
            "approach": -result.offset,
            "largest_pressure": float(result.pressure.max()),
            "patches": float(find_patches(result.in_contact, result.spacing).count),
        }
        for result in results
    ]
    last, result = solves[-1], results[-1]
    some = bool(result.in_contact.any()) and not bool(result.in_contact.all())
    # The stiffness of a contact set is exact where points weigh alike on an elastic response.
    if some and result.weights is None and not is_adhesive(last.effects) and not last.solver.sinks:
        response = ContactModel.filled(last.problem.elastic, last.effects).felt_response
        for row, result in zip(rows, results, strict=True):
            stiffness = frozen_contact(result, response, tolerance=1e-6).stiffness
            row["stiffness"] = stiffness * height / result.mean_pressure
    for name, value in rows[-1].items():
        data[name] = xr.DataArray(value)
        change = abs(value - rows[0][name]) if len(rows) > 1 else math.nan
        data[f"{name}_error"] = error_of(data[name], grid=change, **_SIMULATED)
    if height > 0:
        data = derive(data, gap="mean_gap / rms_height")
    return derive(data, contact_area="area_own * nominal_area")
