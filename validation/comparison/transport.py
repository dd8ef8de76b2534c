"""What passes through contact and gap of a scene, in units: read off its stored solves if it asks for it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Literal

import numpy as np
import xarray as xr

from fem_contact.contact import ContactResult
from validation.arrays import Pair
from validation.comparison.reductions import Case
from validation.execution.press import Press
from validation.measurements.statistics import finest_error
from validation.report.estimates import error_of, mean
from validation.scenes.tables import Leak

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
    ensemble = [on[finest].solve for on in case.surfaces.values() if finest in on]
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
