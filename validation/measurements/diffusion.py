"""What the budgets of rings say of the diffusion equation: limits over grids, octave by octave, step by step.

Names are those of the registry; every function takes the dataset of a chain or of single rings (``_probe``) over
(hurst, load, surface, grid, ...) and adds to it, surface by surface.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np
import xarray as xr

from persson import elastic
from validation.execution.bench import Bench
from validation.execution.measurement import Call
from validation.measurements.limits import ABSENT, solved, stored_variables, two_grid_limit, value_at_zero
from validation.measurements.measurement import AREAS, area_limits
from validation.report.estimates import NORMAL, bare, claim, derive, error_of, mean, ratio_of_means
from validation.report.places import gather, nearest

#: d ln A / d ln V of the theory from which on the contact is not full.
TOUCHED = -0.05
#: How near 1/2 an exponent is called so.
HALF = 0.03
#: A relative change of the area too small to be compared with another.
_NO_LOSS = 1e-3

#: p/sqrt(V) away from the edge of the contact, and at it (edges of bins).
_AWAY, _EDGE = (0.735, 2.94), (0.06, 0.135)
#: Magnification from which on waves are short.
_LATE = 4.0

SQUARE_TERMS = ("square_growth", "square_diffusion", "square_drift", "square_reentry")
_OF_CHAINS = (
    *("area", "area_persson", "area_ratio", "area_ratio_end", "area_exponent", "area_exponent_pixel"),
    "area_exponent_persson",
    *("square_told", "square_growth_path", "square_difference", "loss_ratio", "area_diffused_ratio"),
    *("area_ratio_diffused", "inflow_share", "inflow_share_composed", "inflow_excess", "return_chance"),
    *("crossed_share", "out_share", "exponent_ratio", "exponent_ratio_late"),
    *(*SQUARE_TERMS, *(f"{name}_late" for name in SQUARE_TERMS)),
)
_FLOWS = {
    "share_lost": "area_lost",
    "share_entered": "area_entered",
    "share_load_entered": "load_entered",
    "share_square_entered": "square_entered",
}
_OF_PROBES = (
    *("area_probe", "area_exponent_probe", "edge_loss", "load_taken", "entered_ratio", "entered_ratio_limit"),
    *("power_local", "power_limit", *_FLOWS, *(f"power_{name}" for name in _FLOWS), "pressure_slope"),
    *("mean_drift_away", "mean_drift_edge", "diffusivity_away", "diffusivity_edge"),
)


def budgets_of(bench: Bench, cases: Mapping[tuple[float, float, int, float], Call], *dims: str) -> xr.Dataset:
    """Solve chains, or probes, and put them together along (hurst, load, surface, grid).

    Limits over the grids stand in the place of the areas on each: ``area_each``, and ``area_negative_each`` with the
    negative ring.
    """
    read = {}
    for place, measured in solved(bench, cases).items():
        problem, points = cases[place]["problem"], cases[place]["points"]
        # The ring of a probe is a little shorter than the waves there are.
        zeta = dict(cases[place].arguments).get("magnification")
        shortest = problem.shortest if zeta is None else problem.longest / zeta
        read[place] = stored_variables(measured).assign_coords(
            points=points, cells=points**2, points_per_wave=points * shortest / problem.lengths[0]
        )
    data = gather(read, *dims)
    others = [str(dim) for dim in data.pixel.dims if dim != "grid"]
    flat = {n: data[n].transpose("grid", *others).values for n in AREAS}
    areas = xr.Dataset(
        {n: (("grid", "shift", "load"), a.reshape(len(a), 1, -1)) for n, a in flat.items()},
        coords={n: data[n] for n in ("points", "cells", "points_per_wave")},
    )
    like = data.pixel.isel(grid=0, drop=True).transpose(*others)
    parts = (*area_limits(areas), area_limits(areas.isel(grid=slice(None, -1)))[0])
    value, error, coarser = (
        like.copy(data=part.reshape(like.shape)).drop_vars(["load", "surface"]) for part in parts
    )
    data = data.drop_vars([*AREAS, *areas.coords, "load", "surface"])
    data = data.rename({str(name): f"{name}_each" for name in data.data_vars if name != "solve"})
    for k, name in enumerate(("area_each", "area_negative_each")):
        limit = value.isel(sign=k, drop=True)
        data[name] = limit.assign_attrs(reduction="limit", of="subcell")
        data[f"{name}_error"] = error_of(limit, grid=NORMAL * error.isel(sign=k, drop=True))
        data[f"coarser_{name}"] = coarser.isel(sign=k, drop=True)
    return data.assign(grid_spacing=("grid", 1 / areas.points_per_wave.values))


def with_diffusion_terms(data: xr.Dataset) -> xr.Dataset:
    """Add what the budgets say, surface by surface, and means over the surfaces.

    The grids' share of a mean is how far it moves without the finest grid.
    Coordinates are ``magnification`` (level), ``octave_start`` (octave), ``relative_step`` (variance_step) and
    ``upper`` (bin), edges in units of sqrt(V).
    """
    # As a coordinate it would follow levels that become steps, pairs or octaves.
    data = data.reset_coords("magnification")
    coarse_areas = [name for name in map(str, data.data_vars) if name.startswith("coarser_")]
    coarser = _terms(_without_finest(data, coarse_areas))
    data = _terms(data.drop_vars(coarse_areas))
    names = (f"{name}_each" for name in (*_OF_CHAINS, *_OF_PROBES))
    # Areas have an error of the grids already, P'(0) a drift.
    moved = [n for n in names if not {f"{n}_error", f"{n}_drift"} & set(data.data_vars)]
    data = _added(data, **{f"{name}_drift": coarser[name] - data[name] for name in moved})
    data = mean(data, *_OF_CHAINS)
    data = mean(data, *_OF_PROBES, over="probe_surface")
    # Both sides of a budget are of the same surfaces: their gap has no interval of its own.
    closed = abs(data.area_exponent_pixel / data.area_exponent - 1)
    data = _added(
        data,
        square_gap=abs(data.square_told / data.square_growth - 1).max(),
        area_gap=closed.where(data.area_exponent_persson < TOUCHED),
    )
    data = derive(data, power_excess=f"(power_limit - 0.5) / {HALF}")
    return _with_slopes(data).set_coords("magnification")


def _terms(data: xr.Dataset) -> xr.Dataset:
    """Add all budgets, in this order: restarts read what the area budget adds."""
    for add in (
        _with_square_budget,
        _with_area_budget,
        _with_restarts,
        _with_memory,
        _with_flows,
        _with_profiles,
    ):
        data = add(data)
    return data


def _without_finest(data: xr.Dataset, coarse_areas: list[str]) -> xr.Dataset:
    """Return what there is without the finest grids; a single one that is left stands for its own limit."""
    data = data.assign({name.removeprefix("coarser_"): data[name] for name in coarse_areas})
    for grid, spacing in (("grid", "grid_spacing"), ("probe_grid", "grid_spacing_probe")):
        single = data.sizes[grid] == 2
        left = data.isel({grid: [0, 0] if single else slice(None, -1)})
        data = left.assign({spacing: data[spacing]}) if single else left
    return data.drop_vars(coarse_areas)


def _late(values: xr.DataArray, data: xr.Dataset) -> xr.DataArray:
    """Mean over the octaves of short waves, or of the last."""
    late = data.octave_start.values >= _LATE
    return values.isel(octave=np.flatnonzero(late) if late.any() else [-1]).mean("octave")


def _log(values: xr.DataArray) -> xr.DataArray:
    return values.copy(data=np.log(values.values))


def _ends(values: xr.DataArray) -> tuple[xr.DataArray, xr.DataArray]:
    values = values.rename(level="step")
    return values.isel(step=slice(0, -1)), values.isel(step=slice(1, None))


def _both_signs(data: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Areas before each ring, and after it: means over both of its signs."""
    (before, after), negative = _ends(data.area_each), _ends(data.area_negative_each)[1]
    return before, (after + negative) / 2


def _by_octave(data: xr.Dataset, values: xr.DataArray) -> xr.DataArray:
    began = data.magnification.values[:-1] * (1 + 1e-9)
    octave = np.searchsorted(data.octave_start.values, began) - 1
    parts = [
        values.isel(step=np.flatnonzero(octave == k)).sum("step", skipna=False)
        for k in range(data.sizes["octave"])
    ]
    return xr.concat(parts, dim="octave")


def _added(data: xr.Dataset, **values: xr.DataArray) -> xr.Dataset:
    """Add what is computed here: how its parts were made says nothing of it."""
    return data.assign({name: bare(value) for name, value in values.items()})


def _with_square_budget(data: xr.Dataset) -> xr.Dataset:
    """Add the budget of the mean square pressure by octave, over A dV, where the theory has 1.

    ``square_told_each`` is what D and mu make of it when they are functions of the pressure alone,
    ``square_growth_path_each`` the change without the negative rings.
    """
    before, after = (part.isel(grid=-1) for part in _ends(data.variance_share_each))
    unit = _by_octave(data, 0.5 * sum(_both_signs(data)) * (after - before))

    def over_unit(values: xr.DataArray) -> xr.DataArray:
        return _by_octave(data, two_grid_limit(values, data.grid_spacing) * before) / unit

    points = data.bin_contact_each.where(data.bin_contact_each > 0)
    crossed = (data.bin_pressure_each * data.bin_change_each / points).sum("bin")
    pressure_terms = data.bin_change_square_each.sum("bin") + 2 * crossed + data.square_entered_each
    first, last = _ends(two_grid_limit(data.mean_square_each * data.variance_share_each, data.grid_spacing))
    data = _added(
        data,
        square_growth_each=over_unit(data.square_change_each),
        square_diffusion_each=over_unit(data.pressure_change_square_each),
        square_drift_each=over_unit(2 * data.pressure_cross_change_each),
        square_reentry_each=over_unit(data.square_entered_each),
        square_told_each=over_unit(pressure_terms),
        square_growth_path_each=_by_octave(data, last - first) / unit,
    )
    data = _added(data, **{f"{name}_late_each": _late(data[f"{name}_each"], data) for name in SQUARE_TERMS})
    return derive(data, square_difference_each="square_growth_path_each - square_growth_each")


def _with_area_budget(data: xr.Dataset) -> xr.Dataset:
    finest = "nominal_each.isel(grid=-1) / sqrt(2 * variance_share_each.isel(grid=-1))"
    data = derive(data, area_persson_each=f"erf({finest})", area_ratio_each="area_each / area_persson_each")
    (before, after), theory = _ends(data.variance_share_each.isel(grid=-1)), _ends(data.area_persson_each)
    net = two_grid_limit(data.area_entered_each - data.area_lost_each, data.grid_spacing)
    area, both = _both_signs(data)
    located, counted, persson = (
        _by_octave(data, _log(ratio)) / _by_octave(data, _log(after / before))
        for ratio in (both / area, 1 + net / area, theory[1] / theory[0])
    )
    partial = persson < TOUCHED
    late = [_late(part.where(partial), data) for part in (located, persson)]
    return _added(
        data,
        area_exponent_each=located,
        area_exponent_pixel_each=counted,
        area_exponent_persson_each=persson,
        exponent_ratio_each=(located / persson).where(partial),
        exponent_ratio_late_each=late[0] / late[1],
    )


def _with_restarts(data: xr.Dataset) -> xr.Dataset:
    """Add what absorbing diffusion makes of the true pressures at the beginning of each octave.

    ``area_diffused_ratio_each`` is its area over the true one (octave, level), 1 where it starts;
    ``area_ratio_diffused_each`` that over Persson's; ``loss_ratio_each`` how much faster it loses area than the truth,
    ln against ln, over half an octave.
    """
    area, diffused, octaves = data.area_each, data.area_diffused_each, range(data.sizes["octave"])
    began, half = (
        abs(data.magnification - data.octave_start * factor).argmin("level") for factor in (1, 2**0.5)
    )
    row = xr.DataArray(octaves, dims="octave")
    share = two_grid_limit(diffused / diffused.isel(octave=row, level=began), data.grid_spacing)
    ratio = (share / (area / area.isel(level=began))).transpose("octave", ...)
    true = _log(area.isel(level=half) / area.isel(level=began))
    faster = 1 + _log(ratio.isel(octave=row, level=half)) / true.where(true < -_NO_LOSS)
    return _added(
        data,
        area_ratio_end_each=data.area_ratio_each.isel(level=[*began.values[1:], -1]).rename(level="octave"),
        area_diffused_ratio_each=ratio,
        area_ratio_diffused_each=data.area_ratio_each * ratio,
        loss_ratio_each=faster,
    )


def _with_memory(data: xr.Dataset) -> xr.Dataset:
    finest, before = data.isel(grid=-1), data.area_each.isel(level=slice(0, -2)).rename(level="pair")
    out = finest.points_out_each.where(finest.points_out_each > 0)
    data = _added(
        data,
        inflow_share_each=(finest.inflow_each / before).mean("pair"),
        inflow_share_composed_each=(finest.inflow_composed_each / before).mean("pair"),
        return_chance_each=finest.points_returned_each / out,
    )
    return derive(
        data,
        inflow_excess_each="inflow_share_composed_each - inflow_share_each",
        crossed_share_each="contact_crossed_each.isel(grid=-1)",
        out_share_each=f"contact_out_each.isel(grid=-1, level={nearest(data.magnification, 2.0)})",
    )


def exponents(values: xr.DataArray, steps: xr.DataArray) -> xr.DataArray:
    """Exponent of a step between neighbouring ones, and over all of them (last): (step_pair, ...)."""
    along, last = str(steps.dims[0]), steps.size - 1
    pairs = np.array([*itertools.pairwise(range(steps.size)), (0, last)]).T
    start, end = ({along: xr.DataArray(places, dims="step_pair")} for places in pairs)
    rise, length = (_log(part.isel(end) / part.isel(start)) for part in (values.where(values > 0), steps))
    powers: xr.DataArray = (rise / length).drop_vars(str(steps.name), errors="ignore")
    return powers.transpose("step_pair", ...)


def power_at_zero_step(powers: xr.DataArray, steps: xr.DataArray) -> xr.DataArray:
    """Exponent at a vanishing step from those between neighbours (`exponents`).

    c sqrt(dV) (1 + a sqrt(dV)) has 1/2 + a sqrt(dV)/2.
    """
    if steps.size == 2:
        return powers.isel(step_pair=0)
    middles = xr.DataArray((steps.values[1:] * steps.values[:-1]) ** 0.25, dims="step_pair")
    return value_at_zero(powers.isel(step_pair=slice(0, steps.size - 1)), middles, degree=1)


def _with_flows(data: xr.Dataset) -> xr.Dataset:
    area, steps = data.area_probe_each.isel(probe_level=0, drop=True), data.relative_step
    flows = {
        name: two_grid_limit(data[f"{of}_probe_each"], data.grid_spacing_probe) / area
        for name, of in _FLOWS.items()
    }
    after = (data.area_probe_each + data.area_negative_probe_each).isel(probe_level=slice(1, None)) / 2
    net = _log(after.rename(probe_level="variance_step") / area) / _log(1 + steps)
    powers = {name: exponents(flow, steps) for name, flow in flows.items()}
    data = _added(
        data,
        **{f"{name}_each": flow for name, flow in flows.items()},
        **{f"power_{name}_each": power.isel(step_pair=-1) for name, power in powers.items()},
        power_local_each=powers["share_lost"].isel(step_pair=slice(0, -1)),
        power_limit_each=power_at_zero_step(powers["share_lost"], steps),
        area_exponent_probe_each=net,
    )
    data = derive(
        data,
        entered_ratio_each=ratio_of_means("share_entered_each", "share_lost_each", "probe_surface"),
        edge_loss_each="-area_exponent_probe_each.isel(variance_step=-1)",
        load_taken_each="share_load_entered_each / relative_step",
    )
    return _added(data, entered_ratio_limit_each=value_at_zero(data.entered_ratio_each, steps**0.5, degree=1))


def _with_profiles(data: xr.Dataset) -> xr.Dataset:
    bins = ["contact", "pressure", "change", "change_square"]
    pooled = data[[f"bin_{n}_probe_each" for n in bins]].isel(probe_grid=-1)
    pooled = pooled.rename({f"bin_{n}_probe_each": n for n in bins})

    def profile(sums: xr.Dataset, end: str) -> dict[str, xr.DataArray]:
        steps = sums.contact.where(sums.contact > 0) * data.relative_step
        return {f"mean_drift{end}": sums.change / steps, f"diffusivity{end}": sums.change_square / steps}

    sums = pooled.sum("probe_surface")
    mean_pressure = sums.pressure / sums.contact.where(sums.contact > 0)
    data = _added(data, bin_mean_pressure=mean_pressure, **profile(sums, ""))
    lower = np.concatenate([[0.0], data.upper.values[:-1]])
    for name, (low, high) in (("away", _AWAY), ("edge", _EDGE)):
        keep = np.flatnonzero((lower >= low * (1 - 1e-9)) & (data.upper.values <= high * (1 + 1e-9)))
        data = _added(data, **profile(pooled.isel(bin=keep).sum("bin"), f"_{name}_each"))
    return data


def _with_slopes(data: xr.Dataset) -> xr.Dataset:
    # p0 is 2 p* sqrt(V): the same on every surface, since p* counts in its own gradient.
    nominal = data.nominal_probe_each.isel(probe_grid=-1).mean("probe_surface")
    slope_at_zero = elastic.initial_slope(nominal.values.ravel(), stress_variance=1.0)
    variance = elastic.stress_variance(1.0, contact_modulus=1.0)
    persson = elastic.initial_slope(data.reduced_pressure.values, stress_variance=variance)
    data = data.assign(
        nominal=nominal,
        own=0.5 * nominal.copy(data=np.reshape(slope_at_zero, nominal.shape)),
        pressure_slope_persson=("load", np.asarray(persson)),
        start=data.area_probe.isel(probe_level=0),
        start_error=data.area_probe_error.isel(probe_level=0),
    )
    data = derive(
        claim(data, "pressure_slope", **ABSENT),
        slope_ratio="pressure_slope / pressure_slope_persson",
        edge_loss_persson="own / erf(nominal / 2**.5)",
        edge_loss_slope="slope_ratio * own / start",
        edge_loss_excess="edge_loss_slope - edge_loss",
    )
    return data.drop_vars(["nominal", "own", "start", "start_error"])
