"""What is read off one solve of a scene."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray as xr

from fem_contact.area import ContactAreas
from fem_contact.contact import ContactResult
from fem_contact.stress import density_at_zero
from validation.arrays import Grid
from validation.effects.base import Effect
from validation.execution.press import Contacts, Press
from validation.measurements.measurement import areas_of_solve
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import Scene

#: What is compared of two methods on one grid.
DIFFERENCES = ("pressure_difference", "area_pixel_difference", "area_perimeter_difference")


def is_adhesive(effects: Sequence[Effect]) -> bool:
    """Whether one of the effects is a gap law."""
    return any(effect.slot == "gap law" for effect in effects)


def grid_name(grid: Grid) -> str:
    """Name a grid as tables and coordinates do."""
    return f"{grid[0]} x {grid[1]}"


def own_solves(scene: Scene, solves: Iterable[Press]) -> list[Press]:
    """Return the solves of the scene's own surface, on the grids that its methods list."""
    first = [solve for solve in solves if solve.problem.realisation == 0 and not solve.problem.variation]
    return [solve for solve in first if solve.grid in scene.methods.options(solve.method).grids]


@dataclass(frozen=True, kw_only=True)
class Reading:
    """What is read off one solve, so that its fields are let go."""

    solve: Press
    areas: ContactAreas
    numbers: xr.Dataset

    @classmethod
    def of(cls, solve: Press, result: ContactResult) -> Reading:
        """Read a result."""
        areas = areas_of_solve(solve, result)
        at_bound = result.at_bound if result.weights is None else result.weights * result.at_bound
        numbers = xr.Dataset(
            {
                "solve": solve.key,
                "area_pixel_shift": ((), areas.pixel, {"reduction": "field", "of": "pixel"}),
                "area_perimeter_shift": ((), areas.perimeter, {"reduction": "field", "of": "perimeter"}),
                "area_located_shift": areas.subcell or math.nan,
                "mean_pressure": result.mean_pressure,
                "surface_modulus": result.contact_modulus,
                "density_at_zero": _density(solve, result),
                "plastic": float(np.mean(at_bound)),
                "residual": result.residuals.worst,
                "seconds": result.cost.wall_seconds,
                "unknowns": result.cost.unknowns,
            }
        )
        return cls(solve=solve, areas=areas, numbers=numbers)


def _density(solve: Press, result: ContactResult) -> float:
    """P(0+) E* h'_rms; none with adhesion, whose tension a window from zero on would hold, nor of a patch.

    What of the gradient of a patch is its roughness, and what its shape, the fields do not tell.
    """
    if is_adhesive(solve.effects) or not result.periodic:
        return math.nan
    density = density_at_zero(result)
    # A window that reaches up to the hardness sees what has yielded.
    clipped = np.any(result.at_bound & (result.pressure < density.threshold))
    return math.nan if clipped else density.reduced * (solve.problem.contact_modulus / result.contact_modulus)


@dataclass(frozen=True, kw_only=True)
class Case:
    """A scene with its solves, what was read of each, and of others why they failed."""

    scene: Scene
    problem: ContactProblem
    results: Contacts
    readings: Mapping[Press, Reading]
    failures: Mapping[Press, str]

    @cached_property
    def own(self) -> list[Reading]:
        """What was read of the scene's own surface, on the grids that its methods list."""
        return [self.readings[solve] for solve in own_solves(self.scene, self.readings)]

    def ladder(self, method: str) -> list[Press]:
        """Return the solves of a method, unshifted, coarse to fine: the resolved ones, if there are any."""
        listed = [r.solve for r in self.own if r.solve.method == method and r.solve.is_own]
        resolved = [solve for solve in listed if self.problem.resolved_by(solve.grid)]
        return sorted(resolved or listed, key=lambda solve: self.problem.points_per_wave(solve.grid))

    @cached_property
    def surfaces(self) -> dict[int, dict[Grid, Reading]]:
        """What was read of each surface of the ensemble, by grid; nothing without one."""
        ensemble, solver = self.scene.ensemble, self.scene.ensemble_solver
        if ensemble is None or solver is None:
            return {}
        surfaces: dict[int, dict[Grid, Reading]] = {k: {} for k in range(ensemble.realisations)}
        for solve, reading in self.readings.items():
            k, still = solve.problem.realisation, solve.shift == (0.0, 0.0) and not solve.problem.variation
            if solve.method == solver.name and k in surfaces and still:
                surfaces[k][solve.grid] = reading
        return surfaces

    @property
    def methods(self) -> list[str]:
        """Names of the solvers."""
        return list(self.scene.methods.solvers)

    @property
    def surface_modulus(self) -> float:
        """E* [Pa] at the surface: of the coating, where there is one."""
        return float(self.own[0].numbers.surface_modulus)

    @property
    def failed(self) -> str:
        """Why solves failed, in a sentence."""
        first, *others = self.failures.values()
        return f"{first}, and {len(others)} more" if others else first
