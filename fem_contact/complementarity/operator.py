"""The protocol between contact solvers and discretisations: an operator goes in, a solution comes out.

The unknown x is the *force* on each surface node in units of the mean cell area, x = w p with the node's
weight w (area of the node over the mean cell area). In forces the response S of any discretisation is a
symmetric matrix and the load is a plain sum, so the solver needs no weights: where all nodes are alike x is
the pressure; with several node types per cell (quadratic elements) the caller passes x = w p and divides the
answer by w. Arrays have the shape (nx, ny) of a periodic lattice of nodes, in order of their places (corner,
edge and centre nodes of quadratic elements interleaved); they are C-contiguous doubles.

Whether S moves the mean (layer, block) or leaves it out (half-space) does not matter when the load is
prescribed: a constant displacement only changes the offset.
"""

from dataclasses import dataclass
from typing import Protocol

from fem_contact._types import Array, Mask
from fem_contact.contact import Status


class Operator(Protocol):
    """A symmetric positive semi-definite response S and an approximate inverse of it."""

    @property
    def stiffness(self) -> float:
        """Force per displacement [Pa/m] of a single node, roughly: mean inverse response over wavevectors."""

    @property
    def pairs(self) -> float:
        """FFT pairs of one `apply`, counted on the finest grid; `precondition` is counted as one."""

    def apply(self, force: Array, out: Array) -> None:
        """Write the displacement S force [m] of every node into ``out``, another array; keep no ``force``."""

    def precondition(self, residual: Array, out: Array) -> None:
        """Write M residual into ``out`` [Pa], which may be ``residual`` [m] itself.

        M is symmetric, positive semi-definite and close to the inverse of S, at the same scale; the mean may
        be left out. The solver extends the residual beyond the working set and masks the answer.
        """


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
