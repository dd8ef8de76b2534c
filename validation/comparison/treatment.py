"""What a measured map is like, and how far its contact moves when it is treated otherwise."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict

import numpy as np
import xarray as xr

from validation.execution.press import Contacts
from validation.measurements.measurement import areas_of_solve
from validation.report.findings import Finding, finding, note
from validation.report.table import Table
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import Scene
from validation.scenes.topography.statistics import height_statistics

#: What is said of a measured surface beside its moments.
STATISTICS = (
    *("pixel", "rms_curvature", "kurtosis", "slope_kurtosis", "steep_share"),
    *("summit_density", "summit_curvature", "summit_height", "treatment_spread"),
)
_CHANGES = ("treated_area_change", "treated_gradient_change", "treated_height_change")


def with_treatment(data: xr.Dataset, problem: ContactProblem, results: Contacts) -> xr.Dataset:
    """Add statistics of a measured surface, and what each other treatment changes at the same pressure.

    Changes are relative to the scene's own treatment on the same grid; ``treatment_spread`` is the root sum
    of their squares.
    """
    if problem.measured is None:
        return data
    patch = problem.measured.patch.height_field()
    traits = height_statistics(patch.heights, patch.spacing)
    data = data.assign(
        **asdict(traits), pixel=max(patch.spacing), rms_curvature=math.sqrt(problem.field.moments[2]) / 2
    ).assign_attrs(premise=int(traits.is_gaussian))
    others = [solve for solve in results if solve.problem.variation]
    on = {(solve.method, solve.grid) for solve in others}
    own = next((solve for solve in results if solve.is_own and (solve.method, solve.grid) in on), None)
    if own is None:
        return data
    rows = []
    for solve in (own, *others):
        areas, field = areas_of_solve(solve, results[solve]), solve.problem.field
        area = areas.perimeter if areas.subcell is None else areas.subcell
        rows.append((area, field.rms_gradient, field.rms_height))
    changes = np.transpose(np.array(rows[1:]) / np.array(rows[0]) - 1)
    made = zip((*_CHANGES, "solve_variation"), (*changes, [solve.key for solve in others]), strict=True)
    data = data.assign_coords(variation=[solve.problem.variation for solve in others])
    data = data.assign({name: ("variation", values) for name, values in made})
    spread = float(np.sqrt(np.sum(changes[0] ** 2)))
    return data.assign(treatment_spread=xr.DataArray(spread), treatment_grid=own.label)


def treatment_table(data: xr.Dataset, *cases: str) -> Iterator[Table]:
    """Yield the budget of the treatment, where it was asked for, along the cases of a sweep."""
    if "treated_area_change" in data:
        yield Table(
            (*cases, "variation"),
            (*cases, "variation", *_CHANGES),
            title="Budget of the treatment of the map",
            note="Each row treats the map otherwise and presses it with the same p0 "
            f"({data.treatment_grid.values.flat[0]}). Changes are relative to the treatment of the scene "
            "on that grid; they are no part of the +- of the area.",
            file="treatment",
        )


def about(scene: Scene, problem: ContactProblem) -> dict[str, str]:
    """Return what a dataset says of its scene: title, methods, effects, and what makes a map doubtful."""
    found = () if problem.measured is None else problem.measured.doubts
    return {
        "title": scene.title or scene.name,
        "methods": " ".join(scene.methods.chosen),
        "effects": " ".join(effect.kind for effect in scene.effects),
        **({"doubts": "; ".join(found)} if found else {}),
    }


def doubts(data: xr.Dataset) -> Iterator[Finding]:
    """Yield what makes the measured surface of a dataset doubtful."""
    if found := str(data.attrs.get("doubts", "")):
        yield note("The map is doubtful: {doubts}.", doubts=found)


def treatment_findings(data: xr.Dataset) -> Iterator[Finding]:
    """Yield how far the area hangs on the treatment, and whether the theory's premise holds."""
    yield from doubts(data)
    if "treatment_spread" in data:
        case = data.isel(data.treatment_spread.argmax(...))
        worst = case.isel(variation=int(np.argmax(np.abs(case.treated_area_change.values))))
        form = f"Other treatments of the map move the area by {'at most ' * bool(data.treatment_spread.ndim)}"
        form += "{treatment_spread:.2%} together, most of it {variation}: {treated_area_change:+.2%}."
        yield finding("value", form, worst)
    elif "premise" in data.attrs:
        yield note(
            "How far its treatment moves the area was not asked: treatment = true in [surface] asks it."
        )
    if data.attrs.get("premise") == 0:
        yield finding(
            "value",
            "The map is not what the theory assumes: the kurtosis of its slopes is {slope_kurtosis:.3} "
            "(Gaussian: 3), and the steepest 0.1 % of the points hold {steep_share:.2%} of the mean square "
            "slope (Gaussian: 0.79 %). The distance from the theory judges this premise, not the theory.",
            data,
        )
    elif "premise" in data.attrs:
        yield note("Its slopes are near to Gaussian, as the theory assumes.")
