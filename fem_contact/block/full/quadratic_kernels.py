"""Compiled forces of triquadratic cells, a row of cells along y at a time.

| letter | shape | what it is |
|---|---|---|
| entries | (nz, 855) | blocks of the element matrices of the layers, by parity |
| sizes | (8,) | rows of the blocks |
| places | (3, 3, 3, 3) | row of each combination (x, y, z) of each component |
| e | (nx, ny, nz) | modulus of the cells over E |
| u | (2 nx, 2 ny, 2 nz, 3) | displacement over the cell width, clamped plane left out, periodic in x and y |
| out | like u | nodal forces over E times the cell width squared |
| w, r | (81, ny) | combinations of the displacements of a row of cells, and of its forces |

The combinations along each axis are a + c, m and c - a of the nodes a, m, c of a cell. The tests hold the
assembled matrix against this.
"""

# Types are numba's business here.
# mypy: disallow-untyped-defs=False

import numpy as np
from numba import njit

from fem_contact.block.full.kernels import OPTIONS


@njit(**OPTIONS)
def _gather(places, u, i, k, w):
    """Write the combinations of the cells (i, :, k) into w."""
    ny, after = w.shape[1], (2 * i + 2) % u.shape[0]
    v = np.empty((3, 3, 2 * ny + 1))
    for t in range(3):
        for j in range(2 * ny + 1):
            low, mid, high = u[2 * i, j % (2 * ny)], u[2 * i + 1, j % (2 * ny)], u[after, j % (2 * ny)]
            for z in range(3):
                plane = 2 * k - 1 + z
                a, m, c = 0.0, 0.0, 0.0
                if plane >= 0:
                    a, m, c = low[plane, t], mid[plane, t], high[plane, t]
                v[0, z, j], v[1, z, j], v[2, z, j] = a + c, m, c - a
            for x in range(3):
                bottom, top = v[x, 0, j], v[x, 2, j]
                v[x, 0, j], v[x, 2, j] = bottom + top, top - bottom
        for x in range(3):
            for z in range(3):
                even, mid_row, odd = w[places[x, 0, z, t]], w[places[x, 1, z, t]], w[places[x, 2, z, t]]
                line = v[x, z]
                for p in range(ny):
                    a, m, c = line[2 * p], line[2 * p + 1], line[2 * p + 2]
                    even[p], mid_row[p], odd[p] = a + c, m, c - a


@njit(**OPTIONS)
def _scatter(places, r, e, i, k, out):
    """Add the forces of the cells (i, :, k): the transpose of `_gather`, times the moduli."""
    ny, after = r.shape[1], (2 * i + 2) % out.shape[0]
    v = np.empty((3, 3, 2 * ny + 1))
    for t in range(3):
        for x in range(3):
            for z in range(3):
                even, mid_row, odd = r[places[x, 0, z, t]], r[places[x, 1, z, t]], r[places[x, 2, z, t]]
                line, c = v[x, z], 0.0
                for p in range(ny):
                    scale = e[i, p, k]
                    line[2 * p] = c + scale * (even[p] - odd[p])
                    line[2 * p + 1] = scale * mid_row[p]
                    c = scale * (even[p] + odd[p])
                line[0] += c
        for j in range(2 * ny):
            low, mid, high = out[2 * i, j], out[2 * i + 1, j], out[after, j]
            for x in range(3):
                even_z, odd_z = v[x, 0, j], v[x, 2, j]
                v[x, 0, j], v[x, 2, j] = even_z - odd_z, even_z + odd_z
            for z in range(3):
                plane = 2 * k - 1 + z
                if plane >= 0:
                    low[plane, t] += v[0, z, j] - v[2, z, j]
                    mid[plane, t] += v[1, z, j]
                    high[plane, t] += v[0, z, j] + v[2, z, j]


@njit(**OPTIONS)
def _multiply(entries, sizes, w, r):
    """Multiply the blocks of one layer; every size is a multiple of three."""
    first, place = 0, 0
    for block in range(sizes.size):
        size = sizes[block]
        for row in range(size):
            into = r[first + row]
            into[:] = 0.0
            for column in range(0, size, 3):
                a, b, c = entries[place], entries[place + 1], entries[place + 2]
                one, two, three = w[first + column], w[first + column + 1], w[first + column + 2]
                for p in range(into.size):
                    into[p] += a * one[p] + b * two[p] + c * three[p]
                place += 3
        first += size


@njit(**OPTIONS)
def apply_quadratic(entries, sizes, places, e, u, out):
    """Add the forces A u to out."""
    w, r = np.empty((81, e.shape[1])), np.empty((81, e.shape[1]))
    for i in range(e.shape[0]):
        for k in range(e.shape[2]):
            _gather(places, u, i, k, w)
            _multiply(entries[k], sizes, w, r)
            _scatter(places, r, e, i, k, out)
