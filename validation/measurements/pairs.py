"""Contact areas of many surfaces of one spectrum, each with its mirror image -h, as one unit of work."""

from __future__ import annotations

import itertools
import time
from dataclasses import replace

import xarray as xr

from validation.arrays import Grid
from validation.execution.measurement import measurement
from validation.execution.solve import PAIR_SECONDS, Prediction
from validation.measurements.measurement import press_on_grids
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import EffectSpec


def _predicted(
    problem: ContactProblem,
    grids: tuple[Grid, ...],
    count: int,
    effects: tuple[EffectSpec, ...],
    pair_seconds: float,
) -> Prediction:
    surface = press_on_grids(problem=problem, grids=grids, effects=effects, shifts=1).predict()
    return replace(surface, seconds=2 * count * surface.seconds * pair_seconds / PAIR_SECONDS)


@measurement(
    "pairs-{size}",
    kind="AreaPairs",
    words="{count} pairs of surfaces, to",
    located=True,
    version=1,
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
    tolerance: float,
    effects: tuple[EffectSpec, ...],
) -> xr.Dataset:
    """Press `count` pairs +h, -h from the first realisation on, one sign after the other, on ascending grids.

    What `press_on_grids` keeps of each, with surfaces in the place of loads, and the processor time of each
    on all grids (load). Each meets the load as a scene says it. With effects, edges are not located, and the
    corrected area stands for the area.
    """
    made = []
    for k, mirrored in itertools.product(range(first, first + count), (False, True)):
        drawn, began = problem.further(k), time.process_time()
        surface = replace(drawn, inverted=drawn.inverted != mirrored)
        areas = press_on_grids(
            problem=surface, grids=grids, effects=effects, shifts=1, tolerance=tolerance
        ).do()
        made.append(areas.assign(seconds=("load", [time.process_time() - began])))
    return xr.concat(made, "load", combine_attrs="drop")
