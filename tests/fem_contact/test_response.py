"""Compliances of the elastic solids."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from surfaces import rough_surface

from fem_contact import BondedLayer, FrictionlessLayer, GivenResponse, HalfSpace, Response, Solid, bem


def test_half_space_compliance_is_two_over_modulus_and_wavevector():
    response = HalfSpace(solid=Solid(young=2.0, poisson=0.5))
    assert isinstance(response, Response)
    qx, qy = np.array([0.0, 3.0])[:, None], np.array([0.0, 4.0])[None, :]
    expected = 2 / (2.0 / 0.75 * np.array([[np.inf, 4.0], [3.0, 5.0]]))
    assert_allclose(response.compliance(qx, qy), expected, rtol=1e-15)


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.49, 0.5])
@pytest.mark.parametrize("layer", [BondedLayer, FrictionlessLayer])
def test_thick_layer_is_a_half_space_but_for_its_mean(layer, poisson):
    solid = Solid(young=3.0, poisson=poisson)
    q = np.array([2.0, 5.0, 1e4])
    thick = layer(solid=solid, thickness=20.0).compliance(q, 0 * q)
    assert_allclose(thick, HalfSpace(solid=solid).compliance(q, 0 * q), rtol=1e-12)
    mean = layer(solid=solid, thickness=20.0).compliance(np.zeros(1), np.zeros(1))
    expected = 20.0 * (1 + poisson) * (1 - 2 * poisson) / (3.0 * (1 - poisson))
    assert_allclose(mean, expected, atol=1e-15)


def test_thin_layers_are_beds_of_springs_of_their_own_moduli():
    solid, q = Solid(young=2.0, poisson=0.3), np.array([1e-3])
    sliding, bonded = (layer(solid=solid, thickness=1.0) for layer in (FrictionlessLayer, BondedLayer))
    assert_allclose(sliding.compliance(q, 0 * q), 1 / solid.contact_modulus, rtol=1e-5)
    assert_allclose(bonded.compliance(q, 0 * q), 1.3 * 0.4 / (2.0 * 0.7), rtol=1e-5)


def test_thin_incompressible_bonded_layer_yields_with_the_cube_of_its_thickness():
    solid = Solid(young=1.0, poisson=0.5)
    q = np.array([1e-6, 1e-4, 1e-2])
    thin = BondedLayer(solid=solid, thickness=1.0).compliance(q, 0 * q)
    # C = q^2 d^3 / (3 G), the lubrication limit, with G = E/3.
    assert_allclose(thin, q**2, rtol=2e-4)


def test_one_number_is_the_compliance_of_all_waves():
    functions = lambda qx, qy: 0.1, lambda qx, qy: 0.1 + 0 * qx * qy
    one, many = (GivenResponse(contact_modulus=1.0, function=function) for function in functions)
    surface = rough_surface((16, 12), seed=3, waves=4)
    found, expected = (bem.solve(surface, body, mean_pressure=1e-3).checked() for body in (one, many))
    assert_array_equal(found.pressure, expected.pressure)


def test_given_response_is_used_as_given():
    given = GivenResponse(contact_modulus=2.0, function=lambda qx, qy: 1 / (1 + qx**2 + 2 * qy**2))
    assert isinstance(given, Response)
    assert_allclose(given.compliance(np.ones((2, 1)), np.ones((1, 3))), np.full((2, 3), 0.25))
