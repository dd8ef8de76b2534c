"""How much energy does a partial contact store, how wide is its gap and how stiff is it, beside every theory of them?

Each quantity is a limit over grids, with the scatter of the surfaces. What is solved is checked by itself: energy against
the work of the load, stiffness against neighbouring loads, full contact in closed form, and what the tolerance leaves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from persson.variants import EnergyReading
from validation.arrays import Array
from validation.measures.common import Rising, named
from validation.measures.flow import StiffMeasurement
from validation.measures.measurement import area_limits
from validation.measures.theory import VARIANTS, Waves
from validation.report.drawing import Drawing
from validation.scenes.realised import Realised
from validation.solves.bench import Bench
from validation.studies._options import Shifts, Surfaces
from validation.studies._scene import PressedOptions
from validation.studies.energy.words import QUANTITIES, findings, table

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["THEORIES", "Options", "figures", "findings", "run", "table"]

#: Readings of the elastic energy, and how they are called; gap and stiffness follow from p du = -dU.
THEORIES: dict[EnergyReading, str] = {
    "old": "Persson, Eq. 43",
    "improved": "Persson, Eq. 48",
    "as_printed": "Persson, Eq. 50",
    "yang_persson": VARIANTS["yang_persson"],
    "wang_mueser": VARIANTS["wang_mueser"],
    "xu": VARIANTS["xu"],
    "xu_hybrid": f"{VARIANTS['xu']}, hybrid",
}

#: Loads between which a theory's energy is differentiated, and how far those of the check are apart, relative.
_STEP, _NEAR = 0.01, 1e-3
#: Of the errors of energy and gap in the spacing, measured: 2 to 3; the smaller leaves more to the uncertainty.
_ORDER = 2
#: Tolerances of the solver that are compared, the last with the strictest.
_STRICT = (1e-4, 1e-6, 1e-8, 1e-12)


class Options(PressedOptions):
    """What is pressed, along which path of loads, on which grids."""

    plain = "energy, gap and stiffness are compared with theories of the elastic half-space"

    reduced_pressures: Rising = Field(
        default=(0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.2, 1.5, 4.0),
        min_length=2,
        description="p* = p0 / (E* h'_rms) with the realised gradient of each surface, rising; full contact at the last is a check",
    )
    surfaces: Surfaces = 16
    points_per_wave: Rising = Field(
        default=(4.0, 8.0, 16.0), min_length=2, description="grids, as lambda_short/dx, rising"
    )
    shifts: Shifts = 1


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press every surface along the path of loads, and the first once more for the checks.

    Returns
    -------
    xarray.Dataset
        `area`, `energy`, `gap`, `compliance` over (surface, load), limits over grids, each with its `_error`; `theory_*`
        over (theory, load), told the realised surfaces; `work` (load), energy gained over the work of the load between
        loads close to each; `stiffness_check` (load), difference quotient over the stiffness; `left_*` (tolerance, load),
        what a tolerance of the solver leaves, relative.
    """
    import xarray as xr

    cases = [_case(options, own, options.reduced_pressures) for own in options.pressed]
    near = _case(options, options.first, _pairs(options.reduced_pressures), finest=-2, tolerance=_STRICT[-1])
    strict = [
        _case(options, options.first, options.reduced_pressures, finest=-2, tolerance=t) for t in _STRICT
    ]
    solved = bench.solve([*cases, near, *strict])
    loads = np.array(options.reduced_pressures)
    data: dict[str, Any] = _limits([solved[case] for case in cases])
    data |= _theory([case.realised for case in cases], loads)
    data |= _checked(solved[near], solved[strict[-2]])
    data |= _left([solved[case] for case in strict])
    return xr.Dataset(
        data,
        coords={
            "reduced_pressure": named("load", loads, "p0 / (E* h'_rms)"),
            "theory": list(THEORIES.values()),
            "tolerance": list(_STRICT[:-1]),
        },
        attrs={
            "study": "energy",
            "methods": "theory bem yang_persson wang_mueser xu",
            **options.spectrum_words,
            "surfaces": options.surfaces,
            "points_per_wave": ", ".join(f"{n:g}" for n in options.points_per_wave),
            "solver_tolerance": options.tolerance(StiffMeasurement.tolerance),
        },
    )


def _case(
    options: Options,
    own: Realised,
    loads: Sequence[float],
    *,
    finest: int | None = None,
    tolerance: float | None = None,
) -> StiffMeasurement:
    """One surface on all grids, or on one of them."""
    grids = options.grids_for(options.points_per_wave)
    return StiffMeasurement(
        realised=own,
        reduced_pressures=tuple(loads),
        grids=grids if finest is None else grids[max(len(grids) + finest, 0) :][:1],
        shifts=options.shifts if finest is None else 1,
        tolerance=tolerance or options.tolerance(StiffMeasurement.tolerance),
    )


def _pairs(loads: Sequence[float]) -> list[float]:
    return [load * (1 + sign * _NEAR) for load in loads for sign in (-1, 1)]


def _read(data: xr.Dataset, name: str) -> Array:
    """One of `QUANTITIES` over (grid, load), mean over the shifts."""
    if name == "compliance":
        return np.asarray((1 / data.stiffness).mean("shift").values)
    variable, scale = {"energy": ("energy", "full_contact_energy"), "gap": ("mean_gap", "rms_height")}[name]
    return np.asarray(data[variable].mean("shift").values / data.attrs[scale])


def limit(values: Array, points: Array) -> tuple[Array, Array]:
    """Limit of a quantity whose error falls with the square of the spacing or faster, and its standard error.

    Parameters
    ----------
    values : (grids, ...) array
        Coarse first; the two finest count.
    points : (grids,) array
        Along a side.

    Notes
    -----
    The step from the finest grid to the limit is its own uncertainty: what remains is of higher order, and noise of
    where the edges fall. On 8 surfaces (H = .3, .8; p* = .01 to 1.5; truth from grids of 32 and 48 points per shortest
    wave) the errors of energy and gap are 1.1 times the one claimed, root mean square, from 4 to 16 points on.

    Examples
    --------
    >>> value, error = limit(np.array([1.04, 1.01]), np.array([1.0, 2.0]))
    >>> round(float(value), 12), round(float(error), 12)
    (1.0, 0.01)
    """
    step = (values[-1] - values[-2]) / ((points[-1] / points[-2]) ** _ORDER - 1)
    return values[-1] + step, np.abs(step)


def _limit(data: xr.Dataset, name: str) -> tuple[Array, Array]:
    """Limit and standard error of one of `QUANTITIES` over the loads."""
    values = _read(data, name)
    if name == "compliance":
        # Which points are in contact makes it noisy: no power of the spacing is seen, and none is taken out.
        return values[-1], np.abs(values[-1] - values[-2])
    return limit(values, data.points_per_wave.values)


def _limits(measured: Sequence[xr.Dataset]) -> dict[str, Any]:
    """Limits over the grids and their standard errors, (surface, load)."""
    found = {"area": [area_limits(data) for data in measured]}
    for name in QUANTITIES:
        found[name] = [_limit(data, name) for data in measured]
    dims = ("surface", "load")
    words = {"area": "A/A0", **QUANTITIES}
    values = {
        name: named(dims, np.array([one[0] for one in both]), words[name], unit="1")
        for name, both in found.items()
    }
    errors = {
        f"{name}_error": named(dims, np.array([one[1] for one in both]), "standard error, grids")
        for name, both in found.items()
    }
    return {**values, **errors}


def _theory(cases: Sequence[Realised], loads: Array) -> dict[str, Any]:
    """Return what every reading says of each quantity, told the realised surfaces, means over them; (theory, load)."""
    # Without scatter of the amplitudes every surface has the same waves.
    told = cases if getattr(cases[0].surface, "amplitudes", "") == "gaussian" else cases[:1]
    rows: dict[str, list[Array]] = {name: [] for name in QUANTITIES}
    for case in told:
        waves, height = Waves.of_field(case.field), case.field.rms_height
        pressure = loads * case.field.rms_gradient
        said = [_said(waves, pressure, reading, height=height) for reading in THEORIES]
        for name in QUANTITIES:
            rows[name].append(np.array([one[name] for one in said]))
    return {
        f"theory_{name}": named(("theory", "load"), np.mean(values, axis=0), f"{QUANTITIES[name]}, theory")
        for name, values in rows.items()
    }


def _said(waves: Waves, pressure: Array, reading: EnergyReading, *, height: float) -> Mapping[str, Array]:
    """Energy, gap and compliance of one reading; -d gap = dU / p."""
    up, down = (waves.elastic_energy(pressure * np.exp(sign * _STEP), reading) for sign in (1, -1))
    return {
        "energy": waves.elastic_energy(pressure, reading) / waves.full_energy,
        "gap": waves.mean_gap(pressure, reading) / height,
        "compliance": (up - down) / (2 * _STEP) / (pressure * height),
    }


def _checked(near: xr.Dataset, usual: xr.Dataset) -> dict[str, Any]:
    """Energy over work, and difference quotient over stiffness, between loads closely around each."""
    at = near.isel(grid=0, shift=0)
    load, gap, energy = (
        at[name].values.reshape(-1, 2) for name in ("reduced_pressure", "mean_gap", "energy")
    )
    scale = near.attrs["contact_modulus"] * near.attrs["rms_gradient"]
    fall = gap[:, 0] - gap[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        work = np.diff(energy, axis=1)[:, 0] / (load.mean(axis=1) * scale * fall)
        quotient = np.diff(load, axis=1)[:, 0] * near.attrs["rms_height"] / fall / load.mean(axis=1)
        stiffness = quotient / usual.isel(grid=0, shift=0).stiffness.values
    own = usual.isel(grid=0, shift=0)
    stored = own.energy.values / usual.attrs["full_contact_energy"]
    path = _path_work(own, usual.attrs) / usual.attrs["full_contact_energy"]
    with np.errstate(divide="ignore", invalid="ignore"):
        gained = (stored - stored[0]) / path
    return {
        "work": named("load", work, "energy gained over the work of the load, between loads .2 % apart"),
        "path_work": named("load", gained, "the same from the lightest load on"),
        "stiffness_check": named("load", stiffness, "dp/du between those loads over the stiffness"),
        "first_energy": named("load", stored, "energy over that of full contact, first surface"),
        "first_gap": named(
            "load", own.mean_gap.values / usual.attrs["rms_height"], "gap / h_rms, first surface"
        ),
    }


def _path_work(at: xr.Dataset, told: Mapping[str, float]) -> Array:
    """Work of the load from the first load on [J/m^2]: -int p du = -[p u] + int u p d ln p, by Hermite's rule."""
    load = at.reduced_pressure.values * told["contact_modulus"] * told["rms_gradient"]
    moment = at.mean_gap.values * load
    slope = moment - load * told["rms_height"] / at.stiffness.values
    step = np.diff(np.log(load))
    pieces = step / 2 * (moment[1:] + moment[:-1]) + step**2 / 12 * (slope[:-1] - slope[1:])
    return np.concatenate([[0.0], moment[0] - moment[1:] + np.cumsum(pieces)])


def _left(measured: Sequence[xr.Dataset]) -> dict[str, Any]:
    """Relative change of each quantity of the first surface from a tolerance to the strictest, (tolerance, load)."""
    values = {name: np.array([_read(data, name)[0] for data in measured]) for name in QUANTITIES}
    with np.errstate(divide="ignore", invalid="ignore"):
        return {
            f"left_{name}": named(
                ("tolerance", "load"),
                np.abs(value[:-1] / value[-1] - 1),
                "relative change to the strictest tolerance",
            )
            for name, value in values.items()
        }


def figures(dataset: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw simulated over predicted values over the area, and gap and stiffness towards full contact."""
    from validation.studies.energy import plots

    caption = (
        "Simulated over predicted elastic energy, mean gap and compliance 1/K over the contact area, for every reading of "
        "the elastic energy, told the realised surfaces; 95 % intervals (surfaces, grids, solver); 1 is agreement."
    )
    return (
        Drawing(name="energy-gap-stiffness", figure=plots.ratios(dataset), data=dataset, caption=caption),
        Drawing(
            name="towards-full-contact",
            figure=plots.towards_full_contact(dataset),
            data=dataset,
            caption="Share of the energy of full contact that is missing, mean gap and compliance over the area that is not "
            "in contact, 1 - A/A0: full contact is at the left end. Points, limits over grids with 95 % intervals; lines, "
            "theories, each at its own load, over the simulated area.",
        ),
    )
