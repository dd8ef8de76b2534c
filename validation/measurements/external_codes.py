"""Other contact codes, where they are installed, and ours called as they are."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path

import numpy as np

from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.arrays import Array
from validation.measurements.measurement import press_elastic
from validation.solvers import chosen_solver, methods
from validation.solvers.base import Settings
from validation.solvers.external import ExternalSolver

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
    versions = [f"{code} {metadata.version(code)}" for code in codes]
    return f"{', '.join(versions)}, each on one thread of {_processor()}"


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
    surface, solid = HeightField(heights=heights, lengths=lengths), Solid(young=contact_modulus, poisson=0.0)
    return np.array(press_elastic(surface, solid, mean_pressure, tolerance=tolerance).pressure)


def asked_of(code: str) -> tuple[str, Settings]:
    """Return the method of a code, or of ours as a function, and what tells its version from another."""
    if code == THIS_CODE:
        solver, settings = chosen_solver(f"{__name__}:{bem_pressure.__name__}")
        return solver.name, tuple(settings.items())
    return known_peers()[code], (("version", metadata.version(code)),)
