"""Cases at the ends of the theory's range: each ends converged, with a residual, or in a named refusal."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from persson import Scale, constant_hardness, contact_area, mean_separation, size_dependent_hardness
from persson.adhesion import AdhesionStatus, Interface, solve_adhesion
from persson.spectrum import SelfAffine
from persson.tabulated import Tabulated


@pytest.fixture(params=[(hurst, decades) for decades in (1, 10) for hurst in (0.0, 0.5, 1.0)])
def scale(request):
    """Of every Hurst exponent, and any number of decades."""
    hurst, decades = request.param
    rough = SelfAffine.from_rms_gradient(0.3, hurst=hurst, q_long=1e4, q_short=10.0 ** (4 + decades))
    return Scale(rough, contact_modulus=1.0)


@pytest.mark.parametrize("pressure", [0.0, 1e-3])
def test_adhesion_converges_for_every_hurst_exponent_and_any_number_of_decades(scale, pressure):
    result = solve_adhesion(scale, pressure=pressure, interface=Interface(work_of_adhesion=1e-7)).checked()
    assert result.status in (AdhesionStatus.CONVERGED, AdhesionStatus.NO_CONTACT)
    assert 0 <= result.real_area <= 1
    assert np.all(np.isfinite(result.work))
    if pressure > 0:
        plain = float(contact_area(pressure, stress_variance=0.3**2 / 4))
        assert result.real_area > plain * (1 - 1e-6)
        assert result.error_estimate < 0.01


def test_rising_hardness_converges_for_every_hurst_exponent_and_any_number_of_decades(scale):
    asked = {"wavevectors": np.geomspace(1.1e4, scale.spectrum.q_short, 7), "tolerance": 1e-5}
    hard = {"pressure": 0.01, "yield_stress": lambda k: 0.1 * (1 + k / 1e5) ** 0.05}
    result = size_dependent_hardness(scale, **hard, **asked).checked()
    carried = result.load_elastic + result.yield_stress * result.area_plastic
    assert carried == pytest.approx(np.full(7, 0.01), rel=1e-4)


def test_a_spectrum_over_forty_orders_of_magnitude_is_inverted():
    """C falls by 40 decades, f by 20: V(q) and its inverse agree to rounding of V."""
    q = np.geomspace(1.0, 1e10, 30)
    steep = Tabulated(wavevectors=q, power=q**-4.0)
    scale = Scale(steep, contact_modulus=1.0)
    waves = np.geomspace(1.01, 0.99e10, 50)
    assert scale.wavevector(scale.variance(waves)) == pytest.approx(waves, rel=1e-9)
    assert np.all(mean_separation([1e-6, 1e-3], scale=scale) > 0)


def test_tension_beyond_what_holds_leaves_no_contact():
    rough = SelfAffine.from_rms_gradient(0.05, hurst=0.8, q_long=1e4, q_short=1e7)
    scale, interface = Scale(rough, contact_modulus=1.0), Interface(work_of_adhesion=1e-6)
    free = solve_adhesion(scale, pressure=0.0, interface=interface).checked()
    assert free.real_area > 0.5
    assert solve_adhesion(scale, pressure=-0.2 * free.tensile_limit[0], interface=interface).real_area > 0
    lost = solve_adhesion(scale, pressure=-5 * free.tensile_limit[0], interface=interface)
    assert lost.status is AdhesionStatus.NO_CONTACT


@given(load=st.floats(1e-6, 0.99), v=st.floats(1e-4, 1e4))
@settings(max_examples=60)
def test_yielding_moves_contact_from_elastic_to_plastic_and_only_there_from_none(load, v):
    """A hardness lowers the elastic area and, since it limits stress, raises the whole contact."""
    areas = constant_hardness(load, stress_variance=v, yield_stress=1.0)
    plain = float(contact_area(load, stress_variance=v))
    assert areas.elastic <= plain * (1 + 1e-12)
    assert areas.elastic + areas.plastic >= plain * (1 - 1e-12)
