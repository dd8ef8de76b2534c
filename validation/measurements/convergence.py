"""Limits in what a grid does not refine: kappa as the sample grows, and as the bandwidth of the roughness grows."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import scipy.optimize
import scipy.special
import xarray as xr
from numpy.typing import ArrayLike

from validation.arrays import Array
from validation.errors import RunFailed, UsageError
from validation.execution.measurement import Call
from validation.measurements.common import SHIFTS, base_case, base_surface
from validation.measurements.limits import Measured, limits_of
from validation.measurements.measurement import grid_tolerance, grids_for, press_on_grids
from validation.measurements.statistics import pair_means
from validation.report.estimates import LIMIT, change, derive, error_of, mean, solved_places, total_error
from validation.report.places import gather
from validation.scenes.surfaces import spectrum_of
from validation.scenes.tables import SelfAffineSurface

#: Order in lambda_long/L: the number of long waves on a period grows like (L/lambda_long)^2, and corrections to the
#: mean of anything that depends on them fall with that number.
SIZE_ORDER = 2.0

#: A limit further from the last rung than this many times the span of all rungs is not determinable.
_REACH = 2.0

#: Qualifier of what is measured on each ladder: the dimension of its rungs, whose inverse goes to zero, and the source of
#: error that it measures.
LADDERS = {"by_bandwidth": ("bandwidth_rung", "bandwidth"), "by_size": ("periods_rung", "size")}


def bandwidth_order(hurst: float) -> float:
    """Order in lambda_short/lambda_long: 2 (1 - H).

    The long waves matter by their share in the mean square gradient, which falls so as shorter waves are
    added. That kappa follows is an argument and no law: from 64 to 256 the shipped table of wide bands falls
    with 0.6 to 0.8 times this order, so that what half of it would say is part of the error of a limit.

    >>> round(bandwidth_order(0.8), 12)
    0.4
    """
    return 2 * (1 - hurst)


# ---- a line through means ------------------------------------------------------------------------


class Line(NamedTuple):
    """A straight line through the means of several groups of samples; half widths are of 95 % intervals."""

    limit: float  # Value at x = 0
    slope: float
    limit_scatter: float  # Half widths that the scatter of the samples leaves, by Student's factor
    slope_scatter: float
    limit_drift: float  # By how much they move without the first group
    slope_drift: float
    reach: float  # Distance of x = 0 from the last group, over the span of all


def fitted_line(samples: Iterable[ArrayLike], x: ArrayLike, *, common: bool = False) -> Line:
    """Fit a straight line to the means of groups of independent samples, at places `x` towards 0.

    `common`: sample k is the same surface in every group, whose scatter then cancels in differences. All of
    it is NaN where one sample is.

    >>> line = fitted_line([[2.4, 2.6], [2.2, 2.4], [2.1, 2.3]], (0.4, 0.2, 0.1), common=True)
    >>> round(line.limit, 12), round(line.slope, 12)
    (2.1, 1.0)
    """
    groups = [np.asarray(group, dtype=float) for group in samples]
    at = np.asarray(x, dtype=float)
    if not all(np.isfinite(group).all() for group in groups):
        return Line(*[math.nan] * len(Line._fields))
    span = abs(at[0] - at[-1])
    if span == 0:  # one place has no line
        return Line(*[math.nan] * len(Line._fields))._replace(reach=math.inf)
    values, scatter = _least_squares(groups, at, common=common)
    later = _least_squares(groups[1:], at[1:], common=common)[0] if at.size > 2 else values
    return Line(*map(float, (*values, *scatter, *abs(later - values), abs(at[-1]) / span)))


def _least_squares(samples: Sequence[Array], x: Array, *, common: bool) -> tuple[Array, Array]:
    """Intercept and slope of the means of groups at x, and half widths of their 95 % intervals by scatter."""
    errors = np.array([group.std(ddof=1) / np.sqrt(group.size) for group in samples])
    # Groups of common surfaces scatter together: there equal weights lose nothing.
    # A group without scatter must not take all the weight.
    weight = np.ones_like(x) if common else 1 / np.maximum(errors, 1e-3 * errors.max() + 1e-300)
    design = np.stack([np.ones_like(x), x], axis=1)
    to_line = np.linalg.pinv(design * weight[:, None]) * weight  # of (intercept, slope) by group
    values = to_line @ np.array([group.mean() for group in samples])
    factor = float(scipy.special.stdtrit(min(group.size for group in samples) - 1, 0.975))
    if common:
        spread = (to_line @ np.stack(samples)).std(axis=1, ddof=1) / np.sqrt(samples[0].size)
    else:
        spread = np.sqrt(to_line**2 @ errors**2)
    return values, factor * spread


def line(
    data: xr.Dataset, name: str, *, x: str, along: str, over: str, common: bool, pairs: bool, drift: str
) -> xr.Dataset:
    """Add the line through means, ``x_each`` against a variable that goes to zero: its limit and slope with intervals.

    ``<name>_limit`` with its error, NaN where it is further off than two spans of the groups;
    ``<name>_slope`` with its error; ``<name>_reach``; the ends of the line, ``<name>_line`` over
    ``<x>_line`` (end). ``<name>_error`` of the means is taken over where there is one.

    Parameters
    ----------
    along, over : str
        Dimensions of the groups and of the samples.
    common, pairs : bool
        Whether sample k is the same surface in every group; whether surfaces 2k and 2k + 1 are +h and -h.
    drift : str
        Source of error to which it belongs how the line moves without its first group.
    """
    values = data[f"{name}_each"]

    def fit(rows: Array, solved: Array, steps: Array) -> Line:
        samples = [row[k] for row, k in zip(rows, solved, strict=True)]
        return fitted_line(map(pair_means, samples) if pairs else samples, steps, common=common)

    groups = [along, over]
    lines = xr.apply_ufunc(
        fit,
        values,
        solved_places(data, values, over=over),
        data[x],
        input_core_dims=[groups, groups, [along]],
        output_core_dims=[[] for _ in Line._fields],
        vectorize=True,
        keep_attrs=False,
    )
    n = dict(zip(Line._fields, lines, strict=True))
    made: dict[str, Any] = {"of": f"{name}_each", "x": x, "along": along, "over": over}
    made |= {"common": int(common), "pairs": int(pairs)}
    limit = n["limit"].where(n["reach"] <= _REACH).assign_attrs(made, reduction="line limit")
    slope = n["slope"].assign_attrs(made, reduction="line slope")
    last = data[x].max(along)
    ends = xr.concat([0 * last, last], "end").transpose(..., "end")
    added = {f"{name}_reach": n["reach"], f"{x}_line": ends.drop_attrs()}
    added[f"{name}_line"] = (limit + slope * ends).drop_attrs()
    for field, value in (("limit", limit), ("slope", slope)):
        sources: dict[str, Any] = {"surfaces": n[f"{field}_scatter"], drift: n[f"{field}_drift"]}
        if field == "limit" and f"{name}_error" in data:
            sources["grid"] = data[f"{name}_error"].sel(source="grid", drop=True).max(along, skipna=False)
        error = error_of(value.drop_attrs(), **sources).assign_attrs({LIMIT: drift})
        added |= {f"{name}_{field}": value, f"{name}_{field}_error": error}
    return data.assign(added)


def at_equal(data: xr.Dataset, name: str, *, x: str, along: str) -> xr.Dataset:
    """Add ``<name>_equal_each``: interpolated in ln x along a dimension to the largest ``x`` that all rows share.

    ``<x>_equal`` is that value; where the rows, along the other dimension of x, share none, values are NaN.
    """
    values, at = data[f"{name}_each"], data[x].transpose(..., along)
    common = float(at.isel({along: -1}).min())
    units = np.eye(at.sizes[along])
    rows = [[np.interp(np.log(common), np.log(row), unit) for unit in units] for row in at.values]
    weights = at.copy(data=np.array(rows)).where(common >= at.isel({along: 0}).max())
    made = {"reduction": "interpolation", "of": f"{name}_each", "x": x, "along": along}
    added: dict[str, Any] = {
        f"{name}_equal_each": (values * weights).sum(along, skipna=False).drop_attrs().assign_attrs(made),
        f"{x}_equal": common,
    }
    errors = data[f"{name}_each_error"]
    total = ((errors * weights) ** 2).sum(along, skipna=False) ** 0.5
    added[f"{name}_equal_each_error"] = total.transpose(..., "source").assign_attrs(errors.attrs)
    added[f"{name}_equal_each_drift"] = (data[f"{name}_each_drift"] * weights).sum(along, skipna=False)
    return data.assign(added)


# ---- ladders ------------------------------------------------------------------------------------


def pressed_pairs(
    surface: SelfAffineSurface,
    reduced_pressures: tuple[float, ...],
    points_per_wave: Sequence[float],
    *,
    pairs: int,
    shifts: int,
) -> list[Call]:
    """Return the solves of the first surfaces of a spectrum, +h and -h of each pair after each other."""
    case = base_case(surface, reduced_pressure=reduced_pressures[0])
    grids = grids_for(case, points_per_wave)
    return [
        press_on_grids(
            problem=replace(case.further(pair), inverted=inverted),
            reduced_pressures=reduced_pressures,
            grids=grids,
            shifts=shifts,
            tolerance=grid_tolerance(case, grids),
        )
        for pair in range(pairs)
        for inverted in (False, True)
    ]


def bandwidth_of(nayak: float, *, hurst: float, periods: float) -> float:
    """lambda_long/lambda_short at which Nayak's alpha of C(q) has a value, for one H."""

    def excess(bandwidth: float) -> float:
        surface = base_surface(hurst=hurst, periods=periods, bandwidth=bandwidth, seed=0)
        return spectrum_of(surface).moments().nayak - nayak

    if not excess(1.01) < 0 < excess(1e4):
        raise UsageError(
            f"equal_nayak = {nayak:g}: no bandwidth gives it at H = {hurst:g}; it must exceed 1.5"
        )
    return float(scipy.optimize.brentq(excess, 1.01, 1e4, xtol=1e-6))


#: A solve: which ladder, number of its H, rung, and number of the surface.
_Case = tuple[str, int, float, int]


@dataclass(frozen=True, kw_only=True)
class Ladders:
    """Which spectra are measured; defaults are those of the study `hurst`, whose stored solves others then share."""

    hursts: tuple[float, ...]
    # lambda_long/lambda_short of the bandwidth ladder, rising, on `periods`.
    bandwidths: tuple[float, ...] = (4.0, 8.0, 16.0, 32.0)
    # L/lambda_long of the size ladder, rising, with the smallest of `bandwidths`.
    sizes: tuple[float, ...] = (2.0, 4.0, 8.0)
    periods: float  # L/lambda_long of the bandwidth ladder
    # Pairs +h, -h on the rungs of the bandwidth ladder and on the largest sample; smaller samples get more of
    # them, so that each rung covers the same area.
    pairs: int = 4
    reduced_pressure: float
    points_per_wave: tuple[float, ...] = (4.0, 6.0)
    shifts: int = SHIFTS
    seed: int

    @property
    def cases(self) -> dict[_Case, Call]:
        """All solves in order; surfaces 2k and 2k + 1 are +h and -h."""
        calls: dict[_Case, Call] = {}
        rungs = [("by_bandwidth", of, self.periods, of, self.pairs) for of in self.bandwidths]
        for size in self.sizes:
            pairs = max(2, round(self.pairs * (self.sizes[-1] / size) ** 2))
            rungs.append(("by_size", size, size, self.bandwidths[0], pairs))
        loads, per_wave = (self.reduced_pressure,), self.points_per_wave
        for (i, hurst), (kind, rung, periods, bandwidth, pairs) in itertools.product(
            enumerate(self.hursts), rungs
        ):
            surface = base_surface(hurst=hurst, periods=periods, bandwidth=bandwidth, seed=self.seed)
            solves = pressed_pairs(surface, loads, per_wave, pairs=pairs, shifts=self.shifts)
            calls |= {(kind, i, rung, k): solve for k, solve in enumerate(solves)}
        return calls

    def reduced(self, measured: Measured) -> xr.Dataset:
        """Reduce the results of `cases`: kappa and Nayak's parameter on every rung, and the lines through the rungs.

        RunFailed for contacts too small for a limit of their area.
        """
        ladders = [self._ladder(kind, measured) for kind in LADDERS]
        data = xr.merge(ladders, compat="no_conflicts", combine_attrs="override")
        # H at equal alpha, and alpha at equal H.
        data = at_equal(data, "kappa_by_bandwidth", x="nayak_by_bandwidth", along="bandwidth_rung")
        data = change(data, "kappa_by_bandwidth", along="bandwidth_rung")
        data = change(data, "kappa_by_bandwidth_equal", along="ladder")
        names = (f"kappa_by_bandwidth{what}" for what in ("_equal", "_change", "_equal_change"))
        data = mean(data, *names, over="surface_by_bandwidth", pairs=True)
        return data.assign_coords(hurst_ladder=("ladder", list(self.hursts)))

    def _ladder(self, kind: str, measured: Measured) -> xr.Dataset:
        (rung, source), over = LADDERS[kind], f"surface_{kind}"
        common = kind == "by_bandwidth"
        parts = {case[1:]: limits_of(data) for case, data in measured.items() if case[0] == kind}
        names = {
            "area_each": f"area_{kind}_each",
            "nayak_each": f"nayak_{kind}_each",
            "solve": f"solve_{kind}",
        }
        names |= {f"area_each_{what}": f"area_{kind}_each_{what}" for what in ("error", "drift")}
        data = gather(parts, "ladder", rung, over).isel(load=0, drop=True).drop_vars("ladder")
        data = data[[*names]].rename(names)
        data[f"order_{kind}"] = "ladder", [bandwidth_order(h) if common else SIZE_ORDER for h in self.hursts]
        data["reduced_pressure_ladder"] = self.reduced_pressure
        kappa, area = f"kappa_{kind}", f"area_{kind}_each"
        made = {f"{kappa}_each": f"{area} / reduced_pressure_ladder"}
        data = derive(data, **made, **{f"step_{kind}": f"{rung} ** -order_{kind}"})
        if bool((data[area].isnull() & (data[f"solve_{kind}"] != "")).any()):
            raise RunFailed(
                f"ladder of the {source}: contacts are too small for a limit of their area: raise the load or "
                "the points per wave of the ladder; all solves are stored"
            )
        data = mean(data, kappa, f"nayak_{kind}", over=over, pairs=True)
        at = {"x": f"step_{kind}", "along": rung, "over": over}
        data = line(data, kappa, **at, common=common, pairs=True, drift=source)
        if not common:
            return data
        # What half the order would say; groups of the same surfaces have equal weights.
        steps = data[at["x"]] ** 0.5
        slower = line(data.assign({at["x"]: steps}), kappa, **at, common=True, pairs=True, drift=source)
        doubt = data[kappa].mean(rung) - slower[f"{kappa}_slope"] * steps.mean(rung) - data[f"{kappa}_limit"]
        error = data[f"{kappa}_limit_error"]
        total = (error**2 + doubt.where(error.source == source, 0.0) ** 2) ** 0.5
        return data.assign({error.name: total.transpose(*error.dims).assign_attrs(error.attrs)})


def spectral_errors(
    ladders: xr.Dataset, *, hurst: xr.DataArray | float, bandwidth: xr.DataArray | float, periods: float
) -> dict[str, xr.DataArray]:
    """Return how far kappa may be from that of an endless band and sample, relative, by source, for `claim`.

    With the step x at this bandwidth or sample it is (|slope| x + the larger of two half widths) / limit:
    that of slope x, and that of the limit by this source. NaN without a ladder of this H, or a limit.
    """
    shares: dict[str, Any] = {}
    for kind, (_, source) in LADDERS.items():
        name, value = f"kappa_{kind}", bandwidth if source == "bandwidth" else periods
        half = total_error(ladders, f"{name}_slope")
        assert half is not None
        doubt = ladders[f"{name}_limit_error"].sel(source=source, drop=True)
        limit = ladders[[f"{name}_limit", f"{name}_slope", f"order_{kind}"]].assign(half=half, doubt=doubt)
        limit = limit.swap_dims(ladder="hurst_ladder").rename(hurst_ladder="hurst")
        at = limit.reindex(hurst=np.atleast_1d(hurst), method="nearest", tolerance=1e-9)
        if np.ndim(hurst) == 0:
            at = at.isel(hurst=0, drop=True)
        step = value ** -at[f"order_{kind}"]
        moved = abs(at[f"{name}_slope"]) * step + np.fmax(at.half * step, at.doubt)
        shares[source] = moved / at[f"{name}_limit"]
    return shares
