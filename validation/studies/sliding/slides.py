"""One surface that slides at several velocities, on several grids, reduced to numbers."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.area import contact_areas
from fem_contact.sliding import SlidingContact, slide
from fem_contact.viscoelastic import PronySolid, TabulatedSolid
from validation.arrays import Grid
from validation.scenes.realised import Realised
from validation.solves.solve import LOCATED_EDGES, NumbersSolve, Prediction

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["QUANTITIES", "REMEMBERED", "SHARES", "Rubber", "SlideSolve"]

Rubber = PronySolid | TabulatedSolid

#: Shares g of the full energy that the theory's friction stores at vanishing contact, S = g + (1 - g) P^2.
SHARES = {1.0: "Persson, S = 1", 0.5: "S = 1/2 + P^2/2"}
#: |E| at the frequency of the period over E_0, above which the solid counts as remembering the period before.
REMEMBERED = 2.0
#: What is read off every solve.
QUANTITIES = {
    "friction": "mu / h'_rms by the pressure on the slopes",
    "dissipation": "mu / h'_rms by what the solid loses",
    "area": "A/A0, edge located inside the cells",
    "contraction": "factor by which a plain step of the solver shrinks the error",
    "steps": "steps of the solver",
    "fft_pairs": "pairs of Fourier transforms",
    "residual": "largest contact residual",
}


@dataclass(frozen=True, kw_only=True)
class SlideSolve(NumbersSolve):
    """One surface under its load at rising velocities, each started from the one before, on nested grids.

    Attributes
    ----------
    realised : Realised
        Surface and load; its solid is the relaxed one.
    rubber : PronySolid or TabulatedSolid
    velocities : tuple of float
        v [m/s] along x.
    grids : tuple of (int, int)
    """

    realised: Realised
    rubber: Rubber
    velocities: tuple[float, ...]
    grids: tuple[Grid, ...]

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        solid = {part.name: getattr(self.rubber, part.name) for part in fields(self.rubber) if part.init}
        return {
            **self.realised.recipe,
            "rubber": {name: list(v) if isinstance(v, tuple) else v for name, v in solid.items()},
            "velocities": list(self.velocities),
            "grids": [list(grid) for grid in self.grids],
            "edges": LOCATED_EDGES,
            "version": 1,
        }

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"slide-{max(self.grids)[0]}x{max(self.grids)[1]}"

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        nx, ny = max(self.grids)
        return f"slide, surface {self.realised.realisation + 1}, to {nx}x{ny}"

    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict the cost: some three hundred pairs of transforms for each velocity and grid."""
        points = [nx * ny for nx, ny in self.grids]
        return Prediction(
            seconds=len(self.velocities) * sum(0.03 + 1.2e-5 * n for n in points),
            peak_bytes=600 * max(points),
            unknowns=max(points),
        )

    def measure(self) -> xr.Dataset:
        """Solve everything and keep the numbers; dimensions (grid, velocity)."""
        import xarray as xr

        values = {name: np.empty((len(self.grids), len(self.velocities))) for name in QUANTITIES}
        for i, grid in enumerate(self.grids):
            heights, start = self.realised.heights(grid), None
            for k, velocity in enumerate(self.velocities):
                found = slide(
                    heights,
                    self.rubber,
                    velocity=velocity,
                    mean_pressure=self.realised.pressure,
                    start=start,
                    threads=1,
                ).checked()
                start = found.contact.pressure
                for name, value in self._read_off(found).items():
                    values[name][i, k] = value
        return xr.Dataset({name: (("grid", "velocity"), values[name]) for name in QUANTITIES})

    def _read_off(self, found: SlidingContact) -> dict[str, float]:
        """Return every one of `QUANTITIES` of one solve."""
        gradient, contact = self.realised.field.rms_gradient, found.contact
        located = contact_areas(contact, subcell=True).subcell
        assert located is not None
        return {
            "friction": found.friction / gradient,
            "dissipation": found.dissipation / gradient,
            "area": located,
            "contraction": found.contraction,
            "steps": contact.cost.iterations,
            "fft_pairs": contact.cost.fft_pairs,
            "residual": contact.residuals.worst,
        }
