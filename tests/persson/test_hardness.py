"""Elastoplastic contact.

Closed form against the diffusion solver, limits, and the published figure of polished steel.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from persson import Scale, SelfAffine, constant_hardness, contact_area, size_dependent_hardness


@given(x=st.floats(1e-12, 1 - 1e-9), v=st.floats(1e-4, 5))
@settings(max_examples=80)
def test_areas_and_load_are_conserved(x, v):
    areas = constant_hardness(x, stress_variance=v, yield_stress=1.0)
    assert areas.elastic + areas.plastic + areas.detached == pytest.approx(1, abs=1e-14)
    assert 0 <= areas.plastic <= x * (1 + 1e-12)


@pytest.mark.parametrize("x", [1e-9, 0.2, 0.7, 1 - 1e-9])
def test_images_and_eigenfunctions_meet(x):
    variances = 0.35 * (1 - 1e-15), 0.35 * (1 + 1e-15)
    below, above = (constant_hardness(x, stress_variance=v, yield_stress=1.0) for v in variances)
    assert below.elastic == pytest.approx(float(above.elastic), rel=1e-12)
    assert below.plastic == pytest.approx(float(above.plastic), rel=1e-12)
    assert below.detached == pytest.approx(float(above.detached), rel=1e-12)


def test_infinite_hardness_is_the_elastic_solid_and_great_roughness_yields_everywhere():
    variance = np.array([1e-3, 1.0, 50.0])
    areas = constant_hardness(1.0, stress_variance=variance, yield_stress=1e6)
    assert areas.elastic == pytest.approx(contact_area(1.0, stress_variance=variance), rel=1e-12)
    assert np.all(areas.plastic < 1e-300)
    late = constant_hardness(1.0, stress_variance=1e9, yield_stress=3.0)
    assert (late.plastic, late.elastic) == (1 / 3, 0)


def test_polished_steel_has_yielded_by_79_percent_at_magnification_ten():
    """Persson 2006, Sec. 6, where q0 is not stated: here 1e5 1/m, with h_rms = 0.1 um and H = 0.8."""
    steel = SelfAffine.from_rms_height(1e-7, hurst=0.8, q_long=1e5, q_short=1e10)
    variance = (1e11 / (1 - 0.09) / 2) ** 2 * steel.m2(1e6)
    areas = constant_hardness(10e6, stress_variance=variance, yield_stress=2e9)
    assert areas.plastic * 2e9 / 10e6 == pytest.approx(0.78996, abs=5e-6)


def test_size_dependent_hardness_reduces_to_the_constant_one():
    steel = SelfAffine.from_rms_height(1e-7, hurst=0.8, q_long=1e5, q_short=1e8)
    scale = Scale(steel, contact_modulus=1e11)
    q = np.geomspace(1.2e5, 1e8, 9)
    asked = {"yield_stress": lambda k: np.full(np.shape(k), 2e9), "wavevectors": q}
    moving = size_dependent_hardness(scale, pressure=1e7, **asked).checked()
    still = constant_hardness(1e7, stress_variance=scale.variance(q), yield_stress=2e9)
    # The tolerance is relative to the contact area, which starts at 1.
    assert moving.area_plastic == pytest.approx(still.plastic, abs=1e-6 * moving.area.max())


@pytest.mark.parametrize("graded", [False, True])
def test_scale_inverts_itself(graded):
    rough = SelfAffine.from_rms_height(1e-7, hurst=0.8, q_long=1e5, q_short=1e9)
    scale = Scale(rough, contact_modulus=(lambda q: 1e9 * (1 + 1e6 / q)) if graded else 1e9)
    q = np.geomspace(1.001e5, 0.999e9, 40)
    assert scale.wavevector(scale.variance(q)) == pytest.approx(q, rel=1e-5)
    if graded:
        constant = Scale(rough, contact_modulus=lambda k: np.full(np.shape(k), 1e9))
        plain = Scale(rough, contact_modulus=1e9)
        assert constant.variance(q) == pytest.approx(plain.variance(q), rel=1e-12)
