"""Do finite elements, or other solvers, and boundary elements agree on the same surface and grid, and ever better with refinement?"""

from collections.abc import Iterator
from typing import Annotated, Any, Self

import numpy as np
import xarray as xr
from pydantic import Field, model_validator

from validation.measurements.common import Rising, RisingOrNone
from validation.report.estimates import derive, mean, power_law, reduce
from validation.report.places import each
from validation.report.views import Figure, Table, Views, against, finding, note
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import Scene
from validation.studies._options import Bandwidth, Element, Methods, Periods, ReducedPressure
from validation.studies._scene import PressedOptions, SolverRequest
from validation.studies._study import Bench, gathered, read_off
from validation.units import wrong


class Options(PressedOptions):
    """What is pressed by both methods, and on which grids."""

    off = ("full_points_per_wave", "elements")
    slots = frozenset({"response", "pressure bound", "gap law"})

    methods: Methods = ("bem", "fem")
    reduced_pressure: ReducedPressure = 0.05
    periods: Periods = 2.0
    bandwidth: Bandwidth = 4.0
    poisson: Annotated[float, Field(gt=-1, le=0.49, description="Poisson ratio of the solid")] = 0.3
    surfaces: Annotated[int, Field(ge=1, description="how many realisations")] = 4
    full_points_per_wave: RisingOrNone = (3.0, 4.0, 6.0, 12.0, 24.0)
    """grids of the full Hex1 system, as lambda_short/dx: the independent leg, which shares no contact
    algorithm with the boundary elements"""
    reduced_points_per_wave: Rising = (3.0, 4.0, 6.0, 8.0, 16.0, 32.0)
    """grids of the exact reduction, which shares it: agreement there checks the discretisation only"""
    elements: tuple[Element, ...] = ("Hex1", "Hex2")
    """elements of the reduction; none to leave it out"""
    method_points_per_wave: Rising = (3.0, 4.0, 6.0, 8.0)
    """grids of any other of the methods, as lambda_short/dx"""

    @model_validator(mode="after")
    def _two_methods(self) -> Self:
        if set(self.methods) <= {"bem"}:
            raise wrong("methods = bem: must name another solver beside bem, such as fem or tamaas")
        return self

    @classmethod
    def taken(cls, scene: Scene, first: ContactProblem) -> dict[str, Any]:
        """Return the options that a scene says, its Poisson ratio among them."""
        return {**super().taken(scene, first), "poisson": scene.solid.poisson}


def _legs(options: Options) -> Iterator[SolverRequest]:
    if "fem" in options.methods:
        yield options.block("Hex1", options.full_points_per_wave, method="full", name="full Hex1")
        for element in options.elements:
            yield options.block(element, options.reduced_points_per_wave, name=f"reduced {element}")
    yield from options.others(options.method_points_per_wave)


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press the same heights by both methods.

    Differences (leg, points_per_wave, surface), their means, and the order in dx of that of the pressure.
    """
    cases = {
        (leg.name, options.first.points_per_wave(grid), k): leg.beside_bem(
            problem, grid, effects=options.effects
        )
        for leg in _legs(options)
        for grid in leg.grids
        for k, problem in enumerate(options.pressed)
    }
    along = ("points_per_wave", "surface")
    data = gathered(bench, cases, lambda d, _: read_off(d, **_READ), "leg", *along).sortby("points_per_wave")
    data = mean(reduce(reduce(data, "max", "residual"), "mean", "seconds", "seconds_bem"), *_COMPARED)
    data = power_law(data, "exponent", of="pressure_difference_each", x="points_per_wave", along=along)
    data = derive(data, order="-exponent", area_difference_size="abs(area_difference)")
    solver = [other.method for other in options.others((), without=("bem",))]
    cited = ["bem", *solver, *(effect.kind for effect in options.effects), "perimeter"]
    return data.assign_attrs(reduced_pressure=options.reduced_pressure, methods=" ".join(cited))


#: What is averaged over the surfaces.
_COMPARED = (
    *("pressure_difference", "pressure_difference_inside"),
    *("area_difference", "area_difference_perimeter", "gap_difference"),
)


#: What is read off every solve.
_READ = {
    "pressure_difference_each": "pressure_half_space",
    "pressure_difference_inside_each": "pressure_inside",
    "area_difference_each": "pixel / pixel_bem - 1",
    "area_difference_perimeter_each": "perimeter / perimeter_bem - 1",
    "gap_difference_each": "gap",
    **{f"{name}_each": name for name in ("residual", "converged", "seconds", "seconds_bem")},
}


def views(data: xr.Dataset) -> Views:
    """Differences against the grid, leg by leg, and whether they vanish with it."""
    legs = []
    for here in each(data, "leg"):
        there = np.flatnonzero(np.isfinite(here.pressure_difference.values))
        coarse, fine = (here.isel(points_per_wave=int(there[j])) for j in (0, -1))
        legs.append(
            finding(
                "trend",
                "{leg}: from {coarse} to {points_per_wave} points per shortest wave the difference of pressure to "
                "boundary elements {verdict} from {first:%} to {pressure_difference:%}, fitted order in dx {order}; "
                "the counted areas differ by {area_difference:%} on the finest grid.",
                fine,
                by="exponent",
                coarse=coarse.points_per_wave,
                first=coarse.pressure_difference,
            )
        )
    missed = int((data.converged_each < 1).sum())
    if missed:
        legs.append(
            finding(
                "refusal",
                "{missed} of {all} answers do not have the residuals asked for, the worst {worst}.",
                missed=missed,
                all=data.converged_each.notnull().sum(),
                worst=data.residual_each.max(),
            )
        )
    elif any(str(leg).startswith("full") for leg in data.leg.values):
        shared = "The full system shares no contact algorithm with the boundary elements: where its difference falls "
        shared += (
            "with the grid, that verifies both. The reduced one shares it and verifies the discretisation."
        )
        legs.append(note(shared))
    panels = [
        against("points_per_wave", name, by="leg", log="xy")
        for name in ("pressure_difference", "area_difference_size")
    ]
    return Views(
        table=Table(
            ("leg", "points_per_wave"),
            ("leg", "points_per_wave", *_COMPARED, "residual", "seconds", "seconds_bem"),
        ),
        figures=[
            Figure(
                "fem-against-bem",
                "Pressure (left) and counted area (right) of other methods beside boundary elements on the "
                "same surfaces and points.",
                panels,
            )
        ],
        findings=legs[:6],
    )
