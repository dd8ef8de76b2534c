"""The hexahedra of the block, and their stiffness as scikit-fem integrates it.

Nearly incompressible solids need elements whose dilatation is restrained less often than a displacement
element does it: its mean over the cell (``Hex1/P0``), or its projection on linear functions of the cell
(``Hex2/P1disc``).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact._checks import choice
from fem_contact._types import Array, Numbers
from fem_contact.errors import InvalidInput

if TYPE_CHECKING:
    from skfem import CellBasis

#: Poisson ratio above which trilinear displacement elements are no longer chosen: at .4 they are .7 % too
#: stiff at 12 nodes per wavelength, at .45 3 %, and refinement helps slowly.
_LOCKING = 0.4


@dataclass(frozen=True, kw_only=True)
class Element:
    """A hexahedral element.

    Attributes
    ----------
    order : int
        1 for trilinear, 2 for triquadratic displacement.
    pressures : int
        Pressure modes of a cell: 0 (the dilatation enters pointwise), 1 (its mean) or 4 (its projection on
        linear functions).
    quadrature : int
        Polynomial order that is integrated exactly: two points per direction for trilinear elements, three
        for triquadratic.
    """

    name: str
    order: int
    pressures: int
    quadrature: int

    @property
    def types(self) -> int:
        """Kinds of nodes in a plane, per cell."""
        return self.order**2


ELEMENTS = {
    element.name: element
    for element in (
        Element(name="Hex1", order=1, pressures=0, quadrature=2),
        Element(name="Hex1/P0", order=1, pressures=1, quadrature=2),
        Element(name="Hex2", order=2, pressures=0, quadrature=4),
        Element(name="Hex2/P1disc", order=2, pressures=4, quadrature=4),
    )
}


def element_for(element: str | None, *, poisson: float) -> Element:
    """Return the named element, or the cheapest that suits the Poisson ratio.

    Refused are unknown names, and elements that cannot represent an incompressible solid: displacement
    elements have no finite stiffness there, and a constant pressure per trilinear cell leaves checkerboards
    undetermined.

    Examples
    --------
    >>> [element_for(None, poisson=nu).name for nu in (0.3, 0.49, 0.5)]
    ['Hex1', 'Hex1/P0', 'Hex2/P1disc']
    """
    if element is None:
        element = "Hex1" if poisson <= _LOCKING else "Hex1/P0" if poisson < 0.5 else "Hex2/P1disc"
    choice("element", element, ELEMENTS)
    if poisson == 0.5 and element != "Hex2/P1disc":
        raise InvalidInput(f"element = {element!r}: cannot represent poisson = 0.5; take 'Hex2/P1disc'")
    return ELEMENTS[element]


def lame(poisson: float) -> tuple[float, float]:
    """Lame's constants (lambda, mu) over Young's modulus; an incompressible solid is refused."""
    if not -1 < poisson < 0.5:
        raise InvalidInput(f"poisson = {poisson!r}: must lie in (-1, 0.5) for a finite bulk modulus")
    return poisson / ((1 + poisson) * (1 - 2 * poisson)), 0.5 / (1 + poisson)


@contextmanager
def quiet_skfem() -> Iterator[None]:
    """Keep scikit-fem's log lines about copied arrays from the user, to whom they are no news."""
    import logging

    # Those of its modules have no level of their own.
    logger = logging.getLogger("skfem")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)


def scalar_basis(mesh: Any, element: Element) -> CellBasis:
    """Scalar scikit-fem basis of the element's displacement components."""
    from skfem import Basis, ElementHex1, ElementHex2

    kind = ElementHex1() if element.order == 1 else ElementHex2()
    with quiet_skfem():
        return Basis(mesh, kind, intorder=element.quadrature)


@dataclass(frozen=True, kw_only=True)
class LocalForms:
    """Integrals over each cell from which its stiffness is combined."""

    # int d_a phi_j d_b phi_i for a <= b; i is the test function and the first axis.
    products: dict[tuple[int, int], Array]
    dilatations: Array  # (modes, 3, n, cells): int psi_m d_a phi_i
    masses: Array  # (modes, cells): int psi_m^2; the modes 1, xi, eta, zeta on [-1, 1]^3 are orthogonal
    indices: Numbers  # (2, n, n, cells): Unknowns (test, trial) of the entries of a product

    @classmethod
    def integrate(cls, basis: CellBasis, element: Element) -> LocalForms:
        """Let scikit-fem integrate them."""
        from skfem import BilinearForm

        nodes = basis.Nbfun
        products = {}
        indices = np.empty((2, nodes, nodes, 0), dtype=np.int64)
        for a in range(3):
            for b in range(a, 3):

                def form(u: Any, v: Any, w: Any, a: int = a, b: int = b) -> Any:
                    return u.grad[a] * v.grad[b]

                coo = BilinearForm(form).coo_data(basis)
                # scikit-fem stores the trial function first.
                products[a, b] = coo.data.reshape(nodes, nodes, -1).swapaxes(0, 1)
                indices = coo.indices.reshape(2, nodes, nodes, -1).swapaxes(1, 2)
        dilatations, masses = _dilatations(basis, element.pressures)
        return cls(products=products, dilatations=dilatations, masses=masses, indices=indices)

    def product(self, trial: int, test: int) -> Array:
        """Element matrices of int d_trial u d_test v."""
        if trial <= test:
            return self.products[trial, test]
        return self.products[test, trial].swapaxes(0, 1)


def _dilatations(basis: CellBasis, modes: int) -> tuple[Array, Array]:
    from skfem import Functional, LinearForm

    nodes, cells = basis.Nbfun, basis.nelems
    integrals, masses = np.empty((modes, 3, nodes, cells)), np.empty((modes, cells))
    if modes == 0:
        return integrals, masses
    corners = basis.mesh.doflocs[:, basis.mesh.dofs.element_dofs]
    centre = corners.mean(axis=1)[:, :, None]
    half = 0.5 * np.ptp(corners, axis=1)[:, :, None]
    for mode in range(modes):

        def psi(w: Any, mode: int = mode) -> Any:
            if mode == 0:
                return np.ones_like(w.x[0])
            return (w.x[mode - 1] - centre[mode - 1]) / half[mode - 1]

        masses[mode] = Functional(lambda w, psi=psi: psi(w) ** 2).elemental(basis)
        for a in range(3):
            data = LinearForm(lambda v, w, a=a, psi=psi: psi(w) * v.grad[a]).coo_data(basis).data
            integrals[mode, a] = data.reshape(nodes, cells)
    return integrals, masses


def local_shear(forms: LocalForms, a: int, b: int) -> Array:
    """Element matrices (n, n, cells) of 2 eps(u) : eps(v), component a of v and b of u."""
    block = forms.product(a, b)
    if a == b:
        block = block + forms.products[0, 0] + forms.products[1, 1] + forms.products[2, 2]
    return block


def local_dilatation(forms: LocalForms, a: int, b: int) -> Array:
    """Element matrices (n, n, cells) of div u div v, projected where the element does that."""
    if len(forms.masses) == 0:
        return forms.product(b, a)
    scaled = forms.dilatations[:, b] / forms.masses[:, None]
    return np.asarray(np.einsum("mie,mje->ije", forms.dilatations[:, a], scaled))
