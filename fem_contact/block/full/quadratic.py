r"""The stiffness of triquadratic cells by the parity of what deforms them.

A box is symmetric under its three mirrors. Along each axis the three nodes a, m, c of a cell hold two even
combinations, a + c and m, and an odd one, c - a. Sorted by how the mirrors turn their sign, the 81 unknowns
of a cell fall into eight classes, of 12, 12, 12, 12, 9, 9, 9 and 6, that do not know of each other: 855 of
the 6561 entries of the element matrix are left. `quadratic_kernels` multiplies by them; no matrix is stored.
"""

from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

import numpy as np

from fem_contact._types import Array, Numbers
from fem_contact.block.elements import ELEMENTS
from fem_contact.block.full.block import Block
from fem_contact.block.full.multigrid import Hierarchy, build_hierarchy
from fem_contact.block.full.quadratic_kernels import apply_quadratic
from fem_contact.block.mesh import BlockMesh, element_matrices

#: a + c, m and c - a from the nodes a, m, c of one axis, and whether they are odd.
_COMBINATIONS = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
_ODD = (0, 0, 1)
#: Poisson ratio of the trilinear cells where the solid's is larger: 0, .2, .4 and .45 take more steps.
_COMPRESSIBLE = 0.3


class ParityBlocks(NamedTuple):
    """Element matrices of the layers, class by class."""

    entries: Array  # (nz, 855): The blocks, row by row, one after the other, over E times the cell width
    sizes: Numbers  # (8,)
    # (3, 3, 3, 3): Row of each combination (x, y, z) of each component, classes one after the other.
    places: Numbers


def parity_blocks(mesh: BlockMesh, *, poisson: float) -> ParityBlocks:
    """Sort the element matrices of triquadratic cells by parity."""
    matrices, offsets = element_matrices(mesh, poisson, condensed=True)
    nodes = offsets @ np.array([9, 3, 1])
    unknowns = (3 * np.argsort(nodes)[:, None] + np.arange(3)).ravel()
    back = np.linalg.inv(_COMBINATIONS)
    change = np.kron(np.kron(np.kron(back, back), back), np.eye(3))
    folded = change.T @ matrices[:, unknowns[:, None], unknowns] @ change
    # A component changes sign under its own mirror.
    parity = [
        4 * (_ODD[x] ^ (t == 0)) + 2 * (_ODD[y] ^ (t == 1)) + (_ODD[z] ^ (t == 2))
        for x, y, z, t in np.ndindex(3, 3, 3, 3)
    ]
    order = np.argsort(parity, kind="stable")
    sizes, places = np.bincount(parity), np.empty(81, dtype=np.int64)
    places[order] = np.arange(81)
    classes = np.split(order, np.cumsum(sizes)[:-1])
    blocks = [folded[:, rows[:, None], rows].reshape(mesh.nz, -1) for rows in classes]
    return ParityBlocks(
        entries=np.concatenate(blocks, axis=1), sizes=sizes, places=places.reshape(3, 3, 3, 3)
    )


@dataclass(frozen=True, kw_only=True)
class QuadraticBlock(Block):
    """Triquadratic cells, preconditioned by the trilinear cells between their nodes."""

    mesh: BlockMesh
    cells: ParityBlocks
    modulus: Array  # (nx, ny, nz): Young's modulus of the cells over E

    refined: ClassVar[bool] = True

    def apply(self, field: Array) -> Array:
        """Sum the forces of the cells."""
        u = field.reshape(*self.shape, self.levels, 3)
        forces = np.zeros_like(u)
        apply_quadratic(*self.cells, self.modulus, u, forces)
        return forces.ravel()


def refined_hierarchy(mesh: BlockMesh, *, poisson: float, modulus: Array | None) -> Hierarchy:
    """Build the grids of trilinear cells whose nodes are those of triquadratic ones, in the latter's units.

    Both stiffnesses are spectrally equivalent: their ratio has bounds that do not depend on the grid. Near
    nu = 1/2 trilinear cells lock where ``Hex2/P1disc`` does not: those of a compressible solid serve it.
    """
    nx, ny = mesh.shape
    poisson = min(poisson, _COMPRESSIBLE) if mesh.element.pressures else poisson
    cells = replace(mesh, cells=(nx, ny), layers=np.repeat(mesh.layers, 2), element=ELEMENTS["Hex1"])
    # A cell has half the width, and so half the stiffness.
    halved = np.full(mesh.nz, 0.5) if modulus is None else 0.5 * modulus
    for axis in range(halved.ndim):
        halved = np.repeat(halved, 2, axis=axis)
    return replace(build_hierarchy(cells, poisson=poisson, modulus=halved), depth=float(-mesh.planes[0]))
