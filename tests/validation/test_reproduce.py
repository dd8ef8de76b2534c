"""Recomputing the paper: verdicts, the files written, and that a wrong number changes a verdict."""

import csv
import math
from dataclasses import replace

import pytest

from validation.paper import reproduce
from validation.paper.claims import Reading, judge
from validation.paper.figures import FIGURES
from validation.paper.table import CLAIMS


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper") / "new" / "folder"
    told = []
    rows = reproduce.run(folder, figures=False, progress=told.append)
    return folder, rows, told


def test_every_claim_has_a_verdict_and_the_table_holds_them_all(outcome):
    folder, rows, told = outcome
    assert len(rows) == len(CLAIMS) == len(told)
    assert all(row.verdict.startswith(("reproduced", "not reproduced because")) for row in rows)
    with (folder / "claims.csv").open(encoding="utf-8") as file:
        written = list(csv.DictReader(file))
    assert [line["verdict"] for line in written] == [row.verdict for row in rows]
    assert len((folder / "claims.md").read_text(encoding="utf-8").splitlines()) == len(rows) + 2


def test_claims_that_hold_literally_and_claims_that_do_not_are_told_apart(outcome):
    verdicts = {row.claim: row.verdict for row in outcome[1]}

    def of(start):
        return next(verdict for claim, verdict in verdicts.items() if claim.startswith(start))

    assert of("rim: surface area") == "reproduced"
    assert of("rim at 0.5 MPa without") == "reproduced"
    assert of("rim at 0.5 MPa with adhesion").startswith("reproduced with the inferred convention")
    assert of("Pyrex: contact and adhesion vanish").startswith("reproduced with the inferred convention")
    assert of("PMMA: local pressure").startswith("not reproduced because")
    assert of("PMMA: rms roughness [nm], caption").startswith("not reproduced because")


def test_numbers_of_the_paper(outcome):
    computed = {row.claim: row.computed for row in outcome[1]}
    assert computed["rim at 0.5 MPa with adhesion: A/A0"] == pytest.approx(0.4355, abs=2e-4)
    assert computed["Pyrex: contact and adhesion vanish at h/h_0"] == pytest.approx(0.933, abs=0.006)
    assert computed["Pyrex at 20 MPa: half yielded at magnification"] == pytest.approx(2944, rel=1e-3)
    assert computed["coarse grid: excess of contact area [%]"] == pytest.approx(21.754, abs=0.001)


def test_a_wrong_number_turns_the_verdict():
    claim = CLAIMS[0]
    assert judge(claim).verdict == "reproduced"
    wrong = replace(claim, low=50.0, high=60.0)
    assert judge(wrong).verdict.startswith("not reproduced because")


def test_an_inferred_reading_is_named_and_the_literal_one_reported():
    def readings():
        yield Reading(convention="one", value=3.0)
        yield Reading(convention="two", value=38.0)

    row = judge(replace(CLAIMS[0], readings=readings))
    assert row.verdict == "reproduced with the inferred convention: two"
    assert "literally 3 (one)" in row.note
    assert row.computed == 38.0


def test_tolerances_bracket_the_stated_number():
    assert all(claim.low <= claim.stated <= claim.high for claim in CLAIMS)
    assert all(claim.basis for claim in CLAIMS)


@pytest.mark.parametrize("name", ["spectra", "coarse_grid", "elastoplastic"])
def test_a_figure_is_written_with_its_numbers(name, tmp_path):
    from validation.paper import plots as plots_paper

    figure = next(make for make in FIGURES if make.__name__ == name)()
    png, svg = plots_paper.save(figure, tmp_path)
    assert png.stat().st_size > 5000
    assert figure.title in svg.read_text(encoding="utf-8")
    again = plots_paper.save(figure, tmp_path)[1].read_bytes()
    assert again == svg.read_bytes()
    for panel in figure.panels:
        for curve in panel.curves:
            assert all(math.isfinite(v) for v in (*curve.x, *curve.y))


@pytest.mark.slow
def test_everything_is_written(tmp_path):
    reproduce.run(tmp_path)
    for make in FIGURES:
        for suffix in ("png", "svg", "csv"):
            assert (tmp_path / f"{make.__name__}.{suffix}").stat().st_size > 500
