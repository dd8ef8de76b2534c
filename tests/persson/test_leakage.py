"""The effective medium."""

import numpy as np
import pytest

from persson import effective_medium


def test_a_mixture_of_two_solves_its_quadratic():
    # w (a - K)/(a + K) + (1 - w) (b - K)/(b + K) = 0
    a, b, w = 3.0, 0.2, 0.7
    c = (2 * w - 1) * (a - b)
    exact = (c + np.sqrt(c * c + 4 * a * b)) / 2
    assert effective_medium([a, b], [w, 1 - w]) == pytest.approx(exact, rel=1e-12)


def test_conductance_vanishes_linearly_where_half_of_the_area_is_closed():
    values = [effective_medium([0.0, 1.0], [1 - w, w]) for w in (0.5, 0.55, 0.6, 1.0)]
    assert values == pytest.approx([0.0, 0.1, 0.2, 1.0], abs=1e-12)


def test_resistance_and_conductance_are_treated_alike():
    k = np.random.default_rng(4).lognormal(0, 2, 50)
    w = np.full(50, 1 / 50)
    assert effective_medium(1 / k, w) == pytest.approx(1 / effective_medium(k, w), rel=1e-10)
