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
from validation.audit.dataset import Result, Variables, ordered, solves_in
from validation.audit.stored import Array

SOURCES = ("surfaces", "grid", "solver", "size", "bandwidth", "depth", "theory")
NORMAL = 1.959963984540054


def recomputed(result: Result, name: str) -> Array | None:
    """Return what a variable should be, in the order of its dimensions; None where it cannot be said."""
    variable = result.data[name]
    reduction = REDUCTIONS.get(str(variable.attrs.get("reduction", "")))
    try:
        found = (reduction or from_solves.read_off)(result, name, variable)
        if isinstance(found, xr.Variable):
            return np.asarray(found.set_dims(variable.sizes))  # type: ignore[no-untyped-call]
        return found
    except (ArithmeticError, LookupError, SyntaxError, TypeError, ValueError):
        return None


def errors_of(result: Result, name: str) -> dict[str, Array]:
    """Return what the errors of a variable should be by source, those that can be said."""
    variable, grid = result.data[name], None
    kind = variable.attrs.get("reduction")
    with contextlib.suppress(ArithmeticError, LookupError, TypeError, ValueError):
        if kind == "mean":
            return _mean_errors(result, variable)
        if kind == "expression":
            return _expression_errors(result, variable)
        if kind == "power law" and not name.endswith("_factor"):
            return {"surfaces": _power(result, variable)[1]}
        if kind == "limit":
            grid = from_solves.limit(result, name, variable, error=True)
        if kind == "second-order limit":
            grid = from_solves.over_solves(
                result, variable, lambda solve: abs(from_solves.second_order_step(solve, variable)[1])
            )
    return {} if grid is None else {"grid": NORMAL * grid}


# ---- means -------------------------------------------------------------------------------------------


def _samples(result: Result, variable: xr.Variable) -> tuple[Array, Array]:
    """Return the single values, surfaces last, and which of them were solved."""
    each = result.data[variable.attrs["of"]]
    dims = (*variable.dims, variable.attrs["over"])
    return ordered(each, dims).astype(float), _there(result, each, dims)


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


def _paired(samples: tuple[Array, Array], variable: xr.Variable) -> tuple[Array, Array]:
    """Return the means of +h and -h where these are one sample together."""
    values, there = samples
    if not int(variable.attrs.get("pairs", 0)):
        return samples
    pairs = (*values.shape[:-1], -1, 2)
    return values.reshape(pairs).mean(axis=-1), np.all(there.reshape(pairs), axis=-1)


def _mean_there(values: Array, there: Array) -> Array:
    """Mean over the last axis of what is there; NaN where one of it has no value."""
    count = there.sum(axis=-1)
    total = np.where(there, values, 0.0).sum(axis=-1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _mean_errors(result: Result, variable: xr.Variable) -> dict[str, Array]:
    values, there = _samples(result, variable)
    samples, kept = _paired((values, there), variable)
    middle = _mean_there(samples, kept)
    n = kept.sum(axis=-1)
    squares = np.where(kept, (samples - middle[..., None]) ** 2, 0.0).sum(axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        half = stdtrit(np.maximum(n - 1, 1), 0.975) * np.sqrt(squares / (n - 1) / n)
    found = {"surfaces": np.where(n > 1, half, np.nan)}
    of, dims = variable.attrs["of"], (*variable.dims, variable.attrs["over"])
    error, drift = (result.data.get(f"{of}_{what}") for what in ("error", "drift"))
    if error is drift is None:
        return found
    grid = np.zeros(middle.shape)
    if error is not None:
        grids, *each = ordered(error, ("source", *dims))[1:]
        fewer = 1 if int(variable.attrs.get("alike", 0)) else np.maximum(there.sum(axis=-1), 1)
        found |= {source: _mean_there(part, there) for source, part in zip(SOURCES[2:], each, strict=True)}
        grid = _mean_there(grids**2, there) / fewer
    if drift is not None:
        steps = ordered(drift, dims)
        grid = grid + _mean_there(steps, there) ** 2 + _mean_there(steps**2, there) / there.sum(axis=-1)
    return {**found, "grid": np.sqrt(grid)}


def _change(result: Result, name: str, variable: xr.Variable) -> xr.Variable:
    attrs, along = variable.attrs, variable.attrs["along"]
    each = result.data[attrs["of"]]
    first, last = (int(attrs[k]) % each.sizes[along] for k in ("first", "last"))
    change: xr.Variable = each.isel({along: last}) / each.isel({along: first}) - 1
    return change if first != last else change * np.nan


# ---- expressions ---


def _evaluated(expression: str, values: Variables) -> xr.Variable:
    tree = ast.parse(expression, mode="eval")
    with np.errstate(all="ignore"):
        return xr.as_variable(from_solves.value_of(tree, lambda name: values[name].astype(float)))


def _expression_errors(result: Result, variable: xr.Variable) -> dict[str, Array]:
    """Carry errors along to first order, source by source."""
    expression, values, found = variable.attrs["expression"], result.data, {}
    names = {node.id for node in ast.walk(ast.parse(expression)) if isinstance(node, ast.Name)}
    moved = [n for n in sorted(names) if f"{n}_error" in values]
    for k, source in enumerate(SOURCES if moved else ()):
        total = xr.zeros_like(variable, dtype=float)
        for n in moved:
            step = values[f"{n}_error"].isel(source=k)
            up, down = (_evaluated(expression, {**values, n: values[n] + s * step}) for s in (1, -1))
            total = total + ((up - down) / 2) ** 2
        found[source] = np.sqrt(ordered(total, variable.dims))
    return found


# ---- what is fitted, and shares --------------------------------------------------------------------------


def _power(result: Result, variable: xr.Variable) -> Array:
    """Exponent, half of its 95 % interval and factor of a power, by least squares."""
    attrs = variable.attrs
    of, x = result.data[attrs["of"]], result.data[attrs["x"]]
    dims = (*variable.dims, *str(attrs["along"]).split())
    y = ordered(of, dims).astype(float)
    at = np.broadcast_to(ordered(x, dims).astype(float), y.shape)
    y, at = (values.reshape(*values.shape[: len(variable.dims)], -1) for values in (y, at))
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


def _share(result: Result, name: str, variable: xr.Variable) -> Array:
    """Share of what lies within its claim and the error of what it is compared with."""
    of, within = (result.data[variable.attrs[key]].values for key in ("of", "within"))
    reference = result.data["reference_each_error"].isel(source=SOURCES.index("grid")).values
    return np.asarray(np.mean(np.abs(of) <= np.hypot(within, reference)))


def _line(result: Result, name: str, variable: xr.Variable) -> Array:
    """Limit or slope of the straight line through means along a dimension, by weighted least squares."""
    attrs, dims = variable.attrs, tuple(map(str, variable.dims))
    along, over = attrs["along"], attrs["over"]
    each = result.data[attrs["of"]]
    values = ordered(each, (*dims, along, over))
    x = np.broadcast_to(ordered(result.data[attrs["x"]], (*dims, along)), values.shape[:-1])
    there = _there(result, each, (*dims, along, over))
    found = np.full((2, *values.shape[:-2]), np.nan)
    for place in np.ndindex(values.shape[:-2]):
        groups = [row[kept] for row, kept in zip(values[place], there[place], strict=True)]
        if int(attrs["pairs"]):
            groups = [(group[0::2] + group[1::2]) / 2 for group in groups]
        means = np.array([group.mean() for group in groups])
        error = np.array([math.sqrt(np.sum((g - g.mean()) ** 2) / (g.size - 1) / g.size) for g in groups])
        if int(attrs["common"]):
            error = np.ones(means.size)
        weight = 1 / np.maximum(error, 1e-3 * error.max() + 1e-300)
        found[:, *place] = np.polyfit(x[place], means, 1, w=weight / weight.max())[::-1]
    if attrs["reduction"] == "line slope":
        return np.asarray(found[1])
    reach = ordered(result.data[name.removesuffix("_limit") + "_reach"], dims)
    # Further off than two spans of what was measured a limit is none.
    return np.where(reach <= 2.0, found[0], np.nan)


def _polynomial(result: Result, name: str, variable: xr.Variable) -> Array:
    """Value at a vanishing spacing by a polynomial in a power of it, over the grids."""
    each, dims = result.data[variable.attrs["of"]], (*variable.dims, "grid")
    values = ordered(each, dims).astype(float)
    spacing = ordered(result.data["spacing"], dims)
    at = np.broadcast_to(spacing ** float(variable.attrs["power"]), values.shape)
    grids = values.shape[-1]
    degree = min(int(variable.attrs["degree"]), grids - 2) if grids > 2 else 1
    rows = zip(at.reshape(-1, grids), values.reshape(-1, grids), strict=True)
    return np.reshape([np.polyfit(a, y, degree)[-1] for a, y in rows], values.shape[:-1])


def _mean_distance(result: Result, name: str, variable: xr.Variable) -> Array:
    """Mean distance from 1, in logarithms, over the loads below nearly full contact."""
    over = ordered(result.data[variable.attrs["of"]], (*variable.dims, "load")).astype(float)
    partly = result.data["area"].values < float(variable.attrs["below"])
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.abs(np.log(over[..., partly])).mean(axis=-1))


#: By the attribute `reduction`.
REDUCTIONS: Mapping[str, Callable[[Result, str, xr.Variable], Array | xr.Variable | None]] = {
    "change": _change,
    "drift": from_solves.drift,
    "expression": lambda result, _, one: _evaluated(one.attrs["expression"], result.data),
    "field": from_solves.of_field,
    "limit": from_solves.limit,
    "line limit": _line,
    "line slope": _line,
    "mean distance": _mean_distance,
    "mean": lambda result, _, one: _mean_there(*_paired(_samples(result, one), one)),
    "polynomial limit": _polynomial,
    "power law": lambda result, name, one: _power(result, one)[2 if name.endswith("_factor") else 0],
    "read": from_solves.read,
    "second-order limit": lambda result, name, one: from_solves.over_solves(
        result, one, lambda solve: sum(from_solves.second_order_step(solve, one))
    ),
    "share": _share,
}
