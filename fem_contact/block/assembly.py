"""Stiffness matrix of the block from scikit-fem's forms, in 3 x 3 blocks per pair of nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fem_contact.errors import InvalidInput

if TYPE_CHECKING:
    import scipy.sparse as sp

    from fem_contact.block.mesh import BlockMesh

__all__ = ["Stiffness", "assemble", "lame"]

Array = NDArray[np.float64]


def lame(poisson: float) -> tuple[float, float]:
    """Lame's constants (lambda, mu) over Young's modulus.

    Raises
    ------
    InvalidInput
        For an incompressible solid, whose lambda is infinite.
    """
    if not -1 < poisson < 0.5:
        raise InvalidInput(f"poisson = {poisson!r}: must lie in (-1, 0.5) for elements of displacement alone")
    return poisson / ((1 + poisson) * (1 - 2 * poisson)), 0.5 / (1 + poisson)


@dataclass(frozen=True, kw_only=True)
class Stiffness:
    """Stiffness of the whole block, clamped planes included, over the modulus E.

    Attributes
    ----------
    matrix : scipy.sparse.bsr_array
        Blocks of 3 x 3 over the lattice nodes (i ny + j)(nz + 1) + k; symmetric.
    """

    matrix: sp.bsr_array
    mesh: BlockMesh

    def free(self) -> sp.bsr_array:
        """Return the part over the nodes above the clamped bottom, numbered (i ny + j) nz + k - 1."""
        import scipy.sparse as sp

        nodes = self.matrix.shape[0] // 3
        above = np.arange(nodes) % (self.mesh.nz + 1) != 0
        number = np.cumsum(above) - 1
        rows = np.repeat(np.arange(nodes), np.diff(self.matrix.indptr))
        keep = above[rows] & above[self.matrix.indices]
        counts = np.bincount(number[rows[keep]], minlength=int(above.sum()))
        indptr = np.concatenate(([0], np.cumsum(counts)))
        size = 3 * int(above.sum())
        blocks = (self.matrix.data[keep], number[self.matrix.indices[keep]], indptr)
        return sp.bsr_array(blocks, shape=(size, size))


def assemble(mesh: BlockMesh, *, poisson: float, modulus: Array | None = None) -> Stiffness:
    r"""Assemble the stiffness of the block with scikit-fem.

    .. math:: K = \int \lambda\, (\nabla\!\cdot u)(\nabla\!\cdot v) + 2\mu\, \varepsilon(u):\varepsilon(v)

    The nine scalar forms int d_a u d_b v are assembled and combined, which gives the vector form's matrix at
    an eighth of its cost.

    Parameters
    ----------
    mesh : BlockMesh
    poisson : float
        Poisson ratio, below 1/2.
    modulus : (nx, ny, nz) array, optional
        Young's modulus of each cell over the reference modulus; 1 by default.
    """
    basis, lattice = mesh.basis()
    first, second = lame(poisson)
    local, indices = _gradient_products(basis)
    weight = np.ones(basis.mesh.t.shape[1])
    if modulus is not None:
        weight = modulus[_cells(basis, mesh)]
    pattern = _Pattern.build(lattice[indices[0]], lattice[indices[1]], size=lattice.size)
    data = np.empty((pattern.columns.size, 3, 3))
    for a in range(3):
        for b in range(3):
            # Entry (i, j) of a local matrix belongs to test function i and trial function j.
            block = first * _local(local, b, a) + second * _local(local, a, b)
            if a == b:
                block = block + second * (local[0, 0] + local[1, 1] + local[2, 2])
            data[:, a, b] = pattern.summed((block * weight).ravel())
    return Stiffness(matrix=pattern.matrix(data), mesh=mesh)


def _gradient_products(basis: Any) -> tuple[dict[tuple[int, int], Array], NDArray[np.int64]]:
    """Element matrices (8, 8, cells) of int d_a u d_b v for a <= b, and the indices of their entries."""
    from skfem import BilinearForm

    products = {}
    indices = np.empty((2, 0), dtype=np.int64)
    for a in range(3):
        for b in range(a, 3):

            def form(u: Any, v: Any, w: Any, a: int = a, b: int = b) -> Any:
                return u.grad[a] * v.grad[b]

            coo = BilinearForm(form).coo_data(basis)
            products[a, b] = coo.data.reshape(8, 8, -1)
            indices = coo.indices
    return products, indices


def _local(products: dict[tuple[int, int], Array], trial: int, test: int) -> Array:
    """Element matrices of int d_trial u d_test v."""
    if trial <= test:
        return products[trial, test]
    return products[test, trial].swapaxes(0, 1)


def _cells(basis: Any, mesh: BlockMesh) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Return the indices (i, j, k) of scikit-fem's cells."""
    points = basis.mesh.doflocs[:, basis.mesh.dofs.element_dofs].mean(axis=1)
    k = np.searchsorted(mesh.planes, points[2]) - 1
    return np.floor(points[0]).astype(np.int64), np.floor(points[1] / mesh.aspect).astype(np.int64), k


@dataclass(frozen=True, kw_only=True)
class _Pattern:
    """Sparsity pattern of a sum of element matrices."""

    positions: NDArray[np.int64]
    rows: NDArray[np.int64]
    columns: NDArray[np.int64]
    size: int

    @classmethod
    def build(cls, rows: NDArray[np.int64], columns: NDArray[np.int64], *, size: int) -> _Pattern:
        keys, positions = np.unique(rows * size + columns, return_inverse=True)
        return cls(positions=positions, rows=keys // size, columns=keys % size, size=size)

    def summed(self, values: Array) -> Array:
        total: Array = np.bincount(self.positions, weights=values, minlength=self.columns.size).astype(float)
        return total

    def matrix(self, data: Array) -> sp.bsr_array:
        import scipy.sparse as sp

        counts = np.bincount(self.rows, minlength=self.size)
        indptr = np.concatenate(([0], np.cumsum(counts)))
        return sp.bsr_array((data, self.columns, indptr), shape=(3 * self.size, 3 * self.size))
