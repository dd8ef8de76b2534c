"""How a surface's heights are distributed, and its contact area under given loads."""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy.special import ndtr

from validation.arrays import Grid
from validation.execution.measurement import measurement
from validation.measurements.flow import located_area
from validation.measurements.measurement import elastic_path
from validation.scenes.problem import ContactProblem

#: Edges of the bins of h/h_rms.
HEIGHT_EDGES = np.linspace(-4.0, 4.0, 65)


@measurement(
    "heights-{size}",
    kind="HeightStatistics",
    words="heights",
    located=True,
    version=2,
    left_out=("load",),
    seconds=lambda points, pressures: 1e-2 + len(pressures) * (2e-3 + 8e-7 * points),
    bytes=200,
)
def height_statistics(
    *, problem: ContactProblem, grid: Grid, pressures: tuple[float, ...] = ()
) -> xr.Dataset:
    """Return how the heights of one surface are distributed, over the realised rms height, and its contact area.

    `pressures` are rising p0 [Pa]; none for the heights alone.
    """
    field = problem.heights(grid)
    areas = [located_area(solved) for solved in elastic_path(field, problem.elastic, pressures)]
    z = np.sort(field.heights.ravel() / problem.field.rms_height)
    share = (np.arange(z.size) + 0.5) / z.size
    density = np.histogram(z, bins=HEIGHT_EDGES)[0] / (z.size * np.diff(HEIGHT_EDGES))
    return xr.Dataset(
        {
            "height_density_each": ("bin", density),
            "area_each": ("load", areas),
            "skewness_each": float(np.mean(z**3)),
            "excess_kurtosis_each": float(np.mean(z**4) - 3),
            "height_distance_each": float(np.max(np.abs(ndtr(z) - share))),
            "highest_each": float(z[-1]),
            "rms_height_each": problem.field.rms_height,
            "rms_gradient_each": problem.field.rms_gradient,
        }
    )
