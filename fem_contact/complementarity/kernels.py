"""Compiled passes of the contact iteration: each reads and writes its arrays once, over a block of rows.

Every kernel works on rows ``lo`` to ``hi`` and releases the interpreter lock, so that a pool of threads can
share a pass; sums come back per block and are added in a fixed order, which makes results independent of the
number of threads. Kernels that fill or read a coarser level take its rows instead. ``bound`` is the upper
bound of the force, or None: the branch then does not exist in the compiled code.

Numba is imported with this module, so this module is imported by the solver only when it runs.
"""

# Types are numba's business here.
# mypy: disallow-untyped-defs=False

from __future__ import annotations

import numpy as np
from numba import njit

_OPTIONS = {"cache": True, "nogil": True, "fastmath": {"reassoc", "contract", "nsz"}}

#: Reciprocals of the possible numbers of occupied cells in a cell of the next level; nothing comes from an
#: empty one.
_PARTS = (0.0, 1.0, 1 / 2, 1 / 3, 1 / 4)

#: Share of a value that the extension keeps per level; see `complementarity`.
DECAY = 0.74


@njit(**_OPTIONS)
def weigh(lo, hi, x, u, h, bound):
    """Sum phi, phi (u - h) and x u; phi, the weight of a point in the load, is x, or x (1 - x / bound)."""
    total = 0.0
    moment = 0.0
    energy = 0.0
    for i in range(lo, hi):
        for j in range(x.shape[1]):
            phi = x[i, j]
            energy += phi * u[i, j]
            if bound is not None:
                phi *= 1 - phi / bound[i, j]
            total += phi
            moment += phi * (u[i, j] - h[i, j])
    return total, moment, energy


@njit(**_OPTIONS)
def residual_bounded(lo, hi, x, u, h, offset, bound, stiffness, r, work, sums, counts, s, v):
    """Residual -g on the working set and its sums over 2 x 2 cells, for rows lo..hi of the coarser level.

    A point leaves the working set where x - stiffness g reaches the bound that x is nearer to. Returns sum x
    |g| and sum x below the bound, the least gap there, the greatest gap at the bound, and over the working
    set the sums of phi, s and phi v.
    """
    nx, ny = x.shape
    moment = 0.0
    total = 0.0
    lowest = np.inf
    highest = -np.inf
    free = 0.0
    last = 0.0
    image = 0.0
    for row in range(lo, hi):
        for i in range(2 * row, min(2 * row + 2, nx)):
            for j in range(ny):
                g = u[i, j] - h[i, j] + offset
                force = x[i, j]
                aim = force - stiffness * g
                inside = aim > 0 if force < 0.5 * bound[i, j] else aim < bound[i, j]
                if force >= bound[i, j]:
                    highest = g if g > highest else highest
                else:
                    moment += force * abs(g)
                    lowest = g if g < lowest else lowest
                    total += force
                work[i, j] = inside
                r[i, j] = -g if inside else 0.0
                if inside:
                    weight = force * (1 - force / bound[i, j])
                    free += weight
                    last += s[i, j]
                    image += weight * v[i, j]
        _sum_cells(row, r, work, sums, counts)
    return moment, total, lowest, highest, free, last, image


@njit(**_OPTIONS)
def _sum_cells(row, r, work, sums, counts):
    """Sum a field and count its occupied points over the cells of one row of the coarser level."""
    nx, ny = r.shape
    last = 2 * row + 1 < nx
    for col in range(ny // 2):
        value = r[2 * row, 2 * col] + r[2 * row, 2 * col + 1]
        count = (work[2 * row, 2 * col] > 0) + (work[2 * row, 2 * col + 1] > 0)
        if last:
            value += r[2 * row + 1, 2 * col] + r[2 * row + 1, 2 * col + 1]
            count += (work[2 * row + 1, 2 * col] > 0) + (work[2 * row + 1, 2 * col + 1] > 0)
        sums[row, col] = value
        counts[row, col] = count
    if ny % 2:
        value = r[2 * row, ny - 1]
        count = int(work[2 * row, ny - 1] > 0)
        if last:
            value += r[2 * row + 1, ny - 1]
            count += int(work[2 * row + 1, ny - 1] > 0)
        sums[row, ny // 2] = value
        counts[row, ny // 2] = count


@njit(**_OPTIONS)
def advance_residual(lo, hi, x, u, h, s, v, share, pull_back, offset, stiffness, r, work, sums, counts):
    """Move force and displacement, and write the residual there, in one pass; without bound.

    The step is share * s - pull_back * x, with image share * v - pull_back * u. Rows lo..hi are those of the
    coarser level, whose sums over 2 x 2 cells are written as well. Returns sum x |g|, sum x, sum x (u - h),
    sum x u, the least gap, and over the working set the sums of x, s and x v.
    """
    nx, ny = x.shape
    zero, one, share, keep = (
        x.dtype.type(0),
        x.dtype.type(1),
        x.dtype.type(share),
        x.dtype.type(1 - pull_back),
    )
    offset, stiffness = x.dtype.type(offset), x.dtype.type(stiffness)
    moment, total, torque, energy = 0.0, 0.0, 0.0, 0.0
    free, last, image = 0.0, 0.0, 0.0
    lowest = x.dtype.type(np.inf)
    for row in range(lo, hi):
        for i in range(2 * row, min(2 * row + 2, nx)):
            # Three loops over a row that stays in the cache, each simple enough to be vectorised; sums over a
            # row are of the precision of the fields, sums of rows are double.
            row_moment, row_total, row_torque, row_energy = zero, zero, zero, zero
            row_free, row_last, row_image = zero, zero, zero
            for j in range(ny):
                force = max(keep * x[i, j] + share * s[i, j], zero)
                shift = keep * u[i, j] + share * v[i, j]
                x[i, j] = force
                u[i, j] = shift
                level = shift - h[i, j]
                g = level + offset
                r[i, j] = g
                lowest = min(lowest, g)
                row_total += force
                row_moment += force * abs(g)
                row_torque += force * level
                row_energy += force * shift
            for j in range(ny):
                work[i, j] = x[i, j] > stiffness * r[i, j]
            for j in range(ny):
                inside = one if work[i, j] else zero
                force = inside * x[i, j]
                row_free += force
                row_image += force * v[i, j]
                row_last += inside * s[i, j]
                r[i, j] *= -inside
            moment += row_moment
            total += row_total
            torque += row_torque
            energy += row_energy
            free += row_free
            last += row_last
            image += row_image
        _sum_cells(row, r, work, sums, counts)
    return moment, total, torque, energy, lowest, free, last, image


@njit(**_OPTIONS)
def pull(fine, counts, sums, coarse_counts):
    """Average the occupied cells of a level, in place, and sum them into the next coarser one."""
    nx, ny = fine.shape
    for row in range(sums.shape[0]):
        for i in range(2 * row, min(2 * row + 2, nx)):
            for j in range(ny):
                fine[i, j] *= _PARTS[counts[i, j]]
        _sum_cells(row, fine, counts, sums, coarse_counts)


@njit(**_OPTIONS)
def push(lo, hi, fine, occupied, coarse, decay):
    """Fill the empty cells of a level with `decay` times the bilinear interpolant of the next coarser one."""
    ny = fine.shape[1]
    mx, my = coarse.shape
    line = np.empty(my + 2, coarse.dtype)
    near, far = fine.dtype.type(0.75), fine.dtype.type(0.25)
    keep = fine.dtype.type(decay)
    for i in range(lo, hi):
        parent = i // 2
        other = (parent + (1 if i % 2 else -1)) % mx
        for j in range(my):
            line[j + 1] = keep * (near * coarse[parent, j] + far * coarse[other, j])
        line[0] = line[my]
        line[my + 1] = line[1]
        for p in range(ny // 2):
            left = near * line[p + 1] + far * line[p]
            right = near * line[p + 1] + far * line[p + 2]
            fine[i, 2 * p] = fine[i, 2 * p] if occupied[i, 2 * p] else left
            fine[i, 2 * p + 1] = fine[i, 2 * p + 1] if occupied[i, 2 * p + 1] else right
        if ny % 2 and not occupied[i, ny - 1]:
            fine[i, ny - 1] = near * line[my] + far * line[my - 1]


@njit(**_OPTIONS)
def push_transposed(lo, hi, fine, occupied, coarse, decay):
    """Transpose of `push`: gather the empty cells of a level on rows lo..hi of the next coarser one."""
    nx, ny = fine.shape
    mx, my = coarse.shape
    line = np.zeros(2 * my + 2, coarse.dtype)
    zero, close, far = fine.dtype.type(0), fine.dtype.type(0.75), fine.dtype.type(0.25)
    for row in range(lo, hi):
        line[:] = 0
        for k in range(4):
            if k < 2:
                i = 2 * row + k
                weight = fine.dtype.type(0.75 * decay)
            elif k == 2:
                i = 2 * ((row + 1) % mx)
                weight = fine.dtype.type(0.25 * decay)
            else:
                i = 2 * ((row - 1) % mx) + 1
                weight = fine.dtype.type(0.25 * decay)
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
            fine[i, j] = (fine[i, j] + coarse[i // 2, j // 2]) * _PARTS[counts[i, j]]


@njit(**_OPTIONS)
def finish(lo, hi, z, work, coarse, v):
    """Complete the preconditioned residual z in place; sum z and z v over the working set."""
    ny = z.shape[1]
    total = 0.0
    image = 0.0
    zero = z.dtype.type(0)
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
def trial(lo, hi, x, z, s, work, u, h, offset, step, beta, shift):
    """Write the step to the trial force max(x + step (z + beta s - shift x), 0) over s.

    Points off the working set lose their force. Returns the sums of that force, of g s and of u s.
    """
    total = 0.0
    slope = 0.0
    lift = 0.0
    zero, offset, step = x.dtype.type(0), x.dtype.type(offset), x.dtype.type(step)
    beta, shift = x.dtype.type(beta), x.dtype.type(shift)
    for i in range(lo, hi):
        row_total, row_slope, row_lift = zero, zero, zero
        for j in range(x.shape[1]):
            force = x[i, j]
            y = max(force + step * (z[i, j] + beta * s[i, j] - shift * force), zero)
            y = y if work[i, j] else zero
            row_total += y
            y -= force
            s[i, j] = y
            row_slope += (u[i, j] - h[i, j] + offset) * y
            row_lift += u[i, j] * y
        total += row_total
        slope += row_slope
        lift += row_lift
    return total, slope, lift


@njit(**_OPTIONS)
def trial_bounded(lo, hi, x, z, s, work, bound, step, beta, shift):
    """Write the trial force over s; sum it between the bounds, at the bound, and the room above the first.

    It is clip(x + step (z + beta s - shift phi)) on the working set, and the bound the point has run into
    elsewhere.
    """
    below = 0.0
    at = 0.0
    room = 0.0
    for i in range(lo, hi):
        for j in range(x.shape[1]):
            y = x[i, j]
            if work[i, j]:
                phi = y * (1 - y / bound[i, j])
                y = max(y + step * (z[i, j] + beta * s[i, j] - shift * phi), 0.0)
            elif y < 0.5 * bound[i, j]:
                y = 0.0
            else:
                y = bound[i, j]
            if y >= bound[i, j]:
                y = bound[i, j]
                at += y
            else:
                below += y
                if y > 0:
                    room += bound[i, j] - y
            s[i, j] = y
    return below, at, room


@njit(**_OPTIONS)
def subtract_bounded(lo, hi, s, x, bound, toward):
    """Turn the trial force into a step, after moving it by a share towards the bound, or to zero if negative.

    Points on a bound stay there.
    """
    for i in range(lo, hi):
        for j in range(x.shape[1]):
            y = s[i, j]
            if y > 0 and y < bound[i, j]:
                y += toward * (bound[i, j] - y) if toward > 0 else toward * y
            s[i, j] = y - x[i, j]
    return (0.0,)


@njit(**_OPTIONS)
def line(lo, hi, x, u, h, offset, s, v):
    """Sum g s, s v and u s along the step s with image v."""
    slope = 0.0
    bend = 0.0
    lift = 0.0
    for i in range(lo, hi):
        for j in range(x.shape[1]):
            slope += (u[i, j] - h[i, j] + offset) * s[i, j]
            bend += s[i, j] * v[i, j]
            lift += u[i, j] * s[i, j]
    return slope, bend, lift


@njit(**_OPTIONS)
def bend(lo, hi, s, v):
    """Sum s v."""
    total = 0.0
    for i in range(lo, hi):
        row_total = s.dtype.type(0)
        for j in range(s.shape[1]):
            row_total += s[i, j] * v[i, j]
        total += row_total
    return (total,)


@njit(**_OPTIONS)
def room(lo, hi, x, s, bound, share, pull_back):
    """Largest multiple of the step share * s - pull_back * x that keeps the force within its bounds."""
    most = x.dtype.type(np.inf)
    share, pull_back = x.dtype.type(share), x.dtype.type(pull_back)
    for i in range(lo, hi):
        for j in range(x.shape[1]):
            force = x[i, j]
            step = share * s[i, j] - pull_back * force
            if step < 0 and force < -step * most:
                most = force / -step
            if bound is not None and step > 0 and bound[i, j] - force < step * most:
                most = (bound[i, j] - force) / step
    return (most,)


@njit(**_OPTIONS)
def advance_bounded(lo, hi, x, u, h, s, v, factor, bound):
    """Move force and displacement by `factor` steps; sums of phi and phi (u - h)."""
    total = 0.0
    moment = 0.0
    for i in range(lo, hi):
        for j in range(x.shape[1]):
            force = max(x[i, j] + factor * s[i, j], 0.0)
            shift = u[i, j] + factor * v[i, j]
            # x + (bound - x) may round to just below the bound.
            if force >= bound[i, j] * (1 - 1e-14):
                force = bound[i, j]
            x[i, j] = force
            u[i, j] = shift
            force *= 1 - force / bound[i, j]
            total += force
            moment += force * (shift - h[i, j])
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
