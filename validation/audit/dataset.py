"""A result as it lies on disk: dataset, record, what it says it shows, and the solves it was made of."""

from __future__ import annotations

import csv
import json
import stat
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from validation.audit.stored import Array, Stored

__all__ = ["Labelled", "Result", "Variable", "read_json", "rows_of"]

#: No file that a result consists of is larger.
_LARGEST = 2**31


@dataclass(frozen=True, kw_only=True)
class Variable:
    """An array with the names of its dimensions and its attributes."""

    values: Array
    dims: tuple[str, ...]
    attrs: Mapping[str, Any] = field(default_factory=dict)

    def along(self, dims: tuple[str, ...]) -> Array:
        """Return the array with these dimensions in this order, of length 1 where it has none of them."""
        order = [self.dims.index(dim) for dim in dims if dim in self.dims]
        shape = [self.values.shape[self.dims.index(d)] if d in self.dims else 1 for d in dims]
        return np.transpose(self.values, order).reshape(shape)

    def at(self, place: Mapping[str, int]) -> Variable:
        """Return the part at some positions."""
        index = tuple(place.get(dim, slice(None)) for dim in self.dims)
        dims = tuple(dim for dim in self.dims if dim not in place)
        return Variable(values=np.asarray(self.values[index]), dims=dims, attrs=self.attrs)


@dataclass(frozen=True, kw_only=True)
class Labelled:
    """Variables of a netCDF file by name, and its attributes."""

    variables: Mapping[str, Variable]
    attrs: Mapping[str, Any]

    @classmethod
    def of(cls, path: Path) -> Labelled:
        """Read a file."""
        import netCDF4

        _regular(path)
        with netCDF4.Dataset(path) as file:
            file.set_auto_maskandscale(False)
            variables = {
                name: Variable(
                    values=np.asarray(variable[...]),
                    dims=tuple(variable.dimensions),
                    attrs={key: variable.getncattr(key) for key in variable.ncattrs()},
                )
                for name, variable in file.variables.items()
            }
            return cls(variables=variables, attrs={key: file.getncattr(key) for key in file.ncattrs()})

    def __getitem__(self, name: str) -> Variable:
        return self.variables[name]

    @property
    def coordinates(self) -> set[str]:
        """Names of what says where the numbers stand."""
        said = [self.attrs.get("coordinates", "")]
        said += [one.attrs.get("coordinates", "") for one in self.variables.values()]
        return {name for text in said for name in str(text).split() if name in self}

    def __contains__(self, name: str) -> bool:
        return name in self.variables


class Result:
    """A results folder of a study.

    Parameters
    ----------
    folder : Path
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._read: dict[str, Any] = {}
        #: h'_rms by the pressure of solves, once they were looked at.
        self.gradients: dict[float, float] = {}
        self.record = read_json(folder / "result.json")
        self.data = Labelled.of(folder / "data.nc")
        self.summary = read_json(folder / "summary.json")

    @cached_property
    def tables(self) -> dict[str, list[list[str]]]:
        """Lines of each CSV file by its name, its header first."""
        return {path.name: rows_of(path) for path in sorted(self.folder.glob("*.csv"))}

    @cached_property
    def figures(self) -> dict[str, Labelled]:
        """Data behind each figure by the name of its file."""
        return {path.name: Labelled.of(path) for path in sorted((self.folder / "figures").glob("*.nc"))}

    @cached_property
    def page(self) -> str:
        """The report; empty where there is none."""
        path = self.folder / "report.html"
        if not path.exists():
            return ""
        _regular(path)
        return path.read_text(encoding="utf-8")

    @cached_property
    def store(self) -> Path | None:
        """Folder of the stored solves; None where the record names none that is there."""
        said = self.record.get("store")
        path = None if said is None else (self.folder / str(said)).resolve()
        return path if path is not None and path.is_dir() else None

    def solve(self, key: str) -> Labelled | None:
        """Return the numbers of a stored solve; None where it is not there."""
        found: Labelled | None = self._solve(key, Labelled.of)
        return found

    def fields(self, key: str) -> Stored | None:
        """Return the fields of a stored solve; None where it is not there."""
        found: Stored | None = self._solve(key, Stored)
        return found

    def _solve(self, key: str, kind: Callable[[Path], Any]) -> Any:
        name = f"{kind.__qualname__} {key}"
        if name not in self._read:
            path = None if self.store is None else self.store / f"{key}.nc"
            self._read[name] = kind(path) if path is not None and path.is_file() else None
        return self._read[name]


def _regular(path: Path) -> None:
    """Refuse what is no plain file, or too large to be read."""
    about = path.lstat()
    if not stat.S_ISREG(about.st_mode) or about.st_size > _LARGEST:
        raise ValueError(f"{path.name} is no file of a result")


def read_json(path: Path) -> dict[str, Any]:
    """Return what a JSON file says; a table, or it is refused."""
    _regular(path)
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except RecursionError:
        raise ValueError(f"{path.name} is nested too deeply") from None
    if not isinstance(found, dict):
        raise ValueError(f"{path.name} holds no table")
    return found


def rows_of(path: Path) -> list[list[str]]:
    """Return the lines of a CSV file, its header first."""
    _regular(path)
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.reader(file))
