"""Compiled passes of the contact iteration: each reads and writes its arrays once, over a block of rows.

Every kernel works on rows ``lo`` to ``hi`` and releases the interpreter lock, so that a pool of threads can
share a pass; sums come back per block and are added in a fixed order, which makes results independent of the
number of threads. Kernels that fill or read a coarser level take its rows instead.

======== ============ ======= ===================================================================
letter   shape        unit    what
======== ============ ======= ===================================================================
x, bound (nx, ny)     Pa      force, double; its upper bound, or None: the branch is then not compiled
u, h     (nx, ny)     m       displacement and heights, double
g        (nx, ny)     length  gap, in the precision and units of the iteration
s, v     (nx, ny)     force,  the step and its image, likewise
                      length
z        (nx, ny)     force   preconditioned residual, likewise
work     (nx, ny)     uint8   working set: 1 for its points
unit                  1/Pa    one over the iteration's unit of force
======== ============ ======= ===================================================================

Loops run over whole rows, without a branch that is not a choice between two values, and least values are
kept column by column: what is left is vectorised, and twice as fast as loops over points in contact alone.
Sums over a row are of the precision of the iteration, sums of rows are double.

Numba is imported with this module, so this module is imported by the solver only when it runs.
"""

# Types are numba's business here.
# mypy: disallow-untyped-defs=False

import numpy as np
from numba import njit

_OPTIONS = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": {"reassoc", "contract", "nsz"}}
#: Weight of each of the occupied cells in a cell of the next level, by their number: the mean where they fill
#: it. One or two are mostly the whole or the end of a contact, away from which the residual falls. The two
#: numbers are those of the fewest steps on rough surfaces.
PARTS = (0.0, 0.5, 0.46, 1 / 3, 1 / 4)


@njit(**_OPTIONS)
def weigh(lo, hi, x, u, h, bound, unit, per_u, per_h):
    """Sum phi and phi (u - h); phi, the weight of a point in the load, is x, or x (1 - x / bound)."""
    total = 0.0
    moment = 0.0
    for i in range(lo, hi):
        for j in range(x.shape[1]):
            phi = unit * x[i, j]
            if bound is not None:
                phi *= 1 - x[i, j] / bound[i, j]
            total += phi
            moment += phi * (per_u * u[i, j] - per_h * h[i, j])
    return total, moment


@njit(**_OPTIONS)
def place(lo, hi, g, u, h, per_u, per_h, offset):
    """Write the gap per_u u - per_h h + offset."""
    for i in range(lo, hi):
        for j in range(g.shape[1]):
            g[i, j] = per_u * u[i, j] - per_h * h[i, j] + offset
    return (0.0,)


@njit(**_OPTIONS)
def move(lo, hi, x, g, s, v, bound, factor, shift, unit, stiffness, work, sums, counts):
    """Move the gap by `factor` v + `shift`, find the working set there, and sum -g over cells of 2 x 2.

    A point leaves the working set where x - stiffness g reaches the bound that x is nearer to. Rows lo..hi
    are those of the coarser level. Returns sum x |g| and sum x below the bound, the least gap there, the
    greatest gap at the bound, and over the working set the sums of phi, s and phi v.
    """
    nx, ny = x.shape
    moment, total, free, last, image = 0.0, 0.0, 0.0, 0.0, 0.0
    zero, one = g.dtype.type(0), g.dtype.type(1)
    factor, shift, stiffness = g.dtype.type(factor), g.dtype.type(shift), g.dtype.type(stiffness)
    lows, highs = np.empty(ny, g.dtype), np.empty(ny, g.dtype)
    lowest, highest = g.dtype.type(np.inf), g.dtype.type(-np.inf)
    for j in range(ny):
        lows[j], highs[j] = lowest, highest
    for row in range(lo, hi):
        for i in range(2 * row, min(2 * row + 2, nx)):
            row_moment, row_total, row_free, row_last, row_image = zero, zero, zero, zero, zero
            for j in range(ny):
                gap = g[i, j] + factor * v[i, j] + shift
                g[i, j] = gap
                if bound is None:
                    lows[j] = min(lows[j], gap)
                else:
                    below = x[i, j] < bound[i, j]
                    lows[j] = min(lows[j], gap) if below else lows[j]
                    highs[j] = highs[j] if below else max(highs[j], gap)
            for j in range(ny):
                force, gap = g.dtype.type(unit * x[i, j]), g[i, j]
                weight, inside = force, force - stiffness * gap > zero
                if bound is not None:
                    top = g.dtype.type(unit * bound[i, j])
                    room = g.dtype.type(unit * (bound[i, j] - x[i, j]))
                    weight *= room / top
                    inside = inside if force < room else room + stiffness * gap > zero
                    force = force if x[i, j] < bound[i, j] else zero
                work[i, j] = inside
                held = one if inside else zero
                row_total += force
                row_moment += force * abs(gap)
                row_free += held * weight
                row_image += held * weight * v[i, j]
                row_last += held * s[i, j]
            moment += row_moment
            total += row_total
            free += row_free
            last += row_last
            image += row_image
        _sum_cells(row, g, -one, work, sums, counts)
    # Loops, because numba takes a second to compile `min` and `max` of an array.
    for j in range(ny):
        lowest, highest = min(lowest, lows[j]), max(highest, highs[j])
    return moment, total, lowest, highest, free, last, image


@njit(**_OPTIONS)
def _sum_cells(row, values, sign, occupied, sums, counts):
    """Sum occupied points, times a sign, over the cells of one row of the coarser level, and count them.

    The sign is of the precision of the values: a number as such is compiled apart, and takes a second each.
    """
    nx, ny = values.shape
    zero, near, far = values.dtype.type(0), 2 * row, min(2 * row + 1, nx - 1)
    # The last row of an odd number is alone in its cells.
    twice = np.uint8(far > near)
    for col in range(ny // 2):
        left, right = occupied[near, 2 * col] > 0, occupied[near, 2 * col + 1] > 0
        value = (values[near, 2 * col] if left else zero) + (values[near, 2 * col + 1] if right else zero)
        count = np.uint8(left) + np.uint8(right)
        left, right = occupied[far, 2 * col] > 0, occupied[far, 2 * col + 1] > 0
        other = (values[far, 2 * col] if left else zero) + (values[far, 2 * col + 1] if right else zero)
        sums[row, col] = sign * (value + (other if twice else zero))
        counts[row, col] = count + twice * (np.uint8(left) + np.uint8(right))
    if ny % 2:
        sums[row, ny // 2], counts[row, ny // 2] = zero, 0
        for i in range(near, near + 1 + twice):
            if occupied[i, ny - 1]:
                sums[row, ny // 2] += sign * values[i, ny - 1]
                counts[row, ny // 2] += 1


@njit(**_OPTIONS)
def pull(fine, counts, sums, coarse_counts):
    """Average the occupied cells of a level, in place, and sum them into the next coarser one."""
    nx, ny = fine.shape
    for row in range(sums.shape[0]):
        for i in range(2 * row, min(2 * row + 2, nx)):
            for j in range(ny):
                fine[i, j] *= PARTS[counts[i, j]]
        _sum_cells(row, fine, fine.dtype.type(1), counts, sums, coarse_counts)


@njit(**_OPTIONS)
def push(lo, hi, fine, occupied, coarse, values, sign):
    """Fill a level: occupied cells with values times a sign, others from the next coarser one, bilinear."""
    ny = fine.shape[1]
    mx, my = coarse.shape
    line, wide = np.empty(my + 2, coarse.dtype), np.empty(2 * my, coarse.dtype)
    near, far, sign = fine.dtype.type(0.75), fine.dtype.type(0.25), fine.dtype.type(sign)
    for i in range(lo, hi):
        parent = i // 2
        other = (parent + (1 if i % 2 else -1)) % mx
        for j in range(my):
            line[j + 1] = near * coarse[parent, j] + far * coarse[other, j]
        line[0] = line[my]
        line[my + 1] = line[1]
        for p in range(my):
            wide[2 * p] = near * line[p + 1] + far * line[p]
            wide[2 * p + 1] = near * line[p + 1] + far * line[p + 2]
        for j in range(ny):
            fine[i, j] = sign * values[i, j] if occupied[i, j] else wide[j]
    return (0.0,)


@njit(**_OPTIONS)
def push_transposed(lo, hi, fine, occupied, coarse):
    """Transpose of `push`: gather the empty cells of a level on rows lo..hi of the next coarser one."""
    nx, ny = fine.shape
    mx, my = coarse.shape
    line = np.empty(2 * my + 2, coarse.dtype)
    zero, close, far = fine.dtype.type(0), fine.dtype.type(0.75), fine.dtype.type(0.25)
    for row in range(lo, hi):
        for k in range(2 * my + 2):
            line[k] = zero
        above, below = 2 * ((row + 1) % mx), 2 * ((row - 1) % mx) + 1
        for i, weight in ((2 * row, close), (2 * row + 1, close), (above, far), (below, far)):
            if i < nx:
                for j in range(ny):
                    line[j + 1] += zero if occupied[i, j] else weight * fine[i, j]
        line[0] = line[2 * my]
        line[2 * my + 1] = line[1]
        for col in range(my):
            near = line[2 * col + 1] + line[2 * col + 2]
            coarse[row, col] = close * near + far * (line[2 * col] + line[2 * col + 3])


@njit(**_OPTIONS)
def pull_transposed(fine, counts, coarse):
    """Transpose of `pull` in place: occupied cells take up the coarser level, divided by their count."""
    for i in range(fine.shape[0]):
        for j in range(fine.shape[1]):
            fine[i, j] = (fine[i, j] + coarse[i // 2, j // 2]) * PARTS[counts[i, j]]


@njit(**_OPTIONS)
def finish(lo, hi, z, work, coarse, v):
    """Complete the preconditioned residual z in place; sum z and z v over the working set."""
    ny = z.shape[1]
    total, image, zero = 0.0, 0.0, z.dtype.type(0)
    for i in range(lo, hi):
        row_total, row_image = zero, zero
        for p in range(ny // 2):
            left = z[i, 2 * p] + coarse[i // 2, p] if work[i, 2 * p] else zero
            right = z[i, 2 * p + 1] + coarse[i // 2, p] if work[i, 2 * p + 1] else zero
            z[i, 2 * p] = left
            z[i, 2 * p + 1] = right
            row_total += left + right
            row_image += left * v[i, 2 * p] + right * v[i, 2 * p + 1]
        if ny % 2:
            left = z[i, ny - 1] + coarse[i // 2, ny // 2] if work[i, ny - 1] else zero
            z[i, ny - 1] = left
            row_total += left
            row_image += left * v[i, ny - 1]
        total += row_total
        image += row_image
    return total, image


@njit(**_OPTIONS)
def trial(lo, hi, x, z, s, work, bound, unit, step, beta, shift):
    """Write the step to the trial force clip(x + step (z + beta s - shift phi)) over s.

    Points off the working set go to the bound they have run into. Returns the sum of the trial force,
    and over points between their bounds the sums of what is left to the upper one and to the lower one.
    """
    total, above, below, least = 0.0, 0.0, 0.0, 2 * np.finfo(s.dtype).eps
    step = s.dtype.type(step)
    beta, shift = s.dtype.type(beta), s.dtype.type(shift)
    for i in range(lo, hi):
        row_total = 0.0
        for j in range(x.shape[1]):
            force = s.dtype.type(unit * x[i, j])
            if bound is None:
                change = max(step * (z[i, j] + beta * s[i, j] - shift * force), -force)
                change = change if work[i, j] else -force
            else:
                top = s.dtype.type(unit * bound[i, j])
                room = s.dtype.type(unit * (bound[i, j] - x[i, j]))
                phi = force * (room / top)
                change = max(step * (z[i, j] + beta * s[i, j] - shift * phi), -force)
                aside = -force if force < room else room
                change = min(change, room) if work[i, j] else aside
                if force + change > least * abs(change) and room - change > least * abs(change):
                    above += room - change
                    below += force + change
            row_total += unit * x[i, j] + change
            s[i, j] = change
        total += row_total
    return total, above, below


@njit(**_OPTIONS)
def restore(lo, hi, x, g, s, bound, unit, toward):
    """Move the trial force by a share towards its bounds: up where `toward` is positive, to zero otherwise.

    Without bound it grows by that share. Points on a bound stay there. Returns the sum of g s and the largest
    share of a point's way to its bound that the step takes.
    """
    ny = x.shape[1]
    zero, one, toward = s.dtype.type(0), s.dtype.type(1), s.dtype.type(toward)
    least = s.dtype.type(2 * np.finfo(s.dtype).eps)
    slope, most = 0.0, np.empty(ny, s.dtype)
    for j in range(ny):
        most[j] = zero
    for i in range(lo, hi):
        row_slope = zero
        for j in range(ny):
            force, change = s.dtype.type(unit * x[i, j]), s[i, j]
            if bound is None:
                change += toward * (force + change)
            else:
                room = s.dtype.type(unit * (bound[i, j] - x[i, j]))
                near = least * abs(change)
                way = room - change if toward > zero else force + change
                between = force + change > near and room - change > near
                change += toward * way if between else zero
                most[j] = max(most[j], change / (room if room > zero else one))
            most[j] = max(most[j], -change / (force if force > zero else one))
            row_slope += g[i, j] * change
            s[i, j] = change
        slope += row_slope
    largest = zero
    for j in range(ny):
        largest = max(largest, most[j])
    return slope, largest


@njit(**_OPTIONS)
def bend(lo, hi, s, v):
    """Curvature of the energy along a search direction s with displacements v: the sum of s v."""
    total = 0.0
    for i in range(lo, hi):
        row_total = s.dtype.type(0)
        for j in range(s.shape[1]):
            row_total += s[i, j] * v[i, j]
        total += row_total
    return (total,)


@njit(**_OPTIONS)
def advance(lo, hi, x, g, s, v, bound, unit, factor):
    """Move the force by `factor` steps; sums of phi and phi (g + factor v) there."""
    total, moment = 0.0, 0.0
    # A step that ends at a bound does so but for the rounding of the step.
    least, share = 2 * np.finfo(s.dtype).eps, factor / unit
    for i in range(lo, hi):
        row_total, row_moment = 0.0, 0.0
        for j in range(x.shape[1]):
            change = np.float64(s[i, j])
            near = least * abs(change)
            force = unit * x[i, j] + factor * change
            moved = x[i, j] + share * change
            phi = force if force > near else 0.0
            moved = moved if force > near else 0.0
            if bound is not None:
                top = unit * bound[i, j]
                room = unit * (bound[i, j] - x[i, j]) - factor * change
                at = room <= near + 1e-14 * top
                moved = bound[i, j] if at else moved
                phi = 0.0 if at else phi * (room / top)
            x[i, j] = moved
            row_total += phi
            row_moment += phi * (g[i, j] + factor * v[i, j])
        total += row_total
        moment += row_moment
    return total, moment


@njit(**_OPTIONS)
def multiply(lo, hi, spectrum, factor):
    """Multiply rows of a half spectrum by real factors."""
    for i in range(lo, hi):
        for j in range(factor.shape[1]):
            spectrum[i, j] *= factor[i, j]
    return (0.0,)


@njit(**_OPTIONS)
def divide(lo, hi, spectrum, factor):
    """Divide rows of a half spectrum by real factors, and take out the mean."""
    for i in range(lo, hi):
        for j in range(factor.shape[1]):
            if i + j > 0:
                spectrum[i, j] *= 1 / factor[i, j]
            else:
                spectrum[i, j] = 0
    return (0.0,)
