"""One surface with its waves up to rising magnifications: patches, percolation, macroasperities."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import xarray as xr

from fem_contact.contact import ContactResult
from fem_contact.patches import find_patches
from validation.arrays import Array, Grid
from validation.execution.measurement import measurement
from validation.measurements.flow import States, contact_is_apart, gap_is_open, located_area
from validation.measurements.measurement import press_elastic, without_waves_beyond
from validation.scenes.problem import ContactProblem

#: Located area, and magnification, up to which a threshold is bracketed.
_AREA, _ZETA = 2e-3, 1.002
_AXES: tuple[Literal["x", "y"], ...] = ("x", "y")


@measurement(
    "magnified-{size}",
    kind="Magnified",
    words="magnified",
    located=True,
    version=2,
    left_out=("load",),
    # One problem for each load and magnification, some twenty for each pair of thresholds.
    seconds=lambda points, reduced_pressures, magnifications, percolating, bends: (
        (len(reduced_pressures) * len(magnifications) + len(bends) + 20 * len(percolating))
        * (2e-3 + 8e-7 * points)
    ),
    bytes=500,
)
def magnified(
    *,
    problem: ContactProblem,
    grid: Grid,
    reduced_pressures: tuple[float, ...],
    magnifications: tuple[float, ...],
    percolating: tuple[float, ...] = (),
    bends: tuple[tuple[float, float], ...] = (),
) -> xr.Dataset:
    """Press one surface at loads p* with the gradient of all waves, with its waves up to each magnification.

    Over (load, magnification); thresholds over (percolating, axis, phase). zeta = q/q_long of the last wave
    there is, rising; `percolating` are the p* at which those are sought where contact and gap join up;
    `bends` pairs of p* and zeta that are looked at alone, over (load) where they have one of the loads.
    """
    heights, q_long = problem.heights(grid), 2 * np.pi / problem.longest

    def states_at(load: float) -> States:
        """Contacts by magnification."""

        def solve(zeta: float, start: Array | None) -> ContactResult:
            field = without_waves_beyond(heights, zeta * q_long)
            return press_elastic(field, problem.elastic, load * problem.pressure_scale, start=start)

        return States(solve)

    def threshold(states: States, passes: Callable[[ContactResult], bool]) -> tuple[float, float]:
        low, high = magnifications[0], magnifications[-1]
        if passes(states(low)) or not passes(states(high)):
            return np.nan, np.nan
        return states.threshold(passes, low, high, area=_AREA, ratio=_ZETA)

    rows, zetas = [], dict(bends)
    for load in reduced_pressures:
        states, unit = states_at(load), problem.longest**2
        last = states(magnifications[-1])
        rows.append([_read_off(states(zeta), last, unit=unit) for zeta in reversed(magnifications)][::-1])
    thresholds = np.empty((len(percolating), 2, 2, 2))
    for j, load in enumerate(percolating):
        states = states_at(load)
        for i, axis in enumerate(_AXES):
            thresholds[j, i] = threshold(states, contact_is_apart(axis)), threshold(states, gap_is_open(axis))
    data: dict[str, Any] = {
        f"{name}_each": (("load", "magnification"), [[cell[name] for cell in row] for row in rows])
        for name in rows[0][0]
    }
    for i, name in enumerate(("area", "magnification")):
        data[f"percolation_{name}_axis_each"] = (("percolating", "axis", "phase"), thresholds[..., i])
    field = problem.field

    def gradient_share(zeta: float) -> float:
        return without_waves_beyond(field, zeta * q_long).rms_gradient / field.rms_gradient

    data["gradient_share_each"] = ("magnification", [gradient_share(zeta) for zeta in magnifications])
    macro = np.full((2, len(reduced_pressures)), np.nan)
    for j, load in enumerate(reduced_pressures):
        if load in zetas:
            macro[:, j] = located_area(states_at(load)(zetas[load])), gradient_share(zetas[load])
    data |= {"macro_area_each": ("load", macro[0]), "macro_gradient_share_each": ("load", macro[1])}
    return xr.Dataset(data, coords={"axis": list(_AXES), "phase": ["contact", "gap"]})


def _read_off(state: ContactResult, last: ContactResult, *, unit: float) -> dict[str, float]:
    """Numbers of a contact, and its shares of the contact at the largest magnification, `last`; `unit` is an area [m^2]."""
    patches = find_patches(state.in_contact, state.spacing)
    nominal = state.lengths[0] * state.lengths[1]
    inside = last.in_contact & state.in_contact
    return {
        "area": located_area(state),
        "patch_density": patches.count * unit / nominal,
        "relative_patch_size": patches.mean_size / unit,
        "largest_patch": float(patches.areas.max() / patches.areas.sum()),
        "area_inside": float(inside.sum() / last.in_contact.sum()),
        "load_inside": float(last.pressure[inside].sum() / last.pressure.sum()),
    }
