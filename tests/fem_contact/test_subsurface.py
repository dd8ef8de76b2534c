"""Below the surface: the fields of layered solids are those of elasticity, and meet the surface above."""

from dataclasses import replace

import meshio
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fem_contact import ExponentialSolid, LayeredSolid, Solid, bem, von_mises, write_subsurface
from fem_contact.response import BondedLayer, FrictionlessLayer, HalfSpace
from fem_contact.subsurface import default_depths, fields_below, planes_below, strongest_point
from fem_contact.surface import HeightField

SOFT, HARD = Solid(young=1.0, poisson=0.3), Solid(young=8.0, poisson=0.45)
RUBBER = Solid(young=2.0, poisson=0.5)
RESPONSES = {
    "half-space": HalfSpace(solid=SOFT),
    "incompressible": HalfSpace(solid=RUBBER),
    "bonded": BondedLayer(solid=SOFT, thickness=0.15),
    "bonded, incompressible": BondedLayer(solid=RUBBER, thickness=0.15),
    "frictionless": FrictionlessLayer(solid=HARD, thickness=0.15),
    "layered": LayeredSolid(layers=[SOFT, HARD], thicknesses=[0.08, 0.06], base=RUBBER),
    "exponential": ExponentialSolid(surface=SOFT, bulk_young=5.0, depth=0.1),
}
MESHED = (16, 15)


def pressed(response, *, lengths=(1.0, 1.5), scale=1.0):
    """Full contact with a few long waves, so that pressures are smooth; odd and even numbers of points."""
    x, y = (np.arange(n) / n for n in MESHED)
    waves = np.cos(2 * np.pi * x)[:, None] * (1 + 0.4 * np.sin(4 * np.pi * y + 0.3))[None, :]
    surface = HeightField(heights=1e-3 * waves * lengths[0], lengths=lengths)
    return bem.solve(surface, response, mean_pressure=scale).checked()


@pytest.fixture(scope="module", params=RESPONSES)
def body(request):
    response = RESPONSES[request.param]
    return response, pressed(response)


def test_a_layer_sinks_by_its_mean_compliance_and_stays_at_its_base():
    response = RESPONSES["bonded"]
    contact = pressed(response)
    top, base = planes_below(contact, response, depths=[0.0, 0.15])
    assert -top.displacement[..., 2].mean() == pytest.approx(contact.displacement.mean(), rel=1e-12)
    assert np.abs(base.displacement).max() < 1e-12 * np.abs(top.displacement).max()


def test_a_frictionless_base_bears_no_shear_and_does_not_move_down():
    response = RESPONSES["frictionless"]
    contact = pressed(response)
    top, base = planes_below(contact, response, depths=[0.0, 0.15])
    assert np.abs(base.displacement[..., 2]).max() < 1e-12 * np.abs(top.displacement).max()
    assert np.abs(base.stress[..., 3:5]).max() < 1e-12 * contact.pressure.max()
    assert np.abs(base.displacement[..., :2]).max() > 1e-4 * np.abs(top.displacement).max()


def test_stress_is_hookes_of_the_displacement(body):
    response, contact = body
    depth, step = 0.11, 1e-4
    fields = fields_below(contact, response, depths=depth + step * np.array([-1, 0, 1]))
    above, here, below = np.moveaxis(fields.displacement, 2, 0)
    sideways = [along(here, axis=axis, length=length) for axis, length in enumerate((1.0, 1.5))]
    gradient = np.stack([*sideways, (above - below) / (2 * step)], axis=-1)
    strain = (gradient + np.swapaxes(gradient, -1, -2)) / 2
    stress = fields.stress[:, :, 1]
    solid = solid_at(response, depth)
    xx, yy, zz, yz, xz, xy = np.moveaxis(stress, -1, 0)
    for axis, (own, others) in enumerate(((xx, yy + zz), (yy, xx + zz), (zz, xx + yy))):
        expected = (own - solid.poisson * others) / solid.young
        assert_allclose(strain[..., axis, axis], expected, atol=2e-4 * np.abs(strain).max())
    for (i, j), shear in (((1, 2), yz), ((0, 2), xz), ((0, 1), xy)):
        expected = shear / (2 * solid.shear_modulus)
        assert_allclose(strain[..., i, j], expected, atol=2e-4 * np.abs(strain).max())


def along(field, *, axis, length):
    n = field.shape[axis]
    q = 2j * np.pi / length * np.fft.fftfreq(n, 1 / n)
    if n % 2 == 0:
        q[n // 2] = 0
    shape = [1, 1, 1]
    shape[axis] = n
    return np.fft.ifft(np.fft.fft(field, axis=axis) * q.reshape(shape), axis=axis).real


def solid_at(response, depth):
    if isinstance(response, LayeredSolid):
        return HARD
    if isinstance(response, ExponentialSolid):
        return Solid(young=float(response.young(np.array(depth))), poisson=response.surface.poisson)
    return response.solid


def test_layers_of_one_solid_are_a_half_space():
    half = RESPONSES["half-space"]
    layered = LayeredSolid(layers=[SOFT] * 2, thicknesses=[0.1, 0.07], base=SOFT)
    contact, depths = pressed(half), [0.0, 0.05, 0.1, 0.15, 0.4]
    one, other = (fields_below(contact, response, depths=depths) for response in (half, layered))
    assert_allclose(other.stress, one.stress, atol=1e-12)
    assert_allclose(other.displacement, one.displacement, atol=1e-12)


def test_a_modulus_that_varies_continuously_is_the_limit_of_layers():
    varying = RESPONSES["exponential"]
    contact, errors = pressed(varying), []
    exact = fields_below(contact, replace(varying, sublayers=1024), depths=[0.03, 0.2]).stress
    for sublayers in (16, 32, 64):
        found = fields_below(contact, replace(varying, sublayers=sublayers), depths=[0.03, 0.2]).stress
        errors.append(np.abs(found - exact).max())
    # Second order, but for where the borders of the sublayers of a wave lie beside the depth.
    assert errors[0] > 10 * errors[2]
    assert errors[2] < 1e-6
    edges = np.linspace(0, 0.8, 161)
    middles = (edges[1:] + edges[:-1]) / 2
    layers = [Solid(young=float(young), poisson=0.3) for young in varying.young(middles)]
    base, thicknesses = Solid(young=5.0, poisson=0.3), list(np.diff(edges))
    layered = LayeredSolid(layers=layers, thicknesses=thicknesses, base=base)
    # Sideways stress jumps from layer to layer; what acts on a plane does not.
    by_layers = fields_below(contact, layered, depths=[0.03, 0.2]).stress
    assert_allclose(by_layers[..., 2:5], exact[..., 2:5], atol=3e-4)


def test_many_waves_of_a_graded_solid_go_through_a_spline():
    bulks = 3.0, 1.0 + 1e-12
    graded, half = (ExponentialSolid(surface=SOFT, bulk_young=bulk, depth=0.05) for bulk in bulks)
    rng = np.random.default_rng(7)
    contact = replace(pressed(HalfSpace(solid=SOFT)), pressure=rng.random((48, 40)))
    plain = fields_below(contact, HalfSpace(solid=SOFT), depths=[0.02, 0.1]).stress
    assert_allclose(fields_below(contact, half, depths=[0.02, 0.1]).stress, plain, atol=1e-8)
    assert np.abs(fields_below(contact, graded, depths=[0.02, 0.1]).stress - plain).max() > 0.01


def test_the_mean_pressure_compresses_without_sideways_strain():
    flat = replace(pressed(RESPONSES["half-space"]), pressure=np.full(MESHED, 3.0), mean_pressure=3.0)
    (plane,) = planes_below(flat, HalfSpace(solid=HARD), depths=[0.2])
    sideways = -3.0 * 0.45 / 0.55
    assert_allclose(plane.stress[4, 7], [sideways, sideways, -3, 0, 0, 0], atol=1e-12)
    confined = 8.0 * 0.55 / (1.45 * 0.1)
    assert_allclose(plane.displacement[..., 2], 3.0 * 0.2 / confined, rtol=1e-12)


def test_the_strongest_point_is_found_between_the_depths_given():
    response = RESPONSES["half-space"]
    contact = pressed(response)
    rough = strongest_point(contact, response, depths=[0.01, 0.1, 1.0])
    fine = strongest_point(contact, response)
    planes = planes_below(contact, response, depths=np.linspace(0.01, 1, 300))
    scan = max(plane.von_mises.max() for plane in planes)
    assert rough.depth == pytest.approx(fine.depth, rel=0.05)
    assert scan * (1 - 1e-9) <= fine.von_mises < scan * (1 + 1e-3)
    i, j = np.rint(np.array(fine.place) / contact.spacing).astype(int)
    (plane,) = planes_below(contact, response, depths=[fine.depth])
    assert plane.von_mises[i, j] == fine.von_mises


def test_default_depths_end_at_the_base_or_at_the_period():
    contact = pressed(RESPONSES["half-space"])
    half, bonded = (default_depths(contact, RESPONSES[name]) for name in ("half-space", "bonded"))
    assert (half[0], half[-1], bonded[-1]) == (0.0, pytest.approx(1.5), pytest.approx(0.15))
    assert np.all(np.diff(half) > 0)
    assert half[1] == pytest.approx(1 / 32)


def test_a_file_gives_back_the_fields_upside_up(tmp_path):
    response = RESPONSES["layered"]
    below = fields_below(pressed(response), response, depths=[0.0, 0.05, 0.3])
    write_subsurface(tmp_path / "below.vtu", below)
    mesh = meshio.read(tmp_path / "below.vtu")
    nodes = (17, 16, 3)
    points = mesh.points.reshape(*nodes, 3)
    assert_allclose(points[0, 0, :, 2], [-0.3, -0.05, 0.0])
    stress = mesh.point_data["stress"].reshape(*nodes, 6)
    assert_allclose(stress[:-1, :-1, ::-1], below.stress, rtol=1e-6, atol=1e-6)
    assert_array_equal(stress[-1, :-1], stress[0, :-1])
    corner = mesh.points[mesh.cells_dict["hexahedron"]]
    edges = np.stack([corner[:, k] - corner[:, 0] for k in (1, 3, 4)], axis=1)
    assert np.linalg.det(edges).min() > 0


def test_von_mises_of_known_states():
    assert von_mises([0, 0, 0, 0, 0, 2.0]) == pytest.approx(2 * np.sqrt(3))
    assert von_mises([5.0, 5.0, 5.0, 0, 0, 0]) == 0
