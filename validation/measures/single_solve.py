"""What solves have in common that press one surface once, on one grid, and keep numbers."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar

from fem_contact.response import HalfSpace
from validation.arrays import Grid
from validation.scenes.realised import Realised
from validation.solves.solve import LOCATED_EDGES, NumbersSolve, Prediction

if TYPE_CHECKING:
    from fem_contact.surface import HeightField

__all__ = ["SingleSolve", "Takes"]


@dataclass(frozen=True, kw_only=True)
class Takes:
    """What solves of a kind take: seconds of each problem and of each point in it, bytes for a point; seconds once."""

    seconds: float
    each_point: float
    bytes: int
    once: float = 0.0


@dataclass(frozen=True, kw_only=True)
class SingleSolve(NumbersSolve):
    """One surface at one load on one grid; what is kept of it, its heirs say.

    Attributes
    ----------
    realised : Realised
        Surface, solid and load.
    grid : tuple of int
    kind, words : str
        What names on disk begin with, and what it is in a progress bar.
    version : int
        Of what is read off; in the recipe unless it is 0.
    located : bool
        Whether a located area is kept, so that the recipe says how edges are located.
    takes : Takes
    """

    kind: ClassVar[str]
    words: ClassVar[str]
    version: ClassVar[int] = 0
    located: ClassVar[bool] = False
    takes: ClassVar[Takes]

    realised: Realised
    grid: Grid

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers: what is pressed, and its own fields but those that are None."""
        nx, ny = self.grid
        own = {field.name: getattr(self, field.name) for field in fields(self)}
        said = {name: value for name, value in own.items() if name not in ("realised", "grid")}
        return {
            **self.realised.recipe,
            "points": nx if nx == ny else [nx, ny],
            **{name: _plain(value) for name, value in said.items() if value is not None},
            **({"edges": LOCATED_EDGES} if self.located else {}),
            **({"version": self.version} if self.version else {}),
        }

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"{self.kind}-{self.size}"

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        return f"{self.words} {self.where}"

    @property
    def problems(self) -> int:
        """How many contact problems it is, about."""
        return 1

    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict the cost from the number of points and of problems."""
        n, takes = self.points, self.takes
        seconds = takes.once + self.problems * (takes.seconds + takes.each_point * n)
        return Prediction(seconds=seconds, peak_bytes=takes.bytes * n, unknowns=n)

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


def _plain(value: Any) -> Any:
    """Return a value as JSON has it."""
    return [_plain(item) for item in value] if isinstance(value, tuple) else value
