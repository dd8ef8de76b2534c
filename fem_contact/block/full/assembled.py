"""The field of a block once more, from its surface forces: assembled matrix, algebraic multigrid of pyamg."""

import numpy as np

from fem_contact._checks import instance, room_for, within
from fem_contact._types import Array
from fem_contact.block.full.assembly import above_bottom, assemble
from fem_contact.block.mesh import BlockMesh, nodal_force
from fem_contact.block.solution import BlockSolution
from fem_contact.errors import InvalidInput, NotConverged

#: Of conjugate gradients.
_STEPS = 1000
#: Peak bytes per unknown, by order of the cells: matrix, its parts while it is assembled, grids of the cycle.
_BYTES_PER_UNKNOWN = {1: 5100, 2: 11_500}


def assembled_field(solution: BlockSolution, *, tolerance: float) -> Array:
    r"""Displacement of a block under the contact forces of a solution, found in another way.

    .. math:: K u = f, \qquad f_z = -p A

    K is assembled by scikit-fem and solved by pyamg's smoothed aggregation. Neither the contact algorithm nor
    the matrix-free multigrid nor the Fourier reduction enters: where the forces are right, this is the field.

    Parameters
    ----------
    solution : BlockSolution
        With nu below 1/2.
    tolerance : float
        Bound on |f - K u| / |f|, recomputed.

    Returns
    -------
    (nx, ny, planes, 3) array
        Displacement [m], as `BlockSolution.field`.

    Raises
    ------
    InvalidInput
        For arguments that cannot be used, and for the incompressible solid.
    InsufficientMemory
        Where the matrix does not fit.
    NotConverged
        Where the residual does not fall to the tolerance.
    """
    import pyamg

    instance("solution", solution, BlockSolution)
    tolerance = within("tolerance", tolerance, "[1e-13, 1e-2]")
    mesh, poisson, width = solution.mesh, solution.solid.poisson, solution.cell_size[0]
    if not poisson < 0.5:
        raise InvalidInput(f"poisson = {poisson!r}: the matrix of an incompressible solid is not finite")
    room_for(f"unknowns = {mesh.unknowns}", needed=_BYTES_PER_UNKNOWN[mesh.element.order] * mesh.unknowns)
    modulus = None if solution.modulus is None else np.broadcast_to(solution.modulus, (*mesh.cells, mesh.nz))
    matrix = above_bottom(assemble(mesh, poisson=poisson, modulus=modulus), mesh)
    forces = np.zeros((*mesh.shape, mesh.planes.size - 1, 3))
    forces[:, :, -1, 2] = -nodal_force(solution.contact.pressure / solution.solid.young, mesh)
    field = np.zeros((*mesh.shape, mesh.planes.size, 3))
    if not forces.any():
        return field
    smoother = ("block_gauss_seidel", {"sweep": "symmetric"})
    hierarchy = pyamg.smoothed_aggregation_solver(
        matrix,
        B=_rigid_modes(mesh),
        strength=("symmetric", {"theta": 0.0}),
        # Row sums instead of a spectral radius, which starts from random vectors: the same field every time.
        smooth=("jacobi", {"omega": 1.7, "degree": 1, "weighting": "local"}),
        presmoother=smoother,
        postsmoother=smoother,
        improve_candidates=None,
        coarse_solver="cholesky",
    )
    right = forces.ravel()
    solution_vector = hierarchy.solve(right, tol=0.1 * tolerance, accel="cg", maxiter=_STEPS)
    residual = float(np.linalg.norm(right - matrix @ solution_vector) / np.linalg.norm(right))
    if not residual <= tolerance:
        raise NotConverged(f"assembled block: residual {residual:.2g} after {_STEPS} steps of pyamg's cycle")
    field[:, :, 1:] = solution_vector.reshape(forces.shape) * width
    return field


def _rigid_modes(mesh: BlockMesh) -> Array:
    """Return the three translations and three rotations of the nodes above the bottom, (3 n, 6)."""
    nx, ny = mesh.shape
    x = np.arange(nx) * mesh.cells[0] / nx
    y = np.arange(ny) * mesh.aspect * mesh.cells[1] / ny
    places = np.stack(np.meshgrid(x, y, mesh.planes[1:], indexing="ij"), axis=-1).reshape(-1, 3)
    places -= places.mean(axis=0)
    modes = np.zeros((*places.shape, 6))
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        modes[:, a, a] = 1
        modes[:, b, 3 + a], modes[:, c, 3 + a] = -places[:, c], places[:, b]
    return modes.reshape(-1, 6)
