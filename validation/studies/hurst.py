"""How does kappa = (A/A0)/p* depend on the Hurst exponent, and is it the Nayak parameter that matters?"""

import itertools
from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any

import xarray as xr
from pydantic import Field

from persson.elastic import KAPPA_BGT, KAPPA_PERSSON
from validation.measurements.by_solver import beside_bem
from validation.measurements.common import SHIFTS, Ladder, Rising
from validation.measurements.convergence import Ladders, bandwidth_of, pressed_pairs, spectral_errors
from validation.measurements.grids import method_limit
from validation.measurements.limits import limits_of
from validation.measurements.measurement import TOLERANCES_LEFT, grid_for
from validation.measurements.references import ladders_beside_published, papers_of, published
from validation.measurements.theory import RANKED, VARIANTS, ensemble_area, with_variants
from validation.report.estimates import change, claim_shares, derive, mean
from validation.report.places import gather
from validation.solvers import chosen_solver
from validation.studies._hurst_views import views as views
from validation.studies._options import (
    AnyMethods,
    Bandwidth,
    Hurst,
    Pairs,
    Periods,
    ReducedPressure,
    Seed,
    Shifts,
    StudyOptions,
)
from validation.studies._study import Bench, Call, Measured, solved


class Options(StudyOptions):
    """Spectra, surfaces, loads, and the ladders that say what a larger sample and a wider spectrum would change."""

    why_no_scene = "it asks about spectra, and makes a surface for each"

    methods: AnyMethods = ("bem", "fem")
    """solvers with commas: boundary elements press everything; fem, the full block, and any other press
    surfaces of their own beside them"""
    hursts: tuple[Hurst, ...] = Field(default=(0.1, 0.3, 0.5, 0.8, 0.95), min_length=1)
    """Hurst exponents H"""
    bandwidths: Annotated[tuple[Bandwidth, ...], Field(min_length=1)] = (16.0,)
    """lambda_long / lambda_short, each with every H"""
    equal_nayak: float | None = None
    """also choose the bandwidth of each H so that the Nayak parameter alpha of C(q) has this value"""
    reduced_pressures: Rising = (0.02, 0.05, 0.1, 0.2)
    """p* = p0 / (E* h'_rms) with the realised gradient of each surface, rising"""
    periods: Periods = 4.0
    pairs: Pairs = 8
    shifts: Shifts = SHIFTS
    points_per_wave: Ladder = (4.0, 6.0, 8.0)
    """grids, as lambda_short/dx, rising"""
    method_bandwidth: Bandwidth = Field(
        default=4.0, description="lambda_long / lambda_short of the surfaces that the other methods press"
    )
    method_reduced_pressure: ReducedPressure = 0.05
    method_pairs: Pairs = 4
    method_points_per_wave: Rising = (4.0, 8.0, 12.0)
    """grids of the other methods, as lambda_short/dx, rising; a limit takes three"""
    ladders: bool = True
    """also measure how kappa moves with bandwidth and sample: most of the solves"""
    ladder_hursts: tuple[Hurst, ...] | None = None
    """Hurst exponents with ladders; those of `hursts` if not given"""
    ladder_bandwidths: Rising = (4.0, 8.0, 16.0, 32.0)
    """rungs of the bandwidth ladder, lambda_long / lambda_short, rising"""
    ladder_periods: Rising = (2.0, 4.0, 8.0)
    """rungs of the ladder of samples, L / lambda_long, rising, on the first of these bandwidths"""
    ladder_pairs: Pairs = Field(
        default=4,
        description="pairs on each bandwidth and on the largest sample; smaller samples get more, for the same area in all",
    )
    ladder_points_per_wave: Ladder = (4.0, 6.0)
    """grids of the ladders, as lambda_short/dx, rising"""
    ladder_reduced_pressure: ReducedPressure = 0.05
    seed: Seed = 2006

    @property
    def spectra(self) -> dict[tuple[str, float], float]:
        """Bandwidth by family and H: families of equal bandwidth, then that of equal Nayak parameter."""
        alpha, hursts = self.equal_nayak, sorted(set(self.hursts))
        bandwidths = {(f"bandwidth {b:g}", h): b for b, h in itertools.product(self.bandwidths, hursts)}
        if alpha is not None:
            of = partial(bandwidth_of, alpha, periods=self.periods)
            bandwidths |= {(f"alpha {alpha:g}", h): of(hurst=h) for h in hursts}
        return bandwidths

    @property
    def others(self) -> tuple[str, ...]:
        """Methods beside boundary elements."""
        return tuple(name for name in self.methods if name != "bem")

    @property
    def climbed(self) -> Ladders | None:
        """The ladders; None without them."""
        hursts = self.hursts if self.ladder_hursts is None else self.ladder_hursts
        if not (self.ladders and hursts):
            return None
        options = self.model_dump(include={"periods", "shifts", "seed"})
        of_ladders = ("bandwidths", "pairs", "points_per_wave", "reduced_pressure")
        options |= {name: getattr(self, f"ladder_{name}") for name in of_ladders}
        return Ladders(hursts=tuple(sorted(set(hursts))), sizes=self.ladder_periods, **options)


#: What is solved: a family of spectra, or which ladder, then H and what else tells it apart.
_Case = tuple[Any, ...]


def design(options: Options) -> dict[_Case, Call]:
    """Return the solves: every spectrum's pairs, and those of the ladders."""
    cases: dict[_Case, Call] = {}
    how: Any = (options.reduced_pressures, options.points_per_wave)
    for (family, hurst), bandwidth in options.spectra.items():
        surface = options.self_affine(hurst=hurst, bandwidth=bandwidth)
        solves = pressed_pairs(surface, *how, pairs=options.pairs, shifts=options.shifts)
        cases |= {(family, hurst, k): solve for k, solve in enumerate(solves)}
    if options.others:
        cases |= _by_solver(options)
    return cases | (options.climbed.cases if options.climbed else {})


def _by_solver(options: Options) -> dict[_Case, Call]:
    """Return what several solvers press: "solver", its name, H, surface, and points per wave but of boundary elements."""
    cases: dict[_Case, Call] = {}
    how: Any = ((options.method_reduced_pressure,), options.points_per_wave)
    for hurst in sorted(set(options.hursts)):
        surface = options.self_affine(hurst=hurst, bandwidth=options.method_bandwidth)
        solves = pressed_pairs(surface, *how, pairs=options.method_pairs, shifts=options.shifts)
        cases |= {("solver", "bem", hurst, k): solve for k, solve in enumerate(solves)}
        for name, (k, solve), n in itertools.product(
            options.others, enumerate(solves), options.method_points_per_wave
        ):
            solver, settings = chosen_solver(name)
            cases["solver", name, hurst, k, n] = beside_bem(
                problem=solve["problem"],
                grid=grid_for(solve["problem"], n),
                method=solver.name,
                settings=tuple(settings.items()),
            )
    return cases


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Measure kappa for every spectrum, surface and load, and how it moves with the bandwidth and with the sample.

    Returns kappa (family, hurst, load), of each surface, counted and corrected, with all theories, by load; on the
    ladders, over (ladder, rung), with its limits. Surfaces 2k and 2k + 1 are +h and -h; all spectra share their
    phases.
    """
    cases = design(options)
    measured = solved(bench, cases)
    left = TOLERANCES_LEFT * next(iter(cases.values()))["tolerance"]
    data = claim_shares(_of_spectra(options, cases, measured), "kappa", solver=left)
    if options.others:
        data = data.merge(_of_solvers(options, cases, measured), combine_attrs="override")
    if options.climbed:
        climbed = options.climbed.reduced(measured)
        data = data.merge(ladders_beside_published(climbed), combine_attrs="override")
        spectral = spectral_errors(data, hurst=data.hurst, bandwidth=data.bandwidth, periods=options.periods)
        data = claim_shares(data, "kappa", **spectral)
    data = data.assign(kappa_bgt=KAPPA_BGT, kappa_persson_light=KAPPA_PERSSON).merge(published("kappa"))
    cited = dict.fromkeys(chosen_solver(name)[0].name for name in options.others)
    methods = " ".join([RANKED, *cited, papers_of("kappa", "kappa_ratio")])
    return data.assign_attrs(methods=methods, periods=options.periods)


def _of_spectra(options: Options, cases: Mapping[_Case, Call], measured: Measured) -> xr.Dataset:
    parts, surfaces = {}, range(2 * options.pairs)
    for (family, hurst), bandwidth in options.spectra.items():
        part = gather({k: limits_of(measured[family, hurst, k]) for k in surfaces}, "surface")
        spectrum, gradients = cases[family, hurst, 0]["problem"].spectrum, part.rms_gradient_each.values
        ensemble = ensemble_area(spectrum, part.reduced_pressure.values, rms_gradients=gradients)
        part["area_ensemble_each"] = ("surface", "load"), ensemble
        parts[family, hurst] = part.assign(bandwidth=bandwidth)
    data = with_variants(gather(parts, "family", "hurst"))
    of_surfaces = ("", "_pixel", "_perimeter", "_ensemble")
    data = derive(
        data,
        **{f"kappa{what}_each": f"area{what}_each / reduced_pressure" for what in of_surfaces},
        **{f"kappa_{name}": f"area_{name} / reduced_pressure" for name in VARIANTS},
        kappa_ratio_each="kappa_each.mean(['family', 'hurst']) / kappa_persson",
        kappa_excess_each="(kappa_pixel_each / kappa_each - 1).isel(family=0).mean(['hurst', 'load'])",
    )
    data = change(data, "kappa", along="hurst")
    means = ("kappa_ratio", "kappa_excess", "kappa_change", "nayak")
    data = mean(data, *(f"kappa{what}" for what in of_surfaces), *means, pairs=True)
    # Without its errors: a spread has no interval that those of its ends would tell.
    names, over = ["kappa", "kappa_pixel"], "(['hurst', 'load'])"
    spreads = {f"{name}_spread": f"{name}.max{over} / {name}.min{over} - 1" for name in names}
    return data.assign(derive(data[names].isel(family=0, drop=True), **spreads)[[*spreads]])


def _of_solvers(options: Options, cases: Mapping[_Case, Call], measured: Measured) -> xr.Dataset:
    """Kappa (solver, hurst) by each solver's own limit over its own grids, and over that of boundary elements."""
    names, parts = {f"area{end}": f"area_by_solver{end}" for end in ("_each", "_each_error")}, {}
    for place in dict.fromkeys(case[1:4] for case in cases if case[0] == "solver"):
        if place[0] == "bem":
            limit = limits_of(measured["solver", *place]).isel(load=0, drop=True)[[*names]].rename(names)
        else:
            of = [("solver", *place, n) for n in options.method_points_per_wave]
            answers, grids = [measured[case] for case in of], [cases[case]["grid"] for case in of]
            limit = method_limit(answers, grids, "area_by_solver")
        parts[place] = limit.drop_attrs().assign_attrs(limit.attrs)
    data = gather(parts, "solver", "hurst", "surface_by_solver")
    data = data.rename(solve="solve_by_solver").drop_vars("surface_by_solver")
    bem = data.sel(solver="bem", drop=True)
    data = data.assign(
        area_bem_each=bem.area_by_solver_each,
        area_bem_each_error=bem.area_by_solver_each_error,
        reduced_pressure_by_solver=options.method_reduced_pressure,
        bandwidth_by_solver=options.method_bandwidth,
    )
    data = derive(
        data,
        kappa_persson_by_solver="erf(2**.5 * reduced_pressure_by_solver) / reduced_pressure_by_solver",
        kappa_by_solver_each="area_by_solver_each / reduced_pressure_by_solver",
        kappa_by_solver_difference_each="area_by_solver_each / area_bem_each - 1",
    )
    # The grids of a method are off to one side on all surfaces.
    means = ("kappa_by_solver", "kappa_by_solver_difference")
    return mean(data, *means, over="surface_by_solver", pairs=True, alike=True)
