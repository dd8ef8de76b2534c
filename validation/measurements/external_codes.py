"""Other contact codes, where they are installed: what their contact area costs on the grids of ours."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from dataclasses import replace
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from fem_contact import HalfSpace, bem
from fem_contact.area import EDGE_CONSTANTS, contact_areas
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation import sandbox
from validation.arrays import Array, Grid
from validation.effects.base import ContactModel
from validation.execution.measurement import measurement
from validation.execution.solve import Prediction
from validation.measurements.common import reduced_load
from validation.scenes.problem import ContactProblem
from validation.solvers import chosen_solver, methods
from validation.solvers.base import Claim, Job
from validation.solvers.external import ExternalSolver, verified

#: Part of its grid error that a solver may leave in its area: equal error, not equal residual.
_SOLVER_SHARE = 0.1
_TOLERANCES = tuple(10.0**-k for k in range(2, 12))

#: The package of this project, whose boundary elements are measured as the others are.
THIS_CODE = "fem_contact"


def known_peers() -> dict[str, str]:
    """Return the methods that call another code, by its package."""
    foreign = [method for method in methods().values() if isinstance(method, ExternalSolver)]
    return {method.package: method.name for method in foreign if method.package is not None}


def installed_peers() -> tuple[str, ...]:
    """Name the packages of other codes that are installed."""
    return tuple(code for code, name in known_peers().items() if methods()[name].available() is None)


def code_versions(codes: Sequence[str]) -> str:
    """Say by which versions of the codes, and on which processor, their costs are measured."""
    versions = [f"{code} {_version(code)}" for code in codes]
    return f"{', '.join(versions)}, each on one thread of {_processor()}"


def _version(code: str) -> str:
    return metadata.version("fem-contact" if code == THIS_CODE else code)


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def bem_pressure(
    heights: Array,
    lengths: tuple[float, float],
    *,
    contact_modulus: float,
    mean_pressure: float,
    tolerance: float,
) -> Array:
    """Solve with the boundary elements of this project, called as another code is."""
    half_space = HalfSpace(solid=Solid(young=contact_modulus, poisson=0.0))
    surface = HeightField(heights=heights, lengths=lengths)
    arguments: dict[str, Any] = {"mean_pressure": mean_pressure, "tolerance": tolerance}
    pressure: Array = bem.solve(surface, half_space, threads=1, **arguments).pressure
    return pressure


@measurement(
    "peer-{code}-{size}",
    kind="PeerMeasurement",
    words="{code}",
    located=True,
    recipe=lambda made, code: made | {"version": _version(code), "areas": "pressures of the method"},
    # The interpreter and the libraries it loads take most of the memory.
    predict=lambda points: Prediction(
        seconds=3.0 + 5e-5 * points, peak_bytes=300 * points + 200 * 2**20, unknowns=points
    ),
)
def by_peer(*, code: str, problem: ContactProblem, grid: Grid) -> xr.Dataset:
    """Press one surface at one load on one grid by another code, solved no further than its grid deserves.

    Its areas, seconds of one thread, growth of its memory, and the tolerance it needed. The areas are read off its
    pressures by the code that reads ours, the located one among them.
    """
    field, half_space = problem.heights(grid), HalfSpace(solid=problem.elastic)
    contact = bem.solve(field, half_space, mean_pressure=problem.pressure, threads=1)
    ours = contact_areas(contact.checked())
    # Unit period, gradient and modulus: their tolerances need not be free of units.
    longest = max(problem.lengths)
    heights = field.heights / (longest * problem.field.rms_gradient)
    sides = (problem.lengths[0] / longest, problem.lengths[1] / longest)
    job = Job(
        field=HeightField(heights=heights, lengths=sides),
        load={"mean_pressure": reduced_load(problem)},
        model=ContactModel(solid=Solid(young=1.0, poisson=0.0)),
        threads=1,
    )
    allowed = _SOLVER_SHARE * EDGE_CONSTANTS["bem"] * ours.edge_fraction
    done, claim, error = _solved(code, job, pixel=ours.pixel, allowed=allowed)
    areas = contact_areas(
        verified(claim, done, method=code), edge_constant=EDGE_CONSTANTS["bem"], subcell=True
    )
    numbers = {
        "seconds": claim.cpu_seconds,
        "tolerance": done.settings["tolerance"],
        "solver_error": error,
        "peak_bytes": claim.peak_bytes,
        **{name: getattr(areas, name) for name in ("pixel", "perimeter", "subcell")},
    }
    return xr.Dataset({name: ((), float(value)) for name, value in numbers.items()})


def _solved(code: str, job: Job, *, pixel: float, allowed: float) -> tuple[Job, Claim, float]:
    by = f"{__name__}:{bem_pressure.__name__}" if code == THIS_CODE else known_peers()[code]
    solver, options = chosen_solver(by)
    sandbox.end()  # its memory shall be its own
    solver.warm_up((), {**options, "tolerance": 1e-3})
    most = 0
    for tolerance in _TOLERANCES:
        job = replace(job, settings={**options, "tolerance": tolerance})
        claim = solver.claim(job)
        most = max(most, claim.peak_bytes)
        error = abs(float(np.mean(claim.pressure > 0)) - pixel)
        if error <= allowed:
            break
    return job, replace(claim, peak_bytes=most), error
