"""The protocol between contact solvers and discretisations: an operator goes in, a solution comes out.

The unknown x is the *force* on each surface node in units of the mean cell area, x = w p with the node's
weight w (area of the node over the mean cell area). In forces the response S of any discretisation is a
symmetric matrix and the load is a plain sum, so the solver needs no weights: where all nodes are alike x is
the pressure; with several node types per cell (quadratic elements) the caller passes x = w p and divides the
answer by w. Arrays have the shape (nx, ny) of a periodic lattice of nodes, in order of their places (corner,
edge and centre nodes of quadratic elements interleaved); they are C-contiguous doubles.

An :class:`Operator` offers

``apply(force, out)``
    out = S force: displacement [m] of every node. Must not keep or change ``force``; ``out`` is another
    array.
``precondition(residual, out)``
    out = M residual with M symmetric, positive semi-definite, close to the inverse of S, at the same scale;
    the mean may be left out. The solver extends the residual beyond the working set and masks the answer, so
    neither needs care. ``out`` may be ``residual`` itself.
``stiffness``
    Force per displacement [Pa/m] of a single node, roughly: the mean over wavevectors of the inverse
    response.
``pairs``
    FFT pairs that one ``apply`` costs, counted on the finest grid; ``precondition`` is counted as one.

Whether S moves the mean (layer, block) or leaves it out (half-space) does not matter when the load is
prescribed: a constant displacement only changes the offset.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from fem_contact._types import Array, Mask
from fem_contact.contact import Status

__all__ = ["Operator", "Solution"]


class Operator(Protocol):
    """A symmetric positive semi-definite response and an approximate inverse of it; see the protocol."""

    @property
    def stiffness(self) -> float:
        """Force per displacement [Pa/m] at the grid scale: mean inverse response over wavevectors."""
        ...

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
    """What a complementarity solver returns."""

    force: Array  # x [Pa], within its bounds, its mean the prescribed one to rounding
    displacement: Array  # S x [m], applied afresh to the returned force
    offset: float  # Multiplier of the load [m]
    # The solver's working sets.
    in_contact: Mask
    at_bound: Mask
    status: Status
    iterations: int
    fft_pairs: float
    peak_bytes: int = 0
