"""What a study left behind: its options, its dataset, its files, and the stored solves it was made of."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from validation.audit.ledger import Ledger
from validation.audit.stored import Array, Stored

__all__ = ["Kept", "Numbers", "area_tolerance", "base_surface", "own_grid", "rows_of"]


def rows_of(path: Path) -> list[list[str]]:
    """Return the lines of a CSV file, its header first; none where there is no such file."""
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.reader(file))


def base_surface(options: Mapping[str, Any], *, seed: int, **changes: float) -> dict[str, Any]:
    """Return the surface that most studies press, as recipes have it: a period of 1 mm, a gradient of .1."""
    told = {**options, **changes}
    length = 1e-3
    return {
        "kind": "self-affine",
        "length": [length, length],
        "hurst": told["hurst"],
        "lambda_long": length / told["periods"],
        "lambda_short": length / told["periods"] / told["bandwidth"],
        "rms_gradient": 0.1,
        "seed": seed,
    }


def own_grid(options: Mapping[str, Any], points_per_wave: float, **changes: float) -> int:
    """Return the smallest even number of points with at least that many on the shortest wave."""
    told = {**options, **changes}
    waves = float(told["periods"] * told["bandwidth"])
    return 2 * math.ceil(points_per_wave * waves / 2 - 1e-9)


def area_tolerance(options: Mapping[str, Any], finest: int) -> float:
    """Return the tolerance of studies of areas: 1e-5 at 8 points on the shortest wave, less with their cube."""
    points = finest / (options["periods"] * options["bandwidth"])
    return float(max(1e-5 * min(1.0, (8 / points) ** 3), 1e-8))


@dataclass(frozen=True)
class Numbers:
    """A stored solve that kept numbers: its recipe, and its variables by name."""

    recipe: dict[str, Any]
    values: dict[str, Array]
    attributes: dict[str, Any]

    def __getitem__(self, name: str) -> Array:
        return self.values[name]


def _read(path: Path) -> tuple[dict[str, Array], dict[str, tuple[str, ...]], dict[str, Any]]:
    import netCDF4

    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        values = {name: np.asarray(file.variables[name][...]) for name in file.variables}
        along = {name: tuple(file.variables[name].dimensions) for name in file.variables}
        said = {name: file.getncattr(name) for name in file.ncattrs()}
    return values, along, said


def _recipe(path: Path) -> dict[str, Any]:
    """Read the recipe of a stored solve from the line of JSON behind its data, before the last line."""
    with path.open("rb") as file:
        size = file.seek(0, 2)
        file.seek(max(0, size - 65536))
        line = file.read().splitlines()[-2]
    found: dict[str, Any] = json.loads(json.loads(line)["recipe"])
    return found


class Kept:
    """A study, read from its folder.

    Parameters
    ----------
    folder : Path
    ledger : Ledger
        What is judged goes there.
    """

    def __init__(self, folder: Path, ledger: Ledger) -> None:
        record = json.loads((folder / "study.json").read_text(encoding="utf-8"))
        self.folder, self.ledger = folder, ledger
        self.name: str = record["study"]
        self.options: dict[str, Any] = record["options"]
        self.data, self.along, self.said = _read(folder / "data.nc")
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        self.findings: list[str] = [
            one if isinstance(one, str) else one["text"] for one in summary["findings"]
        ]
        #: Sentences that nobody has read yet.
        self.unsaid = list(self.findings)
        #: Variables of the dataset that were computed again.
        self.judged: set[str] = set()
        #: What figures show beside the dataset, computed again.
        self.derived: dict[str, Array] = {}
        self._store = record.get("store")
        ledger.same("summary.json", "study", summary["study"], self.name)
        ledger.same("summary.json", "options", summary["options"], self.options)

    def __getitem__(self, name: str) -> Array:
        return self.data[name]

    @cached_property
    def recipes(self) -> list[tuple[dict[str, Any], Path]]:
        """Recipes in the store, with their files; none where the study names no store."""
        if self._store is None:
            return []
        paths = sorted((self.folder / self._store).resolve().glob("*.nc"))
        return [(_recipe(path), path) for path in paths]

    def matching(self, surface: Mapping[str, Any], **wanted: Any) -> Iterator[tuple[dict[str, Any], Path]]:
        """Yield stored solves of a surface whose recipe has what is wanted."""
        for recipe, path in self.recipes:
            told = recipe.get("surface", {})
            if all(_alike(told.get(key), value) for key, value in surface.items()) and all(
                _alike(recipe.get(key), value) for key, value in wanted.items()
            ):
                yield recipe, path

    def numbers(self, surface: Mapping[str, Any], **wanted: Any) -> Numbers | None:
        """Return the stored numbers of one solve, or None."""
        for recipe, path in self.matching(surface, **wanted):
            values, _, said = _read(path)
            return Numbers(recipe, values, said)
        return None

    def fields(self, surface: Mapping[str, Any], **wanted: Any) -> Stored | None:
        """Return the stored fields of one solve, or None."""
        for _, path in self.matching(surface, **wanted):
            return Stored(path)
        return None

    def array(self, name: str, expected: Any, *, rtol: float = 1e-9, atol: float = 1e-13) -> None:
        """Judge a variable of the dataset: the element that is furthest off is entered."""
        self.judged.add(name)
        found = np.asarray(self.data[name], dtype=float)
        exact = np.asarray(expected, dtype=float)
        if found.shape != exact.shape:
            self.ledger.same("data.nc", f"shape of {name}", found.shape, exact.shape)
            return
        with np.errstate(invalid="ignore"):
            off = np.abs(found - exact) / (atol + rtol * np.abs(exact))
        # NaN beside NaN agrees; NaN beside a number is as wrong as can be.
        off = np.where(np.isnan(found) & np.isnan(exact), 0.0, np.where(np.isnan(off), np.inf, off))
        worst = np.unravel_index(int(np.argmax(off)), found.shape) if found.ndim else ()
        place = f" at {tuple(map(int, worst))}" if found.ndim else ""
        self.ledger.number(
            "data.nc",
            f"{name}{place}",
            float(found[worst]),
            float(exact[worst]),
            rtol=rtol,
            atol=atol,
        )


def _alike(found: Any, wanted: Any) -> bool:
    """Whether two values of recipes are the same, numbers to rounding."""
    if isinstance(wanted, int | float) and not isinstance(wanted, bool):
        return isinstance(found, int | float) and math.isclose(found, wanted, rel_tol=1e-9)
    if isinstance(wanted, list | tuple):
        same = isinstance(found, list | tuple) and len(found) == len(wanted)
        return same and all(_alike(a, b) for a, b in zip(found, wanted, strict=True))
    if isinstance(wanted, Mapping):
        return isinstance(found, Mapping) and all(
            _alike(found.get(key), value) for key, value in wanted.items()
        )
    return bool(found == wanted)
