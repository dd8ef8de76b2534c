"""A measurement as the studies use it: areas in the limit over its grids, what was counted, and paths of loads to full contact."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fem_contact.contact import ContactResult
from fem_contact.extrapolation import Limit
from validation.arrays import Grid
from validation.errors import UsageError
from validation.execution.bench import Bench
from validation.execution.press import Press
from validation.execution.solve import Solve
from validation.measurements.common import LEAST_POINTS_PER_WAVE
from validation.measurements.measurement import (
    PATCH_EDGES,
    STRESS_EDGES,
    area_limits,
    areas_of_solve,
    has_square_cells,
    limit_over,
)
from validation.measurements.statistics import distance_to_reference
from validation.report.estimates import NORMAL, derive, error_of, evaluated
from validation.scenes.problem import ContactProblem

Case = TypeVar("Case")
#: What was solved, by the places of the cases.
Measured = Mapping[Any, xr.Dataset]


def solved(bench: Bench, cases: Mapping[Case, Solve]) -> dict[Case, xr.Dataset]:
    """Solve cases on a bench, and return each dataset under the name of its case; it says which solve it is of."""
    results = bench.solve(cases.values())
    return {case: results[solve].assign_attrs(solve=solve.key) for case, solve in cases.items()}


def solve_of(result: xr.Dataset) -> dict[str, str]:
    """Return which solve a dataset is of, as an attribute of what is made of it."""
    return {name: key for name, key in result.attrs.items() if name == "solve"}


def read_off(result: xr.Dataset, **expressions: str) -> xr.Dataset:
    """Return what is taken of a solve: variables by expressions of what it keeps, as attributes or variables."""
    variables = {n: xr.DataArray(v) for n, v in result.attrs.items() if isinstance(v, int | float)}
    variables |= {str(n): result[n] for n in result.variables}
    data = xr.Dataset(attrs=solve_of(result))
    for name, expression in expressions.items():
        value = xr.DataArray(evaluated(expression, variables))
        # What was taken of one place has no coordinate of it.
        elsewhere = [n for n, c in value.coords.items() if c.dims != result[n].dims]
        data[name] = value.drop_vars(elsewhere).assign_attrs(reduction="read", expression=expression)
    return data


def stored_variables(result: xr.Dataset) -> xr.Dataset:
    """Return all that a solve keeps, where each variable says that it is read off."""
    return read_off(result, **{str(name): str(name) for name in result.data_vars})


def limits_of(measured: xr.Dataset, *, drift: bool = True) -> xr.Dataset:
    """Reduce what one of `press_on_grids` left to A/A0 over (load): its limit with the interval of the grids, and counts.

    ``area_each`` with its error, and its drift unless that is not wanted: the order of a fit is a
    systematic error; ``area_pixel_each`` (grid, load) and ``area_perimeter_each`` on the finest grid, means
    over the shifts.
    """
    value, error = area_limits(measured)
    plain = measured.drop_vars(["points", "cells"], errors="ignore")
    limit = xr.DataArray(value, dims="load", coords={"reduced_pressure": plain.reduced_pressure})
    read = read_off(
        plain,
        area_pixel_each="pixel.mean('shift')",
        area_perimeter_each="perimeter.isel(grid=-1).mean('shift')",
        rms_gradient_each="rms_gradient",
        nayak_each="nayak",
        seconds_each="seconds.sum()",
    )
    made: dict[str, Any] = {
        "area_each": limit.assign_attrs(reduction="limit", of="subcell"),
        "area_each_error": error_of(limit, grid=NORMAL * xr.DataArray(error, dims="load"), **ABSENT),
    }
    if drift:
        made["area_each_drift"] = "load", grid_drift(measured), {"reduction": "drift", "of": "subcell"}
    return xr.Dataset({**made, **read.data_vars}, attrs=read.attrs)


def shift_means(measured: xr.Dataset, **quantities: str) -> dict[Any, xr.DataArray]:
    """Return means over the sub-grid shifts, each as ``<name>_each`` of an expression of what solves keep."""
    means = {f"{name}_each": f"({of}).mean('shift')" for name, of in quantities.items()}
    return dict(read_off(measured, **means).data_vars)


def grid_drift(dataset: xr.Dataset) -> NDArray[np.float64]:
    """By how much the limit of one measurement moves without its coarsest resolved grid, for each load; signed.

    It does not average out over surfaces; it is 0 where too few grids are resolved to leave one out.
    """
    resolved = np.flatnonzero(dataset.points_per_wave.values >= LEAST_POINTS_PER_WAVE)
    if resolved.size < 3 or (resolved.size - 1) * dataset.sizes["shift"] < 3:
        return np.zeros(dataset.sizes["load"])
    whole, finer = (area_limits(dataset.isel(grid=grids))[0] for grids in (resolved, resolved[1:]))
    return np.asarray(finer - whole)


def solver_error(usual: xr.Dataset, strict: xr.Dataset) -> float:
    """Relative change of the limits of one surface when the residual of its solves is made smaller.

    The largest load counts. Less than one contact point on the finest grid cannot be seen, and counts as one.
    """
    first, second = area_limits(usual)[0], area_limits(strict)[0]
    point = 1 / float(usual.cells[-1]) / usual.sizes["shift"]
    return float(np.max(np.maximum(np.abs(first - second), point) / second))


def limit_of(solved: Mapping[Press, ContactResult]) -> xr.Dataset:
    """Reduce the fields of one surface at one load, coarse grid first, to A/A0 as `limits_of` does."""
    areas = [areas_of_solve(solve, result) for solve, result in solved.items()]
    data = limit_dataset(limit_over(areas), **ABSENT)
    data["area_each"].attrs |= {"reduction": "limit", "of": "fields"}
    data = data.assign(area_pixel_each=areas[-1].pixel, area_perimeter_each=areas[-1].perimeter)
    return data.assign_attrs(solve=" ".join(solve.key for solve in solved))


def limit_dataset(limit: Limit, name: str = "area", **absent: str) -> xr.Dataset:
    """Return a limit over grids as ``<name>_each`` with its interval, and why other sources do not enter."""
    value = xr.DataArray(limit.value)
    error = error_of(value, grid=NORMAL * limit.uncertainty, **absent)
    return xr.Dataset({f"{name}_each": value, f"{name}_each_error": error})


def resolved_grids(first: ContactProblem, grids: Sequence[Grid], *, located: bool) -> tuple[Grid, ...]:
    """Return the grids of at least 3 points per shortest wave.

    UsageError where they give no limit: two are needed where edges are `located` on square cells, else three.
    """
    fine = tuple(
        dict.fromkeys(grid for grid in grids if first.points_per_wave(grid) >= LEAST_POINTS_PER_WAVE)
    )
    located = located and all(has_square_cells(first, grid) for grid in grids)
    if len(fine) < (2 if located else 3):
        side = max(first.lengths) / first.shortest * LEAST_POINTS_PER_WAVE
        listed = ", ".join(f"{nx}" if nx == ny else f"{nx} x {ny}" for nx, ny in grids)
        raise UsageError(
            f"grids = {listed}: a limit needs {'two' if located else 'three'} grids of at least "
            f"{LEAST_POINTS_PER_WAVE:g} points per shortest wave; here that is {math.ceil(side - 1e-9)} or more along a side"
        )
    return fine


def straight_limit(
    data: xr.Dataset, *names: str, of: str = "pixel", x: str = "points", most: float | None = None
) -> xr.Dataset:
    """Add limits of what is linear in the spacing 1/x, as counted areas are: ``<name>_each`` from ``<name>_<of>_each``.

    They are those of the two finest grids; ``<name>_each_drift`` is how far each is from that of the two
    before, or from the finer grid where there are but two. A share cannot exceed `most`, nor be negative
    then.
    """
    for name in names:
        on = [f"{name}_{of}_each.isel(grid={k})" for k in (-1, -2, -3)]
        limit, coarser = (
            f"({on[k]} + ({on[k]} - {on[k + 1]}) / ({x}.isel(grid={-1 - k}) / {x}.isel(grid={-2 - k}) - 1))"
            for k in (0, 1)
        )
        coarser = coarser if data.sizes["grid"] > 2 else on[0]
        if most is not None:
            limit, coarser = (f"minimum(maximum({value}, 0), {most})" for value in (limit, coarser))
        data = derive(data, **{f"{name}_each": limit})
        data = derive(data, **{f"{name}_each_drift": f"{name}_each - {coarser}"})
    return data


def two_grid_step(values: xr.DataArray, spacing: xr.DataArray, *, order: int = 1) -> xr.DataArray:
    """Step from the finest grid to dx -> 0, by a straight line in a power of dx through the two finest grids.

    What is counted errs in the first power, energy and mean gap in the second or a higher one. There the
    step is the standard error of the limit: what remains is of higher order, and noise of where the edges
    fall. On 8 surfaces (H = .3, .8; p* = .01 to 1.5; truth from grids of 32 and 48 points per shortest wave)
    the errors of energy and gap are 1.1 times the one claimed, rms, from 4 to 16 points on.

    >>> import xarray as xr
    >>> values, spacing = (xr.DataArray(v, dims="grid") for v in ([1.04, 1.01], [1.0, 0.5]))
    >>> round(two_grid_step(values, spacing, order=2).item(), 12)
    -0.01
    """
    grid = str(spacing.dims[-1])
    coarse, fine = (spacing.isel({grid: k}, drop=True) ** order for k in (-2, -1))
    low, high = (values.isel({grid: k}, drop=True) for k in (-2, -1))
    return (high - low) * fine / (coarse - fine)


def two_grid_limit(values: xr.DataArray, spacing: xr.DataArray) -> xr.DataArray:
    """Value at dx -> 0 of what is counted, by a straight line in dx through the two finest grids."""
    return values.isel({str(spacing.dims[-1]): -1}, drop=True) + two_grid_step(values, spacing)


def value_at_zero(
    values: xr.DataArray, x: xr.DataArray, *, degree: int, places_more: int = 1
) -> xr.DataArray:
    """Value at x = 0 by a polynomial along the dimension of x; it has more places than coefficients, if more than two."""

    def fit(y: NDArray[np.float64], at: NDArray[np.float64]) -> float:
        most = min(degree, at.size - 1 - places_more) if at.size > 2 else 1
        return float(np.polyfit(at, y, most)[most])

    along = [str(x.dims[-1])]
    limit: xr.DataArray = xr.apply_ufunc(
        fit, values.drop_attrs(), x.drop_attrs(), input_core_dims=[along, along], vectorize=True
    )
    return limit


#: What no area of a plain half-space depends on.
ABSENT = {"depth": "boundary elements press a half-space", "theory": "it is simulated"}

#: Of the errors of energy and gap in the spacing, measured: 2 to 3; the smaller leaves more to the uncertainty.
_ORDER = 2
#: Relative area from which on light contact is dense enough to serve as reference for its distributions.
_REFERENCE_AREA = 0.015
#: Bins of P(sigma) that are drawn as one.
_COARSER = 4
#: What is distributed, and which share of what.
SHARES = {"stress": "stress_share", "patch_area": "patch_area_share", "patch_number": "patch_number_share"}


def reduced_path(measured: xr.Dataset, *, shortest: float) -> xr.Dataset:
    """Reduce a path that keeps distributions and stiffness to numbers over (load).

    The areas of `limits_of`; ``gap_each`` over h_rms and ``energy_ratio_each``, limits over the grids;
    ``compliance_each``, p0/(K h_rms), patches, and shares of the nominal area by pressure and patch size
    (load, bin) on the finest grid.
    """
    data, grids = limits_of(measured), ["points", "cells", "points_per_wave"]
    plain = measured.drop_vars(grids, errors="ignore")
    points = measured.points_per_wave.drop_vars(grids, errors="ignore")
    made: dict[str, Any] = shift_means(
        plain,
        gap_finest="mean_gap.isel(grid=-1) / rms_height",
        energy_ratio_finest="energy.isel(grid=-1) / full_contact_energy",
        compliance="(1 / stiffness).isel(grid=-1)",
        patches="patches.isel(grid=-1)",
        patch_size=f"patch_size.isel(grid=-1) / {float(shortest**2)!r}",
    )
    scaled = (("gap", "mean_gap", "rms_height"), ("energy_ratio", "energy", "full_contact_energy"))
    for name, of, scale in scaled:
        values = plain[of].mean("shift").drop_attrs() / measured.attrs[scale]
        step = two_grid_step(values, 1 / points, order=_ORDER)
        limit = values.isel(grid=-1, drop=True) + step
        made[f"{name}_each"] = limit.assign_attrs(reduction="second-order limit", of=of, scale=scale)
        made[f"{name}_each_error"] = error_of(limit, grid=NORMAL * abs(step), **ABSENT)
    # Which points are in contact makes it noisy: no power of the spacing is seen, and none is taken out.
    compliance = (1 / plain.stiffness).mean("shift")
    change = abs(compliance.isel(grid=-1) - compliance.isel(grid=-2))
    made["compliance_each_error"] = error_of(made["compliance_each"], grid=NORMAL * change, **ABSENT)
    for name, share in SHARES.items():
        shares = measured[f"{name}_profile"].isel(grid=-1, drop=True)
        how = {"reduction": "read", "expression": f"{name}_profile.isel(grid=-1)"}
        made[f"{share}_each"] = (("load", f"{name.partition('_')[0]}_bin"), shares.values, how)
    return data.assign(made).assign_coords(
        stress_upper=("stress_bin", STRESS_EDGES[1:]), patch_upper=("patch_bin", PATCH_EDGES[1:])
    )


def moved_shares(data: xr.Dataset) -> xr.Dataset:
    """Add how far P(sigma) and the patch sizes at every load are from those at the reference load.

    The reference is the lightest load whose contact is dense enough to compare distributions with; surfaces
    are pooled. ``moved_stress`` ... with the interval of resampled surfaces, ``_lower``, ``_upper``, and
    ``_noise``, the distance that two sets of as many surfaces have; ``_beyond`` is what exceeds that.
    """
    enough = np.flatnonzero(data.area.values >= _REFERENCE_AREA)
    reference = int(enough[0]) if enough.size else data.sizes["load"] - 1
    for name, share in SHARES.items():
        moved = distance_to_reference(data[f"{share}_each"].values, reference)
        value, noise = moved[""], moved["_noise"]
        # A bootstrap interval need not hold the value itself, nor 0, which a distance is never below.
        low, high = (np.maximum(part, 0.0) for part in (value - moved["_lower"], moved["_upper"] - value))
        half = np.where(value > 0, np.maximum(np.maximum(low, high), noise), 0.0)
        moved["_beyond"] = value - noise
        how = {"reduction": "distance", "of": f"{share}_each", "reference": reference}
        data = data.assign({f"moved_{name}{end}": ("load", of, how) for end, of in moved.items()})
        for end, error in (("", half), ("_beyond", low)):
            data[f"moved_{name}{end}_error"] = error_of(data[f"moved_{name}"], surfaces=error)
    return data.assign_attrs(reference_load=reference)


def pooled_shares(data: xr.Dataset) -> xr.Dataset:
    """Add P(sigma) per contact area, in wider bins, and the share of the contact in smaller patches.

    All surfaces are pooled: ``contact_stress_density`` (load, stress), ``patch_cumulated`` (load, patch_bin).
    """
    stress, patches = (data[f"{SHARES[name]}_each"].sum("surface") for name in ("stress", "patch_area"))
    coarse = STRESS_EDGES[::_COARSER]
    counted = np.add.reduceat(stress.values, np.arange(0, stress.shape[-1], _COARSER), axis=-1)
    density = counted / counted.sum(axis=-1, keepdims=True) / np.diff(coarse)
    smaller = patches.cumsum("patch_bin") / patches.sum("patch_bin")
    made = {"reduction": "pooled shares"}
    return data.assign(
        contact_stress_density=(("load", "stress"), density, {**made, "of": "stress_share_each"}),
        patch_cumulated=smaller.drop_attrs().assign_attrs({**made, "of": "patch_area_share_each"}),
    ).assign_coords(stress=("stress", (coarse[1:] + coarse[:-1]) / 2))
