"""Numbers with their error: the interval is that of the samples, and pairs count once."""

from __future__ import annotations

import numpy as np
import pytest

from validation.measures.statistics import combined, mean_over_surfaces, order_of_convergence, pair_means


def test_the_standard_error_is_that_of_the_mean():
    values = np.random.default_rng(3).normal(2.0, 0.5, 40)
    estimate = mean_over_surfaces(values, resamples=20000)
    assert estimate.value == pytest.approx(values.mean(), rel=1e-12)
    # 20000 resamples know a standard deviation to half a percent; 3 % is six of those.
    assert estimate.standard_error == pytest.approx(values.std(ddof=1) / np.sqrt(40), rel=0.03)


def test_intervals_of_95_percent_hold_the_mean_in_95_percent_of_trials():
    rng = np.random.default_rng(17)
    held = 0
    for _ in range(400):
        estimate = mean_over_surfaces(rng.normal(0.0, 1.0, 8), resamples=400)
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


def test_one_surface_has_no_scatter():
    with pytest.raises(ValueError, match="at least two surfaces"):
        mean_over_surfaces([1.0])


def test_an_odd_number_makes_no_pairs():
    with pytest.raises(ValueError, match="pairs need an even number"):
        pair_means([1.0, 2.0, 3.0])


def test_errors_add_in_squares_and_orders_are_slopes():
    assert combined(0.3, 0.4) == pytest.approx(0.5)
    assert order_of_convergence([1.0, 0.5, 0.25], [-8.0, -2.0, -0.5]) == pytest.approx(2.0)
