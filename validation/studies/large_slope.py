"""Up to which slope does the linear theory of contact hold?

The same surface is made steeper at one reduced load p* = p0/(E* h'_rms), so that linear elasticity says the same of all
of them; a neo-Hookean block of finite strain, met by the rough surface where its nodes are, says what is left out.
"""

from __future__ import annotations

import itertools
from typing import Annotated

import xarray as xr
from pydantic import Field

from validation.execution.bench import Bench
from validation.measurements.common import BASE_SOLID, Rising, RisingSeveral, base_case
from validation.measurements.measurement import grid_for
from validation.measurements.slopes import CHANGES, changes_of, steepened, with_differences
from validation.report.estimates import claim
from validation.report.views import Figure, Finding, Table, Views, against, finding
from validation.scenes.tables import SolidSpec
from validation.studies._options import Bandwidth, Hurst, Periods, Seed, StudyOptions, Surfaces
from validation.studies._study import gathered

#: Relative differences whose slopes are looked for, and the slope up to which differences count as going with it.
DIFFERENCES, STRAIGHT = (0.01, 0.05), 0.4


class Options(StudyOptions):
    """Surfaces of few waves on fine grids: steep tips of less than some ten points cannot be followed."""

    why_no_scene = "it makes surfaces steeper at one reduced load"

    slopes: RisingSeveral = (0.05, 0.1, 0.2, 0.4, 0.7)
    """h'_rms of the surfaces, rising"""
    reduced_pressures: Rising = (0.05, 0.2)
    """p* = p0 / (E* h'_rms) with the realised gradient of each surface"""
    poissons: tuple[Annotated[float, Field(ge=0, lt=0.5)], ...] = Field(default=(0.3, 0.49), min_length=1)
    """Poisson ratios at small strain"""
    hurst: Hurst = 0.8
    periods: Periods = 1.0
    bandwidth: Bandwidth = 2.0
    surfaces: Surfaces = 4
    points_per_wave: RisingSeveral = (12.0, 16.0)
    """grids, as lambda_short/dx; the finest gives the value, its distance to the one before the uncertainty"""
    seed: Seed = 2006


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
    data = data.drop_vars(["nu", "load", "grid"])
    data = data.assign_coords(
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
                [
                    against("rms_gradient", name, by=("nu", "load"))
                    for name in ("area_finite", "square_finite")
                ],
            )
        ],
        findings=[
            _leaves(data, "area_finite", "contact area projected on the plane"),
            _leaves(data, "square_finite", "mean square pressure"),
            _rate(data, "area_finite", "contact area"),
            _rate(data, "square_finite", "mean square pressure"),
            *([ended] if float(data.paths_ended) else []),
        ],
    )


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
