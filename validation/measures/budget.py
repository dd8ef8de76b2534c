"""What the choice of grids and the stopping of the solver leave uncertain about the area of one measurement."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from validation.measures.common import LEAST_POINTS_PER_WAVE
from validation.measures.measurement import area_limits

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

__all__ = ["grid_drift", "solver_error"]


def grid_drift(dataset: xr.Dataset) -> NDArray[np.float64]:
    """By how much the limit of one measurement moves without its coarsest resolved grid, for each load; signed.

    The order of a fit is a systematic error: it does not average out over surfaces, and its sign is kept so that what does
    may. It is 0 where too few grids are resolved to leave one out.
    """
    resolved = np.flatnonzero(dataset.points_per_wave.values >= LEAST_POINTS_PER_WAVE * (1 - 1e-9))
    if resolved.size < 3 or (resolved.size - 1) * dataset.sizes["shift"] < 3:
        return np.zeros(dataset.sizes["load"])
    whole, _ = area_limits(dataset.isel(grid=resolved))
    finer, _ = area_limits(dataset.isel(grid=resolved[1:]))
    return np.asarray(finer - whole)


def solver_error(usual: xr.Dataset, strict: xr.Dataset) -> float:
    """Relative change of the limits of one surface when the residual of its solves is made smaller; the largest load counts.

    Less than one contact point on the finest grid cannot be seen, and counts as one.
    """
    first, second = area_limits(usual)[0], area_limits(strict)[0]
    one = 1 / float(usual.cells[-1]) / usual.sizes["shift"]
    return float(np.max(np.maximum(np.abs(first - second), one) / second))
