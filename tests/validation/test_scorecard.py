"""Scorecards: a right solver passes, a wrong one is caught, and its fault is named."""

import json
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from validation.cases import Check, Verdict, run_cases
from validation.cases._result import claims_dataset, claims_views
from validation.cases.scorecard import Scorecard, Subject, rows, score
from validation.cli import app
from validation.effects.base import Slots
from validation.methods import chosen_solver
from validation.methods.base import Claim, Cost, Solved
from validation.methods.bem import Bem
from validation.solves.results import read_results


class Toy(Bem):
    """Boundary elements whose answer is spoilt in one way."""

    name = "toy"
    score_points = 16
    controls = frozenset()
    fault = ""

    def solve(self, job) -> Solved:
        slots = job.slots
        if self.fault == "factor":
            slots = Slots(solid=replace(slots.solid, young=2 * slots.solid.young))
        return super().solve(replace(job, slots=slots, settings=self.told(job.settings)))

    def told(self, settings):
        # So loose a tolerance is refused by nobody, and met after a few steps.
        return {"tolerance": 3e-3} if self.fault == "honesty" else {"tolerance": settings["tolerance"]}

    def claim(self, job) -> Claim:
        field, slots = job.field, job.slots
        mean_pressure, claim = job.mean_pressure, Claim.of(self.solve(job).contact)
        pressure, mask = claim.pressure, claim.in_contact
        if self.fault == "tension":
            q = np.hypot(
                *np.meshgrid(
                    *(
                        2 * np.pi * np.fft.fftfreq(n, length / n)
                        for n, length in zip(*_grid(field), strict=True)
                    ),
                    indexing="ij",
                )
            )
            modulus = slots.solid.contact_modulus
            pressure = mean_pressure + modulus / 2 * np.fft.ifft2(q * np.fft.fft2(field.heights)).real
        if self.fault == "place":
            # Values of points are given to the middles between them.
            pressure = (pressure + np.roll(pressure, -1, axis=0)) / 2
        if self.fault == "contact-set":
            pressure = np.maximum(pressure, 1e-14 * mean_pressure)
            mask = pressure > 0
        return Claim(
            pressure=pressure,
            in_contact=mask,
            iterations=claim.iterations,
            wall_seconds=0.0,
            cpu_seconds=1e-3,
            peak_bytes=1,
        )


def _grid(field):
    return field.shape, field.lengths


def card_of(fault: str) -> Scorecard:
    solver = Toy()
    solver.fault = fault
    return score(Subject(name=f"toy {fault}", solver=solver, settings={}))


@pytest.fixture(scope="module")
def right() -> Scorecard:
    return card_of("")


def test_a_right_solver_passes_every_row_and_no_fault_is_named(right: Scorecard) -> None:
    assert [(verdict.case, verdict.error) for verdict in right.failed] == []
    assert right.fault is None
    assert right.cost


@pytest.mark.parametrize("fault", ["factor", "tension", "honesty", "place", "contact-set"])
def test_a_wrong_solver_is_caught_and_its_fault_is_named(fault: str) -> None:
    card = card_of(fault)
    assert card.fault is not None
    assert card.fault[0] == fault
    assert not card.verdict(fault).passed
    views = claims_views(claims_dataset(card.verdicts, [card]))
    assert views.cards[0].answer.text.startswith("no: ")
    assert views.cards[1].answer.text == card.diagnosis


def test_the_worst_failure_stands_first() -> None:
    card = card_of("factor")
    failures = [verdict.used for verdict in card.failed]
    assert failures == sorted(failures, reverse=True)
    flags = [verdict.passed for verdict in card.judged]
    assert flags == sorted(flags)


def test_a_nan_is_the_worst_failure_of_all() -> None:
    check = Check.below("something", float("nan"), 1.0)
    verdict = Verdict(case="x", claim="", source="", checks=(check,), seconds=0.0)
    assert verdict.used == float("inf")
    assert not verdict.passed


def test_boundary_elements_are_scored_in_less_than_two_minutes_of_processor_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    began = time.process_time()
    outcome = CliRunner().invoke(app, ["validate", "--method", "bem", "--quick", "--json"])
    assert time.process_time() - began < 120
    assert outcome.exit_code == 0, outcome.output
    (card,) = json.loads(outcome.output)["scorecards"]
    assert card["passed"]
    page = (tmp_path / "results" / "scorecard-bem" / "report.html").read_text(encoding="utf-8")
    assert "Every claim holds: " in page


def test_a_failing_solver_of_ones_own_exits_with_one_and_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    code = """
        import numpy as np
        def solve(heights, lengths, *, contact_modulus, mean_pressure):
            return np.full(heights.shape, mean_pressure)
    """
    Path("flat_toy.py").write_text("\n".join(line[8:] for line in code.splitlines()), encoding="utf-8")
    outcome = CliRunner().invoke(
        app, ["validate", "--method", "flat_toy:solve", "--quick", "--output", "card"]
    )
    assert outcome.exit_code == 1
    card = read_results(tmp_path / "card").data.isel(solver=0).verdict.to_series()
    failed, holds = (set(card.index[card == word]) for word in ("FAILS", "holds"))
    assert {"honesty", "hertz", "westergaard", "rough-4"} <= failed
    assert {"tension", "load", "symmetry", "units"} <= holds


def test_a_solver_that_crashes_fails_its_rows_and_the_others_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    code = "import os\ndef solve(heights, lengths, *, contact_modulus, mean_pressure):\n    os.abort()\n"
    Path("dying_toy.py").write_text(code, encoding="utf-8")
    solver, settings = chosen_solver("dying_toy:solve")
    verdicts = rows_of(
        Subject(name="dying", solver=solver, settings=settings), {"tension", "hertz", "offset", "odd-axes"}
    )
    assert "cannot be told" in verdicts.pop("offset").left_out
    assert all("crashed its process" in str(verdict.error) for verdict in verdicts.values())


class Deaf(Bem):
    """Boundary elements that do not hear a part of what they are told."""

    score_points = 16
    ignored = ""

    def claim(self, job) -> Claim:
        if self.ignored == "layer":
            job = replace(job, slots=replace(job.slots, response=None))
        if self.ignored == "hardness":
            job = replace(job, slots=replace(job.slots, pressure_bound=None))
        if self.ignored == "offset" and "offset" in job.load:
            job = replace(job, load={"offset": job.load["offset"] + 0.01 * job.field.rms_height})
        found = super().claim(job)
        return replace(found, converged=None) if self.ignored == "end" else found


def rows_of(subject: Subject, names: set[str]) -> dict[str, Verdict]:
    return {one.case: one for one in run_cases([row for row in rows(subject) if row.name in names])}


@pytest.mark.parametrize(
    ("ignored", "fails"),
    [
        ("", set()),
        ("layer", {"layer"}),
        ("hardness", {"yielding-wave"}),
        ("offset", {"offset", "offset-near-full"}),
        ("end", {"cut-short"}),
    ],
)
def test_what_a_solver_is_told_beside_the_load_must_be_heard(ignored: str, fails: set[str]) -> None:
    solver = Deaf()
    solver.ignored = ignored
    asked = {"layer", "yielding-wave", "offset", "offset-near-full", "cut-short"}
    verdicts = rows_of(Subject(name="deaf", solver=solver, settings={}), asked)
    assert {name for name, verdict in verdicts.items() if verdict.word != "holds"} == fails
    assert set(verdicts) == asked


class Hazy(Bem):
    """Boundary elements that leave pressures of no account where the gap is open."""

    score_points = 16

    def claim(self, job) -> Claim:
        found = super().claim(job)
        return replace(found, pressure=np.maximum(found.pressure, 1e-9 * found.pressure.max()))


def test_low_pressures_off_the_contact_do_not_pass_for_a_vanishing_start_of_the_distribution() -> None:
    names = {"stress-near-zero", "hertz", "westergaard"}
    verdicts = rows_of(Subject(name="hazy", solver=Hazy(), settings={}), names)
    assert {name for name, verdict in verdicts.items() if not verdict.passed} == {"stress-near-zero"}


class Dear(Bem):
    """Boundary elements that say of every solve that it took a millisecond a point."""

    score_points = 16

    def cost(self, size) -> Cost:
        return Cost(pairs=float(size.points), peak_bytes=1, unknowns=1)

    def claim(self, job) -> Claim:
        found = super().claim(job)
        return replace(found, cpu_seconds=1e-3 * found.pressure.size)


def test_what_would_take_too_long_is_not_tried_and_said_so() -> None:
    card = score(Subject(name="dear", solver=Dear(), settings={}, seconds=60.0))
    assert card.failed == ()
    assert {"tension", "factor", "honesty", "hertz"} <= {verdict.case for verdict in card.verdicts}
    assert card.left_out["rough-4"].startswith("not tried: 64 x 64 points would take some ")
    assert sum(card.subject.asked_seconds) <= 60.0
    assert set(claims_dataset(card.verdicts, [card]).verdict.values.ravel()) == {"holds", "not judged"}


def test_coarse_grids_that_the_time_allows_show_no_orders() -> None:
    card = score(Subject(name="dear", solver=Dear(), settings={}, seconds=15.0))
    assert card.subject.ladder == (16, 24, 32)
    assert "observed" in card.left_out["nested-grids"]
    checks = [check.quantity for verdict in card.verdicts for check in verdict.checks]
    assert not any(quantity.startswith("observed order") for quantity in checks)
