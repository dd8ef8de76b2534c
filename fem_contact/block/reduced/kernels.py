"""Compiled elimination of columns of trilinear cells; its NumPy twin is `column.eliminate`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fem_contact._types import Array

__all__ = ["ENTRIES", "SIDE_BY_SIDE", "descend", "pack", "sweep"]


#: Columns treated together.
SIDE_BY_SIDE = 64

#: Logarithm by which a wave has fallen where what lies below changes nothing (it comes back as much smaller),
#: and by which it falls within one layer at most: in a thick one to 2 - sqrt(3).
_REACH, _FALL = 17.0, 1.3

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


@njit(cache=True)  # type: ignore[untyped-decorator]
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


@njit(cache=True)  # type: ignore[untyped-decorator]
def _write_functions(phase_x: float, phase_y: float, f: Any, p: int) -> None:
    """Products of functions of the phases, four slots per parity."""
    cx, sx, cy, sy = np.cos(phase_x), np.sin(phase_x), np.cos(phase_y), np.sin(phase_y)
    f[0, p], f[1, p], f[2, p], f[3, p] = 1.0, cy, cx, cx * cy
    f[4, p], f[5, p] = sx, sx * cy
    f[8, p], f[9, p] = sy, cx * sy
    f[12, p] = sx * sy


@njit(cache=True)  # type: ignore[untyped-decorator]
def _combine(weights: Any, f: Any, out: Any) -> None:
    for p in range(out.size):
        out[p] = weights[0] * f[0, p] + weights[1] * f[1, p]
        out[p] += weights[2] * f[2, p] + weights[3] * f[3, p]


@njit(cache=True)  # type: ignore[untyped-decorator]
def _climb(s: Any, m: Any) -> None:
    """Eliminate one plane: s becomes the stiffness at the top of the layer m that stands on s."""
    for p in range(s.shape[1]):
        a0, a1, a2 = s[0, p] + m[0, p], s[1, p] + m[1, p], s[2, p] + m[2, p]
        a3, a4, a5 = s[3, p] + m[3, p], s[4, p] + m[4, p], s[5, p] + m[5, p]
        l1, l2 = a1 / a0, a2 / a0
        d1 = a3 - l1 * a1
        l3 = (a4 - l1 * a2) / d1
        d2 = a5 - l2 * a2 - l3 * l3 * d1
        # With A = L D L^T and Y = L^-1 B, the Schur complement is C - Y^T D^-1 Y.
        u0, u1, u2 = m[6, p], m[7, p], m[8, p]
        v0, v1, v2 = m[9, p] - l1 * u0, m[10, p] - l1 * u1, m[11, p] - l1 * u2
        w0 = m[12, p] - l2 * u0 - l3 * v0
        w1 = m[13, p] - l2 * u1 - l3 * v1
        w2 = m[14, p] - l2 * u2 - l3 * v2
        i0, i1, i2 = 1.0 / a0, 1.0 / d1, 1.0 / d2
        s[0, p] = m[15, p] - u0 * u0 * i0 - v0 * v0 * i1 - w0 * w0 * i2
        s[1, p] = m[16, p] - u0 * u1 * i0 - v0 * v1 * i1 - w0 * w1 * i2
        s[2, p] = m[17, p] - u0 * u2 * i0 - v0 * v2 * i1 - w0 * w2 * i2
        s[3, p] = m[18, p] - u1 * u1 * i0 - v1 * v1 * i1 - w1 * w1 * i2
        s[4, p] = m[19, p] - u1 * u2 * i0 - v1 * v2 * i1 - w1 * w2 * i2
        s[5, p] = m[20, p] - u2 * u2 * i0 - v2 * v2 * i1 - w2 * w2 * i2


@njit(cache=True)  # type: ignore[untyped-decorator]
def _sweep_block(
    packed: Any, parity: Any, falls: Any, phases: Any, states: Any, response: Any, start: int
) -> None:
    size = min(SIDE_BY_SIDE, phases.shape[0] - start)
    f, m, s = np.zeros((16, size)), np.empty((21, size)), np.empty((6, size))
    least = np.inf
    for p in range(size):
        x, y = phases[start + p, 0], phases[start + p, 1]
        _write_functions(x, y, f, p)
        least = min(least, np.hypot(x, y))
    first, fall = (packed.shape[0] - 1 if states.shape[0] == 0 else 0), 0.0
    while first > 0 and fall < _REACH:
        fall += min(least * falls[first], _FALL)
        first -= 1
    for layer in range(first, packed.shape[0]):
        for e in range(15 if layer == first else 0, 21):
            _combine(packed[layer, e], f[4 * parity[e] : 4 * parity[e] + 4], m[e])
        if layer == first:
            s[:] = m[15:]
            continue
        if states.shape[0] > 0:
            for e in range(6):
                for p in range(size):
                    states[layer - 1, start + p, e] = s[e, p]
        _climb(s, m)
    for p in range(size):
        # Unit vertical force: the last column of the inverse.
        l1, l2 = s[1, p] / s[0, p], s[2, p] / s[0, p]
        d1 = s[3, p] - l1 * s[1, p]
        l3 = (s[4, p] - l1 * s[2, p]) / d1
        d2 = s[5, p] - l2 * s[2, p] - l3 * l3 * d1
        z = 1.0 / d2
        response[start + p, 2] = z
        response[start + p, 1] = -l3 * z
        response[start + p, 0] = -l2 * z + l1 * l3 * z


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def sweep(
    lo: int, hi: int, packed: Any, parity: Any, falls: Any, phases: Any, states: Any, response: Any
) -> tuple[float]:
    """Eliminate columns from the bottom upwards, blocks lo to hi of `SIDE_BY_SIDE`.

    Parameters
    ----------
    packed, parity : arrays
        From `pack`.
    falls : (nz,) array
        Logarithm by which a wave of phase 1 at least falls within each layer, if it is thin.
    phases : (n, 2) array
    states : (nz - 1, n, 6) array, or (0, 0, 6) to keep none
        Receives the stiffness at the inner boundaries (packed upper triangle).
    response : (n, 3) array
        Receives (u_x, u_y, u_z) of the surface under a unit vertical force.

    Notes
    -----
    Columns are treated in blocks whose numbers lie side by side, so that one instruction serves several of
    them. Where no state is kept, layers that no wave of a block reaches are left out.
    """
    for block in range(lo, hi):
        _sweep_block(packed, parity, falls, phases, states, response, block * SIDE_BY_SIDE)
    return (0.0,)


@njit(cache=True)  # type: ignore[untyped-decorator]
def _descend_row(packed: Any, parity: Any, phases: Any, state: Any, quadrant: Any, amplitudes: Any) -> None:
    f = np.zeros((16, 1))
    m, a = np.empty((15, 1)), np.empty(6)
    x = np.empty((3, 3))
    for j in range(amplitudes.shape[0]):
        mirrored = quadrant[j] < 0
        point = -1 - quadrant[j] if mirrored else quadrant[j]
        _write_functions(phases[point, 0], phases[point, 1], f, 0)
        for e in range(15):
            _combine(packed[e], f[4 * parity[e] : 4 * parity[e] + 4], m[e])
        for e in range(6):
            a[e] = state[point, e] + m[e, 0]
        sign = -1.0 if mirrored else 1.0
        u, v, w = sign * amplitudes[j, 0], amplitudes[j, 1], amplitudes[j, 2]
        for r in range(3):
            force = m[6 + 3 * r, 0] * u + m[7 + 3 * r, 0] * v + m[8 + 3 * r, 0] * w
            x[r, 0], x[r, 1], x[r, 2] = force.real, force.imag, 0.0
        _solve3(a, x)
        amplitudes[j, 0] = -sign * complex(x[0, 0], x[0, 1])
        amplitudes[j, 1] = -complex(x[1, 0], x[1, 1])
        amplitudes[j, 2] = -complex(x[2, 0], x[2, 1])


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def descend(
    lo: int, hi: int, packed: Any, parity: Any, phases: Any, state: Any, quadrant: Any, amplitudes: Any
) -> tuple[float]:
    """Step from the top plane of one layer to its bottom plane, rows lo to hi of waves.

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
    for i in range(lo, hi):
        _descend_row(packed, parity, phases, state, quadrant[i], amplitudes[i])
    return (0.0,)
