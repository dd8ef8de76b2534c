r"""The stiffness of a block of trilinear cells as what one column of nodes sees of its eight neighbours.

The weak form is that of `assembly`,

.. math:: K = \int \lambda\, (\nabla\!\cdot u)(\nabla\!\cdot v) + 2\mu\, \varepsilon(u):\varepsilon(v),

and scikit-fem integrates it over one column of cells. Where the material varies in depth only, every column
of nodes has the same rows: the sum of the cells around one is kept instead of a matrix, and
`kernels.apply_stencil` multiplies by it. Boxes are symmetric under mirrors, so that neighbours on opposite
sides share a coefficient up to its sign, and 22 of the 81 coefficients of a plane are left.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fem_contact._types import Array, Mask, Shape
from fem_contact.block.mesh import BlockMesh, element_matrices

#: Coefficients in the order of the kernels: component of the force, of the displacement, and the neighbour
#: (x, y) that stands for its mirror images; odd along x (y) where exactly one of the components is x (y).
TERMS = tuple(
    (a, b, right, ahead)
    for a, b in ((0, 0), (1, 0), (2, 0), (1, 1), (0, 1), (2, 1), (2, 2), (0, 2), (1, 2))
    for ahead in range((a == 1) != (b == 1), 2)
    for right in range((a == 0) != (b == 0), 2)
)

#: Numbers in `TERMS` of a component's coupling to itself: own column, neighbours along x, along y, diagonal.
_OWN = ((0, 1, 2, 3), (7, 8, 9, 10), (14, 15, 16, 17))


def stencil(mesh: BlockMesh, *, poisson: float, modulus: Array | None) -> Array:
    """Sum the trilinear cells around the nodes of one column, for nu below 1/2.

    The modulus (nz,) is that of each layer over E, from the bottom upwards; 1 by default. Returned are, for
    every plane above the clamped one, (nz, 3, 22), the coefficients `TERMS` of the forces that it causes on
    the plane below it, itself and the plane above, over E times the cell width.
    """
    matrices, offsets = element_matrices(mesh, poisson)
    if modulus is not None:
        matrices = matrices * modulus[:, None, None]
    corners = offsets // 2
    planes = np.zeros((mesh.nz + 1, 3, len(TERMS)))
    for test, (i, j, k) in enumerate(corners):
        for trial, neighbour in enumerate(corners):
            x, y, z = neighbour - (i, j, k)
            upper = neighbour[2]
            for term, (a, b, right, ahead) in enumerate(TERMS):
                if (right, ahead) == (x, y):
                    planes[upper : upper + mesh.nz, 1 - z, term] += matrices[:, 3 * test + a, 3 * trial + b]
    return planes[1:].copy()


class LineFactors(NamedTuple):
    """A column's coupling to itself, factorised: three tridiagonal matrices L D L'."""

    low: Array  # (nz, 3): Below the diagonal of L; its first row is 0
    reciprocal: Array  # (nz, 3): 1 / D

    @classmethod
    def of(cls, coefficients: Array, shape: Shape) -> LineFactors:
        """Factorise; where a grid is one node wide, a column is its own neighbour."""
        x, y = (2.0 if n == 1 else 0.0 for n in shape)
        share = np.array([1, x, y, x * y])
        low, reciprocal = np.zeros((len(coefficients), 3)), np.zeros((len(coefficients), 3))
        for component, terms in enumerate(_OWN):
            below, diagonal = (coefficients[:, plane][:, terms] @ share for plane in (0, 1))
            pivot = diagonal[0]
            reciprocal[0, component] = 1 / pivot
            for k in range(1, len(diagonal)):
                low[k, component] = below[k] / pivot
                pivot = diagonal[k] - low[k, component] * below[k]
                reciprocal[k, component] = 1 / pivot
        return cls(low=low, reciprocal=reciprocal)

    def following(self, held: Mask) -> Array:
        """Displacement (1, nz, 3) of held columns whose top is moved by one, their neighbours fixed."""
        follow = np.zeros((1, *self.low.shape))
        follow[0, -1, 2] = 1
        follow[0, :-1, 2] = np.cumprod(-self.low[:0:-1, 2])[::-1]
        return follow
