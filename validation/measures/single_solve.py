"""What solves have in common that press one surface once, on one grid, and keep numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from validation.scenes.scene import SelfAffineSurface, SolidSpec
from validation.solves.solve import NumbersSolve

__all__ = ["SingleSolve"]


@dataclass(frozen=True, kw_only=True)
class SingleSolve(NumbersSolve):
    """One realisation of a surface at one load on one square grid; what is kept of it, its heirs say.

    Attributes
    ----------
    surface : SelfAffineSurface
    realisation : int
        Added to the seed of the surface.
    solid : SolidSpec
    reduced_pressure : float
        p* = p0 / (E* h'_rms).
    points : int
        Grid points along each axis.
    """

    surface: SelfAffineSurface
    realisation: int = 0
    solid: SolidSpec
    reduced_pressure: float
    points: int

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        surface = self.surface.model_dump(mode="json")
        surface["seed"] = self.surface.seed_of(self.realisation)
        return {
            "surface": surface,
            "solid": self.solid.model_dump(mode="json"),
            "reduced_pressure": self.reduced_pressure,
            "points": self.points,
        }
