"""What is read off the solves of a scene, and what passes through its contact and gap, in units."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
import xarray as xr

from fem_contact.area import ContactAreas
from fem_contact.contact import ContactResult
from fem_contact.stress import density_at_zero
from validation.arrays import Grid, Pair
from validation.effects.base import Effect
from validation.errors import RunFailed
from validation.execution.press import Contacts, Press
from validation.measurements.measurement import areas_of_solve
from validation.measurements.statistics import finest_error
from validation.report.estimates import error_of, mean
from validation.report.quantities import as_length
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import Scene
from validation.scenes.tables import Leak

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


def read_off(solve: Press, result: ContactResult) -> tuple[ContactAreas, xr.Dataset]:
    """Return areas and numbers of one solve, whose fields can be let go then."""
    areas = areas_of_solve(solve, result)
    at_bound = result.at_bound if result.weights is None else result.weights * result.at_bound
    numbers = {
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
    return areas, xr.Dataset(numbers)


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
    """A scene with its solves, areas and numbers of each (`read_off`), and of others why they failed."""

    scene: Scene
    problem: ContactProblem
    results: Contacts
    areas: Mapping[Press, ContactAreas]
    numbers: Mapping[Press, xr.Dataset]
    failures: Mapping[Press, str]

    @cached_property
    def own(self) -> list[Press]:
        """Solves of the scene's own surface, on the grids that its methods list."""
        return own_solves(self.scene, self.numbers)

    def ladder(self, method: str) -> list[Press]:
        """Return the solves of a method, unshifted, coarse to fine: the resolved ones, if there are any."""
        listed = [solve for solve in self.own if solve.method == method and solve.is_own]
        resolved = [solve for solve in listed if self.problem.resolved_by(solve.grid)]
        return sorted(resolved or listed, key=lambda solve: self.problem.points_per_wave(solve.grid))

    @cached_property
    def surfaces(self) -> dict[int, dict[Grid, Press]]:
        """Solves of each surface of the ensemble, by grid; nothing without one."""
        ensemble, solver = self.scene.ensemble, self.scene.ensemble_solver
        if ensemble is None or solver is None:
            return {}
        surfaces: dict[int, dict[Grid, Press]] = {k: {} for k in range(ensemble.realisations)}
        for solve in self.numbers:
            k, still = solve.problem.realisation, solve.shift == (0.0, 0.0) and not solve.problem.variation
            if solve.method == solver.name and k in surfaces and still:
                surfaces[k][solve.grid] = solve
        return surfaces

    @property
    def methods(self) -> list[str]:
        """Names of the solvers."""
        return list(self.scene.methods.solvers)

    @property
    def surface_modulus(self) -> float:
        """E* [Pa] at the surface: of the coating, where there is one."""
        return float(self.numbers[self.own[0]].surface_modulus)

    @property
    def failed(self) -> str:
        """Why solves failed, in a sentence."""
        first, *others = self.failures.values()
        return f"{first}, and {len(others)} more" if others else first


def too_far_apart(problem: ContactProblem, *, pulled: float = 0.0) -> RunFailed:
    """Say of a distance that is held that nothing presses there, though a share of the area may be pulled."""
    held = f"load.{problem.load.key} = {as_length(problem.load.values[0])}"
    why = f"{pulled:.2g} of the area touches, and is pulled" if pulled else "nothing touches so far apart"
    return RunFailed(f"{held}: {why}; come closer")


# ---- what passes ---------------------------------------------------------------------------------

_AXES: tuple[Literal["x", "y"], ...] = ("x", "y")
#: What is asked of one solve and its result, and what a theory says of it: value, theory's value.
_Read = Callable[[Press, ContactResult], Pair]


def passing(data: xr.Dataset, case: Case) -> xr.Dataset:
    """Add to the dataset of a scene what its table [quantities] asks for.

    The set of contact is that of the solve, whatever effects made it; the current passes through homogeneous
    half-spaces that touch there, yielded points included. Values are those of the finest grid that resolves
    the surface; with an ensemble means over its surfaces.
    """
    scene, results, quantities = case.scene, case.results, case.scene.quantities
    if quantities is None or not (quantities.electrical or quantities.thermal or quantities.leak):
        return data
    alike = ([s for s in case.ladder(name) if results[s].weights is None] for name in case.methods)
    ladder = next(filter(None, alike), [])
    if not ladder:
        return data.assign(passing_note="not determinable: the points of every method weigh differently")
    spacing = [1 / case.problem.points_per_wave(solve.grid) for solve in ladder]
    finest = scene.ensemble and max(scene.ensemble.grids, key=case.problem.points_per_wave)
    ensemble = [on[finest] for on in case.surfaces.values() if finest in on]
    reads: dict[str, tuple[_Read, str]] = {}
    if quantities.electrical is not None:
        reads["electrical_conductance"] = _conductance(quantities.electrical.resistivity, case), "persson"
    if quantities.thermal is not None:
        first, second = quantities.thermal.conductivity
        reads["thermal_conductance"] = _conductance((1 / first, 1 / second), case), "persson"
    if quantities.leak is not None:
        reads |= {f"leak_rate_{axis}": (_leak(quantities.leak, axis), "bruggeman") for axis in _AXES}
    for name, (read, beside) in reads.items():
        values, theories = zip(*(read(solve, results[solve]) for solve in ladder), strict=True)
        value, theory, half = values[-1], theories[-1], finest_error(values, spacing)
        data[name] = xr.DataArray(value)
        data[f"{name}_error"] = error_of(data[name], grid=half)
        if np.isfinite(theory):
            data[f"{name}_{beside}"] = theory
        if len(ensemble) > 1:
            own, told = zip(*(read(solve, results[solve]) for solve in ensemble), strict=True)
            data[f"{name}_each"] = ("surface", list(own))
            if np.isfinite(theory):
                data[f"{name}_{beside}"] = float(np.mean(told))
            data = mean(data.rename({name: f"{name}_own", f"{name}_error": f"{name}_own_error"}), name)
            share = half / value if value and np.isfinite(value) else np.nan
            errors = data[f"{name}_error"]
            data[f"{name}_error"] = errors.where(errors.source != "grid", share * abs(data[name]))
    return data


def _conductance(resistivities: Pair, case: Case) -> _Read:
    """Conductance per nominal area, by Barber's relation on the set of contact, yielded points included."""
    from fem_contact.conductance import contact_conductance, frozen_contact
    from fem_contact.response import HalfSpace
    from persson.scale import Scale
    from persson.separation import contact_stiffness

    half_space = HalfSpace(solid=case.problem.elastic)
    modulus = half_space.contact_modulus
    per_stiffness = contact_conductance(1.0, contact_modulus=modulus, resistivities=resistivities)

    def read(solve: Press, result: ContactResult) -> Pair:
        theory = math.nan
        if not case.scene.effects:
            scale = Scale(solve.problem.own_spectrum, contact_modulus=modulus)
            theory = per_stiffness * float(contact_stiffness(result.mean_pressure, scale=scale))
        if result.in_contact.all() or not result.in_contact.any():
            return math.inf if result.in_contact.any() else 0.0, theory
        conducting = replace(result, at_bound=np.zeros(result.shape, dtype=bool))
        return per_stiffness * frozen_contact(conducting, half_space).stiffness, theory

    return read


def _leak(leak: Leak, axis: Literal["x", "y"]) -> _Read:
    """Volume per time through one period, along one axis, and what Bruggeman makes of the same gaps."""
    from fem_contact.leak import flow_conductance, open_gap
    from persson.leakage import effective_medium

    def read(solve: Press, result: ContactResult) -> Pair:
        gap = open_gap(result)
        along, across = result.lengths if axis == "x" else result.lengths[::-1]
        per = leak.pressure_drop / along * across / leak.viscosity
        medium = effective_medium(gap.ravel() ** 3 / 12, np.full(gap.size, 1 / gap.size))
        return per * flow_conductance(gap, result.lengths, axis=axis).conductance, per * medium

    return read
