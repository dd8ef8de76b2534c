"""Boundary elements on a periodic grid: the response is one compliance per wavevector, applied by FFT.

The pressure is collocated at the grid points; between them it is the trigonometric interpolant, so that the
discrete response is the continuum's, C(q), at every wavevector of the grid.
"""

from fem_contact.bem.parallel import SlabResult, SlabSurface
from fem_contact.bem.problem import Method
from fem_contact.bem.solve import solve, solve_displacement, solve_path

__all__ = ["Method", "SlabResult", "SlabSurface", "solve", "solve_displacement", "solve_path"]
