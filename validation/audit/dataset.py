"""A result as it lies on disk: dataset, record, what it says it shows, and the solves it was made of."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import math
import os
from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import xarray as xr

from validation.audit.stored import LARGEST, Array, moments, sealed_bytes
from validation.files import read_record, read_whole
from validation.netcdf import read_dataset

Lines: TypeAlias = list[list[str]]
#: Variables by name.
Variables: TypeAlias = Mapping[Any, xr.Variable]


def ordered(variable: xr.Variable, dims: tuple[Any, ...]) -> Array:
    """Return an array with these dimensions in this order, of length 1 where it has none of them."""
    return np.asarray(variable.set_dims(dims))  # type: ignore[no-untyped-call]


def numbers_in(recipe: Any, name: str) -> Iterator[float]:
    """Yield the numbers of this name in a recipe, however deep they stand."""
    for key, part in recipe.items() if isinstance(recipe, dict) else enumerate(recipe):
        if key == name and isinstance(part, int | float):
            yield part
        elif isinstance(part, dict | list):
            yield from numbers_in(part, name)


def solves_in(data: Variables) -> dict[str, xr.Variable]:
    """Return the variables that name stored solves, by their keys."""
    return {str(name): variable for name, variable in data.items() if name.startswith("solve")}


class Result:
    """A results folder of a study."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._read: dict[Any, Any] = {}
        self.record = read_record(folder / "result.json")
        data = _bytes(folder / "data.nc", str(self.record["data"]))
        self.data: Variables = read_dataset(memoryview(data)).variables
        self.digests: Mapping[str, str] = read_record(folder / "shown.json")["files"]
        for name in self.digests:
            if (folder / name).exists():  # a figure that is not wanted may go
                self._shown(name)
        self.summary: Mapping[str, Any] = json.loads(self._shown("summary.json"))
        if not isinstance(self.summary, dict):
            raise ValueError("summary.json holds no table")

    def _shown(self, name: str) -> bytes:
        """Return the bytes of a file that shows the result, once they are those that were written."""
        return _bytes(self.folder / name, str(self.digests[name]))

    def _names(self, folder: str, suffix: str) -> list[str]:
        """List the files of a kind: those that were written, and what lies beside them."""
        there = (str(path.relative_to(self.folder)) for path in (self.folder / folder).glob(f"*{suffix}"))
        written = {name for name in self.digests if name.endswith(suffix)}
        return sorted({*there, *(name for name in written if str(Path(name).parent) == folder)})

    @cached_property
    def tables(self) -> dict[str, Lines]:
        """Lines of each CSV file by its name, its header first."""
        return {
            name: list(csv.reader(io.StringIO(self._shown(name).decode(), newline="")))
            for name in self._names(".", ".csv")
        }

    @cached_property
    def figures(self) -> dict[str, Variables]:
        """Data behind each figure by the name of its file."""
        names = self._names("figures", ".nc")
        return {Path(name).name: read_dataset(memoryview(self._shown(name))).variables for name in names}

    @cached_property
    def page(self) -> str:
        """The report; empty where there is none."""
        return self._shown("report.html").decode() if "report.html" in self.digests else ""

    @cached_property
    def store(self) -> Path | None:
        """Folder of the stored solves; None where the record names none that is there."""
        store = self.record.get("store")
        path = None if store is None else Path(os.path.realpath(self.folder / str(store)))
        return path if path is not None and path.is_dir() else None

    @cached_property
    def gradients(self) -> dict[float, float]:
        """h'_rms of the surface with all its waves, by the pressure that it and its parts are given."""
        gradients: dict[float, float] = {}
        named = (text for solves in solves_in(self.data).values() for text in solves.values.ravel())
        for key in {key for text in named for key in str(text).split()}:
            solve = self.solve(key)
            if solve is not None and "heights" in solve:
                x, y = solve.attrs["lengths"]
                gradient = math.sqrt(moments(solve["heights"].values, (float(x), float(y)))[1])
                for pressure in numbers_in(json.loads(solve.attrs["recipe"]), "pressure"):
                    gradients[pressure] = max(gradients.get(pressure, 0.0), gradient)
        return gradients

    def solve(self, key: str, read: Callable[[memoryview], Any] = read_dataset) -> Any:
        """Return what `read` makes of the bytes of a stored solve, once; None where it is not there."""
        path = None if self.store is None else self.store / f"{key}.nc"
        if path is None or not path.is_file():
            return None
        if (key, read) not in self._read:
            self._read[key, read] = read(memoryview(sealed_bytes(path)))
        return self._read[key, read]


def _bytes(path: Path, digest: str) -> bytes:
    """Return the bytes of a file that has this digest."""
    content = read_whole(path, most=LARGEST)
    if hashlib.sha256(content).hexdigest() != digest:
        raise ValueError(f"{path.name} is not what was written (SHA-256)")
    return content
