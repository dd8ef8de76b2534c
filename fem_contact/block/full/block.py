"""Blocks as the active set sees them: forces of a displacement, and a preconditioner for every set."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from fem_contact.block.full.linear import factorised, rigid_modes, smoothed_aggregation

if TYPE_CHECKING:
    import scipy.sparse as sp

    from fem_contact.block.mesh import BlockMesh

__all__ = ["AssembledBlock", "Block", "MeshedBlock", "SetPreconditioner"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


class SetPreconditioner(Protocol):
    """An approximate solution of the linear problem of one active set."""

    @property
    def nbytes(self) -> int:
        """Memory it holds."""
        ...

    def apply(self, residual: Array, load: float | None) -> tuple[Array, float]:
        """Displacement and offset answering a residual that vanishes at tied unknowns, and a residual load.

        Where the load is None the offset is held.
        """
        ...


@dataclass(frozen=True, kw_only=True)
class Block(ABC):
    """A block that displacements can be applied to, and the profile pressed into it.

    Displacements are flat arrays over the nodes above the clamped plane, numbered (i ny + j) nz + k.

    Attributes
    ----------
    heights : (nx, ny) array
        Profile over the cell width, positive into the block.
    bound : (nx, ny) array or None
        Largest nodal force, over E times the cell width squared.
    """

    heights: Array
    bound: Array | None = None

    @property
    @abstractmethod
    def levels(self) -> int:
        """Planes of nodes above the clamped one."""

    @property
    @abstractmethod
    def depth(self) -> float:
        """Thickness over the cell width."""

    @abstractmethod
    def apply(self, field: Array) -> Array:
        """Nodal forces over E times the cell width squared under a displacement, flat arrays."""

    @abstractmethod
    def preconditioner(self, nodes: Mask) -> SetPreconditioner:
        """Prepare the linear problem in which the profile's nodes move alike."""

    @property
    def shape(self) -> tuple[int, int]:
        """Surface nodes along both axes."""
        nx, ny = self.heights.shape
        return nx, ny

    def vertical(self, nodes: Mask) -> NDArray[np.int64]:
        """Numbers of the vertical unknowns at surface nodes."""
        return 3 * (np.flatnonzero(nodes) * self.levels + self.levels - 1) + 2

    def force_scale(self, nodes: Mask, offset: float, *, load: float | None) -> float:
        """Smallest norm that the contact forces of one set can have, for the linear tolerance to refer to.

        With a prescribed offset it is that of the deepest node's indentation spread over the depth.
        """
        if load is not None:
            return load / math.sqrt(max(int(nodes.sum()), 1))
        deepest = float(np.max(self.heights)) - offset
        return deepest / self.depth

    def surface(self, field: Array) -> Array:
        """Vertical component at the surface of a field over all unknowns, (nx, ny)."""
        return field.reshape(*self.shape, self.levels, 3)[:, :, -1, 2]


@dataclass(frozen=True, kw_only=True)
class MeshedBlock(Block):
    """A block that knows its mesh.

    Attributes
    ----------
    mesh : BlockMesh
    """

    mesh: BlockMesh

    @property
    def levels(self) -> int:
        """Planes of nodes above the clamped one."""
        return self.mesh.planes.size - 1

    @property
    def depth(self) -> float:
        """Thickness over the cell width."""
        return float(-self.mesh.planes[0])


@dataclass(frozen=True, kw_only=True)
class AssembledBlock(MeshedBlock):
    """The assembled stiffness.

    Attributes
    ----------
    matrix : scipy.sparse.bsr_array
        Stiffness above the clamped plane, over E.
    direct : bool
        Precondition by a factorisation, which takes smoothed aggregation's place where that crawls and the
        block is small.
    """

    matrix: sp.bsr_array
    direct: bool = False

    def apply(self, field: Array) -> Array:
        """Multiply by the matrix."""
        forces: Array = self.matrix @ field
        return forces

    def preconditioner(self, nodes: Mask) -> SetPreconditioner:
        """Take the tied unknowns out of the matrix and precondition the rest."""
        return _AssembledPreconditioner(self, nodes)

    @cached_property
    def modes(self) -> Array:
        """Rigid-body modes at the free nodes."""
        (nx, ny), z = self.mesh.shape, self.mesh.planes[1:]
        order = self.mesh.element.order
        grid = np.meshgrid(np.arange(nx) / order, np.arange(ny) * self.mesh.aspect / order, z, indexing="ij")
        return rigid_modes(np.stack(grid, axis=-1).reshape(-1, 3))

    @cached_property
    def rows(self) -> NDArray[np.int64]:
        """Block row of every stored block."""
        return np.repeat(np.arange(self.matrix.indptr.size - 1), np.diff(self.matrix.indptr))

    def without(self, tied: NDArray[np.int64]) -> tuple[sp.bsr_array, Mask]:
        """Return the matrix with rows and columns of some unknowns emptied, and their mask."""
        import scipy.sparse as sp

        matrix, rows = self.matrix, self.rows
        fixed: Mask = np.zeros(matrix.shape[0], dtype=bool)
        fixed[tied] = True
        per_node = np.reshape(fixed, (-1, 3))
        node = np.asarray(per_node.any(axis=1))
        data = matrix.data.copy()
        touched = np.flatnonzero(node[rows] | node[matrix.indices])
        data[touched] *= ~per_node[rows[touched]][:, :, None]
        data[touched] *= ~per_node[matrix.indices[touched]][:, None, :]
        own = touched[rows[touched] == matrix.indices[touched]]
        # The diagonal stays, so that every row of the reduced matrix has the size of its neighbours.
        kept = matrix.data[own].diagonal(axis1=1, axis2=2) * per_node[rows[own]]
        data[own] += kept[:, :, None] * np.eye(3)
        return sp.bsr_array((data, matrix.indices, matrix.indptr), shape=matrix.shape), fixed


class _AssembledPreconditioner:
    """Smoothed aggregation on the free unknowns; the offset by its Schur complement."""

    def __init__(self, block: AssembledBlock, nodes: Mask) -> None:
        self.tied = block.vertical(nodes)
        matrix, fixed = block.without(self.tied)
        modes = block.modes * ~fixed[:, None]
        self.inverse = factorised(matrix) if block.direct else smoothed_aggregation(matrix, modes)
        self.nbytes = int(matrix.data.nbytes) + self.inverse.nbytes
        unit = np.zeros(matrix.shape[0])
        unit[self.tied] = 1
        coupling = block.apply(unit)
        diagonal = float(coupling[self.tied].sum())
        coupling[self.tied] = 0
        self.answer = self._free(coupling)
        # One cycle never overestimates the inverse, so the Schur complement stays positive.
        self.schur = diagonal - float(coupling @ self.answer)

    def _free(self, residual: Array) -> Array:
        result = self.inverse.apply(residual)
        result[self.tied] = 0
        return result

    def apply(self, residual: Array, load: float | None) -> tuple[Array, float]:
        free = self._free(residual)
        if load is None:
            return free, 0.0
        shift = (load - float(self.answer @ residual)) / self.schur
        return free - shift * self.answer, shift
