"""A run or sweep computed again, case by case: rows, limit, theory, scatter, cross-checks from its fields."""

from __future__ import annotations

import copy
import itertools
import json
import math
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.special import stdtrit

from validation.audit.dataset import Result
from validation.audit.ledger import Ledger
from validation.audit.limits import limit_over
from validation.audit.stored import Stored, sealed_bytes

Grid = tuple[int, int]

#: Half width of a 95 % interval over a standard error.
_NORMAL = 1.959963984540054
#: What a solve leaves of the located area, in tolerances (docs/bem.md).
_LEFT = 7.0
#: Rounding differs between two ways to add up; a residual of 1e-17 is rounding itself.
_LOOSE = {"residual": {"rtol": 1e-6, "atol": 1e-14}, "rms_height": {"atol": 0.0}}
#: Terms of a series whose n-th is exp(-(n pi)^2 v / 2), v not below `_LEAST`.
_TERMS, _LEAST = 400, 1e-3


def audit_run(result: Result) -> tuple[Ledger, list[Run]]:
    """Compute the dataset of a run or sweep again, case by case; return the runs that its cases are, too."""
    record, ledger, runs, judged = result.record, Ledger(), [], set()
    for scene, at, words in _cases(record["asked"]):
        run = Run(scene, result.store or result.folder)
        if not run.methods:
            raise LookupError("a scene of the theory alone stores no field")
        here = {name: variable.isel(at, missing_dims="ignore") for name, variable in result.data.items()}
        judged |= _Case(run, here, words, ledger).judge(record["asked"].get("accuracy"))
        runs.append(run)
    ledger.unread += [
        f"data.nc: {name}"
        for name, variable in sorted(result.data.items())
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


def _without_none(value: Any) -> Any:
    """Return JSON data without the keys that hold nothing."""
    if isinstance(value, dict):
        return {key: _without_none(item) for key, item in value.items() if item is not None}
    return [_without_none(item) for item in value] if isinstance(value, list) else value


class Run:
    """What the stored solves of one run say.

    Parameters
    ----------
    scene : mapping
        What was asked for, as result.json has it.
    store : Path
        Folder of its solves.
    """

    def __init__(self, scene: dict[str, Any], store: Path) -> None:
        self.scene = scene
        self.surface: dict[str, Any] = self.scene["surface"]
        self.measured = self.surface["kind"] == "file"
        self.effects: list[dict[str, Any]] = self.scene.get("effects", [])
        asked = self.scene["methods"]
        #: Methods that solve on grids, in the order of the comparison: the first is the reference.
        self.methods = [name for name in asked if "grids" in asked[name]]
        self.options: dict[str, dict[str, Any]] = asked
        #: Stored solves by method, grid, shift and realisation.
        self.solves: dict[tuple[str, Grid, tuple[float, float], int], Stored] = {}
        self.realisations = int(scene.get("ensemble", {}).get("realisations", 1))
        wave = self.surface.get("lambda_short")
        self.shortest = None if wave is None else float(wave)
        #: Whether a mean gap or an offset was held in place of a load.
        self.holds_distance = bool({"mean_gap", "offset"} & set(scene["load"]))
        kinds = [effect["kind"] for effect in self.effects]
        self.bare, self.adhesive = not kinds, "adhesion" in kinds
        #: [Pa], where there is one and no other effect.
        self.hardness = float(self.effects[0]["hardness"]) if kinds == ["hardness"] else None
        # A store, which others may share, has the solves of this scene among others.
        for path in sorted(store.glob("*.nc")):
            if path.name.startswith(tuple(f"{name}-" for name in self.methods)):
                one = Stored(memoryview(sealed_bytes(path)))
                k = self._realisation(one.recipe)
                if k is not None:
                    self.solves.setdefault((one.method, one.grid, one.shift, k), one)

    @classmethod
    def of(cls, folder: Path) -> Run:
        """Return the run of a results folder."""
        record = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        return cls(record["asked"]["scene"], (folder / record["store"]).resolve())

    def _realisation(self, recipe: dict[str, Any]) -> int | None:
        """Return which realisation of the scene a recipe asks for; None if it is of another scene."""
        said, surface = _without_none(recipe), dict(_without_none(recipe["surface"]))
        asked = dict(self.surface)
        k = 0
        if "path" in asked:  # the recipe holds the digest of the file in place of its path
            surface["path"] = asked["path"]
        if self.measured:  # it names no usual treatment of later versions
            surface = {"spikes": "keep", **surface}
            asked = {"tilt": "keep", "spikes": "keep", **asked}
            asked.pop("treatment", None)
        else:
            k = surface.pop("seed") - asked.pop("seed")
        same = (
            surface == asked
            and said["solid"] == self.scene["solid"]
            and said["load"] == self.scene["load"]
            and said.get("effects", []) == self.effects
            and "inverted" not in said
        )
        told = self.options.get(recipe["method"], {})
        same = same and all(told.get(key) == value for key, value in said["settings"].items() if key in told)
        return k if same and k in range(self.realisations) else None

    @cached_property
    def depth(self) -> float | None:
        """Depth [m] at which the solid is bonded to a rigid base: inf of a half-space, None of others."""
        layers = {effect["kind"]: effect for effect in self.effects}
        for kind in ("hardness", "adhesion", "smoothing"):
            layers.pop(kind, None)
        if list(layers) == ["thickness"] and layers["thickness"].get("base", "bonded") == "bonded":
            return float(layers["thickness"]["thickness"])
        return None if layers else math.inf

    def resolved(self, one: Stored) -> bool:
        """Whether lambda_short > 2 dx."""
        return self.shortest is None or self.shortest > 2 * max(one.spacing) * (1 + 1e-12)

    def moments(self, k: int = 0) -> tuple[float, float, float] | None:
        """(m0, m2, m4) of one realisation, from its finest grid that resolves it."""
        own = [one for key, one in self.solves.items() if key[3] == k and self.resolved(one)]
        if not own or self.measured:
            return None
        return max(own, key=lambda one: one.p.size).roughness

    @cached_property
    def modulus(self) -> float:
        """E* = E / (1 - nu^2) [Pa]."""
        solid = self.scene["solid"]
        compliance = (1 - solid["poisson"] ** 2) / solid["young"]
        if "second_young" in solid:
            compliance += (1 - solid["second_poisson"] ** 2) / solid["second_young"]
        return float(1 / compliance)

    def pressure(self, k: int = 0) -> float | None:
        """p0 [Pa]: as given, or p* E* h'_rms of that realisation."""
        load = self.scene["load"]
        if "pressure" in load:
            return float(np.ravel(load["pressure"])[0])
        if "force" in load:
            lx, ly = self.surface["length"]
            return float(load["force"] / (lx * ly))
        if self.holds_distance:
            own = [one for (name, _, _, m), one in self.solves.items() if name == self.methods[0] and m == 0]
            return max(own, key=lambda one: one.p.size).mean_pressure
        found = self.moments(k)
        return (
            None
            if found is None
            else float(np.ravel(load["reduced_pressure"])[0]) * self.modulus * math.sqrt(found[1])
        )

    @cached_property
    def reduced_pressure(self) -> float | None:
        """p* = p0 / (E* h'_rms)."""
        pressure, found = self.pressure(), self.moments()
        flat = pressure is None or found is None or not found[1]
        return None if flat else pressure / (self.modulus * math.sqrt(found[1]))  # type: ignore[operator,index]

    def shown(self, method: str, grid: Grid) -> list[Stored]:
        """Solves of the scene's own surface on one grid, all shifts that were asked for."""
        per_axis = int(self.options[method].get("shifts", 1))
        steps = [i / per_axis for i in range(per_axis)]
        keys = [(method, grid, shift, 0) for shift in itertools.product(steps, steps)]
        return [self.solves[key] for key in keys if key in self.solves]

    def residual(self, one: Stored) -> float:
        """Return the largest of the four residuals; NaN under an attraction whose law is not read here."""
        pressure = self.pressure()
        if self.adhesive:
            found = None if pressure is None else one.adhesive_residuals(pressure)
            return math.nan if found is None else max(found.values())
        load = (
            0.0 if pressure is None or self.holds_distance else abs(one.mean_pressure - pressure) / pressure
        )
        return max(*one.residuals.values(), load)

    def limit(self, method: str, k: int = 0, grids: set[Grid] | None = None) -> tuple[float, float]:
        """Limit of one realisation over resolved grids of one method, and its standard error.

        Over other grids than those of the comparison it is that of solves without a shift.
        """
        compared = {(int(g[0]), int(g[1])) for g in self.options[method]["grids"]}
        own = [
            one
            for (name, grid, shift, realisation), one in self.solves.items()
            if (name, realisation) == (method, k)
            and grid in (grids or compared)
            and (grids or self.resolved(one))
            and (shift == (0.0, 0.0) or (not grids and one in self.shown(name, grid)))
        ]
        square = all(abs(one.spacing[0] / one.spacing[1] - 1) <= 0.05 for one in own)
        return limit_over(own, located=method == "bem" and self.bare and square)

    def theory(self, m2: float | None, pressure: float | None) -> tuple[float, float]:
        """A/A0 and A_pl/A0 with V = E*^2 m2 / 4, elastic or with one hardness; NaN with other effects."""
        known = (self.bare or self.hardness is not None) and "theory" in self.options
        if not known or m2 is None or pressure is None:
            return math.nan, math.nan
        variance = 0.25 * self.modulus**2 * m2
        if self.hardness is not None and m2 > 0:
            parts = yielded_areas(pressure, variance=variance, hardness=self.hardness)
            return sum(parts), parts[0]
        return math.erf(pressure / math.sqrt(2 * variance)) if m2 > 0 else 1.0, math.nan

    def own_theory(self, k: int = 0) -> tuple[float, float]:
        """A/A0 and A_pl/A0 of one realisation."""
        found = self.moments(k)
        return self.theory(None if found is None else found[1], self.pressure(k))

    @cached_property
    def spectral_moments(self) -> tuple[float, float] | None:
        """(m0, m2): integrals over C(q) ~ q^(-2 - 2 H) between the cut-offs of a sharp spectrum."""
        s = self.surface
        if s["kind"] != "self-affine" or s.get("rolloff", "sharp") != "sharp":
            return None
        low, high = 2 * math.pi / s["lambda_long"], 2 * math.pi / s["lambda_short"]

        def integral(power: float) -> float:
            """Of q^power between the cut-offs."""
            if abs(power + 1) < 1e-12:
                return math.log(high / low)
            return float((high ** (power + 1) - low ** (power + 1)) / (power + 1))

        # A stretch by g leaves m0, and of m2 the part (1 + 1/g^2)/2.
        slopes = (1 + s.get("stretch", 1.0) ** -2) / 2
        per_height = slopes * integral(1 - 2 * s["hurst"]) / integral(-1 - 2 * s["hurst"])
        if "rms_gradient" in s:
            m2 = s["rms_gradient"] ** 2
            return m2 / per_height, m2
        m0 = s["rms_height"] ** 2
        return m0, m0 * per_height


class _Case:
    """One scene: its numbers in the dataset, beside those of its stored solves."""

    def __init__(self, run: Run, data: Mapping[str, xr.Variable], words: str, ledger: Ledger) -> None:
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
        words = [
            self.names[d][where[d]] if d in ("solver", "grid") else f"{d} {where[d]}" for d in map(str, dims)
        ]
        place = f"{name}{' of ' * bool(dims)}{' '.join(words)}{self.at}"
        found = float(self.data[name].isel(where, missing_dims="ignore").values)
        self.ledger.number("data.nc", place, found, expected, **{**_LOOSE.get(name, {}), **how})
        self.judged.add(name)

    def judge(self, accurate: Mapping[str, Any] | None) -> set[str]:
        """Judge every number that follows from the fields; return which there were."""
        run = self.run
        if not run.measured:
            self._surface()
        for method in run.methods:
            for grid in sorted((int(g[0]), int(g[1])) for g in run.options[method]["grids"]):
                self._row(method, grid)
        self._area(accurate)
        pressure, spectral = run.pressure(), run.spectral_moments
        area, plastic = run.own_theory()
        ensemble = math.nan if math.isnan(area) or spectral is None else run.theory(spectral[1], pressure)[0]
        known = {"area_persson_own": area, "area_ensemble": ensemble, "area_plastic_persson": plastic}
        for name, value in known.items():
            if not math.isnan(value):
                self.number(name, value, rtol=1e-6 if name == "area_ensemble" else 1e-9)
        if "ensemble" in run.scene and "area_each" in self.data:
            self._ensemble()
        return self.judged

    def _row(self, method: str, grid: Grid) -> None:
        """Judge the numbers of a method on a grid, over its shifts, and beside those of the first method."""
        run, own = self.run, self.run.shown(method, grid)
        if not own:
            raise LookupError(f"no stored solve of {method} on {grid[0]} x {grid[1]}")
        means = {"area_pixel": "pixel", "area_perimeter": "perimeter", "density_at_zero": "density_at_zero"}
        if "hardness" in {effect["kind"] for effect in run.effects}:
            means["area_plastic_pixel"] = "plastic"
        if run.adhesive:
            del means["density_at_zero"]
        row = {name: math.fsum(getattr(one, of) for one in own) / len(own) for name, of in means.items()}
        row |= {
            "density_at_zero": row.get("density_at_zero", math.nan),
            "seconds": math.fsum(one.cost["wall_seconds"] for one in own),
            "unknowns": own[0].cost["unknowns"],
            "shifts": len(own),
            "resolved": float(run.resolved(own[0])),
        }
        if not run.measured:
            load, residual = run.reduced_pressure or math.nan, max(run.residual(one) for one in own)
            if run.holds_distance:
                carried = math.fsum(one.mean_pressure for one in own) / len(own)
                load *= carried / (run.pressure() or math.nan)
            row["kappa_perimeter"] = row["area_perimeter"] / load
            row["points_per_wave"] = (run.shortest or math.nan) / max(own[0].spacing)
            if not math.isnan(residual):
                row["residual"] = residual
        at = {"solver": method, "grid": f"{grid[0]} x {grid[1]}"}
        for name, value in row.items():
            self.number(name, value, at=at)
        first, key = run.methods[0], (grid, (0.0, 0.0), 0)
        if method != first and (first, *key) in run.solves and list(grid) in run.options[first]["grids"]:
            a, b = run.solves[(method, *key)], run.solves[(first, *key)]
            off = math.sqrt(float(np.sum((a.p - b.p) ** 2)) / float(np.sum(b.p**2)))
            self.number("pressure_difference", off, at=at, atol=1e-12)
            self.number("area_pixel_difference", a.pixel / b.pixel - 1, at=at, atol=1e-12)
            self.number("area_perimeter_difference", a.perimeter / b.perimeter - 1, at=at, atol=1e-12)

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
        limits, at = [self.run.limit(name) for name in self.run.methods], {"source": "grid"}
        area, error = next((pair for pair in limits if not math.isnan(pair[0])), (math.nan, math.nan))
        if math.isnan(area):
            return
        self.number("area_own", area, rtol=1e-7)
        if accurate is None:
            self.number("area_own_error", _NORMAL * error, at=at, rtol=1e-5, atol=1e-9)
            return
        share = 2 * error / area + _LEFT * accurate["tolerance"]
        self.number("area_own_error", share * area, at=at, rtol=1e-4)
        if accurate["mean"] is None:
            self.number("accuracy_reached", share, rtol=1e-4)

    def _ensemble(self) -> None:
        """Judge the areas of the surfaces, over their own theory, their mean and its interval."""
        run, count = self.run, self.run.realisations
        grids = {(int(g[0]), int(g[1])) for g in run.scene["ensemble"]["grids"]}
        areas = [run.limit("bem", k, grids)[0] for k in range(count)]
        if any(map(math.isnan, areas)):
            return
        for k, area in enumerate(areas):
            theory = run.own_theory(k)[0]
            self.number("area_each", area, at={"surface": k}, rtol=1e-7)
            self.number(
                "area_ratio_each", area if math.isnan(theory) else area / theory, at={"surface": k}, rtol=1e-7
            )
        mean = math.fsum(areas) / count
        deviation = math.sqrt(math.fsum((a - mean) ** 2 for a in areas) / (count - 1))
        half = float(stdtrit(count - 1, 0.975)) * deviation / math.sqrt(count)
        self.number("area", mean, rtol=1e-7)
        self.number("area_error", half, at={"source": "surfaces"}, rtol=1e-5)
        self.number("scatter", deviation / mean, rtol=1e-5)


def yielded_areas(pressure: float, *, variance: float, hardness: float) -> tuple[float, float]:
    """A_pl/A0 and A_el/A0 of Persson's theory for one hardness: diffusion between walls at 0 and H.

    Eigenfunctions sin(n pi sigma / H) decay like exp(-(n pi)^2 V / 2 H^2); where V is so small that they do
    not decay, images of the two nearest walls are all there is.
    """
    x, v = pressure / hardness, variance / hardness**2
    if v < _LEAST:
        near, far = x / math.sqrt(2 * v), (1 - x) / math.sqrt(2 * v)
        return math.erfc(far), 1 - math.erfc(near) - math.erfc(far)
    plastic, staying = x, 0.0
    for n in range(1, _TERMS):
        decay = math.exp(-((n * math.pi) ** 2) * v / 2)
        wave = math.sin(n * math.pi * x) * decay / (n * math.pi)
        plastic += 2 * (-1) ** n * wave
        staying += 4 * wave if n % 2 else 0.0
        if decay < 1e-18:
            break
    return plastic, staying
