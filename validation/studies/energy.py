"""How much energy does a partial contact store, how wide is its gap, how stiff is it, beside every theory?

Each quantity is a limit over grids, with the scatter of the surfaces. What is solved is checked by itself:
energy against the work of the load, stiffness against neighbouring loads, full contact in closed form, and what
the tolerance leaves. The path of loads is that of `pressure`: with the same options the two share their solves.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from validation.arrays import Array
from validation.measurements.common import Resolved, RisingSeveral
from validation.measurements.measurement import TOLERANCE, reduced_numbers
from validation.report.estimates import claim_shares, derive
from validation.report.views import Figure, Findings, Line, Table, Views, against, finding, note
from validation.studies import pressure
from validation.studies._options import Shifts, Surfaces
from validation.studies._study import Bench, Call, solved
from validation.studies.pressure import AGREEMENT, design, measured_path
from validation.theories.persson_variants import persson_readings
from validation.theories.predicted import NEARLY_FULL, beside, distances, ranked

#: How far the loads of the check are apart, relative.
_NEAR = 1e-3
#: Tolerances of the solver that are compared, the last with the strictest.
_STRICT = (1e-4, 1e-6, 1e-8, 1e-12)
#: What is compared.
_COMPARED = ("energy_ratio", "gap", "compliance")


class Options(pressure.Options):
    """What is pressed, along which path of loads, on which grids."""

    plain = "energy, gap and stiffness are compared with theories of the elastic half-space"

    reduced_pressures: RisingSeveral = (0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.2, 1.5, 4.0)
    """p* = p0 / (E* h'_rms) with the realised gradient of each surface, rising; full contact at the last is
    a check"""
    surfaces: Surfaces = 16
    points_per_wave: Resolved = (4.0, 8.0, 16.0)
    """grids, as lambda_short/dx, rising"""
    shifts: Shifts = 1


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Press every surface along the path of loads, and the first once more for the checks.

    That of `pressure.measured_path` beside all readings of the energy; ``work_check`` (load), energy gained over
    the work of the load between loads close to each, ``path_work_check`` along the path; ``stiffness_check``
    (load), difference quotient over the stiffness; ``left_*`` (tolerance, load), what a tolerance of the solver
    leaves.
    """
    first = design(options)[0]
    first = first.but(grids=first["grids"][-2:][:1], shifts=1)
    near = [load * (1 + sign * _NEAR) for load in options.reduced_pressures for sign in (-1, 1)]
    cases: dict[Any, Call] = {t: first.but(tolerance=t) for t in _STRICT}
    cases["near"] = first.but(reduced_pressures=tuple(near), tolerance=_STRICT[-1])
    data = measured_path(options, bench=bench)
    checks = solved(bench, cases)
    data = data.assign(_checked(checks)).assign_coords(tolerance=list(_STRICT[:-1]))
    used = options.tolerance(TOLERANCE)
    usual = int(np.argmin(np.abs(np.log(np.divide(_STRICT[:-1], used)))))
    for name in _COMPARED:
        left = data[f"left_{name}"].isel(tolerance=usual, drop=True).fillna(0)
        data = claim_shares(data, name, solver=left)
    data = distances(beside(data, persson_readings(), options.pressed))
    data = derive(
        data,
        # Of a contact that is full nothing is open: it has no place on a logarithmic axis.
        open_area="(1 - area) * partial_contact",
        energy_missing="1 - energy_ratio",
        energy_missing_predicted="1 - energy_ratio_predicted",
    )
    return data.assign_attrs(methods="theory bem yang_persson wang_mueser xu", solver_tolerance=used)


def _checked(checks: Mapping[Any, xr.Dataset]) -> dict[str, Any]:
    near, usual = checks["near"], checks[_STRICT[-2]]
    *looser, strictest = (reduced_numbers(checks[t].isel(grid=0, shift=0)) for t in _STRICT)
    contact, at = (result.isel(grid=0, shift=0) for result in (usual, near))
    load, gap, energy = (
        at[name].values.reshape(-1, 2) for name in ("reduced_pressure", "mean_gap", "energy")
    )
    scale = near.attrs["contact_modulus"] * near.attrs["rms_gradient"]
    fall, middle = gap[:, 0] - gap[:, 1], load.mean(axis=1)
    stored = looser[-1]["energy_ratio"].values
    path = _path_work(contact, usual.attrs) / usual.attrs["full_contact_energy"]
    with np.errstate(divide="ignore", invalid="ignore"):
        single = {
            "work_check": np.diff(energy, axis=1)[:, 0] / (middle * scale * fall),
            "path_work_check": (stored - stored[0]) / path,
            "stiffness_check": np.diff(load, axis=1)[:, 0]
            * (near.attrs["rms_height"] / fall / middle / contact.stiffness.values),
            "energy_ratio_first": stored,
            "gap_first": looser[-1]["gap"].values,
        }
        left = {n: np.abs([numbers[n] / best - 1 for numbers in looser]) for n, best in strictest.items()}
    shares = {f"left_{name}": (("tolerance", "load"), values) for name, values in left.items()}
    return shares | {name: ("load", values) for name, values in single.items()}


def _path_work(contact: xr.Dataset, attributes: Mapping[str, float]) -> Array:
    """Work of the load from the first on [J/m^2]: -int p du = -[p u] + int u p d ln p, by Hermite's rule."""
    load = contact.reduced_pressure.values * attributes["contact_modulus"] * attributes["rms_gradient"]
    moment = contact.mean_gap.values * load
    slope = moment - load * attributes["rms_height"] / contact.stiffness.values
    step = np.diff(np.log(load))
    pieces = step / 2 * (moment[1:] + moment[:-1]) + step**2 / 12 * (slope[:-1] - slope[1:])
    return np.concatenate([[0.0], moment[0] - moment[1:] + np.cumsum(pieces)])


def views(data: xr.Dataset) -> Views:
    """Ratios to every theory, what is missing towards full contact, and the checks."""
    columns = [f"{name}{end}" for name in _COMPARED for end in ("", "_over")]
    ratios = [against("area", f"{name}_over", AGREEMENT, by="theory", log="y") for name in _COMPARED]
    towards = [
        against(
            "open_area",
            Line(name, joined=False),
            Line(f"{name}_predicted", by="theory", label="{theory}"),
            log="xy",
        )
        for name in ("energy_missing", "gap", "compliance")
    ]
    return Views(
        table=Table(("theory", "load"), ("theory", "reduced_pressure", "area", *columns)),
        budget=_COMPARED,
        figures=[
            Figure(
                "energy-gap-stiffness",
                "Simulated over predicted elastic energy, mean gap and compliance over the contact area, for every "
                "reading of the elastic energy, told the realised surfaces; 1 is agreement.",
                ratios,
            ),
            Figure(
                "towards-full-contact",
                "What is missing of the energy of full contact, mean gap and compliance over the area that is not in "
                "contact; full contact is at the left end. Lines: theories, each at its own load.",
                towards,
            ),
        ],
        findings=[*_findings(data)],
    )


def _findings(data: xr.Dataset) -> Findings:
    for name in _COMPARED:
        yield ranked(
            f"{pressure.TITLES[name]}, mean |ln| of simulated over predicted values where A/A0 < {NEARLY_FULL}: {{order}}.",
            data,
            name,
        )
    partly = data.isel(load=np.flatnonzero(data.gap_first.values > 0))
    checks = ("work_check", "stiffness_check", "path_work_check")
    yield note(
        "First surface: the energy gained between loads 0.2 % apart is the work of the load within {work_check:%}, their "
        "difference quotient the stiffness within {stiffness_check:%}; along the path it is the integral of p du within "
        "{path_work_check:%}, by a quadrature of fourth order.",
        **{name: float(abs(partly[name] - 1).max()) for name in checks},
    )
    form = "The smallest gap, {gap_first} h_rms at p* = {reduced_pressure}, against a tolerance of 1e-12 of the solver: off "
    form += "by {each}; the study takes {solver_tolerance}."
    yield finding("value", form, partly.isel(load=-1), item="{left_gap:%} at {tolerance}")
    full = np.flatnonzero(data.gap_first.values <= 0)
    if full.size:
        form = "From p* = {reduced_pressure} on the contact of the first surface is full: its gap is {gap_first} h_rms, its "
        form += "energy over that of full contact {energy_ratio_first}."
        yield finding("value", form, data.isel(load=int(full[0])))
