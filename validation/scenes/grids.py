"""Grids that a method is pressed on where a scene names none: 4, 8 and 16 points on the shortest wave."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError
from scipy.fft import next_fast_len

from validation.arrays import Grid, Pair
from validation.errors import UsageError
from validation.scenes.tables import FileSurface, Surface
from validation.solvers import Solver, methods
from validation.solvers.base import Size

#: Points on the shortest wave of the coarsest usual grid; the others halve its spacing once and twice.
_POINTS = 4
#: What one solve on a usual grid may take: bytes, and pairs of real 256 x 256 transforms, of a millisecond.
_BYTES, _PAIRS = 2 * 2**30, 6e5
#: In place of grids where the surface is refused anyway.
_ANY: list[Any] = [32, 64]


def usual_grids(lengths: Pair, shortest: float) -> tuple[Grid, ...]:
    """Return grids with at least 4, 8 and 16 points on the shortest wave, of sizes that transform quickly."""
    nx, ny = (2 * int(next_fast_len(math.ceil(_POINTS * n / shortest / 2 - 1e-9))) for n in lengths)
    return (nx, ny), (2 * nx, 2 * ny), (4 * nx, 4 * ny)


def affordable(solver: Solver, grid: Grid, *, lengths: Pair, options: Any) -> bool:
    """Whether a solve on a grid is predicted to take at most 2 GiB, and about ten minutes."""
    cost = solver.cost(Size(grid=grid, lengths=lengths, settings=dict(solver.settings(options))))
    return cost.peak_bytes <= _BYTES and cost.pairs <= _PAIRS


def with_usual_grids(data: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the tables of a scene with usual grids for each method that names none, and for its ensemble.

    A method has those that it can afford, the ensemble the first two.

    A UsageError for a method that cannot afford the coarsest.
    """
    filled, tables, ensemble = dict(data), data.get("methods"), data.get("ensemble")
    solvers = {name: method for name, method in methods().items() if isinstance(method, Solver)}
    lacking = {
        name: table
        for name, table in (tables.items() if isinstance(tables, dict) else ())
        if name in solvers and isinstance(table, dict) and "grids" not in table
    }
    alone = isinstance(ensemble, dict) and "grids" not in ensemble
    if not (lacking or alone):
        return filled
    waves = _waves(data.get("surface"), folder)
    usual = usual_grids(**waves) if waves else ()
    if isinstance(ensemble, dict) and alone:
        filled["ensemble"] = {**ensemble, "grids": [list(grid) for grid in usual[:2]] or _ANY}
    for name, table in lacking.items():
        solver, grids = solvers[name], [list(grid) for grid in usual] or _ANY
        with contextlib.suppress(ValidationError):  # which the scene is refused for
            options = solver.options.model_validate({**table, "grids": grids})
            chosen = [
                list(grid)
                for grid in usual
                if affordable(solver, grid, lengths=waves["lengths"], options=options)
            ]
            grids = chosen or _ANY
            if usual and not chosen:
                nx, ny = usual[0]
                raise UsageError(
                    f"methods.{name}.grids: missing; {_POINTS} points on the shortest wave are {nx} x {ny}, "
                    "more than 2 GiB or ten minutes a solve; name grids that you can wait for"
                )
        filled["methods"] = {**filled["methods"], name: {**table, "grids": grids}}
    return filled


def _waves(surface: object, folder: Path) -> dict[str, Any]:
    """Return `lengths` and `shortest` wave of the table of a surface; of a map it is two points at least."""
    try:
        table = TypeAdapter[Any](Surface).validate_python(surface)
    except ValidationError:  # which the scene is refused for
        return {}
    if not isinstance(table, FileSurface):
        return {"lengths": table.length, "shortest": table.lambda_short}
    from validation.scenes.topography.reading import file_says

    points = file_says(folder / table.path).heights.shape
    spacing = (length / n for length, n in zip(table.length, points, strict=True))
    return {"lengths": table.length, "shortest": max(2 * max(spacing), table.lambda_short or 0.0)}
