"""How large are contact area, gap, stiffness and energy of self-affine surfaces, with their total uncertainty?

The table that others can check against. Few pairs of surfaces +h, -h are solved on fine grids, more on coarser ones whose
area follows the fine one from surface to surface, most are only looked at; together they give the mean over all surfaces
of a spectrum (`validation.measurements.control_variates`). It is made once, shipped, and read by `fem-contact reference`.
"""

import itertools
from typing import Annotated, Any, Literal, Self

import numpy as np
import xarray as xr
from pydantic import Field, model_validator

from validation.measurements.common import Counts, Ladder, Rising, RisingOrNone, base_case
from validation.measurements.table_samples import QUANTITIES, SampledSpectrum, joined, with_size
from validation.measurements.theory import VARIANTS, with_variants
from validation.reference.citable import citable
from validation.reference.fit import at_equal_alpha
from validation.report.estimates import claim, derive, total_error
from validation.report.places import gather
from validation.report.views import Figure, Findings, Line, Table, Views, against, finding, panels_along
from validation.studies._options import Periods, Seed, StudyOptions
from validation.studies._study import Bench, solved
from validation.units import wrong

#: Numbers of pairs are those of the options at this bandwidth, and in proportion to its inverse at others: surfaces with
#: fewer waves scatter more and cost less.
_USUAL_BANDWIDTH = 16.0
#: Of the solver.
_TOLERANCE = 1e-6
#: Grids that a limit takes at least, and pairs that tell a variance.
_LEAST_GRIDS, _LEAST_PAIRS = 3, 4
#: Between the seeds of the table and those of larger samples.
_APART = 1_000_000
#: Nayak parameters at which Hurst exponents are compared, and the load up to which they are [p*].
_ALPHAS, _MIDDLING = (3.0, 4.0, 6.0, 10.0, 16.0), 0.3


class Options(StudyOptions):
    """Spectra and loads of the table, and how many surfaces each is a mean over."""

    why_no_scene = "it makes the table that others are checked against, of surfaces it names"

    hursts: Rising = (0.1, 0.3, 0.5, 0.8, 1.0)
    """Hurst exponents H, rising, at most 1"""
    bandwidths: Rising = (4.0, 8.0, 16.0, 32.0)
    """lambda_long / lambda_short, rising"""
    reduced_pressures: Rising = (0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.57, 0.8, 1.1, 1.5)
    """p* = p0 / (E* h'_rms) with the realised gradient of each surface, rising"""
    periods: Periods = 4.0
    points_per_wave: Ladder = (3.0, 6.0, 12.0, 24.0)
    """grids, as lambda_short/dx, rising"""
    largest: int = Field(default=500, ge=2)
    """points along a side beyond which a fourth or later grid is left out"""
    pairs: Annotated[Counts, Field(min_length=2)] = (80, 18, 6, 2)
    """pairs +h, -h at bandwidth 16 that end with each of the grids, coarsest first; elsewhere in proportion
    to 1/bandwidth, at least 4"""
    wide_pairs: Counts = (40, 4, 4, 4)
    """the same beyond bandwidth 16, as they stand; at least 4 on the coarsest grid"""
    unsolved: int = Field(default=10, ge=1)
    """pairs that are not solved, only looked at, for each that ends with the coarsest grid"""
    gaussian: RisingOrNone = (0.3, 0.8)
    """those Hurst exponents at which surfaces with Gaussian amplitudes are solved as well"""
    gaussian_bandwidths: RisingOrNone = (4.0, 8.0)
    """and the bandwidths of these"""
    larger: RisingOrNone = (0.3, 0.8)
    """those at which samples of twice the periods are solved as well, a quarter as many, on the coarsest grid"""
    larger_bandwidths: RisingOrNone = (4.0, 8.0, 16.0, 32.0)
    """and the bandwidths of these"""
    rolloff: Literal["sharp", "plateau"] = "sharp"
    """C(q) of waves longer than lambda_long: none, or C(2 pi/lambda_long) up to the period"""
    shifts: int = Field(default=1, ge=1, le=8)
    """sub-grid shifts along each axis"""
    seed: Seed = 2006

    @model_validator(mode="after")
    def _pairs_for_each_grid(self) -> Self:
        grids, pairs, wide = map(len, (self.points_per_wave, self.pairs, self.wide_pairs))
        if pairs != grids or wide < grids:
            name, count = ("wide_pairs", wide) if pairs == grids else ("pairs", pairs)
            raise wrong(f"{name} has {count} numbers: needs one for each of points_per_wave")
        return self

    def ladder_of(self, bandwidth: float) -> tuple[float, ...]:
        """Return the points per wave of the grids that are solved: three, and more where they are small."""
        whole = self.points_per_wave
        fits = sum(self.periods * bandwidth * points <= self.largest for points in whole)
        return whole[: max(fits, min(len(whole), _LEAST_GRIDS))]

    def pairs_of(self, bandwidth: float) -> tuple[int, ...]:
        """Return how many pairs end with each grid of the ladder."""
        grids = len(self.ladder_of(bandwidth))
        if bandwidth > _USUAL_BANDWIDTH:
            return (max(_LEAST_PAIRS, self.wide_pairs[0]), *self.wide_pairs[1:grids])
        more = _USUAL_BANDWIDTH / bandwidth
        return tuple(max(_LEAST_PAIRS, int(np.ceil(more * count - 1e-9))) for count in self.pairs[:grids])

    def part(self, hursts: tuple[float, ...], bandwidths: tuple[float, ...]) -> Self | None:
        """Return the options of those of its spectra that are among some; None where none is."""
        selection = {
            "hursts": tuple(value for value in self.hursts if value in hursts),
            "bandwidths": tuple(value for value in self.bandwidths if value in bandwidths),
        }
        return self.model_copy(update=selection) if all(selection.values()) else None

    def samples_by_size(self) -> tuple[Self, Self] | None:
        """Return what makes samples as in the table, and of twice the periods, on the coarsest grid; None without one."""
        part = self.part(self.larger, self.larger_bandwidths)
        if part is None:
            return None
        first, wide = self.pairs[0], self.wide_pairs[0]
        coarsest = {"points_per_wave": self.points_per_wave[:1], "pairs": (first,), "wide_pairs": (wide,)}
        fewer = {"pairs": (-(-first // 4),), "wide_pairs": (-(-wide // 4),)}
        twice = {"periods": 2 * self.periods, "seed": self.seed + _APART}
        return part.model_copy(update=coarsest), part.model_copy(update=coarsest | fewer | twice)


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Solve all pairs of every spectrum, and take the controlled mean of each quantity.

    Over (amplitudes, hurst, bandwidth, reduced_pressure), NaN where nobody asked, for each of `QUANTITIES` and for
    the area at p* by the gradient of C(q): the mean with its errors by source; ``saving``; how far the theories are
    off; areas of the exact amplitudes at equal Nayak parameter.
    """
    made = _means(options, "exact", bench)
    if samples := options.samples_by_size():
        made = with_size(made, *(_means(part, "exact", bench) for part in samples))
    gaussian = options.part(options.gaussian, options.gaussian_bandwidths)
    whole = joined([made, _means(gaussian, "gaussian", bench)]) if gaussian else made
    return citable(_with_theories(whole))


def spectra(options: Options, amplitudes: str) -> dict[tuple[float, float], SampledSpectrum]:
    """Return what is solved by Hurst exponent and bandwidth, of surfaces with such amplitudes."""
    sampled = {}
    for hurst, bandwidth in itertools.product(options.hursts, options.bandwidths):
        sharp = options.self_affine(hurst=hurst, bandwidth=bandwidth)
        surface = sharp.model_copy(update={"amplitudes": amplitudes, "rolloff": options.rolloff})
        sampled[hurst, bandwidth] = SampledSpectrum(
            base=base_case(surface, reduced_pressure=options.reduced_pressures[0]),
            loads=options.reduced_pressures,
            points_per_wave=options.ladder_of(bandwidth),
            pairs=options.pairs_of(bandwidth),
            unsolved=options.unsolved,
            shifts=options.shifts,
            tolerance=_TOLERANCE,
        )
    return sampled


def _means(options: Options, amplitudes: str, bench: Bench) -> xr.Dataset:
    sampled = spectra(options, amplitudes)
    measured = solved(
        bench, {(at, c): s for at, spectrum in sampled.items() for c, s in spectrum.cases.items()}
    )
    cells = {
        at: spectrum.reduced({c: measured[at, c] for c in spectrum.cases}) for at, spectrum in sampled.items()
    }
    data = gather(cells, "hurst", "bandwidth")
    attributes = options.model_dump(include={"periods", "unsolved", "seed", "rolloff"})
    return data.expand_dims(amplitudes=[amplitudes]).assign_attrs(
        study="reference", methods="bem", tolerance=_TOLERANCE, **attributes
    )


def _with_theories(data: xr.Dataset) -> xr.Dataset:
    data = derive(with_variants(data), kappa="area / reduced_pressure", area_excess="area / area_persson - 1")
    data = derive(data, **{f"theory_excess_{name}": f"area_{name} / area - 1" for name in VARIANTS})
    exact = data.sel(amplitudes="exact")
    exact = exact.assign(interval=total_error(exact, "area") / exact.area)
    cells = "(['hurst', 'bandwidth'])"
    summaries = {
        "interval_median": f"interval.median{cells}",
        "interval_worst": f"interval.max{cells}",
        "area_excess_low": f"area_excess.min{cells}",
        "area_excess_high": f"area_excess.max{cells}",
        "saving_median": "saving.median(['hurst', 'reduced_pressure'])",
    }
    bare = derive(exact[["interval", "area_excess", "saving"]], **summaries)
    equal = at_equal_alpha(exact, _ALPHAS)
    several = equal.area.where(equal.area.notnull().sum("hurst") > 1)
    added = (
        equal.drop_vars("area_error")
        .rename({"area": "area_equal", "bandwidth": "bandwidth_equal", "alpha": "nayak_equal"})
        .assign(area_equal_spread=(several.max("hurst") / several.min("hurst") - 1).max("alpha"))
    )
    data = data.assign(bare[[*summaries]]).merge(added.transpose(..., "reduced_pressure"))
    data = claim(data, "area_equal", surfaces=equal.area_error.rename(alpha="nayak_equal"))
    return derive(data, kappa_equal="area_equal / reduced_pressure")


def views(data: xr.Dataset) -> Views:
    """Kappa over the load and at equal Nayak parameter, the theories over the table; of exact amplitudes."""
    names = ("kappa", *QUANTITIES[1:], "area_by_spectrum", "area_excess", "saving")
    made = data.area.sel(amplitudes="exact").notnull().all(["hurst", "reduced_pressure"])
    widest = {"amplitudes": 0, "bandwidth": int(np.flatnonzero(made)[-1]) if made.any() else 0}
    load: dict[str, Any] = {"log": "x", "at": widest}
    plain: dict[str, Any] = {"by": "hurst", "label": "H = {hurst}", "look": {"ls": "-"}}
    lines = {name: Line(f"theory_excess_{name}", **plain) for name in VARIANTS}
    variants = [
        against("reduced_pressure", lines[name], y="theory_excess", title=title, **load)
        for name, title in VARIANTS.items()
    ]
    alpha = against("nayak_equal", Line("kappa_equal", **plain), log="x")
    light = np.flatnonzero(data.reduced_pressure.values < _MIDDLING)
    few = sorted({int(light[k]) for k in (0, light.size // 2, -1)}) if light.size else [0]
    cell = ("amplitudes", "hurst", "bandwidth", "reduced_pressure")
    return Views(
        table=Table(cell, (*cell, "area", *names)),
        figures=[
            Figure(
                "reference",
                "kappa over the load for every Hurst exponent, at the largest bandwidth that all have.",
                [against("reduced_pressure", "kappa", by="hurst", **load)],
            ),
            Figure(
                "reference-verdict",
                "Area of Persson's theory and of its variants over that of the table less one, for every Hurst "
                "exponent at that bandwidth.",
                variants,
            ),
            Figure(
                "reference-alpha",
                "kappa over the Nayak parameter of C(q) for each Hurst exponent at light to middling loads, "
                "interpolated along the bandwidth. Were alpha all that matters, the lines would be one.",
                [panels_along(data, "reduced_pressure", alpha)[k] for k in few],
            ),
        ],
        findings=[*_findings(data, few)],
    )


def _findings(whole: xr.Dataset, few: list[int]) -> Findings:
    data, at = whole.isel(reduced_pressure=few), "at p* = {reduced_pressure}"
    form = "Half of the 95 % interval of A/A0 is {each} (surfaces, grid, solver, size; L/lambda_long = {periods})."
    item = "{interval_median:%} in the median and {interval_worst:%} at worst " + at
    yield finding("value", form, data, item=item)
    form = "The area lies above Persson's, by spectrum, by {each}."
    item = "{area_excess_low:%} to {area_excess_high:%} " + at
    yield finding("value", form, data, item=item)
    yield finding(
        "value",
        "At equal Nayak parameter the areas of the Hurst exponents that have it lie apart by at most {each}.",
        data,
        item="{area_equal_spread:%} " + at,
    )
    form = "Plain means over single surfaces on the same grids would cost, for the same intervals, in the median so many times "
    form += "what was spent on a load: {each}."
    yield finding("cost", form, whole, item="{saving_median} at lambda_long/lambda_short = {bandwidth}")
