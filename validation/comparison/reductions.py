"""What is read off one solve of a scene."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from fem_contact.area import ContactAreas, contact_areas
from fem_contact.contact import ContactResult
from fem_contact.errors import InvalidInput
from fem_contact.stress import density_at_zero
from validation.arrays import Array
from validation.effects.base import Effect
from validation.execution.press import Press
from validation.scenes.scene import Scene


def is_adhesive(effects: Sequence[Effect]) -> bool:
    """Whether one of the effects is a gap law."""
    return any(effect.slot == "gap law" for effect in effects)


def grid_name(grid: tuple[int, int]) -> str:
    """Name a grid as tables and coordinates do."""
    return f"{grid[0]} x {grid[1]}"


def own_solves(scene: Scene, solves: Iterable[Press]) -> list[Press]:
    """Return the solves of the scene's own surface, on the grids that its methods list."""
    first = [solve for solve in solves if solve.realisation == 0 and not solve.problem.variation]
    return [solve for solve in first if solve.grid in scene.methods.options(solve.method).grids]


@dataclass(frozen=True, kw_only=True)
class Reading:
    """What is read off one solve, so that fields are read once and let go; `pressure` where compared."""

    solve: Press
    areas: ContactAreas
    numbers: xr.Dataset
    contact_modulus: float
    mean_pressure: float
    pressure: Array | None = None

    @classmethod
    def of(cls, solve: Press, result: ContactResult, *, bare: bool, shown: bool) -> Reading:
        """Read a result; edges are located on the bare half-space with square cells."""
        solver, (dx, dy) = solve.solver, result.spacing
        located = solver.locates_edges and bare and abs(dx / dy - 1) <= 0.05
        at_bound = result.at_bound if result.weights is None else result.weights * result.at_bound
        areas = contact_areas(result, edge_constant=solver.edge_constant(result), subcell=located)
        numbers = xr.Dataset(
            {
                "solve": solve.key,
                "area_pixel_shift": areas.pixel,
                "area_perimeter_shift": areas.perimeter,
                "area_located_shift": areas.subcell or math.nan,
                "mean_pressure": result.mean_pressure,
                "density_at_zero": _density(result, adhesive=is_adhesive(solve.effects)),
                "plastic": float(np.mean(at_bound)),
                "residual": result.residuals.worst,
                "seconds": result.cost.wall_seconds,
                "unknowns": result.cost.unknowns,
            }
        )
        return cls(
            solve=solve,
            areas=areas,
            numbers=numbers,
            contact_modulus=result.contact_modulus,
            mean_pressure=result.mean_pressure,
            pressure=result.pressure if shown and solve.is_own else None,
        )


def _density(result: ContactResult, *, adhesive: bool) -> float:
    """P(0+) E* h'_rms; none with adhesion, whose tension a window from zero on would hold."""
    if adhesive:
        return math.nan
    try:
        density = density_at_zero(result)
    except InvalidInput:  # a flat surface has no scale of pressure
        return math.nan
    # A window that reaches up to the hardness sees what has yielded.
    clipped = np.any(result.at_bound & (result.pressure < density.threshold))
    return math.nan if clipped else density.reduced
