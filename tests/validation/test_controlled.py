"""The control variate: unbiased, with an interval that holds, and narrower than without."""

import numpy as np
import pytest

from validation.measurements.control_variates import Known, chained_mean, controlled_mean
from validation.measurements.ensemble import Chained
from validation.report.estimates import mean_of


def planted(rng, *, fine, others, correlation=0.99, slope=1.3):
    """Samples of a dear quantity of mean 7 and its cheap companion of another mean."""
    x = rng.gamma(4.0, 0.5, fine + others)
    noise = np.sqrt(1 / correlation**2 - 1) * slope
    y = 7 + slope * (x - 2.0) + noise * rng.normal(size=x.size)
    return y[:fine], x[:fine], Known.of_samples(x[fine:])


def plain_half_width(values):
    """Half of the 95 % interval of the mean without a control."""
    return float(mean_of(np.asarray(values), 0)[1])


@pytest.mark.parametrize(("fine", "others"), [(6, 40), (6, 1000)])
def test_ninety_five_of_a_hundred_intervals_hold_the_mean(fine, others):
    rng = np.random.default_rng(2026)
    trials = 3000
    found = (controlled_mean(*planted(rng, fine=fine, others=others)) for _ in range(trials))
    held = [abs(one.value - 7) <= one.half_width for one in found]
    # Three standard deviations of the share are 1.2 %.
    assert 0.94 - 0.005 < np.mean(held) < 0.975


def test_the_mean_is_unbiased_though_the_coefficient_is_fitted_on_few():
    rng = np.random.default_rng(11)
    drawn = (planted(rng, fine=5, others=30, correlation=0.8) for _ in range(4000))
    values = np.array([controlled_mean(*samples).value for samples in drawn])
    assert abs(values.mean() - 7) < 3.5 * values.std() / np.sqrt(values.size)


def test_a_good_control_narrows_the_interval_and_says_what_it_leaves():
    rng = np.random.default_rng(5)
    y, x, more = planted(rng, fine=4000, others=400_000)
    found = controlled_mean(y, x, more)
    assert found.left / y.var() == pytest.approx(1 - 0.99**2, rel=0.1)
    assert found.coefficients == pytest.approx([1.3], rel=0.01)
    share = 1 - 0.99**2 + 0.99**2 * 4000 / 400_000  # of the residuals, and of the mean of the others
    assert found.half_width / plain_half_width(y) == pytest.approx(share**0.5, rel=0.1)


def test_a_control_that_never_changes_leaves_the_plain_mean():
    y = np.array([1.0, 2.0, 3.0, 5.0])
    found = controlled_mean(y, np.full(4, 2.0), Known.of_samples(np.full(9, 2.0)))
    assert found.value == pytest.approx(y.mean())


@pytest.mark.parametrize(
    ("values", "controls", "known", "words"),
    [
        ([1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [1.0, 2.0], "needs 4"),
        ([1.0, 2.0, 3.0, np.nan], [1.0, 2.0, 3.0, 4.0], [1.0, 2.0], "finite"),
        (np.arange(4.0), np.arange(4.0), np.eye(3)[:, :2], "2 are known"),
        ([], [], [1.0], "needs 2"),
    ],
)
def test_too_few_or_broken_samples_are_refused(values, controls, known, words):
    with pytest.raises(ValueError, match=words):
        controlled_mean(values, controls, Known.of_samples(known))


def planted_chain(rng, *, counts, further, statistics=12):
    """Samples of a quantity of mean 7 on three grids; twelve statistics follow it, two of them alike."""
    weights = np.linspace(0.1, 0.4, statistics)

    def drawn(count):
        x = rng.normal(size=(count, statistics))
        x[:, 1] = x[:, 0] + 1e-3 * x[:, 1]
        coarse = 6 + x @ weights + 0.5 * rng.gamma(4.0, 0.5, count) - 1.0
        middle = 6.5 + 1.1 * (coarse - 6) + 0.2 * rng.normal(size=count)
        return x, coarse, middle, 7 + (middle - 6.5) + 0.05 * rng.normal(size=count)

    (x, coarse, _, _), (_, low, middle, _), (_, _, high, fine) = map(drawn, counts)
    levels = [(coarse, x), (middle, low), (fine, high)]
    return levels, Known.of_samples(drawn(further)[0])


@pytest.mark.parametrize("counts", [(40, 15, 4), (30, 6, 2)])
def test_the_intervals_of_a_chain_hold_and_its_mean_is_unbiased(counts):
    rng = np.random.default_rng(77)
    trials = 500
    found = [chained_mean(*planted_chain(rng, counts=counts, further=800))[-1] for _ in range(trials)]
    values = np.array([one.value for one in found])
    assert abs(values.mean() - 7) < 3.5 * values.std() / np.sqrt(trials)
    held = np.mean([abs(one.value - 7) <= one.half_width for one in found])
    # Three standard deviations of the share are 2.9 %.
    assert 0.95 - 0.029 < held < 0.985


def test_many_statistics_that_follow_the_quantity_narrow_its_interval():
    rng = np.random.default_rng(78)
    (level, *_), known = planted_chain(rng, counts=(200, 15, 4), further=20_000)
    found = controlled_mean(*level, known)
    assert found.left == pytest.approx(0.25, rel=0.35)  # 0.5^2 times the variance 1 of the gamma law
    assert found.half_width < 0.6 * plain_half_width(level[0])


def test_few_samples_of_a_finer_grid_are_not_fitted():
    levels, known = planted_chain(np.random.default_rng(79), counts=(40, 15, 4), further=800)
    chain = chained_mean(levels, known)
    assert chain[-1].coefficients == pytest.approx([1.0], abs=0)
    assert chain[1].coefficients != pytest.approx([1.0], abs=1e-6)


@pytest.mark.parametrize("unit", [1.0, 3.0])
def test_what_a_chain_saves_is_the_time_of_as_many_single_surfaces_as_its_interval_needs(unit):
    rng = np.random.default_rng(80)
    areas = unit * (1 + 0.1 * rng.normal(size=(1, 40)))
    chained = Chained(
        unsolved=rng.normal(size=(20, 2)),
        further=rng.normal(size=(400, 2)),
        unsolved_seconds=7.0,
        seconds=[np.full((40, 1), 2.0), np.full((8, 1), 5.0)],
    )
    chains = chained.chains(lambda last, _: areas[:, : (40, 8)[last]])
    relative = chains[0][-1].half_width / chains[0][-1].value
    surfaces = (1.96 * areas.std(ddof=1) / areas.mean() / relative) ** 2
    assert chained.savings(chains, areas) == pytest.approx(surfaces * 5 / (40 * 2 + 8 * 5 + 7), rel=1e-4)
