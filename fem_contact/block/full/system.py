"""The full system of the block, and coarser grids that propose a first active set."""

import numpy as np

from fem_contact._types import Array, Mask
from fem_contact.block.full.active_set import Violation, solve_contact
from fem_contact.block.full.block import Block
from fem_contact.block.full.multigrid import build_hierarchy
from fem_contact.block.full.quadratic import QuadraticBlock, parity_blocks, refined_hierarchy
from fem_contact.block.mesh import node_weights
from fem_contact.block.problem import Answer, Problem
from fem_contact.settings import one_blas_thread

#: Set, offset and displacement to start from.
First = tuple[Mask, float, Array | None]

#: Below this many nodes along an axis no coarser grid looks for the first active set.
_COARSEST = 16
#: A coarser grid only proposes a set.
_COARSE_TOLERANCE = 1e-3
#: A node all of whose parents on the coarser grid touch is taken to touch.
_INSIDE = 0.999


def prepared(problem: Problem) -> Block:
    """Return the block with its grids, which all solves of one session share."""
    mesh, poisson, modulus = problem.mesh, problem.poisson, problem.modulus
    # Moduli over E: of all cells, (nx, ny, nz), or of the layers alone, (nz,).
    cells = np.broadcast_to(1.0 if modulus is None else modulus, (*mesh.cells, mesh.nz))
    varying = None if modulus is None else cells if problem.lateral else cells[0, 0]
    if mesh.element.order == 1:
        return Block(
            hierarchy=build_hierarchy(mesh, poisson=poisson, modulus=varying),
            heights=problem.heights,
            bound=problem.force_bound,
        )
    return QuadraticBlock(
        mesh=mesh,
        heights=problem.heights,
        bound=problem.force_bound,
        cells=parity_blocks(mesh, poisson=poisson),
        modulus=np.ascontiguousarray(cells),
        hierarchy=refined_hierarchy(mesh, poisson=poisson, modulus=varying),
    )


def solve_full(problem: Problem, start: Mask | Answer | None, block: Block) -> Answer:
    """Solve the whole block from a first set or solution, by default from a coarser grid's."""
    with one_blas_thread():
        first = _first(block, problem, start)
        return _pressed(block, problem, first, tolerance=problem.tolerance, violation=problem.violation)


def _first(block: Block, problem: Problem, start: Mask | Answer | None) -> First:
    """Set, offset and displacement to start from: what is known, or what coarser or simpler cells answer."""
    if isinstance(start, Answer):
        return start.in_contact, start.offset, _above(start)
    if start is not None:
        return start, 0.0, None
    if not isinstance(block, QuadraticBlock):
        return _proposed(block, problem)
    bound, weights = block.bound, node_weights(block.mesh)
    trilinear = Block(
        hierarchy=block.hierarchy,
        heights=block.heights,
        bound=bound if bound is None or weights is None else bound / weights,
    )
    answer = _loosely(trilinear, problem)
    return answer.in_contact, answer.offset, _above(answer)


def _above(answer: Answer) -> Array:
    """Displacement above the clamped plane, in one piece: other layouts are compiled anew."""
    assert answer.field is not None
    return np.ascontiguousarray(answer.field[:, :, 1:])


def _loosely(block: Block, problem: Problem) -> Answer:
    """Solve a block that only proposes a set."""
    return _pressed(
        block,
        problem,
        _proposed(block, problem),
        tolerance=max(_COARSE_TOLERANCE, problem.tolerance),
        violation=lambda *_: np.inf,
    )


def _proposed(block: Block, problem: Problem) -> First:
    """First set, offset and displacement, prolonged from the contact solved on the next coarser grid."""
    if min(block.shape) < _COARSEST:
        return highest_nodes(block.heights, problem), 0.0, None
    answer = _loosely(block.coarser(load=problem.load), problem)
    level = block.hierarchy.levels[0]
    field = level.prolonged(_above(answer))
    inside = level.prolonged(answer.in_contact.astype(float)[:, :, None])[:, :, 0] > _INSIDE
    return inside | (answer.offset - block.heights - field[:, :, -1, 2] < 0), answer.offset, field


def _pressed(
    block: Block, problem: Problem, first: First, *, tolerance: float, violation: Violation
) -> Answer:
    nodes, offset, displacement = first
    return solve_contact(
        block,
        load=problem.load,
        offset=offset if problem.offset is None else problem.offset,
        start=nodes if nodes.any() else highest_nodes(block.heights, problem),
        displacement=displacement,
        tolerance=tolerance,
        max_iterations=problem.steps,
        violation=violation,
    )


def highest_nodes(heights: Array, problem: Problem) -> Mask:
    """Take the points beyond the undeformed surface, or the highest, about as many as will touch."""
    if problem.offset is not None:
        return heights >= min(problem.offset, float(np.max(heights)))
    assert problem.pressure is not None
    relative = problem.pressure / problem.gradient if problem.gradient > 0 else 1.0
    share = min(1.0, max(2 * relative, 1 / heights.size))
    return heights >= np.quantile(heights, 1 - share, method="lower")
