"""Contact areas of many surfaces of one spectrum, each with its mirror image -h, as one unit of work."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from fem_contact.area import TRAITS, ContactAreas
from fem_contact.extrapolation import Limit
from validation.arrays import Array, Grid
from validation.execution.measurement import Call, measurement
from validation.execution.press import Press
from validation.execution.solve import Prediction
from validation.measurements.control_variates import statistics_of_pair
from validation.measurements.measurement import areas_of_solve, areas_read, limit_over, stored_areas
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import EffectSpec

#: What is read off every solve; the located area is NaN where edges cannot be located.
_READ = ("pixel", "perimeter", "subcell", "edge_fraction", "seconds", "peak_bytes", *TRAITS)


def _press(grid: Grid, problem: ContactProblem, tolerance: float, effects: tuple[EffectSpec, ...]) -> Press:
    settings = (("tolerance", tolerance),)
    return Press(method="bem", grid=grid, problem=problem, settings=settings, effects=effects)


def _predicted(
    problem: ContactProblem,
    grids: tuple[Grid, ...],
    count: int,
    tolerance: float,
    effects: tuple[EffectSpec, ...],
    pair_seconds: float,
) -> Prediction:
    costs = [_press(grid, problem, tolerance, effects).predict(pair_seconds=pair_seconds) for grid in grids]
    return Prediction(
        seconds=2 * count * sum(cost.seconds for cost in costs),
        peak_bytes=max(cost.peak_bytes for cost in costs),
        unknowns=max(cost.unknowns for cost in costs),
    )


@measurement(
    "pairs-{size}",
    kind="AreaPairs",
    words="{count} pairs of surfaces, to",
    located=True,
    recipe=lambda made, problem, first: made | problem.further(first).recipe,
    left_out=("first",),
    predict=_predicted,
    compiled=lambda tolerance, effects: (("bem", {"tolerance": tolerance}, effects),),
)
def area_pairs(
    *,
    problem: ContactProblem,
    grids: tuple[Grid, ...],
    first: int,
    count: int,
    tolerance: float = 1e-6,
    effects: tuple[EffectSpec, ...] = (),
) -> xr.Dataset:
    """Press `count` pairs +h, -h from the first realisation on, on ascending grids.

    What is read off (quantity, pair, sign, grid), and on a single grid the statistics of each pair. Each
    meets the load as a scene says it. With effects, edges are not located, and the corrected area stands
    for the area.
    """

    def read_off(grid: Grid, surface: ContactProblem) -> tuple[float, ...]:
        began = time.process_time()
        solve = _press(grid, surface, tolerance, effects)
        result = solve.do(threads=1).contact
        numbers = areas_read(areas_of_solve(solve, result)) | {"peak_bytes": result.cost.peak_bytes}
        numbers["seconds"] = time.process_time() - began
        return tuple(numbers[name] for name in _READ)

    read = np.empty((len(_READ), count, 2, len(grids)))
    statistics: list[dict[str, float]] = []
    for k in range(count):
        drawn = problem.further(first + k)
        for sign, surface in enumerate((drawn, replace(drawn, inverted=not drawn.inverted))):
            for i, grid in enumerate(grids):
                read[:, k, sign, i] = read_off(grid, surface)
        if len(grids) == 1:
            statistics.append(statistics_of_pair(drawn.heights(grids[0])))
    data: dict[str, Any] = {"read": (("quantity", "pair", "sign", "grid"), read)}
    if statistics:
        data["value"] = (("pair", "statistic"), [list(row.values()) for row in statistics])
    return xr.Dataset(data)


@dataclass(frozen=True, kw_only=True)
class Areas:
    """What `area_pairs` read off, of surfaces that end with the same grid."""

    grids: tuple[Grid, ...]
    lengths: tuple[float, float]  # Periods [m]
    read: Array  # (quantity, surface, grid): Both signs of each pair, one after the other

    def on_grid(self, grid: int) -> Array:
        """Return A/A0 on one grid, (surface,): located where edges are, else corrected."""
        perimeter, subcell = self.read[1, :, grid], self.read[2, :, grid]
        return np.where(np.isnan(subcell), perimeter, subcell)

    def limits(self, last: int) -> list[Limit]:
        """Return the limit of each surface over the grids up to one."""
        return [
            limit_over([self._areas(k, grid) for grid in range(last + 1)]) for k in range(self.read.shape[1])
        ]

    @property
    def seconds(self) -> Array:
        """Processor time of each surface, on all grids."""
        return np.asarray(self.read[4].sum(axis=1))

    @property
    def peak_bytes(self) -> int:
        """Largest memory of the arrays of any solve."""
        return int(self.read[5].max())

    def _areas(self, surface: int, grid: int) -> ContactAreas:
        numbers = dict(zip(_READ, self.read[:, surface, grid], strict=True))
        return stored_areas(numbers, grid=self.grids[grid], lengths=self.lengths)

    @classmethod
    def joined(cls, case: Call, parts: list[xr.Dataset]) -> Areas:
        """Put together what several calls of one kind have read."""
        read = np.concatenate([part.read.values for part in parts], axis=1)
        flat = read.reshape(len(_READ), -1, len(case["grids"]))
        return cls(grids=case["grids"], lengths=case["problem"].lengths, read=flat)
