"""Preconditioned conjugate gradients under bounds, on one grid and from coarse to fine grids."""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from fem_contact._types import Array, Shape
from fem_contact.complementarity.arrays import ArrayOperator, PlainIterationArrays
from fem_contact.complementarity.fourier import FourierOperator
from fem_contact.complementarity.grids import Grids
from fem_contact.complementarity.in_slabs import SlabIterationArrays, SlabOperator
from fem_contact.complementarity.iteration_arrays import Errors, IterationArrays
from fem_contact.complementarity.operator import Operator, Solution
from fem_contact.contact import Status
from fem_contact.settings import Settings


def solve_bounded(
    operator: Operator,
    heights: Array,
    *,
    mean_force: float,
    length_scale: float,
    settings: Settings,
    start: Array | None = None,
    bound: Array | None = None,
    draft: bool = False,
    single: bool = False,
) -> Solution:
    """Find 0 <= x <= bound of a given mean with a gap g = A x - h + shift that is 0 where x lies between.

    Where x = 0 it is open, at the bound it may be closed further. Preconditioned conjugate gradients, two
    operator applications per step.

    Parameters
    ----------
    operator : Operator
        A [m/Pa], the response of the solid to pressures at the nodes.
    heights : (nx, ny) array
        h [m] of the rigid body at the nodes, on a periodic lattice.
    mean_force : float
        Prescribed mean of x [Pa], positive.
    length_scale : float
        Length [m] in which the residuals are measured.
    settings : Settings
        Stop at sum x |g| <= tolerance * length_scale * sum x and penetration <= 10 tolerance * length_scale,
        both over points below the bound (sum x not below a tenth of the load), and no opening above that at
        points on the bound. The threads share the passes over the arrays.
    start : (nx, ny) array, optional
        Forces [Pa] to start from, scaled to the load here; uniform if not given.
    bound : (nx, ny) array, optional
        Upper bound of x [Pa]; its mean must exceed `mean_force`.
    draft : bool
        Return the first forces that meet the tolerance, not settled and not applied afresh, or those at which
        the residual stops falling: they only start another solve.
    single : bool
        Compute steps, their images and the gap in single precision, where its range holds the problem. The
        gap is computed afresh in double precision on the way and at the end, where it is judged.

    Notes
    -----
    Each step builds a direction from the preconditioned residual on the working set and the last step, clips
    the trial force to its bounds, applies the response to the difference, and searches the exact minimum
    along it within the bounds. Clipping before the response is applied is what saves the third application of
    projected methods, and keeps every iterate feasible and the energy falling.

    The residual is extended beyond the contact before the inverse response acts on it, by averages over ever
    coarser cells that decay with the distance. Cut off at the edge it would have a jump there, to which the
    inverse (a half derivative) answers with a logarithm of the resolution; extended, the number of steps
    hardly depends on the grid.
    """
    if isinstance(operator, ArrayOperator):
        arrays: IterationArrays = PlainIterationArrays(operator, heights, bound=bound, caution=_CAUTION)
    else:
        options: dict[str, Any] = {"bound": bound, "caution": _CAUTION, "threads": settings.workers}
        if single and isinstance(operator, FourierOperator) and length_scale > 0:
            least, most = (mean_force / length_scale * size for size in operator.extremes)
            if np.finfo(np.float32).tiny * 1e6 < least and most < np.finfo(np.float32).max * 1e-6:
                options["units"] = mean_force, length_scale  # arrays in these are of single precision
        if isinstance(operator, SlabOperator):
            arrays = SlabIterationArrays(operator, heights, **options)
        else:
            arrays = IterationArrays(operator, heights, **options)
    _set_start(arrays, start, mean_force)
    del start  # frees an array for the iteration
    return _iterate(arrays, mean_force=mean_force, length_scale=length_scale, settings=settings, draft=draft)


#: Trial length of the first step, and the range it may move in; the preconditioner is scaled like the inverse
#: response.
_FIRST, _LEAST, _GREATEST = 0.5, 0.1, 3.0
#: A loaded point is let go when its force is below this share of (grid-scale stiffness x its gap). Left to
#: the line search, points with little force and an open gap block the direction, which then need not be one
#: of descent.
_CAUTION = 0.1
#: Share of the load between its bounds that is taken for rounding.
_VANISHING = 3e-11
#: Share of the load that the points below their bound are counted to bear at least: what rounding leaves them
#: cannot be balanced.
_BELOW = 0.1
#: Steps without a new least error after which the iteration is said to stagnate.
_PATIENCE = 60
#: The same for a draft, whose precision may not reach its tolerance.
_DRAFT_PATIENCE = 4


#: Fall of the error after which the gap is computed afresh in double precision, where steps are single.
_AFRESH = 1e-3


def _iterate(
    arrays: IterationArrays, *, mean_force: float, length_scale: float, settings: Settings, draft: bool
) -> Solution:
    began, tolerance = time.monotonic(), settings.tolerance * length_scale / arrays.length_unit
    enough = _DRAFT_PATIENCE if draft else _PATIENCE
    load = mean_force / arrays.force_unit * arrays.count
    # Where all that bear have yielded but for rounding, the points between say nothing of the offset.
    vanishing = 0.0 if arrays.bound is None else _VANISHING * load
    offset, errors = _afresh(arrays, vanishing, roughly=True)
    applications, preconditions, iteration, length, curvature = 1, 0, 0, _FIRST, 0.0
    least, patience, status, renewed = np.inf, enough, Status.ITERATION_LIMIT, errors.size
    exact, verified, plain = not arrays.single, draft, False
    while True:
        if errors.within(tolerance, least=_BELOW * load):
            if verified:
                status = Status.CONVERGED
                break
            # Forces that were on their way out are taken away, and the displacement, so far carried along by
            # additions, is computed afresh: the answer is judged by what is returned.
            _settle(arrays, mean_force)
            offset, errors = _afresh(arrays, vanishing)
            applications, verified, exact, renewed = applications + 1, True, True, errors.size
            continue
        if arrays.single and not draft and errors.size < _AFRESH * renewed:
            offset, errors = _afresh(arrays, vanishing)
            applications, exact, renewed = applications + 1, True, errors.size
        patience = enough if errors.size < 0.9 * least else patience - 1
        least = min(least, errors.size)
        if patience == 0:
            status = Status.STAGNATED
            break
        if iteration == settings.max_iterations:
            break
        if settings.expired(began):
            status = Status.TIME_LIMIT
            break
        iteration += 1
        if plain:
            arrays.project(load)
        else:
            z_sum, z_image = arrays.precondition()
            free, beta = errors.free, 0.0
            if curvature > 0 and free > 0:
                beta = max(0.0, -(z_image - z_sum / free * errors.image) / curvature)
            shift = (z_sum + beta * errors.last) / free if free > 0 else 0.0
            arrays.trial(load, length=length, beta=beta, shift=shift)
        curvature = arrays.bend()
        applications, preconditions = applications + 1, preconditions + (not plain)
        verified, exact = draft, False
        best = -arrays.slope / curvature if curvature > 0 else 0.0
        # The trial force keeps the bounds: a single step does.
        room = arrays.room() if best > 1 else 1.0
        factor = min(best, room)
        plain = best <= 0
        if plain:
            # Clipping has turned the direction uphill: the plain projected gradient points down.
            curvature, errors = 0.0, arrays.move(0.0, 0.0)
            continue
        total, moment = arrays.advance(factor)
        if total > vanishing:
            # phi . g = 0: the offset is the gap below the load, so that scaling phi is no descent.
            errors = arrays.move(factor, -moment / total)
            offset -= moment / total
        elif arrays.bound is None:
            # At vanishing load a step may round every force away: the closest point carries it.
            arrays.move(factor, 0.0)
            _settle(arrays, mean_force)
            offset, errors = _afresh(arrays, vanishing)
            applications, curvature = applications + 1, 0.0
        else:
            arrays.move(factor, 0.0)
            between = _offset_between(arrays)
            errors = arrays.move(0.0, between)
            offset += between
        length = min(max(length * (best if best <= room else 0.9 * best), _LEAST), _GREATEST)
    if not (draft or exact):
        offset, errors = _afresh(arrays, vanishing)
        applications += 1
    pairs = applications * arrays.operator.pairs + preconditions
    return _solution(arrays, offset=offset, status=status, iterations=iteration, pairs=pairs)


def _afresh(arrays: IterationArrays, vanishing: float, *, roughly: bool = False) -> tuple[float, Errors]:
    """Apply the response afresh; the offset and the errors there."""
    total, moment = arrays.start(roughly=roughly)
    if total > vanishing:
        return -moment / total, arrays.place(-moment / total)
    arrays.place(0.0)
    offset = _offset_between(arrays)
    return offset, arrays.move(0.0, offset)


def _set_start(arrays: IterationArrays, start: Array | None, mean_force: float) -> None:
    xp, force, bound = arrays.xp, arrays.force, arrays.bound
    if start is not None:
        if isinstance(force, np.ndarray):
            np.maximum(start, 0.0, out=force)
        else:
            force[...] = xp.where(start > 0, start, xp.zeros_like(start))
    mean = 0.0 if start is None else float(xp.mean(force))
    if mean > 0:
        force *= mean_force / mean
    else:
        # Nor is a coarse solve of which nothing is left a start.
        force[...] = mean_force
    if bound is not None:
        force[...] = xp.where(force < bound, force, bound)
        _restore_load(arrays, mean_force)


def _settle(arrays: IterationArrays, mean_force: float) -> None:
    """Leave no force off the working set but at the bound."""
    xp, force, bound = arrays.xp, arrays.force, arrays.bound
    if bound is None:
        force[~arrays.working] = 0
        if not float(xp.mean(force)) > 0:
            # At vanishing load the gap's rounding may leave no point in the set: the closest one carries it.
            force[arrays.gap <= xp.min(arrays.gap)] = mean_force
        force *= mean_force / float(xp.mean(force))
    else:
        at_rest = xp.where(force < 0.5 * bound, xp.zeros_like(bound), bound)
        force[...] = xp.where(arrays.working, force, at_rest)
        _restore_load(arrays, mean_force)


def _restore_load(arrays: IterationArrays, mean_force: float) -> None:
    """Bring the mean back by moving points between their bounds, or all where need be, towards one."""
    xp, force, bound = arrays.xp, arrays.force, arrays.bound
    for points in ((force > 0) & (force < bound), force >= 0):
        missing = (mean_force - float(xp.mean(force))) * arrays.count
        if abs(missing) <= 1e-13 * mean_force * arrays.count:
            return
        room = xp.where(points, bound - force if missing > 0 else force, xp.zeros_like(force))
        total = float(xp.sum(room))
        if total > 0:
            force += math.copysign(min(abs(missing) / total, 1.0), missing) * room


def _offset_between(arrays: IterationArrays) -> float:
    """Change of offset where every loaded point is at its bound and none lies between.

    Any offset that opens no loaded point and closes no other is right; the one of least indentation is meant.
    Short of the solution there is none, and the middle leaves both kinds of points something to do.
    """
    xp, level = arrays.xp, arrays.gap
    # Forces of the size of rounding are none.
    loaded = arrays.force > (0.0 if arrays.bound is None else 1e-14 * arrays.bound)
    endless = xp.zeros_like(level) + math.inf
    highest = float(xp.max(xp.where(loaded, level, -endless)))
    lowest = float(xp.min(xp.where(loaded, endless, level)))
    return -highest if lowest >= highest else -0.5 * (lowest + highest)


def _solution(
    arrays: IterationArrays, *, offset: float, status: Status, iterations: int, pairs: float
) -> Solution:
    force, bound, held = arrays.force, arrays.bound, arrays.nbytes
    # Done with: what is returned may have their room.
    del arrays.step, arrays.image
    return Solution(
        force=force,
        displacement=arrays.displacement,
        offset=offset * arrays.length_unit,
        in_contact=force > 0,
        at_bound=force < 0 if bound is None else force >= bound,
        status=status,
        iterations=iterations,
        fft_pairs=pairs,
        peak_bytes=held,
    )


def solve_nested(
    operator: Operator,
    heights: Array,
    *,
    coarse: Callable[[tuple[int, int]], Operator],
    mean_force: float,
    length_scale: float,
    settings: Settings,
    start: Array | None = None,
    bound: Array | None = None,
    weights: Array | None = None,
    double: bool = False,
    grids: Grids | None = None,
) -> Solution:
    """Solve from coarse to fine: each grid starts from the interpolated forces of the one before.

    Parameters
    ----------
    coarse : callable
        Operator of a coarser grid of given shape, whose nodes are all alike; its accuracy only matters for
        speed.
    start : (nx, ny) array, optional
        Forces [Pa] to start from; the coarser grids are then left out.
    weights : (nx, ny) array, optional
        Weights of the nodes of the finest grid, where they differ.
    double : bool
        No single precision anywhere.
    grids : Grids, optional
        Where the arrays of the grids are; NumPy's, as a whole, if not given.
    operator, heights, mean_force, length_scale, settings, bound
        As in `solve_bounded`. Coarse grids are solved to `_COARSE` at best; the time is for all grids.

    Notes
    -----
    The heights of a coarse grid are freed of the waves it cannot carry. `Solution.fft_pairs` counts the pairs
    of all grids, each by its share of points.
    """
    given, pairs, began = start is not None, 0.0, time.monotonic()
    grids = grids or Grids((heights.shape[0], heights.shape[1]), threads=settings.workers)
    finest, size = grids.shape, math.prod(grids.shape)
    coarsely = replace(settings, tolerance=max(settings.tolerance, _COARSE))
    levels, shapes = [heights], [finest]
    while not given and max(shapes[-1]) > _COARSEST:
        nx, ny = (n if n <= _COARSEST // 2 else -(-n // 2) for n in shapes[-1])
        levels.append(grids.coarsened(levels[-1], shapes[-1], (nx, ny)))
        shapes.append((nx, ny))
    previous = finest
    while len(levels) > 1:
        smooth, shape = levels.pop(), shapes.pop()
        solution = solve_bounded(
            coarse(shape),
            smooth,
            mean_force=mean_force,
            length_scale=length_scale,
            settings=coarsely.remaining(began),
            start=None if start is None else grids.refined(start, previous, shape),
            bound=None
            if bound is None
            else grids.nearest(bound if weights is None else bound / weights, shape),
            draft=True,
            single=not double and _in_single(shape),
        )
        start, previous = solution.force, shape
        pairs += solution.fft_pairs * math.prod(shape) / size
        del solution
    if start is not None and not given:
        start = grids.refined(start, previous, finest)
        start = start if weights is None else start * weights
    # Handed over, not kept: it is as large as any array of the iteration.
    handed, start = [start], None
    single = not double and _in_single(finest)
    while True:
        solution = solve_bounded(
            operator,
            heights,
            mean_force=mean_force,
            length_scale=length_scale,
            settings=settings.remaining(began),
            start=handed.pop(),
            bound=bound,
            single=single,
        )
        pairs += solution.fft_pairs
        if not (solution.status is Status.STAGNATED and single):
            return replace(solution, fft_pairs=pairs)
        # Next to a bound that leaves hardly a choice the digits of a step may be too few.
        handed, single = [solution.force], False


def surely_partial(
    heights: Any, *, coarse: Callable[[tuple[int, int]], Any], mean_force: float, xp: Any = np
) -> bool:
    """Whether even averages of the heights over cells need tension to be touched everywhere.

    A rougher surface needs more of it. Where that should ever be wrong full contact is iterated.
    """
    (nx, ny), part = heights.shape, _AVERAGED
    if min(nx, ny) < 8 * part or nx % part or ny % part:
        return False
    smooth = xp.mean(xp.reshape(heights, (nx, ny // part, part)), axis=2)
    smooth = xp.mean(xp.reshape(smooth, (nx // part, part, ny // part)), axis=1)
    operator, force = coarse((nx // part, ny // part)), xp.empty_like(smooth)
    if not isinstance(operator, (ArrayOperator, FourierOperator)):
        return False
    operator.invert(smooth, force)
    return float(xp.min(force)) < -mean_force


#: Points along each side of a cell whose heights are averaged to rule out full contact.
_AVERAGED = 8
#: Grids with fewer points are solved in double precision.
_SINGLE = 256**2
#: Tolerance of the coarse grids: their answer is off by the discretisation anyway.
_COARSE = 1e-2
#: Grids are halved down to this number of points.
_COARSEST = 32


def _in_single(shape: Shape) -> bool:
    """Whether a grid has enough points for single precision to pay.

    >>> [_in_single(shape) for shape in ((256, 255), (256, 256), (128, 1024))]
    [False, True, True]
    """
    return math.prod(shape) >= _SINGLE
