"""How deep must the block be, how fast may its layers grow, and which element does it take?"""

import itertools
from dataclasses import dataclass
from typing import Annotated

import xarray as xr
from pydantic import Field

from validation.measurements.by_solver import beside_bem
from validation.measurements.common import BASE_SOLID, Rising, base_case
from validation.measurements.measurement import grid_for
from validation.report.estimates import claim
from validation.report.views import Figure, Finding, Line, Table, Views, against, finding
from validation.scenes.tables import SolidSpec
from validation.studies._options import Element, ReducedPressure, Seed, StudyOptions
from validation.studies._study import Bench, gathered, read_off


class Options(StudyOptions):
    """Parameters of the block, varied one at a time around depth L, growth 1.2 and nu = 0.3, for every element.

    The surface has H = 0.8, L/lambda_long = 1, lambda_long/lambda_short = 4: its longest wave feels the bottom most.
    """

    why_no_scene = "its surface is the one whose longest wave feels the bottom most"

    reduced_pressure: ReducedPressure = 0.05
    points_per_wave: float = Field(default=16.0, ge=1)
    """grid, as lambda_short/dx"""
    depths: Rising = (0.125, 0.25, 0.5, 0.75, 1.0, 1.5)
    """depths of the block, in periods"""
    growths: Rising = (1.05, 1.1, 1.2, 1.5)
    """ratios of the thicknesses of successive layers"""
    elements: tuple[Element, ...] = Field(default=("Hex1", "Hex2"), min_length=1)
    """trilinear and triquadratic"""
    poissons: tuple[Annotated[float, Field(gt=-1, le=0.5)], ...] = (0.0, 0.3, 0.45)
    """Poisson ratios"""
    seed: Seed = 2006


@dataclass(frozen=True, kw_only=True)
class Block:
    """One block, and which of its parameters is varied."""

    varied: str
    element: str
    depth: float = 1.0
    growth: float = 1.2
    poisson: float = 0.3


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Vary every parameter of the block.

    Pressure differences to the half-space and to the bonded layer of the same depth, by case.
    """
    surface = options.self_affine(hurst=0.8, periods=1.0, bandwidth=4.0)
    varied = {"depth": options.depths, "growth": options.growths, "poisson": options.poissons}
    cases = {}
    for (name, values), element in itertools.product(varied.items(), options.elements):
        for value in values:
            block = Block(varied=name, element=element, **{name: value})
            solid = SolidSpec(young=BASE_SOLID.young, poisson=block.poisson)
            pressed = base_case(surface, reduced_pressure=options.reduced_pressure, solid=solid)
            grid = grid_for(pressed, options.points_per_wave)
            depth = ("depth", block.depth * max(pressed.lengths))
            settings = (("method", "reduced"), ("element", element), depth, ("growth", block.growth))
            cases[block] = beside_bem(problem=pressed, grid=grid, method="fem", settings=settings, layer=True)
    differences = {
        "pressure_difference": "pressure_half_space",
        "pressure_difference_layer": "pressure_layer",
        "area_difference": "pixel / pixel_bem - 1",
    }
    data = gathered(bench, cases, lambda d, _: read_off(d, **differences), "case")
    data = claim(data, *differences)
    return data.assign_attrs(points_per_wave=options.points_per_wave, methods="bem fem")


def views(data: xr.Dataset) -> Views:
    """Where the bottom is felt, and what the mesh alone is responsible for."""
    elements = list(dict.fromkeys(data.element.values.tolist()))
    names = ("pressure_difference", "pressure_difference_layer")

    def lines(varied: str) -> list[Line]:
        return [
            Line(name, where={"varied": varied, "element": element}, label=f"{element}, {what}", look=look)
            for name, what in zip(names, ("half-space", "layer"), strict=True)
            for element, look in zip(elements, _LOOKS, strict=False)
        ]

    return Views(
        table=Table(
            ("case",), ("varied", "element", "depth", "growth", "poisson", *names, "area_difference")
        ),
        figures=[
            Figure(
                "block-depth",
                "Pressure of the block against depth (left) and growth of the layers (right), to the "
                "half-space and to the bonded layer of the same depth, which is the error of the mesh alone.",
                [against(result, *lines(result), log="y") for result in ("depth", "growth")],
            )
        ],
        findings=[_finding(data.isel(case=(data.element == e).values), str(e)) for e in elements],
    )


_LOOKS = ({"color": "#0b5394", "marker": "o"}, {"color": "#b45f06", "marker": "s"})


def _finding(data: xr.Dataset, element: str) -> Finding:
    depths = data.isel(case=(data.varied == "depth").values)
    first, last = depths.isel(case=0), depths.isel(case=-1)
    bottom = abs(depths.pressure_difference - depths.pressure_difference_layer)
    deep = depths.depth.values[(bottom < 0.1 * depths.pressure_difference_layer).values]
    return finding(
        "threshold",
        f"{element}: the bottom costs less than a tenth of the mesh from depth {{deep}} L on; at {{shallow}} L the "
        "pressure is {shallow_difference:%} off the half-space. The mesh alone costs "
        "{pressure_difference_layer:%} at {depth} L.",
        last,
        deep=deep.min() if deep.size else "nowhere tried",
        shallow=first.depth,
        shallow_difference=first.pressure_difference,
    )
