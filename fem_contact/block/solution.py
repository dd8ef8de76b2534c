"""What the block returns: the contact result, the displacement field, and the stress read off it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from fem_contact._checks import room_for
from fem_contact._types import Array
from fem_contact.block.elements import Element, lame
from fem_contact.block.equilibrium import Equilibrium, measure_equilibrium
from fem_contact.block.mesh import BlockMesh
from fem_contact.contact import ContactResult
from fem_contact.solid import Solid
from fem_contact.stress import elastic_energy, von_mises

#: Components of symmetric tensors, in the order in which they are stored.
_PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


@dataclass(frozen=True, kw_only=True)
class CellLayer:
    """Displacement of the nodes of one layer of cells."""

    index: int  # Number of the layer, from the bottom upwards
    # (order + 1, nx, ny, 3): Displacement [m] of its planes of nodes, from the lower to the upper.
    nodes: Array
    # (cells, cells): Mean pressure unknown of each cell, tension positive, over the layer's Young's
    # modulus, where the element carries it.
    pressure: Array | None = None

    def gradient(self, size: tuple[float, float, float], element: Element) -> Array:
        """Differentiate u_a along x_b [-] at the centres of cells of a size [m], (nx, ny, 3, 3)."""
        if element.order == 2:
            u, s = self.nodes, 2
            along_x = (np.roll(u, -2, axis=1) - u)[1, ::s, 1::s]
            along_y = (np.roll(u, -2, axis=2) - u)[1, 1::s, ::s]
            along_z = (u[2] - u[0])[1::s, 1::s]
        else:
            right, ahead = np.roll(self.nodes, -1, axis=1), np.roll(self.nodes, -1, axis=2)
            both = np.roll(right, -1, axis=2)
            along_x = 0.25 * (right + both - self.nodes - ahead).sum(axis=0)
            along_y = 0.25 * (ahead + both - self.nodes - right).sum(axis=0)
            mean = 0.25 * (self.nodes + right + ahead + both)
            along_z = mean[1] - mean[0]
        return np.stack([along_x / size[0], along_y / size[1], along_z / size[2]], axis=-1)

    def mean_dilatation(self, size: tuple[float, float, float], element: Element) -> Array:
        """Return the mean of div u over each cell [-], to which elements with pressures respond."""
        if element.order == 1:
            return np.asarray(np.trace(self.gradient(size, element), axis1=-2, axis2=-1))
        u = self.nodes
        in_z = (u[0] + 4 * u[1] + u[2]) / 6
        along_x = _simpson(np.roll(in_z[..., 0], -2, axis=0) - in_z[..., 0], axis=1)[::2] / size[0]
        along_y = _simpson(np.roll(in_z[..., 1], -2, axis=1) - in_z[..., 1], axis=0)[:, ::2] / size[1]
        rise = (u[2] - u[0])[..., 2] / size[2]
        return along_x + along_y + _simpson(_simpson(rise, axis=0), axis=1)


def _simpson(values: Array, *, axis: int) -> Array:
    """Mean over cells two nodes wide along one axis."""
    middle = np.roll(values, -1, axis=axis)
    mean = (values + 4 * middle + np.roll(values, -2, axis=axis)) / 6
    return mean[::2] if axis == 0 else mean[:, ::2]


class FieldSource(Protocol):
    """Whatever can walk down through the block."""

    def descend(self) -> Iterator[CellLayer]:
        """Yield the layers from the surface down."""


@dataclass(frozen=True, kw_only=True)
class ArraySource:
    """A field that is held in memory."""

    field: Array  # (nx, ny, planes, 3): Displacement [m], from the clamped plane upwards
    order: int = 1

    def descend(self) -> Iterator[CellLayer]:
        """Yield the layers from the surface down."""
        for top in range(self.field.shape[2] - 1, 0, -self.order):
            planes = self.field[:, :, top - self.order : top + 1]
            yield CellLayer(index=top // self.order - 1, nodes=np.moveaxis(planes, 2, 0))


@dataclass(frozen=True, kw_only=True)
class CellStress:
    """Stress at the centres of cells, tension positive.

    Attributes
    ----------
    tensor : (..., 6) array
        Components xx, yy, zz, yz, xz, xy [Pa].
    """

    tensor: Array

    @property
    def von_mises(self) -> Array:
        """Von Mises stress of every cell [Pa]."""
        return von_mises(self.tensor)


@dataclass(frozen=True, kw_only=True)
class BlockSolution:
    """A contact problem solved with finite elements.

    The field inside is found when it is first asked for. A block too large for it is walked through with
    `stress_layers`, which holds one layer at a time.

    Attributes
    ----------
    contact : ContactResult
        Pressure (nodal force over the node's area), gap and contact set at the surface nodes.
    solid : Solid
        Reference solid: Poisson ratio, and the modulus that `modulus` multiplies.
    source : FieldSource
        Walks down through the displacement.
    modulus : (nx or 1, ny or 1, nz) array or None
        Young's modulus of each cell over `solid.young`; None where it is 1 everywhere.
    """

    contact: ContactResult
    solid: Solid
    mesh: BlockMesh
    source: FieldSource
    modulus: Array | None = None

    @property
    def cell_size(self) -> tuple[float, float]:
        """Widths of a cell along x and y [m]."""
        return self.contact.lengths[0] / self.mesh.cells[0], self.contact.lengths[1] / self.mesh.cells[1]

    @property
    def planes(self) -> Array:
        """Heights z of the planes of nodes [m], from -depth to 0."""
        return self.mesh.planes * self.cell_size[0]

    @property
    def layers(self) -> Array:
        """Thicknesses of the layers of cells [m], from the bottom upwards, (nz,)."""
        return self.mesh.layers * self.cell_size[0]

    @property
    def depth(self) -> float:
        """Thickness of the block [m]."""
        return float(-self.planes[0])

    @cached_property
    def field(self) -> Array:
        """Displacement (u_x, u_y, u_z) [m] of all nodes, (nx, ny, planes, 3); u_z is positive upwards.

        Raises
        ------
        InsufficientMemory
            If it does not fit; `stress_layers` needs a layer at a time.
        """
        order = self.mesh.element.order
        field = _room_for((*self.mesh.shape, self.mesh.planes.size, 3), "displacement field")
        for layer in self.source.descend():
            first = order * layer.index
            field[:, :, first : first + order + 1] = np.moveaxis(layer.nodes, 0, 2)
        field.setflags(write=False)
        return field

    def stress(self) -> CellStress:
        """Stress at the centres of the cells, (nx, ny, nz, 6), where derivatives are most accurate.

        Raises
        ------
        InsufficientMemory
            If it does not fit; `stress_layers` needs a layer at a time.
        """
        tensor = _room_for((*self.mesh.cells, self.mesh.nz, 6), "stress field")
        for index, layer in self.stress_layers():
            tensor[:, :, index] = layer.tensor
        return CellStress(tensor=tensor)

    def stress_layers(self) -> Iterator[tuple[int, CellStress]]:
        """Yield the number of each layer and the stress in it, (nx, ny, 6), from the surface down."""
        for layer in self.source.descend():
            yield layer.index, CellStress(tensor=self._stress(layer))

    def strain(self) -> Array:
        """Tensor strain xx, yy, zz, yz, xz, xy at the centres of the cells, (nx, ny, nz, 6)."""
        strain = _room_for((*self.mesh.cells, self.mesh.nz, 6), "strain field")
        for layer in self.source.descend():
            strain[:, :, layer.index] = _symmetric(layer.gradient(self._size(layer), self.mesh.element))
        return strain

    @property
    def energy(self) -> float:
        """Elastic energy per nominal area [J/m^2]: half of pressure times displacement."""
        return elastic_energy(self.contact)

    def equilibrium(self) -> Equilibrium:
        """Check the field against the element matrices: forces that nothing balances, and the energy stored.

        Raises
        ------
        InvalidInput
            For the incompressible solid, whose element matrices are not finite.
        """
        width, young = self.cell_size[0], self.solid.young
        residual, energy = measure_equilibrium(
            ((layer.index, layer.nodes / width) for layer in self.source.descend()),
            mesh=self.mesh,
            poisson=self.solid.poisson,
            pressure=self.contact.pressure / young,
            modulus=self.modulus,
        )
        return Equilibrium(residual=residual, energy=energy * young * width)

    def _size(self, layer: CellLayer) -> tuple[float, float, float]:
        return *self.cell_size, float(self.layers[layer.index])

    def _stress(self, layer: CellLayer) -> Array:
        size, element = self._size(layer), self.mesh.element
        strain = _symmetric(layer.gradient(size, element))
        tensor = strain / (1 + self.solid.poisson)
        if layer.pressure is not None:
            tensor[..., :3] += layer.pressure[..., None]
        else:
            first, _ = lame(self.solid.poisson)
            mixed = element.pressures > 0
            dilatation = layer.mean_dilatation(size, element) if mixed else strain[..., :3].sum(axis=-1)
            tensor[..., :3] += first * dilatation[..., None]
        if self.modulus is not None:
            tensor = tensor * self.modulus[:, :, layer.index, None]
        return tensor * self.solid.young


def _room_for(shape: tuple[int, ...], what: str) -> Array:
    remedy = "walk through it with stress_layers()"
    room_for(f"the {what} of {shape} numbers", needed=8.0 * math.prod(shape), remedy=remedy)
    return np.empty(shape)


def _symmetric(gradient: Array) -> Array:
    return np.stack([0.5 * (gradient[..., a, b] + gradient[..., b, a]) for a, b in _PAIRS], axis=-1)
