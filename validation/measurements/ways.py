"""Ways to a contact area: what each is off by and costs, which no other beats, whether claimed intervals hold."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import scipy.stats
import xarray as xr
from numpy.typing import ArrayLike

from validation.measurements.measurement import area_limits
from validation.report.estimates import error_of
from validation.report.places import gather

#: Definitions of the area.
AREAS = ("pixel", "perimeter", "subcell")
#: Accuracies to which the cheapest way is named.
_TARGETS = (0.1, 0.03, 0.01, 0.003, 0.001)


def ways_of_bem(measured: Mapping[int, xr.Dataset]) -> Iterator[xr.Dataset]:
    """Yield single grids, shifts averaged, limits over two grids, and over three with shifts."""
    whole = gather({k: result.isel(load=0) for k, result in measured.items()}, "surface")
    per_wave = measured[0].points_per_wave.values
    for i, name in itertools.product(range(per_wave.size), AREAS):
        on = whole.isel(grid=i)
        label, means, size = f"BEM {name}, {per_wave[i]:g} per wave", on.mean("shift"), on.peak_bytes
        yield way(on[name].isel(shift=0), label=label, seconds=means.seconds, peak_bytes=size)
        yield way(means[name], label=f"{label}, 4 shifts", seconds=4 * means.seconds, peak_bytes=size)
    for count, shifts in ((2, 1), (3, 4)):
        for i in range(per_wave.size - count + 1):
            some = {"grid": slice(i, i + count), "shift": slice(shifts)}
            label = f"BEM limit, {per_wave[i]:g} to {per_wave[i + count - 1]:g} per wave"
            yield way(
                [area_limits(result.isel(some))[0][0] for result in measured.values()],
                label=label + (", 4 shifts" if shifts == 4 else ""),
                seconds=whole.seconds.isel(some).sum(("grid", "shift")),
                peak_bytes=whole.peak_bytes.isel(some),
            )


def way(
    areas: ArrayLike, *, label: str, seconds: ArrayLike, peak_bytes: ArrayLike, process: bool = False
) -> xr.Dataset:
    """Return one way to an area: of all surfaces, and what one surface costs.

    Memory is that of arrays, or by how much a process grew: the two are not compared.
    """
    return xr.Dataset(
        {
            "area_each": ("surface", np.asarray(areas)),
            "seconds": np.asarray(seconds).mean(),
            "peak_bytes": np.asarray(peak_bytes).max(),
            "kind": label.split(",")[0],
            "process": int(process),
        },
        attrs={"way": label},
    )


def covered(data: xr.Dataset) -> xr.Dataset:
    """Add how many claimed intervals hold the reference, with its own interval: share and its exact 95 % interval."""
    reference = data.reference_each_error.sel(source="grid", drop=True)
    held = int((abs(data.missed_each) <= np.hypot(data.claimed_each, reference)).sum())
    total = data.sizes["surface"]
    bounds = scipy.stats.binomtest(held, total).proportion_ci(0.95)
    share = xr.DataArray(held / total)
    half = max(held / total - bounds.low, bounds.high - held / total)
    return data.assign(
        held=held,
        coverage=share.assign_attrs(reduction="share", of="missed_each", within="claimed_each"),
        coverage_error=error_of(share, surfaces=half),
        claimed=data.claimed_each.mean("surface"),
    )


def pareto_front(data: xr.Dataset, cost: str) -> list[int]:
    """Return the ways that no other beats in both deviation and a cost, cheapest first.

    Only memory that is measured alike is compared: by process where other codes are there.
    """
    deviation, price = data.area_deviation_rms.values, data[cost].values
    process = data.process.values.astype(bool)
    alike = process if data.attrs.get("peers") and process.any() else ~process
    compared = alike if cost == "peak_bytes" else np.ones(price.size, dtype=bool)
    best, front = np.inf, []
    for k in np.lexsort((deviation, price)):
        if deviation[k] < best and compared[k]:
            best = deviation[k]
            front.append(int(k))
    return front


def chosen_ways(data: xr.Dataset) -> xr.Dataset:
    """Add the fastest and the leanest of our own ways to each accuracy, and the ways on the fronts."""
    deviation, ours = data.area_deviation_rms.values, data.process.values == 0
    costs = {"fastest": ("seconds", "peak_bytes"), "leanest": ("peak_bytes", "seconds")}
    rows: dict[str, list[Any]] = {}
    for target, (which, (cost, other)) in itertools.product(_TARGETS, costs.items()):
        good = np.flatnonzero((deviation <= target) & ours)
        k = int(good[np.lexsort((data[other].values[good], data[cost].values[good]))[0]]) if good.size else -1
        label = str(data.way.values[k]) if good.size else "none of the ways tried"
        if target < 2 * float(data.reference_rms):
            k, label = -1, "not determinable: the reference is not known well enough"
        rows.setdefault(f"way_{which}", []).append(label)
        for name in ("area_deviation_rms", "seconds", "peak_bytes"):
            rows.setdefault(f"{name}_{which}", []).append(float(data[name][k]) if k >= 0 else np.nan)
    data = data.assign({name: ("target", values) for name, values in rows.items()})
    data = data.assign_coords(accuracy=("target", list(_TARGETS)))
    for cost in ("seconds", "peak_bytes"):
        front, dim = pareto_front(data, cost), f"front_{cost}"
        data[f"area_deviation_rms_{dim}"] = dim, deviation[front]
        data[f"{cost}_front"] = dim, data[cost].values[front]
    return data
