"""Blocks whose modulus varies sideways: a matrix-free operator, preconditioned by a layered block.

The layered block is solved exactly by Fourier transform, with the contact constraint inside, so the number of
conjugate-gradient steps depends on the contrast of the moduli and not on the grid.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from fem_contact.block.elements import element_matrices
from fem_contact.block.full.active_set import Settings, solve_contact
from fem_contact.block.full.block import MeshedBlock, SetPreconditioner
from fem_contact.block.problem import Found, Problem
from fem_contact.block.reduced.fields import FourierSource
from fem_contact.block.reduced.surface import BlockResponse, SurfaceOperator, solve_reduced, surface_operator
from fem_contact.complementarity.fourier import FourierOperator
from fem_contact.errors import InvalidInput
from fem_contact.solid import Solid

__all__ = ["HeterogeneousBlock", "solve_heterogeneous"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Relative accuracy of the contact constraint inside the preconditioner: far below what a step gains.
_INNER = 1e-8
_INNER_STEPS = 400

#: Conjugate-gradient steps allowed for one active set.
_LINEAR_STEPS = 2000


@dataclass(frozen=True, kw_only=True)
class HeterogeneousBlock(MeshedBlock):
    """Trilinear cells with a modulus each.

    Attributes
    ----------
    poisson : float
    modulus : (nx, ny, nz) array
        Young's modulus of the cells over E.
    """

    poisson: float
    modulus: Array

    @cached_property
    def matrices(self) -> Array:
        """Element matrices of the layers, (nz, 24, 24), local nodes in the order of `kernels.apply_cells`."""
        matrices, offsets = element_matrices(self.mesh, self.poisson)
        order = np.argsort(offsets @ np.array([4, 2, 1]))
        unknowns = (3 * order[:, None] + np.arange(3)).ravel()
        return np.ascontiguousarray(matrices[:, unknowns[:, None], unknowns])

    @cached_property
    def layered(self) -> BlockResponse:
        """The layered block next to this one: in each layer the geometric mean of its extreme moduli."""
        low, high = self.modulus.min(axis=(0, 1)), self.modulus.max(axis=(0, 1))
        unit = Solid(young=1.0, poisson=self.poisson)
        return BlockResponse(mesh=self.mesh, solid=unit, width=1.0, layer_modulus=np.sqrt(low * high))

    @cached_property
    def operator(self) -> FourierOperator | SurfaceOperator:
        """Surface of the layered block."""
        return surface_operator(self.layered)

    @cached_property
    def packed(self) -> tuple[Array, NDArray[np.int64]]:
        """The layered block, as the compiled kernels read it."""
        from fem_contact.block.reduced.kernels import pack

        return pack(self.layered.folded.coefficients)

    def apply(self, field: Array) -> Array:
        """Sum the forces of the cells."""
        from fem_contact.block.reduced.kernels import apply_cells

        shape = (*self.mesh.shape, self.levels, 3)
        forces = np.zeros(shape)
        apply_cells(self.matrices, self.modulus, field.reshape(shape), forces)
        return forces.ravel()

    def solve_layered(self, forces: Array) -> Array:
        """Displacement of the layered block under nodal forces, flat arrays."""
        from fem_contact.block.reduced.kernels import solve_columns

        (nx, ny), packed = self.mesh.shape, self.packed
        shape = (nx, ny, self.levels, 3)
        waves = scipy.fft.rfft2(forces.reshape(shape), axes=(0, 1))
        phases = 2 * np.pi * scipy.fft.fftfreq(nx), 2 * np.pi * scipy.fft.rfftfreq(ny)
        solve_columns(*packed, *phases, waves)
        field: Array = scipy.fft.irfft2(waves, s=(nx, ny), axes=(0, 1), overwrite_x=True)
        return field.ravel()

    def preconditioner(self, nodes: Mask) -> SetPreconditioner:
        """Solve the layered block with the profile's nodes tied."""
        return _LayeredPreconditioner(self, nodes)


class _LayeredPreconditioner:
    """The layered block with nodes tied: two Fourier solves around the forces that tie them."""

    def __init__(self, block: HeterogeneousBlock, nodes: Mask) -> None:
        self.block, self.nodes, self.tied = block, nodes, block.vertical(nodes)
        self.nbytes = 6 * 8 * block.mesh.unknowns

    def apply(self, residual: Array, load: float | None) -> tuple[Array, float]:
        """Displacement and offset answering a residual."""
        loose = self.block.solve_layered(residual)
        lifted = self.block.surface(loose)[self.nodes]
        tying, shift = self._tying_forces(lifted, load)
        forces = residual.copy()
        forces[self.tied] += tying
        answer = self.block.solve_layered(forces)
        # The inner iteration leaves a remainder, which must not enter the unknowns that are tied.
        answer[self.tied] = 0
        return answer, shift

    def _tying_forces(self, lifted: Array, load: float | None) -> tuple[Array, float]:
        """Vertical forces of sum `load` on the nodes that bring them to one height, and that height."""
        nodes, operator = self.nodes, self.block.operator
        scale = self.block.mesh.aspect
        field, image = np.zeros(nodes.shape), np.zeros(nodes.shape)

        def moved(force: Array) -> Array:
            field[nodes] = force / scale
            operator.apply(field, image)
            return image[nodes]

        def towards(residual: Array) -> Array:
            field[nodes] = residual
            operator.precondition(field, image)
            return image[nodes] * scale

        def balanced(values: Array) -> Array:
            return values if load is None else values - values.mean()

        force = np.full(lifted.size, 0.0 if load is None else load / lifted.size)
        residual = balanced(-(lifted + moved(force)))
        first, direction, product = float(np.linalg.norm(residual)), np.zeros_like(force), np.inf
        bound = _INNER * max(first, float(np.linalg.norm(balanced(lifted))))
        for _ in range(_INNER_STEPS):
            if not float(np.linalg.norm(residual)) > bound:
                break
            better = balanced(towards(residual))
            previous, product = product, float(residual @ better)
            direction = better + (product / previous) * direction
            change = balanced(moved(direction))
            curvature = float(direction @ change)
            if not curvature > 0:
                break
            force += product / curvature * direction
            residual -= product / curvature * change
        height = 0.0 if load is None else float(np.mean(lifted + moved(force)))
        return force, height


def solve_heterogeneous(problem: Problem, block: HeterogeneousBlock, start: Mask | Found | None) -> Found:
    """Solve the contact with the whole block kept, started from the layered block's solution.

    Raises
    ------
    InvalidInput
        For triquadratic cells.
    """
    mesh = problem.mesh
    if mesh.element.order != 1:
        raise InvalidInput(
            f"element = {mesh.element.name!r}: a modulus that varies sideways needs trilinear cells, "
            "or method = 'full'"
        )
    nodes, offset, guess, pairs = _first_guess(problem, block, start)
    found = solve_contact(
        block,
        load=problem.load,
        offset=offset if problem.offset is None else problem.offset,
        start=nodes,
        settings=Settings(
            tolerance=problem.tolerance, max_iterations=problem.steps, max_linear_iterations=_LINEAR_STEPS
        ),
        violation=problem.violation,
        displacement=guess,
    )
    field = np.zeros((*mesh.shape, mesh.planes.size, 3))
    field[:, :, 1:] = found.displacement
    return Found(
        force=found.force,
        gap=found.gap,
        displacement=-found.displacement[:, :, -1, 2],
        in_contact=found.in_contact,
        offset=found.offset,
        status=found.status,
        iterations=found.sets,
        linear_iterations=found.linear_iterations,
        fft_pairs=pairs,
        bytes=found.matrix_bytes + block.modulus.nbytes + field.nbytes,
        method="heterogeneous",
        note=f"linear residual {found.linear_residual:.3g} of the contact forces, "
        f"at most {found.most_linear_iterations} steps for a set",
        field=field,
        at_bound=found.at_bound,
    )


def _first_guess(
    problem: Problem, block: HeterogeneousBlock, start: Mask | Found | None
) -> tuple[Mask, float, Array | None, float]:
    """Nodes, offset and displacement to start from, and the FFT pairs they cost."""
    mesh = problem.mesh
    if isinstance(start, Found):
        assert start.field is not None
        return start.in_contact, start.offset, start.field[:, :, 1:], 0.0
    if problem.pressure is None:
        assert start is not None
        return start, 0.0, None, 0.0
    layered = solve_reduced(problem, block.layered, block.operator, start=start)
    field = np.empty((*mesh.shape, mesh.planes.size, 3))
    for layer in FourierSource(response=block.layered, force=layered.force, width=1.0).descend():
        field[:, :, layer.index : layer.index + 2] = np.moveaxis(layer.nodes, 0, 2)
    nodes = layered.in_contact if start is None else start
    return nodes, layered.offset, field[:, :, 1:], layered.fft_pairs
