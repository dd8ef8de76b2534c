"""Contact at a prescribed mean gap or offset: the load is sought that makes it."""

import time
from dataclasses import replace

import numpy as np

from fem_contact._types import Array
from fem_contact.bem.problem import Problem
from fem_contact.complementarity import Solution
from fem_contact.complementarity.direct import SLACK, applied
from fem_contact.contact import Status
from fem_contact.errors import InvalidInput

#: Relative width of a bracket in which no load is left to be tried.
_JUMP = 1e-12
#: Relative width of a bracket below which each solve is as accurate as the answer.
_NARROW = 1e-4


class LoadSearch:
    """The load at which the mean gap, or the offset, has a prescribed value."""

    #: Evaluations allowed; a bracket is halved at worst, so they suffice for any smooth fall.
    limit = 200

    def __init__(self, problem: Problem, *, target: float, of_gap: bool) -> None:
        heights = problem.heights
        target = target if of_gap else target - problem.level
        self.problem, self.target, self.of_gap = problem, target, of_gap
        self.scale = problem.surface.rms_height
        # Distances are counted from the position where the mean planes coincide.
        self.gap = target if of_gap else target - float(np.mean(heights))
        self.clearance = float(np.max(heights) - np.mean(heights))
        sinks = not of_gap and problem.operator.compliance[0, 0] > 0
        if self.gap < -SLACK * self.scale and problem.bound is None and not sinks:
            given = target if of_gap else target + problem.level
            raise InvalidInput(
                f"{'mean_gap' if of_gap else 'offset'} = {given:.6g} m: asks for a negative mean gap; "
                "without a pressure bound it cannot fall below 0 (full contact)"
            )

    def run(self) -> Solution:
        """Find the solution whose gap or offset is the prescribed one."""
        problem = self.problem
        if self.gap >= self.clearance:
            solution = applied(problem.operator, problem.heights, np.zeros(problem.surface.shape), pairs=1.0)
            nowhere = np.zeros(solution.force.shape, dtype=bool)
            offset = self.target + (float(np.mean(problem.heights)) if self.of_gap else 0.0)
            return replace(solution, in_contact=nowhere, offset=offset)
        least_full = -float(np.min(problem.full_pressure()))
        closed = self._closed(least_full)
        if closed is not None:
            return closed
        if self.scale <= 8 * np.finfo(float).eps * float(np.max(np.abs(problem.heights))):
            raise InvalidInput("a flat surface yields everywhere at once: prescribe a mean pressure instead")
        if problem.bound is None:
            return self._search(least_full)
        upper = float(np.mean(problem.bound))
        # Where all has yielded the body sinks as far as it is pushed.
        yielded = problem.at(upper)
        return self._moved(yielded) if self._value(yielded) >= self.target else self._search(upper)

    def _closed(self, least: float) -> Solution | None:
        """Full contact, if the target lies there."""
        mean_compliance = float(self.problem.operator.compliance[0, 0])
        sunk = 0.0 if self.of_gap else mean_compliance * least
        if self.gap > SLACK * self.scale - sunk:
            return None
        held = self.of_gap or mean_compliance == 0
        if held and self.gap < -SLACK * self.scale:
            # Points that touch without yielding sink no further: some must yield.
            return None
        load = least if held else -self.gap / mean_compliance
        force, bound = self.problem.full_pressure() + load, self.problem.bound
        if bound is not None and np.any(force > bound):
            return None
        return applied(self.problem.operator, self.problem.heights, force, pairs=2.0)

    def _search(self, upper: float) -> Solution:
        """Secant steps in the logarithm of the load, inside a shrinking bracket from 0 to `upper` [Pa].

        There all points touch, or yield. A positive `miss` is too small a load.
        """
        problem, modulus = self.problem, self.problem.response.contact_modulus
        tolerance = problem.settings.tolerance
        gradient = problem.surface.rms_gradient
        # At light load the mean gap falls with the logarithm of the load, by about 0.45 h_rms.
        slope = -0.45 * self.scale
        low, high, best, mark = 0.0, upper, np.inf, np.inf
        growth = float(np.exp(np.clip(self.gap / slope, -100.0, 100.0)))
        load = min(0.4 * modulus * gradient * growth, 0.5 * upper)
        # A flat surface has no gradient to guess from.
        load = load if load > 0 else 0.5 * upper
        start: Array | None = None
        pairs, iterations, loosest = 0.0, 0, 1e-3
        miss, previous, began = np.inf, (0.0, 0.0), time.monotonic()
        for count in range(self.limit):
            loose = max(tolerance, min(loosest, 0.02 * abs(miss) / self.scale))
            settings = replace(problem.settings.remaining(began), tolerance=loose)
            solution = problem.at(load, start=start, settings=settings)
            pairs, iterations = pairs + solution.fft_pairs, iterations + solution.iterations
            solution = replace(solution, fft_pairs=pairs, iterations=iterations)
            start, miss = solution.force, self._value(solution) - self.target
            best = min(best, abs(miss))
            settled = loose <= tolerance and abs(miss) <= 10 * tolerance * self.scale
            if settled or solution.status is not Status.CONVERGED:
                return solution
            # A miss within the error of its solve has no sign, and would cut the answer off the bracket.
            if abs(miss) > 10 * loose * self.scale:
                low, high = (load, high) if miss > 0 else (low, load)
            if count and load != previous[0] and miss != previous[1]:
                slope = (miss - previous[1]) / float(np.log(load / previous[0]))
            previous = (load, miss)
            guess = load * float(np.exp(np.clip(-miss / slope, -2.0, 2.0))) if slope < 0 else low
            if loosest > tolerance and high - low <= _NARROW * high:
                # Offsets are off by the root of the tolerance at worst: a rough solve may have cut wrong.
                loosest, low, high = tolerance, 0.0, upper
            elif high - low > _JUMP * high:
                # Where the fall has a corner secants creep along it from either side.
                creeps = count % 4 == 3 and best > 0.5 * mark
                mark = best if count % 4 == 3 else mark
                middle = 0.5 * (low + high) if low > 0 else 0.1 * high
                load = guess if low < guess < high and not creeps else middle
            elif miss < 0 or load > high:
                # All that touch have yielded: a range of offsets balances this load. On the heavy side of it
                # the next point to touch bears next to nothing.
                return self._moved(solution)
            else:
                load = high * (1 + 10 * _JUMP)
        return replace(solution, status=Status.STAGNATED)

    def _moved(self, solution: Solution) -> Solution:
        """Return a solution at the prescribed distance; its residuals, measured later, are the judge."""
        return replace(solution, offset=solution.offset - self._value(solution) + self.target)

    def _value(self, solution: Solution) -> float:
        if not self.of_gap:
            return solution.offset
        return float(np.mean(solution.displacement) - np.mean(self.problem.heights)) + solution.offset
