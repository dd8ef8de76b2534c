r"""The stiffness of trilinear cells with a modulus each, column by column.

Where the modulus varies sideways, no two columns of nodes have the same rows, and a cell's element matrix
times its modulus is all that can be shared. A column meets four stacks of cells, mirror images of each other.
On one of them the sums and differences of the values above and below a cell decouple by parity: 2 x 3 x 12
coefficients for each layer, which `cell_kernels` multiplies by. No matrix is stored but that of a column's
coupling to itself, which is factorised to relax it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fem_contact._types import Array, Mask, Shape
from fem_contact.block.mesh import BlockMesh, element_matrices

#: Neighbours of a column on the stack of cells towards +x and +y: itself, along x, along y, the diagonal one.
_SIDES = ((0, 0), (1, 0), (0, 1), (1, 1))
#: Sign of the cells on the four sides of a column, in x and in y.
_QUADRANTS = ((1, 1), (-1, 1), (1, -1), (-1, -1))


def corner_coefficients(mesh: BlockMesh, *, poisson: float) -> Array:
    """Return the forces on the two nodes of one vertical edge of a cell of modulus 1.

    With t and b the values above and below, the components (t + b of x and y, t - b of z) cause half the
    sum of the forces along x and y and half the difference of those along z; this is parity 0. Parity 1 is
    the rest. The shape is (nz, 2, 3, 4, 3): layer from the bottom upwards, parity, component of the force,
    column `_SIDES` of nodes, component of the displacement, over E times the cell width.
    """
    matrices, offsets = element_matrices(mesh, poisson, condensed=True)
    number = {tuple(int(n) for n in corner // 2): 3 * place for place, corner in enumerate(offsets)}
    table = np.empty((mesh.nz, 2, 3, 4, 3))
    for side, (x, y) in enumerate(_SIDES):
        for a in range(3):
            for b in range(3):
                # By symmetry what acts on the upper node is enough.
                above, below = (matrices[:, number[0, 0, 1] + a, number[x, y, z] + b] for z in (1, 0))
                even, odd = 0.5 * (above + below), 0.5 * (above - below)
                # z_d and z_s: differences and sums change places.
                table[:, 0, a, side, b], table[:, 1, a, side, b] = (odd, even) if b == 2 else (even, odd)
    return table


def overlap_means(modulus: Array, shape: Shape) -> Array:
    """Mean modulus of the cells of a coarser grid over the same periods, from (nx, ny, nz)."""
    for axis, coarse in enumerate(shape):
        fine = modulus.shape[axis]
        if coarse == fine:
            continue
        edges, cells = np.arange(fine + 1) / fine, np.arange(coarse)[:, None]
        share = np.diff(np.clip(edges, cells / coarse, (cells + 1) / coarse)) * coarse
        modulus = np.moveaxis(np.tensordot(share, modulus, axes=(1, axis)), 0, axis)
    return np.ascontiguousarray(modulus)


class BlockFactors(NamedTuple):
    """Every column's coupling to itself, factorised: L S L' in blocks of 3 x 3 per plane."""

    low: Array  # (nx, ny, nz, 3, 3): Below the diagonal of L; zero on the lowest plane
    inverse: Array  # (nx, ny, nz, 3, 3): Of the pivots S
    # (nx, ny, nz, 3): Displacement of a column whose top is moved by one upwards, its neighbours held.
    follow: Array

    @classmethod
    def of(cls, coefficients: Array, modulus: Array) -> BlockFactors:
        """Factorise; where a grid is one node wide, a column is its own neighbour."""
        diagonal, below = _self_coupling(coefficients, modulus)
        low, inverse = np.zeros_like(diagonal), np.empty_like(diagonal)
        inverse[:, :, 0] = np.linalg.inv(diagonal[:, :, 0])
        for k in range(1, diagonal.shape[2]):
            low[:, :, k] = below[:, :, k] @ inverse[:, :, k - 1]
            inverse[:, :, k] = np.linalg.inv(diagonal[:, :, k] - low[:, :, k] @ below[:, :, k].swapaxes(2, 3))
        follow = np.empty(diagonal.shape[:-1])
        # The answer to a vertical force on the top, scaled.
        follow[:, :, -1] = inverse[:, :, -1, :, 2] / inverse[:, :, -1, 2:, 2]
        for k in range(diagonal.shape[2] - 2, -1, -1):
            follow[:, :, k] = -np.einsum("xyab,xya->xyb", low[:, :, k + 1], follow[:, :, k + 1])
        return cls(low=low, inverse=inverse, follow=follow)

    def following(self, held: Mask) -> Array:
        """Displacement (m, nz, 3) of held columns whose top is moved by one, their neighbours fixed."""
        return self.follow[held]


def _self_coupling(coefficients: Array, modulus: Array) -> tuple[Array, Array]:
    """Blocks (nx, ny, nz, 3, 3) over E of a column's planes with themselves and with the planes below.

    `coefficients` are `corner_coefficients`; plane k is the upper one of layer k, from the bottom.
    """
    nx, ny, nz = modulus.shape
    # Where a grid is one node wide its neighbours are the column itself.
    sides = [side for side, (x, y) in enumerate(_SIDES) if not (x and nx > 1) and not (y and ny > 1)]
    even, odd = (coefficients[:, parity][:, :, sides].sum(axis=2) for parity in (0, 1))
    # Back from sums and differences: the upper node's answer to the upper and to the lower one.
    flip = np.array([1.0, 1.0, -1.0])
    up, across = even + odd, (even - odd) * flip
    diagonal, below = np.zeros((nx, ny, nz, 3, 3)), np.zeros((nx, ny, nz, 3, 3))
    for x, y in _QUADRANTS:
        stack = np.roll(modulus, (x < 0, y < 0), axis=(0, 1))[:, :, :, None, None]
        signs = np.outer((x, y, 1.0), (x, y, 1.0))
        diagonal += stack * (up * signs)
        below += stack * (across * signs)
        # The lower node is the mirror image of the upper one.
        diagonal[:, :, :-1] += stack[:, :, 1:] * (up[1:] * signs * np.outer(flip, flip))
    return diagonal, below
