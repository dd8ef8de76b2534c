"""The periodic block of hexahedra: uniform sideways, graded in depth.

Lengths are in units of the cell width along x, so that nothing here depends on the unit system. The block
fills -depth < z < 0; its planes are numbered upwards, the clamped bottom first and the surface last.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypedDict

import numpy as np

from fem_contact._checks import instance, positive, samples, shown, within
from fem_contact._types import Array, Lengths, Numbers, Shape
from fem_contact.block.elements import (
    ELEMENTS,
    Element,
    LocalForms,
    lame,
    local_dilatation,
    local_shear,
    quiet_skfem,
    scalar_basis,
)
from fem_contact.errors import InvalidInput
from fem_contact.surface.heights import checked_counts, checked_lengths

if TYPE_CHECKING:
    from skfem import CellBasis

#: A layer count is not raised for a rounding error in depth / first layer.
_SLACK = 1e-9
#: Width [m] that cells must exceed, or the powers of wavevectors leave the range of the arithmetic.
_SMALLEST = 1e-60
#: Cell widths that the depth and the other side of a cell must stay below.
_DEEPEST = 1e9
#: Depth over the first layer must stay below this.
_THINNEST = 1e13
#: Layers at most: beyond, nothing is gained and the time to plan them is no longer bounded.
_MOST_LAYERS = 10_000
#: Layers at least, where the depth is less than this many spacings.
_LEAST_LAYERS = 4


def graded_layers(depth: float, *, first: float, growth: float) -> Array:
    """Thicknesses of layers that grow from the surface downwards and fill the depth exactly.

    The first layer is kept; the ratio is lowered from `growth` until a whole number of layers fits. Where it
    would fall below 1, they are equal and thinner than the first.

    Parameters
    ----------
    depth, first : float
        Depth of the block and thickness of the layer below the surface, in one unit.
    growth : float
        Largest ratio of the thicknesses of neighbouring layers, at least 1.

    Returns
    -------
    (nz,) array
        Thicknesses from the surface downwards.

    Raises
    ------
    InvalidInput
        For a depth or first layer that is not positive, a growth below 1, or more than 10,000 layers.

    Examples
    --------
    >>> graded_layers(7.0, first=1.0, growth=2.0)
    array([1., 2., 4.])
    >>> graded_layers(3.0, first=1.0, growth=1.0)
    array([1., 1., 1.])
    """
    depth, first = positive("depth", depth, unit=""), positive("first", first)
    growth = within("growth", growth, "[1, inf)")
    ratio = depth / first
    if not ratio < _THINNEST:
        raise InvalidInput(
            f"depth / first_layer = {ratio:.3g}: must be less than {_THINNEST:.0e}: thinner layers are "
            "lost in rounding"
        )
    needed = ratio if growth == 1 else math.log1p(ratio * (growth - 1)) / math.log(growth)
    if not needed < _MOST_LAYERS:
        raise InvalidInput(
            f"depth / first_layer = {ratio:.3g}, growth = {growth!r}: make {needed:.3g} layers, at most "
            f"{_MOST_LAYERS:,} are allowed; take a larger growth, a thicker first layer or less depth"
        )
    count = max(math.ceil(needed * (1 - _SLACK)), 1)
    if ratio <= count:
        return np.full(count, depth / count)
    powers, low, high = np.arange(count, dtype=float), 1.0, min(growth, ratio)
    # 1 + r + ... + r^(count - 1) = ratio, by bisection where the growth allowed is more than is needed.
    for _ in range(100 if float(np.sum(high**powers)) > ratio else 0):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if float(np.sum(middle**powers)) < ratio else (low, middle)
    layers = first * high**powers
    layers *= depth / layers.sum()
    return layers


@dataclass(frozen=True, kw_only=True)
class BlockMesh:
    """Periodic hexahedral mesh of nx x ny x nz cells, in units of the cell width along x.

    Attributes
    ----------
    cells : tuple of int
        Surface cells (nx, ny).
    aspect : float
        Cell width along y over that along x.
    layers : (nz,) array
        Layer thicknesses, from the bottom upwards.
    """

    cells: Shape
    aspect: float
    layers: Array
    element: Element

    def __post_init__(self) -> None:
        instance("element", self.element, Element, what="an `Element`, one of `ELEMENTS`")
        checked_counts(self.cells, "cells")
        positive("aspect", self.aspect)
        layers = samples("layers", self.layers)
        if not (layers > 0).all():
            raise InvalidInput(f"layers: the thinnest is {layers.min():.3g}: all must be positive")
        object.__setattr__(self, "layers", layers)

    @property
    def nz(self) -> int:
        """Number of layers."""
        return int(self.layers.size)

    @property
    def shape(self) -> Shape:
        """Nodes per plane along both axes."""
        return self.element.order * self.cells[0], self.element.order * self.cells[1]

    @property
    def edges(self) -> Array:
        """Heights z of the nz + 1 boundaries of the layers, from -depth to 0."""
        return -np.append(np.cumsum(self.layers[::-1])[::-1], 0.0)

    @property
    def planes(self) -> Array:
        """Heights z of the planes of nodes, from -depth to 0; those inside quadratic cells included."""
        edges = self.edges
        if self.element.order == 1:
            return edges
        planes = np.empty(2 * self.nz + 1)
        planes[::2], planes[1::2] = edges, 0.5 * (edges[1:] + edges[:-1])
        return planes

    @property
    def unknowns(self) -> int:
        """Displacement components above the clamped bottom."""
        nx, ny = self.shape
        return 3 * nx * ny * self.element.order * self.nz

    def basis(self) -> tuple[CellBasis, Numbers]:
        """Scalar scikit-fem basis on the periodic block, and the lattice number of each of its unknowns.

        The lattice number of node (i, j, k) is (i ny + j) nk + k, with ny nodes along y and nk planes of
        nodes. Refused are so few cells along an axis that scikit-fem cannot tell the nodes of periodic
        neighbours apart.
        """
        from skfem import MeshHex1DG

        nx, ny = self.cells
        order = self.element.order
        if min(nx, ny) <= order:
            raise InvalidInput(
                f"cells = {self.cells}: the full system of {self.element.name} needs at least {order + 1} "
                "cells along each axis; take method = 'reduced'"
            )
        x, y = np.arange(nx + 1.0), np.arange(ny + 1.0) * self.aspect
        with quiet_skfem():
            mesh = MeshHex1DG.init_tensor(x, y, self.edges, periodic=[0, 1])
        basis = scalar_basis(mesh, self.element)
        i = np.rint(order * basis.doflocs[0]).astype(np.int64) % self.shape[0]
        j = np.rint(order * basis.doflocs[1] / self.aspect).astype(np.int64) % self.shape[1]
        planes = self.planes
        k = np.searchsorted(0.5 * (planes[1:] + planes[:-1]), basis.doflocs[2])
        return basis, (i * self.shape[1] + j) * planes.size + k

    def column(self) -> tuple[CellBasis, Numbers]:
        """Scalar scikit-fem basis on one column of cells, and their numbers from the bottom upwards."""
        from skfem import MeshHex

        with quiet_skfem():
            mesh = MeshHex.init_tensor(np.array([0.0, 1.0]), np.array([0.0, self.aspect]), self.edges)
        return scalar_basis(mesh, self.element), np.argsort(mesh.doflocs[2, mesh.t].mean(axis=0))


def element_matrices(mesh: BlockMesh, poisson: float, *, condensed: bool = False) -> tuple[Array, Numbers]:
    """Element matrices (nz, m, m) of the column, and the local nodes' offsets (n, 3) in half cells.

    Discontinuous linear pressures are unknowns of their own behind the displacements, unless they are
    `condensed`.
    """
    (basis, order), element = mesh.column(), mesh.element
    forms = LocalForms.integrate(basis, element)
    nodes, mixed = basis.Nbfun, element.pressures == 4 and not condensed
    pressures = element.pressures if mixed else 0
    matrices = np.zeros((mesh.nz, 3 * nodes + pressures, 3 * nodes + pressures))
    second = 0.5 / (1 + poisson)
    first = 0.0 if mixed else lame(poisson)[0]
    for a in range(3):
        for b in range(3):
            block = second * local_shear(forms, a, b)
            if not mixed:
                block = block + first * local_dilatation(forms, a, b)
            matrices[:, a : 3 * nodes : 3, b : 3 * nodes : 3] = np.moveaxis(block, -1, 0)
    for mode in range(pressures):
        row = 3 * nodes + mode
        for a in range(3):
            coupling = forms.dilatations[mode, a].T
            matrices[:, row, a : 3 * nodes : 3] = coupling
            matrices[:, a : 3 * nodes : 3, row] = coupling
        # 1 / lambda, which vanishes for the incompressible solid.
        matrices[:, row, row] = -forms.masses[mode] * (1 + poisson) * (1 - 2 * poisson) / poisson
    corner = basis.doflocs[:, basis.element_dofs]
    low, high = corner.min(axis=1, keepdims=True), corner.max(axis=1, keepdims=True)
    offsets = np.rint(2 * ((corner - low) / (high - low))[:, :, 0]).astype(int).T
    return matrices[order], offsets


def node_weights(mesh: BlockMesh) -> Array | None:
    """Area carried by each surface node over the mean, (nx, ny); None where all are 1.

    On triquadratic cells a uniform pressure loads corners, edge nodes and centres like 1 : 2 : 2 : 4.
    """
    if mesh.element.order == 1:
        return None
    along = [np.tile([2 / 3, 4 / 3], n) for n in mesh.cells]
    return np.outer(along[0], along[1])


def nodal_pressure(force: Array, mesh: BlockMesh) -> Array:
    """Pressure over E from nodal forces over E times the cell width squared: force over the node's area."""
    weights, pressure = node_weights(mesh), force * (mesh.element.order**2 / mesh.aspect)
    return pressure if weights is None else pressure / weights


def nodal_force(pressure: Array, mesh: BlockMesh) -> Array:
    """Nodal forces over E times the cell width squared from pressures over E; inverts `nodal_pressure`."""
    weights, force = node_weights(mesh), pressure * (mesh.aspect / mesh.element.order**2)
    return force if weights is None else force * weights


class MeshOptions(TypedDict, total=False):
    """Options of `plan_mesh`, except that the element goes by its name."""

    depth: float | None
    growth: float
    first_layer: float | None
    element: str | None


def plan_mesh(
    shape: Shape,
    lengths: Lengths,
    *,
    depth: float | None = None,
    growth: float = 1.2,
    first_layer: float | None = None,
    element: Element = ELEMENTS["Hex1"],
) -> BlockMesh:
    """Choose the mesh of a block.

    Parameters
    ----------
    shape : tuple of int
        Surface nodes (nx, ny); quadratic cells are two nodes wide, so both must be even for them.
    lengths : tuple of float
        Periods (Lx, Ly) [m].
    depth : float, optional
        Thickness of the block [m]; the longest period by default. A wave of that length then feels the
        clamped bottom by 4e-4 of its compliance (nu = .3), against 5.6e-2 at half the depth.
    growth : float
        Largest ratio of neighbouring layers. Trilinear cells growing by 1.2 are .25 % too stiff for long
        waves, by 1.1, .08 %.
    first_layer : float, optional
        Thickness of the top layer [m]; the longer side of a cell by default (a quarter of the depth, if that
        is less). Thinner top layers make short waves softer, not better.
    element : Element
    """
    instance("element", element, Element, what="an `Element`, one of `ELEMENTS`")
    shape, lengths = checked_counts(shape), checked_lengths(lengths)
    depth = None if depth is None else positive("depth", depth)
    first_layer = None if first_layer is None else positive("first_layer", first_layer)
    if any(n % element.order for n in shape):
        raise InvalidInput(
            f"shape = {shape}: must be even for {element.name}, whose cells are two nodes wide"
        )
    nx, ny = shape[0] // element.order, shape[1] // element.order
    dx, dy = lengths[0] / nx, lengths[1] / ny
    if not (min(dx, dy) > _SMALLEST and max(dx, dy) < _DEEPEST * min(dx, dy)):
        raise InvalidInput(
            f"lengths = {shown(lengths)}: make cells of {dx:.3g} m x {dy:.3g} m; their sides must differ by "
            f"less than a factor of {_DEEPEST:.0e} and exceed {_SMALLEST:g} m"
        )
    thickness = (max(lengths) if depth is None else depth) / dx
    if not thickness < _DEEPEST:
        raise InvalidInput(
            f"depth = {shown(depth)}: must be less than {_DEEPEST:.0e} cell widths ({_DEEPEST * dx:.3g} m): "
            "deeper, the surface is lost in the rounding of the block's compression"
        )
    top = min(max(dx, dy) / dx, thickness / _LEAST_LAYERS) if first_layer is None else first_layer / dx
    if first_layer is not None and depth is not None and first_layer > depth:
        raise InvalidInput(f"first_layer = {first_layer!r}: must not exceed the depth {depth!r} m")
    layers = graded_layers(thickness, first=top, growth=growth)[::-1]
    return BlockMesh(cells=(nx, ny), aspect=dy / dx, layers=layers, element=element)
