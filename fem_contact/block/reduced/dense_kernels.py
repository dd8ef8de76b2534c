"""Compiled elimination of columns of any cells; `column.eliminate` is its NumPy twin."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from fem_contact._types import Array

__all__ = ["LANES", "FoldingPlan", "compliances", "plan_folding"]

FoldingPlan = tuple[NDArray[np.int64], NDArray[np.int64], Array]

#: Columns treated side by side by one instruction stream.
LANES = 16


def plan_folding(coefficients: Array) -> FoldingPlan:
    """List the products of phase functions that each entry of the folded matrices consists of.

    Parameters
    ----------
    coefficients : (nz, 5, 5, m, m) array
        As in `column.FoldedLayers`.

    Returns
    -------
    (k, 2) array of int
        Row and column of the entries of the upper triangle that are not zero.
    (k, 4) array of int
        Numbers 5 i + j of their products f_i(theta_x) f_j(theta_y); at most four each.
    (nz, k, 4) array
        Coefficients.
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


@njit(cache=True, fastmath={"contract"})  # type: ignore[untyped-decorator]
def _eliminate(w: Any, count: int, size: int) -> None:
    """Eliminate the first unknowns of symmetric matrices (upper triangles), without pivoting.

    Displacements come before the pressures that constrain them, so that every pivot is of one sign and none
    small.
    """
    f = np.empty(LANES)
    for k in range(count):
        for i in range(k + 1, size):
            for p in range(LANES):
                f[p] = w[k, i, p] / w[k, k, p]
            for j in range(i, size):
                for p in range(LANES):
                    w[i, j, p] -= f[p] * w[k, j, p]


@njit(cache=True)  # type: ignore[untyped-decorator]
def _write_products(phases: Any, first: int, out: Any) -> None:
    for p in range(LANES):
        point = min(first + p, phases.shape[0] - 1)
        x, y = phases[point, 0], phases[point, 1]
        fx = (1.0, np.cos(0.5 * x), np.cos(x), np.sin(0.5 * x), np.sin(x))
        fy = (1.0, np.cos(0.5 * y), np.cos(y), np.sin(0.5 * y), np.sin(y))
        for i in range(5):
            for j in range(5):
                out[5 * i + j, p] = fx[i] * fy[j]


@njit(cache=True)  # type: ignore[untyped-decorator]
def _write_layer(entries: Any, terms: Any, weights: Any, places: Any, products: Any, w: Any) -> None:
    """Folded matrix of a layer, upper triangle in the order of the work matrix."""
    w[:] = 0.0
    for e in range(entries.shape[0]):
        a, b = places[entries[e, 0]], places[entries[e, 1]]
        r, c = min(a, b), max(a, b)
        for t in range(4):
            weight = weights[e, t]
            if weight != 0.0:
                for p in range(LANES):
                    w[r, c, p] += weight * products[terms[e, t], p]


@njit(cache=True)  # type: ignore[untyped-decorator]
def _stand_on(w: Any, state: Any, state_places: Any, clamped: bool) -> None:
    """Add what lies below a layer, or clamp its bottom plane: unit pivots without coupling take that out."""
    size, total = state.shape[0], w.shape[0]
    if clamped:
        for k in range(size):
            r = state_places[k]
            for c in range(total):
                for p in range(LANES):
                    w[min(r, c), max(r, c), p] = 1.0 if r == c else 0.0
        return
    for r in range(size):
        for c in range(r, size):
            a, b = state_places[r], state_places[c]
            for p in range(LANES):
                w[min(a, b), max(a, b), p] += state[r, c, p]


@njit(cache=True)  # type: ignore[untyped-decorator]
def _columns(
    entries: Any, terms: Any, weights: Any, places: Any, state_places: Any, counts: Any, products: Any
) -> Any:
    """Compliances of some columns side by side, (types, types, lanes)."""
    eliminated, size, types = counts[0], counts[1], counts[2]
    total = eliminated + size
    w = np.empty((total, total, LANES))
    state = np.zeros((size, size, LANES))
    for layer in range(weights.shape[0]):
        _write_layer(entries, terms, weights[layer], places, products, w)
        _stand_on(w, state, state_places, layer == 0)
        _eliminate(w, eliminated, total)
        state[:] = w[eliminated:, eliminated:]
    v = np.zeros((size + types, size + types, LANES))
    v[:size, :size] = state
    for t in range(types):
        v[3 * t + 2, size + t] = 1.0
    _eliminate(v, size, size + types)
    return -v[size:, size:]


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def compliances(
    lo: int,
    hi: int,
    entries: Any,
    terms: Any,
    weights: Any,
    places: Any,
    state_places: Any,
    counts: Any,
    phases: Any,
    out: Any,
) -> tuple[float]:
    """Vertical surface displacement under unit vertical forces, for every kind of node; blocks of `LANES`.

    Parameters
    ----------
    entries, terms, weights : arrays
        From `plan_folding`.
    places : (m,) array of int
        Where the rows of a layer go in the work matrix: bottom, inner, (pressures below), top, pressures.
    state_places : (s,) array of int
        Where the state of what lies below goes: its plane onto the bottom, then its pressures.
    counts : (3,) array of int
        Unknowns eliminated per layer, those of a state, and kinds of nodes.
    phases : (n, 2) array
    out : (n, types, types) array
        Receives the compliance over E times the cell width.
    """
    for block in range(lo, hi):
        products = np.empty((25, LANES))
        _write_products(phases, block * LANES, products)
        found = _columns(entries, terms, weights, places, state_places, counts, products)
        for p in range(min(LANES, phases.shape[0] - block * LANES)):
            for r in range(counts[2]):
                for c in range(counts[2]):
                    out[block * LANES + p, r, c] = found[min(r, c), max(r, c), p]
    return (0.0,)
