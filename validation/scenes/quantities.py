"""The table [quantities] of a scene: what else is read off its contacts, and what that takes."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import BeforeValidator, Field, model_validator

from validation.units import Pressure, Table, pair_of, quantity, wrong

__all__ = ["Electrical", "Leak", "Quantities", "Thermal"]

Resistivity = Annotated[float, quantity("ohm m", "resistivity", "1.7e-8 ohm m"), Field(gt=0)]
Conductivity = Annotated[float, quantity("W/(m K)", "thermal conductivity", "400 W/(m K)"), Field(gt=0)]
Viscosity = Annotated[float, quantity("Pa s", "viscosity", "1 mPa s"), Field(gt=0)]


class Electrical(Table):
    """Electrical conductance of the contact: all current passes through the spots."""

    resistivity: Annotated[tuple[Resistivity, Resistivity], BeforeValidator(pair_of)] = Field(
        description='of the solid and of the rough body, or one for both, e.g. "1.7e-8 ohm m"'
    )


class Thermal(Table):
    """Thermal conductance of the contact: all heat passes through the spots."""

    conductivity: Annotated[tuple[Conductivity, Conductivity], BeforeValidator(pair_of)] = Field(
        description='of the solid and of the rough body, or one for both, e.g. "400 W/(m K)"'
    )


class Leak(Table):
    """Flow of a thin viscous film through the gap."""

    viscosity: Viscosity = Field(description='of the fluid, e.g. "1 mPa s"')
    pressure_drop: Pressure = Field(description='of the fluid over one period, e.g. "0.1 MPa"')


class Quantities(Table):
    """What is asked for beyond the area; a table that is not there costs nothing."""

    electrical: Electrical | None = None
    thermal: Thermal | None = None
    leak: Leak | None = None

    @model_validator(mode="after")
    def _something(self) -> Self:
        if self.electrical is None and self.thermal is None and self.leak is None:
            tables = ", ".join(f"[quantities.{name}]" for name in type(self).model_fields)
            raise wrong(f"give at least one of the tables {tables}")
        return self
