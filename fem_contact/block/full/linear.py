"""Conjugate gradients preconditioned by pyamg's smoothed aggregation, with a residual check of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import scipy.sparse as sp

__all__ = [
    "LinearSolution",
    "Preconditioner",
    "conjugate_gradients",
    "factorised",
    "rigid_modes",
    "smoothed_aggregation",
]

Array = NDArray[np.float64]
Operator = Callable[[Array], Array]

#: Seed of the start vectors from which pyamg estimates spectral radii.
_SEED = 20060412


@contextmanager
def _seeded(seed: int) -> Iterator[None]:
    """Give pyamg, which draws from NumPy's global generator, a fixed stream; the caller's comes back."""
    state = np.random.get_state()  # noqa: NPY002
    np.random.seed(seed)  # noqa: NPY002
    try:
        yield
    finally:
        np.random.set_state(state)  # noqa: NPY002


def rigid_modes(points: Array) -> Array:
    """Three translations and three rotations at (n, 3) points, as the columns of a (3 n, 6) array.

    Rotations jump across the periodic seam; aggregates away from it still profit from them.
    """
    x, y, z = (points - points.mean(axis=0)).T
    modes = np.zeros((len(points), 3, 6))
    for component in range(3):
        modes[:, component, component] = 1
    modes[:, 1, 3], modes[:, 2, 3] = -z, y
    modes[:, 2, 4], modes[:, 0, 4] = -x, z
    modes[:, 0, 5], modes[:, 1, 5] = -y, x
    return modes.reshape(-1, 6)


@dataclass(frozen=True, kw_only=True)
class Preconditioner:
    """An approximate inverse.

    Attributes
    ----------
    apply : callable
        Maps a residual to a new array.
    nbytes : int
        Memory it holds.
    """

    apply: Operator
    nbytes: int


def smoothed_aggregation(matrix: sp.bsr_array, modes: Array) -> Preconditioner:
    """Build a cycle of pyamg's smoothed aggregation, with rigid-body modes as near-null space.

    The same matrix gives the same cycle on every call.
    """
    import pyamg
    import scipy.sparse as sp

    # pyamg sorts index arrays in place: it gets its own copies.
    parts = matrix.data.copy(), matrix.indices.copy(), matrix.indptr.copy()
    smoother = ("chebyshev", {"degree": 3, "iterations": 1})
    with _seeded(_SEED):
        hierarchy = pyamg.smoothed_aggregation_solver(
            sp.bsr_matrix(parts, shape=matrix.shape),
            B=modes,
            strength=("symmetric", {"theta": 0.0}),
            # Row sums instead of a spectral radius: as many steps, and no eigenvalue iteration in the set-up.
            smooth=("jacobi", {"omega": 1.7, "degree": 1, "weighting": "local"}),
            presmoother=smoother,
            postsmoother=smoother,
            improve_candidates=None,
            max_coarse=300,
            coarse_solver="cholesky",
        )
    cycle = hierarchy.aspreconditioner(cycle="V")

    def apply(residual: Array) -> Array:
        answer: Array = cycle @ residual
        return answer

    return Preconditioner(apply=apply, nbytes=sum(_level_bytes(level) for level in hierarchy.levels))


def _level_bytes(level: Any) -> int:
    parts = [getattr(level, name) for name in ("A", "P", "R") if hasattr(level, name)]
    return int(sum(part.data.nbytes + part.indices.nbytes + part.indptr.nbytes for part in parts))


def factorised(matrix: sp.bsr_array) -> Preconditioner:
    """Factorise the matrix itself."""
    import scipy.sparse.linalg as sla

    factors = sla.splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0)
    return Preconditioner(apply=factors.solve, nbytes=12 * int(factors.nnz))


@dataclass(frozen=True, kw_only=True)
class LinearSolution:
    """What conjugate gradients returned.

    Attributes
    ----------
    x : array
    relative_residual : float
        |b - A x| / scale, recomputed from x after the last step.
    iterations : int
    converged : bool
        Whether that residual meets the tolerance.
    """

    x: Array
    relative_residual: float
    iterations: int
    converged: bool


def conjugate_gradients(
    apply: Operator,
    right: Array,
    *,
    precondition: Operator,
    start: Array,
    scale: float,
    tolerance: float,
    max_iterations: int,
) -> LinearSolution:
    """Preconditioned conjugate gradients for a symmetric positive definite operator.

    Parameters
    ----------
    apply, precondition : callable
        The operator A and an approximation of its inverse.
    right, start : array
        Right-hand side and first guess.
    scale : float
        Norm that residuals are compared with, such as |b|.
    tolerance : float
        Bound on |b - A x| / scale.
    max_iterations : int

    Notes
    -----
    The residual carried along drifts from the true one. It is recomputed whenever it claims convergence, and
    the iteration starts again from it, aiming lower, if the claim was wrong; a residual that is not finite
    counts as not converged. Steps are summed apart from x, so that each is rounded to the size of the sum
    and not of x: only the last addition and the product A x are left, which hold |b - A x| above a few
    eps | |A| |x| | (H. A. van der Vorst & Q. Ye, SIAM J. Sci. Comput. 22 (2000) 835).
    """
    x = start.copy()
    iterations, best, aim = 0, np.inf, 0.9 * tolerance * scale
    while True:
        residual = right - apply(x)
        reached = float(np.linalg.norm(residual)) / scale
        # Restarting gains only while the true residual still falls.
        if (
            not np.isfinite(reached)
            or reached <= tolerance
            or iterations >= max_iterations
            or reached > 0.5 * best
        ):
            done = bool(np.isfinite(reached) and reached <= tolerance)
            return LinearSolution(x=x, relative_residual=reached, iterations=iterations, converged=done)
        best = reached
        direction, change = np.zeros_like(x), np.zeros_like(x)
        product = np.inf
        while iterations < max_iterations:
            preconditioned = precondition(residual)
            previous, product = product, float(residual @ preconditioned)
            direction *= product / previous
            direction += preconditioned
            image = apply(direction)
            curvature = float(direction @ image)
            if not curvature > 0:
                break
            step = product / curvature
            change += step * direction
            residual -= step * image
            iterations += 1
            if not float(np.linalg.norm(residual)) > aim:
                break
        x += change
        aim *= 0.5
