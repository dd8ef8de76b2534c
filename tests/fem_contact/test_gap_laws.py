import numpy as np
import pytest
from scipy.integrate import quad

from fem_contact.adhesion.laws import Dugdale, Exponential

LAWS = [Exponential(work=0.3, reach=0.7), *(Dugdale(work=0.3, reach=0.7, ramp=ramp) for ramp in (0.4, 2.0))]


@pytest.mark.parametrize("law", LAWS)
def test_pulling_rigid_surfaces_apart_takes_the_work_of_adhesion(law):
    kinks = [0.7 * (1 - law.ramp / 2), 0.7 * (1 + law.ramp / 2)] if isinstance(law, Dugdale) else None
    work, error = quad(lambda g: float(law.traction(np.array([g]))[0]), 0, 30, points=kinks, limit=200)
    assert work == pytest.approx(law.work, abs=10 * error + 1e-12)
    assert law.energy(np.zeros(1))[0] == pytest.approx(-law.work, rel=1e-15)


def test_a_dugdale_jump_has_the_same_work_as_any_ramp():
    sharp = Dugdale(work=0.3, reach=0.7)
    gap = np.array([0.0, 0.35, 0.6999, 0.7, 2.0])
    np.testing.assert_allclose(sharp.energy(gap), -0.3 * np.maximum(1 - gap / 0.7, 0), atol=1e-15)
    np.testing.assert_allclose(sharp.traction(gap), [0.3 / 0.7] * 3 + [0, 0], rtol=1e-15)


@pytest.mark.parametrize("law", LAWS)
def test_traction_and_slope_are_derivatives_of_the_energy_of_second_order(law):
    gap = np.linspace(0.011, 1.9, 57)
    errors = []
    for step in (1e-3, 5e-4):
        first = (law.energy(gap + step) - law.energy(gap - step)) / (2 * step) - law.traction(gap)
        second = (law.traction(gap + step) - law.traction(gap - step)) / (2 * step) - law.slope(gap)
        smooth = np.abs(second) < 1e-3  # away from the ends of a ramp, where the slope jumps
        errors.append((np.abs(first).max(), np.abs(second[smooth]).max()))
        assert smooth.sum() > 50
    assert errors[1][0] <= errors[0][0] / 3.9 + 1e-12
    assert errors[1][1] <= errors[0][1] / 3.9 + 1e-12


@pytest.mark.parametrize("law", LAWS)
def test_no_slope_is_steeper_than_the_steepest(law):
    assert np.max(-law.slope(np.linspace(0, 3, 1001))) <= law.steepest * (1 + 1e-12)


def test_the_ramp_a_grid_needs_shrinks_with_its_spacing():
    law = Dugdale(work=0.3, reach=0.7)
    ramps = [law.on_grid(spacing=dx, contact_modulus=2.0).ramp for dx in (0.2, 0.1, 0.05)]
    assert ramps == pytest.approx([ramps[0], ramps[0] / 2, ramps[0] / 4], rel=1e-12)
    wide = Dugdale(work=0.3, reach=0.7, ramp=1.5)
    assert wide.on_grid(spacing=0.1, contact_modulus=2.0).ramp == 1.5
    smooth = Exponential(work=0.3, reach=0.7)
    assert smooth.on_grid(spacing=0.1, contact_modulus=2.0) is smooth
