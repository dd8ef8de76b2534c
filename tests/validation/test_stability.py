"""The study of hard cases: what it calls right, refused and wrong, and that nothing is wrong."""

import itertools
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from fem_contact import InvalidInput, Status
from validation.errors import UsageError
from validation.execution.bench import Bench
from validation.execution.store import Store
from validation.measurements import hard_cases
from validation.measurements.hard_cases import HardCase, Measured
from validation.studies import find_study, stability

#: Cases of a second or less; the others run with the slow tests.
QUICK = ("load", "gradient", "hurst", "ties", "precision", "hardness", "contrast", "depth", "single")


class Idle(Bench):
    """A bench that must not be asked for a solve."""

    def solve(self, solves):
        raise AssertionError("the study of hard cases runs no solve of the bench")


def turned(**options):
    return stability.run(stability.Options(**options), bench=Idle(store=Store(folder=Path("nowhere"))))


def outcomes(data):
    return data["outcome"].values


def check(data):
    wrong = data.isel(row=outcomes(data) == "WRONG")
    assert wrong.sizes["row"] == 0, list(zip(wrong["case"].values, wrong["value"].values, strict=True))
    right = data.isel(row=outcomes(data) == "right")
    assert np.all(right["deviation"].values <= right["bound"].values)
    refused = data.isel(row=outcomes(data) == "refused")
    assert all(": must" in words or "need" in words for words in refused["message"].values)


@pytest.mark.parametrize("name", QUICK)
def test_no_quick_case_gives_a_silent_wrong_number(name):
    check(turned(cases=(name,)))


@pytest.mark.parametrize("case", [c for c in stability.CASES if c.name not in QUICK], ids=lambda c: c.name)
def test_no_other_case_is_wrong_where_it_is_easy(case):
    # The easiest value of all asks too little: a sphere that hardly sticks does not tell its law.
    assert case.measure(case.values[1]).error <= case.bound


@pytest.mark.slow
def test_no_case_gives_a_silent_wrong_number():
    check(turned())


@pytest.mark.parametrize("method", ["bem", "fem"])
def test_the_cases_of_a_method_are_its_own(method):
    assert {case.method for case in stability.Options(methods=(method,)).chosen} == {method}


def test_every_method_has_a_hard_case_and_each_says_what_is_right_beforehand():
    assert {case.method for case in stability.CASES} == {"bem", "fem", "theory"}
    assert all(case.reference and case.bound > 0 and len(case.values) > 4 for case in stability.CASES)
    assert len({case.name for case in stability.CASES}) == len(stability.CASES)
    assert all(a != b for case in stability.CASES for a, b in itertools.pairwise(case.values))


def fake(measure, *, refusable=()):
    told = {"name": "fake", "method": "bem", "varied": "nothing", "reference": "nothing"}
    return HardCase(**told, values=(1.0,), bound=0.1, measure=measure, refusable=refusable)


def refusing(value):
    raise InvalidInput("value: must be another")


def crashing(value):
    raise ZeroDivisionError("division by zero")


@pytest.mark.parametrize(
    ("case", "outcome"),
    [
        (fake(lambda value: Measured(error=0.05)), "right"),
        (fake(lambda value: Measured(error=0.2)), "WRONG"),
        (fake(lambda value: Measured(error=math.nan)), "WRONG"),
        (fake(lambda value: Measured(error=9.0, status=Status.STAGNATED)), "not converged"),
        (fake(refusing), "WRONG"),
        (fake(refusing, refusable=(1.0,)), "refused"),
        (fake(crashing, refusable=(1.0,)), "WRONG"),
    ],
)
def test_an_outcome_is_right_only_for_a_small_error_of_a_converged_solve(monkeypatch, case, outcome):
    monkeypatch.setattr(stability, "CASES", (case,))
    data = turned(methods=("bem",))
    assert data.attrs["methods"] == "bem"
    np.testing.assert_array_equal(np.ravel(data.residual), math.nan)  # none was told
    assert list(outcomes(data)) == [outcome]
    first, *others = stability.views(data).findings
    assert first.values["wrong"].value == (outcome == "WRONG")
    # The largest deviation is that of the right ones: .05 of .1.
    (worst,) = [one.values["worst"].value for one in others if "worst" in one.values]
    np.testing.assert_allclose(worst, 0.5 if outcome == "right" else math.nan)


def test_an_offset_that_moves_by_twice_what_rounding_can_is_twice_too_far():
    pressed = []

    def press(field, _):
        pressed.append(field.heights)
        offset = 2 * np.max(np.abs(pressed[-1] - pressed[0]))
        return SimpleNamespace(offset=offset, status=Status.CONVERGED, residuals=SimpleNamespace(worst=0.0))

    assert hard_cases._few_bits(press, 8.0).error == pytest.approx(2.0, rel=0.01)


@pytest.mark.parametrize("ended", [Status.CONVERGED, Status.STAGNATED])
def test_a_path_is_as_good_as_the_worst_of_its_solves(monkeypatch, ended):
    def found(worst, status=Status.CONVERGED):
        residuals = SimpleNamespace(worst=worst)
        return SimpleNamespace(pressure=np.ones((4, 2)), status=status, residuals=residuals)

    path = [found(1e-9), found(2e-9, ended), found(3e-9)]
    monkeypatch.setattr(hard_cases.bem, "solve_path", lambda *_, **__: path)
    measured = hard_cases._path(10.0)
    assert (measured.status, measured.residual) == (ended, 3e-9 if ended is Status.CONVERGED else 2e-9)


def test_a_hang_is_wrong(monkeypatch):
    monkeypatch.setattr(stability, "CASES", (fake(lambda value: Measured(error=0.0)),))
    assert list(outcomes(turned(slowest=0.0))) == ["WRONG"]


def test_the_study_is_found_by_name_with_its_options_and_draws_every_case():
    study = find_study("stability")
    assert set(study.options.flags()) == {"--methods", "--cases", "--slowest"}
    data = turned(cases=("hardness", "ties"))
    (drawing,) = study.figures(data)
    assert [one.label for one in drawing.drawn] == ["hardness", "ties", "allowed"]
    refused = data.isel(row=(data.outcome == "refused").values)
    assert refused.value.values.tolist() == [0.99]
    assert str(refused.message.values[0]).startswith("InvalidInput: pressure_bound")
    with pytest.raises(UsageError, match="no such case; one of: load"):
        study.parse(["--cases", "nonsense"])
