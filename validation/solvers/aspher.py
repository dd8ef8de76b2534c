"""The preconditioned conjugate gradients of ASPHER on its doubly periodic half-space, written in C++."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.arrays import Array
from validation.effects.base import Effect
from validation.errors import UsageError
from validation.solvers.external import ExternalSolver

if TYPE_CHECKING:
    from validation.scenes.problem import ContactProblem

#: Of the tolerance that is asked for: what it calls its error is the residual of another norm.
_SAFETY = 0.1


class Aspher(ExternalSolver):
    """Polonsky and Keer's conjugate gradients of ASPHER, with its preconditioner; square grids alone."""

    name = "aspher"
    label = "ASPHER"
    package = "aspher"
    install = "pip install aspher (it builds with cmake, ninja and Eigen)"
    locates_edges = True
    papers = ("ASPHER: V. A. Yastrebov, https://github.com/cofebem/aspher.",)

    def check(self, options: Any, problem: ContactProblem, effects: Sequence[Effect]) -> None:
        """Refuse what is not square."""
        super().check(options, problem, effects)
        wide = next((grid for grid in options.grids if grid[0] != grid[1]), None)
        if wide is not None or problem.lengths[0] != problem.lengths[1]:
            raise UsageError(
                f"methods.aspher.grids = {wide or options.grids[0]}: ASPHER has square grids on square "
                "periods; leave [methods.aspher] out"
            )


def solve(
    heights: Array,
    lengths: tuple[float, float],
    *,
    contact_modulus: float,
    mean_pressure: float,
    tolerance: float,
    max_iterations: int = 20_000,
) -> dict[str, Any]:
    """Return pressures [Pa], iterations and its word; E* = 1 and the period 1 go in."""
    if heights.shape[0] != heights.shape[1] or lengths[0] != lengths[1]:
        raise ValueError("ASPHER has square grids on square periods")
    import aspher

    solution = aspher.ContactSolver(grid_size=heights.shape[0], backend="periodic").solve(
        np.ascontiguousarray((heights.max() - heights) / lengths[0]),
        mean_pressure / contact_modulus,
        tol=_SAFETY * tolerance,
        max_iter=max_iterations,
        precond="fourier",
    )
    return {
        "pressure": solution.pressure * contact_modulus,
        "iterations": int(solution.iterations),
        "converged": bool(solution.converged),
    }
