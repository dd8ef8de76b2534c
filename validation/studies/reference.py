"""How large are contact area, gap, stiffness and energy of self-affine surfaces, with their total uncertainty?

The table that others can check against. Few pairs of surfaces +h, -h are solved on fine grids, many more on a coarse one
whose area follows the fine one from surface to surface; together they give the mean over all surfaces of a spectrum
(`validation.measures.controlled`). It is made once, shipped, and read by `fem-contact reference`.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy.stats
from numpy.typing import NDArray
from pydantic import Field

from fem_contact.contact import ContactResult
from fem_contact.stress import initial_slope
from validation.measures.common import Ladder, Rising, base_case, base_surface, persson_area, results_of
from validation.measures.controlled import Controlled, controlled_mean
from validation.measures.flow import StiffMeasurement
from validation.measures.measurement import area_limits, grid_for
from validation.measures.statistics import pair_means
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.realised import Realised
from validation.solves.bench import Bench
from validation.studies._options import Periods, Seed
from validation.studies._study import StudyOptions

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["QUANTITIES", "Options", "figures", "findings", "run", "table"]

Array = NDArray[np.float64]

#: Numbers of pairs are those of the options at this bandwidth, and in proportion to its inverse at others: surfaces with
#: fewer waves scatter more and cost less.
_USUAL_BANDWIDTH = 16.0
#: Of the solver. At light load single points decide, by some 4 % of a point: below 1e-4 of the area on these grids.
_TOLERANCE = 1e-6

#: Name: unit, meaning. All means over the surfaces of a spectrum.
QUANTITIES = {
    "area": "A/A0, edge located inside the cells, limit over grids",
    "gap": "mean gap / h_rms",
    "compliance": "p0 / (K h_rms), K = d p0 / d(approach), the contact conductance in other units; 0 in full contact",
    "energy": "elastic energy / that of full contact",
    "slope": "P'(0) (E* h'_rms)^2, fitted between .1 and .4 E* h'_rms",
    "patches": "contact patches per lambda_long^2",
}


class Options(StudyOptions):
    """Spectra and loads of the table, and how many surfaces each is a mean over."""

    own = "it makes the table that others are checked against, of surfaces it names"

    hursts: Rising = Field(
        default=(0.1, 0.3, 0.5, 0.8, 1.0), description="Hurst exponents H, rising, at most 1"
    )
    bandwidths: Rising = Field(default=(4.0, 8.0, 16.0), description="lambda_long / lambda_short, rising")
    reduced_pressures: Rising = Field(
        default=(0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.5),
        description="p* = p0 / (E* h'_rms) with the realised gradient of each surface, rising",
    )
    periods: Periods = 4.0
    pairs: int = Field(
        default=6, ge=4, description="pairs +h, -h on all grids at bandwidth 16; more in proportion below"
    )
    control_pairs: int = Field(
        default=80, ge=4, description="further pairs on the coarsest grid alone at bandwidth 16; more below"
    )
    points_per_wave: Ladder = Field(
        default=(3.0, 6.0, 12.0), description="grids, as lambda_short/dx, rising; the coarsest is the control"
    )
    shifts: int = Field(default=1, ge=1, le=8, description="sub-grid shifts along each axis")
    seed: Seed = 2006

    def pairs_of(self, bandwidth: float) -> tuple[int, int]:
        """Return how many pairs are solved on all grids, and on the coarsest alone."""
        more = max(1.0, _USUAL_BANDWIDTH / bandwidth)
        return int(np.ceil(more * self.pairs)), int(np.ceil(more * self.control_pairs))


@dataclass(frozen=True, kw_only=True)
class _Rich(StiffMeasurement):
    """A measurement with stiffness and the initial slope of P(sigma)."""

    @property
    def quantities(self) -> Mapping[str, tuple[str, str]]:
        return {**super().quantities, "slope": ("1", QUANTITIES["slope"])}

    def read_off(self, result: ContactResult, *, located: bool) -> dict[str, float]:
        return super().read_off(result, located=located) | {"slope": initial_slope(result).reduced}


#: A case: Hurst exponent, bandwidth, number of the pair, inverted, on all grids.
_Case = tuple[float, float, int, bool, bool]


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Solve all pairs of every spectrum, and take the controlled mean of each quantity.

    Returns
    -------
    xarray.Dataset
        Over (hurst, bandwidth, load), for each of `QUANTITIES`: the mean, `_half_width` (95 %, over surfaces), `_grid` (half
        width of what the grids leave, common to all surfaces), and `_error`, the root of their squares and the solver's;
        and `saving`, the time that as many fine surfaces as the same interval takes would cost over what was spent.
    """
    import xarray as xr

    measured = results_of(bench, _cases(options))
    shape = (len(options.hursts), len(options.bandwidths), len(options.reduced_pressures))
    values = {name: np.empty((3, *shape)) for name in QUANTITIES}
    saving = np.empty(shape)
    for at in np.ndindex(shape[:2]):
        hurst, bandwidth = options.hursts[at[0]], options.bandwidths[at[1]]
        fine, control, others = _collected(measured, options, hurst, bandwidth)
        for name, load in itertools.product(QUANTITIES, range(shape[2])):
            found = controlled_mean(
                pair_means(fine.values[name][load]),
                pair_means(control.values[name][load]),
                pair_means(others.values[name][load]),
            )
            estimate, left = found.estimate, fine.grid_error(name, load)
            values[name][(slice(None), *at, load)] = estimate.value, estimate.half_width, left
            if name == "area":
                saving[(*at, load)] = _saving(found, fine, others, load)
    dims = ("hurst", "bandwidth", "reduced_pressure")
    data: dict[str, tuple[tuple[str, ...], Array, dict[str, str]]] = {}
    for name, words in QUANTITIES.items():
        mean, half_width, grid = values[name]
        solver = _TOLERANCE * np.abs(mean)
        data[name] = (dims, mean, {"units": "1", "long_name": words})
        data[f"{name}_half_width"] = (
            dims,
            half_width,
            {"long_name": "half of the 95 % interval over surfaces"},
        )
        data[f"{name}_grid"] = (dims, grid, {"long_name": "half of the 95 % interval of the grid limit"})
        total = np.sqrt(half_width**2 + grid**2 + solver**2)
        data[f"{name}_error"] = (
            dims,
            total,
            {"long_name": "half of the 95 % interval: surfaces, grid, solver"},
        )
    data["saving"] = (
        dims,
        saving,
        {"long_name": "time of plain means of the same interval over the time spent"},
    )
    return xr.Dataset(
        data,
        coords={
            "hurst": list(options.hursts),
            "bandwidth": ("bandwidth", list(options.bandwidths), {"long_name": "lambda_long / lambda_short"}),
            "reduced_pressure": (
                "reduced_pressure",
                list(options.reduced_pressures),
                {"long_name": "p* = p0 / (E* h'_rms)"},
            ),
        },
        attrs={
            "study": "reference",
            "methods": "bem",
            "periods": options.periods,
            "points_per_wave": ", ".join(f"{n:g}" for n in options.points_per_wave),
            "pairs": ", ".join("{} + {}".format(*options.pairs_of(b)) for b in options.bandwidths),
            "tolerance": _TOLERANCE,
            "seed": options.seed,
        },
    )


def _cases(options: Options) -> dict[_Case, _Rich]:
    """List all surfaces of all spectra: those on all grids, then those on the coarsest alone."""
    found = {}
    for hurst, bandwidth in itertools.product(options.hursts, options.bandwidths):
        surface = base_surface(hurst=hurst, periods=options.periods, bandwidth=bandwidth, seed=options.seed)
        base = base_case(surface, reduced_pressure=options.reduced_pressures[0])
        grids = tuple(grid_for(base, points) for points in options.points_per_wave)
        fine, more = options.pairs_of(bandwidth)
        for k, inverted in itertools.product(range(fine + more), (False, True)):
            found[hurst, bandwidth, k, inverted, k < fine] = _Rich(
                realised=_of(base, k, inverted),
                reduced_pressures=options.reduced_pressures,
                grids=grids if k < fine else grids[:1],
                shifts=options.shifts,
                tolerance=_TOLERANCE,
            )
    return found


def _of(base: Realised, k: int, inverted: bool) -> Realised:
    return replace(base.further(k), inverted=inverted)


@dataclass(frozen=True, kw_only=True)
class _Samples:
    """What was read off some surfaces: arrays (load, surface) by quantity, and the standard error of each grid limit."""

    values: Mapping[str, Array]
    errors: Mapping[str, Array]
    seconds: Array

    def grid_error(self, name: str, load: int) -> float:
        """Half of the 95 % interval of what the grids leave: off to the same side on all surfaces, it does not average."""
        return float(1.96 * np.sqrt(np.mean(self.errors[name][load] ** 2)))


def _collected(
    measured: Mapping[_Case, xr.Dataset], options: Options, hurst: float, bandwidth: float
) -> tuple[_Samples, _Samples, _Samples]:
    """Return the fine values, those of the same surfaces on the coarsest grid, and those of the others there."""
    own = {case[2:]: data for case, data in measured.items() if case[:2] == (hurst, bandwidth)}
    fine = [data for (_, _, on_all), data in own.items() if on_all]
    more = [data for (_, _, on_all), data in own.items() if not on_all]
    coarse = [data.isel(grid=[0]) for data in fine]
    return (
        _samples(fine, options, limits=True),
        _samples(coarse, options, limits=False),
        _samples(more, options, limits=False),
    )


def _samples(measured: list[xr.Dataset], options: Options, *, limits: bool) -> _Samples:
    """Read all quantities; the area is the limit over the grids, or that located on the only one."""
    values = {name: np.array([_read(data, name, options) for data in measured]).T for name in QUANTITIES}
    errors = {name: np.zeros_like(one) for name, one in values.items()}
    if limits:
        area = [area_limits(data) for data in measured]
        values["area"] = np.array([value for value, _ in area]).T
        errors = {
            name: np.abs(
                np.array([_read(d, name, options) - _read(d, name, options, grid=-2) for d in measured])
            ).T
            / 2
            for name in QUANTITIES
        }
        errors["area"] = np.array([error for _, error in area]).T
    seconds = np.array([data.seconds.sum(("grid", "shift")).values for data in measured]).T
    return _Samples(values=values, errors=errors, seconds=seconds)


def _read(data: xr.Dataset, name: str, options: Options, *, grid: int = -1) -> Array:
    """Return one quantity of one surface over the loads, on one grid, mean over its shifts."""
    if name == "compliance":
        return np.asarray((1 / data.stiffness.isel(grid=grid)).mean("shift").values)
    mean = data.isel(grid=grid).mean("shift")
    scales = {
        "gap": ("mean_gap", 1 / data.attrs["rms_height"]),
        "energy": ("energy", 1 / data.attrs["full_contact_energy"]),
        "patches": ("patches", 1 / options.periods**2),
        "area": ("subcell", 1.0),
    }
    variable, scale = scales.get(name, (name, 1.0))
    return np.asarray(mean[variable].values * scale)


def _saving(found: Controlled, fine: _Samples, others: _Samples, load: int) -> float:
    """Return the processor time of plain Monte Carlo on single fine surfaces of the same interval over that spent."""
    single = fine.values["area"][load]
    each = float(fine.seconds[load].mean())
    spent = float(fine.seconds[load].sum() + others.seconds[load].sum())
    plain = (scipy.stats.norm.ppf(0.975) / found.estimate.half_width) ** 2 * float(single.var(ddof=1))
    return plain * each / spent


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each spectrum and load."""
    rows = []
    for h, b, j in itertools.product(
        *(range(dataset.sizes[name]) for name in ("hurst", "bandwidth", "reduced_pressure"))
    ):
        here = dataset.isel(hurst=h, bandwidth=b, reduced_pressure=j)
        area, load = float(here.area), float(here.reduced_pressure)
        rows.append(
            (
                float(here.hurst),
                float(here.bandwidth),
                load,
                area,
                100 * float(here.area_error) / area,
                100 * float(here.area_half_width) / area,
                100 * float(here.area_grid) / area,
                area / load,
                *(float(here[name]) for name in QUANTITIES if name != "area"),
                area / float(persson_area(load)),
                float(here.saving),
            )
        )
    columns = (
        "H",
        "lambda_long/lambda_short",
        "p*",
        "A/A0",
        "+- total [%]",
        "+- surfaces [%]",
        "+- grid [%]",
        "kappa",
        "gap/h_rms",
        "p0/(K h_rms)",
        "U/U_full",
        "P'(0)",
        "patches",
        "A/Persson",
        "saving",
    )
    return ResultTable.of(columns, rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Say how sure the table is, what the control saved, and how far the theory is off."""
    share = 100 * (dataset.area_error / dataset.area)
    light = share.sel(reduced_pressure=slice(None, 0.03))
    heavy = share.sel(reduced_pressure=slice(0.03, None))
    sentences = []
    for part, words in ((light, "p* below .03"), (heavy, "p* above .03")):
        if part.size:
            sentences.append(
                f"A/A0 at {words}: half of the 95 % interval is {float(part.median()):.2g} % in the median and "
                f"{float(part.max()):.2g} % at worst (surfaces, grid and solver; L/lambda_long = {dataset.attrs['periods']:g})."
            )
    saving = dataset.saving.median(("hurst", "reduced_pressure"))
    listed = ", ".join(
        f"{float(saving[b]):.3g} at {float(dataset.bandwidth[b]):g}" for b in range(saving.size)
    )
    sentences.append(
        "Plain means over single surfaces on the same grids would cost, for the same intervals, in the median so many times "
        f"what was spent, by lambda_long/lambda_short: {listed}."
    )
    excess = 100 * (dataset.area / persson_area(dataset.reduced_pressure.values) - 1)
    for j in sorted({0, dataset.sizes["reduced_pressure"] // 2, dataset.sizes["reduced_pressure"] - 1}):
        here = excess.isel(reduced_pressure=j)
        sentences.append(
            f"At p* = {float(dataset.reduced_pressure[j]):g} the area lies {float(here.min()):.3g} to {float(here.max()):.3g} % above Persson's, by "
            f"spectrum; +- {float(share.isel(reduced_pressure=j).max()):.2g} % at most."
        )
    return tuple(sentences)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw kappa over the load, and the theory over the table."""
    return (
        Drawing(
            name="reference",
            figure=_figure(dataset),
            data=dataset,
            caption="Left: kappa over the load for every Hurst exponent at the largest bandwidth, with the total 95 % interval. "
            "Right: Persson's area over that of the table, the mean over Hurst exponents for every bandwidth.",
        ),
    )


def _figure(dataset: xr.Dataset) -> Figure:
    from validation.report.figure import THEORY, look, new_figure, plain_look

    figure, (left, right) = new_figure(width=9.0, columns=2)
    load = dataset.reduced_pressure.values
    theory = persson_area(load)
    for h, hurst in enumerate(dataset.hurst.values):
        here = dataset.isel(hurst=h, bandwidth=-1)
        left.errorbar(load, here.area / load, yerr=here.area_error / load, label=f"H = {hurst:g}", **look(h))
    left.plot(load, theory / load, label="Persson", **THEORY)
    for b, bandwidth in enumerate(dataset.bandwidth.values):
        ratio = (theory / dataset.area.isel(bandwidth=b)).mean("hurst")
        label = rf"$\lambda_\mathrm{{long}}/\lambda_\mathrm{{short}}$ = {bandwidth:g}"
        right.plot(load, ratio, label=label, **plain_look(b))
    left.set_ylabel(r"$\kappa = (A/A_0) / p^*$")
    right.set_ylabel("Persson's area / that of the table")
    for axes in (left, right):
        axes.set_xscale("log")
        axes.set_xlabel(r"$p^* = p_0 / (E^* h'_\mathrm{rms})$")
        axes.legend(fontsize=7)
    return figure
