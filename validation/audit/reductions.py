"""The reductions of a dataset, a second time: from what its variables say of how they were made.

An attribute ``reduction`` names one; what it needs stands beside it. Solves are read from the store by the
key in the variable ``solve`` at the same place.
"""

from __future__ import annotations

import ast
import contextlib
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr
from scipy.special import stdtrit

from validation.audit import from_solves
from validation.audit.dataset import Reduced, Result, Variables, ordered, solves_in
from validation.audit.from_solves import second_order_step
from validation.audit.stored import Array

SOURCES = ("surfaces", "grid", "solver", "size", "bandwidth", "depth", "theory")
NORMAL = 1.959963984540054


def recomputed(result: Result, name: str) -> Array | None:
    """Return what a variable should be, in the order of its dimensions; None where it cannot be said."""
    one = Reduced(result, name)
    try:
        found = REDUCTIONS.get(str(one.attrs.get("reduction", "")), from_solves.read_off)(one)
        if isinstance(found, xr.Variable):
            return np.asarray(found.set_dims(one.variable.sizes))  # type: ignore[no-untyped-call]
        return found
    except (ArithmeticError, LookupError, SyntaxError, TypeError, ValueError):
        return None


def errors_of(result: Result, name: str) -> dict[str, Array]:
    """Return what the errors of a variable should be by source, those that can be said."""
    one, grid = Reduced(result, name), None
    kind = one.attrs.get("reduction")
    with contextlib.suppress(ArithmeticError, LookupError, TypeError, ValueError):
        if kind == "mean":
            return _mean_errors(one)
        if kind == "expression":
            return _expression_errors(one)
        if kind == "power law" and not name.endswith("_factor"):
            return {"surfaces": _power(one)[1]}
        if kind == "limit":
            grid = from_solves.limit(one, error=True)
        if kind == "second-order limit":
            grid = from_solves.over_solves(one, lambda solve: abs(second_order_step(solve, one.variable)[1]))
    return {} if grid is None else {"grid": NORMAL * grid}


# ---- means -------------------------------------------------------------------------------------------


def _samples(one: Reduced, *, paired: bool = True) -> tuple[Array, Array]:
    """Return the single values, surfaces last, and which were solved; of pairs +h and -h, their means."""
    each, dims = one["of"], (*one.dims, one.attrs["over"])
    values, there = ordered(each, dims).astype(float), _there(one.result, each, dims)
    if not paired or not one.flag("pairs"):
        return values, there
    pairs = (*values.shape[:-1], -1, 2)
    return values.reshape(pairs).mean(axis=-1), np.asarray(np.all(there.reshape(pairs), axis=-1))


def _there(result: Result, each: xr.Variable, dims: tuple[Any, ...]) -> Array:
    """Return which values were solved, along these dimensions, the last of which counts samples."""
    shape, over = ordered(each, dims).shape, dims[-1]
    for named in solves_in(result.data).values():
        if over in named.dims and set(named.dims) <= set(each.dims):
            return np.broadcast_to(ordered(named, dims).astype(str) != "", shape)
    count = result.data.get("surfaces")  # a case of a sweep may have fewer than others
    if over != "surface" or count is None or not set(count.dims) <= set(each.dims):
        return np.ones(shape, dtype=bool)
    return np.broadcast_to(np.arange(shape[-1]) < ordered(count, dims), shape)


def _mean(values: Array, there: Array) -> Array:
    """Mean over the last axis of what is there; NaN where one of it has no value, or nothing is there."""
    count = there.sum(axis=-1)
    return np.where(count > 0, np.where(there, values, 0.0).sum(axis=-1) / np.maximum(count, 1), np.nan)


def _mean_errors(one: Reduced) -> dict[str, Array]:
    """Half widths of a mean by source: scatter of `n` samples (a pair is one), grids of `count` surfaces."""
    (samples, kept), (values, there) = _samples(one), _samples(one, paired=False)
    n, count = kept.sum(axis=-1), np.maximum(there.sum(axis=-1), 1)
    with np.errstate(invalid="ignore", divide="ignore"):  # of infinite samples, and of one
        squares = np.where(kept, (samples - _mean(samples, kept)[..., None]) ** 2, 0.0).sum(axis=-1)
        half = stdtrit(np.maximum(n - 1, 1), 0.975) * np.sqrt(squares / (n - 1) / n)
    found = {"surfaces": np.where(n > 1, half, np.nan)}
    of, dims = one.attrs["of"], (*one.dims, one.attrs["over"])
    error, drift = (one.result.data.get(f"{of}_{what}") for what in ("error", "drift"))
    if error is drift is None:
        return found

    def mean(each: Array) -> Array:
        return _mean(np.broadcast_to(each, values.shape), there)

    grid = np.zeros(np.shape(n))
    if error is not None:
        grids, *parts = ordered(error, ("source", *dims))[1:]
        found |= {source: mean(part) for source, part in zip(SOURCES[2:], parts, strict=True)}
        grid = mean(grids**2) / (1 if one.flag("alike") else count)
    if drift is not None:
        steps = ordered(drift, dims)
        grid = grid + mean(steps) ** 2 + mean(steps**2) / count
    return {**found, "grid": np.sqrt(grid)}


def _change(one: Reduced) -> xr.Variable:
    each, along = one["of"], one.attrs["along"]
    first, last = (int(one.attrs[k]) % each.sizes[along] for k in ("first", "last"))
    change: xr.Variable = each.isel({along: last}) / each.isel({along: first}) - 1
    return change if first != last else change * np.nan


# ---- expressions ---


def _evaluated(expression: str, values: Variables) -> xr.Variable:
    tree = ast.parse(expression, mode="eval")
    with np.errstate(all="ignore"):
        return xr.as_variable(from_solves.value_of(tree, lambda name: values[name].astype(float)))


def _expression_errors(one: Reduced) -> dict[str, Array]:
    """Carry errors along to first order, source by source."""
    expression, values, found = one.attrs["expression"], one.result.data, {}
    names = {node.id for node in ast.walk(ast.parse(expression)) if isinstance(node, ast.Name)}
    moved = [n for n in sorted(names) if f"{n}_error" in values]
    for k, source in enumerate(SOURCES if moved else ()):
        total = xr.zeros_like(one.variable, dtype=float)
        for n in moved:
            step = values[f"{n}_error"].isel(source=k)
            up, here, down = (_evaluated(expression, {**values, n: values[n] + s * step}) for s in (1, 0, -1))
            kink, further = (up - here) * (down - here) > 0, np.maximum(abs(up - here), abs(down - here))
            total = total + xr.where(kink, further, (up - down) / 2) ** 2  # type: ignore[no-untyped-call]
        found[source] = np.sqrt(ordered(total, one.dims))
    return found


# ---- what is fitted, and shares --------------------------------------------------------------------------


def _power(one: Reduced) -> Array:
    """Exponent, half of its 95 % interval and factor of a power, by least squares."""
    dims = (*one.dims, *str(one.attrs["along"]).split())
    y = ordered(one["of"], dims).astype(float)
    at = np.broadcast_to(ordered(one["x"], dims).astype(float), y.shape)
    y, at = (values.reshape(*values.shape[: len(one.dims)], -1) for values in (y, at))
    found = np.full((3, *y.shape[:-1]), np.nan)
    for place in np.ndindex(y.shape[:-1]):
        valid = np.isfinite(y[place]) & (y[place] > 0) & np.isfinite(at[place])
        u, v = np.log(at[place][valid]), np.log(y[place][valid])
        if np.unique(u).size < 2:
            continue
        slope, start = np.polyfit(u, v, 1)
        half, free = math.nan, u.size - 2
        if free:
            spread, rest = u.size * np.var(u), np.sum((v - start - slope * u) ** 2)
            half = stdtrit(free, 0.975) * math.sqrt(rest / free / spread)
        found[:, *place] = slope, half, math.exp(start)
    return found


def _share(one: Reduced) -> Array:
    """Share of what lies within its claim and the error of what it is compared with."""
    of, within = one["of"].values, one["within"].values
    reference = one.result.data["reference_each_error"].isel(source=SOURCES.index("grid")).values
    return np.asarray(np.mean(np.abs(of) <= np.hypot(within, reference)))


def _line(one: Reduced) -> Array:
    """Limit or slope of the straight line through means along a dimension, by weighted least squares."""
    places = (*one.dims, one.attrs["along"])
    dims, each = (*places, one.attrs["over"]), one["of"]
    values, there = ordered(each, dims), _there(one.result, each, dims)
    x = np.broadcast_to(ordered(one["x"], places), values.shape[:-1])
    found = np.full((2, *values.shape[:-2]), np.nan)
    for place in np.ndindex(values.shape[:-2]):
        groups = [row[kept] for row, kept in zip(values[place], there[place], strict=True)]
        if one.flag("pairs"):
            groups = [(group[0::2] + group[1::2]) / 2 for group in groups]
        means = np.array([group.mean() for group in groups])
        error = np.array([math.sqrt(np.sum((g - g.mean()) ** 2) / (g.size - 1) / g.size) for g in groups])
        if one.flag("common"):
            error = np.ones(means.size)
        if not np.isfinite([*means, *error]).all() or np.ptp(x[place]) == 0:
            continue
        weight = 1 / np.maximum(error, 1e-3 * error.max() + 1e-300)
        found[:, *place] = np.polyfit(x[place], means, 1, w=weight / weight.max())[::-1]
    if one.attrs["reduction"] == "line slope":
        return np.asarray(found[1])
    reach = ordered(one.result.data[one.name.removesuffix("_limit") + "_reach"], one.dims)
    # Further off than two spans of what was measured a limit is none.
    return np.where(reach <= 2.0, found[0], np.nan)


def _polynomial(one: Reduced) -> Array:
    """Value at a vanishing spacing by a polynomial in a power of it, over the grids."""
    values, spacing = (ordered(each, (*one.dims, "grid")) for each in (one["of"], one.result.data["spacing"]))
    at = np.broadcast_to(spacing ** float(one.attrs["power"]), values.shape)
    grids = values.shape[-1]
    degree = min(int(one.attrs["degree"]), grids - 2) if grids > 2 else 1
    rows = zip(at.reshape(-1, grids), values.reshape(-1, grids), strict=True)
    return np.reshape([np.polyfit(a, y, degree)[-1] for a, y in rows], values.shape[:-1])


def _mean_distance(one: Reduced) -> Array:
    """Mean distance from 1, in logarithms, over the loads below nearly full contact."""
    over = ordered(one["of"], (*one.dims, "load")).astype(float)
    partly = one.result.data["area"].values < float(one.attrs["below"])
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.abs(np.log(over[..., partly])).mean(axis=-1))


#: By the attribute `reduction`.
REDUCTIONS: Mapping[str, Callable[[Reduced], Array | xr.Variable | None]] = {
    "change": _change,
    "drift": from_solves.drift,
    "expression": lambda one: _evaluated(one.attrs["expression"], one.result.data),
    "field": from_solves.of_field,
    "limit": from_solves.limit,
    "line limit": _line,
    "line slope": _line,
    "mean distance": _mean_distance,
    "mean": lambda one: _mean(*_samples(one)),
    "polynomial limit": _polynomial,
    "power law": lambda one: _power(one)[2 if one.name.endswith("_factor") else 0],
    "read": from_solves.read,
    "second-order limit": lambda one: from_solves.over_solves(
        one, lambda solve: sum(second_order_step(solve, one.variable))
    ),
    "share": _share,
}
