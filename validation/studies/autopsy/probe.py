"""One ring at one magnification, as high as it takes for a given step of V: what has a limit as the step vanishes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.arrays import Array
from validation.measures.common import reduced_load
from validation.studies.autopsy.books import flows, mean_of, profile
from validation.studies.autopsy.rings import RingSolve, areas_of, book_dataset, pressed

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["RING", "Probe"]

#: The ring ends at this multiple of the magnification at which it begins.
RING = 2**0.25


@dataclass(frozen=True, kw_only=True)
class Probe(RingSolve):
    """A surface with its waves up to one magnification, and the next ring with both signs at several heights.

    The load p* counts in the gradient of the waves up to that magnification.

    Attributes
    ----------
    magnification : float
        q/q_long of the last wave there is.
    steps : tuple of float
        Delta V / V of the ring.
    """

    magnification: float
    steps: tuple[float, ...]

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return {**super().recipe, "magnification": self.magnification, "steps": list(self.steps)}

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"probe-{self.points}"

    @property
    def solves(self) -> int:
        """The surface, and two for each step."""
        return 1 + 2 * len(self.steps)

    @property
    def shortest(self) -> float:
        """Wave length [m] at the magnification of the probe; that of the ring is a little shorter."""
        return self.realised.longest / self.magnification

    def measure(self) -> xr.Dataset:
        """Press everything and keep the books; dimensions (), (step), (step, bin)."""
        heights = self.heights(0.0, self.magnification)
        ring = self.heights(self.magnification, self.magnification * RING)
        v, natural = self.variance(heights), self.variance(ring)
        unit = float(np.sqrt(v))
        # E* h'_rms = 2 sqrt(V).
        load = 2 * reduced_load(self.realised) * unit
        first = self.press(heights, load=load)
        before = pressed(first)
        sums: list[dict[str, Array]] = []
        bins: list[dict[str, Array]] = []
        areas = [[areas_of(first)] * 2]
        for step in self.steps:
            scaled = ring * np.sqrt(step * v / natural)
            pair = [self.press(heights + sign * scaled, load=load, start=first.pressure) for sign in (1, -1)]
            after = [pressed(result) for result in pair]
            sums.append(mean_of([flows(before, state, unit=unit) for state in after]))
            bins.append(mean_of([profile(before, state, unit=unit) for state in after]))
            areas.append([areas_of(result) for result in pair])
        data: dict[str, Any] = {"nominal": ((), load / unit)}
        return book_dataset(data, areas=areas, sums=sums, bins=bins)
