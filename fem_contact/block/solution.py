"""What the block returns: the contact result, the displacement field, and the stress read off it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem_contact.block.assembly import lame
from fem_contact.contact import ContactResult
from fem_contact.solid import Solid

__all__ = ["BlockSolution", "CellStress"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class CellStress:
    """Stress at the centres of the cells, tension positive.

    Attributes
    ----------
    tensor : (nx, ny, nz, 6) array
        Components xx, yy, zz, yz, xz, xy [Pa].
    """

    tensor: Array

    @property
    def von_mises(self) -> Array:
        """Von Mises stress of every cell [Pa], (nx, ny, nz)."""
        xx, yy, zz, yz, xz, xy = np.moveaxis(self.tensor, -1, 0)
        normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
        return np.asarray(np.sqrt(0.5 * normal + 3 * (yz**2 + xz**2 + xy**2)))


@dataclass(frozen=True, kw_only=True)
class BlockSolution:
    """A contact problem solved with finite elements.

    Attributes
    ----------
    contact : ContactResult
        Pressure (nodal force over cell area), gap and contact set at the surface nodes.
    solid : Solid
        Reference solid: Poisson ratio, and the modulus that `modulus` multiplies.
    planes : (nz + 1,) array
        z of the planes of nodes [m], from -depth to 0.
    field : (nx, ny, nz + 1, 3) array
        Displacement (u_x, u_y, u_z) [m] at x = i dx, y = j dy; u_z is positive upwards, out of the body.
    modulus : (nx, ny, nz) array or None
        Young's modulus of each cell over `solid.young`; None where it is 1 everywhere.
    """

    contact: ContactResult
    solid: Solid
    planes: Array
    field: Array
    modulus: Array | None = None

    def __post_init__(self) -> None:
        for name in ("planes", "field"):
            view = getattr(self, name).view()
            view.setflags(write=False)
            object.__setattr__(self, name, view)

    @property
    def layers(self) -> Array:
        """Thicknesses of the layers of cells [m], from the bottom upwards, (nz,)."""
        return np.diff(self.planes)

    @property
    def depth(self) -> float:
        """Thickness of the block [m]."""
        return float(-self.planes[0])

    def strain(self) -> Array:
        """Tensor strain xx, yy, zz, yz, xz, xy at the centres of the cells, (nx, ny, nz, 6)."""
        gradient = self._gradient()
        pairs = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
        return np.stack([0.5 * (gradient[..., a, b] + gradient[..., b, a]) for a, b in pairs], axis=-1)

    def stress(self) -> CellStress:
        """Stress at the centres of the cells, where derivatives of trilinear elements are most accurate."""
        first, second = lame(self.solid.poisson)
        strain = self.strain()
        tensor = 2 * second * strain
        tensor[..., :3] += first * strain[..., :3].sum(axis=-1, keepdims=True)
        if self.modulus is not None:
            tensor *= self.modulus[..., None]
        return CellStress(tensor=tensor * self.solid.young)

    def _gradient(self) -> Array:
        """Differentiate u_a along x_b at the centres, (nx, ny, nz, 3, 3)."""
        dx, dy = self.contact.spacing
        corners = np.empty((2, 2, *self.contact.shape, self.planes.size, 3))
        for i in (0, 1):
            for j in (0, 1):
                corners[i, j] = np.roll(self.field, (-i, -j), axis=(0, 1))
        middle = 0.5 * (corners[..., 1:, :] + corners[..., :-1, :])
        along_x = 0.5 * (middle[1, 0] + middle[1, 1] - middle[0, 0] - middle[0, 1]) / dx
        along_y = 0.5 * (middle[0, 1] + middle[1, 1] - middle[0, 0] - middle[1, 0]) / dy
        along_z = np.diff(corners.mean(axis=(0, 1)), axis=2) / self.layers[:, None]
        return np.stack([along_x, along_y, along_z], axis=-1)
