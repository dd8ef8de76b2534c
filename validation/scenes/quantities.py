"""The table [quantities] of a scene: what else is read off its contacts, and what that takes."""

from __future__ import annotations

import itertools
from typing import Annotated, Self

from pydantic import BeforeValidator, Field, StrictBool, model_validator

from validation.report.quantities import as_length
from validation.units import MOST_ITEMS, Pressure, Table, key, pair_of, quantity, wrong

Resistivity = Annotated[float, quantity("ohm m", "resistivity", "1.7e-8 ohm m"), Field(gt=0)]
Conductivity = Annotated[float, quantity("W/(m K)", "thermal conductivity", "400 W/(m K)"), Field(gt=0)]
Viscosity = Annotated[float, quantity("Pa s", "viscosity", "1 mPa s"), Field(gt=0)]
Depth = Annotated[float, quantity("m", "length", "1 um"), Field(ge=0)]


class Electrical(Table):
    """Electrical conductance of the contact: all current passes through the spots."""

    resistivity: Annotated[tuple[Resistivity, Resistivity], BeforeValidator(pair_of)] = key(
        'of the solid and of the rough body, or one for both, e.g. "1.7e-8 ohm m"'
    )


class Thermal(Table):
    """Thermal conductance of the contact: all heat passes through the spots."""

    conductivity: Annotated[tuple[Conductivity, Conductivity], BeforeValidator(pair_of)] = key(
        'of the solid and of the rough body, or one for both, e.g. "400 W/(m K)"'
    )


class Leak(Table):
    """Flow of a thin viscous film through the gap."""

    viscosity: Viscosity = key('of the fluid, e.g. "1 mPa s"')
    pressure_drop: Pressure = key('of the fluid over one period, e.g. "0.1 MPa"')


class Subsurface(Table):
    """Displacement and stress of the solid below the contact."""

    depths: Annotated[tuple[Depth, ...], Field(min_length=2, max_length=MOST_ITEMS)] | None = key(
        'distances from the surface, rising, e.g. ["0 um", "1 um"]; default: from half a cell '
        "to the period or the base, each a quarter deeper",
        None,
    )
    vtu: StrictBool = key("write displacement and stress as fields/...-below.vtu", False)

    @model_validator(mode="after")
    def _rising(self) -> Self:
        depths = self.depths or ()
        if any(lower <= upper for upper, lower in itertools.pairwise(depths)):
            raise wrong(f"depths = {', '.join(map(as_length, depths))}: must rise")
        return self


#: The tables there are, by name.
QUANTITIES: dict[str, type[Table]] = {
    "electrical": Electrical,
    "thermal": Thermal,
    "leak": Leak,
    "subsurface": Subsurface,
}


class Quantities(Table):
    """What is asked for beyond the area; a table that is not there costs nothing."""

    electrical: Electrical | None = None
    thermal: Thermal | None = None
    leak: Leak | None = None
    subsurface: Subsurface | None = None

    @property
    def passing(self) -> bool:
        """Whether something shall pass through contact or gap."""
        return any(table is not None for table in (self.electrical, self.thermal, self.leak))

    @model_validator(mode="after")
    def _something(self) -> Self:
        if not any(getattr(self, name) is not None for name in QUANTITIES):
            tables = ", ".join(f"[quantities.{name}]" for name in QUANTITIES)
            raise wrong(f"give at least one of the tables {tables}")
        return self
