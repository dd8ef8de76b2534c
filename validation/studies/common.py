"""What the studies share: base surfaces, options, the theory's line, tables."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import Field, StrictInt, ValidationError

from persson import elastic
from validation.errors import UsageError
from validation.scene import Number, Scene, SelfAffineSurface, SolidSpec, Table, problems

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = [
    "Ascending",
    "ResultTable",
    "SurfaceOptions",
    "base_surface",
    "checked",
    "persson_area",
    "solid_of",
]

Ascending = Annotated[tuple[Number, ...], Field(min_length=1)]
Count = Annotated[StrictInt, Field(ge=1)]


class SurfaceOptions(Table):
    """The random surface of a study, in ratios of lengths; heights and moduli scale out of every result."""

    hurst: Number = Field(default=0.8, ge=0, le=1, description="Hurst exponent H")
    size: Number = Field(default=4.0, ge=1, description="L / lambda_long")
    ratio: Number = Field(default=8.0, gt=1, description="lambda_long / lambda_short")
    rolloff: Literal["sharp", "smooth", "plateau"] = Field(default="sharp", description="C(q) below q_long")
    seed: Annotated[StrictInt, Field(ge=0)] = Field(default=2006, description="seed of the first surface")


OptionsType = TypeVar("OptionsType", bound=Table)


def checked(table: type[OptionsType], options: Mapping[str, Any]) -> OptionsType:
    """Check the options of a study.

    Raises
    ------
    UsageError
        With one line for each problem.
    """
    try:
        return table.model_validate(dict(options))
    except ValidationError as error:
        raise UsageError("\n".join(f"option {line}" for line in problems(error))) from None


def base_surface(
    options: SurfaceOptions, *, hurst: float | None = None, ratio: float | None = None
) -> SelfAffineSurface:
    """Return the surface of a study, with a period of 1 mm and a gradient of 0.1; neither matters to what is reported."""
    length = 1e-3
    lambda_long = length / options.size
    return SelfAffineSurface(
        kind="self-affine",
        length=(length, length),
        hurst=options.hurst if hurst is None else hurst,
        lambda_long=lambda_long,
        lambda_short=lambda_long / (options.ratio if ratio is None else ratio),
        rms_gradient=0.1,
        rolloff=options.rolloff,
        seed=options.seed,
    )


def solid_of(scene: Scene | None) -> SolidSpec:
    """Return the solid of a scene, or one of E = 1 GPa and nu = 0.3."""
    return SolidSpec(young=1e9, poisson=0.3) if scene is None else scene.solid


def persson_area(reduced_pressure: ArrayLike) -> NDArray[np.float64]:
    """A/A0 of Persson's theory at p* = p0/(E* h'_rms): erf(sqrt(2) p*).

    Examples
    --------
    >>> bool(abs(persson_area(0.001) / 0.001 - math.sqrt(8 / math.pi)) < 1e-5)
    True
    """
    variance = elastic.stress_variance(1.0, contact_modulus=1.0)
    return np.asarray(elastic.contact_area(np.asarray(reduced_pressure, dtype=float), stress_variance=variance))


@dataclass(frozen=True, kw_only=True)
class ResultTable:
    """Rows for people and for CSV: column names with units, then values as numbers or words."""

    columns: tuple[str, ...]
    rows: tuple[tuple[float | str, ...], ...]

    @classmethod
    def of(cls, columns: Sequence[str], rows: Sequence[Sequence[float | str]]) -> ResultTable:
        """Build a table from sequences."""
        return cls(columns=tuple(columns), rows=tuple(tuple(row) for row in rows))
