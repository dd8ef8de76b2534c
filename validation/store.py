"""Results on disk: one netCDF file for each finished solve, written atomically, checked when read."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.contact import ContactResult, Cost, Residuals, Status
from validation.errors import RunFailed, UsageError
from validation.jobs import Job, recipe_text

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Store", "atomic_path", "prepare_folder"]

_FIELDS = {
    "pressure": ("Pa", "contact pressure, compression positive"),
    "gap": ("m", "gap u - h + offset"),
    "displacement": ("m", "surface displacement, positive into the elastic body"),
    "heights": ("m", "rigid profile, positive towards the elastic body"),
    "contacting_points": ("1", "membership of the contact set"),
    "at_bound": ("1", "points held at the pressure bound"),
}
_FORMAT = "fem-contact result 1"


def prepare_folder(folder: Path) -> Path:
    """Create a results folder and prove that it can be written to.

    Raises
    ------
    UsageError
        When it cannot.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise UsageError(
            f"--output = {str(folder)!r}: cannot be written to ({error.strerror}); name another folder"
        ) from None
    return folder


@contextlib.contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """Yield a temporary path beside `path` that takes its name only when the block ends well.

    Raises
    ------
    RunFailed
        When the disk is full; finished files are untouched.
    """
    draft = path.with_name(f".{os.getpid()}-{path.name}")
    try:
        yield draft
        os.replace(draft, path)
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT) or "No space left" in str(error):
            raise RunFailed(
                f"the disk is full: {path.name} was not written; finished solves are intact"
            ) from None
        raise
    finally:
        draft.unlink(missing_ok=True)


@dataclass(frozen=True, kw_only=True)
class Store:
    """The folder of finished solves; a file is there whole or not at all."""

    folder: Path

    def path(self, job: Job) -> Path:
        """Return where the result of a job is, or will be."""
        return self.folder / f"{job.key}.nc"

    def save(self, job: Job, result: ContactResult) -> None:
        """Write a finished solve."""
        dataset = _as_dataset(job, result)
        encoding = {
            name: {"zlib": True, "complevel": 1, "shuffle": True, "fletcher32": True}
            for name in dataset.data_vars
        }
        with atomic_path(self.path(job)) as draft:
            dataset.to_netcdf(draft, engine="netcdf4", encoding=encoding)

    def load(self, job: Job) -> ContactResult | None:
        """Read a finished solve; None if there is none.

        A damaged file is set aside as `*.corrupt` and counts as none.
        """
        path = self.path(job)
        if not path.exists():
            return None
        try:
            return _from_file(path)
        except (
            Exception
        ):  # what a damaged HDF5 file raises depends on the byte: anything but a result is damage
            os.replace(path, path.with_suffix(".nc.corrupt"))
            return None

    def holds(self, job: Job) -> bool:
        """Whether an intact result of the job is stored."""
        return self.load(job) is not None


def _as_dataset(job: Job, result: ContactResult) -> xr.Dataset:
    import xarray as xr

    dx, dy = result.spacing
    values = {
        "pressure": result.pressure,
        "gap": result.gap,
        "displacement": result.displacement,
        "heights": result.heights,
        "contacting_points": result.in_contact.astype(np.int8),
        "at_bound": result.at_bound.astype(np.int8),
    }
    data = {
        name: (("x", "y"), values[name], {"units": unit, "long_name": words})
        for name, (unit, words) in _FIELDS.items()
    }
    coords = {
        "x": ("x", np.arange(result.shape[0]) * dx, {"units": "m"}),
        "y": ("y", np.arange(result.shape[1]) * dy, {"units": "m"}),
    }
    attributes: dict[str, Any] = {
        "format": _FORMAT,
        "recipe": recipe_text(job),
        "lengths": list(result.lengths),
        "contact_modulus": result.contact_modulus,
        "offset": result.offset,
        "mean_pressure": result.mean_pressure,
        "status": result.status.name,
        "residuals": json.dumps(asdict(result.residuals)),
        "cost": json.dumps(asdict(result.cost)),
        "provenance": json.dumps(dict(result.provenance)),
    }
    return xr.Dataset(data, coords=coords, attrs=attributes)


def _from_file(path: Path) -> ContactResult:
    import xarray as xr

    with xr.open_dataset(path, engine="netcdf4") as dataset:
        dataset.load()
    attributes = dataset.attrs
    if attributes["format"] != _FORMAT:
        raise ValueError(f"{path}: is not a '{_FORMAT}' file")
    values = {name: dataset[name].values for name in _FIELDS}
    return ContactResult(
        pressure=values["pressure"],
        gap=values["gap"],
        displacement=values["displacement"],
        heights=values["heights"],
        in_contact=values["contacting_points"].astype(bool),
        at_bound=values["at_bound"].astype(bool),
        lengths=(float(attributes["lengths"][0]), float(attributes["lengths"][1])),
        contact_modulus=float(attributes["contact_modulus"]),
        offset=float(attributes["offset"]),
        mean_pressure=float(attributes["mean_pressure"]),
        status=Status[attributes["status"]],
        residuals=Residuals(**json.loads(attributes["residuals"])),
        cost=Cost(**json.loads(attributes["cost"])),
        provenance=json.loads(attributes["provenance"]),
    )
