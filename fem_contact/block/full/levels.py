"""Grids of the multigrid: forces of the cells, relaxation of vertical lines, transfer between grids."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem_contact._types import Array, Mask, Numbers, Shape
from fem_contact.block.full import cell_kernels, kernels
from fem_contact.block.full.cells import BlockFactors
from fem_contact.block.full.stencil import LineFactors


@dataclass(frozen=True, kw_only=True)
class Transfer:
    """Linear interpolation along one axis, from a periodic grid of fewer nodes."""

    low: Numbers  # (n,): Coarse node at or before each fine node
    weight: Array  # (n,): Share of the coarse node after it
    size: int  # Coarse nodes

    @classmethod
    def between(cls, fine: int, coarse: int) -> Transfer:
        """Lay both grids over the same period with a node in common."""
        place = np.arange(fine) * coarse
        return cls(low=place // fine, weight=(place % fine) / fine, size=coarse)


@dataclass(frozen=True, kw_only=True)
class Level:
    """One grid of the hierarchy."""

    shape: Shape  # Columns along both axes
    area: float  # Of the cell, over the square of the finest cell width along x
    # What the cells of each layer do, over E times the finest cell width: of `stencil`, (nz, 3, 22), where
    # columns are alike; of `corner_coefficients`, (nz, 72), else, and then the moduli over E, (nx, ny, nz).
    cells: tuple[Array, ...]
    lines: LineFactors | BlockFactors
    down: tuple[Transfer, Transfer] | None  # Interpolation from the next coarser grid; None on the last

    @property
    def uniform(self) -> bool:
        """Whether all columns have the same rows."""
        return isinstance(self.lines, LineFactors)

    @property
    def field_shape(self) -> tuple[int, int, int, int]:
        """Shape of a displacement."""
        return *self.shape, len(self.cells[0]), 3

    def apply(self, u: Array) -> Array:
        """Sum the forces of the cells."""
        forces = np.empty(self.field_shape)
        kernel = kernels.apply_stencil if self.uniform else cell_kernels.apply_cells
        kernel(*self.cells, u, forces)
        return forces

    def relax(self, forces: Array, held: Mask, u: Array, *, backward: bool) -> None:
        """Solve every column for its own unknowns, in place; the tops of some are held."""
        kernel = kernels.relax if self.uniform else cell_kernels.relax_cells
        kernel(*self.cells, *self.lines, forces, held, u, backward)

    def prolonged(self, coarse: Array, onto: Array | None = None) -> Array:
        """Interpolate an array over the next coarser grid's columns to this one, and add it onto another."""
        fine = np.zeros((*self.shape, *coarse.shape[2:])) if onto is None else onto
        self._transfer(coarse, fine, gathering=False)
        return fine

    def restricted(self, fine: Array) -> Array:
        """Gather an array over this grid's columns on the next coarser one: the transpose of `prolonged`."""
        assert self.down is not None
        coarse = np.zeros((self.down[0].size, self.down[1].size, *fine.shape[2:]))
        self._transfer(coarse, fine, gathering=True)
        return coarse

    def _transfer(self, coarse: Array, fine: Array, *, gathering: bool) -> None:
        assert self.down is not None
        x, y = self.down
        flat = (field.reshape(*field.shape[:2], -1) for field in (coarse, fine))
        kernels.transfer(next(flat), x.low, x.weight, y.low, y.weight, next(flat), gathering)
