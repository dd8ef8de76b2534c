import time

import numpy as np
import pytest
from surfaces import SOFT

from fem_contact import Hardness, HeightField, NotConverged, Status, bem, press_yielding
from fem_contact.settings import Settings


def rough(n=48):
    return HeightField(heights=np.random.default_rng(29).standard_normal((n, n)), lengths=(1.0, 1.0))


def test_the_largest_tolerance_is_a_tenth():
    assert Settings(tolerance=0.1).tolerance == 0.1


def test_time_that_has_passed_is_no_longer_allowed():
    settings, began = Settings(time_limit=5.0), time.monotonic()
    assert settings.remaining(began - 2).time_limit == pytest.approx(3.0, abs=0.1)
    assert not settings.expired(began)
    assert settings.expired(began - 6)
    assert settings.remaining(began - 6).expired(began - 1)


@pytest.mark.parametrize("method", ["preconditioned", "double", "polonsky-keer"])
def test_an_elastic_solve_ends_at_its_time_limit_and_says_so(method):
    result = bem.solve(rough(), SOFT, mean_pressure=1.0, method=method, time_limit=1e-9)
    assert result.status is Status.TIME_LIMIT
    with pytest.raises(NotConverged, match="time limit"):
        result.checked()


def test_every_elastic_question_has_a_time_limit():
    surface, short = rough(), 1e-9
    assert bem.solve_displacement(surface, SOFT, mean_gap=0.5, time_limit=short).status is Status.TIME_LIMIT
    loads = bem.solve_path(surface, SOFT, mean_pressures=[0.5, 1.0], time_limit=short)
    assert [result.status for result in loads] == [Status.TIME_LIMIT] * 2
    hard = press_yielding(surface, SOFT, hardness=Hardness(pressure=9.0), mean_pressure=1.0, time_limit=short)
    assert hard.status is Status.TIME_LIMIT


def test_a_time_limit_that_is_not_reached_changes_no_bit():
    free = bem.solve(rough(), SOFT, mean_pressure=1.0, threads=1)
    timed = bem.solve(rough(), SOFT, mean_pressure=1.0, threads=1, time_limit=600.0)
    np.testing.assert_array_equal(free.pressure, timed.pressure)
