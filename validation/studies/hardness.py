"""How much of the contact has yielded, by boundary elements over grids and by Persson's theory?

Surfaces of several seeds against a solid of given hardness: elastic and plastic area in the limit over grids against load,
and against magnification as the same surfaces gain wave after wave, beside the closed form for constant hardness with the
gradient of the same surfaces; and the spectrum of the smoothed surface left behind, beside Persson's.
"""

import itertools
from dataclasses import dataclass
from typing import Annotated, Any, Self

import numpy as np
import xarray as xr
from pydantic import Field, model_validator

from fem_contact.contact import ContactResult
from fem_contact.hardness import yielded
from fem_contact.surface import HeightField, radial_spectrum
from validation.arrays import Array
from validation.effects.base import TheoryInputs
from validation.effects.hardness import Hardness
from validation.effects.smoothing import Smoothing
from validation.execution.bench import Solves
from validation.execution.press import Press
from validation.measurements.common import BASE_SOLID, Counts, base_case
from validation.measurements.grids import squared_gradient
from validation.measurements.limits import straight_limit
from validation.report.estimates import claim, derive, mean
from validation.report.places import gather, spread
from validation.report.views import (
    Column,
    Figure,
    Finding,
    Line,
    Table,
    Views,
    against,
    finding,
    of_one_surface,
)
from validation.scenes.problem import ContactProblem
from validation.solvers.theory import predict, smoothed_spectrum
from validation.studies._options import Bandwidth, Periods, Positives, Seed, SurfaceOptions, above_one
from validation.studies._study import ABSENT, Bench
from validation.units import Positive, wrong

_MODULUS = BASE_SOLID.young / (1 - BASE_SOLID.poisson**2)
_GRADIENT, _LENGTH = 0.1, 1e-4


def remaining_waves(contact: ContactResult, problem: ContactProblem) -> tuple[Array, Array, float]:
    """Return what yielding and unloading leave of a surface.

    Wavevectors [1/m] (n,) of the spectrum; C(q) after, over that before (n,); <|grad h|^2> after, over that
    before, where the surface yielded.
    """
    before = HeightField(heights=np.array(contact.heights), lengths=contact.lengths)
    after = yielded(contact).surface
    spectrum = problem.spectrum_shape
    rings, left = radial_spectrum(before), radial_spectrum(after)
    band = (rings.q >= spectrum.q_long) & (rings.q <= spectrum.q_short)
    slopes = [squared_gradient(field, 1)[contact.at_bound].mean() for field in (before, after)]
    return rings.q[band], left.power[band] / rings.power[band], float(slopes[1] / slopes[0])


def remaining_by_theory(problem: ContactProblem, hardness: float, wavevectors: Array) -> Array:
    """Share of C(q) that Persson's formula leaves, 1 - A_pl(q)/A_pl (2006, Sec. 10.2)."""
    spectrum = problem.own_spectrum
    squeezed = Smoothing(pressure=problem.pressure, hardness=hardness)
    after = smoothed_spectrum(spectrum, TheoryInputs.by(problem.elastic, (squeezed,)))
    return after(wavevectors) / spectrum(wavevectors)


class Options(SurfaceOptions):
    """What is pressed, how hard it is, and how often."""

    why_no_scene = "it turns load and waves by itself; `area` takes a scene that yields"

    reduced_pressures: Positives = (0.01, 0.02, 0.05, 0.1, 0.2)
    """p* = p0 / (E* h'_rms) with the realised gradient of all waves"""
    magnifications: Positives = (1.25, 1.5, 2.0, 3.0, 4.0)
    """zeta = q/q_long of the last wave there is, above 1, at most the bandwidth"""
    hardness: Positive = 0.6
    """H / (E* h'_rms) with the gradient asked for"""
    smoothing_reduced_pressure: Positive = 0.1
    """p* at which magnifications are walked through and surfaces are smoothed"""
    seed: Seed = 11
    surfaces: int = Field(default=2, ge=1)
    """how many"""
    grids: Annotated[Counts, Field(min_length=1)] = (64, 128, 256)
    """points along a side; the limit is that of the two finest, the one before says how sure it is"""
    periods: Periods = 4.0
    bandwidth: Bandwidth = 4.0

    @model_validator(mode="after")
    def _possible(self) -> Self:
        if len(set(self.grids)) < 2:
            raise wrong(f"grids = {', '.join(map(str, self.grids))}: at least two, for a limit")
        above_one(self.magnifications, bandwidth=self.bandwidth)
        return self

    @property
    def limit(self) -> float:
        """Hardness [Pa]."""
        return self.hardness * _MODULUS * _GRADIENT

    @property
    def ladder(self) -> tuple[int, ...]:
        """Grids, rising, each once."""
        return tuple(sorted(set(self.grids)))


@dataclass(frozen=True, kw_only=True)
class Case:
    """A load, and the last wave there is; what is varied: one of both, or nothing for the surfaces that are smoothed."""

    varied: str = ""
    reduced_pressure: float
    magnification: float


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Solve every surface at every load and magnification on every grid.

    A_pl/A0 and A_el/A0 (case, surface, grid), their limits linear in dx and means, and the theory with the gradient
    of the same surfaces; share of C(q) (surface, wave) that the smoothed surfaces keep, and Persson's.
    """
    smoothing, whole = options.smoothing_reduced_pressure, options.bandwidth
    cases = [
        *(Case(varied="load", reduced_pressure=p, magnification=whole) for p in options.reduced_pressures),
        *(Case(varied="waves", reduced_pressure=smoothing, magnification=z) for z in options.magnifications),
        Case(reduced_pressure=smoothing, magnification=whole),
    ]
    surfaces = range(options.surfaces)
    how: dict[str, Any] = {"settings": (("tolerance", 1e-8),), "effects": (Hardness(hardness=options.limit),)}
    solves: dict[tuple[Case, int], tuple[Press, ...]] = {}
    for k in surfaces:
        unit = base_case(options.self_affine(number=k, length=_LENGTH), pressure=1.0).pressure_scale
        for case in cases:
            surface = options.self_affine(number=k, until=case.magnification, length=_LENGTH)
            problem = base_case(surface, pressure=case.reduced_pressure * unit)
            solves[case, k] = tuple(
                Press(method="bem", grid=(n, n), problem=problem, **how)
                for n in (options.ladder if case.varied else [max(options.ladder)])
            )
    solved = bench.solve(itertools.chain(*solves.values()))
    smoothed = {k: _smoothed(solves.pop((cases[-1], k))[0], options, solved) for k in surfaces}
    data = gather({at: _areas(several, solved) for at, several in solves.items()}, "case", "surface")
    data = data.merge(gather(smoothed, "surface").rename(solve="solve_smoothed"))
    data = derive(
        straight_limit(data, *_AREAS),
        area_plastic_excess_each="area_plastic_each / area_plastic_persson_each - 1",
        area_elastic_excess_each="area_elastic_each / area_elastic_persson_each - 1",
        spectrum_kept_excess_each="spectrum_kept_each - spectrum_kept_persson_each",
    )
    names = [f"{area}{of}" for area in _AREAS for of in ("", "_pixel", "_persson", "_excess")]
    names += ["spectrum_kept", "spectrum_kept_persson", "spectrum_kept_excess", "gradient_kept"]
    data = derive(mean(data, *names), spectrum_kept_excess_largest="abs(spectrum_kept_excess).max('wave')")
    data = claim(data, *_AREAS, "spectrum_kept", "gradient_kept", **ABSENT)
    asked = options.model_dump(include={"hardness", "smoothing_reduced_pressure"})
    return data.assign_attrs(methods="theory bem", **asked)


_AREAS = ("area_plastic", "area_elastic")


def _areas(solves: tuple[Press, ...], solved: Solves) -> xr.Dataset:
    yields = [yielded(solved[solve].checked()) for solve in solves]
    theory = predict(solves[0].problem, solves[0].effects)
    assert theory.plastic is not None
    return xr.Dataset(
        {
            "area_plastic_pixel_each": ("grid", [result.plastic_area for result in yields]),
            "area_elastic_pixel_each": ("grid", [result.elastic_area for result in yields]),
            "area_plastic_persson_each": theory.plastic,
            "area_elastic_persson_each": theory.area - theory.plastic,
            "solve": ("grid", [solve.key for solve in solves]),
        },
        coords={"points": ("grid", [solve.grid[0] for solve in solves])},
    )


def _smoothed(solve: Press, options: Options, solved: Solves) -> xr.Dataset:
    problem = solve.problem
    q, shares, gradient = remaining_waves(solved[solve].checked(), problem)
    return xr.Dataset(
        {
            "spectrum_kept_each": ("wave", shares),
            "spectrum_kept_persson_each": ("wave", remaining_by_theory(problem, options.limit, q)),
            "gradient_kept_each": gradient,
        },
        coords={"wave": q / problem.spectrum_shape.q_long},
        attrs={"solve": solve.key},
    )


def views(data: xr.Dataset) -> Views:
    """Plastic and elastic area against load and magnification, and the spectrum that is left."""
    finest = {"grid": data.sizes["grid"] - 1}
    shown = [
        column
        for name in _AREAS
        for column in (name, Column(f"{name}_pixel", finest), f"{name}_persson", f"{name}_excess")
    ]
    return Views(
        table=Table(("case",), ("varied", "reduced_pressure", "magnification", *shown)),
        budget=_AREAS,
        figures=[
            *(_figure(name, finest) for name in _AREAS),
            Figure(
                "smoothed-spectrum",
                "Spectrum of the surface left after yielding and unloading, over that before, and Persson's formula, "
                "which smooths the whole surface (2006, Sec. 10.2).",
                [against("wave", "spectrum_kept", "spectrum_kept_persson", log="x")],
            ),
        ],
        findings=[
            *(_finding(data, name, varied) for varied in ("load", "waves") for name in _AREAS),
            finding(
                "comparison",
                "Smoothed at p* = {smoothing_reduced_pressure}, the surface keeps {spectrum_kept} of C(q) at q = {wave} q_long, {verdict} the "
                "{spectrum_kept_persson:~} of Persson's formula (largest difference {spectrum_kept_excess_largest:~}): it "
                "smooths the whole surface, boundary elements only what has yielded, where {gradient_kept} of the squared "
                "gradient is left.",
                data.isel(wave=-1),
                by="spectrum_kept_excess",
            ),
            *of_one_surface(data),
        ],
    )


def _figure(name: str, finest: dict[str, int]) -> Figure:
    panels = [
        against(
            x,
            Line(name, where={"varied": varied}, label="limit over grids"),
            Line(f"{name}_pixel", where={"varied": varied}, at=finest, label="finest grid"),
            Line(f"{name}_persson", where={"varied": varied}),
            log="x",
            bottom=0.0,
        )
        for varied, x in (("load", "reduced_pressure"), ("waves", "magnification"))
    ]
    part = name.removeprefix("area_")
    state = "yielded" if part == "plastic" else "elastic contact"
    caption = f"Share of the nominal area that is {state} against load (left) and as waves are added (right)."
    return Figure(f"{part}-area", caption, panels)


def _finding(data: xr.Dataset, name: str, varied: str) -> Finding:
    here = data.isel(case=(data.varied == varied).values)
    at = "p* = {reduced_pressure}" + ("" if varied == "load" else ", zeta = {magnification}")
    return finding(
        "comparison",
        f"H = {{hardness}} E* h'_rms: A_{name[5:7]}/A0 is {{each}}.",
        here.isel(case=spread(here, "case", 2)),
        item=f"{{{name}}} at {at}, {{verdict}} Persson's {{{name}_persson}}, {{{name}_excess:+%}} away",
        by=f"{name}_excess",
    )
