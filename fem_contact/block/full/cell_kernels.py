"""Compiled passes over trilinear cells with a modulus each: forces, and relaxation of vertical lines.

| letter | shape | what it is |
|---|---|---|
| c | (nz, 72) | `cells.corner_coefficients`, flat |
| e | (nx, ny, nz) | modulus of the cells over E; cell (i, j) lies between nodes (i, j) and (i + 1, j + 1) |
| u | (nx, ny, nz, 3) | displacement over the cell width, clamped plane left out, periodic in x and y |
| f | (nx, ny, nz, 3) | nodal forces over E times the cell width squared |
| tied | (nx, ny) | whether the vertical displacement of a surface node is held |
| low, inverse, follow | (nx, ny, nz, 3(, 3)) | `cells.BlockFactors` |

The tests hold the assembled matrix against them.
"""

# Types are numba's business here.
# mypy: disallow-untyped-defs=False

import numpy as np
from numba import njit

from fem_contact.block.full.kernels import OPTIONS, coloured_columns


@njit(**OPTIONS, inline="always")
def _product(w, n, near, far):
    """Multiply twelve values by the coefficients of a layer from number n on."""
    total = w[n] * near[0] + w[n + 1] * near[1] + w[n + 2] * near[2] + w[n + 3] * near[3]
    total += w[n + 4] * near[4] + w[n + 5] * near[5] + w[n + 6] * far[0] + w[n + 7] * far[1]
    return total + w[n + 8] * far[2] + w[n + 9] * far[3] + w[n + 10] * far[4] + w[n + 11] * far[5]


@njit(**OPTIONS)
def _stack(c, e, here, x, y, xy, sx, sy, out):
    """Add the forces of one stack of cells on a column: the stack towards +x and +y, or a mirror image."""
    b0, b1, b2, b3, b4, b5, b6, b7, b8, b9, b10, b11 = (0.0,) * 12
    for k in range(here.shape[0]):
        # Values above; mirrors turn the sign of a component.
        t0, t1, t2 = sx * here[k, 0], sy * here[k, 1], here[k, 2]
        t3, t4, t5 = sx * x[k, 0], sy * x[k, 1], x[k, 2]
        t6, t7, t8 = sx * y[k, 0], sy * y[k, 1], y[k, 2]
        t9, t10, t11 = sx * xy[k, 0], sy * xy[k, 1], xy[k, 2]
        w = c[k]
        near = t0 + b0, t1 + b1, t2 - b2, t3 + b3, t4 + b4, t5 - b5
        far = t6 + b6, t7 + b7, t8 - b8, t9 + b9, t10 + b10, t11 - b11
        ex, ey, ez = _product(w, 0, near, far), _product(w, 12, near, far), _product(w, 24, near, far)
        near = t0 - b0, t1 - b1, t2 + b2, t3 - b3, t4 - b4, t5 + b5
        far = t6 - b6, t7 - b7, t8 + b8, t9 - b9, t10 - b10, t11 + b11
        ox, oy, oz = _product(w, 36, near, far), _product(w, 48, near, far), _product(w, 60, near, far)
        ax, ay = sx * e[k], sy * e[k]
        out[k, 0] += ax * (ex + ox)
        out[k, 1] += ay * (ey + oy)
        out[k, 2] += e[k] * (ez + oz)
        if k > 0:
            out[k - 1, 0] += ax * (ex - ox)
            out[k - 1, 1] += ay * (ey - oy)
            out[k - 1, 2] += e[k] * (oz - ez)
        b0, b1, b2, b3, b4, b5 = t0, t1, t2, t3, t4, t5
        b6, b7, b8, b9, b10, b11 = t6, t7, t8, t9, t10, t11


@njit(**OPTIONS)
def _column(c, e, u, i, j, out):
    """Write the forces A u of one column into out (nz, 3)."""
    nx, ny = u.shape[0], u.shape[1]
    before, after, left, right = (i - 1) % nx, (i + 1) % nx, (j - 1) % ny, (j + 1) % ny
    out[:] = 0.0
    here = u[i, j]
    _stack(c, e[i, j], here, u[after, j], u[i, right], u[after, right], 1.0, 1.0, out)
    _stack(c, e[before, j], here, u[before, j], u[i, right], u[before, right], -1.0, 1.0, out)
    _stack(c, e[i, left], here, u[after, j], u[i, left], u[after, left], 1.0, -1.0, out)
    _stack(c, e[before, left], here, u[before, j], u[i, left], u[before, left], -1.0, -1.0, out)


@njit(**OPTIONS)
def apply_cells(c, e, u, out):
    """Write the forces A u into out."""
    for i in range(u.shape[0]):
        for j in range(u.shape[1]):
            _column(c, e, u, i, j, out[i, j])


@njit(**OPTIONS, inline="always")
def _times(m, x, y, z):
    """Multiply a vector by a block of 3 x 3."""
    a, b, c = m[0], m[1], m[2]
    return a[0] * x + a[1] * y + a[2] * z, b[0] * x + b[1] * y + b[2] * z, c[0] * x + c[1] * y + c[2] * z


@njit(**OPTIONS)
def _solve_column(low, inverse, r):
    """Solve L S L' x = r in place."""
    nz = r.shape[0]
    x, y, z = 0.0, 0.0, 0.0
    for k in range(nz):
        a, b, c = _times(low[k], x, y, z)
        x, y, z = r[k, 0] - a, r[k, 1] - b, r[k, 2] - c
        r[k, 0], r[k, 1], r[k, 2] = x, y, z
    x, y, z = 0.0, 0.0, 0.0
    for k in range(nz - 1, -1, -1):
        p, q, t = _times(inverse[k], r[k, 0], r[k, 1], r[k, 2])
        if k < nz - 1:
            a, b, c = _times(low[k + 1].T, x, y, z)
            p, q, t = p - a, q - b, t - c
        x, y, z = p, q, t
        r[k, 0], r[k, 1], r[k, 2] = x, y, z


@njit(**OPTIONS)
def relax_cells(c, e, low, inverse, follow, f, tied, u, backward):
    """Solve every column for its own unknowns, four colours in turn, in place; `backward` is the adjoint."""
    nx, ny, nz = u.shape[0], u.shape[1], u.shape[2]
    r, order = np.empty((nz, 3)), coloured_columns(nx, ny)
    for i, j in order[::-1] if backward else order:
        _column(c, e, u, i, j, r)
        for k in range(nz):
            for a in range(3):
                r[k, a] = f[i, j, k, a] - r[k, a]
        _solve_column(low[i, j], inverse[i, j], r)
        if tied[i, j]:
            share = r[nz - 1, 2]
            for k in range(nz):
                for a in range(3):
                    r[k, a] -= share * follow[i, j, k, a]
            r[nz - 1, 2] = 0.0
        for k in range(nz):
            for a in range(3):
                u[i, j, k, a] += r[k, a]
