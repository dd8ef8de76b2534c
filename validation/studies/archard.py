"""Does the contact area become proportional to the load as bumps are put on bumps (Archard 1957)?

A wave in both directions stands for the largest sphere; shorter and lower ones cover it, level by level. Boundary elements
press it, and the power of the load that its area goes with stands beside Archard's 2/3, 8/9, 26/27 (Persson 2006, Sec. 1).
"""

import itertools
import math
from collections.abc import Sequence
from typing import Annotated, Self

import numpy as np
import xarray as xr
from pydantic import Field, model_validator

from fem_contact.extrapolation import LEAST_CONTACT_POINTS
from fem_contact.surface import HeightField
from persson.archard import archard_hierarchy
from validation.measurements.common import BASE_SOLID, RisingGrids, RisingSeveral
from validation.measurements.flow import located_area
from validation.measurements.measurement import elastic_path
from validation.report.estimates import claim, derive, mean, power_law
from validation.report.views import Figure, Findings, Level, Line, Table, Views, against, finding
from validation.studies._options import Positives, Seed, StudyOptions, Surfaces
from validation.studies._study import ABSENT, Bench, gathered, measurement, stored_variables
from validation.units import wrong

#: Points of a grid on the shortest wave, fewer than which tell nothing of its bumps.
_LEAST = 4


#: Amplitude of the largest wave over the period: it scales out.
_SLOPE = 0.01


@measurement(
    lambda waves, points: f"archard-{len(waves)}-{points}",
    kind="Hierarchy",
    words="bumps on {waves} waves,",
    located=True,
    version=2,
    seconds=lambda points, loads: len(loads) * (2e-3 + 8e-7 * points),
    bytes=120,
)
def press_bumps(
    *,
    waves: tuple[int, ...],
    heights: tuple[float, ...],
    places: tuple[tuple[float, float], ...],
    loads: tuple[float, ...],
    points: int,
) -> xr.Dataset:
    """Press along the path of loads, each from the one before; located A/A0, NaN where too few points touch.

    Each level has so many `waves` on a period, from 1, of `heights` over that of the first, moved by
    `places` of a period; `loads` are rising p0 / (E* H_0 / L).
    """
    solid, areas = BASE_SOLID.elastic, []
    pressures = [load * _SLOPE * solid.contact_modulus for load in loads]
    for solved in elastic_path(bumps(waves, heights, places, points=points), solid, pressures):
        few = np.count_nonzero(solved.in_contact) < LEAST_CONTACT_POINTS
        areas.append(np.nan if few else located_area(solved))
    return xr.Dataset({"area_each": ("load", areas)})


def bumps(
    waves: Sequence[int], heights: Sequence[float], places: Sequence[tuple[float, float]], *, points: int
) -> HeightField:
    r"""Heights on a period of 1: sum over the levels of H_k / 2 [cos(2 pi n_k x) + cos(2 pi n_k y)]."""
    x = np.arange(points) / points
    total = np.zeros((points, points))
    for count, height, (along, across) in zip(waves, heights, places, strict=True):
        first, second = (np.cos(2 * np.pi * count * (x + place)) for place in (along, across))
        total += _SLOPE * height / 2 * (first[:, None] + second[None, :])
    return HeightField(heights=total, lengths=(1.0, 1.0))


def radii_of(waves: Sequence[int], heights: Sequence[float]) -> list[float]:
    """Radius of curvature of the tops of each level, on a period of 1: 1 / (2 pi^2 n_k^2 H_k)."""
    levels = zip(waves, heights, strict=True)
    return [1 / (2 * math.pi**2 * count**2 * _SLOPE * height) for count, height in levels]


class Options(StudyOptions):
    """Which bumps on which, and how they are pressed."""

    why_no_scene = "its surface is a hierarchy of bumps, not one of a spectrum"

    waves: RisingGrids = (16, 128)
    """waves of the second level on a period, of the third, ...; rising"""
    heights: Positives = (0.2, 0.08)
    """their heights over that of the first level, one for each"""
    loads: RisingSeveral = (0.002, 0.004, 0.008, 0.016, 0.032, 0.064)
    """p0 / (E* height of the first level / period), rising"""
    surfaces: Surfaces = 4
    grids: Annotated[RisingGrids, Field(min_length=2)] = (512, 1024)
    """points along a side, rising; the change from the last but one is the uncertainty of the grid"""
    seed: Seed = 2006

    @model_validator(mode="after")
    def _bumps_are_resolved(self) -> Self:
        if len(self.heights) != len(self.waves):
            raise wrong(
                f"--heights: {len(self.heights)} of {len(self.waves)} levels; give one for each of --waves"
            )
        if self.grids[0] < _LEAST * self.waves[-1]:
            raise wrong(
                f"--grids = {self.grids[0]}: {self.waves[-1]} waves take {_LEAST * self.waves[-1]} points or more"
            )
        return self


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press hierarchies of one level, two, and so on, with the levels moved against each other.

    Located A/A0 over (level, surface, grid, load), where surfaces differ in how the levels are moved; its power of
    the load by least squares, and the local one; both of Archard's spheres.
    """
    waves, heights = (1, *options.waves), (1.0, *options.heights)
    moved = np.random.default_rng(options.seed).random((options.surfaces, len(waves), 2))
    counts, surfaces = range(1, len(waves) + 1), range(options.surfaces)
    cases = {
        (n, k, points): press_bumps(
            waves=waves[:n],
            heights=heights[:n],
            places=tuple((float(x), float(y)) for x, y in moved[k, :n]),
            loads=options.loads,
            points=points,
        )
        for n, k, points in itertools.product(counts, surfaces, options.grids)
    }
    data = gathered(bench, cases, lambda d, _: stored_variables(d), "level", "surface", "grid")
    loads = np.array(options.loads)
    # Spheres of a level have the curvature of its tops; n_k^2 of them stand on the period, on the first one too.
    theory = [
        archard_hierarchy(
            loads * _SLOPE,
            radii=radii_of(waves[:n], heights[:n]),
            densities=[float(count**2) for count in waves[1:n]],
            contact_modulus=1.0,
        )
        for n in counts
    ]
    data = data.drop_vars(["level", "grid"]).assign_coords(
        levels=("level", list(counts)),
        points=("grid", list(options.grids)),
        relative_load=("load", loads),
        middle_load=("middle", np.sqrt(loads[1:] * loads[:-1])),
    )
    data["area_archard"] = ("level", "load"), [spheres.area for spheres in theory]
    data["load_exponent_archard"] = "level", [spheres.exponent for spheres in theory]
    return with_exponents(data).assign_attrs(methods="theory bem", shortest=options.waves[-1])


def with_exponents(data: xr.Dataset) -> xr.Dataset:
    """Add the power of the load that areas go with, its rise from level to level, and what it falls short of 1."""
    # A contact of too few points has no area, and its path no power.
    complete = data.area_each.notnull().all("load")
    data = power_law(data, "load_exponent_grid_each", of="area_each", x="relative_load", along=("load",))
    data = data.drop_vars(["load_exponent_grid_each_error", "load_exponent_grid_each_factor"])
    data["load_exponent_grid_each"] = data.load_exponent_grid_each.where(complete)
    data = derive(
        data.assign(area_finest_each=data.area_each.isel(grid=-1)),
        load_exponent_each="load_exponent_grid_each.isel(grid=-1)",
        load_exponent_each_drift="(load_exponent_grid_each.isel(grid=-1) - load_exponent_grid_each.isel(grid=-2))",
        local_exponent_each="log(area_each).diff('load').rename(load='middle') / log(relative_load).diff('load')"
        ".rename(load='middle')",
    )
    data = mean(data, "area_finest", "load_exponent_grid", "load_exponent", "local_exponent")
    data = claim(data, "load_exponent", "area_finest", **ABSENT)
    data = derive(data, area_over_archard="area_finest / area_archard", shortfall="1 - load_exponent")
    before = {f"before{end}": data[f"load_exponent{end}"].shift(level=1) for end in ("", "_error")}
    rise = derive(data.assign(before), level_rise="load_exponent - before")
    return derive(rise.drop_vars(list(before)), shortfall_archard="1 - load_exponent_archard")


def views(data: xr.Dataset) -> Views:
    """Area over the load, its local power, and the powers of every level."""
    areas = ("area_finest", "area_archard")
    lines = [Line(areas[0], by="level", joined=False), Line(areas[1], by="level", label="")]
    powers = [
        Line("local_exponent", by="level", at={"grid": -1}),
        Level("load_exponent_archard", by="level", label="", look={"ls": "--"}),
    ]
    return Views(
        table=Table(
            ("level", "load"), ("levels", "relative_load", *areas, "area_over_archard", "load_exponent")
        ),
        budget=("load_exponent",),
        figures=[
            Figure(
                "archard",
                "Bumps on bumps on a bump. Left: contact area over the load, finest grid, beside Archard's spheres of "
                "the same radii and densities. Right: local power of the load beside Archard's 2/3, 8/9, 26/27 (dashed).",
                [
                    against("relative_load", *lines, log="xy"),
                    against("middle_load", *powers, log="x", bottom=0.6),
                ],
            )
        ],
        findings=[*_findings(data)],
    )


def _findings(data: xr.Dataset) -> Findings:
    yield finding(
        "comparison",
        "The area goes with the load to these powers, over positions of the levels and with the change from the "
        "grid before, by levels: {each}.",
        data,
        item="{levels}: {load_exponent} (Archard {load_exponent_archard:~}), {verdict}",
        by="shortfall",
        words={"+": "below 1", "-": "above 1", "0": "statistically indistinguishable from 1"},
    )
    form = "With each level more the power {each}."
    item = "{verdict} by {level_rise} (level {levels})"
    yield finding("trend", form, data.isel(level=slice(1, None)), item=item, by="level_rise")
    yield finding(
        "value",
        "The area over Archard's, at p0 L/(E* H_0) = {light} and {heavy}, by levels: {each}.",
        data.isel(load=-1).assign(
            lightest=data.area_over_archard.isel(load=0),
            lightest_error=data.area_over_archard_error.isel(load=0),
        ),
        item="{levels}: {lightest} and {area_over_archard}",
        light=data.relative_load[0],
        heavy=data.relative_load[-1],
    )
