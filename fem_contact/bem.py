"""Boundary elements on a periodic grid: the response is one compliance per wavevector, applied by FFT.

The pressure is collocated at the grid points; between them it is the trigonometric interpolant, so that the
discrete response is the continuum's, C(q), at every wavevector of the grid.
"""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from fem_contact.complementarity import Solution, solve_nested
from fem_contact.contact import ContactResult, Cost, Status, measure_residuals
from fem_contact.errors import InvalidInput
from fem_contact.fourier import FourierOperator
from fem_contact.response import Response
from fem_contact.surface import HeightField

__all__ = ["FourierOperator", "solve"]

Array = NDArray[np.float64]


def solve(
    surface: HeightField,
    response: Response,
    *,
    mean_pressure: float,
    tolerance: float = 1e-8,
    max_iterations: int = 10_000,
    start: Array | None = None,
    threads: int | None = None,
) -> ContactResult:
    """Press a rigid rough surface against an elastic solid.

    Parameters
    ----------
    surface : HeightField
        The rigid body.
    response : Response
        The elastic solid.
    mean_pressure : float
        Nominal pressure p0 [Pa], positive.
    tolerance : float
        Stop when sum p |g| <= tolerance h_rms sum p and no point penetrates by more than 10 tolerance h_rms.
    max_iterations : int
        Conjugate-gradient steps allowed.
    start : (nx, ny) array, optional
        Pressure [Pa] to start from, for instance of the previous load; scaled to the load.
    threads : int, optional
        Threads of the transforms; all available processors if not given.

    Returns
    -------
    ContactResult
        Its `status` says how the solve ended; use `.checked()` before relying on it.

    Raises
    ------
    InvalidInput
        For a pressure that is not positive and finite, or a start of the wrong shape or sign.
    """
    clock, processor = time.perf_counter(), time.process_time()
    if not (np.isfinite(mean_pressure) and mean_pressure > 0):
        raise InvalidInput(f"mean_pressure = {mean_pressure!r}: must be a positive, finite pressure in Pa")
    start = _checked_start(start, surface)
    operator = FourierOperator(response, surface.shape, surface.lengths, threads=threads)
    modulus = response.contact_modulus
    solution = _full_contact(operator, surface.heights, mean_pressure)
    if solution is None:
        solution = solve_nested(
            operator,
            surface.heights,
            coarse=lambda shape: FourierOperator(response, shape, surface.lengths, threads=operator.threads),
            start=start,
            mean_force=mean_pressure,
            length_scale=surface.rms_height,
            tolerance=tolerance,
            max_iterations=max_iterations,
            threads=operator.threads,
        )
    gap = solution.displacement - surface.heights + solution.offset
    residuals = measure_residuals(
        pressure=solution.force,
        gap=gap,
        heights=surface.heights,
        lengths=surface.lengths,
        contact_modulus=modulus,
        rms_gradient=surface.rms_gradient,
        target_pressure=mean_pressure,
        at_bound=solution.at_bound,
    )
    arrays: tuple[NDArray[np.generic], ...] = (
        solution.force,
        gap,
        solution.displacement,
        surface.heights,
        operator.compliance,
    )
    return ContactResult(
        pressure=solution.force,
        gap=gap,
        displacement=solution.displacement,
        in_contact=solution.in_contact,
        at_bound=solution.at_bound,
        heights=surface.heights,
        lengths=surface.lengths,
        contact_modulus=modulus,
        offset=solution.offset,
        mean_pressure=float(np.mean(solution.force)),
        status=solution.status,
        residuals=residuals,
        cost=Cost(
            wall_seconds=time.perf_counter() - clock,
            cpu_seconds=time.process_time() - processor,
            iterations=solution.iterations,
            fft_pairs=solution.fft_pairs,
            unknowns=surface.heights.size,
            peak_bytes=sum(array.nbytes for array in arrays) + 4 * gap.nbytes,
        ),
        provenance={
            "method": "boundary elements, FFT, point collocation",
            "solver": "bounded conjugate gradients",
        },
    )


def _checked_start(start: Array | None, surface: HeightField) -> Array | None:
    if start is None:
        return None
    if start.shape != surface.shape or not np.all(np.isfinite(start)) or start.min() < 0 or start.max() <= 0:
        raise InvalidInput(
            f"start: must be pressures of shape {surface.shape}, finite, none negative and not all zero"
        )
    return start


def _full_contact(operator: FourierOperator, heights: Array, mean_pressure: float) -> Solution | None:
    """Exact answer p-hat = h-hat / C(q) where all points touch; None where that needs tension."""
    force, displacement = np.empty(heights.shape), np.empty(heights.shape)
    operator.precondition(heights, force)
    force += mean_pressure - np.mean(force)
    if force.min() < 0:
        return None
    operator.apply(force, displacement)
    return Solution(
        force=force,
        displacement=displacement,
        offset=float(np.mean(heights - displacement)),
        in_contact=np.ones(heights.shape, dtype=bool),
        at_bound=np.zeros(heights.shape, dtype=bool),
        status=Status.CONVERGED,
        iterations=0,
        fft_pairs=2 * operator.pairs,
    )
