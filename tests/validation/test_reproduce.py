"""Recomputing the paper: verdicts, the files written, and that a wrong number changes a verdict."""

import csv
import json
import math
from dataclasses import replace

import pytest

from validation.paper import reproduce
from validation.paper.claims import Reading, judge
from validation.paper.figures import FIGURES
from validation.paper.table import CLAIMS
from validation.report.page import write_page


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper") / "new" / "folder"
    told = []
    rows = reproduce.run(folder, figures=False, progress=told.append).rows
    return folder, rows, told


def test_every_claim_has_a_verdict_and_the_table_holds_them_all(outcome):
    folder, rows, told = outcome
    assert len(rows) == len(CLAIMS) == len(told)
    assert all(row.verdict.startswith(("reproduced", "not reproduced because")) for row in rows)
    with (folder / "claims.csv").open(encoding="utf-8") as file:
        written = list(csv.DictReader(file))
    assert [line["verdict"] for line in written] == [row.verdict for row in rows]
    said = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert [claim["verdict"] for claim in said["claims"]] == [row.verdict for row in rows]
    missed = [row for row in rows if row.verdict.startswith("not")]
    assert all(any(row.claim in finding for finding in said["findings"]) for row in missed)


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
def test_a_figure_is_drawn_from_numbers_that_are_written_with_it(name, tmp_path):
    from validation.paper.page import paper_page
    from validation.paper.plots import drawn

    figure = next(make for make in FIGURES if make.__name__ == name)()
    write_page(paper_page([judge(CLAIMS[0])], figures=(drawn(figure),)), tmp_path)
    html = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert f'id="{figure.name.replace("_", "-")}"' in html
    assert figure.title in html
    (written,) = (tmp_path / "figures").glob("*.csv")
    with written.open(encoding="utf-8") as file:
        points = [(float(line["x"]), float(line["y"])) for line in csv.DictReader(file)]
    curves = [curve for panel in figure.panels for curve in panel.curves]
    assert points == [(x, y) for curve in curves for x, y in zip(curve.x, curve.y, strict=True)]
    assert all(math.isfinite(value) for point in points for value in point)


@pytest.mark.slow
def test_everything_is_written(tmp_path):
    done = reproduce.run(tmp_path)
    assert done.files[0] == tmp_path / "report.html"
    for make in FIGURES:
        for suffix in ("pdf", "svg", "csv", "nc"):
            name = make.__name__.replace("_", "-")
            assert (tmp_path / "figures" / f"{name}.{suffix}").stat().st_size > 500
