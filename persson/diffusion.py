r"""The stress distribution under partial contact: diffusion between moving walls (Persson 2006, Eq. 17).

With the variance V of the stress at full contact as the running variable the equation is

.. math:: \frac{\partial P}{\partial V} = \frac12 \frac{\partial^2 P}{\partial\sigma^2},
          \qquad -\sigma_a(V) < \sigma < \sigma_Y(V), \qquad P(\sigma, 0) = \delta(\sigma - \sigma_0)

and f(zeta) drops out: only where along V the walls stand matters. Area that reaches the lower wall detaches,
area that reaches the upper one yields. Everything is integrated in ln V on a window that follows the walls,
or the tails of the distribution where these are nearer, so decades of magnification cost nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike

from persson._checks import Array, in_proportion, non_negative, numbers_of, real, scalar, whole, within
from persson._window import TAIL, Grid, Pieces, Problem, distance, find_pieces, make_grid
from persson._window import Wall as Wall
from persson.errors import InvalidInput, NotConverged

#: Largest steps in ln V and numbers of basis functions tried in turn until the ledger closes.
_LEVELS = ((0.2, 48), (0.1, 56), (0.05, 80), (0.025, 120), (0.012, 180))
#: Beginning of a step and the abscissae of the stages of `persson._galerkin`.
_STAGES = np.array([0.0, 0.25, 0.75, 0.55, 0.5, 1.0])


@dataclass(frozen=True, kw_only=True)
class Diffusion:
    """Areas, loads and stress distributions against the variance of the full-contact stress.

    Attributes
    ----------
    variance : (n,) array
        V [Pa^2], as asked for.
    pressure : float
        sigma_0 [Pa].
    area_elastic, area_plastic, area_detached : (n,) arrays
        Parts of the nominal area: in elastic contact, yielded, lost from contact.
    load_elastic : (n,) array
        Integral of sigma P [Pa]: the load the elastic contact carries per nominal area.
    mean_square : (n,) array
        Integral of (sigma - sigma_0)^2 P [Pa^2], Persson 2006, Eq. 48.
    tensile_limit, yield_stress : (n,) arrays
        The walls [Pa] at these V; infinite where there is none.
    area_residual, load_residual : (n,) arrays
        Failure of the books to balance, relative: |areas - 1|, and the missing load over the loads exchanged.
    error_estimate : float
        Estimate of the error of the areas relative to the contact area: from the result with steps twice as
        long, or twice the largest residual of the ledger where that is larger.
    tolerance : float
        What was asked for.
    modes, steps : int
        Basis functions and steps of the accepted discretisation.
    """

    variance: Array
    pressure: float
    area_elastic: Array
    area_plastic: Array
    area_detached: Array
    load_elastic: Array
    mean_square: Array
    tensile_limit: Array
    yield_stress: Array
    area_residual: Array
    load_residual: Array
    error_estimate: float
    tolerance: float
    modes: int
    steps: int
    _windows: Array
    _coefficients: Array

    @property
    def area(self) -> Array:
        """Area in contact, elastic and plastic, over the nominal area."""
        return self.area_elastic + self.area_plastic

    def checked(self) -> Diffusion:
        """Return this result if its error estimate meets the tolerance.

        Raises
        ------
        NotConverged
            Otherwise, with the residual.
        """
        if not self.error_estimate <= self.tolerance:
            raise NotConverged(
                f"the ledger of area and load is uncertain by {self.error_estimate:.3g}, more than "
                f"{self.tolerance:.3g}: a wall jumps or oscillates faster than can be followed; "
                "name its jumps in `breaks` or allow a larger tolerance"
            )
        return self

    def distribution(self, index: int, stress: ArrayLike) -> Array:
        """P(sigma) [1/Pa] of elastic contact per nominal area at ``variance[index]``, for stresses [Pa]."""
        whole("index", index, least=-self.variance.size, most=self.variance.size - 1)
        sigma = real("stress", stress) - self.pressure
        left, right = self._windows[index]
        variance = self.variance[index]
        if np.isnan(left):
            if variance == 0:
                raise InvalidInput(
                    "variance = 0: the stress distribution is a delta function at the nominal pressure"
                )
            return np.asarray(np.exp(-0.5 * sigma * sigma / variance) / math.sqrt(2 * math.pi * variance))
        x = (2 * sigma - left - right) / (right - left)
        inside = np.abs(x) <= 1
        # From basis coefficients and, last, the height at the upper wall.
        row = self._coefficients[index]
        scaled = row[:-1] / np.sqrt(4 * np.arange(row.size - 1) + 6.0)
        series = np.zeros(row.size + 1)
        series[:-2] += scaled
        series[2:] -= scaled
        series[:2] += row[-1] / 2
        return np.where(inside, legendre.legval(np.where(inside, x, 0.0), series), 0.0)


def solve_diffusion(
    variance: ArrayLike,
    *,
    pressure: float,
    tensile_limit: Wall = 0.0,
    yield_stress: Wall = None,
    breaks: Sequence[float] = (),
    tolerance: float = 1e-6,
    modes: int | None = None,
    step: float | None = None,
) -> Diffusion:
    """Solve the diffusion equation for the stress distribution between given walls.

    Parameters
    ----------
    variance : (n,) array
        V [Pa^2] at which results are wanted, not negative, not decreasing.
    pressure : float
        Nominal pressure sigma_0 [Pa]; negative for tension.
    tensile_limit : float, callable or None
        sigma_a [Pa], the largest tensile stress, as a constant or as a function of V; 0 without adhesion;
        None for bodies that never detach.
    yield_stress : float, callable or None
        Hardness sigma_Y [Pa]; a function of V must not decrease, and the density at the wall then obeys
        Persson 2006, Eq. 34. None for no yielding.
    breaks : sequence of float
        V [Pa^2] where a wall has a kink, or the square-root onset of adhesion.
    tolerance : float
        Bound on the residuals of area and load, which estimate the relative error. The discretisation is
        refined until it is met.
    modes, step : int, float, optional
        Fix the number of basis functions and the largest step in ln V instead.

    Returns
    -------
    Diffusion
        Call `.checked()` on it before using it as a result.

    Raises
    ------
    InvalidInput
        For arguments outside their range.
    OutsideTheory
        Where the equations have no admissible solution: no load and no adhesion, tension beyond sigma_a,
        pressure beyond sigma_Y, or a hardness that falls with V.

    Notes
    -----
    Persson 2006, Eqs. 17, 19, 27-41. Legendre-Galerkin in stress, an L-stable fourth-order Runge-Kutta
    method in ln V; before the distribution reaches a wall it is the exact Gaussian.

    Examples
    --------
    >>> result = solve_diffusion([1.0, 4.0], pressure=1.0)
    >>> result.checked().area_elastic.round(5)
    array([0.68269, 0.38292])
    """
    outputs, problem = _checked(variance, pressure, tensile_limit, yield_stress)
    within("tolerance", tolerance, "(0, 1)")
    if modes is not None:
        whole("modes", modes, least=4, most=400)
    if step is not None:
        within("step", step, "[1e-4, 1]")
    kinks = np.array([scalar("breaks", kink, unit="Pa^2", power=2) for kink in numbers_of("breaks", breaks)])
    levels = _LEVELS if modes is None and step is None else ((step or 0.1, modes or 48),)
    with in_proportion():
        return _refined(problem, outputs, kinks, levels=levels, tolerance=tolerance)


def _refined(
    problem: Problem, outputs: Array, breaks: Array, *, levels: Sequence[tuple[float, int]], tolerance: float
) -> Diffusion:
    """Refine the discretisation until two of them agree and the ledger closes."""
    pieces = find_pieces(problem, outputs, breaks)
    probes = np.unique(np.linspace(0, outputs.size - 1, min(outputs.size, 8)).astype(int))
    longest, fewest = levels[0]
    coarse = _integrate(problem, outputs[probes], pieces, largest=2 * longest, modes=max(fewest - 8, 24))
    for largest, count in levels:
        result = _integrate(problem, outputs, pieces, largest=largest, modes=count)
        change = np.maximum(
            np.abs(result.area_elastic[probes] - coarse.area_elastic),
            np.abs(result.area_plastic[probes] - coarse.area_plastic),
        )
        contact = np.maximum(result.area[probes], 1e-300)
        residual = float(max(result.area_residual.max(), result.load_residual.max()))
        # The method is of order 4: halving the steps leaves 1/16 of the error; twice that is allowed for.
        estimate = max(2 * residual, float(np.max(change / contact)) / 8)
        result = replace(result, error_estimate=estimate, tolerance=tolerance)
        if estimate <= tolerance:
            break
        coarse = replace(
            result, area_elastic=result.area_elastic[probes], area_plastic=result.area_plastic[probes]
        )
    return result


def diffuse_once(
    variance: ArrayLike,
    *,
    pressure: float,
    tensile_limit: Wall,
    yield_stress: Wall,
    breaks: Sequence[float],
    modes: int,
    step: float,
) -> Diffusion:
    """Solve once on given steps, without error estimate, for iterations that refine the walls themselves."""
    outputs, problem = _checked(variance, pressure, tensile_limit, yield_stress)
    pieces = find_pieces(problem, outputs, np.asarray(breaks, dtype=float))
    return _integrate(problem, outputs, pieces, largest=step, modes=modes)


def _checked(
    variance: ArrayLike, pressure: float, tensile_limit: Wall, yield_stress: Wall
) -> tuple[Array, Problem]:
    outputs = np.atleast_1d(non_negative("variance", variance, power=2))
    if outputs.ndim != 1 or outputs.size == 0 or np.any(np.diff(outputs) < 0):
        raise InvalidInput("variance: must be a one-dimensional array of values that do not decrease")
    load = scalar("pressure", pressure)
    problem = Problem(
        pressure=load,
        below=distance(tensile_limit, load, 1.0, "tensile_limit"),
        above=distance(yield_stress, load, -1.0, "yield_stress"),
        hardening=callable(yield_stress),
    )
    return outputs, problem


def _integrate(problem: Problem, outputs: Array, pieces: Pieces, *, largest: float, modes: int) -> Diffusion:
    """Integrate once, in steps of at most `largest` in ln V, and book where area and load have gone.

    Outputs before `pieces.start` have met no wall: all is in contact, and their stress is Gaussian.
    """
    reference = pieces.reference
    with np.errstate(divide="ignore"):
        t_out = np.log(outputs / reference)
    moving = t_out > pieces.start
    grid = make_grid(problem, pieces, t_out[moving], largest)
    # By node: coefficients of the density times the squared width of the window, then area lost below, load
    # that it carried, area that leaked at the tail, area that has yielded.
    history = _run(problem, reference, grid, modes)
    where = np.searchsorted(np.append(pieces.start, grid.ends), t_out[moving] - 1e-12)
    count = outputs.size
    windows, coefficients = np.full((count, 2), np.nan), np.zeros((count, modes))
    ledger = np.zeros((count, 4))
    below, above = problem.below(outputs), problem.above(outputs)
    lift = _lift(problem, reference, t_out)
    elastic, first, second = np.ones(count), np.zeros(count), outputs.copy()
    height = np.zeros(count)
    if where.size:
        left, right, _, upper = problem.window(t_out[moving], reference)
        windows[moving] = np.stack([left, right], axis=1)
        coefficients[moving] = history[where, :modes] / ((right - left) ** 2)[:, None]
        ledger[moving] = history[where, modes:]
        height[moving] = np.where(upper, lift[moving] * ledger[moving, 3], 0.0)
        elastic[moving], first[moving], second[moving] = _window_moments(
            coefficients[moving], height[moving], left, right
        )
    lost, carried, leaked, plastic = ledger.T
    load_yielded = np.where(plastic != 0, plastic * np.where(np.isfinite(above), above, 0.0), 0.0)
    exchanged = np.abs(first) + np.abs(carried) + np.abs(load_yielded) + np.sqrt(np.abs(second * elastic))
    missing = np.abs(first + carried + load_yielded)
    return Diffusion(
        variance=outputs,
        pressure=problem.pressure,
        area_elastic=elastic,
        area_plastic=plastic,
        area_detached=lost,
        load_elastic=first + problem.pressure * elastic,
        mean_square=second,
        tensile_limit=below - problem.pressure,
        yield_stress=above + problem.pressure,
        area_residual=np.abs(elastic + lost + plastic + leaked - 1),
        load_residual=missing / np.where(exchanged > 0, exchanged, np.inf),
        error_estimate=math.nan,
        tolerance=math.nan,
        modes=modes,
        steps=grid.steps.size,
        _windows=windows,
        _coefficients=np.concatenate([coefficients, height[:, None]], axis=1),
    )


def _run(problem: Problem, reference: float, grid: Grid, modes: int) -> Array:
    """Sample the walls at the stages and hand over to the compiled kernel."""
    if grid.steps.size == 0:
        return np.empty((0, modes + 4))
    from persson import _galerkin

    s = grid.first[:, None] + _STAGES * grid.steps[:, None]
    t = grid.time(s)
    variance = reference * np.exp(t)
    left, right, lower, upper = problem.window(t, reference)
    # One edge is either wall or tail over a whole step: the state in its middle decides, rounding at the ends
    # does not.
    tail = TAIL * np.sqrt(variance)
    walls = [np.broadcast_to(side[:, 3:4], t.shape) for side in (lower, upper)]
    left = np.where(walls[0], -problem.below(variance), -tail)
    right = np.where(walls[1], problem.above(variance), tail)
    derivative = _differentiation(_STAGES).T
    left_rate, right_rate = (edge @ derivative / grid.steps[:, None] for edge in (left, right))
    t_rate = np.where(grid.rooted[:, None], 2 * s, 1.0)
    tail_rate = 0.5 * tail * t_rate
    left_rate = np.where(walls[0], left_rate, -tail_rate)
    right_rate = np.where(walls[1], right_rate, tail_rate)
    diffusion = variance * t_rate
    upper_wall = np.zeros((grid.steps.size, 6))
    upper_wall[:, 0] = walls[1][:, 0]
    if problem.hardening:
        with np.errstate(divide="ignore", invalid="ignore"):
            rise = np.where(walls[1], 2 * right_rate / diffusion, 0.0)[:, 1:]
        # Rounding of a constant hardness must not make the density at the wall negative.
        upper_wall[:, 1:] = np.where(rise > 0, rise, 0.0)
    edges = np.ascontiguousarray(np.stack([left, right, left_rate, right_rate])[:, :, 1:])
    first = float(left[0, 0]), float(right[0, 0]), float(variance[0, 0])
    tables = _galerkin.matrices(modes)
    start = _gaussian_coefficients(first, tables[0], tables[3]) * (first[1] - first[0]) ** 2
    history = np.empty((grid.steps.size + 1, modes + 4))
    diffusion = np.ascontiguousarray(diffusion[:, 1:])
    _galerkin.advance(grid.steps, edges, diffusion, upper_wall, start, tables, history)
    return history


def _lift(problem: Problem, reference: float, t: Array) -> Array:
    """2 dsigma_Y/dV [1/Pa], Eq. 34, at t = ln(V/reference), of shape (n,); 0 for a constant hardness.

    A one-sided difference from the past, since the hardness may have a kink ahead; 0 where V = 0.
    """
    if not problem.hardening:
        return np.zeros(t.shape)
    finite = np.where(np.isfinite(t), t, 0.0)
    back = 1e-3  # in ln V
    points = finite[:, None] + back * (_STAGES - 1)
    variance = reference * np.exp(points)
    slope = problem.above(variance) @ _differentiation(_STAGES)[-1] / back  # by ln V
    rise = np.maximum(2 * slope / variance[:, -1], 0.0)
    return np.where(np.isfinite(t), rise, 0.0)


def _differentiation(points: Array) -> Array:
    """Matrix that differentiates the polynomial through `points` at these points."""
    difference = points[:, None] - points[None, :]
    np.fill_diagonal(difference, 1.0)
    weight = 1 / difference.prod(axis=1)
    matrix: Array = weight[None, :] / weight[:, None] / difference
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return matrix


def _gaussian_coefficients(window: tuple[float, float, float], mass: Array, d: Array) -> Array:
    """L2 projection of the free Gaussian on the basis; `window` holds its edges and the variance."""
    (left, right, variance), modes = window, d.size
    # The integrand vanishes with all derivatives at both ends: the trapezoidal rule is exact to rounding.
    x = np.linspace(-1, 1, 8 * modes + 1)
    sigma = left + (right - left) * (1 + x) / 2
    density = np.exp(-0.5 * sigma * sigma / variance) / math.sqrt(2 * math.pi * variance)
    basis = legendre.legvander(x, modes + 1)
    phi = d * (basis[:, :-2] - basis[:, 2:])
    coupling = np.diag(mass[4, :-2], 2)
    return np.linalg.solve(np.diag(mass[2]) + coupling + coupling.T, phi.T @ density * (x[1] - x[0]))


def _window_moments(
    coefficients: Array, height: Array, left: Array, right: Array
) -> tuple[Array, Array, Array]:
    """Integrals of P, s P and s^2 P over the window, with s relative to the nominal pressure."""
    a0 = coefficients[:, 0] / math.sqrt(6) + height / 2
    a1 = coefficients[:, 1] / math.sqrt(10) + height / 2
    a2 = coefficients[:, 2] / math.sqrt(14) - coefficients[:, 0] / math.sqrt(6)
    half, middle = (right - left) / 2, (right + left) / 2
    i0, i1, i2 = 2 * a0, 2 * a1 / 3, 2 * a0 / 3 + 4 * a2 / 15
    mean = half * (middle * i0 + half * i1)
    square = half * (middle * middle * i0 + 2 * middle * half * i1 + half * half * i2)
    return half * i0, mean, square
