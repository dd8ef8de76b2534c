"""Are the heights of a rough surface Gaussian, and does their spread decide the contact?

Surfaces with a roll-off, as roads have one (Persson 2006, Sec. 2.1): the distribution of heights P_h against the Gaussian for
samples of rising size; and two spectra that differ in their long waves alone, pressed with the same load.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field
from scipy.special import ndtr

from fem_contact import bem
from persson.heights import height_distribution
from validation.arrays import Array
from validation.measures.common import (
    Rising,
    base_case,
    base_surface,
    draw_means,
    means_of,
    named,
    over_surfaces,
    persson_area,
    results_of,
)
from validation.measures.flow import located_area
from validation.measures.measurement import grid_for
from validation.measures.single_solve import SingleSolve, Takes
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.realised import Realised
from validation.scenes.surfaces import spectrum_of
from validation.solves.bench import Bench
from validation.studies._options import Bandwidth, Hurst, Seed, Surfaces
from validation.studies._study import StudyOptions

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["HeightStatistics", "Options", "figures", "findings", "run", "table"]

#: Edges of the bins of h/h_rms.
_EDGES = np.linspace(-4.0, 4.0, 65)
_WORDS = {
    "skewness": "<h^3> / h_rms^3",
    "excess": "<h^4> / h_rms^4 - 3",
    "distance": "largest distance of the cumulated heights from the Gaussian",
    "highest": "highest point / h_rms",
}


class Options(StudyOptions):
    """Which surfaces, and how they are pressed."""

    own = "it asks about spectra with a roll-off, and makes a surface for each"

    periods: Rising = Field(
        default=(1.0, 2.0, 4.0, 8.0), description="L / lambda_0: sizes of the sample, rising"
    )
    longer: float = Field(
        default=2.0, gt=1, description="roll-off wavelength of the second spectrum over that of the first"
    )
    reduced_pressures: Rising = Field(
        default=(0.02, 0.05, 0.1, 0.2), description="p* on the first spectrum, rising"
    )
    hurst: Hurst = 0.8
    bandwidth: Bandwidth = 8.0
    surfaces: Surfaces = 16
    points_per_wave: float = Field(default=4.0, ge=2, description="grid, as lambda_short/dx")
    seed: Seed = 2006

    def first(self, periods: float) -> Realised:
        """Return the first surface of one size."""
        sharp = base_surface(hurst=self.hurst, periods=periods, bandwidth=self.bandwidth, seed=self.seed)
        surface = sharp.model_copy(update={"rolloff": "smooth"})
        return base_case(surface, reduced_pressure=self.reduced_pressures[0])

    def second(self) -> Realised:
        """Return that of the second spectrum: a longer roll-off, and the same C(q) at the shortest waves."""
        first = self.first(self.periods[-1])
        surface: Any = first.surface
        longer = surface.model_copy(update={"lambda_long": surface.lambda_long * self.longer})
        q = 2 * math.pi / surface.lambda_short
        share = float(spectrum_of(surface)(q) / spectrum_of(longer)(q))
        scaled = longer.model_copy(update={"rms_gradient": surface.rms_gradient * math.sqrt(share)})
        return base_case(scaled, reduced_pressure=self.reduced_pressures[0])


@dataclass(frozen=True, kw_only=True)
class HeightStatistics(SingleSolve):
    """Heights of one surface, and its contact area under given loads.

    Attributes
    ----------
    realised : Realised
        Surface and solid.
    grid : tuple of int
    pressures : tuple of float
        p0 [Pa], rising; none for the heights alone.
    """

    kind, words = "heights", "heights"
    located, version = True, 1
    takes = Takes(once=1e-2, seconds=2e-3, each_point=8e-7, bytes=200)

    pressures: tuple[float, ...] = ()

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers; the loads are its own."""
        return {name: value for name, value in super().recipe.items() if name != "load"}

    @property
    def problems(self) -> int:
        """One for each load."""
        return len(self.pressures)

    def measure(self) -> xr.Dataset:
        """Read off the heights, and press; dimensions (bin) and (load)."""
        import xarray as xr

        field, start, areas = self.heights(), None, []
        for pressure in self.pressures:
            solved = bem.solve(
                field, self.half_space, mean_pressure=pressure, start=start, threads=1
            ).checked()
            start = solved.pressure
            areas.append(located_area(solved))
        z = np.sort(field.heights.ravel() / self.realised.field.rms_height)
        share = (np.arange(z.size) + 0.5) / z.size
        density = np.histogram(z, bins=_EDGES)[0] / (z.size * np.diff(_EDGES))
        return xr.Dataset(
            {
                "density": ("bin", density),
                "area": ("load", areas),
                "skewness": float(np.mean(z**3)),
                "excess": float(np.mean(z**4) - 3),
                "distance": float(np.max(np.abs(ndtr(z) - share))),
                "highest": float(z[-1]),
                "rms_height": self.realised.field.rms_height,
                "rms_gradient": self.realised.field.rms_gradient,
            }
        )


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Read off the heights of every sample, and press the largest ones beside those with longer waves.

    Returns
    -------
    xarray.Dataset
        P_h h_rms as `density` and what deviates from the Gaussian over (sample, surface); `area` over (spectrum, surface,
        load) of the two spectra at the same p0, the `theory` told each gradient, and both moments.
    """
    import xarray as xr

    cases = _cases(options)
    found = results_of(bench, cases)
    sizes, rows = range(len(options.periods)), range(options.surfaces)

    def over(name: str) -> Array:
        return np.array([[found["size", i, k][name].values for k in rows] for i in sizes])

    pair = [[found["spectrum", s, k] for k in rows] for s in range(2)]
    moments = {
        name: (("spectrum", "surface"), [[float(one[name]) for one in row] for row in pair])
        for name in ("rms_height", "rms_gradient")
    }
    loads = np.array(options.reduced_pressures)
    # p0 is that of the first spectrum's own surface: p* of the other is less by the ratio of gradients.
    gradients = np.array(moments["rms_gradient"][1])
    theory = persson_area(loads * (gradients[0] / gradients)[..., None])
    return xr.Dataset(
        {
            "density": named(("sample", "surface", "bin"), over("density"), "P_h h_rms"),
            **{name: named(("sample", "surface"), over(name), _WORDS[name]) for name in _WORDS},
            "area": named(
                ("spectrum", "surface", "load"),
                [[one.area.values for one in row] for row in pair],
                "A/A0, located",
            ),
            "theory": named(("spectrum", "surface", "load"), theory, "A/A0, Persson"),
            **moments,
        },
        coords={
            "periods": named("sample", list(options.periods), "L / lambda_0"),
            "height": named("bin", (_EDGES[1:] + _EDGES[:-1]) / 2, "h / h_rms"),
            "reduced_pressure": named("load", loads, "p* on the first spectrum"),
        },
        attrs={"study": "heights", "methods": "theory bem", "longer": options.longer},
    )


def _cases(options: Options) -> dict[tuple[str, int, int], HeightStatistics]:
    """List the samples of rising size, and the pairs of surfaces that are pressed, each pair with common phases."""
    found = {}
    for i, periods in enumerate(options.periods):
        first = options.first(periods)
        grid = grid_for(first, options.points_per_wave)
        for k in range(options.surfaces):
            found["size", i, k] = HeightStatistics(realised=first.further(k), grid=grid)
    pair = (options.first(options.periods[-1]), options.second())
    grid = grid_for(pair[0], options.points_per_wave)
    for k in range(options.surfaces):
        scale = pair[0].further(k).pressure_scale
        pressures = tuple(float(load * scale) for load in options.reduced_pressures)
        for s, realised in enumerate(pair):
            found["spectrum", s, k] = HeightStatistics(
                realised=realised.further(k), grid=grid, pressures=pressures
            )
    return found


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each size of sample."""
    rows = []
    for i, periods in enumerate(dataset.periods.values):
        each = [over_surfaces(dataset[name][i]) for name in _WORDS]
        rows.append((float(periods), *itertools.chain.from_iterable((e.value, e.half_width) for e in each)))
    return ResultTable.of(
        ("L/lambda_0", *itertools.chain.from_iterable((words, "+- (95 %)") for words in _WORDS.values())),
        rows,
    )


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Say how Gaussian the heights are, and what the longer waves change."""
    sentences = []
    for i, periods in enumerate(dataset.periods.values):
        skew, excess, distance, highest = (over_surfaces(dataset[name][i]) for name in _WORDS)
        told = [
            f"{name} {one}{' (not told from zero)' if abs(one.value) <= one.half_width else ''}"
            for name, one in (("skewness", skew), ("excess kurtosis", excess))
        ]
        sentences.append(
            f"L/lambda_0 = {periods:g}: {', '.join(told)}; the cumulated heights of one surface lie {distance} from the Gaussian at most, "
            f"its highest point at {highest} h_rms (95 % over {skew.samples} surfaces)."
        )
    height, gradient = (
        over_surfaces(dataset[name][1] / dataset[name][0]) for name in ("rms_height", "rms_gradient")
    )
    areas = [
        over_surfaces(dataset.area[1, :, j] / dataset.area[0, :, j]) for j in range(dataset.sizes["load"])
    ]
    theory = (dataset.theory[1] / dataset.theory[0]).mean("surface").values
    listed = ", ".join(
        f"{100 * (a.value - 1):+.1f} +- {100 * a.half_width:.1f} % at p* = {p:g} (theory {100 * (t - 1):+.1f} %)"
        for a, t, p in zip(areas, theory, dataset.reduced_pressure.values, strict=True)
    )
    sentences.append(
        f"With a roll-off {float(dataset.attrs['longer']):g} times as long and the same C(q) at short waves h_rms is {height} times as large and the gradient {gradient} times; "
        f"under the same load the contact area changes by {listed}: it follows the gradient, not the heights."
        if max(abs(a.value - 1) + a.half_width for a in areas) < abs(height.value - 1) / 2
        else f"With a roll-off {float(dataset.attrs['longer']):g} times as long h_rms is {height} times as large, the gradient {gradient} times, "
        f"and under the same load the contact area changes by {listed}."
    )
    return tuple(sentences)


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw P_h, and the areas of both spectra."""
    return (
        Drawing(
            name="heights",
            figure=_figure(dataset),
            data=dataset,
            caption="Left: distribution of heights, mean over the surfaces and the scatter of one (standard deviation), for the smallest and the largest sample, beside the "
            "Gaussian. Right: contact area under the same load with a longer roll-off over that without, beside the ratio of rms heights and Persson's theory.",
        ),
    )


def _figure(dataset: xr.Dataset) -> Figure:
    from validation.report.figure import COLOURS, THEORY, look, new_figure

    figure, (left, right) = new_figure(width=9.0, columns=2)
    z = dataset.height.values
    for n, i in enumerate(dict.fromkeys((0, dataset.sizes["sample"] - 1))):
        mean, spread = dataset.density[i].mean("surface"), dataset.density[i].std("surface", ddof=1)
        left.fill_between(
            z, np.maximum(mean - spread, 1e-6), mean + spread, color=COLOURS[n], alpha=0.25, lw=0
        )
        left.plot(z, mean, color=COLOURS[n], lw=1.2, label=rf"$L/\lambda_0$ = {float(dataset.periods[i]):g}")
    left.plot(z, height_distribution(z, rms_height=1.0), color="black", lw=0.9, ls="--", label="Gaussian")
    left.set_yscale("log")
    left.set_ylim(1e-4, 1)
    left.set_xlabel(r"$h / h_\mathrm{rms}$")
    left.set_ylabel(r"$P_h\, h_\mathrm{rms}$")
    ratio = dataset.area[1] / dataset.area[0]
    loads = dataset.reduced_pressure.values
    draw_means(right, loads, means_of(ratio), label="contact area", **look(0))
    right.plot(loads, (dataset.theory[1] / dataset.theory[0]).mean("surface"), label="Persson", **THEORY)
    height = float((dataset.rms_height[1] / dataset.rms_height[0]).mean())
    right.axhline(height, color="black", lw=0.9, ls=":", label=r"$h_\mathrm{rms}$")
    right.set_xscale("log")
    right.set_xlabel(r"$p_0 / (E^* h'_\mathrm{rms})$ on the first spectrum")
    right.set_ylabel("longer roll-off / shorter")
    for axes in (left, right):
        axes.legend(fontsize=7)
    return figure
