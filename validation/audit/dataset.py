"""A result as it lies on disk: dataset, record, what it says it shows, and the solves it was made of."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from validation.audit.stored import LARGEST, Array, Stored, sealed_bytes
from validation.files import read_record, read_whole

T = TypeVar("T")


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
    def of(cls, content: bytes) -> Labelled:
        """Read the bytes of a file."""
        import netCDF4

        with netCDF4.Dataset("memory", memory=content) as file:
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
        self.record = read_record(folder / "result.json")
        self.data = Labelled.of(_bytes(folder / "data.nc", str(self.record["data"])))
        self.digests: Mapping[str, str] = read_record(folder / "shown.json")["files"]
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
    def tables(self) -> dict[str, list[list[str]]]:
        """Lines of each CSV file by its name, its header first."""
        return {
            name: list(csv.reader(io.StringIO(self._shown(name).decode(), newline="")))
            for name in self._names(".", ".csv")
        }

    @cached_property
    def figures(self) -> dict[str, Labelled]:
        """Data behind each figure by the name of its file."""
        return {Path(name).name: Labelled.of(self._shown(name)) for name in self._names("figures", ".nc")}

    @cached_property
    def page(self) -> str:
        """The report; empty where there is none."""
        return self._shown("report.html").decode() if "report.html" in self.digests else ""

    @cached_property
    def store(self) -> Path | None:
        """Folder of the stored solves; None where the record names none that is there."""
        said = self.record.get("store")
        path = None if said is None else Path(os.path.realpath(self.folder / str(said)))
        return path if path is not None and path.is_dir() else None

    def solve(self, key: str) -> Labelled | None:
        """Return the numbers of a stored solve; None where it is not there."""
        return self._solve(key, Labelled.of)

    def fields(self, key: str) -> Stored | None:
        """Return the fields of a stored solve; None where it is not there."""
        return self._solve(key, Stored)

    def _solve(self, key: str, kind: Callable[[bytes], T]) -> T | None:
        path = None if self.store is None else self.store / f"{key}.nc"
        if path is None or not path.is_file():
            return None
        name = f"{kind.__qualname__} {key}"
        if name not in self._read:
            self._read[name] = kind(sealed_bytes(path))
        found: T = self._read[name]
        return found


def _bytes(path: Path, digest: str) -> bytes:
    """Return the bytes of a file that has this digest."""
    content = read_whole(path, most=LARGEST)
    if hashlib.sha256(content).hexdigest() != digest:
        raise ValueError(f"{path.name} is not what was written (SHA-256)")
    return content
