"""Conjugate gradients under bounds without preconditioner, to check the faster solver against."""

import time

import numpy as np

from fem_contact._types import Array
from fem_contact.complementarity.operator import Operator, Solution
from fem_contact.contact import Status
from fem_contact.settings import Settings


def polonsky_keer(
    operator: Operator,
    heights: Array,
    *,
    mean_force: float,
    length_scale: float,
    settings: Settings,
    start: Array | None = None,
) -> Solution:
    """Bounded conjugate gradients without preconditioner: slow, simple, and the oracle of the faster solver.

    Arguments as for `solve_bounded`, without a bound; a start must not be negative.

    Notes
    -----
    I. A. Polonsky, L. M. Keer, Wear 231 (1999) 206, without a pressure bound.
    """
    force = np.full(heights.shape, mean_force) if start is None else start * (mean_force / np.mean(start))
    gap, image, direction = np.empty_like(force), np.empty_like(force), np.zeros_like(force)
    previous, keep, status = 1.0, False, Status.ITERATION_LIMIT
    iteration, began, tolerance = 0, time.monotonic(), settings.tolerance
    while iteration < settings.max_iterations:
        if settings.expired(began):
            status = Status.TIME_LIMIT
            break
        iteration += 1
        operator.apply(force, gap)
        gap -= heights
        contact = force > 0
        offset = -float(np.mean(gap[contact]))
        gap += offset
        error = float(np.sum(force * np.abs(gap))) / float(np.sum(force)) / length_scale
        penetration = -float(gap.min()) / length_scale
        if error <= tolerance and penetration <= 10 * tolerance:
            status = Status.CONVERGED
            break
        squared = float(np.sum(gap[contact] ** 2))
        direction *= squared / previous if keep else 0.0
        direction += gap
        direction[~contact] = 0
        previous = squared
        operator.apply(direction, image)
        image -= float(np.mean(image[contact]))
        curvature = float(np.sum(image * direction))
        if not curvature > 0:
            status = Status.STAGNATED
            break
        step = float(np.sum(gap * direction)) / curvature
        force -= step * direction
        np.maximum(force, 0, out=force)
        violated = (force == 0) & (gap < 0)
        keep = not violated.any()
        force[violated] -= step * gap[violated]
        force *= mean_force / np.mean(force)
    operator.apply(force, image)
    contact = force > 0
    return Solution(
        force=force,
        displacement=image,
        offset=float(np.mean((heights - image)[contact])),
        in_contact=contact,
        at_bound=np.zeros(force.shape, dtype=bool),
        status=status,
        iterations=iteration,
        fft_pairs=(2 * iteration + 1) * operator.pairs,
    )
