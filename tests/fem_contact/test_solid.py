"""Elastic constants and the half-space they give."""

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fem_contact import Solid, composite_modulus

moduli = st.floats(1e-3, 1e13)
ratios = st.floats(-1, 0.5, exclude_min=True)


def test_contact_and_shear_modulus_of_rubber():
    rubber = Solid(young=3e6, poisson=0.5)
    assert rubber.contact_modulus == 4e6
    assert rubber.shear_modulus == 1e6


@given(moduli, st.floats(-0.99, 0.5))
def test_plane_strain_modulus_is_twice_shear_over_one_minus_poisson(young, poisson):
    solid = Solid(young=young, poisson=poisson)
    assert solid.contact_modulus == pytest.approx(2 * solid.shear_modulus / (1 - poisson), rel=1e-12)


@given(moduli, ratios, moduli, ratios)
def test_the_composite_is_symmetric_and_softer_than_either(young, poisson, other_young, other_poisson):
    first, second = Solid(young=young, poisson=poisson), Solid(young=other_young, poisson=other_poisson)
    composite, softer = composite_modulus(first, second), min(first.contact_modulus, second.contact_modulus)
    assert composite == composite_modulus(second, first)
    # three divisions and a sum round by half an ulp each
    assert 0.5 * (1 - 1e-15) <= composite / softer <= 1 + 1e-15


def test_against_a_body_a_million_times_stiffer_the_composite_is_the_softer_body():
    rubber, steel = Solid(young=1e6, poisson=0.5), Solid(young=1e12, poisson=0.3)
    assert composite_modulus(rubber, steel) == pytest.approx(rubber.contact_modulus, rel=2e-6)


def test_a_solid_cannot_be_changed():
    with pytest.raises(dataclasses.FrozenInstanceError):
        Solid(young=1e9, poisson=0.3).young = 2e9  # type: ignore[misc]
