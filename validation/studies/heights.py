"""Are the heights of a rough surface Gaussian, and does their spread decide the contact?

Surfaces with a roll-off, as roads have one (Persson 2006, Sec. 2.1): the distribution of heights P_h against the Gaussian for
samples of rising size; and two spectra that differ in their long waves alone, pressed with the same load.
"""

import math
from typing import Any, Self

import numpy as np
import xarray as xr
from pydantic import Field, model_validator
from scipy.special import ndtr

from persson.heights import height_distribution
from validation.arrays import Grid
from validation.measurements.common import Rising, base_case
from validation.measurements.flow import located_area
from validation.measurements.measurement import elastic_path, grid_for
from validation.report.estimates import claim, derive, mean
from validation.report.places import gather, spread
from validation.report.views import Figure, Findings, Level, Line, Table, Views, against, finding
from validation.scenes.problem import ContactProblem
from validation.scenes.surfaces import spectrum_of
from validation.studies._options import Bandwidth, SurfaceOptions, Surfaces
from validation.studies._study import ABSENT, Bench, Call, measurement, solved, stored_variables
from validation.units import wrong

#: Edges of the bins of h/h_rms.
HEIGHT_EDGES = np.linspace(-4.0, 4.0, 65)


@measurement(
    "heights-{size}",
    kind="HeightStatistics",
    words="heights",
    located=True,
    version=2,
    left_out=("load",),
    seconds=lambda points, pressures: 1e-2 + len(pressures) * (2e-3 + 8e-7 * points),
    bytes=200,
)
def height_statistics(
    *, problem: ContactProblem, grid: Grid, pressures: tuple[float, ...] = ()
) -> xr.Dataset:
    """Return how the heights of one surface are distributed, over the realised rms height, and its contact area.

    `pressures` are rising p0 [Pa]; none for the heights alone.
    """
    field = problem.heights(grid)
    areas = [located_area(solved) for solved in elastic_path(field, problem.elastic, pressures)]
    z = np.sort(field.heights.ravel() / problem.field.rms_height)
    share = (np.arange(z.size) + 0.5) / z.size
    density = np.histogram(z, bins=HEIGHT_EDGES)[0] / (z.size * np.diff(HEIGHT_EDGES))
    return xr.Dataset(
        {
            "height_density_each": ("bin", density),
            "area_each": ("load", areas),
            "skewness_each": float(np.mean(z**3)),
            "excess_kurtosis_each": float(np.mean(z**4) - 3),
            "height_distance_each": float(np.max(np.abs(ndtr(z) - share))),
            "highest_each": float(z[-1]),
            "rms_height_each": problem.field.rms_height,
            "rms_gradient_each": problem.field.rms_gradient,
        }
    )


class Options(SurfaceOptions):
    """Which surfaces, and how they are pressed."""

    why_no_scene = "it asks about spectra with a roll-off, and makes a surface for each"

    periods: Rising = (1.0, 2.0, 4.0, 8.0)
    """L / lambda_0: sizes of the sample, rising"""
    longer: float = Field(default=2.0, gt=1)
    """roll-off wavelength of the second spectrum over that of the first"""
    reduced_pressures: Rising = (0.02, 0.05, 0.1, 0.2)
    """p* on the first spectrum, rising"""
    bandwidth: Bandwidth = 8.0
    surfaces: Surfaces = 16
    points_per_wave: float = Field(default=4.0, ge=2)
    """grid, as lambda_short/dx"""

    @model_validator(mode="after")
    def _waves_fit(self) -> Self:
        if self.periods[-1] < self.longer:
            raise wrong(
                f"periods = {self.periods[-1]:g}, the last: must be at least longer = {self.longer:g}"
            )
        return self

    def first(self, periods: float) -> ContactProblem:
        """Return the first surface of one size."""
        surface = self.self_affine(periods=periods).model_copy(update={"rolloff": "smooth"})
        return base_case(surface, reduced_pressure=self.reduced_pressures[0])

    def second(self) -> ContactProblem:
        """Return that of the second spectrum: a longer roll-off, and the same C(q) at the shortest waves."""
        surface: Any = self.first(self.periods[-1]).surface
        longer = surface.model_copy(update={"lambda_long": surface.lambda_long * self.longer})
        q = 2 * math.pi / surface.lambda_short
        share = float(spectrum_of(surface)(q) / spectrum_of(longer)(q))
        scaled = longer.model_copy(update={"rms_gradient": surface.rms_gradient * math.sqrt(share)})
        return base_case(scaled, reduced_pressure=self.reduced_pressures[0])


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Read off the heights of every sample, and press the largest ones beside those with longer waves.

    Density of heights and what deviates from the Gaussian over (sample, surface); area over (spectrum, surface,
    load) of the two spectra at the same p0, and Persson's told each gradient.
    """
    middles = (HEIGHT_EDGES[1:] + HEIGHT_EDGES[:-1]) / 2
    measured = solved(bench, _cases(options))
    samples, spectra = (
        gather({at[1:]: stored_variables(d) for at, d in measured.items() if at[0] == dim}, dim, "surface")
        for dim in ("sample", "spectrum")
    )
    pressed = ["area_each", "rms_height_each", "rms_gradient_each"]
    spectra = spectra[[*pressed, "solve"]].rename(solve="solve_spectra")
    data = (
        samples.drop_vars([*pressed, "sample"])
        .merge(spectra)
        .assign_coords(
            periods=("sample", list(options.periods)),
            height=("bin", middles),
            reduced_pressure=("load", list(options.reduced_pressures)),
        )
    )
    data["height_density_gaussian"] = ("bin", height_distribution(middles, rms_height=1.0))
    # p0 is that of the first spectrum's own surface: p* of the other is less by the ratio of gradients.
    first, change = "rms_gradient_each.isel(spectrum=0)", "{0}.isel(spectrum=1) / {0}.isel(spectrum=0) - 1"
    changes = {
        "area": "area_change",
        "area_persson": "area_change_persson",
        "rms_height": "rms_height_change",
        "rms_gradient": "rms_gradient_change",
    }
    data = derive(
        data,
        area_persson_each=f"erf(2**.5 * reduced_pressure * {first} / rms_gradient_each)",
        **{f"{of}_each": change.format(f"{name}_each") for name, of in changes.items()},
    )
    data = mean(data, "height_density", *_DEVIATIONS, *changes, *changes.values())
    data = derive(data, area_change_share="2 * area_change / rms_height_change")
    absent = {"solver": "nothing is solved", "depth": "nothing is pressed", "theory": "it is measured"}
    data = claim(claim(data, *_DEVIATIONS, **absent), "area_change", **ABSENT)
    return data.assign_attrs(methods="theory bem", longer=options.longer)


_SPECTRA = ("shorter roll-off", "longer roll-off")
_DEVIATIONS = ("skewness", "excess_kurtosis", "height_distance", "highest")


def _cases(options: Options) -> dict[tuple[str, float | str, int], Call]:
    cases: dict[tuple[str, float | str, int], Call] = {}
    for periods in options.periods:
        first = options.first(periods)
        grid = grid_for(first, options.points_per_wave)
        for k in range(options.surfaces):
            cases["sample", periods, k] = height_statistics(problem=first.further(k), grid=grid)
    pair = (options.first(options.periods[-1]), options.second())
    grid = grid_for(pair[0], options.points_per_wave)
    for k in range(options.surfaces):
        scale = pair[0].further(k).pressure_scale
        loads = tuple(float(load * scale) for load in options.reduced_pressures)
        for name, spectrum in zip(_SPECTRA, pair, strict=True):
            case = height_statistics(problem=spectrum.further(k), grid=grid, pressures=loads)
            cases["spectrum", name, k] = case
    return cases


def views(data: xr.Dataset) -> Views:
    """P_h of samples beside the Gaussian; what a longer roll-off changes of area and rms height."""
    ends = {"sample": spread(data, "sample", 2)}
    densities = [Line("height_density", by="sample", at=ends), Line("height_density_gaussian")]
    changes = [
        Line("area_change", label="contact area"),
        Line("area_change_persson", label="contact area, Persson"),
        Level("rms_height_change", label="h_rms", look={"color": "black", "ls": ":"}),
    ]
    return Views(
        table=Table(("sample",), ("periods", *_DEVIATIONS)),
        budget=(*_DEVIATIONS, "area_change"),
        figures=[
            Figure(
                "heights",
                "Distribution of heights of the smallest and the largest sample, and what a longer roll-off "
                "changes of the contact area under the same load, beside what it changes of the rms height.",
                [
                    against("height", *densities, log="y", bottom=1e-4, top=1.0),
                    against("reduced_pressure", *changes, log="x"),
                ],
            )
        ],
        findings=[*_findings(data)],
    )


def _findings(data: xr.Dataset) -> Findings:
    for name, quantity in (("skewness", "Skewness"), ("excess_kurtosis", "Excess kurtosis")):
        item = f"{{{name}}} at {{periods}}, {{verdict}} zero"
        yield finding(
            "comparison", quantity + " of the heights by L/lambda_0: {each}.", data, item=item, by=name
        )
    form = "Largest distance of the cumulated heights of one surface from the Gaussian, and its highest point over "
    form += "h_rms: {each}."
    yield finding("value", form, data, item="{height_distance} and {highest} at L/lambda_0 = {periods}")
    yield finding(
        "equivalence",
        "With a roll-off {longer} times as long and the same C(q) at short waves, h_rms changes by "
        "{rms_height_change:+%} and the gradient by {rms_gradient_change:+%}. Under the same load the area changes "
        "by {each}.",
        data,
        item="{area_change:+%} at p* = {reduced_pressure} (theory {area_change_persson:+%}), {verdict}",
        by="area_change_share",
        words={
            "within": "less than half as much as the heights",
            "beyond": "more than half as much as the heights",
            "undecided": "less than half as much as the heights or not: not decided",
        },
    )
