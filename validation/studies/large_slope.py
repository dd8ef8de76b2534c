"""Up to which slope does the linear theory of contact hold?

The same surface is made steeper at one reduced load p* = p0/(E* h'_rms), so that linear elasticity says the same of all
of them; a neo-Hookean block of finite strain, met by the rough surface where its nodes are, says what is left out.
"""

import itertools
from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
import xarray as xr
from pydantic import Field

from fem_contact.errors import NotConverged
from fem_contact.settings import one_blas_thread
from validation.arrays import Array, Grid
from validation.execution.solve import Prediction
from validation.measurements.common import BASE_SOLID, Rising, RisingSeveral, base_case
from validation.measurements.measurement import grid_for
from validation.report.estimates import claim, derive, mean, total_error
from validation.report.views import Figure, Finding, Table, Views, against, finding
from validation.scenes.problem import ContactProblem
from validation.scenes.tables import SolidSpec
from validation.studies._options import Bandwidth, Periods, SurfaceOptions, Surfaces
from validation.studies._study import Bench, gathered, measurement, read_off

#: Relative differences whose slopes are looked for, and the slope up to which differences count as going with it.
DIFFERENCES, STRAIGHT = (0.01, 0.05), 0.4


def _predicted(points: int, slopes: tuple[float, ...]) -> Prediction:
    unknowns = int(3 * points * 3 * np.log(points))
    seconds = 0.5 + 4e-5 * unknowns * len(slopes)
    return Prediction(seconds=seconds, peak_bytes=9000 * unknowns, unknowns=unknowns)


@measurement("slopes-{size}", kind="SlopeMeasurement", words="finite strain", version=1, predict=_predicted)
def steepened(
    *, problem: ContactProblem, grid: Grid, slopes: tuple[float, ...], depth: float = 1.0, growth: float = 1.3
) -> xr.Dataset:
    """Press a surface at one p0 / (E* h'_rms) scaled to rising slopes h'_rms, where the solid is neo-Hookean.

    By slope: A/A0 projected on the plane where the nodes are now, the share of the undeformed surface in
    contact (material), and the area along the rigid surface (true), nodes counted; int p^2 dA / (p0^2 A0),
    p over the projected area; forces that nothing balances over those of the contact, and the mean force
    along the plane over the load. NaN, with the reason, where Newton's method ends. The block is `depth`
    periods deep.
    """
    from fem_contact import block

    field, solid = problem.heights(grid), problem.elastic
    pressure = problem.reduced_pressure * solid.contact_modulus * field.rms_gradient
    mesh: Any = {"depth": depth * max(field.lengths), "growth": growth}
    steps: list[dict[str, float]] = []
    ended = ""
    with one_blas_thread():
        linear = block.solve(field, solid, mean_pressure=pressure, **mesh).contact.checked()
        try:
            for steeper in block.solve_slopes(field, solid, mean_pressure=pressure, slopes=slopes, **mesh):
                square = float(np.mean(steeper.shares * steeper.pressure**2)) / steeper.mean_pressure**2
                read = {name: getattr(steeper, name) for name in _NAMES if name != "square_pressure"}
                steps.append(read | {"square_pressure": square})  # what came before an error counts
        except NotConverged as error:
            ended = str(error)
    steps += [dict.fromkeys(_NAMES, np.nan)] * (len(slopes) - len(steps))
    return xr.Dataset(
        {name: ("slope", [step[name] for step in steps]) for name in _NAMES}
        | {
            "linear_area": float(np.mean(linear.in_contact)),
            "linear_square_pressure": float(np.mean(linear.pressure**2)) / linear.mean_pressure**2,
        },
        coords={"slope": list(slopes)},
        attrs={"ended": ended},
    )


_NAMES = ("area", "material_area", "true_area", "square_pressure", "residual", "sideways")


#: Changes against the linear block, and the ratios of a measurement whose distances from 1 they are.
CHANGES = {
    "area_finite": "area / linear_area",
    "area_finite_true": "true_area / linear_area",
    "area_finite_material": "material_area / linear_area",
    "square_finite": "square_pressure / linear_square_pressure",
}


def changes_of(measured: xr.Dataset) -> xr.Dataset:
    """Reduce one path of slopes to changes against the linear block, on its grid."""
    data = read_off(
        measured.drop_vars("slope"),
        **{f"{name}_grid_each": f"{ratio} - 1" for name, ratio in CHANGES.items()},
        **{f"{name}_each": name for name in ("residual", "sideways", "linear_area")},
    )
    return data.assign(path_ended_each=float(bool(measured.attrs["ended"])))


def with_differences(data: xr.Dataset, *, differences: Sequence[float], straight: float) -> xr.Dataset:
    """Add changes on the finest grid, what they are per slope, and from which slope on they exceed differences.

    To ``x_grid_each`` of `CHANGES` over (..., surface, grid, slope), with ``rms_gradient`` (slope); the
    step from the grid before is the error of the grid. Up to the slope `straight`, ``x_rate`` is that of a
    line through 0.
    """
    slopes = data.rms_gradient
    small = {"slope": np.flatnonzero(slopes.values <= straight)}
    data = data.assign_coords(difference=list(differences))
    for name in CHANGES:
        values = data[f"{name}_grid_each"]
        line = (values * slopes).isel(small).sum("slope", skipna=False) / (slopes**2).isel(small).sum()
        data[f"{name}_rate_grid_each"] = line.drop_vars("rms_gradient", errors="ignore").drop_attrs()
        for part in (name, f"{name}_rate"):
            finest, before = (f"{part}_grid_each.isel(grid={k})" for k in (-1, -2))
            data = derive(data, **{f"{part}_each": finest, f"{part}_each_drift": f"{finest} - {before}"})
        data = mean(data, name, f"{name}_rate")
        error = total_error(data, name)
        assert error is not None
        size = abs(data[name])
        for end, change in (("", size), ("_lower", size + error), ("_upper", size - error)):
            at = xr.apply_ufunc(
                first_crossing,
                slopes,
                change,
                data.difference,
                input_core_dims=[["slope"], ["slope"], []],
                vectorize=True,
            )
            data[f"{name}_crossing{end}"] = at.assign_attrs(reduction="crossing", of=name)
            data = claim(data, f"{name}_crossing{end}")
    return data


def first_crossing(slopes: Array, change: Array, difference: float) -> float:
    """Return where a change first exceeds a difference, between slopes and from 0 on straight; NaN if nowhere.

    >>> round(first_crossing(np.array([0.1, 0.12, 0.2]), np.array([0.01, np.nan, 0.03]), 0.02), 12)
    0.15
    """
    x, y = np.append(0.0, slopes), np.append(0.0, change)
    x, y = x[np.isfinite(y)], y[np.isfinite(y)]
    beyond = np.flatnonzero(y > difference)
    if not beyond.size:
        return float("nan")
    k = int(beyond[0])
    return float(x[k - 1] + (difference - y[k - 1]) / (y[k] - y[k - 1]) * (x[k] - x[k - 1]))


class Options(SurfaceOptions):
    """Surfaces of few waves on fine grids: steep tips of less than some ten points cannot be followed."""

    why_no_scene = "it makes surfaces steeper at one reduced load"

    slopes: RisingSeveral = (0.05, 0.1, 0.2, 0.4, 0.7)
    """h'_rms of the surfaces, rising"""
    reduced_pressures: Rising = (0.05, 0.2)
    """p* = p0 / (E* h'_rms) with the realised gradient of each surface"""
    poissons: tuple[Annotated[float, Field(ge=0, lt=0.5)], ...] = Field(default=(0.3, 0.49), min_length=1)
    """Poisson ratios at small strain"""
    periods: Periods = 1.0
    bandwidth: Bandwidth = 2.0
    surfaces: Surfaces = 4
    points_per_wave: RisingSeveral = (12.0, 16.0)
    """grids, as lambda_short/dx; the finest gives the value, its distance to the one before the uncertainty"""


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Make every surface steeper, at every load and Poisson ratio, on every grid.

    Areas and mean square pressure over those of the linear block less 1, over (nu, load, surface, grid, slope); NaN
    where Newton's method found no equilibrium; their means on the finest grid, and from which slope on they count.
    """
    cases = {}
    for poisson, load in itertools.product(options.poissons, options.reduced_pressures):
        solid = SolidSpec(young=BASE_SOLID.young, poisson=poisson)
        base = base_case(options.self_affine(), reduced_pressure=load, solid=solid)
        for k, points in itertools.product(range(options.surfaces), options.points_per_wave):
            cases[poisson, load, k, points] = steepened(
                problem=base.further(k),
                grid=grid_for(base, points),
                slopes=options.slopes,
                depth=1 / options.periods,
            )
    data = gathered(bench, cases, lambda d, _: changes_of(d), "nu", "load", "surface", "grid")
    data = data.drop_vars(["nu", "load", "grid"]).assign_coords(
        poisson=("nu", list(options.poissons)),
        reduced_pressure=("load", list(options.reduced_pressures)),
        points_per_wave=("grid", list(options.points_per_wave)),
        rms_gradient=("slope", list(options.slopes)),
    )
    data = with_differences(data, differences=DIFFERENCES, straight=STRAIGHT)
    data["paths_ended"] = data.path_ended_each.isel(grid=-1).sum()
    data = claim(data, *CHANGES, *(f"{name}_rate" for name in CHANGES), theory="it is simulated")
    return data.assign_attrs(methods="fem", hurst=options.hurst, bandwidth=options.bandwidth)


def views(data: xr.Dataset) -> Views:
    """Area and mean square pressure over the slope, and from where on they leave the linear result."""
    ended = finding(
        "value",
        "{paths_ended} of {paths} paths on the finest grid end before h'_rms = {steepest}: no equilibrium was found beyond, "
        "and their slopes are left out for all surfaces.",
        data,
        paths=data.path_ended_each.isel(grid=-1).size,
        steepest=data.rms_gradient[-1],
    )
    return Views(
        table=Table(("nu", "load", "slope"), ("poisson", "reduced_pressure", "rms_gradient", *CHANGES)),
        budget=("area_finite_rate", "square_finite_rate"),
        figures=[
            Figure(
                "large-slope",
                "What finite strain changes of contact area and mean square pressure at one reduced load, over the "
                "slope of the surface. Straight lines through 0 are effects of first order.",
                [against("rms_gradient", name, by=("nu", "load")) for name in _DRAWN],
            )
        ],
        findings=[
            *(_leaves(data, name, quantity) for name, quantity in _DRAWN.items()),
            *(_rate(data, name, quantity.partition(" projected")[0]) for name, quantity in _DRAWN.items()),
            *([ended] if float(data.paths_ended) else []),
        ],
    )


_DRAWN = {"area_finite": "contact area projected on the plane", "square_finite": "mean square pressure"}
_WHERE = "nu = {poisson}, p* = {reduced_pressure}"


def _leaves(data: xr.Dataset, name: str, quantity: str) -> Finding:
    form = f"h'_rms from which on the {quantity} differs from the linear one (95 %, surfaces and grid), "
    form += "not determinable where that is beyond the slopes there are: {each}."
    item = f"by {{difference:%}} {{{name}_crossing}} ({{{name}_crossing_lower}} to {{{name}_crossing_upper}}; {_WHERE})"
    return finding("threshold", form, data, item=item)


def _rate(data: xr.Dataset, name: str, quantity: str) -> Finding:
    form = f"Up to h'_rms = {STRAIGHT:g} the {quantity} over the linear one {{each}}."
    item = f"{{verdict}} with the slope ({{{name}_rate:+}} times h'_rms; {_WHERE})"
    return finding("trend", form, data, item=item, by=f"{name}_rate", words={"0": "shows no trend"})
