"""Boundary elements on a periodic grid: the response is one compliance per wavevector, applied by FFT.

The pressure is collocated at the grid points; between them it is the trigonometric interpolant, so that the
discrete response is the continuum's, C(q), at every wavevector of the grid.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fem_contact.complementarity import FourierOperator, Solution, polonsky_keer, solve_nested
from fem_contact.contact import ContactResult, Cost, Status, measure_residuals
from fem_contact.errors import InvalidInput
from fem_contact.response import Response
from fem_contact.surface import HeightField

__all__ = ["Method", "solve", "solve_displacement", "solve_path"]

Array = NDArray[np.float64]
Method = Literal["preconditioned", "mixed", "polonsky-keer"]


def solve(
    surface: HeightField,
    response: Response,
    *,
    mean_pressure: float,
    pressure_bound: float | Array | None = None,
    tolerance: float = 1e-8,
    max_iterations: int = 1000,
    start: Array | None = None,
    threads: int | None = None,
    method: Method = "preconditioned",
) -> ContactResult:
    """Press a rigid rough surface against an elastic solid with a given mean pressure.

    Parameters
    ----------
    surface : HeightField
        The rigid body; for two rough bodies the sum of both heights, and the composite modulus in `response`.
    response : Response
        The elastic solid.
    mean_pressure : float
        Nominal pressure p0 [Pa], positive.
    pressure_bound : float or (nx, ny) array, optional
        Largest pressure the solid bears (its hardness) [Pa]; its mean must not be below the mean pressure.
    tolerance : float
        Stop when sum p |g| <= tolerance h_rms sum p and no point penetrates by more than 10 tolerance h_rms,
        points at the bound excepted.
    max_iterations : int
        Conjugate-gradient steps allowed.
    start : (nx, ny) array, optional
        Pressure [Pa] to start from, for instance of the previous load; scaled to the load. Without it the
        solve goes from coarse to fine grids.
    threads : int, optional
        Threads of transforms and of the passes between them; all available processors if not given.
    method : {"preconditioned", "mixed", "polonsky-keer"}
        "mixed" preconditions in single precision, which saves memory and changes only the way to the answer.
        "polonsky-keer" is slow, plain, and there to check the others; it knows no bound.

    Returns
    -------
    ContactResult
        Its `status` says how the solve ended; use `.checked()` before relying on it.

    Raises
    ------
    InvalidInput
        For a pressure that is not positive and finite, a bound below it, or a start of the wrong shape or
        sign.
    """
    problem = _Problem.checked(
        surface,
        response,
        bound=pressure_bound,
        tolerance=tolerance,
        max_iterations=max_iterations,
        threads=threads,
        method=method,
    )
    problem.check_load(mean_pressure)
    solution = problem.at(mean_pressure, start=problem.checked_start(start))
    return problem.result(solution, target=mean_pressure)


def solve_displacement(
    surface: HeightField,
    response: Response,
    *,
    mean_gap: float | None = None,
    offset: float | None = None,
    pressure_bound: float | Array | None = None,
    tolerance: float = 1e-8,
    max_iterations: int = 1000,
    threads: int | None = None,
) -> ContactResult:
    """Press a rigid rough surface against an elastic solid to a given mean gap or offset.

    The load is sought at which the gap or offset has the prescribed value to 10 `tolerance` h_rms; both fall
    as it rises. On a half-space they differ by the mean height only.

    Parameters
    ----------
    mean_gap, offset : float
        Mean gap, or distance of the mean planes before deformation [m]; exactly one of them.
    surface, response, pressure_bound, tolerance, max_iterations, threads
        As in `solve`.

    Returns
    -------
    ContactResult
        Without contact (the surfaces are too far apart) the pressure is zero. At a mean gap of 0 the mean
        pressure is the least that makes full contact.

    Raises
    ------
    InvalidInput
        Unless exactly one of the two is given and finite; for a gap that is negative although nothing yields.
    """
    if (mean_gap is None) == (offset is None):
        raise InvalidInput("mean_gap, offset: give exactly one of them, in m")
    problem = _Problem.checked(
        surface,
        response,
        bound=pressure_bound,
        tolerance=tolerance,
        max_iterations=max_iterations,
        threads=threads,
        method="preconditioned",
    )
    if mean_gap is not None:
        search = _LoadSearch(problem, target=float(mean_gap), of_gap=True)
    else:
        assert offset is not None
        search = _LoadSearch(problem, target=float(offset), of_gap=False)
    return problem.result(search.run(), target=None)


def solve_path(
    surface: HeightField,
    response: Response,
    *,
    mean_pressures: Iterable[float],
    pressure_bound: float | Array | None = None,
    tolerance: float = 1e-8,
    max_iterations: int = 1000,
    threads: int | None = None,
) -> list[ContactResult]:
    """Solve a sequence of loads, up or down, each started from the one before.

    Parameters
    ----------
    mean_pressures : iterable of float
        Nominal pressures [Pa]. The problem is elastic, so an answer does not depend on the path.
    surface, response, pressure_bound, tolerance, max_iterations, threads
        As in `solve`.
    """
    problem = _Problem.checked(
        surface,
        response,
        bound=pressure_bound,
        tolerance=tolerance,
        max_iterations=max_iterations,
        threads=threads,
        method="preconditioned",
    )
    loads = list(mean_pressures)
    for load in loads:
        problem.check_load(load)
    results: list[ContactResult] = []
    previous: Array | None = None
    for load in loads:
        solution = problem.at(load, start=previous)
        results.append(problem.result(solution, target=load))
        previous = solution.force
    return results


@dataclass(kw_only=True)
class _Problem:
    """A surface, a solid and solver settings, ready to be solved at any load."""

    surface: HeightField
    response: Response
    operator: FourierOperator
    bound: Array | None
    tolerance: float
    max_iterations: int
    method: Method
    clock: float = field(default_factory=time.perf_counter)
    processor: float = field(default_factory=time.process_time)

    @classmethod
    def checked(
        cls,
        surface: HeightField,
        response: Response,
        *,
        bound: float | Array | None,
        tolerance: float,
        max_iterations: int,
        threads: int | None,
        method: Method,
    ) -> _Problem:
        """Refuse what no computation can start from, and set up the operator."""
        clock, processor = time.perf_counter(), time.process_time()
        if not (np.isfinite(tolerance) and tolerance > 0):
            raise InvalidInput(
                f"tolerance = {tolerance!r}: must be a positive number, relative to the rms height"
            )
        if max_iterations < 1:
            raise InvalidInput(f"max_iterations = {max_iterations!r}: must be at least 1")
        if threads is not None and threads < 1:
            raise InvalidInput(f"threads = {threads!r}: must be at least 1")
        if method not in ("preconditioned", "mixed", "polonsky-keer"):
            raise InvalidInput(f"method = {method!r}: must be 'preconditioned', 'mixed' or 'polonsky-keer'")
        if method == "polonsky-keer" and bound is not None:
            raise InvalidInput("method = 'polonsky-keer' knows no pressure bound: use 'preconditioned'")
        operator = FourierOperator(response, surface.shape, surface.lengths, threads=threads)
        return cls(
            surface=surface,
            response=response,
            operator=operator,
            bound=_checked_bound(bound, surface),
            tolerance=tolerance,
            max_iterations=max_iterations,
            method=method,
            clock=clock,
            processor=processor,
        )

    def check_load(self, mean_pressure: float) -> None:
        """Refuse a load that cannot be carried."""
        if not (np.isfinite(mean_pressure) and mean_pressure > 0):
            raise InvalidInput(
                f"mean_pressure = {mean_pressure!r}: must be a positive, finite pressure in Pa"
            )
        if self.bound is not None and float(np.mean(self.bound)) < mean_pressure * (1 - _SLACK):
            raise InvalidInput(
                f"pressure_bound with mean {float(np.mean(self.bound)):.6g} Pa: must not be below "
                f"mean_pressure = {mean_pressure:.6g} Pa, or nothing carries the load"
            )

    def checked_start(self, start: Array | None) -> Array | None:
        """Refuse a start that is no pressure field."""
        shape = self.surface.shape
        if start is None:
            return None
        if start.shape != shape or not np.all(np.isfinite(start)) or start.min() < 0 or not start.max() > 0:
            raise InvalidInput(
                f"start: must be pressures of shape {shape}, finite, none negative, not all zero"
            )
        return start

    def at(self, load: float, *, start: Array | None = None, tolerance: float | None = None) -> Solution:
        """Solve at one mean pressure."""
        exact = self._all_at_bound(load) or self._full_contact(load)
        if exact is not None:
            return exact
        solution = self._iterated(
            load, start=start, tolerance=self.tolerance if tolerance is None else tolerance
        )
        # One pair went into the question whether the contact is full.
        return replace(solution, fft_pairs=solution.fft_pairs + self.operator.pairs)

    def _iterated(self, load: float, *, start: Array | None, tolerance: float) -> Solution:
        heights, operator = self.surface.heights, self.operator
        if self.method == "polonsky-keer":
            return polonsky_keer(
                operator,
                heights,
                mean_force=load,
                length_scale=self.surface.rms_height,
                tolerance=tolerance,
                max_iterations=self.max_iterations,
                start=start,
            )
        return solve_nested(
            operator,
            heights,
            coarse=self._coarse,
            mean_force=load,
            length_scale=self.surface.rms_height,
            tolerance=tolerance,
            max_iterations=self.max_iterations,
            start=start,
            bound=self.bound,
            threads=operator.threads,
            single=self.method == "mixed",
        )

    def _coarse(self, shape: tuple[int, int]) -> FourierOperator:
        return FourierOperator(self.response, shape, self.surface.lengths, threads=self.operator.threads)

    def full_pressure(self) -> Array:
        """Pressure [Pa] of full contact but for its mean: p-hat = h-hat / C(q)."""
        pressure = np.empty(self.surface.shape)
        self.operator.precondition(self.surface.heights, pressure)
        pressure -= np.mean(pressure)
        return pressure

    def _full_contact(self, load: float) -> Solution | None:
        """Answer where all points touch; None where that needs tension or more than the bound."""
        force = self.full_pressure()
        force += load
        if force.min() < 0 or (self.bound is not None and np.any(force > self.bound)):
            return None
        return self.solution(force, pairs=2.0)

    def _all_at_bound(self, load: float) -> Solution | None:
        """Answer where the bound leaves no choice, at the offset of least indentation."""
        if self.bound is None or float(np.mean(self.bound)) > load * (1 + _SLACK):
            return None
        solution = self.solution(self.bound.copy(), pairs=1.0)
        offset = -float(np.max(solution.displacement - self.surface.heights))
        return replace(solution, offset=offset, at_bound=np.ones(self.surface.shape, dtype=bool))

    def solution(self, force: Array, *, pairs: float) -> Solution:
        """Wrap a known pressure that makes contact everywhere it is positive, or everywhere at all."""
        displacement = np.empty(force.shape)
        self.operator.apply(force, displacement)
        return Solution(
            force=force,
            displacement=displacement,
            offset=float(np.mean(self.surface.heights - displacement)),
            in_contact=np.ones(force.shape, dtype=bool),
            at_bound=np.zeros(force.shape, dtype=bool),
            status=Status.CONVERGED,
            iterations=0,
            fft_pairs=pairs,
            peak_bytes=force.nbytes + displacement.nbytes,
        )

    def result(self, solution: Solution, *, target: float | None) -> ContactResult:
        """Measure a solution and dress it up."""
        surface = self.surface
        gap = solution.displacement - surface.heights
        gap += solution.offset
        residuals = measure_residuals(
            pressure=solution.force,
            gap=gap,
            heights=surface.heights,
            lengths=surface.lengths,
            contact_modulus=self.response.contact_modulus,
            rms_gradient=surface.rms_gradient,
            target_pressure=target,
            at_bound=solution.at_bound,
        )
        held = self.operator.nbytes + (0 if self.bound is None else self.bound.nbytes)
        return ContactResult(
            pressure=solution.force,
            gap=gap,
            displacement=solution.displacement,
            in_contact=solution.in_contact,
            at_bound=solution.at_bound,
            heights=surface.heights,
            lengths=surface.lengths,
            contact_modulus=self.response.contact_modulus,
            offset=solution.offset,
            mean_pressure=float(np.mean(solution.force)),
            status=solution.status,
            residuals=residuals,
            cost=Cost(
                wall_seconds=time.perf_counter() - self.clock,
                cpu_seconds=time.process_time() - self.processor,
                iterations=solution.iterations,
                fft_pairs=solution.fft_pairs,
                unknowns=gap.size,
                peak_bytes=max(solution.peak_bytes + held, 4 * gap.nbytes + held),
            ),
            provenance={
                "method": "boundary elements by FFT, pressure collocated at the grid points",
                "solver": f"bounded conjugate gradients, {self.method}",
                "tolerance": repr(self.tolerance),
            },
        )


#: Relative difference at which a load counts as equal to the bound: means of equal numbers differ by
#: rounding.
_SLACK = 1e-12


def _checked_bound(bound: float | Array | None, surface: HeightField) -> Array | None:
    if bound is None:
        return None
    values = np.asarray(bound, dtype=float)
    if values.ndim > 0 and values.shape != surface.shape:
        raise InvalidInput(
            f"pressure_bound of shape {values.shape}: must be one pressure or of shape {surface.shape}"
        )
    if not (np.all(values > 0) and np.all(np.isfinite(values))):
        raise InvalidInput("pressure_bound: must be positive and finite everywhere, in Pa")
    return np.array(np.broadcast_to(values, surface.shape))


class _LoadSearch:
    """The load at which the mean gap, or the offset, has a prescribed value."""

    #: Evaluations allowed; a bracket is halved at worst, so they suffice for any smooth fall.
    limit = 60

    def __init__(self, problem: _Problem, *, target: float, of_gap: bool) -> None:
        heights = problem.surface.heights
        self.problem, self.target, self.of_gap = problem, target, of_gap
        self.scale = problem.surface.rms_height
        # Distances are counted from the position where the mean planes coincide.
        self.gap = target if of_gap else target - float(np.mean(heights))
        self.clearance = float(np.max(heights) - np.mean(heights))
        if not np.isfinite(target):
            raise InvalidInput(
                f"{'mean_gap' if of_gap else 'offset'} = {target!r}: must be a finite length in m"
            )
        sinks = not of_gap and problem.operator.compliance[0, 0] > 0
        if self.gap < -_SLACK * self.scale and problem.bound is None and not sinks:
            raise InvalidInput(
                f"{'mean_gap' if of_gap else 'offset'} = {target!r}: asks for a negative mean gap; "
                "without a pressure bound it cannot fall below 0 (full contact)"
            )

    def run(self) -> Solution:
        problem = self.problem
        if self.gap >= self.clearance:
            return self._separated()
        least_full = -float(np.min(problem.full_pressure()))
        if problem.bound is None:
            closed = self._closed(least_full)
            if closed is not None:
                return closed
        upper = least_full if problem.bound is None else float(np.mean(problem.bound))
        return self._search(upper)

    def _separated(self) -> Solution:
        solution = self.problem.solution(np.zeros(self.problem.surface.shape), pairs=1.0)
        nowhere = np.zeros(solution.force.shape, dtype=bool)
        offset = (
            self.target if not self.of_gap else self.target + float(np.mean(self.problem.surface.heights))
        )
        return replace(solution, in_contact=nowhere, offset=offset)

    def _closed(self, least: float) -> Solution | None:
        """Full contact, if the target lies there."""
        mean_compliance = float(self.problem.operator.compliance[0, 0])
        sunk = 0.0 if self.of_gap else mean_compliance * least
        if self.gap > _SLACK * self.scale - sunk:
            return None
        load = least if sunk == 0 else -self.gap / mean_compliance
        return self.problem.solution(self.problem.full_pressure() + load, pairs=2.0)

    def _search(self, upper: float) -> Solution:
        """Secant steps in the logarithm of the load, kept inside a shrinking bracket."""
        problem, modulus = self.problem, self.problem.response.contact_modulus
        gradient = problem.surface.rms_gradient
        # At light load the mean gap falls with the logarithm of the load, by about 0.45 h_rms.
        slope = -0.45 * self.scale
        low, high = 0.0, upper
        load = min(0.4 * modulus * gradient * float(np.exp(self.gap / slope)), 0.5 * upper)
        start: Array | None = None
        pairs, iterations = 0.0, 0
        miss, previous = np.inf, (0.0, 0.0)
        for count in range(self.limit):
            loose = max(problem.tolerance, min(1e-3, 0.02 * abs(miss) / self.scale))
            solution = problem.at(load, start=start, tolerance=loose)
            pairs, iterations = pairs + solution.fft_pairs, iterations + solution.iterations
            solution = replace(solution, fft_pairs=pairs, iterations=iterations)
            start, miss = solution.force, self._value(solution) - self.target
            settled = loose <= problem.tolerance and abs(miss) <= 10 * problem.tolerance * self.scale
            if settled or solution.status is not Status.CONVERGED:
                return solution
            # A miss within the error of its solve has no sign, and would cut the answer off the bracket.
            if abs(miss) > 10 * loose * self.scale:
                low, high = (load, high) if miss > 0 else (low, load)
            if count and load != previous[0] and miss != previous[1]:
                slope = (miss - previous[1]) / float(np.log(load / previous[0]))
            previous = (load, miss)
            guess = load * float(np.exp(np.clip(-miss / slope, -2.0, 2.0))) if slope < 0 else low
            load = guess if low < guess < high else (0.5 * (low + high) if low > 0 else 0.1 * high)
        return replace(solution, status=Status.STAGNATED)

    def _value(self, solution: Solution) -> float:
        if not self.of_gap:
            return solution.offset
        return float(np.mean(solution.displacement) - np.mean(self.problem.surface.heights)) + solution.offset
