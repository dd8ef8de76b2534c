"""Hyun's protocol: roughness down to the grid scale, contact nodes counted, slope measured in three ways."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

import numpy as np
import xarray as xr

from fem_contact.area import contact_areas
from fem_contact.surface import HeightField
from validation.arrays import Array, Grid
from validation.effects.base import ContactModel
from validation.execution.measurement import measurement
from validation.execution.solve import Prediction
from validation.measurements.common import reduced_load
from validation.scenes.problem import ContactProblem
from validation.scenes.tables import SelfAffineSurface
from validation.solvers import find_solver


def _recipe(made: dict[str, Any], method: str) -> dict[str, Any]:
    made = {name: value for name, value in made.items() if (name, value) != ("method", "bem")}
    return made | {"surface": {n: v for n, v in made["surface"].items() if n != "lambda_short"}}


def _predicted(points: int, method: str) -> Prediction:
    """Such roughness converges slowly; a block has some fifty unknowns below each of its points."""
    seconds, size = (1.2e-4, 2500) if method == "fem" else (4e-6, 120)
    return Prediction(seconds=2e-3 + seconds * points, peak_bytes=size * points, unknowns=points)


@measurement(
    "grid-roughness-{size}",
    kind="GridRoughness",
    words="roughness to the grid scale,",
    recipe=_recipe,
    predict=_predicted,
)
def grid_roughness(
    *, problem: ContactProblem, grid: Grid, method: Literal["bem", "fem"] = "bem"
) -> xr.Dataset:
    """Continue the waves of a surface with its power law to the shortest a grid can carry, and press them on that grid.

    The surface gives H, lambda_long, period and seed; its lambda_short is replaced by two spacings. The reduced
    pressure is that of the spectral slope. Returns kappa for the three slopes, by boundary elements or, as Hyun et al.
    had them, by a whole block of finite elements one period deep.
    """
    field, modulus = down_to_grid(problem, grid[0]).heights(grid), problem.contact_modulus
    slopes = rms_slopes(field)
    pressure = reduced_load(problem) * modulus * slopes["spectral"]
    result = find_solver(method).pressed(field, ContactModel(solid=problem.elastic), pressure).checked()
    pixel = contact_areas(result).pixel
    kappa = [pixel * modulus * slope / pressure for slope in slopes.values()]
    return xr.Dataset(
        {"kappa": ("slope", kappa), "pixel": pixel, "seconds": result.cost.wall_seconds},
        coords={"slope": list(slopes)},
    )


def down_to_grid(problem: ContactProblem, points: int) -> ContactProblem:
    """Continue the waves of a surface to the shortest that so many points along a side carry."""
    surface = problem.surface
    assert isinstance(surface, SelfAffineSurface)
    # The Nyquist wave itself has no phase on the grid: stop one wave short of it.
    shortest = surface.length[0] / (points // 2 - 1)
    return replace(problem, surface=surface.model_copy(update={"lambda_short": shortest}))


def rms_slopes(field: HeightField) -> dict[str, float]:
    """Root mean square gradient by spectral, forward and central differences.

    >>> x = np.arange(64) / 64
    >>> wave = HeightField(heights=np.cos(2 * np.pi * x)[:, None] * np.ones(4), lengths=(1.0, 1.0))
    >>> [round(slope / wave.rms_gradient, 4) for slope in rms_slopes(wave).values()]
    [1.0, 0.9996, 0.9984]
    """
    back = {"forward": 0, "central": 1}
    differences = {name: float(np.sqrt(squared_gradient(field, k).mean())) for name, k in back.items()}
    return {"spectral": field.rms_gradient} | differences


def squared_gradient(field: HeightField, back: int) -> Array:
    """|grad h|^2 from the next point and that so many steps back."""
    h = field.heights
    along = [
        (np.roll(h, -1, k) - np.roll(h, back, k)) / ((1 + back) * d) for k, d in enumerate(field.spacing)
    ]
    return along[0] ** 2 + along[1] ** 2
