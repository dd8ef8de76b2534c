"""How does kappa = (A/A0)/p* depend on the Hurst exponent, and is it the Nayak parameter that matters?"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

import numpy as np
import scipy.optimize
from pydantic import Field

from persson import elastic
from persson.variants import corrected_contact_area
from validation.arrays import Array
from validation.errors import UsageError
from validation.measures.budget import Budget, budget_table, grid_drift, grid_share, solver_error
from validation.measures.common import SHIFTS, Ladder, Rising, base_case, base_surface, named, persson_area
from validation.measures.ladders import LADDERS, Ladders, rungs_of, spectral_share
from validation.measures.measurement import Measurement, area_limits, grid_for, grid_tolerance
from validation.measures.statistics import Estimate, mean_over_surfaces, pair_means
from validation.measures.theory import RANKED, VARIANTS, ensemble_area
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.scene import SelfAffineSurface
from validation.scenes.surfaces import spectrum_of
from validation.solves.bench import Bench
from validation.studies._options import Bandwidth, Hurst, Pairs, Periods, ReducedPressure, Seed, Shifts
from validation.studies._study import StudyOptions

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Options", "budget", "figures", "findings", "run", "table"]


class Options(StudyOptions):
    """Spectra, surfaces, loads, and the ladders that say what a larger sample and a wider spectrum would change."""

    own = "it asks about spectra, and makes a surface for each"

    hursts: Annotated[tuple[Hurst, ...], Field(min_length=1)] = Field(
        default=(0.1, 0.3, 0.5, 0.8, 0.95), description="Hurst exponents H"
    )
    bandwidths: Annotated[tuple[Bandwidth, ...], Field(min_length=1)] = Field(
        default=(16.0,), description="lambda_long / lambda_short, each with every H"
    )
    equal_nayak: float | None = Field(
        default=None,
        description="also choose the bandwidth of each H so that the Nayak parameter alpha of C(q) has this value",
    )
    reduced_pressures: Rising = Field(
        default=(0.02, 0.05, 0.1, 0.2),
        description="p* = p0 / (E* h'_rms) with the realised gradient of each surface, rising",
    )
    periods: Periods = 4.0
    pairs: Pairs = 8
    shifts: Shifts = SHIFTS
    points_per_wave: Ladder = Field(default=(4.0, 6.0, 8.0), description="grids, as lambda_short/dx, rising")
    ladder_hursts: tuple[Hurst, ...] | None = Field(
        default=None,
        description="Hurst exponents with ladders of bandwidth and sample; those of `hursts` if not given",
    )
    ladder_bandwidths: Rising = Field(
        default=(4.0, 8.0, 16.0, 32.0),
        description="rungs of the bandwidth ladder, lambda_long / lambda_short, rising",
    )
    ladder_periods: Rising = Field(
        default=(2.0, 4.0, 8.0),
        description="rungs of the ladder of samples, L / lambda_long, rising, on the first of these bandwidths",
    )
    ladder_pairs: int = Field(
        default=4,
        ge=2,
        le=10_000,
        description="pairs on each bandwidth and on the largest sample; smaller samples get more, for the same area in all",
    )
    ladder_points_per_wave: Ladder = Field(
        default=(4.0, 6.0), description="grids of the ladders, as lambda_short/dx, rising"
    )
    ladder_reduced_pressure: ReducedPressure = 0.05
    seed: Seed = 2006


@dataclass(frozen=True, kw_only=True)
class _Spectrum:
    """One C(q), and the family whose members it is compared with."""

    surface: SelfAffineSurface
    hurst: float
    bandwidth: float
    family: str


#: What a case is called: number of the spectrum and of the surface; surfaces 2k and 2k + 1 are +h and -h.
_Case = tuple[int, int]


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Measure kappa for every spectrum, surface and load, and how it moves with the bandwidth and with the sample.

    Returns
    -------
    xarray.Dataset
        kappa by pixel count and perimeter on the finest grid and in the limit, with dimensions (spectrum, surface,
        load). Surfaces 2k and 2k + 1 are +h and -h. All spectra share their phases.
    """
    spectra = _spectra(options)
    cases = _cases(options, spectra)
    # One surface once more with a hundred times smaller residual: what the stopping of the solver does.
    usual = cases[0, 0]
    strict = replace(usual, tolerance=usual.tolerance / 100)
    ladders = _ladders(options)
    solved = bench.solve([*cases.values(), strict, *ladders.cases])
    measured = {case: solved[solve] for case, solve in cases.items()}
    data = _kappas(options, spectra, measured)
    data["solver_error"] = solver_error(solved[usual], solved[strict])
    if ladders.hursts:
        data = data.merge(ladders.dataset(solved))
    return data.assign_attrs(
        study="hurst",
        methods=RANKED,
        periods=options.periods,
        ladder_reduced_pressure=options.ladder_reduced_pressure,
        seconds=float(sum(result.seconds.sum() for result in solved.values())),
    )


def _spectra(options: Options) -> list[_Spectrum]:
    """List the spectra of equal bandwidth, then those of equal Nayak parameter."""
    periods, nayak = options.periods, options.equal_nayak
    wanted = [(h, b, f"bandwidth {b:g}") for b, h in itertools.product(options.bandwidths, options.hursts)]
    if nayak is not None:
        wanted += [
            (h, _bandwidth_for(nayak, hurst=h, periods=periods), f"alpha {nayak:g}") for h in options.hursts
        ]
    return [
        _Spectrum(
            surface=base_surface(hurst=h, periods=periods, bandwidth=b, seed=options.seed),
            hurst=h,
            bandwidth=b,
            family=family,
        )
        for h, b, family in wanted
    ]


def _bandwidth_for(nayak: float, *, hurst: float, periods: float) -> float:
    """lambda_long/lambda_short at which alpha of C(q) has a value, for one H."""

    def excess(bandwidth: float) -> float:
        surface = base_surface(hurst=hurst, periods=periods, bandwidth=bandwidth, seed=0)
        return spectrum_of(surface).moments().nayak - nayak

    if not excess(1.01) < 0 < excess(1e4):
        raise UsageError(
            f"equal_nayak = {nayak:g}: no bandwidth gives it at H = {hurst:g}; it must exceed 1.5"
        )
    return float(scipy.optimize.brentq(excess, 1.01, 1e4, xtol=1e-6))


def _cases(options: Options, spectra: Sequence[_Spectrum]) -> dict[_Case, Measurement]:
    """Press every spectrum's pairs of surfaces along the path of loads."""
    found = {}
    for i, spectrum in enumerate(spectra):
        base = base_case(spectrum.surface, reduced_pressure=options.reduced_pressures[0])
        grids = tuple(grid_for(base, points) for points in options.points_per_wave)
        for pair, inverted in itertools.product(range(options.pairs), (False, True)):
            found[i, 2 * pair + inverted] = Measurement(
                realised=replace(base.further(pair), inverted=inverted),
                reduced_pressures=options.reduced_pressures,
                grids=grids,
                shifts=options.shifts,
                tolerance=grid_tolerance(base, grids),
            )
    return found


def _ladders(options: Options) -> Ladders:
    return Ladders(
        hursts=options.hursts if options.ladder_hursts is None else options.ladder_hursts,
        bandwidths=options.ladder_bandwidths,
        sizes=options.ladder_periods,
        periods=options.periods,
        pairs=options.ladder_pairs,
        reduced_pressure=options.ladder_reduced_pressure,
        points_per_wave=options.ladder_points_per_wave,
        shifts=options.shifts,
        seed=options.seed,
    )


def _kappas(
    options: Options, spectra: Sequence[_Spectrum], measured: Mapping[_Case, xr.Dataset]
) -> xr.Dataset:
    """Everything measured on the spectra, over p*."""
    import xarray as xr

    limits = {case: area_limits(data) for case, data in measured.items()}
    pressure = np.array(options.reduced_pressures)

    def over(read: Callable[[_Case], Array | float]) -> Array:
        rows = range(len(spectra)), range(2 * options.pairs)
        return np.array([[read((i, k)) for k in rows[1]] for i in rows[0]])

    gradients = over(lambda case: measured[case].attrs["rms_gradient"])
    ensemble = [
        ensemble_area(spectrum_of(spectrum.surface), pressure, rms_gradients=row)
        for spectrum, row in zip(spectra, gradients, strict=True)
    ]
    areas = {
        "kappa": over(lambda case: limits[case][0]),
        "kappa_grid_error": over(lambda case: limits[case][1]),
        "kappa_grid_drift": over(lambda case: grid_drift(measured[case])),
        "kappa_pixel": over(lambda case: measured[case].pixel.mean("shift").values),
        "kappa_perimeter": over(lambda case: measured[case].perimeter.isel(grid=-1).mean("shift").values),
        "kappa_ensemble": np.array(ensemble),
    }
    dims = {4: ("spectrum", "surface", "grid", "load"), 3: ("spectrum", "surface", "load")}
    nayak = over(lambda case: measured[case].attrs["nayak"])
    return xr.Dataset(
        {name: named(dims[area.ndim], area / pressure, _WORDS[name]) for name, area in areas.items()},
        coords={
            "nayak": named(("spectrum", "surface"), nayak, "realised Nayak parameter"),
            "reduced_pressure": named("load", pressure, "p0 / (E* h'_rms)"),
            "hurst": ("spectrum", [spectrum.hurst for spectrum in spectra]),
            "bandwidth": named(
                "spectrum", [spectrum.bandwidth for spectrum in spectra], "lambda_long / lambda_short"
            ),
            "family": ("spectrum", [spectrum.family for spectrum in spectra]),
            "points_per_wave": named("grid", list(options.points_per_wave), "lambda_short / dx"),
        },
    )


_WORDS = {
    "kappa": "limit over grids",
    "kappa_grid_error": "standard error of that limit",
    "kappa_grid_drift": "by how much the limit moves without the coarsest grid",
    "kappa_pixel": "pixel count on every grid, mean over shifts",
    "kappa_perimeter": "perimeter-corrected on the finest grid, mean over shifts",
    "kappa_ensemble": "Persson's theory from C(q) alone",
}


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
        if name != "persson"
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
            steps = {
                "size": 1 / float(dataset.attrs["periods"]),
                "bandwidth": 1 / float(dataset.bandwidth[i]),
            }
            size, band = (spectral_share(dataset, k, hurst=hurst, step=s) for k, s in steps.items())
            shares |= {"finite size": size, "bandwidth": band}
        load = float(dataset.reduced_pressure[j])
        name = f"kappa, H = {float(dataset.hurst[i]):g}, {dataset.family.values[i]}, p* = {load:g}"
        measured_at = float(dataset.attrs["ladder_reduced_pressure"])
        if "bandwidth" in shares and load != measured_at:
            name += f" (spectrum: as at {measured_at:g})"
        budgets.append(Budget(quantity=name, value=estimate.value, shares=shares))
    return budget_table(budgets)


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each spectrum and load."""
    limits, pixels = estimates(dataset), estimates(dataset, "kappa_pixel")
    coarsest, finest = dataset.points_per_wave.values[[0, -1]]
    rows = []
    for i, j in itertools.product(range(dataset.sizes["spectrum"]), range(dataset.sizes["load"])):
        pressure = float(dataset.reduced_pressure[j])
        rows.append(
            {
                "H": float(dataset.hurst[i]),
                "lambda_long/lambda_short": float(dataset.bandwidth[i]),
                "Nayak (realised)": float(dataset.nayak[i].mean()),
                "p*": pressure,
                "kappa limit": limits[i][j].value,
                "+- (95 %, surfaces)": limits[i][j].half_width,
                "+- (95 %, grid)": limits[i][j].value * _grid_share(dataset, i, j),
                f"counted at lambda_short/dx = {finest:g}": pixels[i][j].value,
                f"counted at {coarsest:g}": float(dataset.kappa_pixel[i, :, 0, j].mean()),
                "Persson, conditional": float(persson_area(pressure)) / pressure,
                "Persson, ensemble": float(dataset.kappa_ensemble[i, :, j].mean()),
                **variant_kappa(pressure),
            }
        )
    return ResultTable.of_rows(rows)


def findings(data: xr.Dataset) -> tuple[str, ...]:
    """Return what the numbers say, family by family of spectra."""
    from validation.studies.hurst import sentences

    return tuple(sentences.all_of(data))


def figures(data: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw kappa against H, against the Nayak parameter, and along the ladders."""
    from validation.studies.hurst import plots

    limits = estimates(data)
    variants = [variant_kappa(float(p)) for p in data.reduced_pressure.values]
    drawn = [
        Drawing(
            name="kappa-against-hurst",
            figure=plots.kappa_against_hurst(data, limits, variants),
            data=data[["kappa", "kappa_pixel", "kappa_ensemble"]],
            caption="kappa against the Hurst exponent at each load: filled, limit over grids with 95 % intervals over pairs of surfaces; open, points counted on the finest and the coarsest grid; lines, theory conditional on the realised gradient, its variants, and (thin, dashed) from C(q) alone; grey and cross, literature (light load).",
        ),
        Drawing(
            name="kappa-against-nayak",
            figure=plots.kappa_against_nayak(data, limits),
            data=data[["kappa"]],
            caption="The same kappa against the realised Nayak parameter; colours are loads, markers are families of spectra.",
        ),
    ]
    if data.sizes.get("ladder", 0):
        lines = {kind: [rungs_of(data, kind, k) for k in range(data.sizes["ladder"])] for kind in LADDERS}
        names = [f"{kind}_{what}" for kind in LADDERS for what in ("kappa", "half_width", "limit")]
        drawn.append(
            Drawing(
                name="kappa-limits",
                figure=plots.kappa_ladders(data, lines),
                data=data[names],
                caption="kappa as the bandwidth grows (left) and as the sample grows (right), against the step to the fixed order: lines and filled symbols at 0, the limit with its 95 % interval, where it is determinable.",
            )
        )
        drawn.append(
            Drawing(
                name="alpha-against-magnification",
                figure=plots.alpha_against_magnification(data),
                data=data[["bandwidth_kappa", "bandwidth_half_width"]],
                caption="The slope alpha(zeta) of A = alpha F over that of Persson's theory as waves are added, for each fractal dimension, limits over grids with 95 %. "
                "Lines: published for D_f = 2.2, as Persson (2006, Sec. 3.5) quotes them.",
            )
        )
    return tuple(drawn)
