"""How does a contact at rest on rubber grow in time, and how long does it remember a load that was taken off?

Held under a load, a contact only grows, and its area is that of an elastic solid with E = 1/J(t): exactly, so that the theory
needs no more than that modulus. When a part of the load is taken off, the solid remembers, and nothing simple holds.
"""

from typing import Annotated, Any

import numpy as np
import xarray as xr
from pydantic import AfterValidator, Field

from fem_contact.area import contact_areas
from fem_contact.creeping import creep
from fem_contact.solid import Solid
from fem_contact.viscoelastic import PronySolid
from persson import elastic
from validation.arrays import Array, Grid
from validation.measurements.common import in_rising_order
from validation.measurements.measurement import press_elastic
from validation.measurements.theory import RANKED, VARIANTS, variant_areas
from validation.report.estimates import derive, error_of, mean, same_of_all
from validation.report.places import spread
from validation.report.views import Figure, Findings, Table, Views, against, finding
from validation.scenes.problem import ContactProblem
from validation.studies._rubber import RubberOptions
from validation.studies._study import ABSENT, Bench, Call, gathered, measurement
from validation.units import Duration

_Durations = Annotated[tuple[Duration, ...], Field(min_length=1), AfterValidator(in_rising_order)]


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

    The theory is told E = 1/J(t) and the realised gradient. Held, both contacts are one: the most that they differ by is the error of the steps in time.
    """
    fine, before = (measured.isel(grid=k) for k in (-1, -2))
    numbers: dict[str, Any] = {f"{name}_each": fine[name] for name in measured.data_vars}
    numbers |= {f"{name}_each_drift": fine[name] - before[name] for name in measured.data_vars}
    steps = abs(fine.area - fine.area_crept).isel(phase=0, drop=True).max("instant")
    numbers["area_each_error"] = error_of(fine.area, grid=0.0, solver=steps, **ABSENT)
    problem, rubber = solve["problem"], solve["rubber"]
    moduli = moduli_of(rubber, np.array(solve["durations"])) / (1 - rubber.poisson**2)
    variance = elastic.stress_variance(problem.field.rms_gradient**2, contact_modulus=1.0) * moduli**2
    loads = problem.pressure * np.array([[1.0], [solve["load_left"]]])
    theory = variant_areas(loads, stress_variance=variance)
    return xr.Dataset(numbers | {f"{n}_each": (("phase", "instant"), area) for n, area in theory.items()})


def moduli_of(rubber: PronySolid, durations: Array) -> Array:
    """1/J [Pa] at the times after each change, (phase, instant)."""
    return 1 / rubber.creep_compliance(np.array([durations, durations[-1] + durations]))


class Options(RubberOptions):
    """What is held, how long, on what, and how much of the load is left after that."""

    durations: _Durations = (1e-5, 3e-5, 1e-4, 3e-4, 1e-3)
    """times after the load is put on, and after a part of it is taken off, rising"""
    load_left: float = Field(default=0.5, gt=0, le=1)
    """share of the load that is left when the last of these times is over"""
    steps: int = Field(default=8, ge=1)
    """steps of the solver from one time to the next"""


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Hold every surface, take off a part of its load, and hold it again.

    Over (phase, instant): A/A0, that of the elastic contact with E = 1/J(t) under the same load, and the theory's.
    """
    rubber, durations = options.prony(), np.array(options.durations)
    history = options.model_dump(include={"durations", "load_left", "steps"})
    surface = options.self_affine()
    cases = options.cases(creeps, surface, rubber=rubber, relaxed=rubber.relaxed, **history)
    data = gathered(bench, cases, crept_of, "surface")
    data = data.assign_coords(phase=list(PHASES), duration=("instant", durations))
    data["creep_modulus"] = ("phase", "instant"), moduli_of(rubber, durations) / rubber.relaxed
    data = derive(
        data,
        area_memory_each="area_each / area_crept_each - 1",
        area_excess_each="area_each / area_persson_each - 1",
    )
    data = mean(data, "area", "area_crept", "area_memory", "area_excess")
    data = same_of_all(data, *(f"area_{name}" for name in VARIANTS))
    asked = options.model_dump(include={"load_left", "reduced_pressure"})
    return data.assign_attrs(methods=RANKED, solid=repr(rubber), **asked)


def views(data: xr.Dataset) -> Views:
    """Area over the time in both phases, beside elastic contacts and the theory, and what is remembered."""
    areas = ("area", "area_crept", *(f"area_{name}" for name in VARIANTS))
    columns = ("phase", "duration", "creep_modulus", *areas, "area_memory", "area_excess")
    return Views(
        table=Table(("phase", "instant"), columns),
        budget=("area",),
        figures=[
            Figure(
                "creep",
                "Area of real contact on a viscoelastic half-space over the time since the load was put on (left) "
                f"and since all but {data.attrs['load_left']:g} of it was taken off (middle); what is remembered: the "
                "area over that of an elastic contact with E = 1/J(t) under the load of that time (right).",
                [
                    *(against("duration", *areas, log="x", at={"phase": k}) for k in range(len(PHASES))),
                    against("duration", "area_memory", by="phase", log="x"),
                ],
            )
        ],
        findings=[*_findings(data)],
    )


def _findings(data: xr.Dataset) -> Findings:
    held, unloaded = (data.isel(phase=k) for k in range(2))
    some = spread(data, "instant")
    form = "Held, A/A0 is {each}."
    item = "{area} after {duration:u}"
    yield finding("value", form, held.isel(instant=some), item=item)
    form = "Held, it is {each}."
    item = "{verdict} Persson's {area_persson:~} with E = 1/J = {creep_modulus:~} E_0, by {area_excess:%}"
    yield finding("comparison", form, held.isel(instant=some), item=item, by="area_excess")
    yield finding(
        "comparison",
        "With {load_left} of the load left, A/A0 beside a solid that never carried more is {each}.",
        unloaded.isel(instant=some),
        item="{area} after {duration:u} ({verdict} it, by {area_memory:%})",
        by="area_memory",
    )
    form = "Held, the area must be that of the elastic contact with E = 1/J(t); the steps in time miss it by at most "
    form += "{worst:%}."
    yield finding("cost", form, worst=abs(held.area_memory_each).max())
