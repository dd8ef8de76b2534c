"""The known failures of other codes, found by the scorecard; skipped where they are absent."""

from pathlib import Path

import pytest

from validation.cases import run_cases
from validation.cases.scorecard import Subject, rows
from validation.solvers import chosen_solver

BY_GAPS = "external_codes_called_otherwise:tamaas_by_gaps"
BY_DEFAULT = "external_codes_called_otherwise:contact_mechanics_by_default"


@pytest.fixture(autouse=True)
def _in_this_folder(monkeypatch):
    """Functions of the user's are looked for in the folder of the command, too."""
    monkeypatch.chdir(Path(__file__).parent)


def failed(name, package, *, among):
    """Rows that a solver fails, of some, with the first check that is missed."""
    pytest.importorskip(package)
    solver, settings = chosen_solver(name)
    subject = Subject(name=name, solver=solver, settings={**settings, "seconds": 60.0})
    verdicts = list(run_cases([row for row in rows(subject) if row.name in among]))
    assert {verdict.case for verdict in verdicts} == among
    missed = {one.case: [check.quantity for check in one.checks if not check.passed] for one in verdicts}
    return {case: quantities[0] for case, quantities in missed.items() if quantities}


@pytest.mark.nightly
def test_tamaas_misses_residuals_on_odd_first_axes_and_is_silent_at_its_iteration_limit():
    found = failed("tamaas", "tamaas", among={"odd-axes", "cut-short", "contact-set", "honesty", "near-full"})
    assert set(found) == {"odd-axes", "cut-short"}
    assert "45 x 64" in found["odd-axes"]


@pytest.mark.nightly
def test_tamaas_with_gaps_as_unknowns_is_wrong_near_full_contact_and_counts_open_points():
    found = failed(BY_GAPS, "tamaas", among={"contact-set", "near-full", "load"})
    assert set(found) == {"contact-set", "near-full"}
    assert found["contact-set"].startswith("points with p > 0")


@pytest.mark.nightly
def test_contact_mechanics_with_its_tolerance_of_forces_stops_at_once_at_light_load():
    found = failed(BY_DEFAULT, "ContactMechanics", among={"one-cell", "hertz", "cut-short"})
    assert set(found) == {"one-cell"}


def test_aspher_holds_all_that_it_can_be_asked():
    among = {"load", "contact-set", "honesty", "cut-short", "hertz", "near-full", "units"}
    assert failed("aspher", "aspher", among=among) == {}


def test_contact_mechanics_as_its_method_here_calls_it_holds_these_rows():
    among = {"one-cell", "offset", "offset-near-full", "layer", "yielding-wave", "cut-short"}
    assert failed("contact_mechanics", "ContactMechanics", among=among) == {}
