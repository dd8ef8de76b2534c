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

#: Share of a value that the extension keeps per level; see `complementarity`.
DECAY = 0.77


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
        for col in range(counts.shape[1]):
            sums[row, col] = 0
            counts[row, col] = 0
        for i in range(2 * row, min(2 * row + 2, nx)):
            for j in range(ny):
                g = u[i, j] - h[i, j] + offset
                force = x[i, j]
                if bound is not None and force >= bound[i, j]:
                    highest = max(highest, g)
                else:
                    moment += force * abs(g)
                    total += force
                    lowest = min(lowest, g)
                aim = force - stiffness * g
                if bound is None or force < 0.5 * bound[i, j]:  # noqa: SIM108
                    inside = aim > 0
                else:
                    inside = aim < bound[i, j]
                work[i, j] = inside
                if inside:
                    free += force if bound is None else force * (1 - force / bound[i, j])
                r[i, j] = -g if inside else 0.0
            for j in range(ny):
                if work[i, j]:
                    sums[row, j // 2] += r[i, j]
                    counts[row, j // 2] += 1
    return moment, total, lowest, highest, free


@njit(**_OPTIONS)
def pull(fine, counts, sums, coarse_counts):
    """Average the occupied cells of a level, in place, and sum them into the next coarser one."""
    sums[:] = 0
    coarse_counts[:] = 0
    for i in range(fine.shape[0]):
        for j in range(fine.shape[1]):
            if counts[i, j] > 0:
                fine[i, j] /= counts[i, j]
                sums[i // 2, j // 2] += fine[i, j]
                coarse_counts[i // 2, j // 2] += 1


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
            if counts[i, j] > 0:
                fine[i, j] = (fine[i, j] + coarse[i // 2, j // 2]) / counts[i, j]
            else:
                fine[i, j] = 0


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
def trial(lo, hi, x, z, s, work, bound, step, beta, shift):
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
                phi = y if bound is None else y * (1 - y / bound[i, j])
                y = max(y + step * (z[i, j] + beta * s[i, j] - shift * phi), 0.0)
            elif bound is None or y < 0.5 * bound[i, j]:
                y = 0.0
            else:
                y = bound[i, j]
            if bound is not None and y >= bound[i, j]:
                y = bound[i, j]
                at += y
            else:
                below += y
                if bound is not None and y > 0:
                    room += bound[i, j] - y
            s[i, j] = y
    return below, at, room


@njit(**_OPTIONS)
def subtract(lo, hi, s, x, factor):
    """Turn the trial force into the step s = factor * trial - x."""
    for i in range(lo, hi):
        for j in range(x.shape[1]):
            s[i, j] = factor * s[i, j] - x[i, j]
    return (0.0,)


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
def line(lo, hi, x, u, h, offset, s, v, bound):
    """Sum g s and s v, and find the largest multiple of s that keeps the force within its bounds."""
    slope = 0.0
    curvature = 0.0
    room = np.inf
    for i in range(lo, hi):
        for j in range(x.shape[1]):
            step = s[i, j]
            slope += (u[i, j] - h[i, j] + offset) * step
            curvature += step * v[i, j]
            if step < 0 and x[i, j] < -step * room:
                room = x[i, j] / -step
            if bound is not None and step > 0 and bound[i, j] - x[i, j] < step * room:
                room = (bound[i, j] - x[i, j]) / step
    return slope, curvature, room


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
