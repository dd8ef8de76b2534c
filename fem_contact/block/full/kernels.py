"""Compiled passes over trilinear blocks: forces, relaxation of vertical lines, transfer between grids.

| letter | shape | what it is |
|---|---|---|
| c | (nz, 3, 22) | `stencil.TERMS`: what each plane of nodes does to the plane below, itself, the one above |
| u | (nx, ny, nz, 3) | displacement over the cell width, clamped plane left out, periodic in x and y |
| f | (nx, ny, nz, 3) | nodal forces over E times the cell width squared |
| tied | (nx, ny) | whether the vertical displacement of a surface node is held |
| low, d | (nz, 3) | line factors: sub-diagonal over pivot, and the reciprocal pivots, of each component |

The tests hold a NumPy twin of every kernel.
"""

# Types are numba's business here.
# mypy: disallow-untyped-defs=False

from __future__ import annotations

import numpy as np
from numba import njit

_OPTIONS = {"cache": True, "nogil": True, "fastmath": {"reassoc", "contract", "nsz"}}


@njit(**_OPTIONS)
def _column(c, u, i, before, after, j, left, right, out):
    """Write the forces A u of one column into out (nz, 3).

    Mirrored neighbours share a coefficient, so that their sums and differences are formed first; each plane
    then acts on the plane below it, on itself and on the plane above it.
    """
    here, back, ahead = u[i, j], u[i, left], u[i, right]
    low, low_back, low_ahead = u[before, j], u[before, left], u[before, right]
    high, high_back, high_ahead = u[after, j], u[after, left], u[after, right]
    nz = u.shape[2]
    x, y, z = 0.0, 0.0, 0.0
    next_x, next_y, next_z = 0.0, 0.0, 0.0
    for k in range(nz):
        p, q, r, s = high_ahead[k, 0], high_back[k, 0], low_ahead[k, 0], low_back[k, 0]
        x0 = here[k, 0]
        x1, x5 = high[k, 0] + low[k, 0], high[k, 0] - low[k, 0]
        x2 = ahead[k, 0] + back[k, 0]
        x3, x4, x6 = (p + q) + (r + s), (p - q) - (r - s), (p + q) - (r + s)
        p, q, r, s = high_ahead[k, 1], high_back[k, 1], low_ahead[k, 1], low_back[k, 1]
        y0 = here[k, 1]
        y1 = high[k, 1] + low[k, 1]
        y2, y5 = ahead[k, 1] + back[k, 1], ahead[k, 1] - back[k, 1]
        y3, y4, y6 = (p + q) + (r + s), (p - q) - (r - s), (p - q) + (r - s)
        p, q, r, s = high_ahead[k, 2], high_back[k, 2], low_ahead[k, 2], low_back[k, 2]
        z0 = here[k, 2]
        z1, z4 = high[k, 2] + low[k, 2], high[k, 2] - low[k, 2]
        z2, z6 = ahead[k, 2] + back[k, 2], ahead[k, 2] - back[k, 2]
        z3, z5, z7 = (p + q) + (r + s), (p + q) - (r + s), (p - q) + (r - s)
        if k > 0:
            t = c[k, 0]
            x += t[0] * x0 + t[1] * x1 + t[2] * x2 + t[3] * x3 + t[11] * y4 + t[18] * z4 + t[19] * z5
            y += t[4] * x4 + t[7] * y0 + t[8] * y1 + t[9] * y2 + t[10] * y3 + t[20] * z6 + t[21] * z7
            z += t[5] * x5 + t[6] * x6 + t[12] * y5 + t[13] * y6
            z += t[14] * z0 + t[15] * z1 + t[16] * z2 + t[17] * z3
            out[k - 1, 0], out[k - 1, 1], out[k - 1, 2] = x, y, z
        t = c[k, 1]
        x = next_x + t[0] * x0 + t[1] * x1 + t[2] * x2 + t[3] * x3 + t[11] * y4 + t[18] * z4 + t[19] * z5
        y = next_y + t[4] * x4 + t[7] * y0 + t[8] * y1 + t[9] * y2 + t[10] * y3 + t[20] * z6 + t[21] * z7
        z = next_z + t[5] * x5 + t[6] * x6 + t[12] * y5 + t[13] * y6
        z += t[14] * z0 + t[15] * z1 + t[16] * z2 + t[17] * z3
        t = c[k, 2]
        next_x = t[0] * x0 + t[1] * x1 + t[2] * x2 + t[3] * x3 + t[11] * y4 + t[18] * z4 + t[19] * z5
        next_y = t[4] * x4 + t[7] * y0 + t[8] * y1 + t[9] * y2 + t[10] * y3 + t[20] * z6 + t[21] * z7
        next_z = t[5] * x5 + t[6] * x6 + t[12] * y5 + t[13] * y6
        next_z += t[14] * z0 + t[15] * z1 + t[16] * z2 + t[17] * z3
    out[nz - 1, 0], out[nz - 1, 1], out[nz - 1, 2] = x, y, z


@njit(**_OPTIONS)
def apply_stencil(c, u, out):
    """Write the forces A u into out."""
    nx, ny = u.shape[0], u.shape[1]
    for i in range(nx):
        for j in range(ny):
            _column(c, u, i, (i - 1) % nx, (i + 1) % nx, j, (j - 1) % ny, (j + 1) % ny, out[i, j])


@njit(**_OPTIONS)
def relax(c, low, d, f, tied, u, backward):
    """Solve every column for its own unknowns, four colours in turn, in place.

    With `backward` the columns come in reverse, which is the adjoint sweep. A mirror-symmetric column
    couples x, y and z only to themselves: three tridiagonal systems.
    """
    nx, ny, nz = u.shape[0], u.shape[1], u.shape[2]
    r = np.empty((nz, 3))
    for turn in range(4):
        colour = 3 - turn if backward else turn
        first_i, first_j = colour // 2, colour % 2
        for row in range((nx - first_i + 1) // 2):
            i = first_i + 2 * ((nx - first_i + 1) // 2 - 1 - row if backward else row)
            for place in range((ny - first_j + 1) // 2):
                j = first_j + 2 * ((ny - first_j + 1) // 2 - 1 - place if backward else place)
                _column(c, u, i, (i - 1) % nx, (i + 1) % nx, j, (j - 1) % ny, (j + 1) % ny, r)
                x = 0.0
                y = 0.0
                z = 0.0
                for k in range(nz):
                    x = f[i, j, k, 0] - r[k, 0] - low[k, 0] * x
                    y = f[i, j, k, 1] - r[k, 1] - low[k, 1] * y
                    z = f[i, j, k, 2] - r[k, 2] - low[k, 2] * z
                    r[k, 0] = x
                    r[k, 1] = y
                    r[k, 2] = z
                x = 0.0
                y = 0.0
                z = 0.0
                for k in range(nz - 1, -1, -1):
                    up = low[k + 1] if k + 1 < nz else low[0]
                    x = r[k, 0] * d[k, 0] - up[0] * x
                    y = r[k, 1] * d[k, 1] - up[1] * y
                    z = r[k, 2] * d[k, 2] - up[2] * z
                    if k == nz - 1 and tied[i, j]:
                        z = 0.0
                    u[i, j, k, 0] += x
                    u[i, j, k, 1] += y
                    u[i, j, k, 2] += z


@njit(**_OPTIONS)
def transfer(coarse, i_low, i_weight, j_low, j_weight, fine, gathering):
    """Add coarse (mx, my, m), interpolated bilinearly, to fine (nx, ny, m), or `gathering` the transpose."""
    nx, ny, m = fine.shape
    mx, my = coarse.shape[0], coarse.shape[1]
    for i in range(nx):
        for a in range(2):
            wi = i_weight[i] if a else 1 - i_weight[i]
            ci = (i_low[i] + a) % mx
            if wi == 0.0:
                continue
            for j in range(ny):
                for b in range(2):
                    w = wi * (j_weight[j] if b else 1 - j_weight[j])
                    if w == 0.0:
                        continue
                    cj = (j_low[j] + b) % my
                    if gathering:
                        for k in range(m):
                            coarse[ci, cj, k] += w * fine[i, j, k]
                    else:
                        for k in range(m):
                            fine[i, j, k] += w * coarse[ci, cj, k]
