"""The full system of the block: the solver it takes, and coarser grids that propose a first active set."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fem_contact.block.full.active_set import ActiveSetSolution, Settings, solve_contact
from fem_contact.block.full.assembly import assemble
from fem_contact.block.full.block import AssembledBlock
from fem_contact.block.full.multigrid import (
    Hierarchy,
    RefinedBlock,
    StencilBlock,
    build_hierarchy,
    refined_hierarchy,
)
from fem_contact.block.mesh import plan_mesh
from fem_contact.block.problem import Found, Problem

if TYPE_CHECKING:
    import scipy.sparse as sp

__all__ = ["highest_nodes", "prepared", "solve_full"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Set, offset and displacement to start from.
First = tuple[Mask, float, Array | None]
Violation = Callable[[Array, Array, Mask | None], float]

#: Below this many nodes along an axis no coarser grid looks for the first active set.
_COARSEST = 16

#: A coarser grid only proposes a set.
_COARSE_TOLERANCE = 1e-3

#: A node all of whose parents on the coarser grid touch is taken to touch.
_INSIDE = 0.999

#: Least ratio of mean bound and mean pressure on a coarser grid.
_CARRYING = 1.01

#: Largest Poisson ratio at which trilinear cells, which lock, precondition triquadratic ones.
_COMPRESSIBLE = 0.45

#: Above this Poisson ratio smoothed aggregation needs hundreds of steps; small blocks are then factorised.
_CRAWLING = 0.49
_DIRECT_UNKNOWNS = 40_000

#: Conjugate-gradient steps allowed for one active set, with geometric multigrid and smoothed aggregation.
_LINEAR_STEPS, _AGGREGATION_STEPS = 3000, 1000

#: Steps of smoothed aggregation after which a block small enough is factorised instead.
_PATIENCE = 150


def prepared(problem: Problem) -> Hierarchy | sp.bsr_array:
    """Return what all solves on one block share: the grids of the multigrid, or the assembled stiffness."""
    mesh, modulus = problem.mesh, problem.modulus
    moduli = None if modulus is None else np.broadcast_to(modulus, (*mesh.cells, mesh.nz))
    if mesh.element.order == 1:
        modulus = moduli if moduli is None or problem.lateral else moduli[0, 0]
        return build_hierarchy(mesh, poisson=problem.poisson, modulus=modulus)
    return assemble(mesh, poisson=problem.poisson, modulus=moduli).free()


def solve_full(problem: Problem, start: Mask | Found | None, shared: Hierarchy | sp.bsr_array) -> Found:
    """Solve the whole block from a first set or solution, by default from a coarser grid's."""
    from threadpoolctl import threadpool_limits

    # Vectors are short and everything else is serial: more BLAS threads only wait for each other.
    with threadpool_limits(limits=1, user_api="blas"):
        if isinstance(shared, Hierarchy):
            found, method = _on_grids(problem, start, shared), "multigrid"
        else:
            found = _iterate(problem, start, shared)
            method = "refined" if is_refined(problem) else "assembled"
    field = np.zeros((*problem.mesh.shape, problem.mesh.planes.size, 3))
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
        fft_pairs=0.0,
        bytes=found.matrix_bytes,
        method=method,
        note=f"linear residual {found.linear_residual:.3g} of the contact forces",
        field=field,
        at_bound=found.at_bound,
    )


def _on_grids(problem: Problem, start: Mask | Found | None, hierarchy: Hierarchy) -> ActiveSetSolution:
    """Solve on the finest grid, from the answer of the next coarser one unless something better is known."""
    block = StencilBlock(hierarchy=hierarchy, heights=problem.heights, bound=problem.force_bound)
    first: First
    if isinstance(start, Found):
        assert start.field is not None
        first = start.in_contact, start.offset, start.field[:, :, 1:]
    elif start is not None:
        first = start, 0.0, None
    else:
        first = _proposed(block, problem)
    return _pressed(
        block,
        problem,
        first,
        steps=_LINEAR_STEPS,
        tolerance=problem.tolerance,
        violation=problem.violation,
    )


def _proposed(block: StencilBlock, problem: Problem) -> First:
    """First set, offset and displacement, prolonged from the contact solved on the next coarser grid."""
    if min(block.shape) < _COARSEST:
        return highest_nodes(block.heights, problem), 0.0, None
    coarse = block.coarser(load=problem.load)
    found = _pressed(
        coarse,
        problem,
        _proposed(coarse, problem),
        steps=_LINEAR_STEPS,
        tolerance=max(_COARSE_TOLERANCE, problem.tolerance),
        violation=lambda *_: np.inf,
    )
    level = block.hierarchy.levels[0]
    field = level.prolonged(found.displacement)
    inside = level.prolonged(found.in_contact.astype(float)[:, :, None])[:, :, 0] > _INSIDE
    return inside | (found.offset - block.heights - field[:, :, -1, 2] < 0), found.offset, field


def _pressed(
    block: StencilBlock | AssembledBlock,
    problem: Problem,
    first: First,
    *,
    steps: int,
    tolerance: float,
    violation: Violation,
) -> ActiveSetSolution:
    nodes, offset, displacement = first
    return solve_contact(
        block,
        load=problem.load,
        offset=offset if problem.offset is None else problem.offset,
        start=nodes if nodes.any() else highest_nodes(block.heights, problem),
        displacement=displacement,
        settings=Settings(tolerance=tolerance, max_iterations=problem.steps, max_linear_iterations=steps),
        violation=violation,
    )


def is_refined(problem: Problem) -> bool:
    """Whether trilinear cells between the nodes precondition the assembled stiffness."""
    return problem.mesh.element.order == 2 and not problem.lateral and problem.poisson <= _COMPRESSIBLE


def _iterate(problem: Problem, start: Mask | Found | None, matrix: sp.bsr_array) -> ActiveSetSolution:
    mesh, offset, displacement = problem.mesh, 0.0, None
    even = not any(n % 2 for n in mesh.cells) and min(mesh.shape) >= _COARSEST
    if isinstance(start, Found):
        assert start.field is not None
        nodes, offset, displacement = start.in_contact, start.offset, start.field[:, :, 1:]
    elif start is not None:
        nodes = start
    elif even and not problem.lateral and problem.offset is None:
        nodes, offset = _from_coarser(problem)
    else:
        nodes = highest_nodes(problem.heights, problem)
    if not nodes.any():
        nodes = highest_nodes(problem.heights, problem)
    return _assembled(problem, matrix, (nodes, offset, displacement))


def _assembled(problem: Problem, matrix: sp.bsr_array, first: First) -> ActiveSetSolution:
    """Solve with the assembled matrix, by what preconditions it best."""
    mesh, heights, bound = problem.mesh, problem.heights, problem.force_bound
    tolerance, violation = problem.tolerance, problem.violation
    if is_refined(problem):
        modulus = None if problem.modulus is None else problem.modulus[0, 0]
        grids = refined_hierarchy(mesh, poisson=problem.poisson, modulus=modulus)
        refined = RefinedBlock(matrix=matrix, mesh=mesh, heights=heights, bound=bound, hierarchy=grids)
        return _pressed(
            refined, problem, first, steps=_LINEAR_STEPS, tolerance=tolerance, violation=violation
        )
    small = mesh.unknowns <= _DIRECT_UNKNOWNS
    direct = problem.poisson > _CRAWLING and small
    steps = _PATIENCE if small else _AGGREGATION_STEPS
    block = AssembledBlock(matrix=matrix, mesh=mesh, heights=heights, bound=bound, direct=direct)
    found = _pressed(block, problem, first, steps=steps, tolerance=tolerance, violation=violation)
    if found.most_linear_iterations < steps or direct or not small:
        return found
    # Smoothed aggregation crawls on very thick or very thin cells.
    block = replace(block, direct=True)
    return _pressed(block, problem, first, steps=steps, tolerance=tolerance, violation=violation)


def highest_nodes(heights: Array, problem: Problem) -> Mask:
    """Take the points beyond the undeformed surface, or the highest, about as many as will touch."""
    if problem.offset is not None:
        return np.asarray(heights >= min(problem.offset, float(np.max(heights))))
    assert problem.pressure is not None
    relative = problem.pressure / problem.gradient if problem.gradient > 0 else 1.0
    share = min(1.0, max(2 * relative, 1 / heights.size))
    return np.asarray(heights >= np.quantile(heights, 1 - share, method="lower"))


def _from_coarser(problem: Problem) -> tuple[Mask, float]:
    """First active set and offset from every second cell along both axes: one eighth of the unknowns."""
    mesh, order = problem.mesh, problem.mesh.element.order
    nx, ny = mesh.cells[0] // 2, mesh.cells[1] // 2
    coarse = replace(
        problem,
        heights=problem.heights[::2, ::2] / 2,
        mesh=plan_mesh(
            (nx * order, ny * order),
            (float(nx), ny * mesh.aspect),
            depth=float(-mesh.planes[0]) / 2,
            growth=problem.growth,
            element=mesh.element,
        ),
        modulus=None,
        bound=_coarse_bound(problem),
        tolerance=max(_COARSE_TOLERANCE, problem.tolerance),
    )
    found = _iterate(coarse, None, assemble(coarse.mesh, poisson=coarse.poisson).free())
    offset = 2 * found.offset
    touching = offset - problem.heights - _refined(2 * found.displacement[:, :, -1, 2]) < 0
    touching[::2, ::2] |= found.in_contact
    return touching, offset


def _coarse_bound(problem: Problem) -> Array | None:
    """Bound on every second node, raised where those alone could not carry the load."""
    if problem.bound is None or problem.pressure is None:
        return problem.bound
    bound = problem.bound[::2, ::2]
    return bound * max(1.0, _CARRYING * problem.pressure / float(bound.mean()))


def _refined(values: Array) -> Array:
    """Bilinear interpolation of a periodic array to twice its points along both axes."""
    nx, ny = values.shape
    fine = np.empty((2 * nx, 2 * ny))
    fine[::2, ::2] = values
    fine[1::2, ::2] = 0.5 * (values + np.roll(values, -1, axis=0))
    fine[:, 1::2] = 0.5 * (fine[:, ::2] + np.roll(fine[:, ::2], -1, axis=1))
    return fine
