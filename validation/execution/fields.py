"""The fields of a solve as the bytes of one netCDF file with units, and back."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

import numpy as np

from fem_contact.contact import ContactResult, Cost, Residuals, Status
from validation.execution.netcdf import InMemory, reading

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


def encode_result(result: ContactResult, *, recipe: str) -> memoryview:
    """Return one solve as a netCDF file."""
    memory = InMemory()
    file = memory.file
    file.setncatts(
        {
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
    )
    for axis, count, step in zip("xy", result.shape, result.spacing, strict=True):
        file.createDimension(axis, count)
        positions = file.createVariable(axis, "f8", (axis,))
        positions.units = "m"
        positions[...] = np.arange(count) * step
    for name, (unit, words) in _FIELDS.items():
        if (value := getattr(result, _NAMES.get(name, name))) is None:
            continue
        value, packed = value.astype(np.int8) if value.dtype == bool else value, name in _COMPRESSED
        # Checksums on all: whoever reads the file with another tool notices damage, too.
        options: Any = {"zlib": packed, "complevel": 1, "shuffle": packed, "fletcher32": True}
        variable = file.createVariable(name, value.dtype, ("x", "y"), **options)
        variable.setncatts({"units": unit, "long_name": words})
        variable[...] = value
    return memory.close()


def decode_result(content: memoryview) -> ContactResult:
    """Return the solve of a netCDF file that is intact; ValueError or KeyError for another version's."""
    with reading(content) as file:
        file.set_auto_maskandscale(False)
        attributes = {name: file.getncattr(name) for name in file.ncattrs()}
        if attributes["format"] != _FORMAT:
            raise ValueError(f"is not a '{_FORMAT}' file")
        present = [name for name in _FIELDS if name != "weights" or name in file.variables]
        values = {_NAMES.get(name, name): file.variables[name][...] for name in present}
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
