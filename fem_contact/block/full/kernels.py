"""Compiled passes over trilinear blocks: forces, relaxation of vertical lines, transfer between grids.

| letter | shape | what it is |
|---|---|---|
| c | (nz, 3, 22) | rows of each plane of nodes: `stencil.TERMS` of the plane below, its own, the one above |
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

__all__ = ["apply_stencil", "prolong", "relax", "residual", "restrict"]

_OPTIONS = {"cache": True, "nogil": True, "fastmath": {"reassoc", "contract", "nsz"}}


@njit(**_OPTIONS)
def _column(c, u, i, before, after, j, left, right, out):
    """Write the forces A u of one column into out (nz, 3); mirrored neighbours share a coefficient."""
    nz = u.shape[2]
    for k in range(nz):
        x = 0.0
        y = 0.0
        z = 0.0
        for plane in range(1 if k == 0 else 0, 2 if k == nz - 1 else 3):
            t = c[k, plane]
            m = k + plane - 1
            pp = u[after, right, m, 0]
            pm = u[after, left, m, 0]
            mp = u[before, right, m, 0]
            mm = u[before, left, m, 0]
            p = u[after, j, m, 0]
            q = u[before, j, m, 0]
            x += t[0] * u[i, j, m, 0] + t[1] * (p + q)
            x += t[2] * (u[i, right, m, 0] + u[i, left, m, 0]) + t[3] * ((pp + pm) + (mp + mm))
            y += t[4] * ((pp - pm) - (mp - mm))
            z += t[5] * (p - q) + t[6] * ((pp + pm) - (mp + mm))
            pp = u[after, right, m, 1]
            pm = u[after, left, m, 1]
            mp = u[before, right, m, 1]
            mm = u[before, left, m, 1]
            p = u[i, right, m, 1]
            q = u[i, left, m, 1]
            y += t[7] * u[i, j, m, 1] + t[8] * (u[after, j, m, 1] + u[before, j, m, 1])
            y += t[9] * (p + q) + t[10] * ((pp + pm) + (mp + mm))
            x += t[11] * ((pp - pm) - (mp - mm))
            z += t[12] * (p - q) + t[13] * ((pp + mp) - (pm + mm))
            pp = u[after, right, m, 2]
            pm = u[after, left, m, 2]
            mp = u[before, right, m, 2]
            mm = u[before, left, m, 2]
            p = u[after, j, m, 2]
            q = u[before, j, m, 2]
            x += t[18] * (p - q) + t[19] * ((pp + pm) - (mp + mm))
            z += t[14] * u[i, j, m, 2] + t[15] * (p + q)
            p = u[i, right, m, 2]
            q = u[i, left, m, 2]
            z += t[16] * (p + q) + t[17] * ((pp + pm) + (mp + mm))
            y += t[20] * (p - q) + t[21] * ((pp + mp) - (pm + mm))
        out[k, 0] = x
        out[k, 1] = y
        out[k, 2] = z


@njit(**_OPTIONS)
def apply_stencil(c, u, out):
    """Write the forces A u into out."""
    nx, ny = u.shape[0], u.shape[1]
    for i in range(nx):
        for j in range(ny):
            _column(c, u, i, (i - 1) % nx, (i + 1) % nx, j, (j - 1) % ny, (j + 1) % ny, out[i, j])


@njit(**_OPTIONS)
def residual(c, u, f, tied, out):
    """Write f - A u into out, 0 where the unknown is tied."""
    nx, ny, nz = u.shape[0], u.shape[1], u.shape[2]
    for i in range(nx):
        for j in range(ny):
            column = out[i, j]
            _column(c, u, i, (i - 1) % nx, (i + 1) % nx, j, (j - 1) % ny, (j + 1) % ny, column)
            for k in range(nz):
                for a in range(3):
                    column[k, a] = f[i, j, k, a] - column[k, a]
            if tied[i, j]:
                column[nz - 1, 2] = 0.0


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
def restrict(fine, i_low, i_weight, j_low, j_weight, coarse):
    """Add the transpose of `prolong` to coarse: forces (nx, ny, m) gathered on the coarser grid."""
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
                    for k in range(m):
                        coarse[ci, cj, k] += w * fine[i, j, k]


@njit(**_OPTIONS)
def prolong(coarse, i_low, i_weight, j_low, j_weight, fine):
    """Add the bilinear interpolation of coarse (mx, my, m) to fine."""
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
                    for k in range(m):
                        fine[i, j, k] += w * coarse[ci, cj, k]
