"""What solves have in common that press one surface once, on one square grid, and keep numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fem_contact.response import HalfSpace
from validation.scenes.realised import Realised
from validation.solves.solve import NumbersSolve

if TYPE_CHECKING:
    from fem_contact.surface import HeightField

__all__ = ["SingleSolve"]


@dataclass(frozen=True, kw_only=True)
class SingleSolve(NumbersSolve):
    """One surface at one load on one square grid; what is kept of it, its heirs say.

    Attributes
    ----------
    realised : Realised
        Surface, solid and load.
    points : int
        Grid points along each axis.
    """

    realised: Realised
    points: int

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return {**self.realised.recipe, "points": self.points}

    @property
    def half_space(self) -> HalfSpace:
        """The solid as a half-space."""
        return HalfSpace(solid=self.realised.elastic)

    @property
    def grid(self) -> tuple[int, int]:
        """Grid points along both axes."""
        return (self.points, self.points)

    @property
    def where(self) -> str:
        """Grid and number of the surface, for progress bars."""
        return f"{self.points}x{self.points}, surface {self.realised.realisation + 1}"

    def heights(self) -> HeightField:
        """Return the heights that are pressed."""
        return self.realised.heights(self.grid)
