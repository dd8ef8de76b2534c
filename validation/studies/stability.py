"""How far can each method be pushed before it breaks, and does it say so when it does?

Every hard case varies one parameter. At each value a method may be right (its deviation below a bound written
down beforehand), refuse by name, or say that it did not converge. Anything else - a wrong number that calls
itself converged, a NaN, an exception that is no refusal - is a failure of the method.
"""

import math
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from pydantic import Field, ValidationInfo, field_validator

from fem_contact.contact import Status
from fem_contact.errors import FemContactError
from persson.errors import PerssonError
from validation.measurements.hard_cases import CASES, HardCase, elastic_cases
from validation.report.places import gather
from validation.report.views import Figure, Finding, Level, Line, Table, Views, against, finding
from validation.solvers import chosen_solver
from validation.studies._options import AnyMethods, StudyOptions
from validation.studies._study import Bench
from validation.units import wrong

#: What can happen at one value, from good to bad.
OUTCOMES = ("right", "refused", "not converged", "WRONG")
#: Where deviations of rounding size are drawn, over the bound.
_LEAST = 1e-9


class Options(StudyOptions):
    """Which cases, by which methods."""

    why_no_scene = "it asks about hard cases with known answers"

    methods: AnyMethods = ()
    """solvers with commas; those of other packages and module:function of your own go through the elastic
    cases; bem, fem and theory on all if empty"""
    cases: tuple[str, ...] = ()
    """names of cases; all if empty"""
    slowest: float = Field(default=60.0, ge=0)
    """seconds that one value may take; beyond it counts as a hang"""

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
    built_in = {case.method for case in CASES}
    further = [name for name in names if name not in built_in]
    cases = [case for case in CASES if case.method in names or not names]
    return (*cases, *(case for name in further for case in elastic_cases(name)))


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Vary every parameter; the bench runs no solve, since how a solve ends is what is studied.

    By (row): case, method, value, deviation, bound, residual, outcome, seconds.
    """
    if bench.plan_only:
        bench.solve([])
    rows = [
        _outcome(case, value, options.slowest).assign(case=case.name, turn=turn)
        for case in options.chosen
        for turn, value in enumerate(case.values, start=1)
    ]
    data = gather(dict(enumerate(rows)), "row").set_coords(["case", "turn"])
    data["deviation_ratio"] = np.maximum(data.deviation / data.bound, _LEAST).where(data.deviation.notnull())
    data["bound_ratio"] = 1.0
    used = [chosen_solver(name)[0].name for name in options.methods] or ["bem", "fem", "theory"]
    return data.assign_attrs(methods=" ".join(used))


def _outcome(case: HardCase, value: float, slowest: float) -> xr.Dataset:
    clock = time.perf_counter()
    deviation, residual, message = math.nan, math.nan, ""
    try:
        measured = case.measure(value)
    except (FemContactError, PerssonError) as refusal:
        message = f"{type(refusal).__name__}: {refusal}"
        outcome = "refused" if value in case.refusable else "WRONG"
    except Exception as crash:  # whatever it is, it is what this study looks for
        outcome, message = "WRONG", f"{type(crash).__name__}: {crash}"
    else:
        deviation, residual = measured.error, measured.residual
        outcome = "right" if deviation <= case.bound else "WRONG"
        if measured.status is not Status.CONVERGED:
            outcome, message = "not converged", measured.status.value
    seconds = time.perf_counter() - clock
    if seconds > slowest:
        outcome, message = "WRONG", f"took {seconds:.0f} s. {message}"
    row = {name: getattr(case, name) for name in ("method", "varied", "reference", "bound")}
    row |= {"value": float(value), "deviation": deviation, "residual": residual, "seconds": seconds}
    return xr.Dataset({**row, "outcome": outcome, "message": message})


def views(data: xr.Dataset) -> Views:
    """Show what each method does with hard cases: how often right, refused, unconverged, wrong."""
    methods = list(dict.fromkeys(data.method.values.tolist()))
    by_method = [
        against(
            "turn",
            *(Line("deviation_ratio", where={"case": name}, label=name) for name in _of(data, method)),
            Level("bound_ratio", look={"color": "black"}, label="allowed"),
            log="y",
            title=method,
        )
        for method in methods
    ]
    wrong = int((data.outcome == "WRONG").sum())
    judged = ("case", "method", "varied", "value", "deviation", "bound")
    return Views(
        table=Table(("row",), (*judged, "outcome", "seconds", "message")),
        figures=[
            Figure(
                "stability",
                "Deviation over what was allowed beforehand as each parameter goes from easy to hard; "
                "values that were refused have none.",
                by_method,
            )
        ],
        findings=[
            finding(
                "refusal",
                "Of {all} values {wrong} gave a wrong number, a NaN, a crash or a hang that does not say so.",
                wrong=wrong,
                all=data.sizes["row"],
            ),
            *(_counted(data.isel(row=(data.method == method).values), method) for method in methods[:5]),
        ],
    )


def _of(data: xr.Dataset, method: str) -> list[str]:
    return list(dict.fromkeys(data.case.values[data.method.values == method].tolist()))


def _counted(data: xr.Dataset, method: str) -> Finding:
    counts: dict[str, Any] = {name.replace(" ", "_"): int((data.outcome == name).sum()) for name in OUTCOMES}
    right = data.isel(row=(data.outcome == "right").values)
    worst = float((right.deviation / right.bound).max()) if right.sizes["row"] else math.nan
    form = "{name}, {cases} parameters: right at {right} of {all} values (largest deviation {worst:%} of what is "
    form += "allowed), refused by name at {refused}, not converged at {not_converged}, wrong at {WRONG}."
    return finding(
        "share", form, name=method, cases=len(_of(data, method)), all=data.sizes["row"], worst=worst, **counts
    )
