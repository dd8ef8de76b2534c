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

from __future__ import annotations

import numpy as np
from numba import njit

_OPTIONS = {"cache": True, "nogil": True, "fastmath": {"reassoc", "contract", "nsz"}}


@njit(**_OPTIONS)
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
        p0, p1, p2 = t0 + b0, t1 + b1, t2 - b2
        p3, p4, p5 = t3 + b3, t4 + b4, t5 - b5
        p6, p7, p8 = t6 + b6, t7 + b7, t8 - b8
        p9, p10, p11 = t9 + b9, t10 + b10, t11 - b11
        ex = w[0] * p0 + w[1] * p1 + w[2] * p2 + w[3] * p3 + w[4] * p4 + w[5] * p5
        ex += w[6] * p6 + w[7] * p7 + w[8] * p8 + w[9] * p9 + w[10] * p10 + w[11] * p11
        ey = w[12] * p0 + w[13] * p1 + w[14] * p2 + w[15] * p3 + w[16] * p4 + w[17] * p5
        ey += w[18] * p6 + w[19] * p7 + w[20] * p8 + w[21] * p9 + w[22] * p10 + w[23] * p11
        ez = w[24] * p0 + w[25] * p1 + w[26] * p2 + w[27] * p3 + w[28] * p4 + w[29] * p5
        ez += w[30] * p6 + w[31] * p7 + w[32] * p8 + w[33] * p9 + w[34] * p10 + w[35] * p11
        p0, p1, p2 = t0 - b0, t1 - b1, t2 + b2
        p3, p4, p5 = t3 - b3, t4 - b4, t5 + b5
        p6, p7, p8 = t6 - b6, t7 - b7, t8 + b8
        p9, p10, p11 = t9 - b9, t10 - b10, t11 + b11
        ox = w[36] * p0 + w[37] * p1 + w[38] * p2 + w[39] * p3 + w[40] * p4 + w[41] * p5
        ox += w[42] * p6 + w[43] * p7 + w[44] * p8 + w[45] * p9 + w[46] * p10 + w[47] * p11
        oy = w[48] * p0 + w[49] * p1 + w[50] * p2 + w[51] * p3 + w[52] * p4 + w[53] * p5
        oy += w[54] * p6 + w[55] * p7 + w[56] * p8 + w[57] * p9 + w[58] * p10 + w[59] * p11
        oz = w[60] * p0 + w[61] * p1 + w[62] * p2 + w[63] * p3 + w[64] * p4 + w[65] * p5
        oz += w[66] * p6 + w[67] * p7 + w[68] * p8 + w[69] * p9 + w[70] * p10 + w[71] * p11
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


@njit(**_OPTIONS)
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


@njit(**_OPTIONS)
def apply_cells(c, e, u, out):
    """Write the forces A u into out."""
    for i in range(u.shape[0]):
        for j in range(u.shape[1]):
            _column(c, e, u, i, j, out[i, j])


@njit(**_OPTIONS)
def _solve_column(low, inverse, r):
    """Solve L S L' x = r in place."""
    nz = r.shape[0]
    x, y, z = 0.0, 0.0, 0.0
    for k in range(nz):
        m = low[k]
        p = r[k, 0] - (m[0, 0] * x + m[0, 1] * y + m[0, 2] * z)
        q = r[k, 1] - (m[1, 0] * x + m[1, 1] * y + m[1, 2] * z)
        z = r[k, 2] - (m[2, 0] * x + m[2, 1] * y + m[2, 2] * z)
        x, y = p, q
        r[k, 0], r[k, 1], r[k, 2] = x, y, z
    x, y, z = 0.0, 0.0, 0.0
    for k in range(nz - 1, -1, -1):
        s = inverse[k]
        p = s[0, 0] * r[k, 0] + s[0, 1] * r[k, 1] + s[0, 2] * r[k, 2]
        q = s[1, 0] * r[k, 0] + s[1, 1] * r[k, 1] + s[1, 2] * r[k, 2]
        t = s[2, 0] * r[k, 0] + s[2, 1] * r[k, 1] + s[2, 2] * r[k, 2]
        if k < nz - 1:
            m = low[k + 1]
            p -= m[0, 0] * x + m[1, 0] * y + m[2, 0] * z
            q -= m[0, 1] * x + m[1, 1] * y + m[2, 1] * z
            t -= m[0, 2] * x + m[1, 2] * y + m[2, 2] * z
        x, y, z = p, q, t
        r[k, 0], r[k, 1], r[k, 2] = x, y, z


@njit(**_OPTIONS)
def relax_cells(c, e, low, inverse, follow, f, tied, u, backward):
    """Solve every column for its own unknowns, four colours in turn, in place; `backward` is the adjoint."""
    nx, ny, nz = u.shape[0], u.shape[1], u.shape[2]
    r = np.empty((nz, 3))
    for turn in range(4):
        colour = 3 - turn if backward else turn
        first_i, first_j = colour // 2, colour % 2
        for row in range((nx - first_i + 1) // 2):
            i = first_i + 2 * ((nx - first_i + 1) // 2 - 1 - row if backward else row)
            for place in range((ny - first_j + 1) // 2):
                j = first_j + 2 * ((ny - first_j + 1) // 2 - 1 - place if backward else place)
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
