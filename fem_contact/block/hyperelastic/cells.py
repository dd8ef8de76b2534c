r"""Trilinear cells of a neo-Hookean solid: energy, nodal forces and stiffness at a displacement.

.. math:: W = \tfrac\mu2 (J^{-2/3} \operatorname{tr} F^T F - 3) + \tfrac\mu3 (J - 1)^2
              + \tfrac\lambda2 (\bar J - 1)^2

At small strain this is Hooke's law with Lame's constants lambda and mu. On ``Hex1`` the dilatation enters
pointwise, J-bar = J, and the law is the NEO HOOKE of Abaqus and CalculiX with C10 = mu/2 and D1 = 2/K; on
``Hex1/P0`` J-bar is the mean over the cell, so that nearly incompressible solids do not lock. Lengths are
in cell widths, stresses in E.

| letter | shape | what |
|---|---|---|
| F, C | (..., 3, 3) | deformation gradient; its cofactors dJ/dF = J F^-T |
| G | (nz, 8, 8, 3) | d phi_a / d X_j at the points of a layer's cells |
| w | (nz, 8) | volume of the points |
| c, s | (cells, 8, 24) | F^-T grad phi_a and F grad phi_a |
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fem_contact._types import Array, Numbers
from fem_contact.block.elements import lame
from fem_contact.block.full.assembly import Pattern
from fem_contact.block.mesh import BlockMesh

if TYPE_CHECKING:
    import scipy.sparse as sp


def cofactors(gradient: Array) -> tuple[Array, Array]:
    """Cofactors (..., 3, 3) and determinants (...) of matrices."""
    first, second, third = (gradient[..., row, :] for row in range(3))
    rows = (np.cross(second, third), np.cross(third, first), np.cross(first, second))
    return np.stack(rows, axis=-2), np.sum(first * rows[0], axis=-1)


@dataclass(frozen=True, kw_only=True)
class Strained:
    """State of the points of cells."""

    # (..., 3, 3): F and dJ/dF.
    gradient: Array
    cofactor: Array
    jacobian: Array  # (...): J
    dilated: Array  # (...): J-bar: J, or its mean over the cell

    @classmethod
    def of(cls, gradient: Array, weights: Array | None = None) -> Strained:
        """Measure deformation gradients; with weights the dilatation is the mean over the last axis."""
        cofactor, jacobian = cofactors(gradient)
        dilated = jacobian
        if weights is not None:
            mean = np.sum(weights * jacobian, axis=-1, keepdims=True) / np.sum(
                weights, axis=-1, keepdims=True
            )
            dilated = np.broadcast_to(mean, jacobian.shape)
        return cls(gradient=gradient, cofactor=cofactor, jacobian=jacobian, dilated=dilated)

    @property
    def stretch(self) -> Array:
        """Tr F^T F."""
        return np.asarray(np.sum(self.gradient**2, axis=(-2, -1)))

    def energy(self, first: float, second: float) -> Array:
        """W over E."""
        isochoric = 0.5 * second * (self.jacobian ** (-2 / 3) * self.stretch - 3)
        return isochoric + (second / 3 * (self.jacobian - 1) ** 2 + 0.5 * first * (self.dilated - 1) ** 2)

    def tension(self, first: float, second: float) -> Array:
        """Mean tension dU/dJ over E."""
        return 2 / 3 * second * (self.jacobian - 1) + first * (self.dilated - 1)

    def stress(self, first: float, second: float) -> Array:
        """First Piola-Kirchhoff stress dW/dF over E."""
        scaled = (second * self.jacobian ** (-2 / 3))[..., None, None]
        inverse = self.cofactor / self.jacobian[..., None, None]
        isochoric = scaled * (self.gradient - self.stretch[..., None, None] / 3 * inverse)
        return isochoric + self.tension(first, second)[..., None, None] * self.cofactor


def stress(gradient: Array, *, poisson: float) -> Array:
    """First Piola-Kirchhoff stress over Young's modulus of the homogeneous solid at F (..., 3, 3).

    Examples
    --------
    >>> stress(np.eye(3), poisson=0.3).any()
    np.False_
    """
    return Strained.of(gradient).stress(*lame(poisson))


@dataclass(frozen=True, kw_only=True)
class Cells:
    """All cells of a block."""

    mesh: BlockMesh  # Of ``Hex1`` or ``Hex1/P0``
    poisson: float

    @cached_property
    def _tables(self) -> tuple[Array, Array, Numbers]:
        """Gradients G, weights w, and the corners (8, 3) of a cell: scikit-fem's on one column."""
        basis, order = self.mesh.column()
        gradients = np.stack([np.asarray(basis.basis[a][0].grad) for a in range(8)])
        places = basis.doflocs[:, basis.element_dofs[:, 0]].T
        corners = (places > places.mean(axis=0)).astype(np.int64)
        return gradients[:, :, order].transpose(2, 3, 0, 1).copy(), np.asarray(basis.dx)[order], corners

    @cached_property
    def _nodes(self) -> Numbers:
        """Free node, of a flattened field, of each corner of each cell, (nx, ny, nz, 8); -1 where clamped."""
        (nx, ny), nz = self.mesh.cells, self.mesh.nz
        i, j, k = np.ogrid[:nx, :ny, :nz]
        _, _, corners = self._tables
        nodes = [((i + a) % nx * ny + (j + b) % ny) * nz + k + c - 1 for a, b, c in corners]
        below = [np.broadcast_to(k + c == 0, (nx, ny, nz)) for _, _, c in corners]
        return np.where(np.stack(below, axis=-1), -1, np.stack(nodes, axis=-1))

    @cached_property
    def _pattern(self) -> Pattern:
        """Sparsity of the stiffness; entries of clamped nodes fall into a last block of their own."""
        nodes = self._nodes.reshape(-1, 8)
        rows, columns = (pair.ravel() for pair in np.broadcast_arrays(nodes[:, :, None], nodes[:, None, :]))
        size = int(nodes.max()) + 1
        clamped = (rows < 0) | (columns < 0)
        return Pattern.build(np.where(clamped, size, rows), np.where(clamped, 0, columns), size=size)

    def strained(self, field: Array) -> Strained:
        """Deform the cells by u (nx, ny, nz, 3) above the clamped plane: arrays over (nx, ny, nz, 8)."""
        gradients, weights, _ = self._tables
        padded = np.vstack([field.reshape(-1, 3), np.zeros(3)])
        moved = padded[self._nodes]
        gradient = np.einsum("xyzai,zqaj->xyzqij", moved, gradients, optimize=True) + np.eye(3)
        return Strained.of(gradient, weights if self.mesh.element.pressures else None)

    def energy(self, state: Strained) -> float:
        """Return the stored energy over E times the cube of the cell width."""
        return float(np.sum(state.energy(*lame(self.poisson)) * self._tables[1]))

    def forces(self, state: Strained) -> Array:
        """Gradient of the energy, (nx, ny, nz, 3), over E times the square of the cell width."""
        gradients, weights, _ = self._tables
        weighted = state.stress(*lame(self.poisson)) * weights[..., None, None]
        local = np.einsum("xyzqij,zqaj->xyzai", weighted, gradients, optimize=True)
        free = self._nodes >= 0
        size = int(self._nodes.max()) + 1
        nodes, parts = self._nodes[free], local[free]
        summed = [np.bincount(nodes, weights=parts[:, i], minlength=size) for i in range(3)]
        return np.stack(summed, axis=-1, dtype=float).reshape(*self.mesh.cells, self.mesh.nz, 3)

    def stiffness(self, state: Strained, *, turning: Array | None = None) -> sp.bsr_array:
        """Second derivative of the energy over the free nodes, (i ny + j) nz + k.

        To xx, xy and yy at the surface nodes is added the change of forces that turn, (nx, ny, 3).
        """
        pattern, nz = self._pattern, self.mesh.nz
        blocks = np.empty((3, 3, *self.mesh.cells, nz, 8, 8))
        for k in range(nz):
            parts = {name: part[:, :, k].reshape(-1, *part.shape[3:]) for name, part in vars(state).items()}
            layer = Strained(**parts)
            entries = self._layer(layer, k).reshape(*self.mesh.cells, 8, 3, 8, 3)
            blocks[:, :, :, :, k] = entries.transpose(3, 5, 0, 1, 2, 4)
        data = np.stack([pattern.summed(part.ravel()) for part in blocks.reshape(9, -1)], axis=-1)
        last = int(np.searchsorted(pattern.rows, pattern.size))
        free = replace(pattern, rows=pattern.rows[:last], columns=pattern.columns[:last])
        matrix = free.matrix(data[:last].reshape(-1, 3, 3))
        if turning is not None:
            diagonal = np.flatnonzero(free.rows == free.columns)[nz - 1 :: nz]
            xx, xy, yy = turning.reshape(-1, 3).T
            matrix.data[diagonal, 0, 0] += xx
            matrix.data[diagonal, 0, 1] += xy
            matrix.data[diagonal, 1, 0] += xy
            matrix.data[diagonal, 1, 1] += yy
        return matrix

    def _layer(self, state: Strained, k: int) -> Array:
        """Element matrices (cells, 24, 24) of one layer; d^2W/dF^2 written out in c and s."""
        gradients, weights, _ = self._tables
        g, w = gradients[k], weights[k]
        first, second = lame(self.poisson)
        jacobian, stretch = state.jacobian, state.stretch
        mean = self.mesh.element.pressures > 0
        scaled = second * jacobian ** (-2 / 3)
        carried = state.tension(first, second) * jacobian
        outward = np.einsum("eqij,qaj->eqai", state.cofactor, g, optimize=True)
        c = (outward / jacobian[..., None, None]).reshape(-1, 8, 24)
        s = np.einsum("eqij,qaj->eqai", state.gradient, g, optimize=True).reshape(-1, 8, 24)
        bulk = 2 / 3 * second + (0.0 if mean else first)
        both = 2 / 9 * scaled * stretch + carried + bulk * jacobian**2
        turned = w * (scaled * stretch / 3 - carried)
        right = (w * 0.5 * both)[..., None] * c - (w * 2 / 3 * scaled)[..., None] * s
        half = c.swapaxes(1, 2) @ right
        matrix: Array = half + half.swapaxes(1, 2)
        swapped = c.swapaxes(1, 2) @ (turned[..., None] * c)
        matrix += swapped.reshape(-1, 8, 3, 8, 3).swapaxes(2, 4).reshape(-1, 24, 24)
        products = np.einsum("qaj,qbj->qab", g, g).reshape(8, 64)
        alike = ((w * scaled) @ products).reshape(-1, 8, 8)
        for i in range(3):
            matrix[:, i::3, i::3] += alike
        if mean:
            total = np.einsum("q,eqai->eai", w, outward).reshape(-1, 24)
            matrix += first / float(w.sum()) * total[:, :, None] * total[:, None, :]
        return matrix
