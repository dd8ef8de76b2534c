"""Why is Persson's theory off: which terms of its diffusion equation fail, where, and how far do they cancel?

One surface is built up ring by ring of waves at one nominal pressure, each ring with both signs, and the pressure of
every point is compared with that before. In the theory it diffuses with D = 1 and without drift, and what reaches p = 0
is lost for good. Each of these is measured, and the budgets of area, load and mean square pressure that they make up.
"""

import itertools
from typing import Annotated, Any, Self

import numpy as np
import xarray as xr
from pydantic import AfterValidator, Field, model_validator

from validation.measurements.common import Resolved, Rising, RisingSeveral, base_case
from validation.measurements.diffusion import HALF, SQUARE_TERMS, budgets_of, with_diffusion_terms
from validation.measurements.edge import slopes_of
from validation.measurements.measurement import even_points
from validation.measurements.rings import PROFILE_EDGES, RING, chain, probe, ring_ends
from validation.report.estimates import claim, derive
from validation.report.places import gather, nearest
from validation.report.views import Figure, Findings, Line, Table, Views, against, finding, panels_along
from validation.scenes.problem import ContactProblem
from validation.studies._options import Hurst, Seed, StudyOptions, Surfaces
from validation.studies._study import ABSENT, Bench
from validation.units import wrong


def _rough(magnifications: tuple[float, ...]) -> tuple[float, ...]:
    if magnifications[0] < 2:
        raise wrong("must be at least 2: a surface of one wave length is not rough")
    return magnifications


class Options(StudyOptions):
    """Spectra, loads, rings, and the grids over which every flow is extrapolated."""

    why_no_scene = "it builds its surfaces up ring by ring of waves"

    hursts: Annotated[tuple[Hurst, ...], Field(min_length=1)] = (0.3, 0.8)
    """Hurst exponents H"""
    reduced_pressures: Rising = (0.02, 0.05, 0.3, 1.0)
    """p* = p0 / (E* h'_rms) with the realised gradient of all waves, rising"""
    periods: int = Field(default=2, ge=1, le=64)
    """L / lambda_long, whole: rings are of such waves"""
    bandwidth: float = Field(default=32.0, ge=2, le=1024)
    """lambda_long / lambda_short"""
    steps_per_octave: int = Field(default=2, ge=2, le=64, multiple_of=2)
    """rings of waves in each octave, even"""
    surfaces: Surfaces = 4
    points_per_wave: Resolved = (8.0, 12.0)
    """grids of the rings, as lambda_short/dx, rising"""
    probes: Annotated[Rising, AfterValidator(_rough)] = (2.0, 4.0, 8.0)
    """magnifications at which the surface is cut, pressed with these p* of its own gradient, and given one
    more ring as high as the steps below ask for, rising"""
    probe_surfaces: Surfaces = 8
    variance_steps: RisingSeveral = (0.0025, 0.01, 0.04, 0.16)
    """Delta V / V of that ring, rising"""
    probe_points_per_wave: Resolved = (12.0, 24.0)
    """grids there, as the shortest wave there is over dx, rising"""
    slope_points_per_wave: Annotated[Rising, Field(min_length=3)] = (16.0, 32.0, 64.0)
    """grids of the slope of P(p) at zero there, rising"""
    seed: Seed = 2006

    @model_validator(mode="after")
    def _grids_differ(self) -> Self:
        for name, zeta in (("points_per_wave", self.bandwidth), ("probe_points_per_wave", self.probes[0])):
            grids = [even_points(n * zeta * self.periods) for n in getattr(self, name)]
            if len({*grids}) < len(grids):
                raise wrong(f"{name}: too close, two are a grid of as many points")
        if len(self.octaves) < 2:
            raise wrong(f"bandwidth = {self.bandwidth:g}: no octave ends with a ring; take a power of two")
        return self

    @property
    def ends(self) -> tuple[float, ...]:
        """Magnifications at which the rings end."""
        ends = ring_ends(**self.model_dump(include={"periods", "bandwidth", "steps_per_octave"}))
        return tuple(float(end) for end in ends)

    @property
    def octaves(self) -> tuple[float, ...]:
        """Where octaves begin and end, the last one cut where the bandwidth is no power of two."""
        return tuple(e for e in self.ends if abs(np.log2(e) - round(np.log2(e))) < 1e-9)

    def problem(self, hurst: float, load: float, surface: int, *, bandwidth: float) -> ContactProblem:
        """Return a surface at a load."""
        whole = self.self_affine(hurst=hurst, bandwidth=bandwidth)
        return base_case(whole, reduced_pressure=load).further(surface)


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Build every surface up ring by ring, and probe single rings.

    Over (hurst, load, surface, grid): the budgets of every ring (step), and of single rings of given Delta V / V
    (``_probe``), and what `validation.measurements.diffusion` makes of them.
    """
    probes = {zeta: _probes(options, bench, zeta) for zeta in options.probes}
    dims: dict[str, Any] = {"hurst": options.hursts, "load": options.reduced_pressures}
    dims |= {"surface": range(options.surfaces), "grid": options.points_per_wave}
    chains = {
        (*place, n): chain(
            problem=options.problem(*place, bandwidth=options.bandwidth),
            points=even_points(n * options.bandwidth * options.periods),
            ends=options.ends,
            restarts=options.octaves[:-1],
        )
        for *place, n in itertools.product(*dims.values())
    }
    data = (
        budgets_of(bench, chains, *dims)
        .merge(gather(probes, "probe"))
        .assign_coords(
            reduced_pressure=("load", list(options.reduced_pressures)),
            magnification=("level", list(options.ends)),
            octave=[f"{a:g}-{b:g}" for a, b in itertools.pairwise(options.octaves)],
            octave_start=("octave", list(options.octaves[:-1])),
            probe=[f"zeta = {zeta:g}" for zeta in options.probes],
            relative_step=("variance_step", list(options.variance_steps)),
            upper=("bin", PROFILE_EDGES[1:]),
            age=lambda data: np.arange(data.sizes["age"]),
        )
    )
    stated = ("area_ratio", "square_growth_late", "edge_loss")
    data = claim(with_diffusion_terms(data), *stated, **ABSENT)
    asked = options.model_dump(include={"periods", "bandwidth", "surfaces"})
    return data.assign_attrs(methods="theory bem", **asked)


def _probes(options: Options, bench: Bench, zeta: float) -> xr.Dataset:
    surfaces, cases, there = range(options.probe_surfaces), {}, {}
    for place in itertools.product(options.hursts, options.reduced_pressures, surfaces):
        there[place] = options.problem(*place, bandwidth=zeta)
        for n in options.probe_points_per_wave:
            cases[*place, n] = probe(
                # The waves do not depend on where the spectrum is cut, but for their common scale.
                problem=options.problem(*place, bandwidth=zeta * RING),
                points=even_points(n * zeta * options.periods),
                magnification=zeta,
                steps=options.variance_steps,
            )
    per_wave = options.slope_points_per_wave
    slope = slopes_of(bench, there, "hurst", "load", "probe_surface", points_per_wave=per_wave)
    data = budgets_of(bench, cases, "hurst", "load", "surface", "grid")
    dims = {"step": "variance_step", "level": "probe_level", "grid": "probe_grid", "surface": "probe_surface"}
    apart = {
        n: n.replace("_each", "_probe_each") if "_each" in n else f"{n}_probe"
        for n in map(str, data.data_vars)
    }
    return data.rename(dims | apart).merge(slope.drop_vars(["load", "probe_surface"]))


def views(data: xr.Dataset) -> Views:
    """Terms of the diffusion equation, flows, restarts and memory."""
    rough = {"hurst": -1}
    at = {**rough, "load": nearest(data.reduced_pressure, 0.05)}
    step = nearest(data.relative_step, 0.01)
    terms = [Line(name, at=rough, label="sum" if name == SQUARE_TERMS[0] else None) for name in SQUARE_TERMS]
    plain = {"color": "black", "ls": "--", "lw": 0.8, "marker": ""}
    diffused = Line("area_ratio_diffused", by="octave", at=rough, label="", look=plain)
    profiles = [
        against("bin_mean_pressure", Line(y, by=by, at={**at, **where}), bottom=bottom, top=top)
        for y, by, where, bottom, top in (
            ("diffusivity", "variance_step", {"probe": -1}, 0.0, 4.0),
            ("diffusivity", "probe", {"variance_step": step}, 0.0, 4.0),
            ("mean_drift", "probe", {"variance_step": step}, -2.0, 3.0),
        )
    ]
    single: dict[str, Any] = {"by": "load", "at": {**rough, "probe": -1}, "label": "p* = {reduced_pressure}"}
    flows = [
        against("relative_step", Line(y, **single), log=log)
        for y, log in (("share_lost", "xy"), ("entered_ratio", "x"), ("area_exponent_probe", "x"))
    ]
    chance = Line("return_chance", by="load", at={"age": list(range(1, data.sizes["age"]))})
    columns = ("hurst", "reduced_pressure", "octave", *SQUARE_TERMS, "square_told", "square_growth_path")
    areas = ("area_exponent", "area_exponent_pixel", "area_exponent_persson", "loss_ratio", "area_ratio_end")
    return Views(
        table=Table(("hurst", "load", "octave"), (*columns, *areas)),
        budget=("square_growth_late", "edge_loss", "pressure_slope"),
        figures=[
            Figure(
                "budget",
                "Where d<p^2>/(A dV) comes from by octave, largest H: Persson's theory has diffusion alone, 1.",
                panels_along(data, "load", against("octave_start", *terms, log="x")),
            ),
            Figure(
                "restarts",
                "Contact area over Persson's; dashed, where absorbing diffusion goes from the true P(p), largest H.",
                panels_along(
                    data, "load", against("magnification", Line("area_ratio", by="hurst"), diffused, log="x")
                ),
            ),
            Figure(
                "drift-and-diffusivity",
                "Diffusivity and drift of points in contact by their pressure, largest H, p* near 0.05: the theory has 1 and 0.",
                profiles,
            ),
            Figure(
                "fluxes",
                "Area that a ring takes out of contact, what it brings back over that, and the net, against its step, largest "
                f"H and zeta, {_CUT}.",
                flows,
            ),
            Figure(
                "memory",
                "Chance that a ring brings a point back into contact: without memory it would be one number.",
                panels_along(data, "hurst", against("age", chance, log="y")),
            ),
        ],
        findings=[*_findings(data)],
    )


_WHERE = "at H = {hurst} and p* = {reduced_pressure}"
#: What p* is of there: a surface that is cut is pressed by its own gradient.
_CUT = "p* in the gradient of the waves up to there"


def _findings(data: xr.Dataset) -> Findings:
    data = data.isel(load=np.flatnonzero((data.area.isel(level=-1) < 0.999).all("hurst").values))
    probed = data.isel(probe=-1).rename(probe="place")
    yield finding(
        "comparison",
        "With all waves (zeta = {magnification}) the area over Persson's is {each}.",
        derive(data.isel(level=-1), area_excess="area_ratio - 1"),
        item=f"{{area_ratio}} {_WHERE} ({{verdict}} 1)",
        by="area_excess",
    )
    form = "Mean square pressure over A dV from zeta = 4 on, where the theory has 1, diffusion alone: {each}. D(p), mu(p) "
    form += "and re-entry make it but for {square_gap:%} at most."
    item = f"{{square_growth_late}} {_WHERE} (diffusion {{square_diffusion_late:~}}, drift "
    item += "{square_drift_late:~}, re-entry {square_reentry_late:~})"
    yield finding("value", form, data, item=item)
    yield finding(
        "equivalence",
        f"As the step vanishes ({{place}}, {_CUT}), the area that leaves contact goes with Delta V to a power, "
        f"1/2 if within {HALF} of it: {{each}}. With less than 1 no flow over p = 0 has a value without its step.",
        probed,
        item=f"{{verdict}}, {{power_limit}} {_WHERE}",
        by="power_excess",
        words={"within": "1/2", "beyond": "not 1/2", "undecided": "1/2 or not: not decided"},
    )
    form = f"Eq. 26 with the true slope of P(p) at zero ({{place}}, {_CUT}) has for the loss of area -d ln A/d ln V: {{each}}."
    item = f"{{edge_loss_slope}}, {{verdict}} the true {{edge_loss}}, {_WHERE} (P'(0) is {{slope_ratio}} times Persson's)"
    yield finding("comparison", form, probed, item=item, by="edge_loss_excess")
    yield finding(
        "comparison",
        "Over half an octave, diffusion started from the true P(p) at zeta = {octave_start} loses over the area that the "
        "truth loses: {each}.",
        derive(data.isel(octave=nearest(data.octave_start, 4.0)), loss_excess="loss_ratio - 1"),
        item=f"{{loss_ratio}} {_WHERE} ({{verdict}})",
        by="loss_excess",
        words={"+": "faster", "-": "slower", "0": "statistically indistinguishable", "?": "nothing is lost"},
    )
    form = "The laws of single rings compose to an inflow over two rings, over the contact area, of {each}."
    item = f"{{inflow_share_composed:~}}, {{verdict}} the true {{inflow_share:~}}, {_WHERE}"
    yield finding("comparison", form, data, item=item, by="inflow_excess")
