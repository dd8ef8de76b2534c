"""The reductions of a dataset, a second time: from what its variables say of how they were made.

An attribute ``reduction`` names one; what it needs stands beside it. Solves are read from the store by the
key in the variable ``solve`` at the same place.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Iterator, Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.special import erf, stdtrit

from validation.audit.dataset import Labelled, Result, Variable
from validation.audit.limits import limit_over
from validation.audit.stored import Array

__all__ = ["REDUCTIONS", "errors_of", "recomputed"]

#: Points per shortest wave below which a grid enters no limit.
_LEAST_POINTS = 3.0
_SOURCES = ("surfaces", "grid", "solver", "size", "bandwidth", "depth", "theory")
_NORMAL = 1.959963984540054


def recomputed(result: Result, name: str) -> Array | None:
    """Return what a variable should be, in the order of its dimensions; None where it cannot be said."""
    variable = result.data[name]
    reduction = REDUCTIONS.get(str(variable.attrs.get("reduction", "")))
    try:
        return (reduction or _read_off)(result, name, variable)
    except (ArithmeticError, LookupError, TypeError, ValueError):
        return None


def errors_of(result: Result, name: str) -> dict[str, Array]:
    """Return what the errors of a variable should be by source, those that can be said."""
    try:
        return _errors_of(result, name, result.data[name])
    except (ArithmeticError, LookupError, TypeError, ValueError):
        return {}


def _errors_of(result: Result, name: str, variable: Variable) -> dict[str, Array]:
    kind = variable.attrs.get("reduction")
    if kind == "mean" and "pairs" in variable.attrs:
        return _mean_errors(result, variable)
    if kind == "expression":
        return _expression_errors(result, variable)
    if kind == "limit":
        found = _over_solves(result, variable, lambda one: [_NORMAL * e for _, e in _limits(one)])
        return {} if found is None else {"grid": found}
    if kind == "second-order limit":
        found = _over_solves(
            result, variable, lambda one: _NORMAL * abs(_second_order_step(one, variable)[1])
        )
        return {} if found is None else {"grid": found}
    if kind == "power law" and not name.endswith("_factor"):
        return {"surfaces": _power(result, variable)[1]}
    return {}


# ---- means -------------------------------------------------------------------------------------------


def _samples(result: Result, variable: Variable) -> tuple[Array, Array]:
    """Return the single values, surfaces last, and which of them were solved."""
    over = str(variable.attrs["over"])
    each = result.data[str(variable.attrs["of"])]
    dims = (*variable.dims, over)
    values = each.along(dims).astype(float)
    there = np.ones(values.shape, dtype=bool)
    for name, named in result.data.variables.items():
        if name.startswith("solve") and over in named.dims and set(named.dims) <= set(each.dims):
            there = np.broadcast_to(named.along(dims).astype(str) != "", values.shape)
            break
    return values, there


def _paired(values: Array, variable: Variable) -> Array:
    return (values[..., 0::2] + values[..., 1::2]) / 2 if int(variable.attrs.get("pairs", 0)) else values


def _mean(result: Result, name: str, variable: Variable) -> Array:
    values, there = _samples(result, variable)
    if int(variable.attrs.get("pairs", 0)):
        values, there = _paired(values, variable), there[..., 0::2]
    return _mean_there(values, there)


def _mean_there(values: Array, there: Array) -> Array:
    """Mean over the last axis of what is there; NaN where one of it has no value."""
    count = there.sum(axis=-1)
    total = np.where(there, values, 0.0).sum(axis=-1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _mean_errors(result: Result, variable: Variable) -> dict[str, Array]:
    values, there = _samples(result, variable)
    counts = there.sum(axis=-1)
    samples, kept = values, there
    if int(variable.attrs.get("pairs", 0)):
        samples, kept = _paired(values, variable), there[..., 0::2]
    middle = _mean_there(samples, kept)
    n = kept.sum(axis=-1)
    squares = np.where(kept, (samples - middle[..., None]) ** 2, 0.0).sum(axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        half = stdtrit(np.maximum(n - 1, 1), 0.975) * np.sqrt(squares / (n - 1) / n)
    found = {"surfaces": np.where(n > 1, half, np.nan)}
    of, over = str(variable.attrs["of"]), str(variable.attrs["over"])
    dims = (*variable.dims, over)
    grid = np.zeros(middle.shape)
    if f"{of}_error" in result.data:
        error = result.data[f"{of}_error"]
        each = {
            s: np.broadcast_to(error.at({"source": k}).along(dims), values.shape)
            for k, s in enumerate(_SOURCES)
        }
        fewer = 1 if int(variable.attrs.get("alike", 0)) else np.maximum(counts, 1)
        grid = _mean_there(each["grid"] ** 2, there) / fewer
        found |= {s: _mean_there(each[s], there) for s in _SOURCES[2:]}
    if f"{of}_drift" in result.data:
        drift = np.broadcast_to(result.data[f"{of}_drift"].along(dims), values.shape)
        grid = grid + _mean_there(drift, there) ** 2
    if f"{of}_error" in result.data or f"{of}_drift" in result.data:
        found["grid"] = np.sqrt(grid)
    return found


def _change(result: Result, name: str, variable: Variable) -> Array:
    told, along = variable.attrs, str(variable.attrs["along"])
    each = result.data[str(told["of"])]
    first, last = (each.at({along: int(told[k])}).along(variable.dims) for k in ("first", "last"))
    return np.asarray(last / first - 1)


# ---- expressions ---------------------------------------------------------------------------------------

_OPERATORS: dict[type, Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
}
_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": np.abs,
    "erf": erf,
    "exp": np.exp,
    "log": np.log,
    "maximum": np.maximum,
    "minimum": np.minimum,
    "sqrt": np.sqrt,
}


def _names(expression: str) -> list[str]:
    return sorted({node.id for node in ast.walk(ast.parse(expression)) if isinstance(node, ast.Name)})


def _value(node: ast.AST, values: Mapping[str, Array]) -> Any:
    """Evaluate sums, products, powers, a few functions, and single places along a dimension."""
    if isinstance(node, ast.Expression):
        return _value(node.body, values)
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return float(node.value)
    if isinstance(node, ast.Name):
        return values[node.id]
    if isinstance(node, ast.BinOp):
        return _OPERATORS[type(node.op)](_value(node.left, values), _value(node.right, values))
    if isinstance(node, ast.UnaryOp):
        return _OPERATORS[type(node.op)](_value(node.operand, values))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _FUNCTIONS:
        return _FUNCTIONS[node.func.id](*(_value(one, values) for one in node.args))
    raise LookupError(ast.dump(node))


def _placed(result: Result, expression: str) -> tuple[str, dict[str, Variable]]:
    """Name each ``x.isel(dim=k)`` of an expression, and return all variables it needs."""
    tree = ast.parse(expression, mode="eval")
    needed: dict[str, Variable] = {}

    class Places(ast.NodeTransformer):
        def visit_Call(self, node: ast.Call) -> ast.AST:
            if isinstance(node.func, ast.Attribute) and node.func.attr == "isel":
                assert isinstance(node.func.value, ast.Name)
                place = {str(k.arg): ast.literal_eval(k.value) for k in node.keywords}
                name = f"{node.func.value.id}_at_{len(needed)}"
                needed[name] = result.data[node.func.value.id].at(place)
                return ast.Name(id=name, ctx=ast.Load())
            self.generic_visit(node)
            return node

    text = ast.unparse(Places().visit(tree))
    needed |= {n: result.data[n] for n in _names(text) if n not in needed and n in result.data}
    return text, needed


def _expression(result: Result, name: str, variable: Variable) -> Array | None:
    try:
        text, needed = _placed(result, str(variable.attrs["expression"]))
        values = {n: one.along(variable.dims).astype(float) for n, one in needed.items()}
        with np.errstate(all="ignore"):
            found = _value(ast.parse(text, mode="eval"), values)
    except (LookupError, ValueError, SyntaxError, AssertionError):
        return None
    return np.broadcast_to(np.asarray(found, dtype=float), variable.values.shape)


def _expression_errors(result: Result, variable: Variable) -> dict[str, Array]:
    """Carry errors along to first order, source by source."""
    expression = str(variable.attrs["expression"])
    if ".isel(" in expression:
        return {}
    values = {
        n: result.data[n].along(variable.dims).astype(float) for n in _names(expression) if n in result.data
    }
    moved = [n for n in values if f"{n}_error" in result.data]
    tree, found = ast.parse(expression, mode="eval"), {}
    for k, source in enumerate(_SOURCES if moved else ()):
        total = np.zeros(variable.values.shape)
        for n in moved:
            step = result.data[f"{n}_error"].at({"source": k}).along(variable.dims)
            with np.errstate(all="ignore"):
                up, down = (_value(tree, {**values, n: values[n] + s * step}) for s in (1, -1))
            total = total + ((up - down) / 2) ** 2
        found[source] = np.sqrt(total)
    return found


# ---- what is fitted, and shares --------------------------------------------------------------------------


def _power(result: Result, variable: Variable) -> tuple[Array, Array, Array]:
    """Exponent, half of its 95 % interval and factor of a power, by normal equations."""
    told = variable.attrs
    of, x = result.data[str(told["of"])], result.data[str(told["x"])]
    dims = (*variable.dims, *str(told["along"]).split())
    y = of.along(dims).astype(float)
    at = np.broadcast_to(x.along(dims).astype(float), y.shape)
    y, at = (one.reshape(*one.shape[: len(variable.dims)], -1) for one in (y, at))
    found = np.full((3, *y.shape[:-1]), np.nan)
    for place in np.ndindex(y.shape[:-1]):
        kept = np.isfinite(y[place]) & (y[place] > 0) & np.isfinite(at[place])
        u, v = np.log(at[place][kept]), np.log(y[place][kept])
        if np.unique(u).size < 2:
            continue
        spread = float(np.sum((u - u.mean()) ** 2))
        slope = float(np.sum((u - u.mean()) * (v - v.mean()))) / spread
        rest = v - v.mean() - slope * (u - u.mean())
        free = u.size - 2
        half = (
            float(stdtrit(free, 0.975)) * math.sqrt(float(rest @ rest) / free / spread) if free else math.nan
        )
        found[(slice(None), *place)] = slope, half, math.exp(v.mean() - slope * u.mean())
    return found[0], found[1], found[2]


def _power_law(result: Result, name: str, variable: Variable) -> Array:
    exponent, _, factor = _power(result, variable)
    return factor if name.endswith("_factor") else exponent


# ---- from the solves -------------------------------------------------------------------------------------


def _keys(result: Result, variable: Variable) -> Iterator[tuple[tuple[int, ...], str, tuple[str, ...]]]:
    """Yield place, key and dimensions of the solves of a variable."""
    for name, named in result.data.variables.items():
        if name.startswith("solve") and set(named.dims) <= set(variable.dims):
            for place in np.ndindex(named.values.shape):
                yield place, str(named.values[place]), named.dims
            return


def _over_solves(result: Result, variable: Variable, read: Callable[[Labelled], Any]) -> Array | None:
    """Fill an array with what is read off the solve of each place; None where one is not to be had."""
    found, seen = np.full(variable.values.shape, np.nan), False
    for place, key, dims in _keys(result, variable):
        if not key:
            continue
        solve = result.solve(key)
        values = None if solve is None else read(solve)
        if values is None:
            return None
        index: list[Any] = [slice(None)] * len(variable.dims)
        for dim, k in zip(dims, place, strict=True):
            index[variable.dims.index(dim)] = k
        if np.shape(values) != found[tuple(index)].shape:
            return None
        found[tuple(index)], seen = values, True
    return found if seen else None


def _limits(solve: Labelled, *, without: int = 0) -> list[tuple[float, float]]:
    """Limit over the resolved grids and its standard error at each load, without so many of the coarsest."""
    wave = solve["points_per_wave"].values
    grids = np.flatnonzero(wave >= _LEAST_POINTS * (1 - 1e-9))[without:]
    points, cells = solve["points"].values, solve["cells"].values
    pixel, perimeter, subcell, edges = (
        solve[name].along(("grid", "shift", "load"))
        for name in ("pixel", "perimeter", "subcell", "edge_fraction")
    )
    found = []
    for load in range(pixel.shape[2]):
        areas: list[Any] = [
            SimpleNamespace(
                spacing=(1 / float(points[i]), float(points[i]) / float(cells[i])),
                cells=int(cells[i]),
                pixel=float(pixel[i, j, load]),
                perimeter=float(perimeter[i, j, load]),
                edges=float(edges[i, j, load]),
                subcell=float(subcell[i, j, load]),
                alignment=0.0,
            )
            for i in grids
            for j in range(pixel.shape[1])
        ]
        located = not any(math.isnan(one.subcell) for one in areas)
        limit = limit_over(areas, located=located) if areas else None
        found.append((math.nan, math.nan) if limit is None else (limit.value, limit.error))
    return found


def _limit(result: Result, name: str, variable: Variable) -> Array | None:
    if variable.attrs["of"] != "subcell":
        return _limit_of_fields(result, variable)
    return _over_solves(result, variable, lambda solve: [value for value, _ in _limits(solve)])


def _limit_of_fields(result: Result, variable: Variable) -> Array | None:
    """Limits from the fields of several solves, whose keys stand beside each other."""
    found = np.full(variable.values.shape, np.nan)
    for place, keys, _ in _keys(result, variable):
        fields = [result.fields(key) for key in keys.split()]
        if not fields or any(one is None for one in fields):
            return None
        solves: list[Any] = fields
        limit = limit_over(solves, located=not any(one.recipe.get("effects") for one in solves))
        found[place] = math.nan if limit is None else limit.value
    return found


def _drift(result: Result, name: str, variable: Variable) -> Array | None:
    def read(solve: Labelled) -> list[float]:
        wave = solve["points_per_wave"].values
        resolved = int(np.count_nonzero(wave >= _LEAST_POINTS * (1 - 1e-9)))
        shifts = solve["pixel"].along(("grid", "shift", "load")).shape[1]
        if resolved < 3 or (resolved - 1) * shifts < 3:
            return [0.0] * solve["reduced_pressure"].values.size
        pairs = zip(_limits(solve), _limits(solve, without=1), strict=True)
        return [finer - whole for (whole, _), (finer, _) in pairs]

    return _over_solves(result, variable, read)


def _shift_mean(result: Result, name: str, variable: Variable) -> Array | None:
    def read(solve: Labelled) -> Array:
        values = _over_shifts(solve, variable)
        return values if "grid" in variable.dims else np.asarray(values[-1])

    return _over_solves(result, variable, read)


def _over_shifts(solve: Labelled, variable: Variable) -> Array:
    """Mean over the shifts, (grid, load), of a power of what a solve keeps, over a scale."""
    told = variable.attrs
    scale = told.get("scale", 1.0)
    scale = float(solve.attrs[scale] if isinstance(scale, str) else scale)
    values = solve[str(told["of"])].along(("grid", "shift", "load"))
    return np.asarray((values ** float(told.get("power", 1.0))).mean(axis=1) / scale)


def _second_order_step(solve: Labelled, variable: Variable) -> tuple[Array, Array]:
    """Values on the finest grid, and the step from there to the limit, by the two finest."""
    coarse, fine = _over_shifts(solve, variable)[-2:]
    points = solve["points_per_wave"].values
    return fine, (fine - coarse) / (float(points[-1] / points[-2]) ** 2 - 1)


def _second_order(result: Result, name: str, variable: Variable) -> Array | None:
    return _over_solves(result, variable, lambda one: sum(_second_order_step(one, variable)))


def _polynomial(result: Result, name: str, variable: Variable) -> Array:
    """Value at a vanishing spacing by a polynomial in a power of it, over the grids."""
    each, dims = result.data[str(variable.attrs["of"])], (*variable.dims, "grid")
    values = each.along(dims).astype(float)
    spacing = result.data["spacing"].along(dims)
    at = np.broadcast_to(spacing ** float(variable.attrs["power"]), values.shape)
    grids = values.shape[-1]
    degree = min(int(variable.attrs["degree"]), grids - 2) if grids > 2 else 1
    rows = zip(at.reshape(-1, grids), values.reshape(-1, grids), strict=True)
    found = [np.linalg.lstsq(np.vander(a, degree + 1), y, rcond=None)[0][-1] for a, y in rows]
    return np.reshape(found, values.shape[:-1])


def _mean_distance(result: Result, name: str, variable: Variable) -> Array:
    """Mean distance from 1 over the loads below full contact."""
    over = result.data[str(variable.attrs["of"])].along((*variable.dims, "load")).astype(float)
    partly = result.data["area"].values < float(variable.attrs["below"])
    return np.asarray(np.abs(over[..., partly] - 1).mean(axis=-1))


def _finest_profile(result: Result, name: str, variable: Variable) -> Array | None:
    return _over_solves(result, variable, lambda one: one[str(variable.attrs["of"])].values[-1])


def _read(result: Result, name: str, variable: Variable) -> Array | None:
    """Read off what a solve keeps, by the expression that says it."""
    tree = ast.parse(str(variable.attrs["expression"]), mode="eval")

    def read(solve: Labelled) -> Any:
        known = {
            n: one.values.astype(float) for n, one in solve.variables.items() if one.values.dtype.kind in "fi"
        }
        known |= {
            n: np.asarray(v, dtype=float)
            for n, v in solve.attrs.items()
            if isinstance(v, float | int | np.number)
        }
        return _value(tree, known)

    return _over_solves(result, variable, read)


def _reduced(how: Callable[..., Array]) -> Callable[[Result, str, Variable], Array]:
    """Return the reduction of single values over the surfaces, without an interval."""

    def reduce(result: Result, name: str, variable: Variable) -> Array:
        values, _ = _samples(result, variable)
        return np.asarray(how(values, axis=-1))

    return reduce


def _read_off(result: Result, name: str, variable: Variable) -> Array | None:
    """Read what a solve keeps under this name, as a variable or an attribute, where the shapes are those."""
    plain = name.removesuffix("_each")
    if variable.values.dtype.kind not in "fi" or name.endswith(("_error", "_drift")):
        return None

    def read(solve: Labelled) -> Any:
        if plain in solve and solve[plain].values.dtype.kind in "fi":
            return solve[plain].values
        return solve.attrs.get(plain)

    return _over_solves(result, variable, read)


#: By the attribute `reduction`.
REDUCTIONS: Mapping[str, Callable[[Result, str, Variable], Array | None]] = {
    "change": _change,
    "drift": _drift,
    "expression": _expression,
    "finest profile": _finest_profile,
    "limit": _limit,
    "max": _reduced(np.nanmax),
    "mean distance": _mean_distance,
    "mean": lambda result, name, one: (_mean if "pairs" in one.attrs else _reduced(np.nanmean))(
        result, name, one
    ),
    "polynomial limit": _polynomial,
    "power law": _power_law,
    "read": _read,
    "second-order limit": _second_order,
    "shift mean": _shift_mean,
    "sum": _reduced(np.nansum),
}
