"""Compiled elimination of columns of cells, and the way back down; the tests hold NumPy twins of both.

| letter | shape | what it is |
|---|---|---|
| entries, terms, weights | (k, 2), (k, 4), (nz, k, 4) | `plan_folding` |
| products | (25, lanes) | f_i(theta_x) f_j(theta_y) of each wave in row 5 i + j |
| places | (m,) | row in w of each row of a layer: bottom, inner, pressures, top |
| below | (s,) | row in w of what lies below a layer: its plane onto the bottom, then its pressures |
| counts | (4,) | unknowns of a plane and of an inner one, kinds of nodes, columns side by side |
| w | (m + pressures, same, lanes) | bottom, inner, pressures below, top, pressures; upper triangles |
| states | (nz, n, s (s + 1) / 2) | what lies below the top of each layer: upper triangles, row by row |
"""

# Types are numba's business here.
# mypy: disallow-untyped-defs=False

import numpy as np
from numba import njit

from fem_contact._types import Array, Numbers

FoldingPlan = tuple[Numbers, Numbers, Array]

_OPTIONS = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": {"contract"}}
#: Logarithm by which a wave has fallen where what lies below changes nothing (it comes back as much smaller),
#: and by which it falls within one layer at most: in a thick one to 2 - sqrt(3).
_REACH, _FALL = 17.0, 1.3


def plan_folding(coefficients: Array) -> FoldingPlan:
    """List the products of phase functions that each entry of the folded matrices consists of.

    From the coefficients (nz, 5, 5, m, m) of `column.FoldedLayers` follow, for the k entries of the upper
    triangle that are not zero, row and column (k, 2), the numbers 5 i + j (k, 4) of their products
    f_i(theta_x) f_j(theta_y), at most four each, and the coefficients of these (nz, k, 4).
    """
    layers, size = len(coefficients), coefficients.shape[-1]
    flat = coefficients.reshape(layers, -1, size, size)
    small = 1e-14 * np.abs(flat).max(axis=(1, 2, 3), keepdims=True)
    present = np.any(np.abs(flat) > small, axis=0)
    entries = [(r, c) for r in range(size) for c in range(r, size) if present[:, r, c].any()]
    terms, weights = np.zeros((len(entries), 4), dtype=np.int64), np.zeros((layers, len(entries), 4))
    for number, (r, c) in enumerate(entries):
        places = np.flatnonzero(present[:, r, c])
        terms[number, : places.size] = places
        weights[:, number, : places.size] = flat[:, places, r, c]
    return np.array(entries), terms, weights


@njit(**_OPTIONS)
def _eliminate(w, count, size):
    """Eliminate the first unknowns of symmetric matrices (upper triangles), without pivoting.

    Displacements come before the pressures that constrain them, so that every pivot is of one sign and none
    small.
    """
    lanes = w.shape[2]
    f, inverse = np.empty(lanes), np.empty(lanes)
    for k in range(count):
        for p in range(lanes):
            inverse[p] = 1.0 / w[k, k, p]
        for i in range(k + 1, size):
            for p in range(lanes):
                f[p] = w[k, i, p] * inverse[p]
            for j in range(i, size):
                for p in range(lanes):
                    w[i, j, p] -= f[p] * w[k, j, p]


@njit(**_OPTIONS)
def _write_products(x, y, p, out):
    fx = (1.0, np.cos(0.5 * x), np.cos(x), np.sin(0.5 * x), np.sin(x))
    fy = (1.0, np.cos(0.5 * y), np.cos(y), np.sin(0.5 * y), np.sin(y))
    for i in range(5):
        for j in range(5):
            out[5 * i + j, p] = fx[i] * fy[j]


@njit(**_OPTIONS)
def _write_layer(entries, terms, weights, places, products, w):
    """Write the matrix of a layer, its upper triangle, into w for each wave (letters: top of this file)."""
    w[:] = 0.0
    for e in range(entries.shape[0]):
        a, b = places[entries[e, 0]], places[entries[e, 1]]
        out = w[min(a, b), max(a, b)]
        w0, w1, w2, w3 = weights[e]
        f0, f1 = products[terms[e, 0]], products[terms[e, 1]]
        f2, f3 = products[terms[e, 2]], products[terms[e, 3]]
        for p in range(out.size):
            out[p] = w0 * f0[p] + w1 * f1[p] + w2 * f2[p] + w3 * f3[p]


@njit(**_OPTIONS)
def _clamp(w, below):
    """Clamp the bottom plane: unit pivots without coupling take it out."""
    for r in below:
        for c in range(w.shape[0]):
            w[min(r, c), max(r, c)] = 1.0 if r == c else 0.0


@njit(**_OPTIONS)
def sweep(lo, hi, entries, terms, weights, places, below, counts, falls, phases, states, out):
    """Eliminate columns from the bottom upwards, blocks lo to hi of columns that lie side by side.

    | argument | shape | what it is |
    |---|---|---|
    | falls | (nz,) | logarithm by which a wave of phase 1 at least falls within each layer, if it is thin |
    | phases | (n, 2) | theta_x, theta_y of each column |
    | states | as above, or (0, 0, 0) | without them, layers that no wave of a block reaches are left out |
    | out | (n, types, types) | vertical displacement per unit vertical force, over E times the cell width |
    """
    _, inner, types, lanes = counts
    size, layers, keep = below.size, weights.shape[0], states.shape[0] > 0
    eliminated, total = size + inner, 2 * size + inner
    w, v = np.empty((total, total, lanes)), np.zeros((size + types, size + types, lanes))
    products = np.empty((25, lanes))
    for block in range(lo, hi):
        count = min(lanes, phases.shape[0] - block * lanes)
        least = np.inf
        for p in range(lanes):
            x, y = phases[block * lanes + min(p, count - 1)]
            _write_products(x, y, p, products)
            least = min(least, np.hypot(x, y))
        first, fall = 0 if keep else layers - 1, 0.0
        while first > 0 and fall < _REACH:
            fall += min(least * falls[first], _FALL)
            first -= 1
        for layer in range(first, layers):
            _write_layer(entries, terms, weights[layer], places, products, w)
            if layer == first:
                _clamp(w, below)
            else:
                for r in range(size):
                    for c in range(r, size):
                        a, b = below[r], below[c]
                        onto, state = w[min(a, b), max(a, b)], v[r, c]
                        for p in range(lanes):
                            onto[p] += state[p]
            _eliminate(w, eliminated, total)
            v[:size, :size] = w[eliminated:, eliminated:]
            if keep:
                e = 0
                for r in range(size):
                    for c in range(r, size):
                        for p in range(count):
                            states[layer, block * lanes + p, e] = v[r, c, p]
                        e += 1
        v[:, size:] = 0.0
        for t in range(types):
            v[3 * t + 2, size + t] = 1.0
        _eliminate(v, size, size + types)
        for p in range(count):
            for r in range(types):
                for c in range(types):
                    out[block * lanes + p, r, c] = -v[size + min(r, c), size + max(r, c), p]
    return (0.0,)


@njit(**_OPTIONS)
def descend(
    lo, hi, entries, terms, weights, places, below, counts, phases, states, quadrant, signs, waves, middle
):
    """Step from the top plane of one layer to its bottom plane, blocks lo to hi of waves.

    | argument | shape | what it is |
    |---|---|---|
    | weights | (k, 4) | those of this layer |
    | phases | (n, 2) | those of one quadrant |
    | states | (n, s (s + 1) / 2) | what lies below the layer; (0, 0) where its bottom is clamped |
    | quadrant | (waves,) | phase that each wave mirrors onto; -1 - i for one with negative theta_x |
    | signs | (s,) | of what a mirror in x turns |
    | waves | (waves, s) | amplitudes of the top plane and the layer's pressures; then of what lies below |
    | middle | (waves, inner) | receives those of the inner plane |
    """
    plane, inner, _, lanes = counts
    size, clamped = below.size, states.shape[0] == 0
    eliminated = size + inner
    w = np.empty((eliminated + size, eliminated + size, lanes))
    products, b, point = np.empty((25, lanes)), np.empty((2, eliminated, lanes)), np.empty(lanes, np.int64)
    for block in range(lo, hi):
        first = block * lanes
        count = min(lanes, quadrant.size - first)
        for p in range(lanes):
            number = quadrant[first + min(p, count - 1)]
            point[p] = number if number >= 0 else -1 - number
            _write_products(phases[point[p], 0], phases[point[p], 1], p, products)
        _write_layer(entries, terms, weights, places, products, w)
        if clamped:
            _clamp(w, below)
        else:
            e = 0
            for r in range(size):
                for c in range(r, size):
                    onto = w[min(below[r], below[c]), max(below[r], below[c])]
                    for p in range(lanes):
                        onto[p] += states[point[p], e]
                    e += 1
        b[:] = 0.0
        for c in range(size):
            for p in range(count):
                wave = waves[first + p, c] * (signs[c] if quadrant[first + p] < 0 else 1.0)
                for r in range(eliminated):
                    b[0, r, p] -= w[r, eliminated + c, p] * wave.real
                    b[1, r, p] -= w[r, eliminated + c, p] * wave.imag
        for k in range(eliminated):
            for i in range(k + 1, eliminated):
                for p in range(lanes):
                    f = w[k, i, p] / w[k, k, p]
                    b[0, i, p] -= f * b[0, k, p]
                    b[1, i, p] -= f * b[1, k, p]
                    for j in range(i, eliminated):
                        w[i, j, p] -= f * w[k, j, p]
        for k in range(eliminated - 1, -1, -1):
            for j in range(k + 1, eliminated):
                for p in range(lanes):
                    b[0, k, p] -= w[k, j, p] * b[0, j, p]
                    b[1, k, p] -= w[k, j, p] * b[1, j, p]
            for p in range(lanes):
                b[0, k, p] /= w[k, k, p]
                b[1, k, p] /= w[k, k, p]
        for p in range(count):
            mirrored = quadrant[first + p] < 0
            for c in range(size):
                sign = signs[c] if mirrored else 1.0
                waves[first + p, c] = sign * complex(b[0, below[c], p], b[1, below[c], p])
            for c in range(inner):
                sign = signs[c] if mirrored else 1.0
                middle[first + p, c] = sign * complex(b[0, plane + c, p], b[1, plane + c, p])
    return (0.0,)
