r"""The exact reduction of the block to its surface, one lateral wavevector at a time.

With a material that varies in depth only, the periodic stiffness matrix is block-circulant: under a Bloch
wave

.. math:: u(x) = \hat u_t\, e^{i \theta\cdot x}

the nodes of one kind t in one plane carry one amplitude, and the whole block becomes the band matrix of a
single column of cells. Eliminating its planes from the clamped bottom upwards leaves the stiffness of the
surface, of the very mesh and element: no approximation is made. Boxes are symmetric under mirrors, so with
u_z (and the pressure modes even in x and y) counted in units of i every amplitude is real.

Lengths are in cell widths, stiffness in Young's modulus; theta is the phase per cell.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from fem_contact._types import Array
from fem_contact.block.elements import Element
from fem_contact.block.mesh import BlockMesh, element_matrices
from fem_contact.complementarity.rows import Rows
from fem_contact.settings import available_processors

__all__ = [
    "FoldedLayers",
    "SurfaceStates",
    "eliminate",
    "fold",
    "split_layer",
    "surface_compliance",
    "surface_response",
]


#: Functions of one phase that folded matrices are made of: 1, cos(t/2), cos t, sin(t/2), sin t.
_FUNCTIONS = 5


@dataclass(frozen=True, kw_only=True)
class FoldedLayers:
    """Element matrices of a column as functions of the phases."""

    # (nz, 5, 5, m, m): Of f_i(theta_x) f_j(theta_y), f = 1, cos(t/2), cos t, sin(t/2), sin t. The m
    # rows are bottom plane, inner plane (triquadratic cells), pressure modes, top plane; within a plane
    # by kind of node, then component.
    coefficients: Array
    types: int  # Kinds of nodes per plane
    pressures: int  # Pressure modes kept as unknowns

    @property
    def plane(self) -> int:
        """Unknowns of a plane."""
        return 3 * self.types

    @property
    def inner(self) -> int:
        """Unknowns of the inner plane of a cell."""
        return int(self.coefficients.shape[-1]) - 2 * self.plane - self.pressures

    def matrices(self, layer: int, phases: Array) -> Array:
        """Folded matrix of a layer at (n, 2) phases, (n, m, m)."""
        size = self.coefficients.shape[-1]
        x, y = _functions(phases[:, 0]), _functions(phases[:, 1])
        products = (x[:, :, None] * y[:, None, :]).reshape(len(phases), -1)
        values = products @ self.coefficients[layer].reshape(_FUNCTIONS**2, -1)
        return np.asarray(values.reshape(-1, size, size))


def _functions(phase: Array) -> Array:
    half = 0.5 * phase
    return np.stack([np.ones_like(phase), np.cos(half), np.cos(phase), np.sin(half), np.sin(phase)], axis=1)


def fold(mesh: BlockMesh, *, poisson: float, modulus: Array | None = None) -> FoldedLayers:
    """Fold the element matrices of one column of scikit-fem cells under Bloch waves.

    Parameters
    ----------
    poisson : float
        1/2 is allowed for the element with discontinuous linear pressure, whose pressures stay unknowns.
    modulus : (nz,) array, optional
        Young's modulus of each layer over the reference modulus, from the bottom upwards.
    """
    folded = _folded(tuple(mesh.layers.tolist()), mesh.aspect, mesh.element, poisson)
    if modulus is None:
        return folded
    return replace(folded, coefficients=folded.coefficients * modulus[:, None, None, None, None])


@lru_cache(maxsize=4)
def _folded(layers: tuple[float, ...], aspect: float, element: Element, poisson: float) -> FoldedLayers:
    """Fold a column of one material; the columns of a sweep or an ensemble are alike."""
    mesh = BlockMesh(cells=(1, 1), aspect=aspect, layers=np.array(layers), element=element)
    matrices, offsets = element_matrices(mesh, poisson)
    order, types = mesh.element.order, mesh.element.types
    pressures = matrices.shape[1] - 3 * len(offsets)
    inner = 3 * types if order == 2 else 0
    size = 6 * types + inner + pressures
    starts = {0: 0, 1: 3 * types, 2: 3 * types + inner + pressures}
    rows, positions, turned = [], [], []
    for x, y, z in offsets:
        kind = (x % 2) * 2 + y % 2
        rows += [starts[z] + 3 * kind + component for component in range(3)]
        positions += [(x, y)] * 3
        turned += [False, False, True]
    rows += [3 * types + inner + mode for mode in range(pressures)]
    positions += [(1, 1)] * pressures
    turned += [mode in (0, 3) for mode in range(pressures)]
    coefficients = np.zeros((mesh.nz, _FUNCTIONS, _FUNCTIONS, size, size))
    for a, row in enumerate(rows):
        for b, column in enumerate(rows):
            shift = positions[b][0] - positions[a][0], positions[b][1] - positions[a][1]
            for i, j, sign in _wave_terms(shift, turned[b] - turned[a]):
                coefficients[:, i, j, row, column] += sign * matrices[:, a, b]
    coefficients.setflags(write=False)
    return FoldedLayers(coefficients=coefficients, types=types, pressures=pressures)


def _wave_terms(shift: tuple[int, int], turn: int) -> list[tuple[int, int, int]]:
    """Real part of i^turn exp(i theta . shift / 2) as products of functions: their numbers and signs.

    Imaginary parts cancel between mirror images within the cell.
    """
    (cx, cy), (sx, sy) = (abs(shift[0]), abs(shift[1])), (2 + abs(shift[0]), 2 + abs(shift[1]))
    dx, dy = int(np.sign(shift[0])), int(np.sign(shift[1]))
    even, odd = [(cx, cy, 1), (sx, sy, -dx * dy)], [(sx, cy, -turn * dx), (cx, sy, -turn * dy)]
    terms = even if turn == 0 else odd
    return [term for term in terms if term[2]]


@dataclass(frozen=True, kw_only=True)
class SurfaceStates:
    """What the layers below each boundary amount to, for a set of phases."""

    # (n, s, s): State at the surface: stiffness of its plane, bordered by the top layer's pressures.
    top: Array
    # The states at the boundaries below it, from the bottom upwards, if they were asked for.
    below: list[Array]


def eliminate(folded: FoldedLayers, phases: Array, *, keep: bool = False) -> SurfaceStates:
    """Eliminate the planes from the bottom upwards, at (n, 2) phases, for any element.

    For trilinear cells it is the NumPy twin of the compiled kernel.

    A layer's pressures are eliminated together with the plane above it, which constrains them; that way
    nothing is singular for the incompressible solid, not even at zero phase.
    """
    below: list[Array] = []
    plane, inner, pressures = folded.plane, folded.inner, folded.pressures
    state = None
    for layer in range(len(folded.coefficients)):
        matrix = folded.matrices(layer, phases)
        if state is not None and keep:
            below.append(state)
        eliminated, coupling, kept = split_layer(matrix, state, plane=plane, inner=inner, pressures=pressures)
        state = kept
        if eliminated.shape[1]:
            state = kept - coupling.swapaxes(1, 2) @ np.linalg.solve(eliminated, coupling)
    assert state is not None
    return SurfaceStates(top=state, below=below)


def split_layer(
    matrix: Array, state: Array | None, *, plane: int, inner: int, pressures: int
) -> tuple[Array, Array, Array]:
    """Split one layer on what lies below into {bottom, pressures below, inner} and {top, pressures}.

    Without a state the bottom plane is clamped.
    """
    middle = np.arange(plane, plane + inner)
    modes = np.arange(plane + inner, plane + inner + pressures)
    top = np.arange(plane + inner + pressures, matrix.shape[1])
    retained = np.concatenate([top, modes])
    kept = matrix[:, retained[:, None], retained]
    if state is None:
        return matrix[:, middle[:, None], middle], matrix[:, middle[:, None], retained], kept
    own = np.concatenate([np.arange(plane), middle])
    at = np.concatenate([np.arange(plane), np.arange(plane + pressures, plane + pressures + inner)])
    eliminated = np.zeros((len(matrix), plane + pressures + inner, plane + pressures + inner))
    eliminated[:, : plane + pressures, : plane + pressures] = state
    eliminated[:, at[:, None], at] += matrix[:, own[:, None], own]
    coupling = np.zeros((len(matrix), plane + pressures + inner, retained.size))
    coupling[:, at] = matrix[:, own[:, None], retained]
    return eliminated, coupling, kept


def surface_response(folded: FoldedLayers, states: SurfaceStates) -> Array:
    """Amplitudes of the surface plane under unit vertical nodal forces of each kind, (n, 3 types, types)."""
    size, types = states.top.shape[1], folded.types
    loads = np.zeros((size, types))
    loads[3 * np.arange(types) + 2, np.arange(types)] = 1
    answer = np.linalg.solve(states.top, np.broadcast_to(loads, (len(states.top), size, types)))
    return np.asarray(answer[:, : folded.plane])


def surface_compliance(folded: FoldedLayers, phases: Array) -> Array:
    """Vertical displacement under unit vertical nodal forces, no tangential ones, (n, types, types).

    Parameters
    ----------
    phases : (n, 2) array
        Phases per cell.
    """
    from fem_contact.block.reduced.dense_kernels import LANES, compliances, plan_folding

    plane, inner, pressures = folded.plane, folded.inner, folded.pressures
    eliminated, size = plane + inner + pressures, plane + pressures
    # Rows of a layer are bottom, inner, pressures, top; eliminated are bottom, inner, the pressures below.
    bottom, middle = np.arange(plane), np.arange(plane, plane + inner)
    top = eliminated + np.arange(plane)
    modes = eliminated + plane + np.arange(pressures)
    places = np.concatenate([bottom, middle, modes, top])
    state_places = np.concatenate([bottom, plane + inner + np.arange(pressures)])
    out = np.empty((len(phases), folded.types, folded.types))
    counts = np.array([eliminated, size, folded.types])
    plan, phases = plan_folding(folded.coefficients), np.ascontiguousarray(phases)
    rows = Rows(-(-len(phases) // LANES), threads=available_processors(), least=8)
    rows.run(compliances, *plan, places, state_places, counts, phases, out)
    return out
