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

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from fem_contact._types import Array, Numbers
from fem_contact.block.elements import Element
from fem_contact.block.mesh import BlockMesh, element_matrices
from fem_contact.complementarity.rows import Rows
from fem_contact.settings import available_processors

#: Functions of one phase that folded matrices are made of: 1, cos(t/2), cos t, sin(t/2), sin t.
_FUNCTIONS = 5

SweepPlan = tuple[Numbers, Numbers, Array, Numbers, Numbers, Numbers]

#: Poisson ratio from which pressures stay unknowns: below, 1/lambda may be of any size.
_STIFF = 0.4
#: Columns eliminated side by side by one instruction stream, of small and of large matrices.
_LANES = (64, 16)


@dataclass(frozen=True, kw_only=True)
class FoldedLayers:
    """Element matrices of a column as functions of the phases."""

    # (nz, 5, 5, m, m): Of f_i(theta_x) f_j(theta_y), f = 1, cos(t/2), cos t, sin(t/2), sin t. The m
    # rows are bottom plane, inner plane (triquadratic cells), pressure modes, top plane; within a plane
    # by kind of node, then component.
    coefficients: Array
    types: int  # Kinds of nodes per plane
    pressures: int  # Pressure modes kept as unknowns
    falls: Array  # (nz,): Logarithm by which a wave of phase 1 at least falls within each layer, if thin

    @property
    def plane(self) -> int:
        """Unknowns of a plane."""
        return 3 * self.types

    @property
    def inner(self) -> int:
        """Unknowns of the inner plane of a cell."""
        return int(self.coefficients.shape[-1]) - 2 * self.plane - self.pressures

    @cached_property
    def plan(self) -> SweepPlan:
        """What `kernels` read: entries, terms, weights, places, below and counts."""
        from fem_contact.block.reduced.kernels import plan_folding

        plane, inner, pressures = self.plane, self.inner, self.pressures
        # A layer's pressures are eliminated together with the plane above it, which constrains them; that way
        # nothing is singular for the incompressible solid, not even at zero phase.
        below = np.append(np.arange(plane), plane + inner + np.arange(pressures))
        top = plane + inner + pressures + np.arange(plane + pressures)
        places = np.concatenate([np.arange(plane + inner), top[plane:], top[:plane]])
        counts = np.array([plane, inner, self.types, _LANES[plane > 3]])
        return *plan_folding(self.coefficients), places, below, counts


def fold(mesh: BlockMesh, *, poisson: float, modulus: Array | None = None) -> FoldedLayers:
    """Fold the element matrices of one column of scikit-fem cells under Bloch waves.

    nu = 1/2 is allowed for the element with discontinuous linear pressure, whose pressures then are unknowns.
    The modulus (nz,) is that of each layer over E, from the bottom upwards.
    """
    folded = _folded(tuple(mesh.layers.tolist()), mesh.aspect, mesh.element, poisson)
    if modulus is None:
        return folded
    return replace(folded, coefficients=folded.coefficients * modulus[:, None, None, None, None])


@lru_cache(maxsize=4)
def _folded(layers: tuple[float, ...], aspect: float, element: Element, poisson: float) -> FoldedLayers:
    """Fold a column of one material; the columns of a sweep or an ensemble are alike."""
    mesh = BlockMesh(cells=(1, 1), aspect=aspect, layers=np.array(layers), element=element)
    matrices, offsets = element_matrices(mesh, poisson, condensed=poisson < _STIFF)
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
    # Where cells lock, waves fall as slowly as those of pressure do under shear; of the modes that a mean
    # dilatation leaves to thick cells nothing is known, nor of those of triquadratic cells.
    rate = math.sqrt((0.5 - poisson) / (1 - poisson)) / max(aspect, 1.0)
    falls = (0.0 if element.pressures or order == 2 else rate) * mesh.layers
    return FoldedLayers(coefficients=coefficients, types=types, pressures=pressures, falls=falls)


def _wave_terms(shift: tuple[int, int], turn: int) -> list[tuple[int, int, int]]:
    """Real part of i^turn exp(i theta . shift / 2) as products of functions: their numbers and signs.

    Imaginary parts cancel between mirror images within the cell.
    """
    (cx, cy), (sx, sy) = (abs(shift[0]), abs(shift[1])), (2 + abs(shift[0]), 2 + abs(shift[1]))
    dx, dy = int(np.sign(shift[0])), int(np.sign(shift[1]))
    even, odd = [(cx, cy, 1), (sx, sy, -dx * dy)], [(sx, cy, -turn * dx), (cx, sy, -turn * dy)]
    terms = even if turn == 0 else odd
    return [term for term in terms if term[2]]


def surface_compliance(folded: FoldedLayers, phases: Array, *, states: Array | None = None) -> Array:
    """Vertical displacement under unit vertical nodal forces, no tangential ones, (n, types, types).

    Phases (n, 2) are those per cell. The states, if asked for, receive what lies below the top of each layer,
    (nz, n, s (s + 1) / 2): the stiffness of its plane, bordered by its pressures.
    """
    from fem_contact.block.reduced.kernels import sweep

    out = np.empty((len(phases), folded.types, folded.types))
    retained = np.empty((0, 0, 0)) if states is None else states
    rows = Rows(-(-len(phases) // int(folded.plan[-1][-1])), threads=available_processors(), least=8)
    rows.run(sweep, *folded.plan, folded.falls, np.ascontiguousarray(phases), retained, out)
    return out
