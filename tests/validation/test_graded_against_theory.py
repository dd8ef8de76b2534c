"""The modulus a wave feels, Persson's weighting against the exact response of the graded half-space."""

import numpy as np
import pytest

from fem_contact import ExponentialSolid, Solid
from persson import ExponentialLayers

POISSON = 0.3


def compared(q, ratio):
    """Felt modulus by the theory over the exact one, and the largest E'/(E q) of the profile."""
    exact = ExponentialSolid(
        surface=Solid(young=1.0, poisson=POISSON), bulk_young=ratio, depth=1.0, sublayers=256
    )
    felt = 2 / (q * exact.compliance(q, np.zeros_like(q)))
    theory = ExponentialLayers(bulk=ratio, excess=[1 - ratio], depths=[1.0], poisson=POISSON)
    depth = np.linspace(0, 5, 500)
    young = exact.young(depth)
    slope = np.abs(np.gradient(young, depth)) / young
    return theory(q) / felt, np.max(slope) / q


@pytest.mark.parametrize(("ratio", "found"), [(2.0, -0.036), (0.5, 0.113)])
def test_where_the_profile_changes_little_over_a_wave_the_weighting_errs_by_four_and_eleven_percent(
    ratio, found
):
    # The range the theory claims is max E'/(E q) < 1. Waves as long as the profile is deep feel a modulus
    # that is taken 4 % too soft when the bulk is twice as stiff as the surface, 11 % too stiff if it is half.
    share, grading = compared(np.geomspace(0.2, 100, 25), ratio)
    inside = grading < 1
    assert inside.sum() > 10
    error = share[inside] - 1
    assert error[np.argmax(np.abs(error))] == pytest.approx(found, abs=0.004)


def test_the_error_vanishes_where_the_profile_is_slow_and_grows_with_the_contrast():
    mild, grading = compared(np.array([1.0, 10.0, 100.0]), 2.0)
    assert abs(mild[2] - 1) < abs(mild[1] - 1)
    assert abs(mild[2] - 1) < 1e-2
    assert grading[2] < 0.02
    strong, _ = compared(np.array([10.0]), 100.0)
    assert abs(strong[0] - 1) > abs(mild[1] - 1)
