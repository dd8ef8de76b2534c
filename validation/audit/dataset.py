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

from validation.audit.stored import Array, moments
from validation.files import read_record, read_whole
from validation.netcdf import read_dataset

Lines: TypeAlias = list[list[str]]
#: Variables by name.
Variables: TypeAlias = Mapping[Any, xr.Variable]

#: No file that a result consists of is larger.
_LARGEST = 2**31
#: Where what shows a result in numbers lies.
_NUMBERS = ("*.csv", "figures/*.nc")


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
        if self.record.get("format") != "fem-contact result 2":
            raise ValueError("result.json is not of this version")
        data = _bytes(folder / "data.nc", str(self.record["data"]))
        self.data: Variables = read_dataset(memoryview(data)).variables
        named: Mapping[str, str] = read_record(folder / "shown.json")["files"]
        beside = {str(path.relative_to(folder)) for kind in _NUMBERS for path in folder.glob(kind)}
        if foreign := sorted(beside - named.keys()):
            raise ValueError(f"{foreign[0]} was not written with it")
        needed = (n for n in named if (folder / n).exists() or n.endswith(".nc") or "/" not in n)
        self._shown = {name: _bytes(folder / name, named[name]) for name in needed}
        self.summary: Mapping[str, Any] = json.loads(self._shown["summary.json"])
        if not isinstance(self.summary, dict):
            raise ValueError("summary.json holds no table")

    @cached_property
    def tables(self) -> dict[str, Lines]:
        """Lines of each CSV file by its name, its header first."""
        return {
            name: list(csv.reader(io.StringIO(content.decode(), newline="")))
            for name, content in sorted(self._shown.items())
            if name.endswith(".csv") and "/" not in name
        }

    @cached_property
    def figures(self) -> dict[str, Variables]:
        """Data behind each figure by the name of its file."""
        return {
            Path(name).name: read_dataset(memoryview(content)).variables
            for name, content in sorted(self._shown.items())
            if name.endswith(".nc")
        }

    @cached_property
    def page(self) -> str:
        """The report; empty where there is none."""
        return self._shown.get("report.html", b"").decode()

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
            self._read[key, read] = read(_sealed_bytes(path))
        return self._read[key, read]


class Reduced:
    """A variable of a result, which says in its attributes how it was made."""

    def __init__(self, result: Result, name: str) -> None:
        self.result, self.name, self.variable = result, name, result.data[name]
        self.attrs, self.dims = self.variable.attrs, tuple(map(str, self.variable.dims))

    def __getitem__(self, key: str) -> xr.Variable:
        """Return the variable that an attribute names."""
        return self.result.data[self.attrs[key]]

    def flag(self, key: str) -> bool:
        """Whether an attribute is there, and not 0."""
        return bool(int(self.attrs.get(key, 0)))


def _bytes(path: Path, digest: str) -> bytes:
    """Return the bytes of a file that has this digest."""
    content = read_whole(path, most=_LARGEST)
    if hashlib.sha256(content).hexdigest() != digest:
        raise ValueError(f"{path.name} is not what was written (SHA-256)")
    return content


def _sealed_bytes(path: Path) -> memoryview:
    """Return the bytes of a stored solve, whose last line has the digest of those before it."""
    content = read_whole(path, most=_LARGEST)
    body = memoryview(content)[:-72]
    if content[-72:] != b"sha256 %s\n" % hashlib.sha256(body).hexdigest().encode():
        # No ValueError, after which a number would count as one that cannot be judged.
        raise OSError(f"{path.name} is not what was written (SHA-256)")
    return memoryview(content)
