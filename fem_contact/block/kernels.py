"""Compiled elimination of columns of trilinear cells; its NumPy twin is `column.eliminate`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

__all__ = ["ENTRIES", "descend", "pack", "sweep"]

Array = NDArray[np.float64]

#: Upper triangle of the 6 x 6 folded matrix (bottom, top), in the order the kernel reads it.
ENTRIES = (
    *((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)),
    *((0, 3), (0, 4), (0, 5), (1, 3), (1, 4), (1, 5), (2, 3), (2, 4), (2, 5)),
    *((3, 3), (3, 4), (3, 5), (4, 4), (4, 5), (5, 5)),
)


def pack(coefficients: Array) -> tuple[Array, NDArray[np.int64]]:
    """Compress folded layers of trilinear cells for the kernel.

    Parameters
    ----------
    coefficients : (nz, 5, 5, 6, 6) array
        As in `column.FoldedLayers`.

    Returns
    -------
    (nz, 21, 4) array
        Coefficients of each entry in its four products of functions.
    (21,) array
        Parity of each entry: 0 even-even, 1 odd in x, 2 odd in y, 3 odd in both.
    """
    even, odd = np.array([0, 2]), np.array([4])
    packed, parity = np.zeros((len(coefficients), len(ENTRIES), 4)), np.zeros(len(ENTRIES), dtype=np.int64)
    for entry, (row, column) in enumerate(ENTRIES):
        both = coefficients[:, :, :, row, column]
        scale = np.abs(both).max(initial=0.0)
        for number, (x, y) in enumerate(((even, even), (odd, even), (even, odd), (odd, odd))):
            part = both[:, x[:, None], y].reshape(len(coefficients), -1)
            if np.abs(part).max(initial=0.0) > 1e-13 * scale:
                parity[entry] = number
                packed[:, entry] = 0
                packed[:, entry, : part.shape[1]] = part
    return packed, parity


@njit(cache=True, inline="always")  # type: ignore[untyped-decorator]
def _solve3(a: Any, b: Any) -> None:
    """Solve a positive definite 3 x 3 system (packed 00 01 02 11 12 22) for the columns of b, in place."""
    d0 = a[0]
    l1, l2 = a[1] / d0, a[2] / d0
    d1 = a[3] - l1 * a[1]
    m = a[4] - l1 * a[2]
    l3 = m / d1
    d2 = a[5] - l2 * a[2] - l3 * m
    for c in range(3):
        y0 = b[0, c]
        y1 = b[1, c] - l1 * y0
        y2 = b[2, c] - l2 * y0 - l3 * y1
        x2 = y2 / d2
        x1 = y1 / d1 - l3 * x2
        b[2, c] = x2
        b[1, c] = x1
        b[0, c] = y0 / d0 - l1 * x1 - l2 * x2


@njit(cache=True, parallel=True)  # type: ignore[untyped-decorator]
def sweep(packed: Any, parity: Any, phases: Any, states: Any, response: Any) -> None:
    """Eliminate columns from the bottom upwards.

    Parameters
    ----------
    packed, parity : arrays
        From `pack`.
    phases : (n, 2) array
    states : (nz - 1, n, 6) array, or (0, 0, 6) to keep none
        Receives the stiffness at the inner boundaries (packed upper triangle).
    response : (n, 3) array
        Receives (u_x, u_y, u_z) of the surface under a unit vertical force.
    """
    layers, blocks = packed.shape[0], 64
    count = phases.shape[0]
    for block in prange((count + blocks - 1) // blocks):
        f = np.empty((4, 4))
        m, s, a = np.empty(21), np.empty(6), np.empty(6)
        coupling, x = np.empty((3, 3)), np.empty((3, 3))
        for point in range(block * blocks, min(count, (block + 1) * blocks)):
            cx, sx = np.cos(phases[point, 0]), np.sin(phases[point, 0])
            cy, sy = np.cos(phases[point, 1]), np.sin(phases[point, 1])
            f[0, 0], f[0, 1], f[0, 2], f[0, 3] = 1.0, cy, cx, cx * cy
            f[1, 0], f[1, 1], f[1, 2], f[1, 3] = sx, sx * cy, 0.0, 0.0
            f[2, 0], f[2, 1], f[2, 2], f[2, 3] = sy, cx * sy, 0.0, 0.0
            f[3, 0], f[3, 1], f[3, 2], f[3, 3] = sx * sy, 0.0, 0.0, 0.0
            for layer in range(layers):
                first = 15 if layer == 0 else 0
                for e in range(first, 21):
                    g = parity[e]
                    m[e] = (
                        packed[layer, e, 0] * f[g, 0]
                        + packed[layer, e, 1] * f[g, 1]
                        + packed[layer, e, 2] * f[g, 2]
                        + packed[layer, e, 3] * f[g, 3]
                    )
                if layer == 0:
                    for e in range(6):
                        s[e] = m[15 + e]
                    continue
                if states.shape[0] > 0:
                    for e in range(6):
                        states[layer - 1, point, e] = s[e]
                for e in range(6):
                    a[e] = s[e] + m[e]
                for r in range(3):
                    for c in range(3):
                        coupling[r, c] = m[6 + 3 * r + c]
                        x[r, c] = coupling[r, c]
                _solve3(a, x)
                e = 0
                for r in range(3):
                    for c in range(r, 3):
                        s[e] = m[15 + e] - (
                            coupling[0, r] * x[0, c] + coupling[1, r] * x[1, c] + coupling[2, r] * x[2, c]
                        )
                        e += 1
            x[:] = 0.0
            x[2, 0] = 1.0
            _solve3(s, x)
            response[point, 0], response[point, 1], response[point, 2] = x[0, 0], x[1, 0], x[2, 0]


@njit(cache=True, parallel=True)  # type: ignore[untyped-decorator]
def descend(packed: Any, parity: Any, phases: Any, state: Any, quadrant: Any, amplitudes: Any) -> None:
    """Step from the top plane of one layer to its bottom plane.

    Parameters
    ----------
    packed, parity : (21, 4) and (21,) arrays
        The layer, from `pack`.
    phases : (n, 2) array
        Phases of one quadrant.
    state : (n, 6) array
        Stiffness of what lies below the layer.
    quadrant : (nx, ny) array of int
        Which of them each wave mirrors onto; a negative entry -1 - i says so for a wave with negative
        theta_x.
    amplitudes : (nx, ny, 3) complex array
        Amplitudes of the top plane on entry, of the bottom plane on return.
    """
    for i in prange(amplitudes.shape[0]):
        f = np.empty((4, 4))
        m, a = np.empty(15), np.empty(6)
        x = np.empty((3, 3))
        for j in range(amplitudes.shape[1]):
            mirrored = quadrant[i, j] < 0
            point = -1 - quadrant[i, j] if mirrored else quadrant[i, j]
            cx, sx = np.cos(phases[point, 0]), np.sin(phases[point, 0])
            cy, sy = np.cos(phases[point, 1]), np.sin(phases[point, 1])
            f[0, 0], f[0, 1], f[0, 2], f[0, 3] = 1.0, cy, cx, cx * cy
            f[1, 0], f[1, 1], f[1, 2], f[1, 3] = sx, sx * cy, 0.0, 0.0
            f[2, 0], f[2, 1], f[2, 2], f[2, 3] = sy, cx * sy, 0.0, 0.0
            f[3, 0], f[3, 1], f[3, 2], f[3, 3] = sx * sy, 0.0, 0.0, 0.0
            for e in range(15):
                g = parity[e]
                m[e] = (
                    packed[e, 0] * f[g, 0]
                    + packed[e, 1] * f[g, 1]
                    + packed[e, 2] * f[g, 2]
                    + packed[e, 3] * f[g, 3]
                )
            for e in range(6):
                a[e] = state[point, e] + m[e]
            sign = -1.0 if mirrored else 1.0
            u, v, w = sign * amplitudes[i, j, 0], amplitudes[i, j, 1], amplitudes[i, j, 2]
            for r in range(3):
                force = m[6 + 3 * r] * u + m[7 + 3 * r] * v + m[8 + 3 * r] * w
                x[r, 0], x[r, 1], x[r, 2] = force.real, force.imag, 0.0
            _solve3(a, x)
            amplitudes[i, j, 0] = -sign * complex(x[0, 0], x[0, 1])
            amplitudes[i, j, 1] = -complex(x[1, 0], x[1, 1])
            amplitudes[i, j, 2] = -complex(x[2, 0], x[2, 1])
