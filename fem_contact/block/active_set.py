"""Primal-dual active set on the surface nodes of the assembled block.

On the set, u_z follows the rigid profile; the profile's height above the undeformed surface is one more
unknown, tied to the nodes of the set, whose equation is the balance of the load. Lengths are in cell widths
and stresses in Young's modulus throughout.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fem_contact.block.linear import LinearSolution, conjugate_gradients, factorised, multigrid, rigid_modes
from fem_contact.contact import Status

if TYPE_CHECKING:
    import scipy.sparse as sp

    from fem_contact.block.mesh import BlockMesh

__all__ = ["ActiveSetSolution", "Block", "Settings", "solve_contact"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Linear tolerance while the set still moves; it only has to tell contact from separation at most nodes.
_LOOSE = 1e-3


@dataclass(frozen=True, kw_only=True)
class Settings:
    """When the active-set iteration stops.

    Attributes
    ----------
    tolerance : float
        Bound on the linear residual over the norm of the contact forces, and on what an unsettled set may
        still violate.
    max_iterations : int
        Active sets tried at most.
    max_linear_iterations : int
        Conjugate-gradient steps per set.
    """

    tolerance: float
    max_iterations: int
    max_linear_iterations: int


@dataclass(frozen=True, kw_only=True)
class ActiveSetSolution:
    """State at the end of the iteration, dimensionless.

    Attributes
    ----------
    displacement : (nx, ny, nz, 3) array
        u over the cell width above the clamped plane.
    force : (nx, ny) array
        Downward nodal force on the contact nodes over E times the cell width squared; 0 elsewhere.
    gap : (nx, ny) array
        g over the cell width.
    in_contact : (nx, ny) array of bool
    offset : float
        Offset over the cell width.
    """

    displacement: Array
    force: Array
    gap: Array
    in_contact: Mask
    offset: float
    status: Status
    sets: int
    linear_iterations: int
    linear_residual: float
    matrix_bytes: int


@dataclass(frozen=True, kw_only=True)
class Block:
    """The assembled block and the profile pressed into it.

    Attributes
    ----------
    matrix : scipy.sparse.bsr_array
        Stiffness above the clamped plane, over E.
    mesh : BlockMesh
    heights : (nx, ny) array
        Profile over the cell width, positive into the block.
    direct : bool
        Precondition by a factorisation, which takes multigrid's place where that crawls and the block is
        small.
    """

    matrix: sp.bsr_array
    mesh: BlockMesh
    heights: Array
    direct: bool = False

    @property
    def levels(self) -> int:
        """Planes of nodes above the clamped one."""
        return self.mesh.planes.size - 1

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

    def vertical(self, nodes: Mask) -> NDArray[np.int64]:
        """Numbers of the vertical unknowns at surface nodes."""
        return 3 * (np.flatnonzero(nodes) * self.levels + self.levels - 1) + 2

    def force_scale(self, state: _State, *, load: float | None) -> float:
        """Smallest norm that the contact forces of one set can have, for the linear tolerance to refer to.

        With a prescribed offset it is that of the deepest node's indentation spread over the depth.
        """
        if load is not None:
            return load / math.sqrt(max(int(state.nodes.sum()), 1))
        deepest = float(np.max(self.heights)) - state.offset
        return deepest / float(-self.mesh.planes[0])

    def surface(self, field: Array) -> Array:
        """Vertical component at the surface of a field over all unknowns, (nx, ny)."""
        nx, ny = self.mesh.shape
        return field.reshape(nx, ny, self.levels, 3)[:, :, -1, 2]


@dataclass(frozen=True, kw_only=True)
class _State:
    """Displacement, and what it says about the surface nodes."""

    displacement: Array
    offset: float
    nodes: Mask
    following: Mask
    force: Array
    gap: Array

    @classmethod
    def initial(cls, block: Block, *, start: Mask, offset: float, displacement: Array | None) -> _State:
        field = np.zeros(block.matrix.shape[0]) if displacement is None else displacement.ravel()
        zero = np.zeros(block.mesh.shape)
        return cls(displacement=field, offset=offset, nodes=start, following=start, force=zero, gap=zero)

    @classmethod
    def read(cls, block: Block, *, nodes: Mask, offset: float, displacement: Array) -> _State:
        force = -block.surface(block.matrix @ displacement)
        gap = offset - block.heights - block.surface(displacement)
        return cls(
            displacement=displacement,
            offset=offset,
            nodes=nodes,
            following=np.where(nodes, force > 0, gap < 0),
            # Off the set the nodal force is the linear residual, on it the gap is rounding.
            force=np.where(nodes, force, 0.0),
            gap=np.where(nodes, 0.0, gap),
        )

    @property
    def settled(self) -> bool:
        """Whether the set reproduces itself."""
        return bool(np.array_equal(self.nodes, self.following))

    @property
    def key(self) -> bytes:
        """The next set, hashable."""
        return self.following.tobytes()

    def moved(self) -> _State:
        """Return the same displacement with the next set."""
        return replace(self, nodes=self.following)


class _SetProblem:
    """The linear problem of one set: u outside the set, and the offset where the load is given."""

    def __init__(self, block: Block, nodes: Mask) -> None:
        import scipy.sparse as sp

        self.block, self.tied = block, block.vertical(nodes)
        matrix, rows = block.matrix, block.rows
        fixed: Mask = np.zeros(matrix.shape[0], dtype=bool)
        fixed[self.tied] = True
        per_node = np.reshape(fixed, (-1, 3))
        node = np.asarray(per_node.any(axis=1))
        touched = np.flatnonzero(node[rows] | node[matrix.indices])
        data = matrix.data.copy()
        data[touched] *= ~per_node[rows[touched]][:, :, None]
        data[touched] *= ~per_node[matrix.indices[touched]][:, None, :]
        own = touched[rows[touched] == matrix.indices[touched]]
        # The diagonal stays, so that every row of the reduced matrix has the size of its neighbours.
        kept = matrix.data[own].diagonal(axis1=1, axis2=2) * per_node[rows[own]]
        data[own] += kept[:, :, None] * np.eye(3)
        self.matrix = sp.bsr_array((data, matrix.indices, matrix.indptr), shape=matrix.shape)
        modes = block.modes * ~fixed[:, None]
        self.preconditioner = factorised(self.matrix) if block.direct else multigrid(self.matrix, modes)
        unit = np.zeros(matrix.shape[0])
        unit[self.tied] = 1
        image = matrix @ unit
        self.diagonal = float(image[self.tied].sum())
        self.coupling = image
        self.coupling[self.tied] = 0
        self.answer = self._cycle(self.coupling)
        # One cycle never overestimates the inverse, so the Schur complement stays positive.
        self.schur = self.diagonal - float(self.coupling @ self.answer)

    def _cycle(self, residual: Array) -> Array:
        result = self.preconditioner.apply(residual)
        result[self.tied] = 0
        return result

    def _apply(self, x: Array) -> Array:
        full = x[:-1].copy()
        full[self.tied] = x[-1]
        image = self.block.matrix @ full
        total = image[self.tied].sum()
        image[self.tied] = 0
        return np.append(image, total)

    def _precondition(self, r: Array) -> Array:
        free = self._cycle(r[:-1])
        shift = (r[-1] - float(self.answer @ r[:-1])) / self.schur
        return np.append(free - shift * self.answer, shift)

    def _apply_free(self, x: Array) -> Array:
        image: Array = self.matrix @ x
        image[self.tied] = 0
        return image

    def advance(
        self, state: _State, *, load: float | None, settings: Settings, tolerance: float
    ) -> tuple[_State, LinearSolution]:
        """Solve for displacement and offset with the nodes of the set tied to the profile."""
        prescribed = np.zeros_like(state.displacement)
        prescribed[self.tied] = -self.block.heights[state.nodes]
        if load is None:
            prescribed[self.tied] += state.offset
        right = -(self.block.matrix @ prescribed)
        total = float(right[self.tied].sum())
        right[self.tied] = 0
        guess = state.displacement.copy()
        guess[self.tied] = 0
        tied_offset = load is not None
        solution = conjugate_gradients(
            self._apply if tied_offset else self._apply_free,
            np.append(right, total - load) if load is not None else right,
            precondition=self._precondition if tied_offset else self._cycle,
            start=np.append(guess, state.offset) if tied_offset else guess,
            scale=self.block.force_scale(state, load=load),
            tolerance=tolerance,
            max_iterations=settings.max_linear_iterations,
        )
        if tied_offset:
            offset = float(solution.x[-1])
            displacement = solution.x[:-1] + prescribed
            displacement[self.tied] += offset
        else:
            offset, displacement = state.offset, solution.x + prescribed
        return _State.read(self.block, nodes=state.nodes, offset=offset, displacement=displacement), solution

    @property
    def nbytes(self) -> int:
        """Memory of the reduced matrix and its preconditioner."""
        return int(self.matrix.data.nbytes) + self.preconditioner.nbytes


def solve_contact(
    block: Block,
    *,
    load: float | None,
    offset: float,
    start: Mask,
    settings: Settings,
    violation: Callable[[Array, Array], float],
    displacement: Array | None = None,
) -> ActiveSetSolution:
    """Press a rigid profile into the block.

    Parameters
    ----------
    block : Block
    load : float or None
        Total downward force over E times the cell width squared; None where `offset` is prescribed.
    offset : float
        Prescribed offset over the cell width, or its first guess.
    start : (nx, ny) array of bool
        First active set.
    settings : Settings
    violation : callable
        Dimensionless measure of what nodal forces and gaps violate.
    displacement : (nx, ny, nz, 3) array, optional
        First guess of u over the cell width.

    Notes
    -----
    The set is updated to {contact nodes under pressure} and {other nodes that penetrate}: a semi-smooth
    Newton step. With the linear systems solved, complementarity holds exactly, and a set that reproduces
    itself is the solution. The first sets are found with loosely solved systems. A set seen before means a
    cycle; it is accepted where what it violates is below the tolerance (ties), and reported otherwise.
    """
    state = _State.initial(block, start=start, offset=offset, displacement=displacement)
    seen: set[bytes] = set()
    tolerance = max(_LOOSE, settings.tolerance)
    status, linear, peak, sets = Status.ITERATION_LIMIT, 0, 0, 0
    while sets < settings.max_iterations:
        problem = _SetProblem(block, state.nodes)
        peak, sets = max(peak, problem.nbytes), sets + 1
        state, solution = problem.advance(state, load=load, settings=settings, tolerance=tolerance)
        linear += solution.iterations
        if tolerance > settings.tolerance and (state.settled or state.key in seen):
            tolerance = settings.tolerance
            seen.clear()
            state, solution = problem.advance(state, load=load, settings=settings, tolerance=tolerance)
            linear += solution.iterations
        if tolerance == settings.tolerance:
            if not solution.converged:
                limited = solution.iterations >= settings.max_linear_iterations
                status = Status.ITERATION_LIMIT if limited else Status.STAGNATED
                break
            if state.settled or violation(state.force, state.gap) <= settings.tolerance:
                status = Status.CONVERGED
                break
            if state.key in seen:
                status = Status.CYCLING
                break
        if sets < settings.max_iterations:
            seen.add(state.nodes.tobytes())
            state = state.moved()
    return ActiveSetSolution(
        displacement=state.displacement.reshape(*block.mesh.shape, block.levels, 3),
        force=state.force,
        gap=state.gap,
        in_contact=state.nodes,
        offset=state.offset,
        status=status,
        sets=sets,
        linear_iterations=linear,
        linear_residual=solution.relative_residual,
        matrix_bytes=peak,
    )
