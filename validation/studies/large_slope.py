"""Up to which slope does the linear theory of contact hold?

The same surface is made steeper at one reduced load p* = p0/(E* h'_rms), so that linear elasticity says the same of all
of them; a neo-Hookean block of finite strain, met by the rough surface where its nodes are, says what is left out.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import Field

from validation.arrays import Array
from validation.measures.common import (
    BASE_SOLID,
    Rising,
    base_case,
    base_surface,
    named,
    over_surfaces,
    results_of,
)
from validation.measures.measurement import grid_for
from validation.measures.slopes import SlopeMeasurement
from validation.measures.statistics import Estimate, mean_over_surfaces
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.scenes.scene import SolidSpec
from validation.solves.bench import Bench
from validation.studies._options import Bandwidth, Hurst, Periods, Seed, Surfaces
from validation.studies._study import StudyOptions

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["Options", "figures", "findings", "run", "table"]

#: What is compared with the linear block, and how sentences call it.
_RATIOS = {
    "projected_area": ("A", "contact area projected on the plane"),
    "square_pressure": ("<p^2>", "mean square pressure"),
}
#: Relative differences whose slopes are looked for, and the slope up to which differences count as going with it.
_DIFFERENCES, _STRAIGHT = (0.01, 0.05), 0.4


class Options(StudyOptions):
    """Surfaces of few waves on fine grids: steep tips of less than some ten points cannot be followed."""

    own = "it makes surfaces steeper at one reduced load"

    slopes: Rising = Field(
        default=(0.05, 0.1, 0.2, 0.4, 0.7), min_length=2, description="h'_rms of the surfaces, rising"
    )
    reduced_pressures: Rising = Field(
        default=(0.05, 0.2), description="p* = p0 / (E* h'_rms) with the realised gradient of each surface"
    )
    poissons: tuple[Annotated[float, Field(ge=0, lt=0.5)], ...] = Field(
        default=(0.3, 0.49), min_length=1, description="Poisson ratios at small strain"
    )
    hurst: Hurst = 0.8
    periods: Periods = 1.0
    bandwidth: Bandwidth = 2.0
    surfaces: Surfaces = 4
    points_per_wave: Rising = Field(
        default=(12.0, 16.0),
        min_length=2,
        description="grids, as lambda_short/dx; the finest gives the value, its distance to the one before the uncertainty",
    )
    seed: Seed = 2006


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Make every surface steeper, at every load and Poisson ratio, on every grid.

    Returns
    -------
    xarray.Dataset
        `projected_area`, `true_area`, `material_area` and `square_pressure` over those of the linear block less 1, on the dimensions
        (poisson, load, surface, grid, slope); NaN where Newton's method found no equilibrium, `ended` counts such paths.
    """
    import xarray as xr

    cases = dict(_cases(options))
    found = results_of(bench, cases)
    shape = (
        len(options.poissons),
        len(options.reduced_pressures),
        options.surfaces,
        len(options.points_per_wave),
    )
    names = ("projected_area", "true_area", "material_area", "square_pressure")
    values = {name: np.empty((*shape, len(options.slopes))) for name in names}
    residual, ended, linear = (
        np.empty((*shape, len(options.slopes))),
        np.empty(shape, dtype=int),
        np.empty(shape),
    )
    for at, data in found.items():
        for name in names:
            scale = data.linear_square_pressure if name == "square_pressure" else data.linear_area
            measured = data["area" if name == "projected_area" else name]
            values[name][at] = measured.values / float(scale) - 1
        residual[at], linear[at] = data.residual.values, float(data.linear_area)
        ended[at] = bool(data.attrs["ended"])
    path = ("nu", "load", "surface", "grid")
    return xr.Dataset(
        {
            name: named((*path, "slope"), values[name], f"{name} over that of the linear block, less 1")
            for name in names
        }
        | {
            "residual": named((*path, "slope"), residual, "unbalanced over contact forces"),
            "linear_area": named(path, linear, "A/A0 of the linear block, nodes counted"),
            "ended": named(path, ended, "whether the path ends before the steepest slope"),
        },
        coords={
            "poisson": ("nu", list(options.poissons)),
            "reduced_pressure": named("load", list(options.reduced_pressures), "p0 / (E* h'_rms)"),
            "points_per_wave": ("grid", list(options.points_per_wave)),
            "slope": named("slope", list(options.slopes), "h'_rms"),
        },
        attrs={
            "study": "large-slope",
            "methods": "fem",
            "hurst": options.hurst,
            "bandwidth": options.bandwidth,
        },
    )


def _cases(options: Options) -> Iterator[tuple[tuple[int, int, int, int], SlopeMeasurement]]:
    """Yield one path for each Poisson ratio, load, surface and grid."""
    surface = base_surface(
        hurst=options.hurst, periods=options.periods, bandwidth=options.bandwidth, seed=options.seed
    )
    for (i, poisson), (j, load) in itertools.product(
        enumerate(options.poissons), enumerate(options.reduced_pressures)
    ):
        solid = SolidSpec(young=BASE_SOLID.young, poisson=poisson)
        base = base_case(surface, reduced_pressure=load, solid=solid)
        for k, (g, points) in itertools.product(range(options.surfaces), enumerate(options.points_per_wave)):
            yield (
                (i, j, k, g),
                SlopeMeasurement(
                    realised=base.further(k),
                    grid=grid_for(base, points),
                    slopes=options.slopes,
                    depth=1 / options.periods,
                ),
            )


def _curve(dataset: xr.Dataset, name: str, i: int, j: int) -> tuple[Array, Array, Array]:
    """Mean over the surfaces on the finest grid, half of its 95 % interval, and the grid's share, by slope."""
    part = dataset[name][i, j]
    means = [over_surfaces(part[:, -1, s]) for s in range(dataset.sizes["slope"])]
    grid = np.abs((part[:, -1] - part[:, -2]).mean("surface", skipna=False).values)
    return np.array([m.value for m in means]), np.array([m.half_width for m in means]), grid


def _rate(dataset: xr.Dataset, name: str, i: int, j: int) -> tuple[Estimate, float]:
    """Difference per slope by a line through 0 over the small slopes, mean over the surfaces; and the grid's share."""
    small = dataset[name][i, j].sel(slope=slice(0, _STRAIGHT)).values
    slopes = dataset.slope.values[: small.shape[-1]]
    rates = small @ slopes / np.sum(slopes**2)
    return mean_over_surfaces(rates[:, -1]), float(np.abs(np.mean(rates[:, -1] - rates[:, -2])))


def _crossing(slopes: Array, change: Array, difference: float) -> float:
    """Return where a change first exceeds a difference, between slopes and from 0 on in a straight line; inf if nowhere."""
    x, y = np.append(0.0, slopes), np.append(0.0, change)
    kept = np.isfinite(y)
    x, y = x[kept], y[kept]
    beyond = np.flatnonzero(y > difference)
    if not beyond.size:
        return float("inf")
    k = int(beyond[0])
    return float(x[k - 1] + (difference - y[k - 1]) / (y[k] - y[k - 1]) * (x[k] - x[k - 1]))


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each Poisson ratio, load and slope."""
    rows = []
    for i, j in itertools.product(range(dataset.sizes["nu"]), range(dataset.sizes["load"])):
        curves = {name: _curve(dataset, name, i, j) for name in (*_RATIOS, "true_area")}
        for s, slope in enumerate(dataset.slope.values):
            numbers = [100 * float(part[s]) for name in _RATIOS for part in curves[name]]
            rows.append(
                (
                    float(dataset.poisson[i]),
                    float(dataset.reduced_pressure[j]),
                    float(slope),
                    *numbers,
                    100 * float(curves["true_area"][0][s]),
                )
            )
    columns = ["nu", "p*", "h'_rms"]
    for symbol, _ in _RATIOS.values():
        columns += [f"{symbol}/linear - 1 [%]", "+- surfaces (95 %)", "+- grid"]
    return ResultTable.of((*columns, "A along the rough surface/linear - 1 [%]"), rows)


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Say from which slope on area and pressure leave the linear result, and where no equilibrium was found."""
    sentences = []
    for i, j in itertools.product(range(dataset.sizes["nu"]), range(dataset.sizes["load"])):
        where = f"nu = {float(dataset.poisson[i]):g}, p* = {float(dataset.reduced_pressure[j]):g}"
        for name, (_, words) in _RATIOS.items():
            said = " and ".join(_slope_words(dataset, _curve(dataset, name, i, j), d) for d in _DIFFERENCES)
            rate, grid = _rate(dataset, name, i, j)
            sure = float(np.hypot(rate.half_width, grid))
            sentences.append(
                f"{where}: the {words} differs from the linear one by {said}; up to h'_rms = {_STRAIGHT:g} by the part "
                f"{rate.value:.2g} +- {sure:.1g} times h'_rms."
            )
    ended, paths = int(dataset.ended[..., -1].sum()), int(dataset.ended[..., -1].size)
    if ended:
        sentences.append(
            f"{ended} of {paths} paths on the finest grid end before h'_rms = {float(dataset.slope[-1]):g}: no equilibrium "
            "was found beyond, and their slopes are left out for all surfaces."
        )
    return tuple(sentences)


def _slope_words(dataset: xr.Dataset, curve: tuple[Array, Array, Array], difference: float) -> str:
    """Where |mean| exceeds a difference, and where it does at either end of its interval."""
    mean, scatter, grid = curve
    slopes, sure = dataset.slope.values, np.hypot(scatter, grid)
    at, low, high = (
        _crossing(slopes, change, difference)
        for change in (np.abs(mean), np.abs(mean) + sure, np.abs(mean) - sure)
    )
    reached = slopes[np.isfinite(mean)]
    top = float(reached[-1]) if reached.size else 0.0
    if not np.isfinite(at):
        return f"{100 * difference:g} % nowhere up to h'_rms = {top:g}"
    upper = f"to {high:.2g}" if np.isfinite(high) else f"to beyond {top:g}"
    return f"{100 * difference:g} % from h'_rms = {at:.2g} on ({low:.2g} {upper}, 95 % over surfaces, and the grid)"


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw both differences over the slope."""
    return (
        Drawing(
            name="large-slope",
            figure=_figure(dataset),
            data=dataset,
            caption="Contact area, projected on the plane (left), and mean square pressure (right) of a neo-Hookean block over those "
            "of the linear block at the same reduced load, over the slope of the surface: mean and 95 % over the surfaces on the "
            "finest grid; small and open, the coarser one. Straight lines through 0 are effects of first order in the slope.",
        ),
    )


def _figure(dataset: xr.Dataset) -> Figure:
    from validation.report.figure import look, new_figure

    figure, panels = new_figure(width=9.0, columns=2)
    slopes = dataset.slope.values
    for axes, (name, (symbol, _)) in zip(panels, _RATIOS.items(), strict=True):
        pairs = itertools.product(range(dataset.sizes["nu"]), range(dataset.sizes["load"]))
        for k, (i, j) in enumerate(pairs):
            mean, scatter, _ = _curve(dataset, name, i, j)
            style = look(k)
            label = rf"$\nu$ = {float(dataset.poisson[i]):g}, $p^*$ = {float(dataset.reduced_pressure[j]):g}"
            axes.errorbar(slopes, 100 * mean, yerr=100 * scatter, label=label, **style)
            coarse = dataset[name][i, j, :, -2].mean("surface", skipna=False).values
            axes.plot(
                slopes, 100 * coarse, ls="", ms=3, marker=style["marker"], color=style["color"], mfc="white"
            )
        axes.axhline(0.0, color="black", lw=0.8)
        axes.set_xlabel(r"$h'_\mathrm{rms}$")
        axes.set_ylabel(
            f"{symbol} over that of the linear block, less 1 [%]".replace("<p^2>", r"$\langle p^2 \rangle$")
        )
    panels[0].legend(fontsize=7)
    return figure
