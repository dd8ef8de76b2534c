"""A run computed again: its rows, limit, theory, scatter and cross-checks from the stored fields."""

from __future__ import annotations

import itertools
import json
import math
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from validation.audit.closed_forms import yielded_areas
from validation.audit.limits import limit_over
from validation.audit.stored import Stored, sealed_bytes

Grid = tuple[int, int]


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
        self._find(store)

    @classmethod
    def of(cls, folder: Path) -> Run:
        """Return the run of a results folder."""
        record = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        return cls(record["asked"]["scene"], (folder / record["store"]).resolve())

    def _find(self, store: Path) -> None:
        """Take from a store, which others may share, what this scene asked for."""
        for path in sorted(store.glob("*.nc")):
            if not path.name.startswith(tuple(f"{name}-" for name in self.methods)):
                continue
            one = Stored(sealed_bytes(path))
            k = self._realisation(one.recipe)
            if k is not None:
                self.solves.setdefault((one.method, one.grid, one.shift, k), one)

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

    def points_per_wave(self, one: Stored) -> float:
        """lambda_short / dx on the coarser axis; NaN for a measured surface, whose file is not read."""
        return math.nan if self.shortest is None else self.shortest / max(one.spacing)

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

    @cached_property
    def gradient(self) -> float | None:
        """h'_rms of the surface."""
        found = self.moments()
        return None if found is None else math.sqrt(found[1])

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
        pressure = self.pressure()
        return None if pressure is None or not self.gradient else pressure / (self.modulus * self.gradient)

    def shown(self, method: str, grid: Grid) -> list[Stored]:
        """Solves of the scene's own surface on one grid, all shifts that were asked for."""
        per_axis = int(self.options[method].get("shifts", 1))
        steps = [i / per_axis for i in range(per_axis)]
        keys = [(method, grid, shift, 0) for shift in itertools.product(steps, steps)]
        return [self.solves[key] for key in keys if key in self.solves]

    @cached_property
    def rows(self) -> dict[tuple[str, Grid], dict[str, float]]:
        """Numbers by their names of every method on every grid, coarse to fine, over its shifts."""
        grids = {name: sorted(tuple(g) for g in self.options[name]["grids"]) for name in self.methods}
        return {(name, grid): self._row(name, grid) for name in self.methods for grid in grids[name]}

    def _row(self, method: str, grid: Grid) -> dict[str, float]:
        own = self.shown(method, grid)
        if not own:
            raise LookupError(f"no stored solve of {method} on {grid[0]} x {grid[1]}")

        def mean(name: str) -> float:
            return math.fsum(getattr(one, name) for one in own) / len(own)

        row = {
            "area_pixel": mean("pixel"),
            "area_perimeter": mean("perimeter"),
            "density_at_zero": math.nan if self.adhesive else mean("density_at_zero"),
            "seconds": math.fsum(one.cost["wall_seconds"] for one in own),
            "unknowns": own[0].cost["unknowns"],
            "shifts": len(own),
            "resolved": float(self.resolved(own[0])),
        }
        if any(effect["kind"] == "hardness" for effect in self.effects):
            row["area_plastic_pixel"] = mean("plastic")
        if self.measured:
            return row
        residual = max(self.residual(one) for one in own)
        load = self.reduced_pressure
        if load is not None and self.holds_distance:
            load *= mean("mean_pressure") / (self.pressure() or math.nan)
        row["kappa_perimeter"] = math.nan if load is None else row["area_perimeter"] / load
        row["points_per_wave"] = self.points_per_wave(own[0])
        return row if math.isnan(residual) else {**row, "residual": residual}

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
        """Limit of one realisation over resolved grids of one method, and its standard error."""
        own_rows = (grid for (name, grid), row in self.rows.items() if name == method and row["resolved"])
        wanted = grids or set(own_rows)
        one_shift = grids is not None
        own = [
            one
            for (name, grid, shift, realisation), one in self.solves.items()
            if name == method
            and realisation == k
            and grid in wanted
            and (shift == (0.0, 0.0) or (not one_shift and one in self.shown(name, grid)))
        ]
        square = all(abs(one.spacing[0] / one.spacing[1] - 1) <= 0.05 for one in own)
        return limit_over(own, located=method == "bem" and self.bare and square)

    @cached_property
    def own_limit(self) -> tuple[float, float] | None:
        """That of the first method that has one."""
        every = (self.limit(name) for name in self.methods)
        return next((found for found in every if not math.isnan(found[0])), None)

    def theory(self, k: int = 0) -> float | None:
        """A/A0 of that realisation with V = E*^2 m2 / 4, elastic or with one hardness; None with others."""
        found, pressure = self.moments(k), self.pressure(k)
        known = self.bare or self.hardness is not None
        if not known or "theory" not in self.options or found is None or pressure is None:
            return None
        return self._persson(pressure, found[1])

    def _persson(self, pressure: float, m2: float) -> float:
        variance = 0.25 * self.modulus**2 * m2
        if self.hardness is not None and m2 > 0:
            return sum(yielded_areas(pressure, variance=variance, hardness=self.hardness))
        return math.erf(pressure / math.sqrt(2 * variance)) if m2 > 0 else 1.0

    @cached_property
    def yielded_theory(self) -> float | None:
        """A_pl/A0 with one hardness."""
        found, pressure = self.moments(), self.pressure()
        if self.hardness is None or self.theory() is None or found is None or pressure is None:
            return None
        return yielded_areas(pressure, variance=0.25 * self.modulus**2 * found[1], hardness=self.hardness)[0]

    @cached_property
    def ensemble_theory(self) -> float | None:
        """The same from C(q) alone."""
        pressure, found = self.pressure(), self.spectral_moments
        if self.theory() is None or pressure is None or found is None:
            return None
        return self._persson(pressure, found[1])

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

    @cached_property
    def scatter(self) -> tuple[list[float], list[float]] | None:
        """Areas, and areas over their own theory, of the realisations."""
        if "ensemble" not in self.scene:
            return None
        grids = {(int(g[0]), int(g[1])) for g in self.scene["ensemble"]["grids"]}
        areas = [self.limit("bem", k, grids)[0] for k in range(self.realisations)]
        ratios = [area / (self.theory(k) or 1.0) for k, area in enumerate(areas)]
        return None if any(map(math.isnan, areas)) else (areas, ratios)

    @cached_property
    def cross(self) -> list[tuple[str, Grid, float, float, float]]:
        """(method, grid, pressure, pixel, perimeter) of each other method against the first."""
        found = []
        first = self.methods[0]
        for method, grid in self.rows:
            key = (grid, (0.0, 0.0), 0)
            if method == first or (first, grid) not in self.rows or (first, *key) not in self.solves:
                continue
            a, b = self.solves[(method, *key)], self.solves[(first, *key)]
            difference = math.sqrt(float(np.sum((a.p - b.p) ** 2)) / float(np.sum(b.p**2)))
            found.append((method, grid, difference, a.pixel / b.pixel - 1, a.perimeter / b.perimeter - 1))
        return found
