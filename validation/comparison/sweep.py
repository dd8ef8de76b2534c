"""Running a sweep: every scene checked before any solve, one store, one dataset, one page."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from validation.comparison.explain import problems_of, solves_of_sweep
from validation.comparison.numbers import scene_data
from validation.comparison.run import asked_of, solve_and_write
from validation.comparison.theory_alone import theory_data
from validation.comparison.treatment import with_treatment
from validation.errors import RunFailed
from validation.execution.bench import Bench
from validation.execution.outputs import Outputs
from validation.execution.press import run_solves
from validation.execution.running import Solves
from validation.report.estimates import gather
from validation.report.quantities import labelled
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import Scene
from validation.scenes.sweep import Sweep


def run_sweep(
    sweep: Sweep,
    folder: Path,
    *,
    bench: Bench | None = None,
    cases: Sequence[ContactProblem] | None = None,
    report: bool = True,
) -> Outputs:
    """Run every scene of a sweep into one folder, as `run_scene` does one."""
    problems = cases or problems_of(sweep)
    solves = solves_of_sweep(sweep, problems)
    keys = [dataclasses.asdict(key) for key in sweep.keys]
    settings = asked_of(sweep.scenes[0], sweep={"mode": sweep.mode, "keys": keys})

    def measured(results: Solves) -> tuple[xr.Dataset, Sequence[Path]]:
        each = map(run_solves, sweep.scenes, problems)
        counts = {"solves": len(solves), "asked": sum(map(len, each))}
        return sweep_data(sweep, problems, results).assign_attrs(counts), ()

    bench = bench or Bench.at(folder / "solves")
    return solve_and_write(bench, folder, solves, measured, kind="sweep", settings=settings, report=report)


def sweep_data(sweep: Sweep, cases: Sequence[ContactProblem], results: Solves) -> xr.Dataset:
    """Gather the numbers of all cases over the swept keys, or over `case` where these run side by side."""
    parts = _alike([_case(*pair, results) for pair in zip(sweep.scenes, cases, strict=True)])
    if "contact_modulus" not in parts[0]:
        raise RunFailed("; ".join(dict.fromkeys(part.failures.item() for part in parts)))
    names = [key.name for key in sweep.keys]
    parts = [part.drop_vars(names, errors="ignore") for part in parts]
    if sweep.mode == "zip":
        data = gather(dict(enumerate(parts, 1)), case=range(1, len(parts) + 1))
        data = data.assign_coords({key.name: ("case", list(key.values)) for key in sweep.keys})
    else:
        places = [key.values for key in sweep.keys]
        every = [place[0] if len(names) == 1 else place for place in itertools.product(*places)]
        data = gather(dict(zip(every, parts, strict=True)), **dict(zip(names, places, strict=True)))
    for key in sweep.keys:
        data[key.name].attrs.update(units=key.unit, long_name=key.key, key=key.key)
        data = data.sortby(key.name) if sweep.mode == "product" and key.numeric else data
    alike = {"title", "methods", "effects", "theory", "drawn", "adhesive", "doubts"}
    shared = {name: value for name, value in parts[0].attrs.items() if name in alike}
    told = {"mode": sweep.mode, "cases": len(parts), "keys": " ".join(names)}
    return labelled(data, sweep.given).assign_attrs(shared | told)


def _case(scene: Scene, problem: ContactProblem, results: Solves) -> xr.Dataset:
    if not scene.methods.solvers:
        return theory_data(scene, problem).drop_dims("wave").isel(load=0).reset_coords()
    solves, every = run_solves(scene, problem), results.failures
    done = {solve: results[solve] for solve in solves if solve not in every}
    failures = {s: every[s] for s in solves if s in every and not s.problem.variation}
    try:
        return with_treatment(scene_data(scene, problem, done, failures=failures), problem, done)
    except RunFailed as error:
        return xr.Dataset({"failures": str(error)})


def _alike(parts: Sequence[xr.Dataset]) -> list[xr.Dataset]:
    """Give all cases the same dimensions and variables: what one of them lacks is NaN, or no words."""
    # Positions of the surface have names where cases have different numbers of them.
    if len({part.sizes["shift"] for part in parts if "shift" in part.dims}) > 1:
        parts = [p.assign(shift=np.arange(p.sizes["shift"])) if "shift" in p.dims else p for p in parts]
    how: Any = {"data_vars": "all", "coords": "minimal", "compat": "override", "join": "outer"}
    data = xr.concat(parts, "case", combine_attrs="drop_conflicts", **how)
    texts = [name for name, values in data.data_vars.items() if values.dtype.kind in "OU"]
    data = data.assign({name: data[name].where(data[name].notnull(), "").astype(str) for name in texts})
    return [data.isel(case=k) for k in range(len(parts))]
