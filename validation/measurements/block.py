"""One finite-element solve beside the boundary elements on the same points, reduced to numbers."""

from __future__ import annotations

from typing import Any, Literal

import xarray as xr

from fem_contact.area import contact_areas
from validation.arrays import Grid
from validation.execution.measurement import measurement
from validation.execution.solve import Prediction
from validation.measurements.by_solver import compared, difference
from validation.scenes.problem import ContactProblem


def _predicted(
    points: int, problem: ContactProblem, grid: Grid, method: str, element: str, depth: float, growth: float
) -> Prediction:
    from fem_contact.block import estimate

    mesh: Any = {"depth": depth, "growth": growth, "element": element, "method": method}
    lengths = problem.lengths
    sides = (lengths[0] / max(lengths), lengths[1] / max(lengths))
    size = estimate(grid, sides, poisson=problem.solid.poisson, **mesh)
    if method == "full":
        return Prediction(seconds=3e-6 * size.unknowns, peak_bytes=size.bytes, unknowns=size.unknowns)
    return Prediction(seconds=0.3 + 8e-6 * points, peak_bytes=400 * points, unknowns=size.unknowns)


@measurement(
    "block-{method}-{size}",
    kind="BlockMeasurement",
    words="FEM {method} {element}",
    version=2,
    predict=_predicted,
)
def block_beside_bem(
    *,
    problem: ContactProblem,
    grid: Grid,
    method: Literal["full", "reduced"] = "reduced",
    element: str = "Hex1",
    depth: float = 1.0,
    growth: float = 1.2,
    tolerance: float | None = None,
) -> xr.Dataset:
    """Press a block of finite elements, the half-space, and the bonded layer as deep as the block.

    Areas, gaps and pressure differences of the three solves (`compared`). The method "full" is the whole
    system, which shares no contact algorithm with the boundary elements, "reduced" its exact reduction;
    `depth` is in periods.
    """
    from fem_contact import bem, block
    from fem_contact.response import BondedLayer, HalfSpace

    solid, field, pressure = problem.elastic, problem.heights(grid), problem.pressure
    thickness = depth * max(problem.lengths)
    settings: dict[str, Any] = {} if tolerance is None else {"tolerance": tolerance}
    settings |= {"method": method, "element": element, "depth": thickness, "growth": growth}
    fem = block.solve(field, solid, mean_pressure=pressure, **settings).contact.checked()
    half, layer = (
        bem.solve(field, response, mean_pressure=pressure, threads=1).checked()
        for response in (HalfSpace(solid=solid), BondedLayer(solid=solid, thickness=thickness))
    )
    constant, height = block.ELEMENTS[element].edge_constant, problem.field.rms_height
    data = {
        **compared(fem, half, edge_constant=constant, rms_height=height),
        "pixel_layer": contact_areas(layer).pixel,
        "pressure_layer": difference(fem, layer),
    }
    return xr.Dataset({name: ((), float(value)) for name, value in data.items()})
