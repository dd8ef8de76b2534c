"""One surface at rest on rubber, held and then partly unloaded, on several grids: areas over time, and what the theory says."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from fem_contact.area import contact_areas
from fem_contact.creeping import creep
from fem_contact.solid import Solid
from fem_contact.viscoelastic import PronySolid
from persson import elastic
from validation.arrays import Array, Grid
from validation.execution.measurement import Call, measurement
from validation.measurements.limits import ABSENT
from validation.measurements.measurement import press_elastic
from validation.measurements.theory import variant_areas
from validation.report.estimates import error_of
from validation.scenes.problem import ContactProblem

#: What happens, one after the other.
PHASES = ("held", "unloaded")


@measurement(
    "creep-{size}",
    kind="CreepSolve",
    words="creep, to",
    # Some fifteen pairs of transforms for each step.
    seconds=lambda grids, durations, steps: (
        2 * len(durations) * (steps + 1) * sum(0.002 + 1e-6 * nx * ny for nx, ny in grids)
    ),
    bytes=2500,
)
def creeps(
    *,
    problem: ContactProblem,
    rubber: PronySolid,
    durations: tuple[float, ...],
    load_left: float,
    steps: int,
    grids: tuple[Grid, ...],
) -> xr.Dataset:
    """Hold one surface under its load, then under a share of it, to rising times after each change [s].

    A/A0 corrected at its edge over (grid, phase, instant), also of the elastic contact with E = 1/J(t) under the load of
    that time.
    """
    shape = (len(grids), len(PHASES), len(durations))
    areas, crept = np.empty(shape), np.empty(shape)
    moduli = moduli_of(rubber, np.array(durations))
    parts = np.concatenate([[0.0], durations])
    path = np.interp(np.arange(len(durations) * steps + 1) / steps, np.arange(parts.size), parts)
    times = np.concatenate([path, path[-1] + path])
    loads = problem.pressure * np.repeat([1.0, load_left], path.size)
    # Where the durations end on the path.
    at = steps * np.arange(1, parts.size) + path.size * np.arange(2)[:, None]
    for i, grid in enumerate(grids):
        field = problem.heights(grid)
        results = creep(field, rubber, times=times, mean_pressure=loads, threads=1)
        for place, k in np.ndenumerate(at):
            areas[(i, *place)] = contact_areas(results[k].checked()).perimeter
            relaxed = Solid(young=float(moduli[place]), poisson=rubber.poisson)
            crept[(i, *place)] = contact_areas(press_elastic(field, relaxed, float(loads[k]))).perimeter
    dims = ("grid", "phase", "instant")
    return xr.Dataset({"area": (dims, areas), "area_crept": (dims, crept)})


def crept_of(measured: xr.Dataset, solve: Call) -> xr.Dataset:
    """Reduce what one of `creeps` left to (phase, instant) on its finest grid, its step from the grid before, and theory.

    Held, both contacts are one: the most that they differ by is the error of the steps in time.
    """
    fine, before = (measured.isel(grid=k) for k in (-1, -2))
    numbers: dict[str, Any] = {f"{name}_each": fine[name] for name in measured.data_vars}
    numbers |= {f"{name}_each_drift": fine[name] - before[name] for name in measured.data_vars}
    steps = abs(fine.area - fine.area_crept).isel(phase=0, drop=True).max("instant")
    numbers["area_each_error"] = error_of(fine.area, grid=0.0, solver=steps, **ABSENT)
    theory = _theory(solve["problem"], solve["rubber"], np.array(solve["durations"]), solve["load_left"])
    numbers |= {f"{name}_each": (("phase", "instant"), area) for name, area in theory.items()}
    return xr.Dataset(numbers)


def moduli_of(rubber: PronySolid, durations: Array) -> Array:
    """1/J [Pa] at the times after each change, (phase, instant)."""
    return 1 / rubber.creep_compliance(np.array([durations, durations[-1] + durations]))


def _theory(
    problem: ContactProblem, rubber: PronySolid, durations: Array, load_left: float
) -> dict[str, Array]:
    """A/A0 by every variant, (phase, instant), with E = 1/J(t) and the realised gradient."""
    moduli = moduli_of(rubber, durations) / (1 - rubber.poisson**2)
    variance = elastic.stress_variance(problem.field.rms_gradient**2, contact_modulus=1.0) * moduli**2
    return variant_areas(problem.pressure * np.array([[1.0], [load_left]]), stress_variance=variance)
