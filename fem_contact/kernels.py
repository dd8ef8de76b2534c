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
    """Sum phi and phi (u - h); phi, the weight of a point in the load, is x, or x (1 - x / bound)."""
    total = 0.0
    moment = 0.0
    for i in range(lo, hi):
        for j in range(x.shape[1]):
            phi = x[i, j]
            if bound is not None:
                phi *= 1 - phi / bound[i, j]
            total += phi
            moment += phi * (u[i, j] - h[i, j])
    return total, moment


@njit(**_OPTIONS)
def residual(lo, hi, x, u, h, offset, bound, stiffness, r, work, sums, counts):
    """Residual -g on the working set and its sums over 2 x 2 cells, for rows lo..hi of the coarser level.

    A point leaves the working set where x - stiffness g reaches the bound that x is nearer to. Returns sum x
    |g| and sum x below the bound, the least gap there, the greatest gap at the bound, and the sum of x over
    the working set.
    """
    nx, ny = x.shape
    moment = 0.0
    total = 0.0
    lowest = np.inf
    highest = -np.inf
    free = 0.0
    for row in range(lo, hi):
        for i in range(2 * row, min(2 * row + 2, nx)):
            for j in range(ny):
                g = u[i, j] - h[i, j] + offset
                force = x[i, j]
                aim = force - stiffness * g
                if bound is None:
                    moment += force * abs(g)
                    lowest = g if g < lowest else lowest
                    inside = aim > 0
                    weight = force
                else:
                    weight = force * (1 - force / bound[i, j])
                    inside = aim > 0 if force < 0.5 * bound[i, j] else aim < bound[i, j]
                    if force >= bound[i, j]:
                        highest = g if g > highest else highest
                    else:
                        moment += force * abs(g)
                        lowest = g if g < lowest else lowest
                        total += force
                work[i, j] = inside
                free += weight if inside else 0.0
                r[i, j] = -g if inside else 0.0
        _sum_cells(row, r, work, sums, counts)
    return moment, total, lowest, highest, free


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

    The step is share * s - pull_back * x, with image share * v - pull_back * u. Returns sum x |g|, sum x, sum
    x (u - h), the least gap, and the sum of x over the working set.
    """
    nx, ny = x.shape
    keep = 1 - pull_back
    moment = 0.0
    total = 0.0
    torque = 0.0
    lowest = np.inf
    free = 0.0
    for row in range(lo, hi):
        for i in range(2 * row, min(2 * row + 2, nx)):
            for j in range(ny):
                force = keep * x[i, j] + share * s[i, j]
                force = force if force > 0 else 0.0
                shift = keep * u[i, j] + share * v[i, j]
                x[i, j] = force
                u[i, j] = shift
                level = shift - h[i, j]
                g = level + offset
                torque += force * level
                total += force
                moment += force * abs(g)
                lowest = g if g < lowest else lowest
                inside = force - stiffness * g > 0
                work[i, j] = inside
                free += force if inside else 0.0
                r[i, j] = -g if inside else 0.0
        _sum_cells(row, r, work, sums, counts)
    return moment, total, torque, lowest, free


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
    line = np.empty(my, coarse.dtype)
    for i in range(lo, hi):
        parent = i // 2
        other = (parent + (1 if i % 2 else -1)) % mx
        for j in range(my):
            line[j] = decay * (0.75 * coarse[parent, j] + 0.25 * coarse[other, j])
        for j in range(ny):
            if not occupied[i, j]:
                p = j // 2
                q = p + 1 if j % 2 else p - 1
                if q < 0:
                    q = my - 1
                elif q >= my:
                    q = 0
                fine[i, j] = 0.75 * line[p] + 0.25 * line[q]


@njit(**_OPTIONS)
def push_transposed(lo, hi, fine, occupied, coarse, decay):
    """Transpose of `push`: gather the empty cells of a level on rows lo..hi of the next coarser one."""
    nx, ny = fine.shape
    mx, my = coarse.shape
    line = np.empty(ny, coarse.dtype)
    for row in range(lo, hi):
        line[:] = 0
        for k in range(4):
            if k < 2:
                i = 2 * row + k
                weight = 0.75 * decay
            elif k == 2:
                i = 2 * ((row + 1) % mx)
                weight = 0.25 * decay
            else:
                i = 2 * ((row - 1) % mx) + 1
                weight = 0.25 * decay
            if i < nx:
                for j in range(ny):
                    if not occupied[i, j]:
                        line[j] += weight * fine[i, j]
        for col in range(my):
            value = 0.75 * line[2 * col]
            if 2 * col + 1 < ny:
                value += 0.75 * line[2 * col + 1]
            right = 2 * (col + 1) if col + 1 < my else 0
            left = 2 * col - 1 if col > 0 else 2 * my - 1
            value += 0.25 * line[right]
            if left < ny:
                value += 0.25 * line[left]
            coarse[row, col] = value


@njit(**_OPTIONS)
def pull_transposed(fine, counts, coarse):
    """Transpose of `pull` in place: occupied cells take up the coarser level, divided by their count."""
    for i in range(fine.shape[0]):
        for j in range(fine.shape[1]):
            fine[i, j] = (fine[i, j] + coarse[i // 2, j // 2]) * _PARTS[counts[i, j]]


@njit(**_OPTIONS)
def finish(lo, hi, z, work, coarse, x, s, v, bound):
    """Complete the preconditioned residual z in place; sum z, z v, s and phi v over the working set."""
    total = 0.0
    image = 0.0
    last = 0.0
    weight = 0.0
    for i in range(lo, hi):
        for j in range(z.shape[1]):
            if work[i, j]:
                value = z[i, j] + coarse[i // 2, j // 2]
                z[i, j] = value
                total += value
                image += value * v[i, j]
                last += s[i, j]
                phi = x[i, j]
                if bound is not None:
                    phi *= 1 - phi / bound[i, j]
                weight += phi * v[i, j]
            else:
                z[i, j] = 0
    return total, image, last, weight


@njit(**_OPTIONS)
def trial(lo, hi, x, z, s, work, step, beta, shift):
    """Write the step to the trial force max(x + step (z + beta s - shift x), 0) over s; sum that force.

    Points off the working set lose their force.
    """
    total = 0.0
    for i in range(lo, hi):
        for j in range(x.shape[1]):
            force = x[i, j]
            y = force + step * (z[i, j] + beta * s[i, j] - shift * force)
            y = y if work[i, j] and y > 0 else 0.0
            total += y
            s[i, j] = y - force
    return (total,)


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
def line(lo, hi, x, u, h, offset, s, v, bound, share, pull_back):
    """Sum along the step t = share * s - pull_back * x with image w; find the room the bounds leave.

    Returns sum g t, sum t w, sum u t, the largest multiple of t that keeps the force within its bounds, and
    sum s v.
    """
    slope = 0.0
    curvature = 0.0
    lift = 0.0
    room = np.inf
    plain = 0.0
    for i in range(lo, hi):
        for j in range(x.shape[1]):
            force = x[i, j]
            level = u[i, j]
            step = share * s[i, j] - pull_back * force
            slope += (level - h[i, j] + offset) * step
            curvature += step * (share * v[i, j] - pull_back * level)
            lift += level * step
            plain += s[i, j] * v[i, j]
            if step < 0 and force < -step * room:
                room = force / -step
            if bound is not None and step > 0 and bound[i, j] - force < step * room:
                room = (bound[i, j] - force) / step
    return slope, curvature, lift, room, plain


@njit(**_OPTIONS)
def advance(lo, hi, x, u, h, s, v, factor, bound):
    """Move force and displacement by `factor` steps; sums of phi and phi (u - h)."""
    total = 0.0
    moment = 0.0
    for i in range(lo, hi):
        for j in range(x.shape[1]):
            force = max(x[i, j] + factor * s[i, j], 0.0)
            shift = u[i, j] + factor * v[i, j]
            x[i, j] = force
            u[i, j] = shift
            if bound is not None:
                # x + (bound - x) may round to just below the bound.
                if force >= bound[i, j] * (1 - 1e-14):
                    force = bound[i, j]
                    x[i, j] = force
                force *= 1 - force / bound[i, j]
            total += force
            moment += force * (shift - h[i, j])
    return total, moment


@njit(**_OPTIONS)
def multiply(lo, hi, spectrum, factor):
    """Multiply rows of a half spectrum by real factors."""
    for i in range(lo, hi):
        for j in range(spectrum.shape[1]):
            spectrum[i, j] *= factor[i, j]
    return (0.0,)


@njit(**_OPTIONS)
def divide(lo, hi, spectrum, factor):
    """Divide rows of a half spectrum by real factors, and take out the mean."""
    for i in range(lo, hi):
        for j in range(spectrum.shape[1]):
            if i + j > 0:
                spectrum[i, j] *= 1 / factor[i, j]
            else:
                spectrum[i, j] = 0
    return (0.0,)
