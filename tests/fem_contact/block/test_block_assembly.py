import numpy as np
import pytest
import scipy.sparse.linalg as sla
import skfem
from skfem.helpers import ddot, div, sym_grad

from fem_contact.block import ELEMENTS, BlockMesh, plan_mesh
from fem_contact.block.elements import LocalForms, scalar_basis
from fem_contact.block.full.assembly import assemble, lame
from fem_contact.errors import InvalidInput


def bonded_layer(q: float, *, depth: float, poisson: float) -> float:
    """Compliance of a layer on a rigid base without tangential traction, times Young's modulus."""
    k, a = 3 - 4 * poisson, q * depth
    shape = (k * np.sinh(2 * a) - 2 * a) / (k * np.cosh(2 * a) + 2 * a**2 + (k**2 + 1) / 2)
    return float(2 * (1 - poisson**2) / q * shape)


def surface_deflection(mesh: BlockMesh, pressure: np.ndarray, *, poisson: float) -> np.ndarray:
    """Downward displacement of the surface nodes under nodal forces `pressure` times the cell area."""
    (nx, ny), nz = mesh.shape, mesh.nz
    matrix = assemble(mesh, poisson=poisson).free()
    force = np.zeros((nx, ny, nz, 3))
    force[:, :, -1, 2] = -pressure * mesh.aspect
    moved = sla.spsolve(matrix.tocsc(), force.ravel()).reshape(nx, ny, nz, 3)
    return -moved[:, :, -1, 2]


def test_combined_scalar_forms_equal_the_vector_form_cell_by_cell() -> None:
    mesh = plan_mesh((3, 4), (1.0, 2.0))
    modulus = np.random.default_rng(17).uniform(0.5, 2.0, (3, 4, mesh.nz))
    basis, _ = mesh.basis()
    vector = skfem.Basis(basis.mesh, skfem.ElementVector(skfem.ElementHex1()), intorder=2)
    first, second = lame(0.3)
    corner = basis.mesh.doflocs[:, basis.mesh.dofs.element_dofs].mean(axis=1)
    i, j = np.floor(corner[0]).astype(int), np.floor(corner[1] / mesh.aspect).astype(int)
    k = np.searchsorted(mesh.planes, corner[2]) - 1

    @skfem.BilinearForm
    def form(u, v, w):
        return w.young * (first * div(u) * div(v) + 2 * second * ddot(sym_grad(u), sym_grad(v)))

    young = np.tile(modulus[i, j, k][:, None], (1, vector.X.shape[1]))
    reference = form.assemble(vector, young=young).toarray()
    x = vector.doflocs
    node = (np.rint(x[0]).astype(int) % 3) * 4 + np.rint(x[1] / mesh.aspect).astype(int) % 4
    plane = np.array([int(np.argmin(np.abs(mesh.planes - z))) for z in x[2]])
    component = np.empty(vector.N, dtype=int)
    for axis in range(3):
        component[vector.nodal_dofs[axis]] = axis
    number = 3 * (node * (mesh.nz + 1) + plane) + component
    ours = assemble(mesh, poisson=0.3, modulus=modulus).matrix.toarray()[np.ix_(number, number)]
    np.testing.assert_allclose(ours, reference, atol=1e-14 * np.abs(reference).max())


def test_patch_of_uniform_strain_needs_no_force_inside() -> None:
    mesh = plan_mesh((5, 4), (1.0, 1.3))
    matrix = assemble(mesh, poisson=0.27).matrix
    z = mesh.planes - mesh.planes[0]
    for component in range(3):
        field = np.zeros((5, 4, mesh.nz + 1, 3))
        field[..., component] = 0.01 * z
        force = (matrix @ field.ravel()).reshape(field.shape)
        first, second = lame(0.27)
        traction = 0.01 * (first + 2 * second if component == 2 else second) * mesh.aspect
        assert np.abs(force[:, :, 1:-1]).max() < 1e-12 * traction
        np.testing.assert_allclose(force[:, :, -1, component], traction, rtol=1e-12)


@pytest.mark.parametrize("poisson", [-0.4, 0.0, 0.3, 0.45])
def test_uniform_load_compresses_the_layer_by_its_closed_form(poisson: float) -> None:
    mesh = plan_mesh((3, 2), (1.0, 1.0))
    deflection = surface_deflection(mesh, np.ones((3, 2)), poisson=poisson)
    exact = -mesh.planes[0] * (1 + poisson) * (1 - 2 * poisson) / (1 - poisson)
    np.testing.assert_allclose(deflection, exact, rtol=1e-12)


def test_compliance_of_waves_converges_with_second_order() -> None:
    errors = []
    for n in (8, 16, 32):
        mesh = plan_mesh((n, 2), (1.0, 2.0 / n), growth=1.0, depth=0.5)
        wave = np.cos(2 * np.pi * np.arange(n) / n)[:, None] * np.ones(2)
        found = surface_deflection(mesh, wave, poisson=0.3)[0, 0] / n
        errors.append(abs(found / bonded_layer(2 * np.pi, depth=0.5, poisson=0.3) - 1))
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.all((orders > 1.6) & (orders < 2.6)), (errors, orders)


def test_incompressible_solid_is_refused_by_displacement_elements() -> None:
    with pytest.raises(InvalidInput, match=r"poisson = 0\.5"):
        lame(0.5)


@pytest.mark.parametrize("element", ["Hex1", "Hex2"])
def test_only_a_constant_costs_a_cell_nothing(element: str) -> None:
    """Too few points of the quadrature leave waves that no stiffness resists."""
    forms = LocalForms.integrate(scalar_basis(skfem.MeshHex(), ELEMENTS[element]), ELEMENTS[element])
    laplacian = sum(forms.products[a, a] for a in range(3))[:, :, 0]
    values = np.linalg.eigvalsh(laplacian)
    np.testing.assert_allclose(laplacian.sum(axis=1), 0, atol=1e-12)
    assert np.count_nonzero(values < 1e-10 * values[-1]) == 1
