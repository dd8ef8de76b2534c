"""Stiffness matrix of the block from scikit-fem's forms, in 3 x 3 blocks per pair of nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fem_contact._types import Array, Numbers
from fem_contact.block.elements import LocalForms, lame, local_dilatation, local_shear
from fem_contact.block.mesh import BlockMesh

if TYPE_CHECKING:
    import scipy.sparse as sp


def assemble(mesh: BlockMesh, *, poisson: float, modulus: Array | None = None) -> sp.bsr_array:
    r"""Assemble the stiffness of the block with scikit-fem, over the modulus E.

    .. math:: K = \int \lambda\, (\nabla\!\cdot u)(\nabla\!\cdot v) + 2\mu\, \varepsilon(u):\varepsilon(v)

    Its blocks of 3 x 3 belong to the nodes (i ny + j) nk + k of nk planes, the clamped one included. The
    scalar forms int d_a u d_b v are integrated and combined, which gives the vector form's matrix at
    an eighth of its cost. nu is below 1/2; the modulus (nx, ny, nz) is that of each cell over E.
    """
    basis, lattice = mesh.basis()
    first, second = lame(poisson)
    forms = LocalForms.integrate(basis, mesh.element)
    weight = np.ones(basis.nelems)
    if modulus is not None:
        x, y, z = basis.mesh.doflocs[:, basis.mesh.dofs.element_dofs].mean(axis=1)
        i, j = np.floor(x).astype(np.int64), np.floor(y / mesh.aspect).astype(np.int64)
        weight = modulus[i, j, np.searchsorted(mesh.edges, z) - 1]
    rows, columns = lattice[forms.indices].reshape(2, -1)
    pattern = Pattern.build(rows, columns, size=lattice.size)
    data = np.empty((pattern.columns.size, 3, 3))
    for a in range(3):
        for b in range(3):
            block = first * local_dilatation(forms, a, b) + second * local_shear(forms, a, b)
            data[:, a, b] = pattern.summed((block * weight).ravel())
    return pattern.matrix(data)


def above_bottom(matrix: sp.bsr_array, mesh: BlockMesh) -> sp.bsr_array:
    """Return the part over the nodes above the clamped plane, numbered (i ny + j)(nk - 1) + k - 1."""
    above = np.repeat(np.arange(matrix.shape[0] // 3) % mesh.planes.size != 0, 3)
    return matrix.tocsr()[above][:, above].tobsr((3, 3))


@dataclass(frozen=True, kw_only=True)
class Pattern:
    """Sparsity pattern of a sum of element matrices."""

    positions: Numbers
    rows: Numbers
    columns: Numbers
    size: int

    @classmethod
    def build(cls, rows: Numbers, columns: Numbers, *, size: int) -> Pattern:
        """Find the blocks that entries at these rows and columns fall into."""
        keys, positions = np.unique(rows * size + columns, return_inverse=True)
        return cls(positions=positions, rows=keys // size, columns=keys % size, size=size)

    def summed(self, values: Array) -> Array:
        """Add entries up by block."""
        total: Array = np.bincount(self.positions, weights=values, minlength=self.columns.size).astype(float)
        return total

    def matrix(self, data: Array) -> sp.bsr_array:
        """Return the matrix of these blocks."""
        import scipy.sparse as sp

        counts = np.bincount(self.rows, minlength=self.size)
        indptr = np.concatenate(([0], np.cumsum(counts)))
        return sp.bsr_array((data, self.columns, indptr), shape=(3 * self.size, 3 * self.size))
