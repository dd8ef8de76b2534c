r"""Newton's method with an active set: a neo-Hookean block under a frictionless rigid profile.

The energy of the cells is least, with F times the offset d, where no surface node lies
above the profile:

.. math:: g_i = d - h(x_i, y_i) - z_i \ge 0,\quad \lambda_i \ge 0,\quad \lambda_i g_i = 0,
          \quad \sum_i \lambda_i = F

at the *current* places of the nodes. The force of a node is lambda_i grad g_i, normal to the profile
where it is, and lambda_i is its vertical part. Each step solves the tangent problem in which the nodes of
the set stay on the tangent planes of the profile: their heights follow from their sideways motion and from
the offset, and are eliminated. That leaves a symmetric matrix, solved by conjugate gradients; the linear
block's multigrid with these nodes tied preconditions it. Lengths are in cell widths and stresses in
Young's modulus.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fem_contact._types import Array, Mask
from fem_contact.block.full.block import Block, CyclePreconditioner
from fem_contact.block.full.linear import conjugate_gradients
from fem_contact.block.full.multigrid import Hierarchy
from fem_contact.block.hyperelastic.cells import Cells, Strained
from fem_contact.block.hyperelastic.profile import Heights, Profile

#: Bounds on the linear residual of a step, over the contact forces.
_LOOSE = 1e-2
#: Halvings of a step that would turn a cell inside out.
_HALVINGS = 6
#: A residual larger than this is no longer worth a step.
_LOST = 1e3


@dataclass(frozen=True, kw_only=True)
class State:
    """Where the nodes are, and what presses on them."""

    field: Array  # (nx, ny, nz, 3): u above the clamped plane
    offset: float  # d
    force: Array  # (nx, ny): lambda_i
    nodes: Mask  # (nx, ny): The active set
    history: tuple[float, ...] = ()  # Residual after each step
    linear: int = 0  # Conjugate-gradient steps
    trouble: str = ""  # Why there is no solution; empty where this is one
    strained: Strained | None = None  # The cells at this field, where they are known

    def scaled(self, factor: float) -> State:
        """Return the guess for a problem whose heights and load are those of this one times a factor."""
        return State(
            field=factor * self.field,
            offset=factor * self.offset,
            force=factor * self.force,
            nodes=self.nodes,
        )


@dataclass(frozen=True, kw_only=True)
class Press:
    """A profile to be pressed into a block."""

    cells: Cells
    hierarchy: Hierarchy  # Grids of the linear block
    profile: Profile
    load: float  # F, over E times the square of the cell width
    roughness: float  # Length in which gaps are measured
    tolerance: float
    steps: int  # Newton steps at most

    def scaled(self, factor: float) -> Press:
        """Multiply heights and load."""
        profile = replace(self.profile, coefficients=factor * self.profile.coefficients)
        return replace(self, profile=profile, load=factor * self.load, roughness=factor * self.roughness)

    def below(self, field: Array) -> Heights:
        """Profile above the current places of the surface nodes."""
        nx, ny = self.cells.mesh.cells
        x = np.arange(nx)[:, None] + field[:, :, -1, 0]
        y = np.arange(ny)[None, :] * self.cells.mesh.aspect + field[:, :, -1, 1]
        return self.profile.at(x, y)

    def gap(self, state: State) -> Array:
        """Return g at every node."""
        return state.offset - self.below(state.field).height - state.field[:, :, -1, 2]

    def unbalanced(self, state: State) -> Array:
        """Return the forces of the cells less those of the contact, (nx, ny, nz, 3)."""
        rest = self.cells.forces(state.strained or self.cells.strained(state.field))
        slope = self.below(state.field).slope
        rest[:, :, -1, :2] += state.force[..., None] * slope
        rest[:, :, -1, 2] += state.force
        return rest

    def residual(self, state: State) -> float:
        """Return what is not balanced over the contact forces, or the error of the load if that is more."""
        rest = float(np.linalg.norm(self.unbalanced(state)))
        missing = abs(float(state.force.sum()) / self.load - 1)
        return max(rest / float(np.linalg.norm(state.force)), missing)


def descend(press: Press, start: State) -> State:
    """Take Newton steps until set, gaps and forces settle; `trouble` says why where they do not."""
    state, seen = start, set[bytes]()
    if not float(press.cells.strained(start.field).jacobian.min()) > 0:
        return replace(start, trouble="a cell turned inside out")
    for _ in range(press.steps):
        moved = _step(press, state)
        if moved.trouble:
            return moved
        gap = press.gap(moved)
        following = np.where(moved.nodes, moved.force > 0, gap < 0)
        closed = float(np.max(np.abs(gap[moved.nodes]), initial=0.0)) / press.roughness
        residual = max(press.residual(moved), closed)
        moved = replace(moved, history=(*state.history, residual))
        if not residual < _LOST:
            return replace(moved, trouble=f"the residual grew to {residual:.3g}")
        settled = bool(np.array_equal(following, moved.nodes))
        if residual <= press.tolerance and settled:
            return replace(moved, strained=None)
        if not following.any():
            return replace(moved, trouble="the contact was lost")
        key = following.tobytes()
        if not settled and residual <= press.tolerance and key in seen:
            return replace(moved, trouble="the active set repeats itself")
        seen.add(key)
        state = replace(moved, nodes=following, force=np.where(following, np.maximum(moved.force, 0.0), 0.0))
    return replace(state, trouble=f"{press.steps} Newton steps left a residual of {state.history[-1]:.3g}")


def _step(press: Press, state: State) -> State:
    """Solve the tangent problem of the active set, and go there as far as no cell turns inside out."""
    tangent = _Tangent(press, state)
    change, shift, steps, converged = tangent.solved()
    if not converged:
        return replace(state, trouble="the tangent stiffness is not positive definite")
    fraction = 1.0
    for _ in range(_HALVINGS):
        field = state.field + fraction * change
        strained = press.cells.strained(field)
        if float(strained.jacobian.min()) > 0:
            force = state.force + fraction * (tangent.force(change) - state.force)
            return replace(
                state,
                field=field,
                offset=state.offset + fraction * shift,
                force=force,
                linear=state.linear + steps,
                strained=strained,
            )
        fraction *= 0.5
    return replace(state, trouble="a cell turned inside out")


class _Tangent:
    """The linear problem of one step."""

    def __init__(self, press: Press, state: State) -> None:
        self.press, self.state = press, state
        strained = state.strained or press.cells.strained(state.field)
        heights, nodes = press.below(state.field), state.nodes
        # Stiffness of the cells, and of the contact forces, which turn with the profile.
        self.matrix = press.cells.stiffness(strained, turning=state.force[..., None] * heights.curvature)
        self.internal = press.cells.forces(strained)
        self.slope = heights.slope[nodes]
        self.gap = (state.offset - heights.height - state.field[:, :, -1, 2])[nodes]

    def times(self, field: Array) -> Array:
        """Multiply a displacement."""
        return (self.matrix @ field.ravel()).reshape(field.shape)

    def lifted(self, free: Array) -> Array:
        """Displacement from the free unknowns: nodes of the set stay on the tangent planes."""
        field = free[:-1].reshape(self.internal.shape).copy()
        top = field[:, :, -1]
        top[self.state.nodes, 2] = free[-1] - np.sum(self.slope * top[self.state.nodes, :2], axis=-1)
        return field

    def dropped(self, forces: Array) -> Array:
        """Transpose of `lifted`: forces on the free unknowns."""
        rest = forces.copy()
        top = rest[:, :, -1]
        vertical = top[self.state.nodes, 2]
        top[self.state.nodes, :2] -= self.slope * vertical[:, None]
        top[self.state.nodes, 2] = 0
        return np.append(rest.ravel(), vertical.sum())

    def solved(self) -> tuple[Array, float, int, bool]:
        """Change of the displacement and of the offset; conjugate-gradient steps; whether they converged."""
        nodes = self.state.nodes
        closing = np.zeros_like(self.internal)
        closing[nodes, -1, 2] = self.gap
        right = -self.dropped(self.internal + self.times(closing))
        right[-1] -= self.press.load
        block = Block(hierarchy=self.press.hierarchy, heights=np.zeros(nodes.shape))
        inverse = CyclePreconditioner(block, nodes)

        def precondition(rest: Array) -> Array:
            field, shift = inverse.apply(rest[:-1], float(rest[-1]))
            return np.append(field, shift)

        scale = self.press.load / np.sqrt(nodes.sum())
        off = float(np.linalg.norm(right)) / scale
        aim = max(min(_LOOSE * off, off**2), 0.1 * self.press.tolerance)
        solution = conjugate_gradients(
            lambda free: self.dropped(self.times(self.lifted(free))),
            right,
            precondition=precondition,
            start=np.zeros_like(right),
            scale=scale,
            tolerance=aim,
            max_iterations=400,
        )
        change = self.lifted(solution.x) + closing
        return change, float(solution.x[-1]), solution.iterations, solution.converged

    def force(self, change: Array) -> Array:
        """Vertical contact forces after the change."""
        vertical = (self.internal + self.times(change))[:, :, -1, 2]
        return np.where(self.state.nodes, -vertical, 0.0)
