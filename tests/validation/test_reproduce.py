"""Recomputing the paper: verdicts, the files written, and that a wrong number changes a verdict.

``python tests/validation/test_reproduce.py`` writes gold/paper.json again, where a change is meant.
"""

import csv
import json
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from gold import write_lines
from reading_back import misdrawn

from validation.execution.results import Result, read_results
from validation.paper import pmma, reproduce, rim
from validation.paper.claims import Application, Claim, Stated, application, judge, written
from validation.paper.figures import FIGURES
from validation.paper.pmma import PMMA
from validation.paper.reproduce import paper_dataset, paper_page
from validation.paper.rim import RIM

#: Number and verdict of each claim, and what is drawn of each figure.
NUMBERS = Path(__file__).parent / "gold" / "paper.json"
#: The conventions under which the claims of each system agree best: a slow test sees that they do.
JOINT = {
    "tire rim": "A* with slope factor, energy of Eq. 50 as printed",
    "Pyrex": "two equal surfaces added coherently (C x 4), E = 32 GPa, Delta gamma = 0.43 J/m^2, "
    "energy of Eq. 43",
}


def of_best(application):
    """An application under its best convention alone, with the notes left out."""
    conventions = application.conventions
    if application.name in JOINT:
        conventions = {JOINT[application.name]: conventions[JOINT[application.name]]}
    claims = (replace(c, note="") for c in application.claims)
    return replace(application, conventions=conventions, claims=tuple(claims))


def test_spectra_cross_where_it_is_said():
    q = pmma._crossing()
    assert pmma.s.pmma()(q) == pytest.approx(pmma.s.steel()(q), rel=1e-6)
    assert pmma.s.pmma()(2 * q) > pmma.s.steel()(2 * q)


@pytest.mark.parametrize(("area", "words"), [(0.3, "leaks"), (0.4, "not decided"), (0.6, "seals")])
def test_a_rim_seals_above_all_thresholds_and_leaks_below_all(monkeypatch, area, words):
    monkeypatch.setattr(rim, "_READINGS", {"one": None})
    monkeypatch.setattr(rim, "_pressed", lambda reading: SimpleNamespace(real_area=area))
    assert rim._seals().endswith(f"one {area:.4f}: {words}")


def words(row):
    return [*filter(None, (row["paper_verdict"], row["paper_reason"]))]


def result_of(rows, folder, figures=()):
    data = paper_dataset(rows, figures)
    return Result(kind="paper", name="reproduce", settings={}, store=folder, data=data)


def claim(text, low, high, value, **more):
    stated = Stated((low + high) / 2, low, high, "5 %")
    return Claim(text=text, section="1", stated=stated, value=value, **more)


TOY = Application(
    name="toy",
    conventions={"one": 1.0, "two": 2.0},
    claims=(
        claim("a [nm]", 1.9, 2.1, lambda x: x),
        claim("b", 3.9, 4.1, lambda x: 2 * x),
        claim("c", 0.9, 1.1, lambda x: x, choice="chosen"),
        claim("d", 6.9, 7.1, lambda: 7.0, fixed=True),
        claim("e", 6.9, 7.1, lambda: 8.0, fixed=True, failure="it is 8"),
    ),
)


def test_all_claims_of_a_system_are_judged_under_one_convention():
    """Two of the three that depend on it agree under the second; the third may not have its own."""
    rows = judge(TOY)
    assert [row["computed"] for row in rows] == [2.0, 4.0, 2.0, 7.0, 8.0]
    assert [row["literal"] for row in rows] == [1.0, 2.0, 1.0, 7.0, 8.0]
    assert [row["paper_convention"] for row in rows] == ["two", "two", "two", "as stated", "as stated"]
    found = {row["claim"]: ": ".join(words(row)) for row in rows}
    assert found["toy: a [nm]"] == "reproduced under the joint convention"
    assert found["toy: c"].startswith("not reproduced")
    assert found["toy: d"] == "reproduced"
    assert found["toy: e"] == "not reproduced: it is 8"
    assert "literally 1, which agrees, too" in rows[2]["paper_note"]


def test_the_literal_convention_wins_a_tie_and_a_choice_is_never_called_reproduced_alone():
    rows = judge(replace(TOY, claims=(TOY.claims[0], TOY.claims[2])))
    assert rows[1]["paper_convention"] == "one"
    assert rows[1]["paper_verdict"] == "reproduced with a choice"
    assert rows[1]["paper_reason"] == "chosen"
    assert rows[0]["paper_verdict"] == "not reproduced"


def test_a_claim_is_computed_once_where_no_convention_enters():
    calls = []
    one = claim("f", 0, 2, lambda: calls.append(1) or 1.0, fixed=True)
    told = []
    judge(replace(TOY, claims=(one,)), tell=told.append)
    assert (len(calls), told) == (1, ["f"])


def test_what_is_written_and_not_computed_is_refused():
    with pytest.raises(ValueError, match=r"Pyrex: .*half_yielded.*: written or computed alone"):
        application("Pyrex", values={"rms": lambda: 1.0})


def told(application):
    return {row["claim"]: [row["computed"], *words(row)] for row in judge(of_best(application))}


@pytest.mark.parametrize("application", reproduce.APPLICATIONS, ids=lambda application: application.name)
def test_every_claim_has_its_number_and_its_verdict(application):
    known = json.loads(NUMBERS.read_text(encoding="utf-8"))
    for claim, (number, *words) in told(application).items():
        exact, *verdict = known[claim]
        assert (number, words) == (pytest.approx(exact, rel=1e-6, abs=1e-12), verdict), claim


def shown(figure):
    """Number of points, mean and largest value of each quantity of each curve."""

    def numbers(name, values):
        return name, len(values), float(np.nanmean(values)), float(np.nanmax(values))

    curves = {f"{figure.name}, {label}": curve for label, curve in figure.curves().items()}
    return {label: [word for pair in one.items() for word in numbers(*pair)] for label, one in curves.items()}


#: Those of PMMA take seconds and are made as those of the rim, of a spectrum that the claims have too.
SLOW = {"pmma_pressure": pytest.mark.slow}


@pytest.mark.parametrize(
    "figure", [pytest.param(one, id=one.name, marks=SLOW.get(one.name, ())) for one in FIGURES]
)
def test_every_curve_has_its_numbers(figure):
    known = json.loads(NUMBERS.read_text(encoding="utf-8"))
    for curve, numbers in shown(figure).items():
        exact = [n if isinstance(n, str) else pytest.approx(n, rel=1e-6, abs=0.0) for n in known[curve]]
        assert numbers == exact, curve


def test_the_joint_convention_of_the_rim_is_the_literal_one():
    assert next(iter(RIM.conventions)) == JOINT["tire rim"]


def test_pmma_does_not_follow_the_load_with_the_printed_parameters():
    _, wide = PMMA.conventions.values()
    (area,) = (claim for claim in PMMA.claims if claim.text.startswith("figure of the area"))
    assert area.value(wide) > 100


def test_tolerances_bracket_the_stated_number():
    for system in reproduce.APPLICATIONS:
        for one in system.claims:
            stated = one.stated
            assert stated.low <= stated.value <= stated.high or stated.value == pytest.approx(stated.high)
            assert stated.basis


@pytest.mark.slow
def test_everything_is_recomputed_written_and_shown(tmp_path):
    folder, told = tmp_path / "new" / "folder", []
    outputs = reproduce.run(folder, progress=told.append)
    page, files = outputs.page, outputs.files
    data = read_results(folder).data
    assert [problem for drawing in page.figures for problem in misdrawn(drawing, data)] == []
    claims = sum(len(system.claims) for system in reproduce.APPLICATIONS)
    assert data.sizes["claim"] == claims == len(told) - len(FIGURES)
    counts = [float(data[f"claims_{kind}"]) for kind in ("literal", "joint", "chosen", "missed")]
    assert sum(counts) == data.claims_judged
    with (folder / "table.csv").open(encoding="utf-8") as file:
        written = list(csv.DictReader(file))
    assert [line["verdict"] for line in written] == data.paper_verdict.values.tolist()
    for system in reproduce.APPLICATIONS:
        of_it = data.isel(claim=[c.startswith(f"{system.name}: ") for c in data.claim.values])
        best = JOINT.get(system.name, next(iter(system.conventions)))
        assert set(of_it.paper_convention.values) - {"as stated"} == {best} - {""}
    assert files[0] == folder / "report.html"
    for figure in FIGURES:
        for suffix in ("pdf", "svg", "csv", "nc"):
            name = figure.name.replace("_", "-")
            assert (folder / "figures" / f"{name}.{suffix}").stat().st_size > 500


def test_the_page_lists_what_fails_and_what_has_no_verdict(tmp_path):
    result = result_of(judge(TOY), tmp_path)
    page = paper_page(result, figures=True)
    columns = {column["name"] for column in page.summary["tables"]["table"]["columns"]}
    assert columns == {name for name, v in result.data.variables.items() if v.dims == ("claim",)}
    told = ("stated", "stated_low", "stated_high", "stated_basis")
    shown = [list(result.data[name].values) for name in told]
    assert shown == [[row[name] for row in judge(TOY)] for name in told]
    assert (page.summary["kind"], page.summary["name"]) == (result.kind, result.name)
    assert page.findings[0].startswith("1 of 5 numbers follow from the text as it stands, 2 under the set")
    assert page.findings[1].startswith("Not reproduced: toy: c (1: ")
    assert page.findings[1].endswith(" and toy: e (1: it is 8).")
    statements = [one["statement"] for one in written()["unjudged"].values()]
    assert all(any(one in line for line in page.notes["Without a verdict"]) for one in statements)


def test_pressures_on_too_coarse_a_grid_carry_the_load_of_the_exact_ones():
    (figure,) = (figure for figure in FIGURES if figure.name == "coarse_grid")
    for curve in figure.curves().values():
        stress, density = curve["stress_over_load"], curve["density_over_load"]
        # Some per cent lie beyond the end of the figure.
        assert 0.97 < np.trapezoid(stress * density, stress) < 1


#: Those of adhesion take seconds each; `test_everything_is_recomputed_written_and_shown` has them all.
QUICK = [figure for figure in FIGURES if not re.search("rim|pmma|pyrex_rough", figure.name)]


def test_figures_show_the_curves_that_their_labels_name(tmp_path):
    result = result_of(judge(TOY), tmp_path, [figure.compute() for figure in QUICK])
    drawings = {one.name.replace("-", "_"): one for one in paper_page(result, figures=True).figures}
    assert set(drawings) == {figure.name for figure in QUICK}
    assert [problem for one in drawings.values() for problem in misdrawn(one, result.data)] == []
    for figure in QUICK:
        curves = figure.curves()
        drawn = [label for panel in figure.panels for label, one in curves.items() if panel[1] in one]
        assert [one.label for one in drawings[figure.name].drawn] == drawn


if __name__ == "__main__":
    made = [*map(told, reproduce.APPLICATIONS), *map(shown, FIGURES)]
    write_lines(NUMBERS, {name: row for part in made for name, row in part.items()})
