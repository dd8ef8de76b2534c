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

import numpy as np
from numba import njit

OPTIONS = {"cache": True, "nogil": True, "fastmath": {"reassoc", "contract", "nsz"}}


@njit(**OPTIONS)
def _plane(t, x, y, z, fx, fy, fz):
    """Return the forces on a plane, by component, and those of the values of one plane on it."""
    a = t[0] * x[0] + t[1] * x[1] + t[2] * x[2] + t[3] * x[3] + t[11] * y[4] + t[18] * z[4] + t[19] * z[5]
    b = t[4] * x[4] + t[7] * y[0] + t[8] * y[1] + t[9] * y[2] + t[10] * y[3] + t[20] * z[6] + t[21] * z[7]
    c = t[5] * x[5] + t[6] * x[6] + t[12] * y[5] + t[13] * y[6]
    return fx + a, fy + b, fz + c + t[14] * z[0] + t[15] * z[1] + t[16] * z[2] + t[17] * z[3]


@njit(**OPTIONS)
def _column(c, u, i, j, out):
    """Write the forces A u of one column into out (nz, 3).

    Mirrored neighbours share a coefficient, so that their sums and differences are formed first; each plane
    then acts on the plane below it, on itself and on the plane above it.
    """
    nx, ny, nz = u.shape[0], u.shape[1], u.shape[2]
    before, after, left, right = (i - 1) % nx, (i + 1) % nx, (j - 1) % ny, (j + 1) % ny
    here, back, ahead = u[i, j], u[i, left], u[i, right]
    low, low_back, low_ahead = u[before, j], u[before, left], u[before, right]
    high, high_back, high_ahead = u[after, j], u[after, left], u[after, right]
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
        xs, ys = (x0, x1, x2, x3, x4, x5, x6), (y0, y1, y2, y3, y4, y5, y6)
        zs = z0, z1, z2, z3, z4, z5, z6, z7
        if k > 0:
            out[k - 1, 0], out[k - 1, 1], out[k - 1, 2] = _plane(c[k, 0], xs, ys, zs, x, y, z)
        x, y, z = _plane(c[k, 1], xs, ys, zs, next_x, next_y, next_z)
        next_x, next_y, next_z = _plane(c[k, 2], xs, ys, zs, 0.0, 0.0, 0.0)
    out[nz - 1, 0], out[nz - 1, 1], out[nz - 1, 2] = x, y, z


@njit(**OPTIONS)
def apply_stencil(c, u, out):
    """Write the forces A u into out."""
    for i in range(u.shape[0]):
        for j in range(u.shape[1]):
            _column(c, u, i, j, out[i, j])


@njit(**OPTIONS)
def coloured_columns(nx, ny):
    """List the columns (i, j) by four colours: no two of one colour are neighbours."""
    colours = ((0, 0), (0, 1), (1, 0), (1, 1))
    return [(i, j) for a, b in colours for i in range(a, nx, 2) for j in range(b, ny, 2)]


@njit(**OPTIONS)
def relax(c, low, d, f, tied, u, backward):
    """Solve every column for its own unknowns, four colours in turn, in place.

    With `backward` the columns come in reverse, which is the adjoint sweep. A mirror-symmetric column
    couples x, y and z only to themselves: three tridiagonal systems.
    """
    nx, ny, nz = u.shape[0], u.shape[1], u.shape[2]
    r, order = np.empty((nz, 3)), coloured_columns(nx, ny)
    for i, j in order[::-1] if backward else order:
        _column(c, u, i, j, r)
        x, y, z = 0.0, 0.0, 0.0
        for k in range(nz):
            x = f[i, j, k, 0] - r[k, 0] - low[k, 0] * x
            y = f[i, j, k, 1] - r[k, 1] - low[k, 1] * y
            z = f[i, j, k, 2] - r[k, 2] - low[k, 2] * z
            r[k, 0], r[k, 1], r[k, 2] = x, y, z
        x, y, z = 0.0, 0.0, 0.0
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


@njit(**OPTIONS)
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
