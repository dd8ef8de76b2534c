"""Scorecards: a right solver passes, a wrong one is caught, and its fault is named."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commanding import answer_of, invoke
from reading_back import misdrawn

from validation.cases import Verdict, below, run_cases
from validation.cases._result import _unique, claims_dataset, claims_page, claims_views
from validation.cases.scorecard import Subject, rows, score
from validation.execution.results import read_results
from validation.solvers import chosen_solver
from validation.solvers.base import Cost
from validation.solvers.bem import Bem


class Toy(Bem):
    """Boundary elements on small grids, of a modulus that may be wrong."""

    score_points = 16
    stiffness = 1.0

    def claim(self, job):
        solid = replace(job.model.solid, young=self.stiffness * job.model.solid.young)
        found = super().claim(replace(job, model=replace(job.model, solid=solid)))
        return replace(found, cost=replace(found.cost, cpu_seconds=1e-3))


def card_of(stiffness):
    solver = Toy()
    solver.stiffness = stiffness
    return score(Subject(name="toy", solver=solver, settings={}))


@pytest.fixture(scope="module")
def wrong():
    return card_of(2.0)


@pytest.fixture(scope="module")
def right():
    return card_of(1.0)


def test_a_right_solver_passes_every_row_and_no_fault_is_named(right):
    assert [(verdict.case, verdict.error) for verdict in right.failed] == []
    assert right.diagnosis == ""
    assert right.cost


def test_a_wrong_solver_beside_a_right_one_is_named_in_every_sentence(right, wrong):
    verdicts = [replace(verdict, solver="soft") for verdict in wrong.verdicts]
    views = claims_views(claims_dataset([*right.verdicts, *verdicts], [right, wrong]))
    assert views.cards[0].answer.text.startswith(f"no: {len(wrong.failed)} of ")
    assert views.cards[1].question == "What is wrong with soft?"
    assert views.cards[1].answer.text == wrong.diagnosis
    assert views.cards[2].basis.text.startswith("toy, one rough surface")
    assert all(one.text.startswith("soft: ") for one in views.findings[:-1])
    other = [replace(verdict, solver="b") for verdict in right.verdicts]
    alike = claims_views(claims_dataset([*right.verdicts, *other], [right] * 2))
    sentences = ["Every claim holds", "Nearest to its tolerance"]
    assert [one.text.partition(":")[0] for one in alike.findings] == sentences
    assert f"{2 * len(right.counted)} of them" in alike.findings[0].text


def test_what_is_wrong_stands_on_the_page_and_in_the_sentence(wrong):
    assert wrong.diagnosis == "the stiffness is 2 times that of E*"
    assert wrong.sentence.startswith(f"toy: {len(wrong.failed)} rows fail: ")
    assert wrong.sentence.endswith(f"; {wrong.diagnosis}")
    alone = replace(wrong, verdicts=wrong.failed[:1]).sentence
    assert alone.startswith(f"toy: 1 row fails: {wrong.failed[0].case}")
    views = claims_views(claims_dataset(wrong.verdicts, [wrong]))
    assert views.cards[0].answer.text.startswith("no: ")
    assert views.cards[1].answer.text == wrong.diagnosis
    assert {card.answer.kind for card in views.cards[:2]} == {"value"}
    counts = {row.case: sum(not check.passed for check in row.checks) for row in wrong.failed}
    for text in (one.text for one in views.findings if "FAILS" in one.text):
        count = counts[text.partition(" FAILS")[0]]
        assert (f"({count} numbers of it fail)" in text) == (count > 1)


def test_an_accuracy_costs_what_the_cheapest_grid_does_that_is_as_near_where_that_was_measured(right):
    for accuracy in (0.1, 0.01):
        near = [row.seconds for row in right.cost if row.area_miss <= accuracy]
        assert right.needed("seconds", accuracy) == min(near) > 0
    assert np.isnan(right.needed("seconds", 1e-12))
    unknown = replace(right, cost=tuple(replace(row, peak_bytes=0) for row in right.cost))
    assert np.isnan(unknown.needed("peak_bytes", 0.1))


def test_names_that_come_again_have_a_number_from_the_second_on():
    assert _unique(["p", "u", "p", "p"]) == ["p", "u", "p (2)", "p (3)"]


def test_the_worst_failure_stands_first(wrong):
    failures = [verdict.used for verdict in wrong.failed]
    assert failures == sorted(failures, reverse=True)
    flags = [verdict.passed for verdict in wrong.counted]
    assert flags == sorted(flags)


def test_a_nan_is_the_worst_failure_of_all():
    check = below("something", float("nan"), 1.0)
    verdict = Verdict(case="x", claim="", source="", checks=(check,), seconds=0.0)
    assert verdict.used == float("inf")
    assert not verdict.passed


def test_boundary_elements_are_scored_in_less_than_two_minutes_of_processor_time(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    began = time.process_time()
    (card,) = answer_of("validate --method bem --quick")["scorecards"]
    assert time.process_time() - began < 120
    assert card["passed"]
    result = read_results(tmp_path / "results" / "scorecard-bem")
    page = claims_page(result, figures=True)
    assert page.findings[0].startswith("Every claim holds: ")
    assert [problem for one in page.figures for problem in misdrawn(one, result.data)] == []
    titles = [axes.get_title() for one in page.figures for axes in one.figure.axes]
    assert len(set(titles)) == len(titles) > 3
    assert page.figures


def test_a_failing_solver_of_ones_own_exits_with_one_and_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    head = "import numpy as np\ndef solve(heights, lengths, *, contact_modulus, mean_pressure):\n"
    Path("flat_toy.py").write_text(f"{head}    return np.full(heights.shape, mean_pressure)\n")
    outcome = invoke("validate --method flat_toy:solve --quick --output card")
    assert outcome.exit_code == 1
    card = read_results(tmp_path / "card").data.isel(solver=0).verdict.to_series()
    failed, holds = (set(card.index[card == word]) for word in ("FAILS", "holds"))
    assert {"honesty", "hertz", "westergaard", "rough-4"} <= failed
    assert {"tension", "load", "symmetry", "units"} <= holds


def test_a_solver_that_crashes_fails_its_rows_and_the_others_go_on(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code = "import os\ndef solve(heights, lengths, *, contact_modulus, mean_pressure):\n    os.abort()\n"
    Path("dying_toy.py").write_text(code, encoding="utf-8")
    solver, settings = chosen_solver("dying_toy:solve")
    subject = Subject(name="dying", solver=solver, settings=settings)
    verdicts = rows_of(subject, {"tension", "hertz", "offset", "odd-axes"})
    assert "cannot be told" in verdicts.pop("offset").left_out
    assert all("crashed its process" in str(verdict.error) for verdict in verdicts.values())


class Deaf(Bem):
    """Boundary elements that do not hear a part of what they are told."""

    score_points = 16
    ignored = ""

    def claim(self, job):
        if self.ignored == "layer":
            job = replace(job, model=replace(job.model, response=None))
        if self.ignored == "hardness":
            job = replace(job, model=replace(job.model, pressure_bound=None))
        if self.ignored == "offset" and "offset" in job.load:
            job = replace(job, load={"offset": job.load["offset"] + 0.01 * job.field.rms_height})
        found = super().claim(job)
        return replace(found, converged=None) if self.ignored == "end" else found


def rows_of(subject, names):
    return {one.case: one for one in run_cases([row for row in rows(subject) if row.name in names])}


#: Rows that fail, by what is not heard.
UNHEARD = {"": set(), "layer": {"layer"}, "hardness": {"yielding-wave"}, "end": {"cut-short"}}


@pytest.mark.parametrize(("ignored", "fails"), {**UNHEARD, "offset": {"offset", "offset-near-full"}}.items())
def test_what_a_solver_is_told_beside_the_load_must_be_heard(ignored, fails):
    solver = Deaf()
    solver.ignored = ignored
    asked = {"layer", "yielding-wave", "offset", "offset-near-full", "cut-short"}
    verdicts = rows_of(Subject(name="deaf", solver=solver, settings={}), asked)
    assert {name for name, verdict in verdicts.items() if verdict.word != "holds"} == fails
    assert set(verdicts) == asked


class Hazy(Bem):
    """Boundary elements that leave pressures of no account where the gap is open."""

    score_points = 16

    def claim(self, job):
        found = super().claim(job)
        return replace(found, pressure=np.maximum(found.pressure, 1e-9 * found.pressure.max()))


def test_low_pressures_off_the_contact_do_not_pass_for_a_vanishing_start_of_the_distribution():
    names = {"stress-near-zero", "hertz", "westergaard"}
    verdicts = rows_of(Subject(name="hazy", solver=Hazy(), settings={}), names)
    assert {name for name, verdict in verdicts.items() if not verdict.passed} == {"stress-near-zero"}


def test_a_solver_that_never_returns_costs_its_budget_and_gets_a_card(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code = "def solve(heights, lengths, *, contact_modulus, mean_pressure):\n    while True:\n        pass\n"
    Path("endless_toy.py").write_text(code, encoding="utf-8")
    solver, settings = chosen_solver("endless_toy:solve")
    began = time.monotonic()
    card = score(Subject(name="endless", solver=solver, settings=settings, seconds=2.0))
    # A child process starts once for each call that was ended.
    assert time.monotonic() - began < 60
    # What a busy machine takes to end a call comes on top: no call begins once the budget is spent.
    *before, _ = (seconds for _, seconds in card.subject._costs)
    assert sum(before) < 2
    assert {"load", "tension", "honesty"} <= {verdict.case for verdict in card.failed}
    assert card.left_out["hertz"].startswith("not tried: ")
    assert card.diagnosis.startswith("it gives no answer: endless_toy:solve")


class Dear(Bem):
    """Boundary elements that say of every solve that it took a millisecond a point."""

    score_points = 16

    def cost(self, size):
        return Cost(pairs=float(size.points), peak_bytes=1, unknowns=1)

    def claim(self, job):
        found = super().claim(job)
        return replace(found, cost=replace(found.cost, cpu_seconds=1e-3 * found.pressure.size))


def test_what_would_take_too_long_is_not_tried_and_said_so():
    card = score(Subject(name="dear", solver=Dear(), settings={}, seconds=60.0))
    assert card.failed == ()
    assert {"tension", "full-contact", "honesty", "hertz"} <= {verdict.case for verdict in card.verdicts}
    assert card.left_out["rough-4"].startswith("not tried: 64 x 64 points would take some ")
    assert sum(seconds for _, seconds in card.subject._costs) <= 60.0
    assert set(claims_dataset(card.verdicts, [card]).verdict.values.ravel()) == {"holds", "not judged"}


def test_coarse_grids_that_the_time_allows_show_no_orders():
    card = score(Subject(name="dear", solver=Dear(), settings={}, seconds=15.0))
    assert card.subject.ladder == (16, 24, 32)
    assert "observed" in card.left_out["nested-grids"]
    checks = [check.quantity for verdict in card.verdicts for check in verdict.checks]
    assert not any(quantity.startswith("observed order") for quantity in checks)
