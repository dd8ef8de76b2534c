"""The independent reader: silent on a sound run, and it finds each number that was changed."""

from __future__ import annotations

import json
import re
import shutil

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from fem_contact.area import EDGE_CONSTANTS, EDGE_MAPS
from validation.audit import audit, stored
from validation.audit.ledger import Ledger, printed
from validation.audit.reading import judge_fields, judge_surfaces
from validation.audit.recomputed import Run
from validation.cli.commands import app
from validation.comparison.accuracy import run_accurate
from validation.comparison.run import run_scene
from validation.comparison.sweep import run_sweep
from validation.scenes.scene import load_scene
from validation.scenes.sweep import load_asked


@pytest.fixture
def copied(small_run, tmp_path):
    """A copy of the results of the small scene, to be damaged."""
    return shutil.copytree(small_run.folder, tmp_path / "results")


def _edit(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert old in text, f"{old!r} not in {path.name}"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def _changed(folder, change):
    """Change summary.json as data."""
    path = folder / "summary.json"
    said = json.loads(path.read_text())
    change(said)
    path.write_text(json.dumps(said))


_NO_REPORT = {"data of figures: there are none", "report.html: there is none"}


def test_every_number_of_the_small_run_follows_from_its_fields(small_run):
    ledger = audit(small_run.folder)
    assert [str(entry) for entry in ledger.wrong] == []
    assert ledger.unread == []
    places = {entry.place.split(",")[0] for entry in ledger.entries}
    assert {"table.csv", "summary.json", "sentence", "figures/area", "figures/cost.csv"} <= places
    assert {"figures/pressure-at-zero.csv", "report.html"} <= places
    assert len(ledger.entries) > 700


def test_an_ensemble_with_a_coarse_grid_and_a_second_theory_agrees_throughout(write_scene, tmp_path):
    ensemble = "[ensemble]\nrealisations = 3\ngrids = [16, 32]\n\n[methods.theory]"
    scene = write_scene(
        ("[methods.theory]", ensemble),
        ("grids = [12, 24, 48]\nshifts = 2", "grids = [6, 16, 32]\nunder_resolved = true"),
        # Gaussian amplitudes and a pressure in Pa: each surface has its own gradient, and its own theory.
        ("seed = 77", 'seed = 77\namplitudes = "gaussian"'),
        ("reduced_pressure = 0.1", 'pressure = "11 kPa"'),
        fem=False,
    )
    run_scene(load_scene(str(scene)), tmp_path / "results", report=False)
    ledger = audit(tmp_path / "results")
    assert [str(entry) for entry in ledger.wrong] == []
    assert set(ledger.unread) == _NO_REPORT
    assert any(entry.name == "scatter, ratios 2" for entry in ledger.entries)
    assert any(entry.name == "under-resolved grids" for entry in ledger.entries)


def test_an_ensemble_is_read_without_the_shifts_of_its_first_surface(write_scene, tmp_path):
    ensemble = "[ensemble]\nrealisations = 2\ngrids = [12, 24]\n\n[methods.theory]"
    scene = write_scene(("[methods.theory]", ensemble), fem=False)
    run_scene(load_scene(str(scene)), tmp_path / "results", report=False)
    ledger = audit(tmp_path / "results")
    assert [str(entry) for entry in ledger.wrong] == []
    assert "scatter, areas 1" in {entry.name for entry in ledger.entries}


def _audited(write_scene, folder, effects, *, theory=True):
    """Run the small scene with effects, and read it back; return the run and the ledger."""
    table = "" if not theory else "[methods.theory]"
    scene = write_scene(("[methods.theory]", f"{effects}\n\n{table}"), fem=False)
    run_scene(load_scene(str(scene)), folder, report=False)
    return audit(folder)


_HARD = '[[effects]]\nkind = "hardness"\nhardness = "60 kPa"'
_STICKY = '[[effects]]\nkind = "adhesion"\nwork = "1 mJ/m^2"\nreach = "0.2 um"'
_LAYER = '[[effects]]\nkind = "thickness"\nthickness = "3 um"'


def test_with_a_hardness_areas_and_the_theory_of_one_hardness_are_judged(write_scene, tmp_path):
    ledger = _audited(write_scene, tmp_path / "results", _HARD)
    assert [str(entry) for entry in ledger.wrong] == []
    assert set(ledger.unread) == _NO_REPORT
    names = {entry.name for entry in ledger.entries}
    assert {"A_pl/A0", "theory, A_pl/A0", "A_pl/A0 by the theory", "theory, A/A0 from C(q) alone"} <= names
    _changed(tmp_path / "results", lambda s: s["theory"].update(plastic=1.01 * s["theory"]["plastic"]))
    assert [entry.name for entry in audit(tmp_path / "results").wrong] == ["theory, A_pl/A0"]


def test_with_adhesion_tension_and_balance_are_judged_and_the_theory_is_listed(write_scene, tmp_path):
    ledger = _audited(write_scene, tmp_path / "results", _STICKY)
    assert [str(entry) for entry in ledger.wrong] == []
    assert set(ledger.unread) == _NO_REPORT | {"theory with effects, or of a measured surface"}
    names = {entry.name for entry in ledger.entries}
    assert {"residual, tension", "residual, complementarity", "bem 48x48 residual"} <= names
    run = Run.of(tmp_path / "results")
    one = run.solves["bem", (24, 24), (0.0, 0.0), 0]
    one.p[~one.contact] -= 0.1 * abs(one.p.min())
    ledger = Ledger()
    judge_fields(0, one, run, ledger)
    assert {"residual, tension", "residual, complementarity"} <= {entry.name for entry in ledger.wrong}


def test_the_displacement_of_a_bonded_layer_is_judged(write_scene, tmp_path):
    ledger = _audited(write_scene, tmp_path / "results", _LAYER, theory=False)
    assert [str(entry) for entry in ledger.wrong] == []
    assert set(ledger.unread) == _NO_REPORT
    run = Run.of(tmp_path / "results")
    one = run.solves["bem", (24, 24), (0.0, 0.0), 0]
    run.effects[0]["thickness"] *= 1.1
    run.__dict__.pop("depth", None)
    ledger = Ledger()
    judge_fields(0, one, run, ledger)
    assert [entry.name for entry in ledger.wrong] == ["u against 2 p / (E* q)"]


def test_a_sweep_is_read_case_by_case(write_scene, tmp_path):
    scene = str(write_scene(("grids = [12, 24, 48]\nshifts = 2", "grids = [12, 24, 48]"), fem=False))
    sweep = load_asked(
        scene,
        ["sweep.load.pressure=['5 kPa', '10 kPa']", "sweep.effects.hardness.hardness=['200 kPa', 60e3]"],
    )
    run_sweep(sweep, tmp_path / "swept", report=False)
    ledger = audit(tmp_path / "swept")
    assert [str(entry) for entry in ledger.wrong] == []
    assert ledger.unread == ["table, sentences and figures of the sweep, which show the dataset"]
    assert "theory_plastic at pressure = 5000, hardness = 60000" in {entry.name for entry in ledger.entries}
    path = tmp_path / "swept" / "data.nc"
    data = xr.load_dataset(path)
    data.assign(kappa=data.kappa * [[1, 1], [1, 1.01]]).to_netcdf(path)
    assert [entry.name for entry in audit(tmp_path / "swept").wrong] == [
        "kappa at pressure = 10000, hardness = 60000"
    ]


def test_what_a_run_to_an_accuracy_claims_follows_from_its_fields(write_scene, tmp_path):
    scene = write_scene(
        ("[methods.theory]", "[ensemble]\nrealisations = 2\ngrids = [12, 24]\n\n[methods.theory]")
    )
    run_accurate(load_scene(str(scene)), tmp_path / "results", target=0.3, report=False)
    ledger = audit(tmp_path / "results")
    assert [str(entry) for entry in ledger.wrong] == []
    judged = {entry.name for entry in ledger.entries if entry.place == "accuracy.json"}
    assert {"A/A0", "relative error", "FEM beside it", "FEM beside it, relative error"} <= judged
    assert "mean distance from the theory" in {entry.name for entry in ledger.entries}
    assert "accuracy.json: mean" in ledger.unread
    path = tmp_path / "results" / "accuracy.json"
    said = json.loads(path.read_text())
    said["beside"][0]["area"] *= 1.001
    path.write_text(json.dumps(said | {"error": said["error"] / 2}))
    wrong = {entry.name for entry in audit(tmp_path / "results").wrong}
    assert wrong == {"relative error", "FEM beside it"}


_ROW = "summary.json"
#: What a mistake of the comparison would make of the summary, and which entry must disagree.
_PLANTED = {
    "kappa from the counted area": (
        lambda s: s["rows"][0].update(kappa=s["rows"][0]["pixel"] / s["reduced_pressure"]),
        "bem 12x12 kappa",
    ),
    "one per cent on the corrected area": (
        lambda s: s["rows"][2].update(perimeter=1.01 * s["rows"][2]["perimeter"]),
        "bem 48x48 perimeter",
    ),
    "deviation instead of standard error over shifts": (
        lambda s: s["rows"][1].update(pixel_scatter=2 * s["rows"][1]["pixel_scatter"]),
        "bem 24x24 pixel_scatter",
    ),
    "boundary elements against finite elements": (
        lambda s: s["cross_checks"][0].update(pixel=1 / (1 + s["cross_checks"][0]["pixel"]) - 1),
        "fem on 12x12 against bem, pixel",
    ),
    "conditional and ensemble theory swapped": (
        lambda s: s["theory"].update(area=s["theory"]["ensemble_area"], ensemble_area=s["theory"]["area"]),
        "theory, A/A0 of this surface",
    ),
    "limit without its coarsest grid's error": (
        lambda s: s["limit"].update(value=0.999 * s["limit"]["value"]),
        "limit of A/A0",
    ),
    "half the standard error of the limit": (
        lambda s: s["limit"].update(uncertainty=0.5 * s["limit"]["uncertainty"]),
        "error of the limit",
    ),
    "p* with the gradient of C(q)": (
        lambda s: s.update(reduced_pressure=s["reduced_pressure"] * 1.07),
        "p*",
    ),
    "variance with E*^2 / 2": (
        lambda s: s["theory"].update(stress_variance=2 * s["theory"]["stress_variance"]),
        "theory, V [Pa^2]",
    ),
    "P(0+) one per cent high": (
        lambda s: s["rows"][3].update(density_at_zero=1.01 * s["rows"][3]["density_at_zero"]),
        "fem 12x12 density_at_zero",
    ),
    "smallest residual in place of the largest": (
        lambda s: s["rows"][0].update(residual=0.0),
        "bem 12x12 residual",
    ),
    "seconds of one shift": (
        lambda s: s["rows"][0].update(seconds=s["rows"][0]["seconds"] / 4),
        "bem 12x12 seconds",
    ),
    "two rows exchanged": (lambda s: s["rows"].reverse(), "bem 12x12 method"),
}


@pytest.mark.parametrize("mistake", _PLANTED)
def test_a_mistake_in_the_summary_is_found_by_name(copied, mistake):
    change, name = _PLANTED[mistake]
    _changed(copied, change)
    assert name in {entry.name for entry in audit(copied).wrong if entry.place == "summary.json"}


#: Where a sentence is changed: what stands there, what is put there, what must disagree.
_SENTENCES = {
    "above for below": ("above it (grid", "below it (grid", "side of the theory"),
    "kappa of the limit": ("kappa = 2.2407", "kappa = 2.2506", "kappa of the limit"),
    "error with one digit changed": (
        "0.22407 +- 0.00019",
        "0.22407 +- 0.00091",
        "error of A/A0 in the limit",
    ),
    "theory of the other kind": ("A/A0 = 0.1585", "A/A0 = 0.1697", "theory, A/A0 of this surface"),
    "number of solves": ("12 solves", "3 solves", "solves of the limit"),
    "over for under": ("(BEM) overestimates", "(BEM) underestimates", "counting by BEM, word"),
    "order of P(0+)": ("dx^0.60", "dx^0.50", "order of P(0+) in dx"),
    "does not shrink": ("pressure shrinks", "pressure does not shrink", "difference in pressure shrinks"),
    "p* rounded away": ("p* = 0.1.", "p* = 0.2.", "p*"),
}


@pytest.mark.parametrize("mistake", _SENTENCES)
def test_a_mistake_in_a_sentence_is_found_by_name(copied, mistake):
    old, new, name = _SENTENCES[mistake]
    _edit(copied / "summary.json", old, new)
    assert name in {entry.name for entry in audit(copied).wrong if entry.place == "sentence"}


def test_another_cheapest_way_is_found(copied):
    """Which one it is depends on measured seconds: the other area of the same grid is not within 1 %."""
    said = (copied / "summary.json").read_text(encoding="utf-8")
    way = re.search(r"on \d+ x \d+ with the (perimeter|pixel) area", said)
    other = way[0].replace(way[1], {"perimeter": "pixel", "pixel": "perimeter"}[way[1]])
    _edit(copied / "summary.json", way[0], other)
    assert "cheapest way within 1 %" in {entry.name for entry in audit(copied).wrong}


def test_a_sentence_that_is_left_out_is_missed(copied):
    _changed(copied, lambda s: s["findings"].pop(1))
    assert "says what the theory gives" in {entry.name for entry in audit(copied).wrong}


def test_a_sentence_of_unknown_form_is_listed_as_unread(copied):
    _changed(copied, lambda s: s["findings"].append("All is well."))
    assert audit(copied).unread == ["sentence of another form: All is well."]


def test_swapped_columns_are_found_in_the_table_of_the_page(copied):
    _edit(copied / "report.html", "<td>0.2283</td><td>2.283</td>", "<td>2.283</td><td>0.2283</td>")
    wrong = {entry.name for entry in audit(copied).wrong}
    assert wrong == {"bem 12x12 A/A0 perimeter", "bem 12x12 kappa"}


def test_the_cards_of_the_page_follow_from_the_fields(small_run, copied):
    names = {entry.name for entry in audit(small_run.folder).entries if entry.place == "report.html, card"}
    assert len(names) == 7
    _edit(copied / "report.html", "over the grids; κ = 2.2407", "over the grids; κ = 2.2416")
    assert [entry.name for entry in audit(copied).wrong] == ["kappa of the card"]


def test_a_number_changed_in_the_table_file_is_found(copied):
    row = (copied / "table.csv").read_text().splitlines()[1]
    _edit(copied / "table.csv", row, row.replace("0.2282", "0.2382"))
    assert [entry.name for entry in audit(copied).wrong] == ["bem 12x12 perimeter"]


def test_a_theory_curve_drawn_for_another_load_is_found(copied):
    path = copied / "figures" / "pressure-at-zero.csv"
    lines = path.read_text().splitlines()
    k = next(i for i, line in enumerate(lines) if line.split(",")[1] == "Persson" and i % 7 == 0)
    head, density = lines[k].rsplit(",", 1)
    lines[k] = f"{head},{float(density) * 1.02 + 1e-3!r}"
    path.write_text("\n".join(lines))
    (entry,) = audit(copied).wrong
    assert entry.name.startswith("Persson, P at")


def test_fields_that_break_their_own_definitions_are_found(small_run):
    run = Run.of(small_run.folder)
    (one,) = [solve for key, solve in run.solves.items() if key[:2] == ("fem", (24, 24))]
    one.gap[0, 0] += 1e-9
    one.p[one.contact] *= 1.001
    ledger = Ledger()
    judge_fields(0, one, run, ledger)
    assert {entry.name for entry in ledger.wrong} >= {
        "gap less u - h + offset, over the height",
        "mean pressure [Pa]",
    }


def test_surfaces_that_share_one_seed_are_found(small_run):
    run = Run.of(small_run.folder)
    key = ("bem", (24, 24), (0.0, 0.0), 0)
    run.solves[(*key[:3], 1)] = run.solves[key]
    ledger = Ledger()
    judge_surfaces(run, ledger)
    assert [entry.name for entry in ledger.wrong] == ["surfaces that differ"]


def test_a_shift_in_the_other_direction_is_found(small_run):
    run = Run.of(small_run.folder)
    one = run.solves[("bem", (24, 24), (0.0, 0.5), 0)]
    one.h = np.roll(one.h, 1, axis=1)
    ledger = Ledger()
    judge_surfaces(run, ledger)
    assert {entry.name for entry in ledger.wrong} == {"heights against those moved by the shift"}


def test_the_command_exits_with_one_where_a_number_disagrees(small_run, copied):
    runner = CliRunner()
    sound = runner.invoke(app, ["audit", str(small_run.folder)])
    assert sound.exit_code == 0
    assert "sentences:" in sound.output
    _edit(copied / "table.csv", "bem,12x12", "fem,12x12")
    damaged = runner.invoke(app, ["audit", str(copied)])
    assert damaged.exit_code == 1
    assert "table.csv: bem 12x12 method: found fem, recomputed bem: DISAGREES" in damaged.output


def test_the_command_refuses_a_folder_without_a_run(tmp_path):
    outcome = CliRunner().invoke(app, ["audit", str(tmp_path)])
    assert type(outcome.exception).__name__ == "UsageError"
    assert "cannot be audited" in str(outcome.exception)


@pytest.mark.parametrize(
    ("text", "value", "digits", "agrees"),
    [
        ("27 %", 0.2749, None, True),
        ("27 %", 0.2751, None, False),
        ("0.1", 0.10004, 4, True),
        ("0.1", 0.10006, 4, False),
        ("1.1e-10", 1.149e-10, None, True),
        ("-0.20 %", 0.002, None, False),
        ("12,096", 12096, None, True),
        ("", float("nan"), None, True),
        ("0.5", float("nan"), None, False),
    ],
)
def test_a_printed_number_agrees_to_half_a_unit_of_its_last_digit(text, value, digits, agrees):
    assert printed(text, value, digits=digits) is agrees


def test_constants_of_edges_stand_twice_and_agree():
    assert {key: c for key, c in EDGE_CONSTANTS.items() if key != "fem"} == stored.EDGE_CONSTANTS
    assert EDGE_CONSTANTS["fem"] == EDGE_CONSTANTS["Hex1"]
    second = np.ravel(list(stored.EDGE_BEND.values()))
    assert (*stored.EDGE_MAP.ravel(), *second) == EDGE_MAPS["bem"]
