"""A number with its 95 % interval by source: how a dataset holds it, how it is reduced, how it is read.

A dataset keeps beside a variable ``x`` its errors as ``x_error`` with the further dimension ``source``:
half widths of 95 % intervals by `SOURCES`. NaN there says *not measured*, 0 *does not enter*; an attribute
named as the source says why. Half widths are kept and not standard errors, since Student's factor belongs
to the sample: so what is stored is what is shown, everywhere. Values of single surfaces are ``x_each``, and
how far they move without their coarsest grid is ``x_each_drift``. What a reduction made says how in its
attributes, from which the audit makes it again.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import scipy.special
import xarray as xr

from validation.arrays import Array
from validation.errors import UsageError, did_you_mean

#: Where an error comes from, in the order in which it is listed.
SOURCES = ("surfaces", "grid", "solver", "size", "bandwidth", "depth", "theory")
#: Those of the step from one spectrum and period to any: they are no part of the interval of a value for
#: its own, but of one that is a limit in them (attribute `LIMIT` of its errors).
SPECTRAL = ("size", "bandwidth")
LIMIT = "limit_in"
#: Attribute of errors that are of no source but of a fit: what they hold.
HOLDS = "holds"
#: Half width of a 95 % interval over the standard error, where that is known and not estimated from a few
#: samples.
NORMAL = float(scipy.special.ndtri(0.975))

#: Errors and scatter of less than this, relative, are those of the arithmetic.
_ROUNDING = 1e-14

_FUNCTIONS = {name: getattr(np, name) for name in ("abs", "exp", "log", "maximum", "minimum", "sqrt")}
_FUNCTIONS["erf"] = scipy.special.erf


# ---- errors --------------------------------------------------------------------------------------


def error_of(value: xr.DataArray, **sources: xr.DataArray | Array | float | str) -> xr.DataArray:
    """Return the errors of a variable from what is known of each source.

    Of a source is given half the width of its 95 % interval, or the reason why it does not enter. Sources
    that are not given are not measured (NaN).
    """
    if unknown := sources.keys() - set(SOURCES):
        others = ", ".join(sorted(unknown))
        raise UsageError(f"no source of errors is called {others}; they are: {', '.join(SOURCES)}")
    parts, why = [], {}
    for source in SOURCES:
        share = sources.get(source, math.nan)
        if isinstance(share, str):
            why[source], share = f"does not enter: {share}", 0.0
        if isinstance(share, xr.DataArray):
            share = _alike(share, value)
        parts.append(np.broadcast_to(np.asarray(share, dtype=float), value.shape))
    coords = {**value.coords, "source": list(SOURCES)}
    return xr.DataArray(np.abs(np.stack(parts, -1)), coords, (*value.dims, "source"), attrs=why)


def _of(data: xr.Dataset, name: str, who: str, along: str = "") -> xr.DataArray:
    if name in data.variables:
        if along and along not in data[name].dims:
            raise UsageError(
                f"{who}: {name!r} has no {along!r}; it is along {', '.join(map(str, data[name].dims))}"
            )
        return data[name]
    raise UsageError(f"{who}: no {name!r} in the dataset{did_you_mean(name, map(str, data.variables))}")


def optional(data: xr.Dataset, name: str) -> xr.DataArray | None:
    """Return a variable, or None; `Dataset.get` first looks for names like it, for milliseconds."""
    return data[name] if name in data.variables else None


def claim(data: xr.Dataset, *names: str, **sources: xr.DataArray | float | str) -> xr.Dataset:
    """Add or replace sources of the errors of variables, or say why one does not enter; see `error_of`."""
    added = {}
    for name in names:
        more = error_of(_of(data, name, "claim"), **sources)
        old = optional(data, f"{name}_error")
        if old is not None:
            wanted = np.isin(SOURCES, list(sources))
            more = more.copy(data=np.where(wanted, more.values, _alike(old, more)))
            # What is claimed does not follow from the reduction of the variable: the audit is told.
            claimed = {*str(old.attrs.get("claimed", "")).split(), *sources}
            kept = {name: words for name, words in old.attrs.items() if name not in sources}
            more.attrs = {**kept, **more.attrs, "claimed": " ".join(sorted(claimed))}
        added[f"{name}_error"] = more
    return _with(data, added)


def claim_shares(data: xr.Dataset, name: str, **shares: xr.DataArray | float) -> xr.Dataset:
    """Claim errors of a variable by what share of it they are."""
    return claim(data, name, **{source: share * abs(data[name]) for source, share in shares.items()})


def _with(data: xr.Dataset, added: Mapping[str, xr.DataArray]) -> xr.Dataset:
    """Assign arrays made of the dataset's own: their coordinates are its, and need not be aligned again."""
    coords = {} if "source" in data.coords else {"source": list(SOURCES)}
    errors = any("source" in value.dims for value in added.values())
    return data.assign({n: v.variable for n, v in added.items()}).assign_coords(coords if errors else {})


def bare(value: xr.DataArray, **attributes: Any) -> xr.DataArray:
    """Values and dimensions with these attributes alone, not with those of what it was made from."""
    return xr.DataArray(value.values, dims=value.dims, attrs=attributes)


def total_error(data: xr.Dataset, name: str, *, sources: Iterable[str] | None = None) -> xr.DataArray | None:
    """Root sum of squares over the sources that were measured.

    NaN where none of those that enter was, None for what has no errors.

    Size and bandwidth, which belong to the step to any spectrum, are left out unless they are named, or the
    variable is a limit in one of them.
    """
    errors = optional(data, f"{name}_error")
    if errors is None:
        return None
    total = _total(errors.variable, errors.source.values.tolist(), sources)
    return errors.isel(source=0, drop=True).copy(data=total).assign_attrs({})


def error_here(data: xr.Dataset, name: str) -> tuple[float | None, str]:
    """Total error of a single number, and what it holds; see `total_error` and `sources_of`."""
    if f"{name}_error" not in data.variables:
        return None, ""
    total = float(_total(data.variables[f"{name}_error"], data.variables["source"].values.tolist()).item())
    return total, sources_of(data[f"{name}_error"].squeeze()) if total > 0 else ""


def _total(errors: xr.Variable, names: Sequence[str], sources: Iterable[str] | None = None) -> Array:
    asked = list(shown_sources(errors) if sources is None else sources)
    half = np.moveaxis(errors.values, errors.get_axis_num("source"), -1)[..., [*map(names.index, asked)]]
    enter = [source not in errors.attrs for source in asked]
    measured = ~np.isnan(half[..., enter if any(enter) else slice(None)]).all(axis=-1)
    return np.where(measured, np.sqrt(np.nansum(half**2, axis=-1)), np.nan)


def sources_of(errors: xr.DataArray) -> str:
    """Name what a +- holds where not every source that enters was measured; empty where it holds all.

    >>> import xarray as xr
    >>> area = claim(xr.Dataset({"area": 0.1}), "area", grid=0.002, depth="a half-space")
    >>> sources_of(area.area_error)
    'grid'
    """
    if HOLDS in errors.attrs:
        return str(errors.attrs[HOLDS])
    half = dict(zip(errors.source.values.tolist(), errors.values.tolist(), strict=True))
    enter = [source for source in shown_sources(errors) if source not in errors.attrs]
    complete = not any(math.isnan(half[source]) for source in enter)
    return "" if complete else ", ".join(source for source in shown_sources(errors) if half[source] > 0)


def shown_sources(errors: xr.DataArray | xr.Variable) -> tuple[str, ...]:
    """Return which sources are part of the interval of a value for its own spectrum and period."""
    return tuple(s for s in SOURCES if s not in SPECTRAL or s == errors.attrs.get(LIMIT))


# ---- reductions ----------------------------------------------------------------------------------


def mean(
    data: xr.Dataset, *names: str, over: str = "surface", pairs: bool = False, alike: bool = False
) -> xr.Dataset:
    """Add means over surfaces: ``x`` from ``x_each``, with Student's 95 % interval and what the grids leave.

    Errors of single surfaces that are independent (``x_each_error`` of the grid) shrink like the root of
    their number, unless the grids are off to the same side on all surfaces (`alike`); errors of other
    sources do not. Of drifts the mean counts, with its sign, and the error that it has by their size. With
    `pairs` surfaces 2k and 2k + 1 are +h and -h: anti-correlated, and one sample together. Places that were
    never solved (`solved_places`) are no samples;
    one that was solved and has no value leaves the mean without one.
    """
    added: dict[str, xr.DataArray] = {}
    for name in names:
        values = _of(data, f"{name}_each", f"mean of {name!r}", over)
        place, axis = values.isel({over: 0}, drop=True), values.get_axis_num(over)
        solved = _alike(solved_places(data, values, over=over), values)
        middle, half = mean_of(values.values, axis, pairs=pairs, there=solved)
        sources: dict[str, Any] = {"surfaces": half}
        of = optional(data, f"{name}_each_error")
        if of is not None:
            of_each = dict(zip(SOURCES, np.moveaxis(_alike(of, error_of(values)), -1, 0), strict=True))
            grid = _mean(of_each["grid"] ** 2, axis, solved)
            sources["grid"] = (grid / (1 if alike else solved.sum(axis))) ** 0.5
            sources |= {source: _mean(of_each[source], axis, solved) for source in SOURCES[2:]}
        drift = optional(data, f"{name}_each_drift")
        if drift is not None:
            moved = _alike(drift, values)
            # Drifts of either sign that cancel by chance are no smaller for it.
            scattered = (_mean(moved**2, axis, solved) / solved.sum(axis)) ** 0.5
            moved = np.hypot(_mean(moved, axis, solved), scattered)
            sources["grid"] = np.hypot(sources.get("grid", 0.0), moved)
        made: dict[str, Any] = {"reduction": "mean", "of": f"{name}_each", "over": over}
        made |= {"pairs": int(pairs), "alike": int(alike)}
        # An error that rounding explains is none.
        least = _ROUNDING * abs(middle)
        sources = {source: np.where(half < least, 0.0, half) for source, half in sources.items()}
        error = error_of(place, **sources)
        if of is not None:
            error.attrs |= of.attrs
        added |= {name: place.copy(data=middle).assign_attrs(made), f"{name}_error": error}
    return _with(data, added)


def same_of_all(data: xr.Dataset, *names: str) -> xr.Dataset:
    """Add means of what a theory says of surfaces that it is told the same of: no sample, and no interval."""
    return derive(data, **{name: f"{name}_each.mean('surface', skipna=False)" for name in names})


def claim_surfaces(data: xr.Dataset, name: str, each: str, *, of: Mapping[str, Any]) -> xr.Dataset:
    """Claim the surfaces' share of what is derived of means by what it is on single surfaces, `each`.

    Of the same surfaces the scatter is common; of others this is as wide as if they were independent. `of`
    are the attributes of the means; what is derived of anything else, or of one surface, stays as it is.
    """
    if of.get("reduction") != "mean" or each not in data or f"{name}_error" not in data:
        return data
    one = data[[each]].rename({each: "single_each"})
    found = mean(one, "single", over=of["over"], pairs=bool(of["pairs"])).single_error
    half, both = (errors.sel(source="surfaces", drop=True) for errors in (found, data[f"{name}_error"]))
    return claim(data, name, surfaces=half.fillna(both))


def mean_of(
    samples: Array, axis: int, *, there: Array | bool = True, pairs: bool = False
) -> tuple[Array, Array]:
    """Mean along an axis, and half of its 95 % interval by Student's factor.

    Where one surface has no value the mean has none: the others are not a fair sample. A single sample has
    no interval. Where not all are `there`, the mean is over those that are.
    """
    samples, there = (np.moveaxis(np.broadcast_to(a, samples.shape), axis, 0) for a in (samples, there))
    if pairs:
        samples, there = (samples[::2] + samples[1::2]) / 2, there[::2]
    count, middle = there.sum(0), _mean(samples, 0, there)
    with np.errstate(invalid="ignore"):  # of what is endless it is unknown
        squares = np.where(there, (samples - middle) ** 2, 0.0).sum(0)
    scatter = (squares / np.where(count > 1, count - 1, math.nan)) ** 0.5
    # What is the same on every surface scatters by rounding alone.
    scatter = np.where(scatter < _ROUNDING * abs(middle), 0.0, scatter)
    student = scipy.special.stdtrit(np.maximum(count - 1, 1), 0.975)
    return middle, scatter * student / np.maximum(count, 1) ** 0.5


def _alike(values: xr.DataArray, like: xr.DataArray) -> Array:
    """Values along the dimensions of another array, in their order."""
    if values.dims != like.dims:
        values = values.broadcast_like(like).transpose(*like.dims)
    return values.values


def _mean(values: Array, axis: int, there: Array) -> Array:
    """Mean over the samples that are there; NaN where one of them is."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(there, values, 0.0).sum(axis) / there.sum(axis))


def solved_places(data: xr.Dataset, values: xr.DataArray, *, over: str) -> xr.DataArray:
    """Return which places of a variable were solved: where its ``solve`` is named; all if it has none.

    The solves of a variable are in the one whose name begins with ``solve`` and whose dimensions it has all.
    """
    for name in (name for name in data.data_vars if str(name).startswith("solve")):
        named = data[name]
        if over in named.dims and set(named.dims) <= set(values.dims):
            return named != ""
    return xr.ones_like(values, bool)


def change(data: xr.Dataset, name: str, *, along: str, first: int = 0, last: int = -1) -> xr.Dataset:
    """Add ``x_change_each``: by how much ``x_each`` differs between two places, relative, surface by surface.

    Errors of the two places are taken as independent. Of a place with itself it is not determinable: NaN.
    """
    values = _of(data, f"{name}_each", f"change of {name!r}", along)

    def ends(of: xr.DataArray) -> list[xr.DataArray]:
        return [of.isel({along: k}, drop=True) for k in (last, first)]

    end, start = ends(values)
    if first % values.sizes[along] == last % values.sizes[along]:
        end = end * math.nan
    made = {"reduction": "change", "of": f"{name}_each", "along": along, "first": first, "last": last}
    added = {f"{name}_change_each": bare(end / start - 1, **made)}
    errors = optional(data, f"{name}_each_error")
    if errors is not None:
        error, before = ends(errors)
        total = ((error / end) ** 2 + (before / start) ** 2) ** 0.5 * abs(end / start)
        added[f"{name}_change_each_error"] = total.transpose(*end.dims, "source").assign_attrs(errors.attrs)
    drift = optional(data, f"{name}_each_drift")
    if drift is not None:
        moved, before = ends(drift)
        added[f"{name}_change_each_drift"] = (moved - before * end / start) / start
    return _with(data, added)


def reduce(data: xr.Dataset, how: str, *names: str) -> xr.Dataset:
    """Add ``x`` from ``x_each`` without an interval: its "mean", "max" or "sum" over the surfaces.

    For what is no sample of a mean: costs, residuals.
    """
    return derive(data, **{name: f"{name}_each.{how}('surface')" for name in names})


def derive(data: xr.Dataset, **expressions: str) -> xr.Dataset:
    """Add variables by expressions of others, errors carried along to first order, source by source.

    Expressions are sums, products, powers and ``abs, exp, log, sqrt, erf, maximum, minimum`` of variables and
    numbers, and ``x.mean('surface')``, as are the largest and the sum.

    >>> import xarray as xr
    >>> data = xr.Dataset({"area": 0.1, "pressure": 0.05})
    >>> data = claim(data, "area", grid=0.002)
    >>> kappa = derive(data, kappa="area / pressure")
    >>> kappa.kappa.item(), round(kappa.kappa_error.sel(source="grid").item(), 12)
    (2.0, 0.04)
    """
    for name, expression in expressions.items():
        names = {n.id for n in ast.walk(ast.parse(expression)) if isinstance(n, ast.Name)}
        point = {str(n): data[n] for n in sorted(names & {str(n) for n in data.variables})}
        for absent in sorted(names - set(point) - set(_FUNCTIONS)):
            _of(data, absent, f"{name} = {expression}")
        at = partial(_moved, expression, point)
        value = at({})
        value = value.transpose(*(dim for dim in data.sizes if dim in value.dims))
        added = {name: bare(value, reduction="expression", expression=expression)}
        errors = [{n: data[f"{n}_error"]} for n in point if f"{n}_error" in data]
        if errors:
            shifts = [_shift(value, at(error), at(error, -1)) for error in errors]
            total = sum((shift**2 for shift in shifts[1:]), shifts[0] ** 2) ** 0.5
            first, *others = (e.attrs for error in errors for e in error.values())
            why = {s: words for s, words in first.items() if all(s in other for other in others)}
            added[f"{name}_error"] = bare(total.transpose(*value.dims, "source"), **why)
        drifts = [at({n: data[f"{n}_drift"]}) - value for n in point if f"{n}_drift" in data]
        if drifts:
            added[f"{name}_drift"] = bare(sum(drifts[1:], drifts[0]))
        data = _with(data, added)
    return data


def _shift(value: xr.DataArray, up: xr.DataArray, down: xr.DataArray) -> xr.DataArray:
    """Half of what lies between both ends of an interval; at a kink, with both on one side, the further."""
    kink = (up - value) * (down - value) > 0
    return ((up - down) / 2).where(~kink, np.maximum(abs(up - value), abs(down - value)))


def ratio_of_means(above: str, below: str, over: str) -> str:
    """Expression whose mean over surfaces is the ratio of two means, and whose scatter is that of the ratio.

    To first order (Cochran, Sampling Techniques, Sec. 6.4); ratios of single surfaces have no mean where what
    they are divided by may vanish on one.
    """
    mean = f"{below}.mean('{over}')"
    return f"{above} / {mean} + {above}.mean('{over}') / {mean} * (1 - {below} / {mean})"


def evaluated(expression: str, values: Mapping[str, Any]) -> Any:
    """Evaluate one of our own expressions of arrays, without warnings where it has no finite value.

    A UsageError for a name that is none of the values.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        try:
            return eval(expression, {"__builtins__": {}, **_FUNCTIONS}, dict(values))
        except NameError as error:
            raise UsageError(f"{expression!r}: {error}") from None


def _moved(
    expression: str, point: Mapping[str, xr.DataArray], by: Mapping[str, xr.DataArray], sign: int = 1
) -> xr.DataArray:
    """Value of an expression where some variables are moved."""
    return xr.DataArray(evaluated(expression, {**point, **{n: point[n] + sign * b for n, b in by.items()}}))


def power_law(data: xr.Dataset, name: str, *, of: str, x: str, along: Sequence[str]) -> xr.Dataset:
    """Add the exponent of a power of `x`, by least squares of logarithms; ``NAME_factor`` is its value at 1.

    The fit is over the dimensions `along`. The interval is Student's, of the scatter around the line; what is
    not positive or not there is left out, and with less than three points the exponent has no interval.
    """
    import scipy.stats

    def fit(y: Array, at: Array) -> tuple[float, float, float]:
        valid = np.isfinite(y) & (y > 0) & np.isfinite(at)
        y, at = y[valid], at[valid]
        if np.unique(at).size < 2:
            return math.nan, math.nan, math.nan
        line = scipy.stats.linregress(np.log(at), np.log(y))
        student = float(scipy.special.stdtrit(y.size - 2, 0.975)) if y.size > 2 else math.nan
        return float(line.slope), student * float(line.stderr), float(np.exp(line.intercept))

    values, at = (_of(data, one, f"power law {name!r}") for one in (of, x))
    core: dict[str, Any] = {"input_core_dims": [list(along)] * 2, "output_core_dims": [[], [], []]}
    exponent, half, factor = xr.apply_ufunc(fit, values, at.broadcast_like(values), vectorize=True, **core)
    made = {"reduction": "power law", "of": of, "x": x, "along": " ".join(along)}
    exponent, factor = (fitted.assign_attrs(made) for fitted in (exponent, factor))
    error = error_of(exponent, surfaces=half).assign_attrs({HOLDS: "scatter around the fit"})
    return data.assign({name: exponent, f"{name}_error": error, f"{name}_factor": factor})
