"""Numbers with their error: the interval is that of the samples, and pairs count once."""

import numpy as np
import pytest

from validation.measurements.statistics import finest_error, order_of_convergence, pair_means
from validation.report.estimates import mean_of


def estimated(values, **how):
    """Mean and half of its 95 % interval, of samples along the last axis."""
    array = np.asarray(values)
    return mean_of(array, -1, **how)


def test_the_interval_of_a_mean_is_that_of_student():
    # From the first paper on it, Student, Biometrika 6 (1908): hours of sleep that ten patients gained, mean
    # 1.58, standard deviation 1.23; t of nine degrees of freedom is 2.262.
    sleep = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4]
    middle, half = estimated(sleep)
    assert float(middle) == pytest.approx(1.58, abs=1e-12)
    assert float(half) == pytest.approx(2.262 * 1.23 / np.sqrt(10), rel=1e-3)


def test_anti_correlated_pairs_gain_by_being_averaged_first():
    rng = np.random.default_rng(5)
    common, own = rng.normal(0, 1, 200), rng.normal(0, 0.3, (200, 2))
    values = (np.stack([common, -common], axis=1) + own).ravel()
    (middle, half), (plain, wide) = estimated(values, pairs=True), estimated(values)
    assert float(half) < 0.3 * float(wide)
    assert float(middle) == pytest.approx(float(plain), abs=1e-14)
    np.testing.assert_allclose(estimated(pair_means(values)), (middle, half), rtol=1e-12)


@pytest.mark.parametrize("spacing", [(2, 1), (1.5, 1), (4, 2, 1), (2, 1.5, 1), (8, 4, 2, 1)], ids=str)
@pytest.mark.parametrize("power", [1.0, 1.5])
def test_the_interval_of_the_finest_grid_holds_what_was_planted_on_grids_that_err_anew(spacing, power):
    rng, dx = np.random.default_rng(6), np.array(spacing, dtype=float)
    values = 7.0 + rng.normal(0, dx**power, (10_000, dx.size))
    held = np.mean([abs(v[-1] - 7.0) <= finest_error(v, dx, power=power) for v in values])
    # Distances hold what the finest is off by, too, which widens those of close grids.
    assert 0.943 < held < 0.985


def test_one_grid_and_what_is_endless_on_one_have_no_interval():
    assert np.isnan(finest_error([1.0], [0.5]))
    assert np.isnan(finest_error([np.inf, 1.0], [1.0, 0.5]))
    assert np.isnan(finest_error([np.inf, np.inf], [1.0, 0.5]))


def test_one_surface_has_no_scatter_and_no_interval():
    middle, half = estimated([1.0])
    assert float(middle) == 1.0
    assert np.isnan(half)


def test_an_odd_number_makes_no_pairs():
    with pytest.raises(ValueError, match="pairs need an even number"):
        pair_means([1.0, 2.0, 3.0])


def test_orders_are_slopes():
    assert order_of_convergence([1.0, 0.5, 0.25], [-8.0, -2.0, -0.5]) == pytest.approx(2.0)
