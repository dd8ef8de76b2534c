"""How good is Persson's theory, quantity by quantity and range by range, and are its variants better?"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field
from scipy.special import erf, erfinv

from persson import elastic
from persson.variants import corrected_contact_area
from validation.arrays import Array
from validation.measures.budget import Budget, budget_table, grid_share, solver_error
from validation.measures.common import named
from validation.measures.distributions import Distributions, distance_to_reference, largest_difference
from validation.measures.ladders import Ladders, spectral_errors
from validation.measures.limits import solved
from validation.measures.measurement import grid_for
from validation.measures.statistics import mean_over_surfaces
from validation.measures.theory import RANKED, VARIANTS
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.scene import Load
from validation.solves.bench import Bench
from validation.studies import pressure, stress_near_zero
from validation.studies.theory_verdict.others import with_theories
from validation.studies.theory_verdict.words import QUANTITIES, findings, table, verdict
from validation.theories import find_theory
from validation.units import Positive

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Options", "budget", "figures", "findings", "run", "table", "verdict"]

#: Below this, over h_rms, two gaps are both closed.
_CLOSED = 1e-6


class Options(pressure.Options):
    """Those of the study `pressure`, and what else is scored."""

    off: ClassVar[Mapping[str, Any]] = {"ladder_reduced_pressures": (), "edge": False}

    ladder_reduced_pressures: tuple[Positive, ...] = Field(
        default=(0.05, 0.4),
        description="p* at which it is measured how the area moves with bandwidth and sample, for the budget; none to leave it out",
    )
    theory: tuple[str, ...] = Field(
        default=(),
        description="further theories: bush-gibson-thomas, carbone-bottiglione, greenwood-williamson, or your own, my_module:area",
    )
    edge: bool = Field(
        default=True,
        description="also score P(sigma) at vanishing pressure, on the cases of `stress-near-zero`",
    )


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Score the theory and its variants on the cases of the studies `pressure` and `stress-near-zero`.

    The cases run in stages, study by study: a dry run lists those of the first.

    Returns
    -------
    xarray.Dataset
        ratio (quantity, variant, load): simulated over predicted, told the realised surface; interval: its 95 % half width;
        distance (variant, load): of the distribution of pressure from the predicted one.
    """
    for name in options.theory:
        find_theory(name)  # what is unknown is refused before anything is solved
    data = pressure.run(options, bench=bench)
    found = _scores(options, data)
    found["solver_error"] = _solver_share(options, bench)
    if options.edge:
        small = stress_near_zero.Options(hurst=options.hurst, periods=options.periods, seed=options.seed)
        edge = stress_near_zero.run(small, bench=bench).isel(method=0)
        found = found.merge(_edge_scores(edge), combine_attrs="override")
    if options.theory:
        pressed = [case.realised for case in pressure._cases(options)]
        found = with_theories(found, options.theory, data=data, pressed=pressed)
    return found.assign(_spectral_shares(options, bench)) if options.ladder_reduced_pressures else found


def _scores(options: Options, data: xr.Dataset) -> xr.Dataset:
    """Compare everything in the data of the study `pressure` with what is predicted."""
    import xarray as xr

    found = xr.Dataset(
        coords={
            "quantity": list(QUANTITIES),
            "variant": list(VARIANTS),
            "reduced_pressure": data.reduced_pressure,
        },
        attrs={
            "study": "theory-verdict",
            "methods": RANKED,
            **options.spectrum_words,
            "surfaces": options.surfaces,
        },
    )
    ratios, intervals = zip(*(_scored(data, name) for name in QUANTITIES), strict=True)
    dims = ("quantity", "variant", "load")
    found["ratio"] = named(dims, np.array(ratios), "simulated over predicted")
    found["interval"] = named(dims, np.array(intervals), "95 % half width of that ratio")
    found["area"] = named("load", data.area.mean("surface").values, "A/A0, limit over grids")
    found["distance"] = named(
        ("variant", "load"),
        _pressure_distances(data),
        "largest difference of the cumulated P(sigma) A0/A from the predicted one",
    )
    _add_claims(found, data)
    found["theory_area"] = data.theory_area
    found["shares"] = named(("load", "source"), _shares(data), "relative 95 % half widths of the area")
    return found.assign_coords(source=["grid", "surfaces"])


def _spectral_shares(options: Options, bench: Bench) -> dict[str, Any]:
    """How far the area may be from that of an endless sample and bandwidth, at the loads of the ladders."""
    import xarray as xr

    rows = []
    for load in options.ladder_reduced_pressures:
        ladders = Ladders(
            hursts=(options.hurst,), periods=options.periods, reduced_pressure=load, seed=options.seed
        )
        climbed = ladders.reduced(solved(bench, ladders.cases))
        shares = spectral_errors(
            climbed, hurst=options.hurst, bandwidth=options.bandwidth, periods=options.periods
        )
        rows.append([float(shares[source]) for source in ("size", "bandwidth")])
    coords = {
        "ladder_load": list(options.ladder_reduced_pressures),
        "spectral_source": ["finite size", "bandwidth"],
    }
    return {"spectral": xr.DataArray(rows, dims=("ladder_load", "spectral_source"), coords=coords)}


def _shares(data: xr.Dataset) -> Array:
    """Relative half widths of the area from grids and surfaces, (load, source)."""
    rows = []
    for j in range(data.sizes["load"]):
        values, errors, drifts = (data[name][:, j].values for name in ("area", "area_error", "area_drift"))
        estimate = mean_over_surfaces(values)
        rows.append((grid_share(values, errors=errors, drifts=drifts), estimate.half_width / estimate.value))
    return np.array(rows)


def _scored(data: xr.Dataset, name: str) -> tuple[Array, Array]:
    """Return simulated over predicted for every variant and load, and the half width of its 95 % interval."""
    simulated = [mean_over_surfaces(data[name][:, j].values) for j in range(data.sizes["load"])]
    value = np.array([s.value for s in simulated])
    half = np.array([s.half_width for s in simulated])
    if name == "area":
        half = np.hypot(half, _shares(data)[:, 0] * value)
    elif name == "gamma":
        # A difference of gaps: as uncertain as both, although their errors are alike.
        steps = np.abs(np.gradient(np.log(data.reduced_pressure.values)))
        half = np.hypot(half, data.gap_error.mean("surface").values / steps)
    else:
        half = np.hypot(half, data[f"{name}_error"].mean("surface").values)
    predicted = data[f"theory_{name}"].sel(mode="conditional").values
    if name in ("gap", "gamma"):
        closed = (predicted < _CLOSED) & (value < _CLOSED)
        ratio = np.where(closed, 1.0, value / np.where(closed, 1.0, predicted))
        return ratio, np.where(closed, 1e-9, half / np.where(closed, 1.0, predicted))
    # At full contact no surface differs from another: what is left is rounding, and it is no uncertainty of zero.
    return value / predicted, np.maximum(half, 1e-9) / predicted


def _pressure_distances(data: xr.Dataset) -> Array:
    """Distance of the simulated P(sigma) A0/A, surfaces pooled, from that of every variant; (variant, load)."""
    loads = data.reduced_pressure.values
    pooled = data.stress_share.sum("surface").values
    # What lies above the last edge counts in the last bin.
    upper = np.concatenate([[0.0], data.stress_upper.values[:-1], [np.inf]])
    rows = []
    for area in data.theory_area.sel(mode="conditional").values:
        width = _width(area, loads)[:, None]
        stress, load = upper / width, loads[:, None] / width
        below = 0.5 * (erf(stress - load) - erf(stress + load)) + erf(load)
        rows.append(largest_difference(pooled, np.diff(below, axis=1)))
    return np.array(rows)


def _width(area: Array, loads: Array) -> Array:
    """Return (2 V)^(1/2) over E* h'_rms of a variant: the variance that gives its area, V = p0^2 / (2 erfinv(A/A0)^2)."""
    # Where the area is 1 to rounding, the variance is that of full contact, E*^2 h'^2 / 4.
    closed = area > 1 - 1e-9
    return np.asarray(np.where(closed, np.sqrt(0.5), loads / erfinv(np.where(closed, 0.5, area))))


def _claimed(data: xr.Dataset) -> dict[str, xr.DataArray]:
    return {
        "pressure": data.stress_share,
        "patches": data.patch_area_share,
        "number": data.patch_number_share,
    }


def _add_claims(found: xr.Dataset, data: xr.Dataset) -> None:
    """Add the distances of the distributions at each load from those at the reference load."""
    reference = pressure.reference_load(data)
    for name, shares in _claimed(data).items():
        distance = distance_to_reference(shares.values, reference)
        found[f"{name}_moved"] = ("load", distance.value)
        found[f"{name}_moved_high"] = ("load", distance.high)
        found[f"{name}_moved_noise"] = ("load", distance.noise)
    found.attrs["reference_load"] = reference


def _solver_share(options: Options, bench: Bench) -> float:
    """Relative change of the area when the solves of one surface stop at a hundred times smaller residual."""
    usual = Distributions(
        realised=replace(options.first, load=Load(reduced_pressure=0.01)),
        reduced_pressures=(0.01, 0.1, 1.0),
        grids=tuple(grid_for(options.first, points) for points in (4.0, 6.0, 8.0)),
        shifts=options.shifts,
    )
    strict = replace(usual, tolerance=usual.tolerance / 100)
    solved = bench.solve([usual, strict])
    return solver_error(solved[usual], solved[strict])


def _edge_scores(edge: xr.Dataset) -> xr.Dataset:
    """P(0+) and the slope at zero, simulated against Persson's."""
    import xarray as xr

    value, slope = stress_near_zero.limit_at_zero(edge), stress_near_zero.limit_slope(edge)
    load, full = float(edge.attrs["reduced_pressure"]), elastic.stress_variance(1.0, contact_modulus=1.0)
    areas = np.array([corrected_contact_area(load, stress_variance=full, variant=name) for name in VARIANTS])
    predicted = elastic.initial_slope(load, stress_variance=_width(areas, np.array(load)) ** 2 / 2)
    return xr.Dataset(
        {
            "edge_value": value.value,
            "edge_value_half": value.half_width,
            "edge_slope_ratio": ("variant", slope.value / predicted),
            "edge_slope_half": ("variant", slope.half_width / predicted),
            "edge_pressure": load,
        },
        coords={"variant": list(VARIANTS)},
    )


def budget(dataset: xr.Dataset) -> ResultTable:
    """Return what is uncertain about the area over the theory at every load."""
    budgets = []
    for j, load in enumerate(dataset.reduced_pressure.values):
        shares = dict(zip(dataset.source.values.tolist(), dataset.shares.values[j].tolist(), strict=True))
        shares["solver"] = float(dataset.solver_error)
        words = f"A/A_Persson, p* = {load:g}"
        if dataset.sizes.get("ladder_load", 0):
            near = int(np.argmin(np.abs(np.log(dataset.ladder_load.values / load))))
            shares |= dict(
                zip(
                    dataset.spectral_source.values.tolist(),
                    dataset.spectral.values[near].tolist(),
                    strict=True,
                )
            )
            words += f" (spectrum: as at {float(dataset.ladder_load[near]):g})"
        budgets.append(Budget(quantity=words, value=float(dataset.ratio[0, 0, j]), shares=shares))
    return budget_table(budgets)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw simulated over predicted values against the area, quantity by quantity."""
    from validation.studies.theory_verdict import plots

    return (
        Drawing(
            name="theory-verdict",
            figure=plots.theory_verdict(dataset, list(QUANTITIES.values())),
            data=dataset[["ratio", "interval", "distance"]],
            caption="Simulated over predicted contact area (limit over grids), mean gap, stiffness and elastic energy for the theory and its variants, told the realised surface, with 95 % intervals; 1 is agreement. Thin, dashed: the original theory told C(q) alone.",
        ),
    )
