"""Answers that no iteration leads to: full contact, and a bound that leaves no choice."""

from dataclasses import replace
from typing import Any

import numpy as np

from fem_contact.complementarity.operator import Operator, Solution
from fem_contact.contact import Status

#: Relative difference at which a load counts as equal to the bound: means of equal numbers differ by
#: rounding.
SLACK = 1e-12


def applied(operator: Operator, heights: Any, force: Any, *, pairs: float, xp: Any = np) -> Solution:
    """Wrap a known force that makes contact everywhere, at the offset of full contact."""
    displacement = xp.empty_like(force)
    operator.apply(force, displacement)
    return Solution(
        force=force,
        displacement=displacement,
        offset=float(xp.mean(heights - displacement)),
        in_contact=xp.ones_like(force, dtype=xp.bool),
        at_bound=xp.zeros_like(force, dtype=xp.bool),
        status=Status.CONVERGED,
        iterations=0,
        fft_pairs=pairs,
        peak_bytes=16 * force.shape[0] * force.shape[1],
    )


def all_at_bound(
    operator: Operator, heights: Any, *, mean_force: float, bound: Any, xp: Any = np
) -> Solution | None:
    """Answer where the bound leaves no choice: its mean is the load, so that all points are at it.

    Heights [m], bound and forces [Pa] are (nx, ny); the gap is u - h + offset. The offset is that of least
    indentation: the largest gap is 0. None where the bound carries more than the load.
    """
    if bound is None or float(xp.mean(bound)) > mean_force * (1 + SLACK):
        return None
    solution = applied(operator, heights, xp.asarray(bound, copy=True), pairs=operator.pairs, xp=xp)
    offset = -float(xp.max(solution.displacement - heights))
    return replace(solution, offset=offset, at_bound=solution.in_contact)


def touching(
    operator: Operator, heights: Any, rough: Any, uniform: Any, *, bound: Any, pairs: float, xp: Any = np
) -> Solution | None:
    """Answer where all points touch under the forces of the roughness, and others that move all alike.

    None where that needs tension or more than the bound.
    """
    force = rough + uniform
    if float(xp.min(force)) < 0 or (bound is not None and bool(xp.any(force > bound))):
        return None
    return applied(operator, heights, force, pairs=pairs, xp=xp)
