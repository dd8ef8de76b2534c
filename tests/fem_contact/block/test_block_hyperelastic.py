"""The block at finite strain against closed forms, its own derivatives, scikit-fem, and the linear block."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from fem_contact import HeightField, NotConverged, Solid
from fem_contact.block import ELEMENTS, plan_mesh, solve_finite_strain
from fem_contact.block.hyperelastic import solver
from fem_contact.block.hyperelastic.cells import Cells, Strained, stress
from fem_contact.block.hyperelastic.newton import descend
from fem_contact.block.hyperelastic.profile import Profile
from tests.surfaces import rough_surface

SOLID = Solid(young=2e6, poisson=0.3)
MESH = {"depth": 0.5, "growth": 2.0}


def small_mesh(element):
    return plan_mesh((4, 5), (4.0, 6.0), depth=4.0, element=ELEMENTS[element])


def rotation(seed):
    q, r = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


@pytest.mark.parametrize("element", ["Hex1", "Hex1/P0"])
def test_forces_are_the_gradient_of_the_energy_and_the_stiffness_that_of_the_forces(element):
    cells = Cells(mesh=small_mesh(element), poisson=0.3)
    rng = np.random.default_rng(5)
    u = 0.1 * rng.standard_normal((*cells.mesh.cells, cells.mesh.nz, 3))
    v, step = rng.standard_normal(u.shape), 1e-5
    above, below = (cells.strained(u + sign * step * v) for sign in (1, -1))
    force = cells.forces(cells.strained(u))
    # Central differences are off by step^2 and by rounding over step.
    slope = (cells.energy(above) - cells.energy(below)) / (2 * step)
    assert slope == pytest.approx(np.sum(force * v), rel=1e-8)
    change = (cells.forces(above) - cells.forces(below)) / (2 * step)
    product = cells.stiffness(cells.strained(u)) @ v.ravel()
    assert_allclose(product, change.ravel(), atol=1e-8 * np.abs(change).max())


def test_forces_are_those_that_scikit_fem_assembles():
    from skfem import Basis, ElementHex1, ElementVector, LinearForm, MeshHex1DG

    mesh = small_mesh("Hex1")
    u = 0.1 * np.random.default_rng(7).standard_normal((*mesh.cells, mesh.nz, 3))
    x, y = np.arange(5.0), np.arange(6.0) * mesh.aspect
    cells = MeshHex1DG.init_tensor(x, y, mesh.edges, periodic=[0, 1])
    basis = Basis(cells, ElementVector(ElementHex1()), intorder=2)
    place = basis.doflocs
    i, j = np.rint(place[0]).astype(int) % 4, np.rint(place[1] / mesh.aspect).astype(int) % 5
    k = np.searchsorted(mesh.planes + 1e-9, place[2])
    part = np.arange(place.shape[1]) % 3
    nodal = np.concatenate([np.zeros((4, 5, 1, 3)), u], axis=2)[i, j, k, part]

    @LinearForm
    def form(v, w):
        gradient = np.moveaxis(w["u"].grad, (0, 1), (-2, -1)) + np.eye(3)
        return np.sum(np.moveaxis(stress(gradient, poisson=0.3), (-2, -1), (0, 1)) * v.grad, axis=(0, 1))

    assembled = form.assemble(basis, u=basis.interpolate(nodal))
    cells = Cells(mesh=mesh, poisson=0.3)
    ours = np.concatenate([np.zeros((4, 5, 1, 3)), cells.forces(cells.strained(u))], axis=2)[i, j, k, part]
    assert_allclose(assembled[k > 0], ours[k > 0], atol=1e-13)


def test_rigid_motion_leaves_no_stress_and_turns_the_stress_there_is():
    turn = rotation(3)
    assert np.abs(stress(turn, poisson=0.3)).max() < 1e-15
    gradient = np.eye(3) + 0.3 * np.random.default_rng(8).standard_normal((3, 3))
    assert_allclose(stress(turn @ gradient, poisson=0.3), turn @ stress(gradient, poisson=0.3), atol=1e-14)


@pytest.mark.parametrize("stretch", [0.5, 0.9, 1.5, 3.0])
def test_uniaxial_stretch_obeys_the_closed_form(stretch):
    poisson = 0.3
    shear, bulk = 0.5 / (1 + poisson), 1 / (3 * (1 - 2 * poisson))

    def across(side):
        jacobian = stretch * side**2
        return shear / 3 * jacobian ** (-5 / 3) * (side**2 - stretch**2) + bulk * (jacobian - 1)

    side = brentq(across, 0.1, 3, xtol=1e-15)
    jacobian = stretch * side**2
    # Cauchy stress along the axis, sides free: mu J^(-5/3) (stretch^2 - side^2), over the shrunk section.
    cauchy = shear * jacobian ** (-5 / 3) * (stretch**2 - side**2)
    found = stress(np.diag([side, side, stretch]), poisson=poisson)
    assert_allclose(found, np.diag([0, 0, cauchy * side**2]), atol=1e-13)


def test_profile_and_its_derivatives_are_those_of_the_fourier_series():
    lx, ly = 2.0, 3.0
    x, y = np.meshgrid(np.arange(8) * lx / 8, np.arange(9) * ly / 9, indexing="ij")

    def exact(x, y):
        a, b = 2 * np.pi / lx, 4 * np.pi / ly
        wave, slope = np.cos(a * x) * np.sin(b * y), np.sin(a * x) * np.sin(b * y)
        return wave, -a * slope, b * np.cos(a * x) * np.cos(b * y), -(a**2) * wave, -(b**2) * wave

    profile = Profile.of(HeightField(heights=exact(x, y)[0], lengths=(lx, ly)), unit=0.5)
    x, y = np.random.default_rng(4).uniform(-4, 4, (2, 20))
    found, (height, along, across, bent, bent_across) = profile.at(2 * x, 2 * y), exact(x, y)
    assert_allclose(found.height, 2 * height, atol=1e-13)
    assert_allclose(found.slope, np.stack([along, across], -1), atol=1e-13)
    assert_allclose(found.curvature[:, [0, 2]], np.stack([bent, bent_across], -1) / 2, atol=1e-12)


@pytest.fixture(scope="module")
def steep():
    surface = rough_surface((12, 12), seed=11, waves=2, gradient=0.4)
    return solve_finite_strain(surface, SOLID, mean_pressure=0.1 * 0.4 * SOLID.contact_modulus, **MESH)


def test_what_is_returned_is_in_equilibrium_and_meets_the_profile(steep):
    assert steep.residual < 1e-8
    force = steep.state.force
    assert force.sum() / steep.press.load == pytest.approx(1, abs=1e-8)
    assert force[steep.in_contact].min() > 0
    assert not force[~steep.in_contact].any()
    assert np.abs(steep.gap[steep.in_contact]).max() < 1e-8 * steep.surface.rms_height
    assert steep.gap[~steep.in_contact].min() > 0
    assert np.mean(steep.pressure * steep.shares) == pytest.approx(steep.mean_pressure)
    assert steep.shares.mean() == pytest.approx(1, abs=1e-14)
    assert steep.area < steep.true_area
    # The block is the same everywhere: only the lattice can hold it sideways.
    assert steep.sideways < 0.01


def test_newton_converges_in_second_order(steep):
    press = replace(steep.press, tolerance=1e-12)
    noise = 2e-2 * np.random.default_rng(9).standard_normal(steep.state.field.shape)
    start = replace(steep.state, field=steep.state.field + noise, history=())
    errors = [e for e in descend(press, start).history if e > 1e-12]
    orders = [np.log(after) / np.log(before) for before, after in itertools.pairwise(errors)]
    assert len(orders) >= 2
    assert min(orders) > 1.6


def test_units_and_translation_change_nothing(steep):
    heights = 2.0**-20 * np.roll(steep.surface.heights, (3, 5), axis=(0, 1))
    moved = HeightField(heights=heights, lengths=(2.0**-20, 2.0**-20))
    solid = Solid(young=2.0**30 * SOLID.young, poisson=SOLID.poisson)
    mesh = {"depth": 0.5 * 2.0**-20, "growth": 2.0}
    again = solve_finite_strain(moved, solid, mean_pressure=2.0**30 * steep.mean_pressure, **mesh)
    back = np.roll(again.pressure, (-3, -5), axis=(0, 1)) / 2.0**30
    assert_allclose(back, steep.pressure, atol=1e-7 * steep.pressure.max())


def test_what_newton_cannot_follow_is_refused_by_name(monkeypatch):
    surface = rough_surface((8, 8), seed=11, waves=2, gradient=0.4)
    monkeypatch.setattr(solver, "_STEPS", 1)
    with pytest.raises(NotConverged, match="of the slope asked for: 1 Newton steps left a residual"):
        solve_finite_strain(surface, SOLID, mean_pressure=1e5, **MESH)


def test_a_tangent_that_is_not_definite_is_refused_by_name():
    # Tips of 2 points in radius: what holds a node sideways is less than the force on it that turns.
    surface = rough_surface((12, 12), seed=11, waves=4, gradient=2.0)
    with pytest.raises(NotConverged, match="of the slope asked for: "):
        solve_finite_strain(surface, SOLID, mean_pressure=0.2 * 2.0 * SOLID.contact_modulus, **MESH)


def test_mean_dilatation_is_that_of_the_cell():
    gradient = np.eye(3) * np.array([1.0, 1.1, 1.2, 1.3])[:, None, None]
    state = Strained.of(gradient, np.array([1.0, 2.0, 3.0, 4.0]))
    assert state.dilated == pytest.approx(np.average(state.jacobian, weights=[1, 2, 3, 4]))
