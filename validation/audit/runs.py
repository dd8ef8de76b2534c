"""The dataset of a run or a sweep, number by number, from the stored fields of its solves."""

from __future__ import annotations

import copy
import hashlib
import itertools
import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from validation.audit.ledger import Ledger
from validation.audit.recomputed import Run

__all__ = ["audit_run", "record_of"]

#: Half width of a 95 % interval over a standard error.
_NORMAL = 1.959963984540054
#: What a solve leaves of the located area, in tolerances (docs/bem.md).
_LEFT = 7.0
#: Rounding differs between two ways to add up; a residual of 1e-17 is rounding itself.
_LOOSE = {"residual": {"rtol": 1e-6, "atol": 1e-14}, "rms_height": {"atol": 0.0}}


def record_of(folder: Path) -> dict[str, Any]:
    """Return the record of a results folder, if it and the dataset are what was written.

    Raises
    ------
    OSError, ValueError
    """
    said = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    if not isinstance(said, dict):
        raise ValueError("result.json is no record")
    digest = said.pop("sha256", None)
    if digest != hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest():
        raise ValueError("result.json is not what was written (SHA-256)")
    return said


def audit_run(folder: Path) -> tuple[Ledger, list[Run]]:
    """Compute the dataset of a run or sweep again, case by case; return the runs that its cases are, too."""
    import netCDF4

    ledger, record = Ledger(), record_of(folder)
    content = (folder / "data.nc").read_bytes()
    ledger.same("data.nc", "SHA-256", record["data"], hashlib.sha256(content).hexdigest())
    store = (folder / record["store"]).resolve()
    with netCDF4.Dataset(folder / "data.nc") as file:
        data = {
            name: np.ma.filled(np.ma.asarray(file[name][...]), np.nan)
            if file[name].dtype != str
            else np.asarray(file[name][...])
            for name in file.variables
        }
        dims = {name: tuple(file[name].dimensions) for name in file.variables}
    runs = []
    judged: set[str] = set()
    for scene, at, words in _cases(record):
        run = Run(scene, store)
        if not run.methods:
            raise LookupError("a scene of the theory alone stores no field")
        here = {
            name: (
                tuple(d for d in dims[name] if d not in at),
                value[tuple(at.get(d, slice(None)) for d in dims[name])],
            )
            for name, value in data.items()
        }
        judged |= _Case(run, here, words, ledger).judge(record["asked"].get("accuracy"))
        runs.append(run)
    ledger.unread += [
        f"data.nc: {name}"
        for name in sorted(data)
        if name not in judged and data[name].dtype.kind == "f" and name not in dims[name]
    ]
    return ledger, runs


def _cases(record: Mapping[str, Any]) -> Iterator[tuple[dict[str, Any], dict[str, int], str]]:
    """Yield the scene of each case, its place along the swept dimensions, and words for it."""
    scene = record["asked"]["scene"]
    if "sweep" not in record["asked"]:
        yield scene, {}, ""
        return
    keys, side_by_side = record["asked"]["sweep"]["keys"], record["asked"]["sweep"]["mode"] == "zip"
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

    def __init__(self, run: Run, data: Mapping[str, Any], words: str, ledger: Ledger) -> None:
        self.run, self.data, self.ledger = run, data, ledger
        self.at = f" at {words}" if words else ""
        self.judged: set[str] = set()
        self.methods = [str(name) for name in data["solver"][1]]
        self.grids = [str(name) for name in data["grid"][1]]

    def number(
        self, name: str, expected: float | None, *, at: Mapping[str, int] | None = None, **how: float
    ) -> None:
        """Enter one number of the dataset, at a place along the dimensions that are left."""
        if name not in self.data:
            return
        dims, values = self.data[name]
        found = values[tuple((at or {})[d] for d in dims)] if dims else values
        place = " ".join(self._word(d, (at or {})[d]) for d in dims)
        loose = {**_LOOSE.get(name, {}), **how}
        self.ledger.number(
            "data.nc", f"{name}{' of ' * bool(place)}{place}{self.at}", float(found), expected, **loose
        )
        self.judged.add(name)

    def _word(self, dim: str, k: int) -> str:
        return {"solver": self.methods, "grid": self.grids}.get(dim, {k: f"{dim} {k}"})[k]

    def source(self, name: str) -> int:
        """Position of a source of error."""
        return [str(s) for s in self.data["source"][1]].index(name)

    def judge(self, accurate: Mapping[str, Any] | None) -> set[str]:
        """Judge every number that follows from the fields; return which there were."""
        run = self.run
        theory = run.theory()
        if not run.measured:
            self._surface()
        self._rows()
        self._area(accurate)
        known = {
            "area_persson_own": theory,
            "area_ensemble": run.ensemble_theory,
            "area_plastic_persson": run.yielded_theory,
        }
        for name, value in known.items():
            if value is not None:
                self.number(name, value, rtol=1e-6 if name == "area_ensemble" else 1e-9)
        for method, grid, *values in run.cross:
            at = {"solver": self.methods.index(method), "grid": self.grids.index(f"{grid[0]} x {grid[1]}")}
            for name, value in zip(("pressure", "area_pixel", "area_perimeter"), values, strict=True):
                self.number(f"{name}_difference", value, at=at, atol=1e-12)
        if run.scatter is not None and "area_each" in self.data:
            for k, (area, ratio) in enumerate(zip(*run.scatter[:2], strict=True)):
                self.number("area_each", area, at={"surface": k}, rtol=1e-7)
                self.number("area_ratio_each", ratio, at={"surface": k}, rtol=1e-7)
            self._mean([float(a) for a in run.scatter[0]])
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

    def _rows(self) -> None:
        for row in self.run.rows:
            at = {
                "solver": self.methods.index(row.method),
                "grid": self.grids.index(f"{row.grid[0]} x {row.grid[1]}"),
            }
            self.number("area_pixel", row.pixel, at=at)
            self.number("area_perimeter", row.perimeter, at=at)
            self.number("density_at_zero", row.density_at_zero, at=at)
            self.number("seconds", row.seconds, at=at)
            self.number("unknowns", row.unknowns, at=at)
            self.number("shifts", row.solves, at=at)
            if row.plastic is not None:
                self.number("area_plastic_pixel", row.plastic, at=at)
            if not math.isnan(row.residual) and not self.run.measured:
                self.number("residual", row.residual, at=at)
            if not self.run.measured:
                self.number("kappa_perimeter", row.kappa, at=at)
                self.number("points_per_wave", row.points_per_wave, at=at)
                self.number("resolved", float(not row.under_resolved), at=at)

    def _area(self, accurate: Mapping[str, Any] | None) -> None:
        limit, at = self.run.own_limit, {"source": self.source("grid")}
        if limit is None:
            return
        self.number("area_own", limit.value, rtol=1e-7)
        if accurate is None:
            self.number("area_own_error", _NORMAL * limit.error, at=at, rtol=1e-5, atol=1e-9)
            return
        error = 2 * limit.error / limit.value + _LEFT * accurate["tolerance"]
        self.number("area_own_error", error * limit.value, at=at, rtol=1e-4)
        if accurate["mean"] is None:
            self.number("accuracy_reached", error, rtol=1e-4)

    def _mean(self, areas: list[float]) -> None:
        """Judge mean and interval over the surfaces of an ensemble."""
        from scipy.special import stdtrit

        count, mean = len(areas), math.fsum(areas) / len(areas)
        deviation = math.sqrt(math.fsum((a - mean) ** 2 for a in areas) / (count - 1))
        self.number("area", mean, rtol=1e-7)
        half = float(stdtrit(count - 1, 0.975)) * deviation / math.sqrt(count)
        self.number("area_error", half, at={"source": self.source("surfaces")}, rtol=1e-5)
        self.number("scatter", deviation / mean, rtol=1e-5)
