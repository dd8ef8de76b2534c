"""What solves have in common that press one surface once, on one grid, and keep numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fem_contact.response import HalfSpace
from validation.scenes.realised import Realised
from validation.solves.solve import NumbersSolve

if TYPE_CHECKING:
    from fem_contact.surface import HeightField

__all__ = ["SingleSolve"]

Grid = tuple[int, int]


@dataclass(frozen=True, kw_only=True)
class SingleSolve(NumbersSolve):
    """One surface at one load on one grid; what is kept of it, its heirs say.

    Attributes
    ----------
    realised : Realised
        Surface, solid and load.
    grid : tuple of int
    """

    realised: Realised
    grid: Grid

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        nx, ny = self.grid
        return {**self.realised.recipe, "points": nx if nx == ny else [nx, ny]}

    @property
    def half_space(self) -> HalfSpace:
        """The solid as a half-space."""
        return HalfSpace(solid=self.realised.elastic)

    @property
    def size(self) -> str:
        """Points along the sides, as names on disk have them."""
        nx, ny = self.grid
        return str(nx) if nx == ny else f"{nx}x{ny}"

    @property
    def points(self) -> int:
        """Number of grid points."""
        return self.grid[0] * self.grid[1]

    @property
    def where(self) -> str:
        """Grid and number of the surface, for progress bars."""
        return f"{self.grid[0]}x{self.grid[1]}, surface {self.realised.realisation + 1}"

    def heights(self) -> HeightField:
        """Return the heights that are pressed."""
        return self.realised.heights(self.grid)
