"""The periodic block of hexahedra: uniform sideways, graded in depth.

Lengths are in units of the grid spacing dx, so that nothing here depends on the unit system. The block fills
-depth < z < 0; its planes are numbered upwards, the clamped bottom first and the surface last.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fem_contact.errors import InvalidInput

if TYPE_CHECKING:
    from skfem import CellBasis

__all__ = ["BlockMesh", "graded_layers", "plan_mesh"]

Array = NDArray[np.float64]
Shape = tuple[int, int]
Lengths = tuple[float, float]

#: A layer count is not raised for a rounding error in depth / first layer.
_SLACK = 1e-9

#: Layers at least, where the depth is less than this many spacings.
_LEAST_LAYERS = 4


def graded_layers(depth: float, *, first: float, growth: float) -> Array:
    """Thicknesses of layers that grow from the surface downwards and fill the depth exactly.

    The first layer is kept; the ratio is lowered from `growth` until a whole number of layers fits. Where not
    even two layers of the first thickness fit, the layers are equal.

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
        For a depth or first layer that is not positive, or a growth below 1.

    Examples
    --------
    >>> graded_layers(7.0, first=1.0, growth=2.0)
    array([1., 2., 4.])
    >>> graded_layers(3.0, first=1.0, growth=1.0)
    array([1., 1., 1.])
    """
    for name, value in (("depth", depth), ("first_layer", first)):
        if not (math.isfinite(value) and value > 0):
            raise InvalidInput(f"{name} = {value!r}: must be a positive, finite length")
    if not (math.isfinite(growth) and growth >= 1):
        raise InvalidInput(f"growth = {growth!r}: must be a finite ratio, at least 1")
    ratio = depth / first
    if growth == 1:
        count = math.ceil(ratio * (1 - _SLACK))
    else:
        count = math.ceil(math.log1p(ratio * (growth - 1)) / math.log(growth) * (1 - _SLACK))
    count = max(count, 1)
    if ratio <= count:
        return np.full(count, depth / count)
    fitted = _fitted_growth(ratio, count, growth)
    layers = first * fitted ** np.arange(count, dtype=float)
    layers *= depth / layers.sum()
    return layers


def _fitted_growth(ratio: float, count: int, growth: float) -> float:
    """Solve 1 + r + ... + r^(count-1) = ratio for r in [1, growth] by bisection."""
    powers = np.arange(count, dtype=float)
    low, high = 1.0, growth
    if float(np.sum(high**powers)) <= ratio:
        return high
    for _ in range(100):
        middle = 0.5 * (low + high)
        if float(np.sum(middle**powers)) < ratio:
            low = middle
        else:
            high = middle
    return high


@contextmanager
def _quiet_skfem() -> Iterator[None]:
    """Keep scikit-fem's log lines about copied arrays from the user, to whom they are no news."""
    loggers = [logging.getLogger(name) for name in ("skfem", "skfem.mesh.mesh")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


@dataclass(frozen=True, kw_only=True)
class BlockMesh:
    """Periodic hexahedral mesh of nx x ny x nz cells, in units of dx.

    Attributes
    ----------
    shape : tuple of int
        Surface cells, and nodes per plane, (nx, ny).
    aspect : float
        dy / dx.
    layers : (nz,) array
        Layer thicknesses over dx, from the bottom upwards.
    """

    shape: Shape
    aspect: float
    layers: Array

    @property
    def nz(self) -> int:
        """Number of layers."""
        return int(self.layers.size)

    @property
    def planes(self) -> Array:
        """Heights z / dx of the nz + 1 planes of nodes, from -depth to 0."""
        below = np.append(np.cumsum(self.layers[::-1])[::-1], 0.0)
        planes: Array = -below
        return planes

    @property
    def unknowns(self) -> int:
        """Displacement components above the clamped bottom."""
        return 3 * self.shape[0] * self.shape[1] * self.nz

    def basis(self) -> tuple[CellBasis, NDArray[np.int64]]:
        """Scalar scikit-fem basis of trilinear elements, and the lattice number of each of its unknowns.

        The lattice number of node (i, j, k) is (i ny + j)(nz + 1) + k. Two quadrature points per direction
        integrate the stiffness of these boxes exactly.

        Raises
        ------
        InvalidInput
            For fewer than two cells along an axis: an element cannot be its own periodic neighbour in
            scikit-fem.
        """
        from skfem import Basis, ElementHex1, MeshHex1DG

        nx, ny = self.shape
        if min(nx, ny) < 2:
            raise InvalidInput(
                f"shape = {self.shape}: the full system needs at least two cells along each axis"
            )
        x, y = np.arange(nx + 1.0), np.arange(ny + 1.0) * self.aspect
        with _quiet_skfem():
            mesh = MeshHex1DG.init_tensor(x, y, self.planes, periodic=[0, 1])
            basis = Basis(mesh, ElementHex1(), intorder=2)
        i = np.rint(basis.doflocs[0]).astype(np.int64) % nx
        j = np.rint(basis.doflocs[1] / self.aspect).astype(np.int64) % ny
        middles = 0.5 * (self.planes[1:] + self.planes[:-1])
        k = np.searchsorted(middles, basis.doflocs[2])
        return basis, (i * ny + j) * (self.nz + 1) + k


def plan_mesh(
    shape: Shape,
    lengths: Lengths,
    *,
    depth: float | None = None,
    growth: float = 1.2,
    first_layer: float | None = None,
) -> BlockMesh:
    """Choose the mesh of a block.

    Parameters
    ----------
    shape : tuple of int
        Surface cells (nx, ny).
    lengths : tuple of float
        Periods (Lx, Ly) [m].
    depth : float, optional
        Thickness of the block [m]; the longest period by default. A wave of that length then feels the
        clamped bottom by 4e-4 of its compliance (nu = .3), against 5.6e-2 at half the depth.
    growth : float
        Largest ratio of neighbouring layers. With 1.2 long waves are .25 % too stiff; with 1.1, .08 %.
    first_layer : float, optional
        Thickness of the top layer [m]; the spacing dx by default (a quarter of the depth, if that is less).
        Thinner top layers make short waves softer, not better.
    """
    nx, ny = int(shape[0]), int(shape[1])
    if nx < 1 or ny < 1:
        raise InvalidInput(f"shape = {shape!r}: must be two positive whole numbers (nx, ny)")
    dx, dy = lengths[0] / nx, lengths[1] / ny
    thickness = (max(lengths) if depth is None else depth) / dx
    top = min(1.0, thickness / _LEAST_LAYERS) if first_layer is None else first_layer / dx
    if first_layer is not None and depth is not None and first_layer > depth:
        raise InvalidInput(f"first_layer = {first_layer!r}: must not exceed the depth {depth!r} m")
    layers = graded_layers(thickness, first=top, growth=growth)[::-1]
    return BlockMesh(shape=(nx, ny), aspect=dy / dx, layers=layers)
