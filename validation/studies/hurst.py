"""How does kappa = (A/A0)/p* depend on the Hurst exponent, and is it the Nayak parameter that matters?"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Annotated, Any

import numpy as np
import xarray as xr
from pydantic import Field

from persson.elastic import KAPPA_BGT, KAPPA_PERSSON
from validation.execution.bench import Bench
from validation.execution.measurement import Call
from validation.measurements.common import SHIFTS, Ladder, Rising, base_surface
from validation.measurements.convergence import Ladders, bandwidth_of, pressed_pairs, spectral_errors
from validation.measurements.kappa_by_solver import KappaBySolver
from validation.measurements.limits import limits_of, solved, solver_error
from validation.measurements.references import ladders_beside_published, papers_of, published
from validation.measurements.theory import RANKED, VARIANTS, with_ensemble, with_variants
from validation.report.estimates import change, claim, derive, gather, mean
from validation.report.findings import Finding, finding
from validation.report.marks import Band, Figure, Level, Line, Panel, panels_along
from validation.report.table import Column, Table
from validation.report.views import Views
from validation.solvers import chosen_solver
from validation.studies._options import (
    AnyMethods,
    Bandwidth,
    Hurst,
    Pairs,
    Periods,
    ReducedPressure,
    Seed,
    Shifts,
)
from validation.studies._study import StudyOptions

#: A/A0 below which kappa is published, a little more than the authors' 0.1; H of the published alpha(zeta).
_LIGHT, _PUBLISHED = 0.12, 0.8


#: Options of the surfaces that other solvers press, which begin with `method_`.
_OF_METHODS = ("bandwidth", "reduced_pressure", "pairs", "points_per_wave")


class Options(StudyOptions):
    """Spectra, surfaces, loads, and the ladders that say what a larger sample and a wider spectrum would change."""

    own = "it asks about spectra, and makes a surface for each"

    methods: AnyMethods = Field(
        default=("bem", "fem"),
        description="solvers with commas: boundary elements press everything; fem, the full block, and any other press surfaces of their own beside them",
    )
    hursts: tuple[Hurst, ...] = Field(
        default=(0.1, 0.3, 0.5, 0.8, 0.95), min_length=1, description="Hurst exponents H"
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
    method_bandwidth: Bandwidth = Field(
        default=4.0, description="lambda_long / lambda_short of the surfaces that the other methods press"
    )
    method_reduced_pressure: ReducedPressure = 0.05
    method_pairs: Pairs = 4
    method_points_per_wave: Rising = Field(
        default=(4.0, 8.0, 12.0),
        description="grids of the other methods, as lambda_short/dx, rising; a limit takes three",
    )
    ladders: bool = Field(
        default=True, description="also measure how kappa moves with bandwidth and sample: most of the solves"
    )
    ladder_hursts: tuple[Hurst, ...] | None = Field(
        default=None, description="Hurst exponents with ladders; those of `hursts` if not given"
    )
    ladder_bandwidths: Rising = Field(
        default=(4.0, 8.0, 16.0, 32.0),
        description="rungs of the bandwidth ladder, lambda_long / lambda_short, rising",
    )
    ladder_periods: Rising = Field(
        default=(2.0, 4.0, 8.0),
        description="rungs of the ladder of samples, L / lambda_long, rising, on the first of these bandwidths",
    )
    ladder_pairs: Pairs = Field(
        default=4,
        description="pairs on each bandwidth and on the largest sample; smaller samples get more, for the same area in all",
    )
    ladder_points_per_wave: Ladder = Field(
        default=(4.0, 6.0), description="grids of the ladders, as lambda_short/dx, rising"
    )
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
    def beside(self) -> KappaBySolver | None:
        """What other solvers press; None without them."""
        own = {name: getattr(self, name) for name in ("periods", "shifts", "seed")}
        own |= {name: getattr(self, f"method_{name}") for name in _OF_METHODS}
        hursts, per_wave = tuple(sorted(set(self.hursts))), self.points_per_wave
        each = KappaBySolver(solvers=self.others, hursts=hursts, bem_points_per_wave=per_wave, **own)
        return each if self.others else None

    @property
    def climbed(self) -> Ladders | None:
        """The ladders; None without them."""
        hursts = self.hursts if self.ladder_hursts is None else self.ladder_hursts
        own = {name: getattr(self, name) for name in ("periods", "shifts", "seed")}
        of_ladders = ("bandwidths", "pairs", "points_per_wave", "reduced_pressure")
        own |= {name: getattr(self, f"ladder_{name}") for name in of_ladders}
        return Ladders(hursts=hursts, sizes=self.ladder_periods, **own) if self.ladders and hursts else None


#: What is solved: a family of spectra, or which ladder, then H and what else tells it apart.
_Case = tuple[Any, ...]


def design(options: Options) -> dict[_Case, Call]:
    """Return the solves: every spectrum's pairs, one of them with a smaller residual, and those of the ladders."""
    cases: dict[_Case, Call] = {}
    told: dict[str, Any] = {"periods": options.periods, "seed": options.seed}
    for (family, hurst), bandwidth in options.spectra.items():
        surface = base_surface(hurst=hurst, bandwidth=bandwidth, **told)
        loads, count = options.reduced_pressures, {"pairs": options.pairs, "shifts": options.shifts}
        solves = pressed_pairs(surface, loads, options.points_per_wave, **count)
        cases |= {(family, hurst, k): solve for k, solve in enumerate(solves)}
    usual = next(iter(cases.values()))
    cases["strict",] = usual.but(tolerance=usual["tolerance"] / 100)
    if options.beside:
        cases |= options.beside.cases
    return cases | (options.climbed.cases if options.climbed else {})


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Measure kappa for every spectrum, surface and load, and how it moves with the bandwidth and with the sample.

    Returns kappa (family, hurst, load), of each surface, counted and corrected, with all theories, by load; on the
    ladders, over (ladder, rung), with its limits. Surfaces 2k and 2k + 1 are +h and -h; all spectra share their
    phases.
    """
    cases = design(options)
    measured = solved(bench, cases)
    share = solver_error(measured[next(iter(cases))], measured["strict",])
    data = _of_spectra(options, cases, measured)
    data = claim(data, "kappa", solver=share * data.kappa)
    if options.beside:
        data = data.merge(options.beside.reduced(measured), combine_attrs="override")
    if options.climbed:
        climbed = options.climbed.reduced({case: measured[case] for case in options.climbed.cases})
        data = data.merge(ladders_beside_published(climbed), combine_attrs="override")
        spectral = spectral_errors(data, hurst=data.hurst, bandwidth=data.bandwidth, periods=options.periods)
        data = claim(data, "kappa", **{source: part * data.kappa for source, part in spectral.items()})
    data = data.merge(published("kappa")).assign(kappa_bgt=KAPPA_BGT, kappa_persson_light=KAPPA_PERSSON)
    seconds = sum(float(result.seconds.sum()) for result in measured.values())
    cited = dict.fromkeys(chosen_solver(name)[0].name for name in options.others)
    methods = " ".join([RANKED, *cited, papers_of("kappa", "kappa_ratio")])
    return data.assign_attrs(study="hurst", methods=methods, periods=options.periods, seconds=seconds)


def _of_spectra(
    options: Options, cases: Mapping[_Case, Call], measured: Mapping[_Case, xr.Dataset]
) -> xr.Dataset:
    """Reduce the spectra: kappa and its means over pairs, from lowest to highest H, over the theory, counted."""
    parts, surfaces = {}, range(2 * options.pairs)
    for (family, hurst), bandwidth in options.spectra.items():
        part = gather({k: limits_of(measured[family, hurst, k]) for k in surfaces}, surface=surfaces)
        spectrum = cases[family, hurst, 0]["problem"].spectrum
        parts[family, hurst] = with_ensemble(part.assign(bandwidth=bandwidth), spectrum)
    families, hursts = (list(dict.fromkeys(names)) for names in zip(*parts, strict=True))
    data = with_variants(gather(parts, family=families, hurst=hursts))
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
    bare = data[["kappa", "kappa_pixel"]].isel(family=0, drop=True)
    spread = "{0}.max(['hurst', 'load']) / {0}.min(['hurst', 'load']) - 1"
    spreads = {f"{name}_spread": spread.format(name) for name in ("kappa", "kappa_pixel")}
    return data.assign(derive(bare, **spreads)[[*spreads]])


def views(data: xr.Dataset) -> Views:
    """Kappa against H, against the Nayak parameter, and along the ladders."""
    climbed, beside = "ladder" in data.dims, "solver" in data.dims
    names = ("family", "hurst", "bandwidth", "nayak", "reduced_pressure", "kappa")
    counted = (Column("kappa_pixel", {"grid": -1}), Column("kappa_pixel", {"grid": 0}))
    theories = ("kappa_persson", "kappa_ensemble", "kappa_yang_persson", "kappa_wang_mueser", "kappa_xu")
    return Views(
        table=Table(rows=("family", "hurst", "load"), columns=(*names, *counted, *theories)),
        budget=("kappa", *(("kappa_by_solver",) if beside else ())),
        figures=[
            *(_of_solvers_against_hurst(data) if beside else ()),
            _against_hurst(data),
            _against_nayak(climbed),
            *(_ladder_figures() if climbed else ()),
        ],
        findings=[
            *(_beside(data) if beside else ()),
            *_of_families(data),
            *(_of_ladders(data) if climbed else ()),
        ],
    )


#: Published ranges and points, told apart by their sources.
_LITERATURE = Band(
    y="kappa_published",
    high="kappa_published_high",
    x="hurst_published",
    by="paper_kappa",
    look={"color": "black", "mfc": "white"},
)


def _of_solvers_against_hurst(data: xr.Dataset) -> Iterator[Figure]:
    """Every solver's own limit in one panel as wide as a column, with the other bandwidths at that load."""
    light = float(data.reduced_pressure_by_solver)
    same = np.flatnonzero(np.isclose(data.reduced_pressure, light))
    wide = [
        Line(
            y="kappa",
            by="family",
            at={"load": int(k)},
            look={"mfc": "white", "ls": ":"},
            label="boundary elements, {family}",
        )
        for k in same
    ]
    own = Line(y="kappa_by_solver", by="solver")
    caption = f"kappa against the Hurst exponent at p* = {light:g}, limits over the grids of each solver on the same "
    caption += (
        f"surfaces of bandwidth {float(data.bandwidth_by_solver):g}; Persson's theory; published values."
    )
    panel = Panel(
        marks=[own, *wide, Level(y="kappa_persson_by_solver", label="Persson"), _LITERATURE],
        x="hurst",
        bottom=1.5,
    )
    yield Figure(name="kappa-of-solvers", caption=caption, panels=[panel], width=4.2, height=4.4)


def _against_hurst(data: xr.Dataset) -> Figure:
    """One panel for each load: limit, counts, theory; literature where the load is light."""
    marks = (
        Line(y="kappa", label="limit over grids"),
        Line(y="kappa_pixel", at={"grid": 0}, label="counted, coarsest grid"),
        Level(y="kappa_persson"),
    )
    panels = panels_along(data, "load", Panel(marks=marks, x="hurst", at={"family": 0}, bottom=1.35))
    area = data.kappa.isel(family=0).mean("hurst") * data.reduced_pressure
    return Figure(
        name="kappa-against-hurst",
        caption="kappa against the Hurst exponent at each load: the limit over grids, points counted on the coarsest "
        "grid, and Persson's theory; black, published values (light load).",
        panels=[
            replace(panel, marks=(*marks, _LITERATURE)) if float(light) < _LIGHT else panel
            for panel, light in zip(panels, area, strict=True)
        ],
        width=2.9 * max(2, len(panels)) + 1,
        height=4.4,
    )


def _against_nayak(climbed: bool) -> Figure:
    """Kappa of all spectra and loads, and along the ladders of bandwidth."""
    theories = (Level(y="kappa_bgt"), Level(y="kappa_persson_light"))
    rungs = Line(y="kappa_by_bandwidth", x="nayak_by_bandwidth", by="ladder")
    lines = [Line(y="kappa", by=("family", "load")), *([rungs] if climbed else [])]
    panels = [Panel(marks=(line, *theories), x="nayak", y="kappa", log="x") for line in lines]
    caption = "The same kappa against the realised Nayak parameter; right, as the bandwidth grows at equal H."
    size = {"width": 4.6 * len(panels), "height": 4.8}
    return Figure(name="kappa-against-nayak", caption=caption, panels=panels, **size)


def _ladder_figures() -> tuple[Figure, ...]:
    """Kappa on the rungs with the lines to their limits; alpha(zeta) over the theory's."""
    panels = []
    for kind, title in (("by_bandwidth", "lambda_short/lambda_long falls"), ("by_size", "the sample grows")):
        end = f"step_{kind}_line"
        marks = (
            Line(y=f"kappa_{kind}", by="ladder", joined=False, look={"mfc": "white"}),
            Line(y=f"kappa_{kind}_line", x=end, by="ladder", look={"marker": "", "lw": 0.8}, label=""),
            Line(y=f"kappa_{kind}_limit", x=end, at={"end": 0}, by="ladder", label=""),
        )
        panels.append(Panel(marks=marks, x=f"step_{kind}", y="kappa", title=title))
    ratio = [Line(y="kappa_ratio_by_bandwidth", by="ladder")]
    paper, published = "paper_kappa_ratio", "kappa_ratio_published"
    papers = [
        Level(y=published, at={paper: k}, look={"ls": ls}, label=f"{{{paper}}}")
        for k, ls in enumerate((":", "--", "-"))
    ]
    return (
        Figure(
            name="kappa-limits",
            caption="kappa against the step to its order as the bandwidth grows (left) and the sample (right); lines and "
            "filled symbols at 0: the limit where it is determinable.",
            panels=panels,
            width=9.0,
            height=4.2,
        ),
        Figure(
            name="alpha-against-magnification",
            caption="Slope alpha(zeta) of A = alpha F over that of Persson's theory as waves are added; black, published "
            "for H = 0.8, as Persson (2006, Sec. 3.5) quotes them.",
            panels=[Panel(marks=[*ratio, *papers], x="bandwidth_rung", log="x", base=2)],
        ),
    )


def _beside(data: xr.Dataset) -> Iterator[Finding]:
    """Say what each other solver has of the same surfaces."""
    form = "By its own limit over grids kappa is, at p* = {reduced_pressure_by_solver} and bandwidth {bandwidth_by_solver}, by "
    form += "{solver}: {each}."
    item = (
        "{kappa_by_solver} at H = {hurst}, {kappa_by_solver_difference:+%} from boundary elements ({verdict})"
    )
    words = {"agree": "not distinguishable", "differ": "beyond the intervals"}
    for k in range(1, data.sizes["solver"]):
        here = data.isel(solver=k)
        yield finding(
            "agreement", form, here, item=item, over="hurst", by="kappa_by_solver_difference", words=words
        )


def _of_families(data: xr.Dataset) -> Iterator[Finding]:
    """Say what H changes, what counting adds, how far the theory is off."""
    ends: dict[str, Any] = {"first": float(data.hurst[0]), "last": float(data.hurst[-1])}
    ends |= {"low": float(data.bandwidth.min()), "high": float(data.bandwidth.max())}
    if data.sizes["hurst"] > 1:
        form = "From H = {first} to {last} kappa {each}."
        item = "{verdict}, {kappa_change:%}, at p* = {reduced_pressure} with {family}"
        none = {"0": "shows no trend beyond its interval"}
        over = ("family", "load")
        yield finding("trend", form, data, item=item, over=over, by="kappa_change", words=none, **ends)
    form = "Counted kappa is {each}; over H and load the limit spreads by {kappa_spread:%}, what counting spreads more is a "
    form += "discretisation artefact."
    item = "{verdict} the limit, by {kappa_excess:%}, at lambda_short/dx = {points_per_wave} (spread {kappa_pixel_spread:%})"
    plain = data.isel(family=0, hurst=0)
    yield finding("comparison", form, plain, item=item, over="grid", by="kappa_excess")
    wide = "{low}" if ends["low"] == ends["high"] else "{low} to {high}"
    form = (
        f"The limit over Persson's theory is {{each}} (mean over spectra of lambda_long/lambda_short {wide})."
    )
    yield finding("value", form, data, item="{kappa_ratio} at p* = {reduced_pressure}", over="load", **ends)


def _of_ladders(data: xr.Dataset) -> Iterator[Finding]:
    """Say what H changes at equal alpha and alpha at equal H, where kappa goes, and what was published of alpha(zeta)."""
    if data.sizes["ladder"] > 1:
        ends: dict[str, Any] = {"first": float(data.hurst_ladder[0]), "last": float(data.hurst_ladder[-1])}
        form = "At the Nayak parameter {nayak_by_bandwidth_equal} kappa at H = {last} is {verdict} that at H = {first}, "
        form += "{kappa_by_bandwidth_equal_change:%}; as the bandwidth grows at equal H it changes by {each}."
        item, by = "{kappa_by_bandwidth_change:%} (H = {hurst_ladder})", "kappa_by_bandwidth_equal_change"
        yield finding("comparison", form, data, item=item, over="ladder", by=by, **ends)
    form = "As waves are added at p* = {reduced_pressure_ladder}, for which the budget has bandwidth and size, kappa {each}."
    item = "{verdict} at H = {hurst_ladder}, limit {kappa_by_bandwidth_limit}, for an endless sample {kappa_by_size_limit}"
    words = {"+": "falls", "-": "rises", "0": "shows no trend beyond its interval"}
    yield finding("trend", form, data, item=item, over="ladder", by="kappa_by_bandwidth_slope", words=words)
    close = np.flatnonzero(np.isclose(data.hurst_ladder, _PUBLISHED))
    if close.size:
        own, over = data.isel(ladder=int(close[0]), bandwidth_rung=-1), "paper_kappa_ratio"
        form = "At D_f = 2.2, zeta = {bandwidth_rung} and p* = {reduced_pressure_ladder} alpha is {kappa_ratio_by_bandwidth} of "
        form += "Persson's; published, mostly for more waves: {each}."
        item, by = "{kappa_ratio_published} ({paper_kappa_ratio}) {verdict}", "kappa_ratio_difference"
        words = {"agree": "agrees within the interval", "differ": "lies outside the interval"}
        yield finding("agreement", form, own, item=item, over=over, by=by, words=words)
