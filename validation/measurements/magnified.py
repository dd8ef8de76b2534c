"""One surface with its waves up to rising magnifications: patches, percolation, macroasperities."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np
import xarray as xr

from fem_contact.contact import ContactResult
from fem_contact.patches import find_patches
from validation.arrays import Array, Grid
from validation.execution.measurement import measurement
from validation.measurements.flow import States, contact_is_apart, gap_is_open, located_area
from validation.measurements.measurement import press_elastic, without_waves_beyond
from validation.report.estimates import claim, derive, jackknife, mean, ratio_of_means
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
    seconds=lambda points, reduced_pressures, magnifications, percolating: (
        (len(reduced_pressures) * len(magnifications) + 20 * len(percolating)) * (2e-3 + 8e-7 * points)
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
) -> xr.Dataset:
    """Press one surface at loads p* with the gradient of all waves, with its waves up to each magnification.

    Over (load, magnification); thresholds over (percolating, axis, phase). zeta = q/q_long of the last wave
    there is, rising; `percolating` are the p* at which those are sought where contact and gap join up.
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

    rows = []
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
    gradients = [without_waves_beyond(field, z * q_long).rms_gradient for z in magnifications]
    data["gradient_share_each"] = ("magnification", np.array(gradients) / field.rms_gradient)
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


def sharpest_bend(zeta: Array, area: Array) -> float:
    """Magnification where ln A over ln zeta bends up most, by the parabola through three steps; NaN at an end.

    >>> x = np.linspace(-1, 3, 9)
    >>> round(float(np.log(sharpest_bend(np.exp(x), np.cosh(x - 1.1)))), 1)
    1.1
    """
    x, y = np.log(zeta), np.log(area)
    slopes, middles = np.diff(y) / np.diff(x), (x[1:] + x[:-1]) / 2
    bend = np.diff(slopes) / np.diff(middles)
    top = int(np.argmax(bend))
    if top in (0, bend.size - 1) or not bend[top] > 0:
        return float("nan")
    around = slice(top - 1, top + 2)
    c2, c1, _ = np.polyfit(x[1:-1][around], bend[around], 2)
    return float(np.exp(-c1 / (2 * c2)))


def at_magnification(zeta: Array, area: Array, at: float) -> float:
    """A/A0 between the magnifications, straight in the logarithms; NaN beyond them.

    >>> round(at_magnification(np.array([1.0, 4.0]), np.array([0.4, 0.1]), 2.0), 12)
    0.2
    """
    return float(np.exp(np.interp(np.log(at), np.log(zeta), np.log(area), left=np.nan, right=np.nan)))


def with_macroasperities(data: xr.Dataset, *, theory: Sequence[float], same: float) -> xr.Dataset:
    """Add where ln A bends most, in simulation and theory (``_persson``), and area and pressure there.

    To ``area_each`` and ``area_persson_each`` (surface, load, magnification), ``area``, p* as a coordinate.
    `theory` is zeta_m at each load; `same` the relative change of the pressure, against the lightest load
    with one, that is none.
    """
    along = [["magnification"], ["magnification"]]

    def bend(area: xr.DataArray) -> Any:
        # Of the mean over the surfaces: the bend of a single one is noise.
        places = data.magnification, area.mean("surface")
        return xr.apply_ufunc(sharpest_bend, *places, input_core_dims=along, vectorize=True)

    def there(area: xr.DataArray, zeta: xr.DataArray) -> Any:
        places = data.magnification, area, zeta
        found = xr.apply_ufunc(at_magnification, *places, input_core_dims=[*along, []], vectorize=True)
        return found.transpose("surface", "load")

    def at_bend(area: xr.DataArray) -> Any:
        return there(area, bend(area)).mean("surface", skipna=False)

    data["macro_magnification"] = bend(data.area_each).assign_attrs(reduction="bend", of="area")
    data["macro_magnification_persson"] = ("load", list(theory))
    # Where it bends is an estimate, too, whose scatter is that of leaving surfaces out.
    data["macro_area_each"] = jackknife(at_bend, data.area_each)
    data["macro_area_persson_each"] = there(data.area_persson_each, data.macro_magnification_persson)
    for which in ("", "_persson"):
        area, pressure = f"macro_area{which}", f"macro_pressure{which}"
        lightest = int(np.argmax(data[f"{area}_each"].notnull().all("surface").values))
        areas = ratio_of_means(f"{area}_each.isel(load={lightest})", f"{area}_each", "surface")
        loads = f"reduced_pressure / reduced_pressure.isel(load={lightest})"
        data = derive(data, **{f"macro_pressure_ratio{which}_each": f"({areas}) * {loads}"})
        data = mean(data, area, f"macro_pressure_ratio{which}")
        data = derive(
            claim(data, f"macro_magnification{which}"),
            **{pressure: f"reduced_pressure / {area}"},
            **{f"macro_pressure_shift{which}": f"(macro_pressure_ratio{which} - 1) / {same}"},
        )
    return data
