"""Compiled kernel of the diffusion solver: Legendre-Galerkin in stress, SDIRK4 in time.

Imported where it is used, because numba takes a second to load. Basis: d_k (L_k - L_{k+2}) with d_k =
1/sqrt(4k + 6), for which the stiffness matrix is the identity and mass and advection matrices have five
diagonals (J. Shen, SIAM J. Sci. Comput. 15, 1489, 1994). Time steps: five stages, order 4, L-stable, stiffly
accurate (Hairer and Wanner, Solving Ordinary Differential Equations II, Table 6.5).
"""

from collections.abc import Callable
from typing import Any

import numba
import numpy as np

from persson._checks import Array

#: Coefficients below the diagonal; the diagonal is 1/4, the weights are the last row.
_LOWER = np.array(
    [
        [0.25, 0.0, 0.0, 0.0, 0.0],
        [0.5, 0.25, 0.0, 0.0, 0.0],
        [17 / 50, -1 / 25, 0.25, 0.0, 0.0],
        [371 / 1360, -137 / 2720, 15 / 544, 0.25, 0.0],
        [25 / 24, -49 / 48, 125 / 16, -85 / 12, 0.25],
    ]
)


def matrices(modes: int) -> tuple[Array, Array, Array, Array]:
    """Five diagonals (5, modes) of mass, int phi_j phi_k' and int phi_j x phi_k', and the factors d_k.

    Row o holds the entries (j, j + o - 2), stored at index j.
    """
    k = np.arange(modes + 2, dtype=float)
    d = 1 / np.sqrt(4 * k + 6)
    mass, shift, stretch = (np.zeros((5, modes)) for _ in range(3))
    j = k[:modes]
    dj = d[:modes]
    mass[2] = dj**2 * (2 / (2 * j + 1) + 2 / (2 * j + 5))
    mass[4] = -dj * d[2 : modes + 2] * 2 / (2 * j + 5)
    mass[0, 2:] = mass[4, :-2]
    shift[1, 1:] = -2 * dj[1:] * dj[:-1]
    shift[3] = 2 * dj * d[1 : modes + 1]
    stretch[2] = -(dj**2) * ((j + 1) * 2 / (2 * j + 1) - (j + 2) * 2 / (2 * j + 5))
    stretch[0, 2:] = -dj[2:] * dj[:-2] * j[2:] * 2 / (2 * j[2:] + 1)
    stretch[4] = dj * d[2 : modes + 2] * (j + 3) * 2 / (2 * j + 5)
    for rows in (mass, shift, stretch):
        rows[3, -1:] = 0
        rows[4, -2:] = 0
    return mass, shift, stretch, dj


def _compiled(function: Callable[..., Any]) -> Any:
    """Compile, and keep what is compiled where numba finds a folder that can be written to."""
    try:
        return numba.njit(cache=True)(function)
    except RuntimeError:  # no locator: home and package are read-only
        return numba.njit(function)


@_compiled
def _factor(rows):  # type: ignore[no-untyped-def]
    """LU factors of a five-diagonal matrix in place, without pivoting."""
    n = rows.shape[1]
    for j in range(n - 1):
        p = rows[1, j + 1] / rows[2, j]
        rows[1, j + 1] = p
        rows[2, j + 1] -= p * rows[3, j]
        rows[3, j + 1] -= p * rows[4, j]
        if j + 2 < n:
            p = rows[0, j + 2] / rows[2, j]
            rows[0, j + 2] = p
            rows[1, j + 2] -= p * rows[3, j]
            rows[2, j + 2] -= p * rows[4, j]


@_compiled
def _solve(rows, x):  # type: ignore[no-untyped-def]
    """Solve in place with the factors of `_factor`."""
    n = rows.shape[1]
    for j in range(1, n):
        x[j] -= rows[1, j] * x[j - 1]
        if j > 1:
            x[j] -= rows[0, j] * x[j - 2]
    for j in range(n - 1, -1, -1):
        if j + 1 < n:
            x[j] -= rows[3, j] * x[j + 1]
        if j + 2 < n:
            x[j] -= rows[4, j] * x[j + 2]
        x[j] /= rows[2, j]


@_compiled
def _moments(mass, d, x, height, out):  # type: ignore[no-untyped-def]
    """Integrals of the density against the basis: mass times coefficients, and the ramp to `height`."""
    n = x.size
    for j in range(n):
        value = mass[2, j] * x[j]
        if j >= 2:
            value += mass[0, j] * x[j - 2]
        if j + 2 < n:
            value += mass[4, j] * x[j + 2]
        out[j] = value
    out[0] += d[0] * height
    out[1] += d[1] / 3 * height


@_compiled
def _assemble(tables, advection, kappa, rows):  # type: ignore[no-untyped-def]
    """LU factors of (1 - 2 b1) mass - b0 shift - b1 stretch + kappa; all already multiplied by the step."""
    mass, shift, stretch, _ = tables
    b0, b1 = advection
    for o in range(5):
        for j in range(rows.shape[1]):
            rows[o, j] = (1 - 2 * b1) * mass[o, j] - b0 * shift[o, j] - b1 * stretch[o, j]
    for j in range(rows.shape[1]):
        rows[2, j] += kappa
    _factor(rows)


@_compiled
def _slopes(d, x, height):  # type: ignore[no-untyped-def]
    """Return the derivatives of the density at x = -1 and x = 1."""
    low, high = height / 2, height / 2
    for k in range(x.size):
        slope = (2 * k + 3) * d[k] * x[k]
        high -= slope
        low += slope if k % 2 == 0 else -slope
    return low, high


@_compiled
def _yield(stage, d, rows, x, known):  # type: ignore[no-untyped-def]
    """Plastic area of a stage at the upper wall (Persson 2006, Eqs. 33 and 34); takes its part off x.

    The density at the wall is `lift` times the plastic area, so the area is one more unknown that borders the
    matrix.
    """
    weight, flow, right_rate, lift, square, b0, b1 = stage
    top, bottom = known, 1.0
    for k in range(x.size):
        top += weight * flow / square * (2 * k + 3) * d[k] * x[k]
    if lift != 0.0:
        border = np.zeros(x.size)
        border[0] = square * lift * d[0] * (1 - 2 * b1 - b0)
        border[1] = square * lift * d[1] / 3 * (1 - 2 * b1 - b1)
        _solve(rows, border)
        bottom += weight * lift * (right_rate + flow / 2)
        for k in range(x.size):
            bottom += weight * flow / square * (2 * k + 3) * d[k] * border[k]
        for k in range(x.size):
            x[k] -= top / bottom * border[k]
    return top / bottom


@_compiled
def advance(steps, edges, diffusion, upper_wall, start, tables, history):  # type: ignore[no-untyped-def]
    """Integrate over all steps; rates are per unit of the running variable s.

    The unknown is the density times the squared width of the window: with one wall that tends to a constant,
    so that large steps cost no accuracy however far the distribution has spread.

    | argument | shape | what it is |
    |---|---|---|
    | steps | (n,) | step sizes in s |
    | edges | (4, n, 5) | at the stages: left and right edge of the window [stress], and their rates |
    | diffusion | (n, 5) | V dT/ds [stress^2] |
    | upper_wall | (n, 6) | whether the solid yields at the right edge, 0 or 1; 2 dsigma_Y/dV at the stages |
    | start | (N,) | coefficients of the density times the squared width at the first node |
    | tables | | result of `matrices` |
    | history | (n + 1, N + 4) | filled with the coefficients at each node and four areas and loads |

    2 dsigma_Y/dV [1/stress] times the plastic area is the density at the upper wall. The four are the area
    lost below, the stress it carried, the area that leaked out of the window above, and the plastic area.
    """
    mass, d = tables[0], tables[3]
    count = start.size
    gamma = 0.25
    rows = np.empty((5, count))
    rates, losses = np.zeros((5, count)), np.zeros((5, 4))
    known, state = np.empty(count), np.empty(count)
    now, ledger, height = start.copy(), np.zeros(4), 0.0
    history[0, :count] = now
    history[0, count:] = 0.0
    for n in range(steps.size):
        h = steps[n]
        _moments(mass, d, now, height, state)
        for i in range(5):
            left, right = edges[0, n, i], edges[1, n, i]
            left_rate, right_rate = edges[2, n, i], edges[3, n, i]
            width = right - left
            weight = h * gamma
            b0, b1 = weight * (left_rate + right_rate) / width, weight * (right_rate - left_rate) / width
            flow = diffusion[n, i] / width
            plastic = ledger[3]
            known[:] = state
            for m in range(i):
                plastic += h * _LOWER[i, m] * losses[m, 3]
                for j in range(count):
                    known[j] += h * _LOWER[i, m] * rates[m, j]
            _assemble(tables, (b0, b1), weight * 2 * flow / width, rows)
            now[:] = known
            _solve(rows, now)
            height, before = 0.0, plastic
            if upper_wall[n, 0] != 0.0:
                lift = upper_wall[n, i + 1]
                stage = (weight, flow, right_rate, lift, width * width, b0, b1)
                plastic = _yield(stage, d, rows, now, plastic)
                height = width * width * lift * plastic
            low, high = _slopes(d, now, height)
            flow /= width * width
            losses[i, 0] = flow * low
            losses[i, 1] = flow * low * left
            losses[i, 2] = -flow * high if upper_wall[n, 0] == 0.0 else 0.0
            losses[i, 3] = (plastic - before) / weight
            _moments(mass, d, now, height, rates[i])
            for j in range(count):
                rates[i, j] = (rates[i, j] - known[j]) / weight
        for m in range(4):
            for i in range(5):
                ledger[m] += h * _LOWER[4, i] * losses[i, m]
        history[n + 1, :count] = now
        history[n + 1, count:] = ledger
