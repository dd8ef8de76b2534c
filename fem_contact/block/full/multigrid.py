"""Geometric multigrid for blocks of trilinear cells: coarser sideways, all layers kept.

Vertical lines are relaxed exactly, four colours in turn, so that neither thin layers at the surface nor thick
ones at the bottom slow it down; only sideways are grids coarsened, the shorter spacing first, down to a
single column, which lines solve exactly. The cells of a coarser grid are integrated anew.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fem_contact._types import Array, Mask
from fem_contact.block.full.cells import BlockFactors, corner_coefficients, overlap_means
from fem_contact.block.full.levels import Level, Transfer
from fem_contact.block.full.stencil import LineFactors, stencil
from fem_contact.block.mesh import BlockMesh

#: Spacings along both axes count as equal up to this ratio, and are then doubled together.
_ALIKE = 1.5
#: A coarse node is tied where this share of its weight lies on tied nodes.
_TIED_SHARE = 0.25


@dataclass(frozen=True, kw_only=True)
class Hierarchy:
    """Grids from the finest to a single column."""

    levels: tuple[Level, ...]
    depth: float  # Thickness of the block over the finest cell width

    def coarser(self) -> Hierarchy:
        """Return the hierarchy below the finest grid, in the same units."""
        return replace(self, levels=self.levels[1:])

    def tied(self, nodes: Mask) -> tuple[Mask, ...]:
        """Return the tied surface nodes of all grids for those of the finest."""
        masks = [np.ascontiguousarray(nodes)]
        for level in self.levels[:-1]:
            weight = level.restricted(np.ones((*level.shape, 1)))[:, :, 0]
            share = level.restricted(masks[-1].astype(float)[:, :, None])[:, :, 0] / weight
            masks.append(share >= _TIED_SHARE)
        return tuple(masks)

    def cycle(self, residual: Array, tied: tuple[Mask, ...], depth: int = 0) -> Array:
        """Approximate the displacement under a residual: a V-cycle, symmetric and positive."""
        level, held = self.levels[depth], tied[depth]
        u = np.zeros(level.field_shape)
        level.relax(residual, held, u, backward=False)
        if level.down is None:
            return u
        left = level.apply(u)
        np.subtract(residual, left, out=left)
        left[held, -1, 2] = 0
        following = level.lines.following(held)
        # The transpose of what the correction is kept to below.
        left[held, -1, 2] = -np.sum(left[held] * following, axis=(1, 2))
        coarse = level.restricted(left)
        del left
        level.prolonged(self.cycle(coarse, tied, depth + 1), onto=u)
        # A column whose top is held yields to it all the way down: thin layers would be torn otherwise.
        u[held] -= u[held, -1, 2][:, None, None] * following
        level.relax(residual, held, u, backward=True)
        return u


def build_hierarchy(mesh: BlockMesh, *, poisson: float, modulus: Array | None = None) -> Hierarchy:
    """Integrate the trilinear cells of all grids, however few.

    The modulus over E is that of each layer, from the bottom upwards, (nz,), or of each cell, (nx, ny, nz);
    that of a coarser cell is the mean over its volume.
    """
    levels: list[Level] = []
    shape, coarser = (0, 0), mesh.shape
    while coarser != shape:
        shape = coarser
        width, across = mesh.cells[0] / shape[0], mesh.aspect * mesh.cells[1] / shape[1]
        cells = replace(mesh, cells=shape, aspect=across / width, layers=mesh.layers / width)
        # Halved are the nodes along the axis of the shorter spacing, or along both where these are alike.
        least = min((h for n, h in zip(shape, (width, across), strict=True) if n > 1), default=0.0)
        coarser = (
            (shape[0] + 1) // 2 if width <= _ALIKE * least else shape[0],
            (shape[1] + 1) // 2 if across <= _ALIKE * least else shape[1],
        )
        down = None
        if coarser != shape:
            down = Transfer.between(shape[0], coarser[0]), Transfer.between(shape[1], coarser[1])
        if modulus is None or modulus.ndim == 1:
            rows = width * stencil(cells, poisson=poisson, modulus=modulus)
            coefficients: tuple[Array, ...] = (rows,)
            lines: LineFactors | BlockFactors = LineFactors.of(rows, shape)
        else:
            modulus = overlap_means(modulus, shape)
            corners = width * corner_coefficients(cells, poisson=poisson)
            coefficients = corners.reshape(mesh.nz, -1), modulus
            lines = BlockFactors.of(corners, modulus)
        levels.append(Level(shape=shape, area=width * across, cells=coefficients, lines=lines, down=down))
    return Hierarchy(levels=tuple(levels), depth=float(-mesh.planes[0]))
