"""How far can each method be pushed before it breaks, and does it say so when it does?

Every hard case turns one dial. At each value a method may be right (its error below a bound written down
beforehand), refuse by name, or say that it did not converge. Anything else - a wrong number that calls itself
converged, a NaN, an error that is no refusal - is a failure of the method.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field, ValidationInfo, field_validator

from fem_contact.contact import Status
from fem_contact.errors import FemContactError
from persson.errors import PerssonError
from validation.methods import chosen_solver
from validation.studies._options import AnyMethods
from validation.studies._study import StudyOptions
from validation.studies.stability.blocks import BLOCKS, LARGE_BLOCK, YIELDING_BLOCK
from validation.studies.stability.cases import HardCase
from validation.studies.stability.effects import DIFFUSION, EFFECTS, YIELDING_UNDER_ADHESION
from validation.studies.stability.elastic import ELASTIC, SINGLE_PRECISION, by_method
from validation.units import wrong

if TYPE_CHECKING:
    import xarray as xr

    from validation.report.drawing import Drawing
    from validation.solves.bench import Bench

__all__ = ["CASES", "OUTCOMES", "Options", "figures", "findings", "run"]

CASES: tuple[HardCase, ...] = (
    *ELASTIC,
    *EFFECTS,
    *BLOCKS,
    DIFFUSION,
    SINGLE_PRECISION,
    YIELDING_BLOCK,
    YIELDING_UNDER_ADHESION,
    LARGE_BLOCK,
)

#: What can happen at one value of a dial, from good to bad.
OUTCOMES = ("right", "refused", "not converged", "WRONG")

_WORDS = {
    "case": "hard case",
    "method": "method",
    "dial": "what is turned",
    "reference": "what is right",
    "outcome": "what happened",
    "words": "refusal or status, in the method's own words",
}
_NUMBERS = {
    "value": ("value of the dial", "1"),
    "error": ("error, as the case defines it", "1"),
    "bound": ("largest error that counts as right", "1"),
    "residual": ("residual", "1"),
    "seconds": ("wall time", "s"),
}


class Options(StudyOptions):
    """Which dials are turned."""

    own = "it asks about hard cases with known answers"

    methods: AnyMethods = Field(
        default=(),
        description="solvers with commas; those of other packages and module:function of your own go through the "
        "elastic cases; bem, fem and theory on all if empty",
    )
    cases: tuple[str, ...] = Field(default=(), description="names of cases; all if empty")
    slowest: float = Field(
        default=60.0, ge=0, description="seconds that one value may take; beyond it counts as a hang"
    )

    @field_validator("cases")
    @classmethod
    def _known(cls, names: tuple[str, ...], others: ValidationInfo) -> tuple[str, ...]:
        known = [case.name for case in _cases_of(others.data.get("methods", ()))]
        for name in names:
            if name not in known:
                raise wrong(f"{name!r}: no such case; one of: {', '.join(known)}")
        return names

    @property
    def chosen(self) -> tuple[HardCase, ...]:
        """Cases by name, or all."""
        cases = _cases_of(self.methods)
        known = {case.name: case for case in cases}
        return tuple(known[name] for name in self.cases) or cases


def _cases_of(names: Sequence[str]) -> tuple[HardCase, ...]:
    """Return the cases of some methods; those of this package where none is named."""
    own = {case.method for case in CASES}
    if not names:
        return CASES
    found = tuple(case for case in CASES if case.method in names)
    return (*found, *(case for name in names if name not in own for case in by_method(name)))


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Turn every dial; the bench runs no solve, for the cases are small, and how a solve ends is what is studied.

    Returns
    -------
    xarray.Dataset
        One row for each value of each dial: error, bound, residual, outcome, seconds.
    """
    import xarray as xr

    if bench.plan_only:
        bench.solve([])
    rows = [_turned(case, value, options.slowest) for case in options.chosen for value in case.values]
    columns: dict[str, tuple[str, list[str | float], dict[str, str]]] = {
        name: ("row", [row[name] for row in rows], {"units": "", "long_name": _WORDS[name]})
        for name in _WORDS
    }
    for name, (words, unit) in _NUMBERS.items():
        columns[name] = ("row", [row[name] for row in rows], {"units": unit, "long_name": words})
    used = [chosen_solver(name)[0].name for name in options.methods] or ["bem", "fem", "theory"]
    return xr.Dataset(columns, attrs={"methods": " ".join(used)})


def _turned(case: HardCase, value: float, slowest: float) -> dict[str, str | float]:
    clock = time.perf_counter()
    error, residual, words = math.nan, math.nan, ""
    try:
        measured = case.measure(value)
    except (FemContactError, PerssonError) as refusal:
        words = f"{type(refusal).__name__}: {refusal}"
        outcome = "refused" if case.refusable(value) else "WRONG"
    except Exception as crash:  # whatever it is, it is what this study looks for
        outcome, words = "WRONG", f"{type(crash).__name__}: {crash}"
    else:
        error, residual = measured.error, measured.residual
        outcome = "right" if error <= case.bound else "WRONG"
        if measured.status is not Status.CONVERGED:
            outcome, words = "not converged", measured.status.value
    seconds = time.perf_counter() - clock
    if seconds > slowest:
        outcome, words = "WRONG", f"took {seconds:.0f} s. {words}"
    return {
        "case": case.name,
        "method": case.method,
        "dial": case.dial,
        "reference": case.reference,
        "value": value,
        "error": error,
        "bound": case.bound,
        "residual": residual,
        "outcome": outcome,
        "words": words,
        "seconds": seconds,
    }


def findings(data: xr.Dataset) -> tuple[str, ...]:
    """Say for every case how far it is right, what it refuses, and what is wrong."""
    sentences = []
    for name in dict.fromkeys(data["case"].values):
        own = data.isel(row=data["case"].values == name)
        outcomes = own["outcome"].values
        right = own["value"].values[outcomes == "right"]
        errors = own["error"].values[outcomes == "right"]
        method, dial = str(own["method"].values[0]), str(own["dial"].values[0])
        text = f"{method}, {name} ({dial}): right at {right.size} of {outcomes.size} values"
        if right.size:
            text += (
                f", from {right[0]:g} to {right[-1]:g}, largest error {errors.max():.2g} "
                f"(allowed {float(own['bound'].values[0]):.2g})"
            )
        for outcome in OUTCOMES[1:]:
            where = own["value"].values[outcomes == outcome]
            if where.size:
                first = str(own["words"].values[outcomes == outcome][0])
                text += f"; {outcome} at {', '.join(f'{v:g}' for v in where)}"
                text += f" ({first})" if first else ""
        sentences.append(text + ".")
    wrong = int(np.count_nonzero(data["outcome"].values == "WRONG"))
    total = data.sizes["row"]
    sentences.append(
        f"Of {total} values {wrong} gave a wrong number, a crash or a hang."
        if wrong
        else f"None of the {total} values gave a silent wrong number, a NaN, a crash or a hang."
    )
    return tuple(sentences)


def figures(data: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw the error along all dials by method, and along every dial beside what is allowed."""
    from validation.report.drawing import Drawing
    from validation.report.figure import lines_figure
    from validation.studies.stability.plots import stability_figure

    columns = ["case", "method", "value", "error", "bound", "outcome"]
    drawings = [
        Drawing(
            name="stability",
            figure=stability_figure(data),
            data=data[columns],
            caption="Error over what was allowed beforehand at every turn of every dial, by method; crosses "
            "are values refused by name.",
        )
    ]
    for name in dict.fromkeys(data["case"].values):
        own = data.isel(row=(data["case"].values == name) & np.isfinite(data["error"].values))
        if own.sizes["row"] == 0:
            continue
        # An error of exactly 0 is drawn at rounding size, so that a logarithmic axis has it.
        drawn = own.assign(error=np.maximum(own["error"], np.finfo(float).eps))
        drawn["error"].attrs = own["error"].attrs
        drawn["value"].attrs["long_name"] = str(own["dial"].values[0])
        drawings.append(
            Drawing(
                name=f"stability-{name}",
                figure=lines_figure(
                    drawn,
                    x="value",
                    lines=("error", "bound"),
                    logarithmic="xy" if float(own["value"].min()) > 0 else "y",
                ),
                data=own[["value", "error", "bound", "residual", "seconds"]],
                caption=f"{own['method'].values[0]}, {name}: error against {own['reference'].values[0]}.",
            )
        )
    return tuple(drawings)
