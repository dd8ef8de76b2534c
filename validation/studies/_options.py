"""Options that many studies have, with their ranges and meanings: like things have like names."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, ValidationInfo

from validation.solvers import chosen_solver
from validation.units import wrong

Hurst = Annotated[float, Field(ge=0, le=1, description="Hurst exponent H")]
Periods = Annotated[float, Field(ge=1, description="L / lambda_long")]
Bandwidth = Annotated[float, Field(gt=1, description="lambda_long / lambda_short")]
Seed = Annotated[int, Field(ge=0, description="whole number that names the first surface")]
ReducedPressure = Annotated[
    float, Field(gt=0, description="p* = p0 / (E* h'_rms) with the realised gradient of each surface")
]


def _with_scatter(count: int, others: ValidationInfo) -> int:
    on_scene = others.data.get("scene") is not None or (others.context or {}).get("on_scene")
    if count < 2 and not on_scene:
        raise wrong("must be greater than or equal to 2")
    return count


Surfaces = Annotated[
    int,
    Field(ge=1, description="how many; scatter between them is the uncertainty"),
    AfterValidator(_with_scatter),
]
Pairs = Annotated[
    int,
    Field(ge=2, description="pairs of surfaces +h, -h; scatter between pairs is the uncertainty"),
]
Shifts = Annotated[int, Field(ge=1, description="sub-grid shifts along each axis")]


def _that_solve(names: tuple[str, ...]) -> tuple[str, ...]:
    for name in names:
        chosen_solver(name)
    return tuple(dict.fromkeys(names))


AnyMethods = Annotated[tuple[str, ...], AfterValidator(_that_solve)]
Methods = Annotated[
    AnyMethods,
    Field(
        min_length=1,
        description="solvers with commas: bem, fem, tamaas, ..., of another package, or module:function of your own",
    ),
]
#: Finite elements of the block, by the names of `fem_contact.block`.
Element = Literal["Hex1", "Hex1/P0", "Hex2", "Hex2/P1disc"]
