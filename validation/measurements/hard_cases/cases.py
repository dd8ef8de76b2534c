"""What a hard case is, and what many of them press."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fem_contact.contact import ContactResult, Status
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface

HALF_SPACE = HalfSpace(solid=Solid(young=1.0, poisson=0.0))


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What one value of the parameter gave."""

    error: float  # Distance to the reference, as the case defines it
    residual: float = math.nan  # The solver's own, dimensionless; NaN where a method has none
    status: Status = Status.CONVERGED


@dataclass(frozen=True, kw_only=True)
class HardCase:
    """One difficulty with the parameter that is varied."""

    name: str
    method: str
    varied: str  # Which parameter, in words with its unit
    values: tuple[float, ...]  # Its values, from easy to hard
    reference: str  # What is right, in words
    bound: float  # Largest error that counts as right
    measure: Callable[[float], Measured]
    limit: str = ""  # Where a refusal is allowed, in words; empty where every value must be right
    refusable: Callable[[float], bool] = lambda value: False  # Whether a refusal is allowed at a value


def wave(points: int = 64, *, amplitude: float = 0.01, rows: int = 4) -> HeightField:
    """Return a cosine along x, on a period of 1."""
    x = np.arange(points) / points
    heights = amplitude * np.cos(2 * np.pi * x)[:, None] * np.ones(rows)
    return HeightField(heights=heights, lengths=(1.0, rows / points))


def rough(points: int = 64, *, hurst: float = 0.8, gradient: float = 0.1, waves: int = 8) -> HeightField:
    """Return a random surface of a period of 1 with that many of its shortest waves on it."""
    surface = random_surface(
        lambda q: q ** (-2 - 2 * hurst),
        q_short=waves * 2 * np.pi,
        lengths=(1.0, 1.0),
        shape=(points, points),
        seed=41,
    )
    return HeightField(heights=surface.heights * (gradient / surface.rms_gradient), lengths=(1.0, 1.0))


def judged(result: ContactResult, error: float) -> Measured:
    """Return a solve with its error."""
    return Measured(error=error, residual=result.residuals.worst, status=result.status)


def load_errors(result: ContactResult, *, load: float, hardness: float) -> float:
    """By how much loads and bound are missed, relative to the load and the hardness."""
    from fem_contact.hardness import yielded

    unloaded = yielded(result)
    missed = abs(unloaded.elastic_load + unloaded.plastic_load - load) / load
    missed = max(missed, abs(unloaded.plastic_load - hardness * unloaded.plastic_area) / load)
    return max(missed, float(np.max(result.pressure)) / hardness - 1, 0.0)
