r"""The bounded quadratic programme of frictionless contact; it knows nothing but "apply the response".

.. math:: \min_x\ \tfrac12\, x\cdot S x - x\cdot h ,\qquad 0 \le x \le x_{\max},\qquad \textstyle\sum x = F

Its optimality conditions are those of contact: with the gap g = S x - h + offset (the offset is the
multiplier of the load), g = 0 where 0 < x < x_max, g >= 0 where x = 0, g <= 0 where x = x_max.

Protocol
--------
The unknown x is the *force* on each surface node in units of the mean cell area, x = w p with the node's
weight w (area of the node over the mean cell area). In forces the response S of any discretisation is a
symmetric matrix and the load is a plain sum, so the solver needs no weights: where all nodes are alike x is
the pressure; with several node types per cell (quadratic elements) the caller passes x = w p and divides the
answer by w. Arrays may have any shape, for instance (nx, ny), or (types, nx, ny); all arrays of one problem
share it and are C-contiguous doubles.

An :class:`Operator` offers

``apply(force, out)``
    out = S force: displacement [m] of every node. Must not keep or change ``force``.
``precondition(residual, out)``
    out = M residual with M symmetric, positive semi-definite, close to the inverse of S (any constant factor
    is allowed). The solver hands in a residual that vanishes off the working set, and masks the answer, so
    neither needs care.
``pairs``
    FFT pairs that one ``apply`` costs, counted on the finest grid; ``precondition`` is counted the same.

Whether S moves the mean (layer, block) or leaves it out (half-space) does not matter when the load is
prescribed: a constant displacement only changes the offset.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from fem_contact.contact import Status

__all__ = ["Operator", "Solution", "polonsky_keer"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


class Operator(Protocol):
    """A symmetric positive semi-definite response and an approximate inverse of it; see the protocol."""

    @property
    def pairs(self) -> float:
        """FFT pairs per application."""
        ...

    def apply(self, force: Array, out: Array) -> None:
        """Write the displacement [m] under ``force`` [Pa] into ``out``."""
        ...

    def precondition(self, residual: Array, out: Array) -> None:
        """Write an approximate inverse of the response, applied to ``residual`` [m], into ``out`` [Pa]."""
        ...


@dataclass(frozen=True, kw_only=True)
class Solution:
    """What a complementarity solver returns.

    Attributes
    ----------
    force : array
        x [Pa], within its bounds, its mean the prescribed one to rounding.
    displacement : array
        S x [m], applied afresh to the returned force.
    offset : float
        Multiplier of the load [m].
    in_contact, at_bound : array of bool
        The solver's working sets.
    status : Status
    iterations : int
    fft_pairs : float
    """

    force: Array
    displacement: Array
    offset: float
    in_contact: Mask
    at_bound: Mask
    status: Status
    iterations: int
    fft_pairs: float


def polonsky_keer(
    operator: Operator,
    heights: Array,
    *,
    mean_force: float,
    length_scale: float,
    tolerance: float,
    max_iterations: int,
    start: Array | None = None,
) -> Solution:
    """Bounded conjugate gradients without preconditioner: slow, simple, and the oracle of the faster solver.

    Parameters
    ----------
    operator : Operator
    heights : array
        h [m] of the rigid body at the nodes.
    mean_force : float
        Prescribed mean of x [Pa], positive.
    length_scale : float
        Length [m] in which the residuals are measured.
    tolerance : float
        Stop at sum x |g| <= tolerance * length_scale * sum x and penetration <= 10 tolerance * length_scale.
    max_iterations : int
    start : array, optional
        Forces [Pa] to start from, not negative, scaled to the load here; uniform if not given.

    Notes
    -----
    I. A. Polonsky, L. M. Keer, Wear 231 (1999) 206, without a pressure bound.
    """
    force = np.full(heights.shape, mean_force) if start is None else start * (mean_force / np.mean(start))
    gap, image, direction = np.empty_like(force), np.empty_like(force), np.zeros_like(force)
    previous, keep, status = 1.0, False, Status.ITERATION_LIMIT
    iteration = 0
    while iteration < max_iterations:
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
