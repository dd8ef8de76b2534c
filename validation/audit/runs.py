"""The dataset of a run or a sweep, number by number, from the stored fields of its solves."""

from __future__ import annotations

import copy
import itertools
import math
from collections.abc import Iterator, Mapping
from typing import Any

from scipy.special import stdtrit

from validation.audit.dataset import Result, Variable
from validation.audit.ledger import Ledger
from validation.audit.recomputed import Run

#: Half width of a 95 % interval over a standard error.
_NORMAL = 1.959963984540054
#: What a solve leaves of the located area, in tolerances (docs/bem.md).
_LEFT = 7.0
#: Rounding differs between two ways to add up; a residual of 1e-17 is rounding itself.
_LOOSE = {"residual": {"rtol": 1e-6, "atol": 1e-14}, "rms_height": {"atol": 0.0}}


def audit_run(result: Result) -> tuple[Ledger, list[Run]]:
    """Compute the dataset of a run or sweep again, case by case; return the runs that its cases are, too."""
    record, ledger, runs, judged = result.record, Ledger(), [], set()
    for scene, at, words in _cases(record["asked"]):
        run = Run(scene, result.store or result.folder)
        if not run.methods:
            raise LookupError("a scene of the theory alone stores no field")
        here = {name: variable.at(at) for name, variable in result.data.variables.items()}
        judged |= _Case(run, here, words, ledger).judge(record["asked"].get("accuracy"))
        runs.append(run)
    ledger.unread += [
        f"data.nc: {name}"
        for name, variable in sorted(result.data.variables.items())
        if name not in judged and variable.values.dtype.kind == "f" and name not in variable.dims
    ]
    return ledger, runs


def _cases(asked: Mapping[str, Any]) -> Iterator[tuple[dict[str, Any], dict[str, int], str]]:
    """Yield the scene of each case, its place along the swept dimensions, and words for it."""
    scene = asked["scene"]
    if "sweep" not in asked:
        yield scene, {}, ""
        return
    keys, side_by_side = asked["sweep"]["keys"], asked["sweep"]["mode"] == "zip"
    values = [key["values"] for key in keys]
    # Along numbers a product is sorted.
    if not side_by_side:
        values = [v if any(isinstance(x, str) for x in v) else sorted(v) for v in values]
    cases = list(zip(*values, strict=True)) if side_by_side else list(itertools.product(*values))
    for k, case in enumerate(cases):
        here = copy.deepcopy(scene)
        for key, value in zip(keys, case, strict=True):
            _set(here, key["key"].split("."), value)
        at = {"case": k}
        if not side_by_side:
            at = {key["name"]: v.index(x) for key, v, x in zip(keys, values, case, strict=True)}
        yield here, at, ", ".join(f"{key['name']} = {value}" for key, value in zip(keys, case, strict=True))


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


class _Case:
    """One scene: its numbers in the dataset, beside those of its stored solves."""

    def __init__(self, run: Run, data: Mapping[str, Variable], words: str, ledger: Ledger) -> None:
        self.run, self.data, self.ledger = run, data, ledger
        self.at = f" at {words}" if words else ""
        self.judged: set[str] = set()
        self.names = {dim: [str(name) for name in data[dim].values] for dim in ("solver", "grid", "source")}

    def number(
        self, name: str, expected: float | None, *, at: Mapping[str, int | str] | None = None, **how: float
    ) -> None:
        """Enter one number of the dataset, at positions or names along the dimensions that are left."""
        if name not in self.data:
            return
        told, dims = dict(at or {}), self.data[name].dims
        where = {d: self.names[d].index(k) if isinstance(k, str) else k for d, k in told.items()}
        words = [self.names[d][where[d]] if d in ("solver", "grid") else f"{d} {where[d]}" for d in dims]
        place = f"{name}{' of ' * bool(dims)}{' '.join(words)}{self.at}"
        found = float(self.data[name].at(where).values)
        self.ledger.number("data.nc", place, found, expected, **{**_LOOSE.get(name, {}), **how})
        self.judged.add(name)

    def judge(self, accurate: Mapping[str, Any] | None) -> set[str]:
        """Judge every number that follows from the fields; return which there were."""
        run = self.run
        if not run.measured:
            self._surface()
        for (method, grid), row in run.rows.items():
            for name, value in row.items():
                self.number(name, value, at={"solver": method, "grid": f"{grid[0]} x {grid[1]}"})
        self._area(accurate)
        known = {
            "area_persson_own": run.theory(),
            "area_ensemble": run.ensemble_theory,
            "area_plastic_persson": run.yielded_theory,
        }
        for name, known_area in known.items():
            if known_area is not None:
                self.number(name, known_area, rtol=1e-6 if name == "area_ensemble" else 1e-9)
        for method, grid, *values in run.cross:
            at = {"solver": method, "grid": f"{grid[0]} x {grid[1]}"}
            for name, value in zip(("pressure", "area_pixel", "area_perimeter"), values, strict=True):
                self.number(f"{name}_difference", value, at=at, atol=1e-12)
        if run.scatter is not None and "area_each" in self.data:
            for k, (area, ratio) in enumerate(zip(*run.scatter, strict=True)):
                self.number("area_each", area, at={"surface": k}, rtol=1e-7)
                self.number("area_ratio_each", ratio, at={"surface": k}, rtol=1e-7)
            self._mean(run.scatter[0])
        return self.judged

    def _surface(self) -> None:
        run, found = self.run, self.run.moments()
        self.number("contact_modulus", run.modulus)
        self.number("pressure", run.pressure())
        self.number("reduced_pressure", run.reduced_pressure)
        if found is not None:
            m0, m2, m4 = found
            self.number("rms_height", math.sqrt(m0))
            self.number("rms_gradient", math.sqrt(m2))
            self.number("nayak", 1.5 * m0 * m4 / m2**2 if m2 else None)
        if run.spectral_moments is not None:
            m0, m2 = run.spectral_moments
            self.number("rms_height_spectrum", math.sqrt(m0), rtol=1e-6, atol=0.0)
            self.number("rms_gradient_spectrum", math.sqrt(m2), rtol=1e-6)

    def _area(self, accurate: Mapping[str, Any] | None) -> None:
        limit, at = self.run.own_limit, {"source": self.names["source"].index("grid")}
        if limit is None:
            return
        self.number("area_own", limit[0], rtol=1e-7)
        if accurate is None:
            self.number("area_own_error", _NORMAL * limit[1], at=at, rtol=1e-5, atol=1e-9)
            return
        error = 2 * limit[1] / limit[0] + _LEFT * accurate["tolerance"]
        self.number("area_own_error", error * limit[0], at=at, rtol=1e-4)
        if accurate["mean"] is None:
            self.number("accuracy_reached", error, rtol=1e-4)

    def _mean(self, areas: list[float]) -> None:
        """Judge mean and interval over the surfaces of an ensemble."""
        count, mean = len(areas), math.fsum(areas) / len(areas)
        deviation = math.sqrt(math.fsum((a - mean) ** 2 for a in areas) / (count - 1))
        self.number("area", mean, rtol=1e-7)
        half = float(stdtrit(count - 1, 0.975)) * deviation / math.sqrt(count)
        self.number("area_error", half, at={"source": self.names["source"].index("surfaces")}, rtol=1e-5)
        self.number("scatter", deviation / mean, rtol=1e-5)
