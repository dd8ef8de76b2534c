"""Numbers with their error: the interval is that of the samples, and pairs count once."""

from __future__ import annotations

import numpy as np
import pytest

from validation.measures.statistics import combined, mean_over_surfaces, order_of_convergence, pair_means


def test_the_interval_of_a_mean_is_that_of_student():
    # From the first paper on it, Student, Biometrika 6 (1908): hours of sleep that ten patients gained, mean
    # 1.58, standard deviation 1.23; t of nine degrees of freedom is 2.262.
    sleep = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4]
    estimate = mean_over_surfaces(sleep)
    assert estimate.value == pytest.approx(1.58, abs=1e-12)
    assert estimate.standard_error == pytest.approx(1.23 / np.sqrt(10), rel=1e-3)
    assert estimate.half_width == pytest.approx(2.262 * estimate.standard_error, rel=1e-4)
    assert estimate.samples == 10


def test_an_interval_depends_on_the_samples_alone_and_in_no_order():
    values = np.random.default_rng(3).normal(2.0, 0.5, 8)
    first, second = mean_over_surfaces(values), mean_over_surfaces(values[::-1])
    assert first.half_width == pytest.approx(second.half_width, rel=1e-14)
    # Twice as many of the same samples know the mean better by the root of two, but for what n - 1 does.
    twice = mean_over_surfaces(np.tile(values, 2))
    assert twice.standard_error == pytest.approx(first.standard_error * np.sqrt(7 / 15), rel=1e-12)


def test_intervals_of_95_percent_hold_the_mean_in_95_percent_of_trials():
    rng = np.random.default_rng(17)
    held = 0
    for _ in range(400):
        estimate = mean_over_surfaces(rng.normal(0.0, 1.0, 8))
        held += abs(estimate.value) <= estimate.half_width
    # Binomial: 380 +- 4.4; four standard deviations either way.
    assert 362 <= held <= 397


def test_anti_correlated_pairs_gain_by_being_averaged_first():
    rng = np.random.default_rng(5)
    common, own = rng.normal(0, 1, 200), rng.normal(0, 0.3, (200, 2))
    values = (np.stack([common, -common], axis=1) + own).ravel()
    assert (
        mean_over_surfaces(pair_means(values)).standard_error
        < 0.3 * mean_over_surfaces(values).standard_error
    )


def test_one_surface_has_no_scatter_and_no_interval():
    alone = mean_over_surfaces([1.0])
    assert (alone.value, alone.samples) == (1.0, 1)
    assert np.isnan(alone.standard_error)
    assert np.isnan(alone.half_width)
    with pytest.raises(ValueError, match="at least one surface"):
        mean_over_surfaces([])


def test_an_odd_number_makes_no_pairs():
    with pytest.raises(ValueError, match="pairs need an even number"):
        pair_means([1.0, 2.0, 3.0])


def test_errors_add_in_squares_and_orders_are_slopes():
    assert combined(0.3, 0.4) == pytest.approx(0.5)
    assert order_of_convergence([1.0, 0.5, 0.25], [-8.0, -2.0, -0.5]) == pytest.approx(2.0)
