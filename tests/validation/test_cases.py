"""The cases with a known answer: quick ones pass, a wrong one fails loudly, more are found by being there.

``python tests/validation/test_cases.py`` writes gold/claims.json again, where a change is meant.
"""

import json
import time
from pathlib import Path

import numpy as np
import pytest
from gold import write_lines

from validation import cases
from validation.cases import Case, all_cases, below, chosen_cases, order, relative, run_cases, within
from validation.cases._closed_forms import HertzInPeriod, Westergaard
from validation.errors import UsageError

#: Finite-element cases take longer than the fast suite allows; `fem-contact validate` runs them.
SECONDS = [case for case in all_cases() if case.quick and "fem" not in case.name and "block" not in case.name]

#: Number, reference and tolerance of each check.
NUMBERS = Path(__file__).parent / "gold" / "claims.json"
#: Part of the tolerance by which a number may move. Between two instruction sets it was 0.3 % at most.
SHARE = 0.03
CHECKS = json.loads((Path(__file__).parents[1] / "mutants" / "checks.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("case", SECONDS, ids=lambda case: case.name)
def test_a_quick_case_passes(case):
    (verdict,) = run_cases([case])
    assert verdict.error is None, verdict.error
    assert verdict.passed, [check for check in verdict.checks if not check.passed]
    assert verdict.source
    # Each check that a fault of the catalogue breaks is asked, and no other.
    assert {check.quantity for check in verdict.checks} == CHECKS[case.name].keys()
    for check, (number, reference, tolerance) in _with_known(verdict):
        assert (check.computed, check.reference) == pytest.approx(
            (number, reference), rel=1e-9, abs=SHARE * tolerance
        ), check


def _with_known(verdict):
    """The checks of a case beside what is stored of them; their tolerances are those."""
    known = json.loads(NUMBERS.read_text(encoding="utf-8"))[verdict.case]
    assert {check.quantity for check in verdict.checks} == known.keys()
    for check in verdict.checks:
        assert check.tolerance == pytest.approx(known[check.quantity][2], rel=0.2), check
        yield check, known[check.quantity]


@pytest.mark.slow
@pytest.mark.parametrize(
    "case", [c for c in all_cases() if c.name not in {s.name for s in SECONDS}], ids=lambda case: case.name
)
def test_a_long_case_passes(case):
    (verdict,) = run_cases([case])
    assert verdict.passed, (verdict.error, [check for check in verdict.checks if not check.passed])
    assert list(_with_known(verdict))


def test_names_are_unique_and_claims_are_sentences():
    names = [case.name for case in all_cases()]
    assert len(set(names)) == len(names)
    for case in all_cases():
        assert case.claim.endswith(".")
        assert case.tolerance in cases.TOLERANCES
    for topic in ("hertz", "westergaard", "full-contact", "against-bem", "units", "theory"):
        assert chosen_cases([topic], quick=False), topic


def test_a_case_is_chosen_by_name_or_by_the_beginning_of_its_name():
    names = {f"hertz{part}-{solver}" for part in ("", "-radius") for solver in ("bem", "fem", "reduced")}
    assert {case.name for case in chosen_cases(["hertz"], quick=True)} == names
    with pytest.raises(UsageError, match=r"case 'hert': no such case; did you mean 'hertz'"):
        chosen_cases(["hert"], quick=False)
    with pytest.raises(UsageError, match="case 'bem-grids': is called nested-grids-bem now"):
        chosen_cases(["bem-grids"], quick=False)


@pytest.mark.parametrize(
    ("check", "passed"),
    [
        (relative("x", 1.0, 1.01, 0.01), True),
        (relative("x", 1.0, 1.02, 0.01), False),
        (below("x", 0.5, 0.5), True),
        (below("x", -0.6, 0.5), False),
        (within("x", 1.5, 0.5, 1.5), True),
        (within("x", float("nan"), 0.0, 1.0), False),
        (below("x", float("inf"), float("inf")), False),
    ],
)
def test_a_check_passes_within_its_tolerance_and_never_on_nan(check, passed):
    assert check.passed is passed


def test_errors_of_which_one_is_none_have_no_order():
    falling = order("x", [1, 2, 4], [0.16, 0.04, 0.01], expected=2.0, tolerance=0.01)
    assert (falling.passed, falling.computed) == (True, pytest.approx(2.0))
    for errors in ([0.16, 0.04, 0.0], [0.16, 0.04, -0.01]):
        found = order("x", [1, 2, 4], errors, expected=2.0, tolerance=0.01)
        assert np.isnan(found.computed)
        assert not found.passed


def test_a_case_that_raises_or_checks_nothing_has_failed_and_the_others_go_on():
    began, parts = time.monotonic(), (lambda: 1 / 0, list, lambda: [below("x", 0.0, 1.0)])
    found = list(run_cases([Case(name=run.__name__, claim="A.", run=run) for run in parts]))
    assert [verdict.passed for verdict in found] == [False, False, True]
    assert found[0].error == "ZeroDivisionError: division by zero"
    assert 0 < sum(verdict.seconds for verdict in found) <= time.monotonic() - began


def test_validate_exits_with_1_and_names_what_failed(monkeypatch, capsys):
    from validation.cli.commands import main

    wrong = Case(name="wrong", claim="Two is three.", run=lambda: [relative("two", 2.0, 3.0, 0.01)])
    right = Case(name="right", claim="Two is two.", run=lambda: [relative("two", 2.0, 2.0, 0.01)])
    monkeypatch.setattr(cases, "all_cases", lambda: (right, wrong))
    for arguments, code in ((["validate"], 1), (["validate", "right"], 0), (["validate", "--json"], 1)):
        monkeypatch.setattr("sys.argv", ["fem-contact", *arguments])
        with pytest.raises(SystemExit) as exit_:
            main()
        assert (exit_.value.code or 0) == code
        printed = capsys.readouterr()
        assert ("passed  right  (" in printed.err) == ("--json" not in arguments)
        if code:
            assert "1 of 2 cases failed: wrong" in printed.err
    assert [row["passed"] for row in json.loads(printed.out)] == [True, False]


def test_hertz_and_westergaard_carry_their_load():
    hertz = HertzInPeriod(radius=0.13, contact_modulus=7.0)
    pressure = hertz.pressure(hertz.distance(1500, (0.5, 0.5)))
    assert (np.mean(pressure), pressure.max()) == pytest.approx((hertz.load, hertz.peak), rel=1e-4)
    wave = Westergaard(amplitude=0.02, half_width=0.21, contact_modulus=3.0)
    x = (np.arange(200_000) + 0.5) / 200_000 - 0.5
    assert np.mean(wave.pressure(x)) == pytest.approx(wave.load, rel=1e-6)
    flat = Westergaard(amplitude=0.02, half_width=0.5, contact_modulus=3.0)
    assert flat.load == pytest.approx(0.06 * np.pi)


if __name__ == "__main__":
    found = {
        one.case: {check.quantity: [check.computed, check.reference, check.tolerance] for check in one.checks}
        for one in run_cases(all_cases())
    }
    write_lines(NUMBERS, found)
