"""Primal-dual active set on the surface nodes of a block whose inside is kept.

On the set, u_z follows the rigid profile; the profile's height above the undeformed surface is one more
unknown, tied to the nodes of the set, whose equation is the balance of the load. Nodes at a bound of the
pressure are a set of their own: they carry a known force and are free to move. Lengths are in cell widths and
stresses in Young's modulus throughout.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fem_contact._types import Array, Mask
from fem_contact.block.full.block import Block, CyclePreconditioner
from fem_contact.block.full.linear import LinearSolution, conjugate_gradients
from fem_contact.block.problem import Answer
from fem_contact.contact import Status

Violation = Callable[[Array, Array, Mask | None], float]

#: Linear tolerance while the set still moves; it only has to tell contact from separation at most nodes.
_LOOSE = 1e-3
#: Conjugate-gradient steps allowed for one active set.
_LINEAR_STEPS = 3000


@dataclass(frozen=True, kw_only=True)
class _State:
    """Displacement, and what it says about the surface nodes."""

    displacement: Array
    offset: float
    # (nx, ny): Nodes on the profile, and others at the bound (None without one); the same for the next
    # set.
    nodes: Mask
    following: Mask
    force: Array
    gap: Array
    plastic: Mask | None = None
    sinking: Mask | None = None

    def read(self, block: Block, *, offset: float, displacement: Array) -> _State:
        """Take over the displacement of the linear problem of this set."""
        nodes, plastic = self.nodes, self.plastic
        force = -block.surface(block.apply(displacement))
        gap = offset - block.heights - block.surface(displacement)
        sinking = None
        if plastic is None or block.bound is None:
            following = np.where(nodes, force > 0, gap < 0)
            # Off the set the nodal force is the linear residual, on it the gap is rounding.
            force = np.where(nodes, force, 0.0)
        else:
            sinking = np.where(plastic, gap <= 0, nodes & (force > block.bound))
            following = np.where(plastic, gap > 0, np.where(nodes, force > 0, gap < 0)) & ~sinking
            force = np.where(nodes, force, np.where(plastic, block.bound, 0.0))
        return replace(
            self,
            displacement=displacement,
            offset=offset,
            following=following,
            sinking=sinking,
            force=force,
            gap=np.where(nodes, 0.0, gap),
        )

    def anchored(self, block: Block, load: float | None) -> _State:
        """Return a next set that leaves the profile a node to rest on, whose equation the load is.

        Where all contact is at its bound, the nodes nearest to its edge make up for what the load misses.
        """
        bound, sinking = block.bound, self.sinking
        if bound is None or sinking is None or load is None or self.following.any():
            return self
        missing = load - float(bound[sinking].sum())
        some = np.flatnonzero(~sinking if missing > 0 else sinking)
        near = some[np.argsort(self.gap.flat[some] if missing > 0 else -self.gap.flat[some], kind="stable")]
        count = int(np.searchsorted(np.cumsum(bound.flat[near]), abs(missing))) + 1
        following = self.following.copy()
        following.flat[near[:count]] = True
        return replace(self, following=following, sinking=sinking & ~following)

    @property
    def settled(self) -> bool:
        """Whether the set reproduces itself."""
        return self.key == _key(self.nodes, self.plastic)

    @property
    def key(self) -> bytes:
        """The next set, hashable."""
        return _key(self.following, self.sinking)

    def moved(self) -> _State:
        """Return the same displacement with the next set."""
        return replace(self, nodes=self.following, plastic=self.sinking)


def _key(nodes: Mask, plastic: Mask | None) -> bytes:
    return nodes.tobytes() if plastic is None else nodes.tobytes() + plastic.tobytes()


class _SetProblem:
    """The linear problem of one set: u outside the set, and the offset where the load is given."""

    def __init__(self, block: Block, nodes: Mask) -> None:
        self.block, self.tied = block, block.vertical(nodes)
        self.preconditioner = CyclePreconditioner(block, nodes)

    def advance(
        self, state: _State, *, load: float | None, tolerance: float
    ) -> tuple[_State, LinearSolution]:
        """Solve for displacement and offset with the nodes of the set tied to the profile."""
        prescribed = np.zeros_like(state.displacement)
        prescribed[self.tied] = -self.block.heights[state.nodes]
        if load is None:
            prescribed[self.tied] += state.offset
        right = -self.block.apply(prescribed)
        bound, plastic, whole = self.block.bound, state.plastic, load
        if bound is not None and plastic is not None:
            right[self.block.vertical(plastic)] -= bound[plastic]
            load = None if load is None else load - float(bound[plastic].sum())
        total = float(right[self.tied].sum())
        right[self.tied] = 0
        guess = state.displacement.copy()
        guess[self.tied] = 0

        def applied(x: Array) -> Array:
            full = x[: guess.size].copy()
            if load is not None:
                full[self.tied] = x[-1]
            image = self.block.apply(full)
            moment = image[self.tied].sum()
            image[self.tied] = 0
            return image if load is None else np.append(image, moment)

        def preconditioned(r: Array) -> Array:
            free, shift = self.preconditioner.apply(r[: guess.size], None if load is None else float(r[-1]))
            return free if load is None else np.append(free, shift)

        solution = conjugate_gradients(
            applied,
            right if load is None else np.append(right, total - load),
            precondition=preconditioned,
            start=guess if load is None else np.append(guess, state.offset),
            scale=self.block.force_scale(
                state.nodes if plastic is None else state.nodes | plastic, state.offset, load=whole
            ),
            tolerance=tolerance,
            max_iterations=_LINEAR_STEPS,
        )
        offset, displacement = state.offset, solution.x[: guess.size] + prescribed
        if load is not None:
            offset = float(solution.x[-1])
            displacement[self.tied] += offset
        solved = state.read(self.block, offset=offset, displacement=displacement)
        return solved.anchored(self.block, whole), solution


def solve_contact(
    block: Block,
    *,
    load: float | None,
    offset: float,
    start: Mask,
    tolerance: float,
    max_iterations: int,
    violation: Violation,
    displacement: Array | None = None,
) -> Answer:
    """Press a rigid profile into the block.

    The load is the total downward force over E times the cell width squared; without it the offset, over the
    cell width, is prescribed and no first guess, as set and displacement (nx, ny, nz, 3) are. The tolerance
    bounds the linear residual over the norm of the contact forces, and what an unsettled set may still
    violate: `violation` measures that, dimensionless. At most so many active sets are tried.

    The set is updated to {contact nodes under pressure} and {other nodes that penetrate}: a semi-smooth
    Newton step; {contact nodes pressed beyond a bound} and {nodes at it that do not open} go to the bound.
    With the linear systems solved, complementarity holds exactly, and a set that reproduces itself is the
    solution. The first sets are found with loosely solved systems. A set seen before means a cycle; it is
    accepted where what it violates is below the tolerance (ties), and reported otherwise.
    """
    if displacement is None:
        displacement = np.zeros(3 * block.heights.size * block.levels)
    state = _State(
        displacement=displacement.ravel(),
        offset=offset,
        nodes=start,
        following=start,
        force=np.zeros(block.shape),
        gap=np.zeros(block.shape),
        plastic=None if block.bound is None else np.zeros(block.shape, dtype=bool),
    )
    seen: set[bytes] = set()
    loosely = max(_LOOSE, tolerance)
    status = Status.ITERATION_LIMIT
    linear, peak, sets = 0, 0, 0
    while sets < max_iterations:
        problem = _SetProblem(block, state.nodes)
        peak, sets = max(peak, problem.preconditioner.nbytes), sets + 1
        state, solution = problem.advance(state, load=load, tolerance=loosely)
        linear += solution.iterations
        if not solution.converged and solution.iterations >= _LINEAR_STEPS:
            # What is not solved loosely will not be solved tightly, and sets read off it mean nothing.
            status = Status.ITERATION_LIMIT
            break
        if loosely > tolerance and (state.settled or state.key in seen):
            loosely = tolerance
            seen.clear()
            state, solution = problem.advance(state, load=load, tolerance=tolerance)
            linear += solution.iterations
        if loosely == tolerance:
            verdict = _verdict(state, solution, seen=seen, tolerance=tolerance, violation=violation)
            if verdict is not None:
                status = verdict
                break
        if sets < max_iterations:
            seen.add(_key(state.nodes, state.plastic))
            state = state.moved()
    at_bound = None
    if block.bound is not None and state.plastic is not None:
        # A node that the profile rests on may be among them.
        at_bound = state.plastic | (state.nodes & (state.force >= (1 - tolerance) * block.bound))
    field = np.zeros((*block.shape, block.levels + 1, 3))
    field[:, :, 1:] = state.displacement.reshape(*block.shape, block.levels, 3)
    return Answer(
        force=state.force,
        gap=state.gap,
        displacement=-field[:, :, -1, 2],
        in_contact=state.nodes if state.plastic is None else state.nodes | state.plastic,
        offset=state.offset,
        status=status,
        iterations=sets,
        linear_iterations=linear,
        bytes=peak,
        method="refined" if block.refined else "multigrid",
        note=f"linear residual {solution.relative_residual:.3g} of the contact forces",
        field=field,
        at_bound=at_bound,
    )


def _verdict(
    state: _State, solution: LinearSolution, *, seen: set[bytes], tolerance: float, violation: Violation
) -> Status | None:
    """Return how the iteration ends with a set solved to the tolerance; None where it goes on."""
    if not solution.converged:
        return Status.ITERATION_LIMIT if solution.iterations >= _LINEAR_STEPS else Status.STAGNATED
    if state.settled or violation(state.force, state.gap, state.plastic) <= tolerance:
        return Status.CONVERGED
    return Status.CYCLING if state.key in seen else None
