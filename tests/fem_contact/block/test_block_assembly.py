import numpy as np
import pytest
import skfem
from numpy.testing import assert_allclose
from skfem.helpers import ddot, div, sym_grad

from fem_contact.block import ELEMENTS, plan_mesh
from fem_contact.block.elements import LocalForms, scalar_basis
from fem_contact.block.full.assembly import assemble, lame


def test_combined_scalar_forms_equal_the_vector_form_cell_by_cell():
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
    ours = assemble(mesh, poisson=0.3, modulus=modulus).toarray()[np.ix_(number, number)]
    assert_allclose(ours, reference, atol=1e-14 * np.abs(reference).max())


def test_patch_of_uniform_strain_needs_no_force_inside():
    mesh = plan_mesh((5, 4), (1.0, 1.3))
    matrix = assemble(mesh, poisson=0.27)
    z = mesh.planes - mesh.planes[0]
    for component in range(3):
        field = np.zeros((5, 4, mesh.nz + 1, 3))
        field[..., component] = 0.01 * z
        force = (matrix @ field.ravel()).reshape(field.shape)
        first, second = lame(0.27)
        traction = 0.01 * (first + 2 * second if component == 2 else second) * mesh.aspect
        assert np.abs(force[:, :, 1:-1]).max() < 1e-12 * traction
        assert_allclose(force[:, :, -1, component], traction, rtol=1e-12)


@pytest.mark.parametrize("element", ["Hex1", "Hex2"])
def test_only_a_constant_costs_a_cell_nothing(element):
    """Too few points of the quadrature leave waves that no stiffness resists."""
    forms = LocalForms.integrate(scalar_basis(skfem.MeshHex(), ELEMENTS[element]), ELEMENTS[element])
    laplacian = sum(forms.products[a, a] for a in range(3))[:, :, 0]
    values = np.linalg.eigvalsh(laplacian)
    assert_allclose(laplacian.sum(axis=1), 0, atol=1e-12)
    assert np.count_nonzero(values < 1e-10 * values[-1]) == 1
