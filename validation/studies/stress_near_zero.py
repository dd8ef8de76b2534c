"""Does P(sigma) vanish at sigma = 0, with which slope, and is it the slope of the theory?"""

import re
from collections.abc import Iterator

import xarray as xr
from pydantic import Field

from persson import elastic
from validation.errors import UsageError
from validation.measurements.common import Rising
from validation.measurements.edge import edge_limits, edge_of_contact, start_of_pressure
from validation.report.estimates import change, derive, mean, power_law
from validation.report.places import gather, spread
from validation.report.views import Figure, Findings, Level, Line, Table, Views, against, finding
from validation.studies._options import Bandwidth, Methods, ReducedPressure, Surfaces
from validation.studies._scene import PressedOptions
from validation.studies._study import Bench, solved


class Options(PressedOptions):
    """Surfaces, and grids fine enough to see the edge."""

    plain = "at the edge of a plastic, adhesive or layered contact P(sigma) starts by another law"

    methods: Methods = ("bem",)
    reduced_pressure: ReducedPressure = 0.05
    bandwidth: Bandwidth = 4.0
    surfaces: Surfaces = 6
    points_per_wave: Rising = (16.0, 24.0, 32.0, 48.0, 64.0, 96.0, 128.0)
    """grids, as lambda_short/dx, rising"""
    window: float = Field(default=0.4, gt=0)
    """eps of the density P(sigma < eps)/eps, in units of E* h'_rms sqrt(dx/lambda_short): it closes with
    the grid, since a window of fixed width would tend to its slope times half its width and not to P(0+)"""
    slope_window: float = Field(default=1.2, gt=0)
    """the same for the slope; it must end beyond the first cell inside the edge, where the continuum begins"""


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Measure the density of small pressures on grids fine enough to see the edge.

    Over (method, surface, grid) the density in a window that closes, its mean slope there after the counted area in
    excess is taken out, and the slope that follows from the contour and the edge coefficient; over (method,
    surface) their limits at dx -> 0, with means over the surfaces.

    A UsageError for methods on different numbers of grids.
    """
    solvers = options.others(options.points_per_wave, without=())
    if len({len(solver.grids) for solver in solvers}) > 1:
        listed = ", ".join(f"{solver.name} {len(solver.grids)}" for solver in solvers)
        raise UsageError(f"grids of the methods: must be as many for each; found {listed}")
    # A grid is even, and so a little finer than asked for.
    spacing = {
        solver.name: [1 / options.first.points_per_wave(grid) for grid in solver.grids] for solver in solvers
    }
    windows = {"window": options.window, "slope_window": options.slope_window}
    measured = solved(
        bench,
        {
            (solver.name, k, g): edge_of_contact(
                problem=problem, grid=grid, method=solver.method, settings=solver.settings
            )
            for solver in solvers
            for k, problem in enumerate(options.pressed)
            for g, grid in enumerate(solver.grids)
        },
    )
    starts = {
        case: start_of_pressure(data, spacing=spacing[case[0]][case[2]], **windows)
        for case, data in measured.items()
    }
    data = gather(starts, "method", "surface", "grid")
    data = data.drop_vars("grid").assign_coords(
        spacing=(("method", "grid"), [*spacing.values()]),
        stress=("bin", next(iter(measured.values())).stress.values),
        reduced_pressure=options.reduced_pressure,
    )
    methods = " ".join(["theory", *(solver.method for solver in solvers)])
    return limits(data).assign_attrs(methods=methods, **windows, **options.spectrum_words)


def limits(data: xr.Dataset) -> xr.Dataset:
    """Add means over the surfaces, limits at dx -> 0, and Persson's closed form in units of E* h'_rms."""
    variance = elastic.stress_variance(1.0, contact_modulus=1.0)
    slope = float(elastic.initial_slope(float(data.reduced_pressure), stress_variance=variance))
    data = edge_limits(
        data.assign(root_spacing=data.spacing**0.5, root_spacing_limit=0.0, initial_slope_persson=slope)
    )
    for name in ("window_slope", "contour_slope"):
        data = change(data, name, along="grid", first=-2)
    data = derive(
        data,
        initial_slope_gap_each="initial_slope_window_each - initial_slope_contour_each",
        initial_slope_excess_each="initial_slope_window_each / initial_slope_persson - 1",
    )
    data = data.assign(small_density=data.small_density_each.mean("surface")).drop_vars("small_density_each")
    names = [str(name).removesuffix("_each") for name in data.data_vars if str(name).endswith("_each")]
    data = mean(data, *names)
    data = power_law(data, "decay", of="density_at_zero", x="spacing", along=("grid",))
    lines = {f"small_density_{way}": data[f"initial_slope_{way}"] * data.stress for way in _WAYS}
    return data.assign({name: line.drop_attrs() for name, line in lines.items()})


def views(data: xr.Dataset) -> Views:
    """P(sigma) near zero, and what its start tends to."""
    return Views(
        table=Table(
            ("method", "grid"),
            ("method", "spacing", "density_at_zero", "window_slope", "contour_slope", "patches"),
        ),
        budget=("initial_density", "initial_slope_window", "initial_slope_contour"),
        figures=[figure for m in range(data.sizes["method"]) for figure in _figures(data, m)],
        findings=[*_findings(data)],
    )


def _findings(data: xr.Dataset) -> Findings:
    named = "{method}: " if data.sizes["method"] > 1 else ""
    yield finding(
        "comparison",
        "In units of 1/(E* h'_rms) the density at vanishing pressure is at dx to 0 {each}.",
        data,
        item=named + "{initial_density}, {verdict} zero, and falls like dx^{decay} on the grids",
        by="initial_density",
    )
    form = "The slope of P at zero, in units of (E* h'_rms)^-2: {each}; Persson's closed form has "
    form += "{initial_slope_persson}."
    item = (
        named + "{initial_slope_window} from a closing window, {verdict} Persson's, {initial_slope_excess:+%}"
    )
    yield finding("comparison", form, data, item=item, by="initial_slope_excess")
    form = "The slope from contour length and edge coefficient, 2 S <B^-2>: {each}."
    item = named + "{initial_slope_contour}; the two ways {verdict}"
    yield finding("agreement", form, data, item=item, by="initial_slope_gap")
    yield finding(
        "value",
        "From the last grid but one to the last {each} patches a surface.",
        data.assign(patches=data.patches.isel(grid=-1), patches_error=data.patches_error.isel(grid=-1)),
        item=named
        + "the mean slope in the window changes by {window_slope_change:+%}, that from the contour by "
        "{contour_slope_change:+%}, with {patches}",
    )


def _figures(data: xr.Dataset, m: int) -> Iterator[Figure]:
    name = str(data.method.values[m])
    ending = f"-{re.sub('[^A-Za-z0-9]+', '-', name)}" if m else ""
    method = f" By {name}." if m else ""
    at = {"method": m}
    densities = [
        Line("small_density", at={"grid": g}, look={"marker": ""}, label="dx/lambda_short = {spacing:.3}")
        for g in spread(data, "grid")
    ]
    slopes = [Line(f"small_density_{way}", look={"marker": "", "ls": ls}) for way, ls in _WAYS.items()]
    top = 1.1 * float(data.small_density[m].max())
    yield Figure(
        f"pressure-near-zero{ending}",
        "Distribution of contact pressure near zero on some grids, mean over surfaces, with its initial slopes "
        f"at dx to 0 and that of the theory.{method}",
        [against("stress", *densities, *slopes, at=at, bottom=0.0, top=top)],
    )
    limit, theory = "root_spacing_limit", Level("initial_slope_persson")
    ways = [Line("window_slope"), Line("contour_slope")]
    ways += [Line(f"initial_slope_{way}", x=limit, look={"mfc": "white"}) for way in ("window", "contour")]
    yield Figure(
        f"slope-at-zero{ending}",
        "Slope of P(sigma) at zero on each grid, from the density in a closing window and from the contour; at "
        f"the left end, open, their limits; line, the theory.{method}",
        [against("root_spacing", *ways, theory, y="initial_slope", at=at, bottom=0.0)],
    )
    density = ("density_at_zero", Line("initial_density", x=limit))
    yield Figure(
        f"density-at-zero{ending}",
        f"Density at vanishing pressure against the root of the spacing; at the left end its limit.{method}",
        [against("root_spacing", *density, at=at)],
    )


_WAYS = {"window": "--", "contour": ":", "persson": "-."}
