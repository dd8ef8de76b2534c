"""Blocks as the active set sees them: forces of a displacement, and a preconditioner for every set."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fem_contact._types import Array, Mask, Numbers, Shape
from fem_contact.block.full.levels import Transfer
from fem_contact.block.full.multigrid import Hierarchy

#: Least ratio of what the bound can carry and the load on a coarser grid.
_CARRYING = 1.01


@dataclass(frozen=True, kw_only=True)
class Block:
    """The trilinear cells of a hierarchy's finest grid, and the profile pressed into them.

    Displacements are flat arrays over the nodes above the clamped plane, numbered (i ny + j) nz + k.
    """

    hierarchy: Hierarchy
    heights: Array  # (nx, ny): Profile over the cell width, positive into the block
    bound: Array | None = None  # (nx, ny): Largest nodal force, over E times the cell width squared

    #: Whether the hierarchy's cells are others than the block's.
    refined: ClassVar[bool] = False

    def coarser(self, *, load: float | None) -> Block:
        """Return the profile on the next coarser grid, under a bound that can carry the load there."""
        fine, coarse = self.hierarchy.levels[:2]
        heights, bound = _sampled(self.heights, coarse.shape), None
        if self.bound is not None:
            bound = _sampled(self.bound, coarse.shape) * (coarse.area / fine.area)
            if load is not None:
                bound *= max(1.0, _CARRYING * load / float(bound.sum()))
        return Block(hierarchy=self.hierarchy.coarser(), heights=heights, bound=bound)

    @property
    def levels(self) -> int:
        """Planes of nodes above the clamped one."""
        return self.hierarchy.levels[0].field_shape[2]

    @property
    def shape(self) -> Shape:
        """Surface nodes along both axes."""
        nx, ny = self.heights.shape
        return nx, ny

    def apply(self, field: Array) -> Array:
        """Nodal forces over E times the cell width squared under a displacement, flat arrays."""
        level = self.hierarchy.levels[0]
        return level.apply(field.reshape(level.field_shape)).ravel()

    def vertical(self, nodes: Mask) -> Numbers:
        """Numbers of the vertical unknowns at surface nodes."""
        return 3 * (np.flatnonzero(nodes) * self.levels + self.levels - 1) + 2

    def force_scale(self, nodes: Mask, offset: float, *, load: float | None) -> float:
        """Smallest norm that the contact forces of one set can have, for the linear tolerance to refer to.

        With a prescribed offset it is that of the deepest node's indentation spread over the depth.
        """
        if load is not None:
            return load / math.sqrt(max(int(nodes.sum()), 1))
        deepest = float(np.max(self.heights)) - offset
        return deepest / self.hierarchy.depth

    def surface(self, field: Array) -> Array:
        """Vertical component at the surface of a field over all unknowns, (nx, ny)."""
        return field.reshape(*self.shape, self.levels, 3)[:, :, -1, 2]


def _sampled(values: Array, shape: Shape) -> Array:
    """Interpolate a periodic array linearly at the nodes of a coarser grid."""
    for axis in (0, 1):
        at = Transfer.between(shape[axis], values.shape[axis])
        along = np.reshape(at.weight, (-1, 1) if axis == 0 else (1, -1))
        after = np.take(values, (at.low + 1) % at.size, axis=axis)
        values = (1 - along) * np.take(values, at.low, axis=axis) + along * after
    return np.ascontiguousarray(values)


class CyclePreconditioner:
    """One cycle on the free unknowns; the offset by its Schur complement."""

    def __init__(self, block: Block, nodes: Mask) -> None:
        self.hierarchy, self.tied = block.hierarchy, block.hierarchy.tied(nodes)
        self.field_shape = self.hierarchy.levels[0].field_shape
        held = block.vertical(nodes)
        unit = np.zeros(int(np.prod(self.field_shape)))
        unit[held] = 1
        coupling = block.apply(unit)
        diagonal = float(coupling[held].sum())
        coupling[held] = 0
        answer, share = self._free(coupling), 1.0
        moment = float(coupling @ answer)
        if block.refined or not self.hierarchy.levels[0].uniform:
            # A cycle on other cells or mean moduli may overestimate the inverse; scaled to the least energy,
            # the answer still leaves a positive complement. On the same cells it never does.
            image = block.apply(answer)
            image[held] = 0
            energy = float(answer @ image)
            share = moment / energy if energy > 0 else 0.0
        self.answer = share * answer
        self.schur = diagonal - share * moment
        self.nbytes = 5 * self.answer.nbytes

    def _free(self, residual: Array) -> Array:
        return self.hierarchy.cycle(residual.reshape(self.field_shape), self.tied).ravel()

    def apply(self, residual: Array, load: float | None) -> tuple[Array, float]:
        """Displacement and offset answering a residual; the offset is held where the load is None."""
        free = self._free(residual)
        if load is None:
            return free, 0.0
        shift = (load - float(self.answer @ residual)) / self.schur
        free -= shift * self.answer
        return free, shift
