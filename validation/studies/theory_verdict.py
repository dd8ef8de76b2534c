"""How good is Persson's theory, quantity by quantity and range by range, and are its variants better?"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import erf, erfinv

from persson import elastic
from persson.variants import corrected_contact_area
from validation.measures.budget import Budget, budget_table, grid_share, solver_error
from validation.measures.common import base_surface, measure, solid_of
from validation.measures.distributions import Distributions
from validation.measures.load_independence import distance_to_reference, largest_difference
from validation.measures.measurement import grid_for
from validation.measures.spectrum_limits import spectral_share, usual_ladders
from validation.measures.statistics import mean_over_surfaces
from validation.measures.theory import modes_sentence
from validation.measures.theory_energy import VARIANTS
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.solves.bench import Bench
from validation.studies import pressure as pressure_study
from validation.studies import stress_near_zero

if TYPE_CHECKING:
    import xarray as xr

    from validation.scenes.scene import Scene

__all__ = ["budget", "figures", "findings", "run", "table", "verdict"]

_RANGES = ((0.0, 0.03), (0.03, 0.1), (0.1, 0.3), (0.3, 0.7), (0.7, 0.99), (0.99, 1.001))

#: Quantities scored as ratios, and how they are called.
QUANTITIES = {
    "area": "contact area",
    "gap": "mean gap",
    "gamma": "stiffness, as p0/(K h_rms)",
    "energy": "elastic energy",
}

#: Below this, over h_rms, two gaps are both closed.
_CLOSED = 1e-6


def run(
    *,
    scene: Scene | None = None,
    bench: Bench | None = None,
    reduced_pressures: tuple[float, ...] = pressure_study.LOADS,
    hurst: float = 0.8,
    size: float = 4.0,
    ratio: float = 8.0,
    surfaces: int = 8,
    points_per_wave: tuple[float, ...] = (4.0, 8.0, 16.0),
    shifts: int = 2,
    ladder_pressures: tuple[float, ...] = (0.05, 0.4),
    edge: bool = True,
    seed: int = 2006,
) -> xr.Dataset:
    """Score the theory and its variants on the cases of the studies `pressure` and `stress-near-zero`.

    The cases run in stages, study by study: a dry run lists those of the first.

    Parameters
    ----------
    scene : Scene, optional
        Gives the solid; nothing reported depends on it.
    bench : Bench, optional
        Where and how the cases run.
    reduced_pressures : tuple of float
        p*, rising.
    hurst, size, ratio : float
        H, L/lambda_long and lambda_long/lambda_short.
    surfaces : int
        Realisations.
    points_per_wave : tuple of float
        Grids, as lambda_short/dx, rising.
    shifts : int
        Sub-grid shifts along each axis.
    ladder_pressures : tuple of float
        Loads at which it is measured how the area moves with bandwidth and sample, for the budget; none to leave it out.
    edge : bool
        Also score P(sigma) at vanishing pressure, on the cases of `stress-near-zero`.
    seed : int
        Of the first surface.

    Returns
    -------
    xarray.Dataset
        ratio (quantity, variant, load): simulated over predicted, told the realised surface; interval: its 95 % half width;
        distance (variant, load): of the distribution of pressure from the predicted one.
    """
    import xarray as xr

    common = {"scene": scene, "bench": bench, "size": size, "hurst": hurst, "seed": seed}
    data = pressure_study.run(
        reduced_pressures=reduced_pressures,
        ratio=ratio,
        surfaces=surfaces,
        points_per_wave=points_per_wave,
        shifts=shifts,
        **common,  # type: ignore[arg-type]
    )
    found = xr.Dataset(
        coords={
            "quantity": list(QUANTITIES),
            "variant": list(VARIANTS),
            "reduced_pressure": data.reduced_pressure,
        },
        attrs={"study": "theory-verdict", "hurst": hurst, "size": size, "ratio": ratio, "surfaces": surfaces},
    )
    ratios, intervals = zip(*(_scored(data, name) for name in QUANTITIES), strict=True)
    dims = ("quantity", "variant", "load")
    found["ratio"] = (dims, np.array(ratios), {"long_name": "simulated over predicted"})
    found["interval"] = (dims, np.array(intervals), {"long_name": "95 % half width of that ratio"})
    found["area"] = ("load", data.area.mean("surface").values, {"long_name": "A/A0, limit over grids"})
    found["distance"] = (
        ("variant", "load"),
        _pressure_distances(data),
        {"long_name": "largest difference of the cumulated P(sigma) A0/A from the predicted one"},
    )
    _add_claims(found, data)
    found["theory_area"] = data.theory_area
    found["shares"] = (
        ("load", "source"),
        _shares(data),
        {"long_name": "relative 95 % half widths of the area"},
    )
    found = found.assign_coords(source=["grid", "surfaces"])
    found["solver_error"] = _solver_share(
        scene,
        bench,
        surface_options={"hurst": hurst, "size": size, "ratio": ratio, "seed": seed},
        shifts=shifts,
    )
    if edge:
        found = found.merge(_edge_scores(stress_near_zero.run(**common)), combine_attrs="override")  # type: ignore[arg-type]
    if not ladder_pressures:
        return found
    spectral = np.empty((len(ladder_pressures), 2))
    for k, load in enumerate(ladder_pressures):
        ladders = usual_ladders(
            hurst=hurst, size=size, reduced_pressure=load, solid=solid_of(scene), seed=seed
        )
        climbed = ladders.dataset(measure(bench, ladders.cases))
        steps = {"size": 1 / size, "bandwidth": 1 / ratio}
        spectral[k] = [spectral_share(climbed, kind, hurst=hurst, step=step) for kind, step in steps.items()]
    found["spectral"] = (("ladder_load", "spectral_source"), spectral)
    return found.assign_coords(
        ladder_load=list(ladder_pressures), spectral_source=["finite size", "bandwidth"]
    )


def _shares(data: xr.Dataset) -> np.ndarray:
    """Relative half widths of the area from grids and surfaces, (load, source)."""
    rows = []
    for j in range(data.sizes["load"]):
        values, errors, drifts = (data[name][:, j].values for name in ("area", "area_error", "area_drift"))
        estimate = mean_over_surfaces(values)
        rows.append((grid_share(values, errors=errors, drifts=drifts), estimate.half_width / estimate.value))
    return np.array(rows)


def _scored(data: xr.Dataset, name: str) -> tuple[np.ndarray, np.ndarray]:
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


def _pressure_distances(data: xr.Dataset) -> np.ndarray:
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


def _width(area: np.ndarray, loads: np.ndarray) -> np.ndarray:
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
    reference = pressure_study.reference_load(data)
    for name, shares in _claimed(data).items():
        distance = distance_to_reference(shares.values, reference)
        found[f"{name}_moved"] = ("load", distance.value)
        found[f"{name}_moved_high"] = ("load", distance.high)
        found[f"{name}_moved_noise"] = ("load", distance.noise)
    found.attrs["reference_load"] = reference


def _solver_share(
    scene: Scene | None, bench: Bench | None, *, surface_options: dict[str, float], shifts: int
) -> float:
    """Relative change of the area when the solves of one surface stop at a hundred times smaller residual."""
    options = dict(surface_options)
    surface = base_surface(
        hurst=options["hurst"], size=options["size"], ratio=options["ratio"], seed=int(options["seed"])
    )
    usual = Distributions(
        surface=surface,
        solid=solid_of(scene),
        reduced_pressures=(0.01, 0.1, 1.0),
        grids=tuple(grid_for(surface, points) for points in (4.0, 6.0, 8.0)),
        shifts=shifts,
    )
    first, second = measure(bench, [usual, replace(usual, tolerance=usual.tolerance / 100)])
    return solver_error(first, second)


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
        }
    )


def verdict(ratio: float, interval: float) -> str:
    """Return a word for a simulated over a predicted value with its 95 % half width.

    Examples
    --------
    >>> verdict(1.0, 1e-9), verdict(1.02, 0.03), verdict(1.36, 0.03), verdict(0.9, 0.3)
    ('exact', 'right within 5 %', 'off by +36 %', 'not determinable')
    """
    if not np.isfinite(ratio):
        return "says nothing"
    if interval < 1e-6 and abs(ratio - 1) < 1e-4:
        return "exact"
    if abs(ratio - 1) <= interval:
        return (
            f"right within {100 * (abs(ratio - 1) + interval):.2g} %"
            if interval < 0.1
            else "not determinable"
        )
    return f"off by {100 * (ratio - 1):+.2g} %" if ratio < 2 else f"off by a factor of {ratio:.2g}"


def _range_verdict(ratios: np.ndarray, intervals: np.ndarray) -> str:
    """Return the verdict on several loads: the worst that is decided against, or else the load that is known best."""
    told = np.abs(ratios - 1) > intervals
    if told.any():
        pick = int(np.argmax(np.where(told, np.abs(ratios - 1), -1.0)))
    else:
        pick = int(np.argmin(np.where(np.isfinite(intervals), intervals, np.inf)))
    return verdict(float(ratios[pick]), float(intervals[pick]))


def _inside(dataset: xr.Dataset) -> list[tuple[str, np.ndarray]]:
    """Ranges of the area that hold loads, in words, with their loads."""
    area = dataset.area.values
    ranges = [
        (f"{low:g} to {min(high, 1.0):g}", np.flatnonzero((area >= low) & (area < high)))
        for low, high in _RANGES
    ]
    return [(words, loads) for words, loads in ranges if loads.size]


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each quantity and range of contact area: the verdict on every variant."""
    rows: list[tuple[float | str, ...]] = []
    ranges = _inside(dataset)
    for q, words in enumerate(QUANTITIES.values()):
        for area, loads in ranges:
            ratio, interval = (dataset[name][q].values[:, loads] for name in ("ratio", "interval"))
            cells = [_range_verdict(*row) for row in zip(ratio, interval, strict=True)]
            rows.append((words, area, *cells))
    for area, loads in ranges:
        distances = dataset.distance.values[:, loads].max(axis=1)
        rows.append(("P(sigma) A0/A", area, *(f"differs by up to {d:.3f}" for d in distances)))
    if "edge_value" in dataset:
        rows += _edge_rows(dataset)
    for name, words in _CLAIMS.items():
        for area, loads in ranges:
            # The claim is about light contact.
            if dataset.area.values[loads].min() > _LIGHT:
                continue
            rows.append((words, area, _claim(dataset, name, loads), *["says nothing"] * (len(VARIANTS) - 1)))
    return ResultTable.of(("quantity", "A/A0", *VARIANTS.values()), rows)


_CLAIMS = {
    "pressure": "P(sigma) A0/A independent of load (Secs. 3.3, 13)",
    "patches": "patch sizes by area independent of load (Secs. 3.3, 13)",
    "number": "patch sizes by number independent of load (Secs. 3.3, 13)",
}


#: Relative area beyond which nobody claims that distributions stay.
_LIGHT = 0.3


def _claim(dataset: xr.Dataset, name: str, loads: np.ndarray) -> str:
    """Return the verdict on a claim of independence within one range: the load that moved most."""
    loads = loads[loads != int(dataset.attrs["reference_load"])]
    if not loads.size:
        return "the reference"
    moved, high, noise = (dataset[f"{name}_moved{end}"].values[loads] for end in ("", "_high", "_noise"))
    told = moved > noise
    if told.any():
        return f"moved by {moved[told].max():.3f}"
    known = int(np.argmin(high))
    return f"right within {high[known]:.3f}" if high[known] < 0.1 else "not determinable"


def _edge_rows(dataset: xr.Dataset) -> list[tuple[float | str, ...]]:
    where = f"at p* = {float(dataset.edge_pressure):g}"
    value, half = float(dataset.edge_value), float(dataset.edge_value_half)
    zero = f"right within {abs(value) + half:.3f}" if abs(value) <= half else f"off by {value:+.3f}"
    slopes = [
        verdict(float(ratio), float(interval))
        for ratio, interval in zip(dataset.edge_slope_ratio, dataset.edge_slope_half, strict=True)
    ]
    return [("P(0+) E*h' = 0", where, *[zero] * len(VARIANTS)), ("slope of P(sigma) at 0", where, *slopes)]


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


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return the verdicts in sentences."""
    sentences = []
    area = dataset.ratio.sel(quantity="area")
    half = dataset.interval.sel(quantity="area")
    for i, name in enumerate(VARIANTS.values()):
        ratio = area[i].values
        told = np.abs(ratio - 1) > half[i].values
        worst = int(np.argmax(np.where(told, np.abs(ratio - 1), 0.0)))
        sentences.append(
            f"{name}: simulated over predicted area is {ratio[0]:.3f} at the lightest load (p* = {dataset.reduced_pressure.values[0]:g}) and "
            f"{ratio[-1]:.3f} at the heaviest; worst {verdict(float(ratio[worst]), float(half[i, worst]))} at "
            f"A/A0 = {dataset.area.values[worst]:.3g}."
        )
    for quantity, words in QUANTITIES.items():
        sentences.append(_closest(dataset, quantity, words))
    sentences.append(
        modes_sentence(
            *(dataset.theory_area.sel(mode=mode, variant="persson") for mode in dataset.mode.values)
        )
    )
    if "edge_value" in dataset:
        value, slope = float(dataset.edge_value), float(dataset.edge_slope_ratio[0])
        sentences.append(
            f"P(sigma) starts from {value:+.3f} +- {float(dataset.edge_value_half):.2g} (over E* h'_rms; the theory: 0), with {slope:.1f} +- "
            f"{float(dataset.edge_slope_half[0]):.1g} times the slope of the theory, at p* = {float(dataset.edge_pressure):g} on another bandwidth (study stress-near-zero)."
        )
    return tuple(sentences)


def _closest(dataset: xr.Dataset, quantity: str, words: str) -> str:
    """Say which variant is closest on average over the loads below full contact, and how far the original is."""
    open_contact = dataset.area.values < _RANGES[-1][0]
    off = np.abs(dataset.ratio.sel(quantity=quantity).values[:, open_contact] - 1).mean(axis=1)
    best = int(np.nanargmin(off))
    name = list(VARIANTS.values())[best]
    return (
        f"{words[0].upper()}{words[1:]}, mean distance over these loads below full contact: '{name}' is closest, {100 * off[best]:.2g} % off; "
        f"the original theory is {100 * off[0]:.2g} % off."
    )


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw simulated over predicted values against the area, quantity by quantity."""
    from validation.studies import _plots_limits as plots_limits

    return (
        Drawing(
            name="theory-verdict",
            figure=plots_limits.theory_verdict(dataset, list(QUANTITIES.values())),
            data=dataset[["ratio", "interval", "distance"]],
            caption="Simulated over predicted contact area (limit over grids), mean gap, stiffness and elastic energy for the theory and its variants, told the realised surface, with 95 % intervals; 1 is agreement. Thin, dashed: the original theory told C(q) alone.",
        ),
    )
