"""What follows from the stored solves of a dataset: limits, drifts, means over shifts, what is read off.

Expressions of variables are evaluated without executing anything: sums, products, powers, a few functions.
"""

from __future__ import annotations

import ast
import itertools
import json
import math
import operator
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.special import erf

from validation.audit.dataset import Reduced, Result, numbers_in, ordered, solves_in
from validation.audit.limits import TRAITS, limit_over
from validation.audit.stored import Array, Pair, Stored
from validation.netcdf import read_dataset

#: Points per shortest wave below which a grid enters no limit.
_LEAST_POINTS = 3.0


def _read_along(
    solves: xr.Variable, variable: xr.Variable, read: Callable[[list[str]], Any]
) -> tuple[Array, NDArray[np.bool_]] | None:
    """Fill an array with what is read by the keys of each place; return it, and where something was.

    Of a place that several say, all must say the same: where they do not it is NaN. None for other shapes.
    """
    filled, seen = np.full(variable.shape, np.nan), np.zeros(variable.shape, dtype=bool)
    for place, keys in np.ndenumerate(solves.values):
        if not keys or (values := read(str(keys).split())) is None:
            continue
        values, at = np.asarray(values, float), dict(zip(solves.dims, place, strict=True))
        index = tuple(at.get(dim, slice(None)) for dim in variable.dims)
        if np.shape(values) != filled[index].shape:
            return None
        scale = np.max(np.abs(values), where=np.isfinite(values), initial=0.0)
        near = np.isclose(filled[index], values, rtol=1e-9, atol=1e-12 * scale)
        filled[index], seen[index] = np.where(seen[index] & ~near, np.nan, values), True
    return filled, seen


def over_solves(
    one: Reduced, read: Callable[..., Any], kind: Callable[..., Any] = read_dataset
) -> Array | None:
    """Fill an array with what is read off the solve of each place; None where one is not to be had.

    Solves are those named along most of its dimensions. Where several keys stand beside each other, `read`
    takes all of their solves, each of a `kind`. Of a list by load that has one, a variable without that
    dimension is the value.
    """

    def of_all(keys: list[str]) -> Any:
        solves = [one.result.solve(key, kind) for key in keys]
        values = None if any(solve is None for solve in solves) else read(*solves)
        if "load" not in one.dims and isinstance(values, list) and len(values) == 1:
            values = values[0]
        if values is None:
            raise LookupError(keys)
        return values

    named = [solves for solves in solves_in(one.result.data).values() if set(solves.dims) <= set(one.dims)]
    made = named and _read_along(max(named, key=lambda solves: solves.ndim), one.variable, of_all)
    return made[0] if made and made[1].any() else None


def limits(solve: xr.Dataset, *, without: int = 0) -> list[Pair]:
    """Limit over the resolved grids and its standard error at each load, without so many of the coarsest."""
    names = ("edge_fraction", "pixel", "perimeter", "subcell", *TRAITS)
    arrays = {name: ordered(solve.variables[name], ("grid", "shift", "load")) for name in names}
    _, shifts, loads = arrays["pixel"].shape

    def area(i: int, *place: int) -> SimpleNamespace:
        numbers = {name: float(values[i, *place]) for name, values in arrays.items()}
        points, cells = float(solve["points"].values[i]), int(solve["cells"].values[i])
        there = {"located": not math.isnan(numbers["subcell"]), "edges": numbers["edge_fraction"]}
        return SimpleNamespace(spacing=(1 / points, points / cells), cells=cells, **there, **numbers)

    places = list(itertools.product(_resolved(solve)[without:], range(shifts)))
    return [limit_over([area(i, j, load) for i, j in places]) for load in range(loads)]


def _resolved(solve: xr.Dataset) -> Array:
    return np.flatnonzero(solve["points_per_wave"].values >= _LEAST_POINTS * (1 - 1e-9))


def limit(one: Reduced, *, error: bool = False) -> Array | None:
    """Limits over the grids of each solve, or their standard errors."""
    if one.attrs["of"] == "subcell":
        return over_solves(one, lambda solve: [pair[int(error)] for pair in limits(solve)])
    return over_solves(one, lambda *solves: limit_over(solves)[int(error)], Stored)


def of_field(one: Reduced) -> Array | None:
    """Compute from the fields of each solve what the attribute ``of`` names of them."""
    return over_solves(one, lambda solve: getattr(solve, one.attrs["of"]), Stored)


def drift(one: Reduced) -> Array | None:
    """Change of each limit without its coarsest grid."""

    def read(solve: xr.Dataset) -> list[float]:
        resolved = _resolved(solve).size
        if resolved < 3 or (resolved - 1) * solve.sizes.get("shift", 1) < 3:
            return [0.0] * solve["reduced_pressure"].values.size
        pairs = zip(limits(solve), limits(solve, without=1), strict=True)
        return [finer - whole for (whole, _), (finer, _) in pairs]

    return over_solves(one, read)


def second_order_step(solve: xr.Dataset, variable: xr.Variable) -> tuple[Array, Array]:
    """Values on the finest grid, means over the shifts, and the step to the limit, by the two finest."""
    values = ordered(solve.variables[variable.attrs["of"]], ("grid", "shift", "load")).mean(axis=1)
    coarse, fine = values[-2:] / solve.attrs.get(variable.attrs.get("scale"), 1.0)
    points = solve["points_per_wave"].values
    return fine, (fine - coarse) / (float(points[-1] / points[-2]) ** 2 - 1)


_OPERATORS: dict[type, Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.USub: operator.neg,
}
_FUNCTIONS: dict[str, Callable[..., Any]] = {
    **{name: getattr(np, name) for name in ("abs", "exp", "log", "maximum", "minimum", "sqrt")},
    "erf": erf,
}
_REDUCED = ("isel", "max", "mean", "min", "sum")


def value_of(node: ast.AST, value: Callable[[str], Any]) -> Any:
    """Evaluate sums, powers, functions, ``x.isel(dim=k)`` and ``x.mean(dim)``; a name has its `value`."""
    if isinstance(node, ast.Expression):
        return value_of(node.body, value)
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return float(node.value)
    if isinstance(node, ast.Name):
        return value(node.id)
    if isinstance(node, ast.BinOp):
        return _OPERATORS[type(node.op)](value_of(node.left, value), value_of(node.right, value))
    if isinstance(node, ast.UnaryOp):
        return _OPERATORS[type(node.op)](value_of(node.operand, value))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _FUNCTIONS:
        return _FUNCTIONS[node.func.id](*(value_of(part, value) for part in node.args))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in _REDUCED:
        how = {str(k.arg): ast.literal_eval(k.value) for k in node.keywords}
        if node.func.attr == "sum":
            how["min_count"] = 1  # of a case that failed there is none
        reduced = getattr(value_of(node.func.value, value), node.func.attr)
        return reduced(*map(ast.literal_eval, node.args), **how)
    raise LookupError(ast.dump(node))


def read(one: Reduced) -> Array | None:
    """Read off what a solve keeps, by the expression that says it."""
    tree = ast.parse(one.attrs["expression"], mode="eval")

    def read(solve: xr.Dataset) -> Any:
        numbers = {n: v.astype(float) for n, v in solve.variables.items() if v.dtype.kind in "fib"}
        return value_of(tree, {**solve.attrs, **numbers}.__getitem__)

    return over_solves(one, read)


def read_off(one: Reduced) -> Array | None:
    """Read what solves keep or were asked under this name, where the shapes are those.

    Of what is said once of several solves, all must say the same: where they do not it is NaN.
    """
    plain = one.name.removesuffix("_each")
    if one.variable.dtype.kind not in "fib" or one.name.endswith(("_error", "drift")):
        return None

    def read(solve: xr.Dataset) -> Any:
        # Without "_each" it may be a mean over surfaces, which no solve has; a coordinate is never one.
        known = solve.variables if one.name != plain else set(solve.coords) - set(solve.dims)
        if plain in known and solve[plain].dtype.kind in "fib":
            return solve[plain].values
        return solve.attrs.get(plain, _asked(one.result, solve, plain))

    return over_solves(one, read) if one.name != plain else _said_by_all(one, read)


def _asked(result: Result, solve: xr.Dataset, name: str) -> Any:
    """Return the one number of this name in what a solve was asked; p* follows from p0."""
    recipe = json.loads(str(solve.attrs.get("recipe", "{}")))
    recipe.get("surface", {}).pop("surfaces", None)  # bodies of one contact; a result counts realisations
    found = [recipe[f"{name}s"]] if f"{name}s" in recipe else list(numbers_in(recipe, name))
    if name == "points" and "grid" in recipe:
        found = recipe["grid"][:1]
    if name == "depth":  # of a block, over the period
        found = [depth / max(recipe["surface"]["length"]) for depth in found]
    if name == "reduced_pressure" and not found:
        solid = recipe.get("solid", {})
        for pressure in numbers_in(recipe, "pressure") if len(solid) == 2 else ():
            modulus = solid["young"] / (1 - solid["poisson"] ** 2)
            found.append(pressure / (modulus * result.gradients[pressure]))
    return found[0] if len(found) == 1 else None


def _said_by_all(one: Reduced, read: Callable[[xr.Dataset], Any]) -> Array | None:
    def of_first(keys: list[str]) -> Any:
        solve = one.result.solve(keys[0])
        return None if solve is None else read(solve)

    for _, solves in sorted(solves_in(one.result.data).items()):
        made = _read_along(solves, one.variable, of_first)
        # Of a place that no solve says it is not known, unless nothing stands there.
        if made and made[1].any() and np.isnan(one.variable.values[~made[1]].astype(float)).all():
            return made[0]
    return None
