"""The fields of a solve as a dataset with units, and back from the bytes of its netCDF file."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.contact import ContactResult, Cost, Residuals, Status

if TYPE_CHECKING:
    import xarray as xr

_FIELDS = {
    "pressure": ("Pa", "contact pressure, compression positive"),
    "gap": ("m", "gap u - h + offset"),
    "displacement": ("m", "surface displacement, positive into the elastic body"),
    "heights": ("m", "rigid profile, positive towards the elastic body"),
    "contacting_points": ("1", "membership of the contact set"),
    "at_bound": ("1", "points held at the pressure bound"),
    "weights": ("1", "area carried by each point over the mean cell area"),
}
#: In a `ContactResult`, where it has another name there.
_NAMES = {"contacting_points": "in_contact"}
_FORMAT = "fem-contact result 1"

#: Fields that are mostly zero or one; compressing others costs 50 ms per 256 x 256 points and saves nothing.
_COMPRESSED = frozenset({"pressure", "contacting_points", "at_bound"})


def fields_dataset(result: ContactResult, *, recipe: str) -> xr.Dataset:
    """Return one solve as a dataset over x and y."""
    import xarray as xr

    variables = {}
    for name, (unit, words) in _FIELDS.items():
        if (value := getattr(result, _NAMES.get(name, name))) is None:
            continue
        value, packed = value.astype(np.int8) if value.dtype == bool else value, name in _COMPRESSED
        # Checksums on all: whoever reads the file with another tool notices damage, too.
        options = {"zlib": packed, "complevel": 1, "shuffle": packed, "fletcher32": True, "_FillValue": None}
        variables[name] = xr.Variable(("x", "y"), value, {"units": unit, "long_name": words}, options)
    for axis, count, step in zip("xy", result.shape, result.spacing, strict=True):
        variables[axis] = xr.Variable(axis, np.arange(count) * step, {"units": "m"}, {"_FillValue": None})
    attributes = {
        "format": _FORMAT,
        "recipe": recipe,
        "lengths": list(result.lengths),
        "contact_modulus": result.contact_modulus,
        "offset": result.offset,
        "mean_pressure": result.mean_pressure,
        "status": result.status.name,
        "residuals": json.dumps(asdict(result.residuals)),
        "cost": json.dumps(asdict(result.cost)),
        "provenance": json.dumps(dict(result.provenance)),
    }
    return xr.Dataset(variables, attrs=attributes)


def decode_result(content: memoryview) -> ContactResult:
    """Return the solve of a netCDF file that is intact; ValueError or KeyError for another version's."""
    import netCDF4

    # By hand: half the time that xarray takes, and every page decodes all of its solves.
    with netCDF4.Dataset("memory", memory=content) as file:
        file.set_auto_maskandscale(False)
        attributes = file.__dict__
        if attributes["format"] != _FORMAT:
            raise ValueError(f"is not a '{_FORMAT}' file")
        present = [name for name in _FIELDS if name != "weights" or name in file.variables]
        values: dict[str, Any] = {_NAMES.get(name, name): file.variables[name][...] for name in present}
    values |= {name: values[name].astype(bool) for name in ("in_contact", "at_bound")}
    return ContactResult(
        **values,
        lengths=(float(attributes["lengths"][0]), float(attributes["lengths"][1])),
        contact_modulus=float(attributes["contact_modulus"]),
        offset=float(attributes["offset"]),
        mean_pressure=float(attributes["mean_pressure"]),
        status=Status[attributes["status"]],
        residuals=Residuals(**json.loads(attributes["residuals"])),
        cost=Cost(**json.loads(attributes["cost"])),
        provenance=json.loads(attributes["provenance"]),
    )
