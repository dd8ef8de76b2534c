"""Physical effects a scene can list beyond plain elastic contact of a half-space: their tables and slots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field

from validation.units import Length, Number, Pressure, Table, Work

__all__ = [
    "EFFECT_KINDS",
    "EFFECT_TABLES",
    "SLOTS",
    "Adhesion",
    "Coating",
    "Cracks",
    "EffectSpec",
    "Graded",
    "HardnessEffect",
    "SizeDependentHardness",
    "Thickness",
    "clash",
    "effect_key",
]


class HardnessEffect(Table):
    """The solid yields where the pressure reaches its hardness."""

    kind: Literal["hardness"]
    hardness: Pressure = Field(description='indentation hardness H, e.g. "2 GPa"')


class Adhesion(Table):
    """The surfaces attract each other across the gap."""

    kind: Literal["adhesion"]
    work: Work = Field(description='work of adhesion, e.g. "50 mJ/m^2"')
    reach: Length = Field(description='range of the attraction, e.g. "2 nm"')
    law: Literal["exponential", "dugdale"] = "exponential"


class Thickness(Table):
    """The solid is a layer on a rigid base."""

    kind: Literal["thickness"]
    thickness: Length = Field(description='thickness of the layer, e.g. "20 um"')
    base: Literal["bonded", "frictionless"] = "bonded"


class Coating(Table):
    """A homogeneous layer of another modulus on top of the solid."""

    kind: Literal["coating"]
    young: Pressure = Field(description="Young's modulus of the coating")
    poisson: Number | None = Field(default=None, gt=-1, le=0.5, description="that of the solid if not given")
    thickness: Length = Field(description='thickness of the coating, e.g. "1 um"')


class Graded(Table):
    """The modulus relaxes exponentially from that of the solid at the surface to another one below."""

    kind: Literal["graded"]
    bulk_young: Pressure = Field(description="Young's modulus far below the surface")
    depth: Length = Field(description='depth over which it relaxes, e.g. "5 um"')


class SizeDependentHardness(Table):
    """A hardness that rises towards short lengths; a part of the theory alone."""

    kind: Literal["size-dependent-hardness"]
    hardness: Pressure = Field(description="hardness of the bulk")
    length: Length = Field(description="length below which it rises")


class Cracks(Table):
    """Work of adhesion that differs between opening and closing cracks; a part of the theory alone."""

    kind: Literal["cracks"]
    dissipation: Number = Field(ge=0, description="share of the work of adhesion lost at the tip")


EFFECT_TABLES = (HardnessEffect, Adhesion, Thickness, Coating, Graded, SizeDependentHardness, Cracks)

EffectSpec = Annotated[
    HardnessEffect | Adhesion | Thickness | Coating | Graded | SizeDependentHardness | Cracks,
    Field(discriminator="kind"),
]

#: The slot of a solver that each effect fills.
SLOTS = {
    "hardness": "pressure bound",
    "size-dependent-hardness": "pressure bound",
    "adhesion": "gap law",
    "cracks": "gap law",
    "thickness": "response",
    "coating": "response",
    "graded": "response",
}

EFFECT_KINDS = frozenset(SLOTS)


def effect_key(index: int, key: str) -> str:
    """How a message names a key of an effect: counted from one, as a reader of the file counts.

    >>> effect_key(0, "hardness")
    '[[effects]] 1 hardness'
    """
    return f"[[effects]] {index + 1} {key}"


def clash(effects: Sequence[EffectSpec]) -> str | None:
    """Say which two effects fill the same slot; None if each has its own."""
    filled: dict[str, str] = {}
    for effect in effects:
        slot = SLOTS[effect.kind]
        if slot in filled:
            return (
                f"effects: {filled[slot]!r} and {effect.kind!r} both fill the slot '{slot}'; list one of them"
            )
        filled[slot] = effect.kind
    return None
