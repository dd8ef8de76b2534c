"""Contact areas of many surfaces of one spectrum, each with its mirror image -h, as one unit of work."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.area import EDGE_CONSTANTS, TRAITS, ContactAreas, contact_areas
from fem_contact.extrapolation import Limit
from validation.arrays import Array
from validation.measures.measurement import Grid, has_square_cells, limit_over
from validation.measures.without_solve import statistics_of_pair
from validation.scenes.realised import Realised
from validation.scenes.scene import EffectSpec
from validation.solves.press import Press
from validation.solves.solve import LOCATED_EDGES, NumbersSolve, Prediction

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["AreaPairs", "Areas"]

#: What is read off every solve; the located area is NaN where edges cannot be located.
_READ = ("pixel", "perimeter", "subcell", "edge_fraction", "seconds", "peak_bytes", *TRAITS)


@dataclass(frozen=True, kw_only=True)
class AreaPairs(NumbersSolve):
    """Contact areas of `count` pairs +h, -h, on ascending grids.

    Attributes
    ----------
    realised : Realised
        Surface, solid and one load.
    grids : tuple of (int, int)
    first, count : int
        Realisations. Each meets the load as a scene says it: p* of its own gradient, or one pressure for all.
    tolerance : float
        Of the solver.
    effects : tuple
        Of a scene. With any, edges are not located, and the corrected area stands for the area.
    """

    realised: Realised
    grids: tuple[Grid, ...]
    first: int
    count: int
    tolerance: float = 1e-6
    effects: tuple[EffectSpec, ...] = ()

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return self.realised.further(self.first).recipe | {
            "grids": [list(grid) for grid in self.grids],
            "count": self.count,
            "tolerance": self.tolerance,
            "effects": [effect.model_dump(mode="json", exclude_none=True) for effect in self.effects],
            "edges": LOCATED_EDGES,
        }

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"pairs-{self.grids[-1][0]}x{self.grids[-1][1]}"

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        return f"{self.count} pairs of surfaces, to {self.grids[-1][0]}x{self.grids[-1][1]}"

    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict the cost: two solves of each surface on each grid."""
        costs = [self._press(grid, self.realised).predict(pair_seconds=pair_seconds) for grid in self.grids]
        return Prediction(
            seconds=2 * self.count * sum(cost.seconds for cost in costs),
            peak_bytes=max(cost.peak_bytes for cost in costs),
            unknowns=max(cost.unknowns for cost in costs),
        )

    @property
    def code_path(self) -> tuple[str, ...]:
        """That of boundary elements with these effects."""
        return self._press(self.grids[0], self.realised).code_path

    def warm_up(self) -> None:
        """Load the compiled passes."""
        self._press(self.grids[0], self.realised).warm_up()

    def _press(self, grid: Grid, realised: Realised) -> Press:
        settings = (("tolerance", self.tolerance),)
        return Press(method="bem", grid=grid, realised=realised, settings=settings, effects=self.effects)

    def measure(self) -> xr.Dataset:
        """Solve everything; the areas (quantity, pair, sign, grid), and on a single grid the statistics of each pair."""
        import xarray as xr

        read = np.empty((len(_READ), self.count, 2, len(self.grids)))
        statistics: list[dict[str, float]] = []
        for k in range(self.count):
            own = self.realised.further(self.first + k)
            for sign, surface in enumerate((own, replace(own, inverted=not own.inverted))):
                for i, grid in enumerate(self.grids):
                    read[:, k, sign, i] = self._read_off(grid, surface)
            if len(self.grids) == 1:
                statistics.append(statistics_of_pair(own.heights(self.grids[0])))
        data: dict[str, Any] = {"read": (("quantity", "pair", "sign", "grid"), read)}
        if statistics:
            data["value"] = (("pair", "statistic"), [list(one.values()) for one in statistics])
        return xr.Dataset(data)

    def _read_off(self, grid: Grid, surface: Realised) -> tuple[float, ...]:
        began = time.process_time()
        result = self._press(grid, surface).do(threads=1).contact
        located = not self.effects and has_square_cells(surface, grid)
        areas = contact_areas(result, subcell=located)
        subcell = np.nan if areas.subcell is None else areas.subcell
        spent = time.process_time() - began
        told = areas.pixel, areas.perimeter, subcell, areas.edge_fraction, spent, result.cost.peak_bytes
        return (*told, *(getattr(areas, name) for name in TRAITS))


@dataclass(frozen=True, kw_only=True)
class Areas:
    """What `AreaPairs` read off, of surfaces that end with the same grid.

    Attributes
    ----------
    grids : tuple of (int, int)
    lengths : (float, float)
        Periods [m].
    read : (quantity, surface, grid) array
        Both signs of each pair, one after the other.
    """

    grids: tuple[Grid, ...]
    lengths: tuple[float, float]
    read: Array

    def on_grid(self, grid: int) -> Array:
        """Return A/A0 on one grid, (surface,): located where edges are, else corrected."""
        perimeter, subcell = self.read[1, :, grid], self.read[2, :, grid]
        return np.where(np.isnan(subcell), perimeter, subcell)

    def limits(self, last: int) -> list[Limit]:
        """Return the limit of each surface over the grids up to one."""
        return [
            limit_over([self._areas(k, grid) for grid in range(last + 1)]) for k in range(self.read.shape[1])
        ]

    @property
    def seconds(self) -> Array:
        """Processor time of each surface, on all grids."""
        return np.asarray(self.read[4].sum(axis=1))

    @property
    def peak_bytes(self) -> int:
        """Largest memory of the arrays of any solve."""
        return int(self.read[5].max())

    def _areas(self, surface: int, grid: int) -> ContactAreas:
        pixel, perimeter, subcell, fraction, _, _, *traits = self.read[:, surface, grid]
        shape = self.grids[grid]
        return ContactAreas(
            pixel=pixel,
            perimeter=perimeter,
            edge_length=np.nan,
            edge_fraction=fraction,
            edge_constant=EDGE_CONSTANTS["bem"],
            spacing=(self.lengths[0] / shape[0], self.lengths[1] / shape[1]),
            subcell=None if np.isnan(subcell) else subcell,
            cells=shape[0] * shape[1],
            **dict(zip(TRAITS, traits, strict=True)),
        )

    @classmethod
    def joined(cls, case: AreaPairs, parts: list[xr.Dataset]) -> Areas:
        """Put together what several calls of one kind have read."""
        read = np.concatenate([part.read.values for part in parts], axis=1)
        flat = read.reshape(len(_READ), -1, len(case.grids))
        return cls(grids=case.grids, lengths=case.realised.lengths, read=flat)
