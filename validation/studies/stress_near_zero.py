"""Does P(sigma) vanish at sigma = 0, with which slope, and is it the slope of the theory?"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from persson import elastic
from validation.errors import UsageError
from validation.measures.common import Rising, each, over_surfaces, results_of
from validation.measures.edge import EdgeMeasurement, window_slope
from validation.measures.statistics import Estimate, combined, mean_over_surfaces
from validation.report.drawing import Drawing
from validation.report.table import ResultTable
from validation.solves.bench import Bench
from validation.studies._options import Bandwidth, Methods, ReducedPressure, Surfaces
from validation.studies._scene import PressedOptions

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = [
    "Options",
    "by_method",
    "exponent",
    "figures",
    "findings",
    "intercepts",
    "limit_at_zero",
    "limit_contour_slope",
    "limit_slope",
    "run",
    "table",
]


class Options(PressedOptions):
    """Surfaces, and grids fine enough to see the edge."""

    plain = "at the edge of a plastic, adhesive or layered contact P(sigma) starts by another law"

    methods: Methods = ("bem",)
    reduced_pressure: ReducedPressure = 0.05
    bandwidth: Bandwidth = 4.0
    surfaces: Surfaces = 6
    points_per_wave: Rising = Field(
        default=(16.0, 24.0, 32.0, 48.0, 64.0, 96.0, 128.0), description="grids, as lambda_short/dx, rising"
    )
    window: float = Field(
        default=0.4,
        gt=0,
        description="eps of the density P(sigma < eps)/eps, in units of E* h'_rms sqrt(dx/lambda_short): it closes with "
        "the grid, since a window of fixed width would tend to its slope times half its width and not to P(0+)",
    )
    slope_window: float = Field(
        default=1.2,
        gt=0,
        description="the same for the slope; it must end beyond the first cell inside the edge, where the continuum "
        "begins",
    )


@dataclass(frozen=True, kw_only=True)
class _Start:
    """How P(sigma) of one surface starts on one grid."""

    density_at_zero: float
    slope: float
    contour_slope: float
    patches: float


#: A solve: number of the method, of the surface, of the grid.
_Case = tuple[int, int, int]


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Measure the density of small pressures on grids fine enough to see the edge.

    Returns
    -------
    xarray.Dataset
        density_at_zero (method, surface, grid), the mean slope of P inside the window after the counted area in excess is
        taken out, the slope that follows from the contour and the edge coefficient, and the number of patches.

    Raises
    ------
    UsageError
        For methods on different numbers of grids.
    """
    asked = options.others(options.points_per_wave, without=())
    if len({len(one.grids) for one in asked}) > 1:
        listed = ", ".join(f"{one.name} {len(one.grids)}" for one in asked)
        raise UsageError(f"grids of the methods: must be as many for each; found {listed}")
    cases = {
        (m, k, g): EdgeMeasurement(realised=own, grid=grid, method=one.method, settings=one.settings)
        for m, one in enumerate(asked)
        for (k, own), (g, grid) in itertools.product(enumerate(options.pressed), enumerate(one.grids))
    }
    # A grid is even, and so a little finer than asked for.
    spacing = [[1 / options.first.points_per_wave(grid) for grid in one.grids] for one in asked]
    data = _dataset(results_of(bench, cases), options, np.array(spacing))
    return data.assign_coords(method=[one.name for one in asked]).assign_attrs(
        methods=" ".join(["theory", *(one.method for one in asked)])
    )


def _start(data: xr.Dataset, options: Options, spacing: float) -> _Start:
    """Read one solve: shares of the area below the ends of both windows, and the edge coefficient."""
    upper = np.concatenate([[0], data.upper.values])
    share = np.concatenate([[0], np.cumsum(data.density.values) * float(np.diff(data.upper[:2])[0])])
    window, slope_window = (width * np.sqrt(spacing) for width in (options.window, options.slope_window))
    inside = np.interp([window, slope_window], upper, share)
    return _Start(
        density_at_zero=float(inside[0]) / window,
        slope=window_slope(float(inside[1]), excess=float(data.excess), window=slope_window),
        contour_slope=2 * float(data.contour * data.inverse_square),
        patches=float(data.patches),
    )


def _dataset(found: Mapping[_Case, xr.Dataset], options: Options, spacing: np.ndarray) -> xr.Dataset:
    import xarray as xr

    (count, grids), surfaces = spacing.shape, options.surfaces

    def over(read: Callable[[_Case], Any]) -> np.ndarray:
        places = range(count), range(surfaces), range(grids)
        return np.array([[[read((m, k, g)) for g in places[2]] for k in places[1]] for m in places[0]])

    starts = {case: _start(data, options, spacing[case[0], case[2]]) for case, data in found.items()}
    names = ("density_at_zero", "slope", "contour_slope", "patches")
    read = over(lambda case: attrgetter(*names)(starts[case]))
    dims = ("method", "surface", "grid")
    data: dict[str, Any] = {name: (dims, read[..., k]) for k, name in enumerate(names)}
    density = over(lambda case: found[case].density.values)
    data["density"] = (("method", "grid", "bin"), density.mean(axis=1))
    stress = found[0, 0, 0].stress.values
    return xr.Dataset(
        data,
        coords={
            "spacing": (("method", "grid"), spacing, {"long_name": "dx / lambda_short"}),
            "stress": ("bin", stress, {"long_name": "sigma / (E* h'_rms)"}),
        },
        attrs={
            "study": "stress-near-zero",
            "reduced_pressure": options.reduced_pressure,
            "persson_slope": _persson_slope(options.reduced_pressure),
            "window": options.window,
            "slope_window": options.slope_window,
            "surfaces": options.surfaces,
        },
    )


def _persson_slope(reduced_pressure: float) -> float:
    """Slope of Persson's P(sigma) at zero in units of E* h'_rms."""
    variance = elastic.stress_variance(1.0, contact_modulus=1.0)
    return float(elastic.initial_slope(reduced_pressure, stress_variance=variance))


def _at_zero(rows: np.ndarray, root: np.ndarray, *, degree: int) -> np.ndarray:
    """Value at dx -> 0 of each surface, by a polynomial in dx^(1/2) over its grids."""
    degree = min(degree, root.size - 2) if root.size > 2 else 1
    return np.array([np.polyfit(root, row, degree)[degree] for row in rows])


def intercepts(dataset: xr.Dataset, *, degree: int = 2) -> np.ndarray:
    """P(0+) at dx -> 0 of each surface, by a polynomial in dx^(1/2) over its grids.

    The density in a window eps ~ dx^(1/2) is P(0+) + S eps/2 - c eps^2 + ..., since P bends down from its initial slope S:
    a straight line takes the bend for an intercept.
    """
    return _at_zero(dataset.density_at_zero.values, np.sqrt(dataset.spacing.values), degree=degree)


def _with_drift(dataset: xr.Dataset, values: Callable[[xr.Dataset], np.ndarray]) -> Estimate:
    """Mean over surfaces, its interval widened by how much it moves without the coarsest grid."""
    estimate = mean_over_surfaces(values(dataset))
    finer = dataset.isel(grid=slice(1, None))
    drift = float(values(finer).mean()) - estimate.value if finer.sizes["grid"] > 2 else 0.0
    return replace(estimate, half_width=combined(estimate.half_width, drift))


def limit_at_zero(dataset: xr.Dataset) -> Estimate:
    """P(0+) at dx -> 0, mean over surfaces."""
    return _with_drift(dataset, intercepts)


def limit_slope(dataset: xr.Dataset) -> Estimate:
    """P'(0) at dx -> 0 from the mean slope inside the window that closes, mean over surfaces."""
    return _with_drift(
        dataset, lambda part: _at_zero(part.slope.values, np.sqrt(part.spacing.values), degree=2)
    )


def limit_contour_slope(dataset: xr.Dataset) -> Estimate:
    """2 S <B^-2> at dx -> 0: the patches curve within the cells where B is read, a bias of first order in dx."""
    return _with_drift(
        dataset, lambda part: _at_zero(part.contour_slope.values, part.spacing.values, degree=1)
    )


def exponent(dataset: xr.Dataset) -> float:
    """Fitted exponent of dx in the mean density at zero."""
    mean = dataset.density_at_zero.mean("surface").values
    return float(np.polyfit(np.log(dataset.spacing.values), np.log(mean), 1)[0])


def table(dataset: xr.Dataset) -> ResultTable:
    """Return one row for each method and grid."""
    columns = ["method", "lambda_short/dx"]
    for words in _MEANS.values():
        columns += [words, "+- (95 %)"]
    rows: list[list[float | str]] = []
    for name, own in by_method(dataset).items():
        for here in each(own, "grid"):
            means = [over_surfaces(here[quantity]) for quantity in _MEANS]
            numbers = [number for mean in means for number in (mean.value, mean.half_width)]
            rows.append([name, 1 / float(here.spacing), *numbers, float(here.patches.mean())])
    return ResultTable.of([*columns, "patches"], rows)


#: What the table holds of each grid, and how it is called there.
_MEANS = {
    "density_at_zero": "P(0+) E*h'",
    "slope": "mean slope in the window",
    "contour_slope": "slope from the contour",
}


def by_method(dataset: xr.Dataset) -> dict[str, xr.Dataset]:
    """Return what each method found."""
    return {str(name): dataset.isel(method=m) for m, name in enumerate(dataset.method.values)}


def findings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return whether the density vanishes, and how the slopes compare, for each method."""
    each = by_method(dataset)
    return tuple(
        sentence if len(each) == 1 else f"{name}: {sentence}"
        for name, own in each.items()
        for sentence in _sentences(own)
    )


def _sentences(dataset: xr.Dataset) -> tuple[str, ...]:
    limit = limit_at_zero(dataset)
    straight = float(intercepts(dataset, degree=1).mean())
    finest = float(dataset.density_at_zero[:, -1].mean())
    zero = abs(limit.value) <= limit.half_width
    slope, contour = limit_slope(dataset), limit_contour_slope(dataset)
    persson = float(dataset.attrs["persson_slope"])
    patches = dataset.patches.mean("surface").values
    return (
        f"The density at vanishing pressure falls like dx^{exponent(dataset):.2f}, to {finest:.3f} on the finest grid; at dx -> 0 it is "
        f"{limit} (95 %), {'not told from zero' if zero else 'different from zero'} "
        f"(in units of 1/(E* h'_rms), {limit.samples} surfaces; a straight line in dx^(1/2), which takes the bend of P for an intercept, leaves {straight:.4f}).",
        _slope_sentence(slope, contour, persson),
        f"On the finest grid the slopes are {float(dataset.slope[:, -1].mean()):.3f} and {float(dataset.contour_slope[:, -1].mean()):.3f}."
        + _drift(dataset),
        f"Every patch adds to the slope whatever its size: it rests on {patches[-1]:.0f} patches per surface, "
        f"{patches[-2]:.0f} on the next coarser grid.",
    )


#: A slope less certain than this, relative, is no number.
_DECIDED = 0.3


def _slope_sentence(slope: Estimate, contour: Estimate, persson: float) -> str:
    """Say what the slope at zero is, whether both ways to it agree, and how far the theory is."""
    both = f"{slope} from the density in a closing window, {contour} from contour length and edge coefficient (2 S <B^-2>)"
    if slope.half_width > _DECIDED * slope.value:
        return f"The slope P'(0) is not determinable to {100 * _DECIDED:.0f} % from these surfaces and grids: {both}; Persson's closed form has {persson:.3f}."
    agree = abs(slope.value - contour.value) <= combined(slope.half_width, contour.half_width)
    return (
        f"P grows from zero with the slope {both}, in units of (E* h'_rms)^-2 at dx -> 0: the two {'agree' if agree else 'do not agree'} within "
        f"their intervals. Persson's closed form has {persson:.3f}, {slope.value / persson:.1f} +- {slope.half_width / persson:.1f} times less than simulated."
    )


def _drift(dataset: xr.Dataset) -> str:
    """Say whether the slopes still move from one grid to the next."""
    words = []
    for name, label in (("slope", "slope in the window"), ("contour_slope", "slope from the contour")):
        mean = dataset[name].mean("surface").values
        change = mean[-1] / mean[-2] - 1
        if abs(change) > 0.05:
            words.append(f"the {label} still changes by {100 * change:+.0f} % from the last grid but one")
    return f" Not converged: {' and '.join(words)}; finer grids are needed for a number." if words else ""


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw P(sigma) near zero and its value at zero against the grid, for each method."""
    first, *others = by_method(dataset).items()
    drawings = list(_drawings(first[1], ""))
    for name, own in others:
        drawings += _drawings(own, name)
    return tuple(drawings)


def _drawings(dataset: xr.Dataset, method: str) -> Iterator[Drawing]:
    """Yield the figures of one method; those of the first go without its name."""
    ending = f"-{re.sub('[^A-Za-z0-9]+', '-', method)}" if method else ""
    words = f" By {method}." if method else ""
    for drawing in _plain_drawings(dataset):
        yield replace(drawing, name=drawing.name + ending, caption=drawing.caption + words)


def _plain_drawings(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    window, contour = limit_slope(dataset), limit_contour_slope(dataset)
    return (
        Drawing(
            name="pressure-near-zero",
            figure=_pressure_near_zero(dataset, window=window.value, contour=contour.value),
            data=dataset[["density"]],
            caption="Distribution of contact pressure near zero on each grid, mean over surfaces, with the initial slope "
            "that follows from contour and edge coefficient and that of the theory.",
        ),
        Drawing(
            name="slope-at-zero",
            figure=_slope_at_zero(dataset, window, contour),
            data=dataset[["slope", "contour_slope"]],
            caption="Slope of P(sigma) at zero on each grid, from the density in a closing window and from the contour; "
            "filled at 0, the limits with 95 % intervals; line, the theory.",
        ),
        Drawing(
            name="density-at-zero",
            figure=_density_at_zero(dataset),
            data=dataset[["density_at_zero"]],
            caption="Density at vanishing pressure against the square root of the spacing: grey, single surfaces; black, "
            "mean; the intercept tells whether it vanishes.",
        ),
    )


def _pressure_near_zero(dataset: xr.Dataset, *, window: float, contour: float) -> Figure:
    """P(sigma) below 0.3 E* h' on every grid, mean over surfaces, with the slopes."""
    from validation.report.figure import THEORY, new_figure

    figure, (axes,) = new_figure()
    shades = np.linspace(0.75, 0.0, dataset.sizes["grid"])
    for k, spacing in enumerate(dataset.spacing.values):
        label = rf"$\lambda_{{short}}/\Delta x$ = {1 / spacing:.0f}"
        axes.plot(
            dataset.stress,
            dataset.density[k],
            color=str(shades[k]),
            ls=("-", "--", "-.", ":")[k % 4],
            label=label,
        )
    top = float(dataset.density.max())
    stress = np.linspace(0, 0.3, 50)
    for slope, label, style in (
        (window, "slope at 0, closing window", {"color": "#0b5394", "ls": "--"}),
        (contour, r"$2 S\langle B^{-2}\rangle\sigma$", {"color": "#b45f06", "ls": ":"}),
        (float(dataset.attrs["persson_slope"]), "Persson's slope", THEORY),
    ):
        axes.plot(stress, slope * stress, label=label, lw=2, **style)
    axes.set_ylim(0, 1.1 * top)
    axes.set_xlim(0, 0.3)
    axes.set_xlabel(r"$\sigma / (E^* h'_{rms})$")
    axes.set_ylabel(r"$P(\sigma)\,E^* h'_{rms}$ per nominal area")
    axes.legend(fontsize=8)
    return figure


def _slope_at_zero(dataset: xr.Dataset, window: Estimate, contour: Estimate) -> Figure:
    """Draw the slope of P(sigma) at zero against the spacing, by both ways, with the limits and the theory."""
    from validation.report.figure import THEORY, look, new_figure

    figure, (axes,) = new_figure()
    root = np.sqrt(dataset.spacing.values)
    ways = (
        ("slope", window, "density in a closing window"),
        ("contour_slope", contour, r"$2 S\langle B^{-2}\rangle$"),
    )
    for k, (name, limit, label) in enumerate(ways):
        values = dataset[name]
        error = values.std("surface", ddof=1) / np.sqrt(dataset.sizes["surface"])
        axes.errorbar(root, values.mean("surface"), yerr=error, label=label, **{**look(k), "mfc": "white"})
        axes.errorbar([-0.004 * k], [limit.value], yerr=[limit.half_width], ls="", **look(k))
    axes.axhline(float(dataset.attrs["persson_slope"]), label="Persson", **THEORY)
    axes.set_ylim(bottom=0)
    axes.set_xlabel(r"$(\Delta x/\lambda_{short})^{1/2}$")
    axes.set_ylabel(r"$P'(0)\,(E^* h'_{rms})^2$")
    axes.legend(fontsize=8)
    return figure


def _density_at_zero(dataset: xr.Dataset) -> Figure:
    """P(0+) against dx^(1/2), each surface and the mean, with the extrapolation to dx -> 0."""
    from validation.report.figure import SYMBOLS, new_figure

    figure, (axes,) = new_figure()
    at_zero, root = intercepts(dataset), np.sqrt(dataset.spacing.values)
    for k, row in enumerate(dataset.density_at_zero.values):
        axes.plot(root, row, marker=SYMBOLS[k % 8], ms=4, lw=0.6, color="0.5")
    mean = dataset.density_at_zero.mean("surface").values
    axes.plot(root, mean, marker="o", color="black", lw=1.5, label="mean over surfaces")
    bend = np.polyfit(root, mean, 2 if root.size > 3 else 1)
    dense = np.linspace(0, root[0], 50)
    axes.plot(dense, np.polyval(bend, dense), ls="--", color="black", lw=1, label="polynomial in dx^(1/2)")
    axes.errorbar(
        [0],
        [at_zero.mean()],
        yerr=[at_zero.std(ddof=1) if at_zero.size > 1 else 0.0],
        color="#b45f06",
        marker="s",
        capsize=3,
        label="intercept, spread",
    )
    axes.axhline(0, color="black", lw=0.5)
    axes.set_xlabel(r"$(\Delta x/\lambda_{short})^{1/2}$")
    axes.set_ylabel(r"$P(0^+)\,E^* h'_{rms}$")
    axes.legend(fontsize=8)
    return figure
