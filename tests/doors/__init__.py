"""Every public door of `fem_contact` and `persson`, each with arguments it accepts."""

from doors.blocks import block_doors
from doors.solvers import solver_doors
from doors.theory import theory_doors

__all__ = ["block_doors", "solver_doors", "theory_doors"]
