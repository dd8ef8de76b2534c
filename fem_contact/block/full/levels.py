"""Grids of the multigrid: forces of the cells, relaxation of vertical lines, transfer between grids."""

from __future__ import annotations

from abc import ABC, abstractmethod
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
class Level(ABC):
    """One grid of the hierarchy."""

    shape: Shape  # Columns along both axes
    area: float  # Of the cell, over the square of the finest cell width along x
    coefficients: Array  # (nz, ...): What the cells of each layer do, over E times the finest cell width
    down: tuple[Transfer, Transfer] | None  # Interpolation from the next coarser grid; None on the last

    @abstractmethod
    def apply(self, u: Array) -> Array:
        """Sum the forces of the cells."""

    @abstractmethod
    def relax(self, forces: Array, held: Mask, u: Array, *, backward: bool) -> None:
        """Solve every column for its own unknowns, in place; the tops of some are held."""

    @abstractmethod
    def following(self, held: Mask) -> Array:
        """Displacement (m or 1, nz, 3) of held columns whose top is moved by one, their neighbours fixed."""

    @property
    def field_shape(self) -> tuple[int, int, int, int]:
        """Shape of a displacement."""
        return *self.shape, len(self.coefficients), 3

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


@dataclass(frozen=True, kw_only=True)
class StencilLevel(Level):
    """A grid whose columns all have the same rows: the coefficients are those of `stencil`."""

    lines: LineFactors

    def apply(self, u: Array) -> Array:
        """Sum the forces of the cells."""
        forces = np.empty(self.field_shape)
        kernels.apply_stencil(self.coefficients, u, forces)
        return forces

    def relax(self, forces: Array, held: Mask, u: Array, *, backward: bool) -> None:
        """Solve every column for its own unknowns, in place."""
        kernels.relax(self.coefficients, self.lines.low, self.lines.reciprocal, forces, held, u, backward)

    def following(self, held: Mask) -> Array:
        """Displacement of a column whose top is moved by one."""
        field = np.zeros((1, len(self.coefficients), 3))
        field[0, :, 2] = self.lines.tied
        return field


@dataclass(frozen=True, kw_only=True)
class CellLevel(Level):
    """A grid whose cells have a modulus each: the coefficients are `corner_coefficients`, (nz, 72)."""

    modulus: Array  # (nx, ny, nz): Young's modulus of the cells over E
    lines: BlockFactors

    def apply(self, u: Array) -> Array:
        """Sum the forces of the cells."""
        forces = np.empty(self.field_shape)
        cell_kernels.apply_cells(self.coefficients, self.modulus, u, forces)
        return forces

    def relax(self, forces: Array, held: Mask, u: Array, *, backward: bool) -> None:
        """Solve every column for its own unknowns, in place."""
        lines = self.lines.low, self.lines.inverse, self.lines.follow
        cell_kernels.relax_cells(self.coefficients, self.modulus, *lines, forces, held, u, backward)

    def following(self, held: Mask) -> Array:
        """Displacement of the held columns where their top is moved by one."""
        return self.lines.follow[held]
