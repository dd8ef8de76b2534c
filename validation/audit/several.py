"""Sweeps, and runs to an accuracy: many scenes at once, and what was claimed of one."""

from __future__ import annotations

import copy
import itertools
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from validation.audit.ledger import Ledger
from validation.audit.recomputed import Run

__all__ = ["audit_accuracy", "audit_sweep"]

#: Keys of accuracy.json that say what was asked and spent, and not what came out.
_ASKED = ("predicted_seconds", "solving_seconds", "seconds", "solves", "reused", "peak_bytes", "target")
#: Keys that say what was found over the surfaces of the spectrum.
_OF_THE_MEAN = (
    "surfaces",
    "mean",
    "mean_error",
    "statistical",
    "scatter",
    "surface_grids",
    "pairs",
    "unsolved",
)

#: What a solve leaves of the located area, in tolerances (docs/bem.md).
_LEFT = 7.0


def audit_accuracy(folder: Path, run: Run, ledger: Ledger) -> None:
    """Judge accuracy.json, where a run has one: limits, and the half widths of their 95 % intervals."""
    path, place = folder / "accuracy.json", "accuracy.json"
    if not path.exists():
        return
    said = json.loads(path.read_text(encoding="utf-8"))
    limit = run.own_limit
    if limit is not None:
        ledger.number(place, "A/A0", said["area"], limit.value, rtol=1e-7)
        error = 2 * limit.error / limit.value + _LEFT * said["tolerance"]
        ledger.number(place, "relative error", said["error"], error, rtol=1e-4)
    bem = run.options["bem"]
    ledger.same(place, "grids", said["grids"], [list(grid) for grid in bem["grids"]])
    ledger.same(place, "shifts", said["shifts"], bem.get("shifts", 1))
    _beside(said["beside"], run, ledger)
    # The mean over surfaces is of areas whose fields are not kept.
    ledger.unread.extend(f"accuracy.json: {key}" for key in (*_ASKED, *_OF_THE_MEAN))


def _beside(said: list[dict[str, Any]], run: Run, ledger: Ledger) -> None:
    """Judge what the other methods say of the same surface."""
    for other in said:
        found = run.limit(other["method"], 0)
        name = f"{other['label']} beside it"
        if found is None or other["doubt"] or other["located"]:
            ledger.unread.append(f"accuracy.json: {name}")
            continue
        ledger.number("accuracy.json", name, other["area"], found.value, rtol=1e-7)
        error = 2 * found.error / found.value
        ledger.number("accuracy.json", f"{name}, relative error", other["error"], error, rtol=1e-4)


def audit_sweep(folder: Path) -> Ledger:
    """Compute every number of the dataset of a sweep again, case by case."""
    import netCDF4

    ledger = Ledger()
    record = json.loads((folder / "sweep.json").read_text(encoding="utf-8"))
    if "store" not in record:
        raise LookupError("sweep.json names no store; run the sweep again")
    store = (folder / record["store"]).resolve()
    with netCDF4.Dataset(folder / "data.nc") as file:
        data: dict[str, Any] = {
            name: np.ma.filled(np.ma.asarray(file.variables[name][...], dtype=float), math.nan)
            for name in file.variables
            if file.variables[name].dtype != str
        }
        solvers = [str(name) for name in file.variables["solver"][...]] if "solver" in file.variables else []
    if not solvers:
        raise LookupError("a sweep of the theory alone stores no field")
    keys, judged = record["keys"], set(solvers)
    values = [key["values"] for key in keys]
    side_by_side = record["mode"] == "zip"
    cases = list(zip(*values, strict=True)) if side_by_side else list(itertools.product(*values))
    for k, case in enumerate(cases):
        scene = copy.deepcopy(record["scene"])
        for key, value in zip(keys, case, strict=True):
            _set(scene, key["key"].split("."), value)
        run = Run(scene, store)
        words = ", ".join(f"{key['name']} = {value:g}" for key, value in zip(keys, case, strict=True))
        judged |= _case(run, data, (k, words, [key["name"] for key in keys]), ledger)
    names = {name for name in data if name not in judged and name != "case"}
    ledger.unread.extend(f"data.nc: {name}" for name in sorted(names - {key["name"] for key in keys}))
    ledger.unread.append("table, sentences and figures of the sweep, which show the dataset")
    return ledger


def _set(scene: dict[str, Any], path: list[str], value: Any) -> None:
    """Put a value where a dotted key says; an effect is named by its kind."""
    *parents, last = path
    place: Any = scene
    for name in parents:
        if isinstance(place, list):
            place = next(effect for effect in place if effect["kind"] == name)
        else:
            place = place.setdefault(name, {})
    if path[0] == "load":
        place.clear()
    place[last] = value


def _case(run: Run, data: dict[str, Any], told: tuple[int, str, list[str]], ledger: Ledger) -> set[str]:
    """Judge the numbers of one case; return which there were."""
    k, words, swept = told
    limit, load = run.own_limit, run.reduced_pressure
    theory = run.theory()
    expected: dict[str, float | None] = {
        "pressure": run.pressure(),
        "reduced_pressure": load,
        "contact_modulus": run.modulus,
        "rms_gradient": run.gradient,
        "area": None if limit is None else limit.value,
        "area_error": None if limit is None else limit.error,
        "theory": theory,
        "theory_ensemble": run.ensemble_theory,
        "theory_plastic": run.yielded_theory,
    }
    if load is not None:
        expected["kappa"] = None if limit is None else limit.value / load
        expected["kappa_error"] = None if limit is None else limit.error / load
        expected["theory_kappa"] = None if theory is None else theory / load
    judged = set()
    for name, value in expected.items():
        known = value is not None or name in ("area", "area_error", "kappa", "kappa_error")
        if name in data and name not in swept and known:
            loose = {"rtol": 1e-5 if name.endswith("error") else 1e-7, "atol": 1e-11}
            ledger.number("data.nc", f"{name} at {words}", data[name].ravel()[k], value, **loose)
            judged.add(name)
    for s, method in enumerate(run.methods):
        rows = [row for row in run.rows if row.method == method]
        row = max(rows, key=lambda row: (not row.under_resolved, row.points_per_wave))
        own = {"pixel_error": row.pixel_scatter, "points_per_wave": row.points_per_wave}
        own |= {name: getattr(row, name) for name in ("pixel", "perimeter", "plastic", "residual")}
        for name, value in own.items():
            if name in data and value is not None:
                found = data[name].reshape(len(run.methods), -1)[s, k]
                loose = {"rtol": 1e-6, "atol": 1e-13} if name == "residual" else {"atol": 1e-12}
                ledger.number("data.nc", f"{name} of {method} at {words}", found, value, **loose)
                judged.add(name)
    return judged
