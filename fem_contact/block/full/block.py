"""Blocks as the active set sees them: forces of a displacement, and a preconditioner for every set."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from fem_contact.block.mesh import BlockMesh

__all__ = ["Block", "MeshedBlock", "SetPreconditioner"]

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
