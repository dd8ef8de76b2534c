"""Conjugate gradients with a residual check of their own."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fem_contact._types import Array

#: Residual over what rounding leaves of the product, and over the scale, up to which nothing is left to gain:
#: of nearly incompressible blocks the first stops at 1e-12 to 1e-11, where pressures are right to 2e-12.
_ROUNDED = (4.0, 1e-10)

Operator = Callable[[Array], Array]


@dataclass(frozen=True, kw_only=True)
class LinearSolution:
    """What conjugate gradients returned."""

    x: Array
    relative_residual: float  # |b - A x| / scale, recomputed from x after the last step
    iterations: int
    # Whether that residual meets the tolerance, or is what rounding leaves of A x and at most 1e-10.
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
    """Preconditioned conjugate gradients for a symmetric positive definite operator A, A x = b.

    The tolerance is a bound on |b - A x| / `scale`, with |b|, say, as the scale.

    Notes
    -----
    The residual carried along drifts from the true one. It is recomputed whenever it claims convergence, and
    the iteration starts again from it, aiming lower, if the claim was wrong; a residual that is not finite
    counts as not converged. Steps are summed apart from x, so that each is rounded to the size of the sum
    and not of x: only the last addition and the product A x are left, which hold |b - A x| above a few
    eps | |A| |x| | (H. A. van der Vorst & Q. Ye, SIAM J. Sci. Comput. 22 (2000) 835), which is
    measured where a residual falls no further.
    """
    x = start.copy()
    iterations, best, aim = 0, float(np.finfo(float).max), 0.9 * tolerance * scale
    while True:
        residual = right - apply(x)
        relative = float(np.linalg.norm(residual)) / scale
        # Restarting gains only while the true residual is finite and still falls.
        if not tolerance < relative <= 0.5 * best or iterations >= max_iterations:
            done = relative <= tolerance
            if not done and relative <= _ROUNDED[1]:
                # A third of x is rounded anew: three times its product differs from that of x by rounding.
                rounding = float(np.linalg.norm(apply(x) - 3 * apply(x / 3))) / scale
                done = relative <= _ROUNDED[0] * rounding
            return LinearSolution(x=x, relative_residual=relative, iterations=iterations, converged=done)
        best = relative
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
