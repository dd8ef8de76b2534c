"""How does kappa = (A/A0)/p* depend on the Hurst exponent, and is it the Nayak parameter that matters?"""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.optimize

from persson import elastic
from persson.variants import Variant, corrected_contact_area
from validation.errors import UsageError
from validation.measures.budget import Budget, budget_table, grid_drift, grid_share, solver_error
from validation.measures.common import at_least, base_surface, ladder, measure, persson_area, rising, solid_of
from validation.measures.measurement import Measurement, area_limits, grid_for
from validation.measures.spectrum_limits import LADDERS, Ladders, rungs_of, spectral_share
from validation.measures.statistics import Estimate, mean_over_surfaces, pair_means
from validation.measures.theory import ensemble_area, modes_sentence
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.surfaces import spectrum_of
from validation.solves.bench import Bench

if TYPE_CHECKING:
    import xarray as xr

    from validation.scenes.scene import Scene, SelfAffineSurface

__all__ = ["budget", "figures", "findings", "run", "table"]

#: Variants of the theory that are drawn beside the original, and how they are called.
VARIANTS: dict[Variant, str] = {
    "yang_persson": "Yang, Persson 2008",
    "wang_mueser": "Wang, Mueser 2017",
    "xu": "Xu et al. 2024",
}


def run(
    *,
    scene: Scene | None = None,
    bench: Bench | None = None,
    hursts: tuple[float, ...] = (0.1, 0.3, 0.5, 0.8, 0.95),
    ratios: tuple[float, ...] = (16.0,),
    equal_nayak: float | None = None,
    reduced_pressures: tuple[float, ...] = (0.02, 0.05, 0.1, 0.2),
    size: float = 4.0,
    pairs: int = 8,
    points_per_wave: tuple[float, ...] = (4.0, 6.0, 8.0),
    shifts: int = 2,
    ladder_hursts: tuple[float, ...] | None = None,
    ladder_ratios: tuple[float, ...] = (4.0, 8.0, 16.0, 32.0),
    ladder_sizes: tuple[float, ...] = (2.0, 4.0, 8.0),
    ladder_pairs: int = 4,
    ladder_points: tuple[float, ...] = (4.0, 6.0),
    ladder_pressure: float = 0.05,
    seed: int = 2006,
) -> xr.Dataset:
    """Measure kappa for every spectrum, surface and load, and how it moves with the bandwidth and with the sample.

    Parameters
    ----------
    scene : Scene, optional
        Gives the solid; kappa does not depend on it.
    bench : Bench, optional
        Where and how the cases run; in this process and in `results/solves` if not given.
    hursts : tuple of float
        Hurst exponents.
    ratios : tuple of float
        lambda_long/lambda_short, each with every H.
    equal_nayak : float, optional
        Also choose the ratio of each H so that alpha of C(q) has this value.
    reduced_pressures : tuple of float
        p*, rising.
    size : float
        L/lambda_long.
    pairs : int
        Pairs of surfaces +h, -h.
    points_per_wave : tuple of float
        Grids, as lambda_short/dx, rising.
    shifts : int
        Sub-grid shifts along each axis.
    ladder_hursts : tuple of float, optional
        Hurst exponents with ladders of bandwidth and size; all of `hursts` if not given.
    ladder_ratios : tuple of float
        Rungs of the bandwidth ladder, lambda_long/lambda_short, rising.
    ladder_sizes : tuple of float
        Rungs of the size ladder, L/lambda_long, rising, on the smallest of these bandwidths.
    ladder_pairs : int
        Pairs on each bandwidth and on the largest sample; smaller samples get more, for the same area in all.
    ladder_points : tuple of float
        Grids of the ladders, as lambda_short/dx.
    ladder_pressure : float
        p* of the ladders.
    seed : int
        Of the first surface.

    Returns
    -------
    xarray.Dataset
        kappa by pixel count and perimeter on the finest grid and in the limit, with dimensions (spectrum, surface,
        load). Surfaces 2k and 2k + 1 are +h and -h. All spectra share their phases.
    """
    at_least("pairs", pairs, 2)
    at_least("ladder_pairs", ladder_pairs, 2)
    reduced_pressures, points_per_wave = (
        rising("reduced_pressures", reduced_pressures),
        ladder("points_per_wave", points_per_wave, shifts=shifts),
    )
    spectra = [(h, r, f"ratio {r:g}") for r, h in itertools.product(ratios, hursts)]
    if equal_nayak is not None:
        spectra += [
            (h, _ratio_for(equal_nayak, hurst=h, size=size), f"alpha {equal_nayak:g}") for h in hursts
        ]
    surfaces = [base_surface(hurst=h, size=size, ratio=r, seed=seed) for h, r, _ in spectra]
    common: dict[str, Any] = {"solid": solid_of(scene), "shifts": shifts}
    cases = [
        Measurement(
            surface=surface,
            realisation=pair,
            inverted=inverted,
            reduced_pressures=reduced_pressures,
            grids=tuple(grid_for(surface, points) for points in points_per_wave),
            **common,
        )
        for surface, pair, inverted in itertools.product(surfaces, range(pairs), (False, True))
    ]
    # One surface once more with a hundred times smaller residual: what the stopping of the solver does.
    strict = replace(cases[0], tolerance=cases[0].tolerance / 100)
    ladders = Ladders(
        hursts=tuple(hursts if ladder_hursts is None else ladder_hursts),
        ratios=rising("ladder_ratios", ladder_ratios),
        sizes=rising("ladder_sizes", ladder_sizes),
        size=size,
        pairs=ladder_pairs,
        reduced_pressure=ladder_pressure,
        points_per_wave=ladder("ladder_points", ladder_points, shifts=shifts),
        seed=seed,
        **common,
    )
    measured = measure(bench, [*cases, strict, *ladders.cases])
    main = measured[: len(cases)]
    data = _kappas(main, surfaces, shape=(len(spectra), 2 * pairs, len(reduced_pressures)))
    data = data.assign_coords(
        hurst=("spectrum", [hurst for hurst, _, _ in spectra]),
        ratio=("spectrum", [ratio for _, ratio, _ in spectra], {"long_name": "lambda_long / lambda_short"}),
        family=("spectrum", [family for _, _, family in spectra]),
        points_per_wave=("grid", list(points_per_wave), {"long_name": "lambda_short / dx"}),
    )
    data["solver_error"] = solver_error(main[0], measured[len(cases)])
    if ladders.hursts:
        data = data.merge(ladders.dataset(measured[len(cases) + 1 :]))
    return data.assign_attrs(
        study="hurst",
        size=size,
        ladder_pressure=ladder_pressure,
        seconds=float(sum(result.seconds.sum() for result in measured)),
    )


def _kappas(
    measured: list[xr.Dataset], surfaces: list[SelfAffineSurface], *, shape: tuple[int, int, int]
) -> xr.Dataset:
    """Everything measured on the spectra, over p*."""
    import xarray as xr

    pressure = measured[0].reduced_pressure.values
    limits = [area_limits(data) for data in measured]
    dims = ("spectrum", "surface", "load")
    counted = np.array([data.pixel.mean("shift").values for data in measured])
    gradients = np.array([data.attrs["rms_gradient"] for data in measured]).reshape(shape[:2])
    ensemble = np.array(
        [ensemble_area(s, pressure, rms_gradients=row) for s, row in zip(surfaces, gradients, strict=True)]
    )
    values = {
        "kappa": (dims, np.array([value for value, _ in limits]).reshape(shape)),
        "kappa_grid_error": (dims, np.array([error for _, error in limits]).reshape(shape)),
        "kappa_grid_drift": (dims, np.array([grid_drift(data) for data in measured]).reshape(shape)),
        "kappa_pixel": (
            (*dims[:2], "grid", "load"),
            counted.reshape(*shape[:2], *counted.shape[1:]),
        ),
        "kappa_perimeter": (dims, _finest(measured, "perimeter").reshape(shape)),
        "kappa_ensemble": (dims, ensemble),
    }
    words = {
        "kappa": "limit over grids",
        "kappa_grid_error": "standard error of that limit",
        "kappa_grid_drift": "by how much the limit moves without the coarsest grid",
        "kappa_pixel": "pixel count on every grid, mean over shifts",
        "kappa_perimeter": "perimeter-corrected on the finest grid, mean over shifts",
        "kappa_ensemble": "Persson's theory from C(q) alone",
    }
    nayak = np.array([data.attrs["nayak"] for data in measured]).reshape(shape[:2])
    return xr.Dataset(
        {name: (d, v / pressure, {"long_name": words[name]}) for name, (d, v) in values.items()},
        coords={
            "nayak": (("spectrum", "surface"), nayak, {"long_name": "realised Nayak parameter"}),
            "reduced_pressure": ("load", pressure, {"long_name": "p0 / (E* h'_rms)"}),
        },
    )


def _ratio_for(nayak: float, *, hurst: float, size: float) -> float:
    """lambda_long/lambda_short at which alpha of C(q) has a value, for one H."""

    def excess(ratio: float) -> float:
        surface = base_surface(hurst=hurst, size=size, ratio=ratio, seed=0)
        return spectrum_of(surface).moments().nayak - nayak

    if not excess(1.01) < 0 < excess(1e4):
        raise UsageError(
            f"equal_nayak = {nayak:g}: no bandwidth gives it at H = {hurst:g}; it must exceed 1.5"
        )
    return float(scipy.optimize.brentq(excess, 1.01, 1e4, xtol=1e-6))


def _finest(measured: list[xr.Dataset], name: str) -> np.ndarray:
    return np.array([data[name].isel(grid=-1).mean("shift").values for data in measured])


def estimates(dataset: xr.Dataset, name: str = "kappa") -> list[list[Estimate]]:
    """Mean over pairs of surfaces with its 95 % interval, for each spectrum and load; counted on the finest grid."""
    values = dataset[name].isel(grid=-1) if "grid" in dataset[name].dims else dataset[name]
    pairs = pair_means(values.transpose("spectrum", "load", "surface").values)
    return [[mean_over_surfaces(samples) for samples in loads] for loads in pairs]


def variant_kappa(reduced_pressure: float) -> dict[str, float]:
    """Kappa of the corrected variants of the theory at one load, by the name of the variant."""
    variance = elastic.stress_variance(1.0, contact_modulus=1.0)
    areas = {
        words: corrected_contact_area(reduced_pressure, stress_variance=variance, variant=name)
        for name, words in VARIANTS.items()
    }
    return {words: float(area) / reduced_pressure for words, area in areas.items()}


def _grid_share(dataset: xr.Dataset, spectrum: int, load: int) -> float:
    names = ("kappa", "kappa_grid_error", "kappa_grid_drift")
    values, errors, drifts = (dataset[name][spectrum, :, load].values for name in names)
    return grid_share(values, errors=errors, drifts=drifts)


def budget(dataset: xr.Dataset) -> ResultTable:
    """Return what is uncertain about every kappa: for its own spectrum, and as a value for endless bandwidth and sample."""
    limits = estimates(dataset)
    solver = float(dataset.solver_error)
    budgets = []
    for i, j in itertools.product(range(dataset.sizes["spectrum"]), range(dataset.sizes["load"])):
        estimate = limits[i][j]
        shares = {
            "grid": _grid_share(dataset, i, j),
            "solver": solver,
            "surfaces": estimate.half_width / estimate.value,
        }
        if dataset.sizes.get("ladder", 0):
            hurst = float(dataset.hurst[i])
            steps = {"size": 1 / float(dataset.attrs["size"]), "bandwidth": 1 / float(dataset.ratio[i])}
            size, band = (spectral_share(dataset, k, hurst=hurst, step=s) for k, s in steps.items())
            shares |= {"finite size": size, "bandwidth": band}
        load = float(dataset.reduced_pressure[j])
        name = f"kappa, H = {float(dataset.hurst[i]):g}, {dataset.family.values[i]}, p* = {load:g}"
        measured_at = float(dataset.attrs["ladder_pressure"])
        if "bandwidth" in shares and load != measured_at:
            name += f" (spectrum: as at {measured_at:g})"
        budgets.append(Budget(quantity=name, value=estimate.value, shares=shares))
    return budget_table(budgets)


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each spectrum and load."""
    limits, pixels = estimates(dataset), estimates(dataset, "kappa_pixel")
    rows = []
    for i, j in itertools.product(range(dataset.sizes["spectrum"]), range(dataset.sizes["load"])):
        pressure = float(dataset.reduced_pressure[j])
        rows.append(
            (
                float(dataset.hurst[i]),
                float(dataset.ratio[i]),
                float(dataset.nayak[i].mean()),
                pressure,
                limits[i][j].value,
                limits[i][j].half_width,
                limits[i][j].value * _grid_share(dataset, i, j),
                pixels[i][j].value,
                float(dataset.kappa_pixel[i, :, 0, j].mean()),
                float(persson_area(pressure)) / pressure,
                float(dataset.kappa_ensemble[i, :, j].mean()),
                *variant_kappa(pressure).values(),
            )
        )
    coarsest, finest = dataset.points_per_wave.values[[0, -1]]
    columns = (
        "H",
        "lambda_long/lambda_short",
        "Nayak (realised)",
        "p*",
        "kappa limit",
        "+- (95 %, surfaces)",
        "+- (95 %, grid)",
        f"counted at lambda_short/dx = {finest:g}",
        f"counted at {coarsest:g}",
        "Persson, conditional",
        "Persson, ensemble",
        *VARIANTS.values(),
    )
    return ResultTable.of(columns, rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return what the numbers say, family by family of spectra."""
    sentences = []
    for family in dict.fromkeys(dataset.family.values.tolist()):
        part = dataset.isel(spectrum=np.flatnonzero(dataset.family.values == family))
        if part.sizes["spectrum"] > 1:
            sentences.append(_trend(part, family))
    sentences.append(_counting(dataset))
    pressures = dataset.reduced_pressure.values
    theory = persson_area(pressures) / pressures
    ratio = dataset.kappa.mean(("spectrum", "surface")).values / theory
    sentences.append(
        "The limit over Persson's theory is "
        + ", ".join(f"{r:.3f} at p* = {p:g}" for r, p in zip(ratio, pressures, strict=True))
        + " (mean over the spectra)."
    )
    sentences.append(
        modes_sentence(np.broadcast_to(theory, dataset.kappa_ensemble.shape), dataset.kappa_ensemble)
    )
    if dataset.sizes.get("ladder", 0) > 1:
        sentences.append(_alpha_sentence(dataset))
    for kind in LADDERS:
        sentences += [_ladder_sentence(dataset, kind, k) for k in range(dataset.sizes.get("ladder", 0))]
    return tuple(sentences)


def _counting(dataset: xr.Dataset) -> str:
    """Say how much of the spread over H and loads is the grid's, by the spectra of equal bandwidth."""
    family = dataset.family.values[0]
    part = dataset.isel(spectrum=np.flatnonzero(dataset.family.values == family))

    def spread(values: xr.DataArray) -> tuple[float, float, float]:
        means = values.mean("surface").values
        return float(means.min()), float(means.max()), float(means.max() / means.min() - 1)

    low, high, true = spread(part.kappa)
    words = []
    for g in sorted({0, part.sizes["grid"] - 1}):
        least, most, seen = spread(part.kappa_pixel.isel(grid=g))
        mean = float(part.kappa_pixel.isel(grid=g).mean() / part.kappa.mean() - 1)
        words.append(
            f"at lambda_short/dx = {float(part.points_per_wave[g]):g} from {least:.2f} to {most:.2f} (spread {100 * seen:.0f} %, {100 * mean:+.1f} % on average)"
        )
    return (
        f"Counting points gives kappa, over all H and loads of {family}, {' and '.join(words)}; the limit goes from {low:.2f} to {high:.2f} "
        f"(spread {100 * true:.0f} %): what is more is the grid's."
    )


def _alpha_sentence(dataset: xr.Dataset) -> str:
    """Compare H at equal Nayak parameter with the Nayak parameter at equal H, along the bandwidth ladders."""
    alpha, kappa = dataset.bandwidth_nayak.values, dataset.bandwidth_kappa.values
    common = float(alpha[:, -1].min())
    if common < alpha[:, 0].max():
        return "The bandwidth ladders share no Nayak parameter: H at equal alpha cannot be read off them."
    at_common = np.array([np.interp(np.log(common), np.log(a), k) for a, k in zip(alpha, kappa, strict=True)])
    along = kappa[:, -1] / kappa[:, 0] - 1
    hurst = dataset.ladder_hurst.values
    return (
        f"H at equal alpha: at the Nayak parameter {common:.3g} kappa of all bandwidth ladders, H = {hurst.min():g} to {hurst.max():g}, lies within "
        f"{100 * (at_common.max() / at_common.min() - 1):.1f} % ({at_common.min():.3f} to {at_common.max():.3f}). Alpha at equal H: it changes by "
        + ", ".join(
            f"{100 * c:+.1f} % from {a[0]:.2g} to {a[-1]:.2g} (H = {h:g})"
            for c, a, h in zip(along, alpha, hurst, strict=True)
        )
        + "."
    )


def _ladder_sentence(dataset: xr.Dataset, kind: str, k: int) -> str:
    """Say where a ladder leads."""
    line, hurst = rungs_of(dataset, kind, k), float(dataset.ladder_hurst[k])
    kappa, steps = dataset[f"{kind}_kappa"][k].values, dataset[f"{kind}_step"].values
    change = f"kappa goes from {kappa[0]:.3f} to {kappa[-1]:.3f} as {LADDERS[kind]} falls from 1/{1 / steps[0]:g} to 1/{1 / steps[-1]:g}"
    if kind == "bandwidth":
        alpha = dataset.bandwidth_nayak[k].values
        change += f" (at equal H, with the Nayak parameter from {alpha[0]:.2g} to {alpha[-1]:.2g})"
    start = f"H = {hurst:g}, p* = {dataset.attrs['ladder_pressure']:g}: {change}"
    if not line.determinable:
        return (
            f"{start}; its limit is not determinable: with the order {line.order:.2g} it lies {line.reach:.1f} times "
            "as far away as these rungs span."
        )
    decided = abs(line.slope) > line.slope_half_width
    return (
        f"{start}; with the fixed order {line.order:.2g} the limit is {line.limit:.3f} +- {line.half_width:.2g} (95 %)"
        + ("." if decided else ", and no trend is told from zero.")
    )


def _trend(part: xr.Dataset, family: str) -> str:
    """Compare the lowest with the highest H, surface by surface, since their phases are common."""
    first, last = int(part.hurst.values.argmin()), int(part.hurst.values.argmax())
    words = []
    for j, pressure in enumerate(part.reduced_pressure.values):
        ratio = part.kappa[last, :, j].values / part.kappa[first, :, j].values - 1
        change = mean_over_surfaces(pair_means(ratio))
        decided = abs(change.value) > change.half_width
        words.append(
            f"{100 * change.value:+.1f} +- {100 * change.half_width:.1f} % at p* = {pressure:g}"
            + ("" if decided else " (not told from zero)")
        )
    alphas = part.nayak.mean("surface").values
    return (
        f"Spectra of {family}: from H = {float(part.hurst[first]):g} to {float(part.hurst[last]):g} (Nayak parameter "
        f"{alphas[first]:.2g} to {alphas[last]:.2g}) kappa changes by " + ", ".join(words) + "."
    )


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw kappa against H, against the Nayak parameter, and along the ladders."""
    from validation.studies import _plots_limits as plots_limits
    from validation.studies import _plots_studies as plots_studies

    limits = estimates(dataset)
    variants = [variant_kappa(float(p)) for p in dataset.reduced_pressure.values]
    drawn = [
        Drawing(
            name="kappa-against-hurst",
            figure=plots_limits.kappa_against_hurst(dataset, limits, variants),
            data=dataset[["kappa", "kappa_pixel", "kappa_ensemble"]],
            caption="kappa against the Hurst exponent at each load: filled, limit over grids with 95 % intervals over pairs of surfaces; open, points counted on the finest and the coarsest grid; lines, theory conditional on the realised gradient, its variants, and (thin, dashed) from C(q) alone; grey and cross, literature (light load).",
        ),
        Drawing(
            name="kappa-against-nayak",
            figure=plots_studies.kappa_against_nayak(dataset, limits),
            data=dataset[["kappa"]],
            caption="The same kappa against the realised Nayak parameter; colours are loads, markers are families of spectra.",
        ),
    ]
    if dataset.sizes.get("ladder", 0):
        lines = {
            kind: [rungs_of(dataset, kind, k) for k in range(dataset.sizes.get("ladder", 0))]
            for kind in LADDERS
        }
        names = [f"{kind}_{what}" for kind in LADDERS for what in ("kappa", "half_width", "limit")]
        drawn.append(
            Drawing(
                name="kappa-limits",
                figure=plots_limits.kappa_ladders(dataset, lines),
                data=dataset[names],
                caption="kappa as the bandwidth grows (left) and as the sample grows (right), against the step to the fixed order: lines and filled symbols at 0, the limit with its 95 % interval, where it is determinable.",
            )
        )
    return tuple(drawn)
