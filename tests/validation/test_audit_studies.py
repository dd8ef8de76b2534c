"""Studies read back: every number again from the stored solves by other code, and what was not is listed."""

from __future__ import annotations

import csv
import json
import shutil

import numpy as np
import pytest
import xarray as xr
from small_scene import small_scene
from typer.testing import CliRunner

from validation.audit import audit
from validation.audit.studies import JUDGES
from validation.cli.commands import app
from validation.scenes.scene import load_scene
from validation.solves.bench import Bench
from validation.studies import find_study
from validation.studies._outputs import run_study

_ROUGH = {"periods": 2.0, "bandwidth": 2.0, "points_per_wave": (4.0, 6.0, 8.0), "seed": 61}
#: Options of small studies, and what is said of each not to be computed again.
_SMALL = {
    "pressure": (
        {**_ROUGH, "surfaces": 3, "shifts": 1, "reduced_pressures": (0.02, 0.03, 0.3, 4.0)},
        {"theory of gap and energy", "data.nc: theory_gap", "data.nc: theory_energy"},
    ),
    "theory-verdict": (
        {
            **_ROUGH,
            "surfaces": 3,
            "shifts": 1,
            "reduced_pressures": (0.02, 0.03, 0.3, 4.0),
            "edge": False,
            "ladder_reduced_pressures": (),
        },
        {
            "scores of gap, stiffness and energy",
            "data.nc: solver_error",
            "data.nc: ratio",
            "data.nc: interval",
        },
    ),
}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Folders of small studies, each run when it is first asked for, all on one store."""
    root = tmp_path_factory.mktemp("studies")
    bench = Bench.at(root / "solves")

    def left_by(name):
        folder = root / name
        if not folder.exists():
            folder.mkdir()
            study = find_study(name)
            given = {key: value for key, value in _SMALL[name][0].items() if value is not None}
            run_study(study, study.options(**given), folder, bench=bench, report=name == "pressure")
        return folder

    return left_by


def test_each_study_whose_judge_there_is_has_a_small_case_here():
    assert set(_SMALL) == set(JUDGES)


@pytest.mark.parametrize("name", _SMALL)
def test_every_number_of_a_study_follows_from_its_solves_or_is_listed(results, name):
    ledger = audit(results(name))
    assert [str(entry) for entry in ledger.wrong] == []
    unread = [line for line in ledger.unread if not line.startswith("report.html: there is none")]
    allowed = tuple(_SMALL[name][1])
    assert [line for line in unread if not line.startswith(allowed or ("nothing",))] == []
    places = {entry.place for entry in ledger.entries}
    assert {"data.nc", "sentence"} <= places
    assert len(ledger.entries) > 40


@pytest.fixture
def copied(results, tmp_path):
    """A copy of a study to be damaged, with the store beside it."""

    def copy(name):
        source = results(name)
        if not (tmp_path / "solves").exists():
            (tmp_path / "solves").symlink_to(source.parent / "solves")
        return shutil.copytree(source, tmp_path / name)

    return copy


def _edited(folder, name, column, factor):
    """Multiply one number of the first row of a CSV file."""
    path = folder / name
    with path.open(newline="", encoding="utf-8") as file:
        lines = list(csv.reader(file))
    k = lines[0].index(column)
    lines[1][k] = repr(float(lines[1][k]) * factor)
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(lines)


#: Put into tables and budgets: one per cent, a deviation for a standard error, 1.96 for Student's factor.
_WRONG_CELLS = {
    "pressure": [("table.csv", "kappa", 1.01), ("table.csv", "+- (95 %)", np.sqrt(3))],
    "theory-verdict": [("budget.csv", "value", 1.01)],
}


@pytest.mark.parametrize("name", _WRONG_CELLS)
def test_wrong_numbers_in_the_table_and_budget_of_a_study_are_found_where_they_stand(copied, name):
    folder = copied(name)
    for change in _WRONG_CELLS[name]:
        _edited(folder, *change)
    wrong = {(entry.place, entry.name) for entry in audit(folder).wrong}
    assert wrong == {(table, f"{column}, row 1") for table, column, _ in _WRONG_CELLS[name]}


#: Variables of the dataset, the mistake that changes them, and by how much.
_WRONG_DATA = {
    "pressure": {
        "energy": ("stored energy without 1/2", 2.0),
        "gamma": ("log10 for ln", np.log(10)),
        "stress_share": ("share not normalised", 24.0**2),
    },
    "theory-verdict": {"shares": ("one sigma", 0.5), "distance": ("another load", 1.1)},
}


@pytest.mark.parametrize("name", _WRONG_DATA)
def test_mistakes_in_the_dataset_of_a_study_are_found_by_the_names_of_the_variables(copied, name):
    path = copied(name) / "data.nc"
    data = xr.load_dataset(path)
    data.assign({key: data[key] * factor for key, (_, factor) in _WRONG_DATA[name].items()}).to_netcdf(path)
    wrong = [entry.name.split(" at ")[0] for entry in audit(path.parent).wrong if entry.place == "data.nc"]
    assert set(_WRONG_DATA[name]) <= set(wrong)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("theory-verdict", ("is closest", "is not closest")),
    ],
)
def test_a_sentence_that_turns_the_other_way_is_found(copied, name, words):
    folder = copied(name)
    path = folder / "summary.json"
    said = json.loads(path.read_text())
    k = next(k for k, sentence in enumerate(said["findings"]) if words[0] in sentence)
    said["findings"][k] = said["findings"][k].replace(*words)
    path.write_text(json.dumps(said))
    assert {entry.place for entry in audit(folder).wrong} == {"sentence"}


def test_a_study_nobody_computes_again_and_a_store_that_is_gone_are_listed(copied):
    folder = copied("pressure")
    path = folder / "study.json"
    said = json.loads(path.read_text())
    path.write_text(json.dumps({**said, "store": "nowhere"}))
    ledger = audit(folder)
    assert ledger.wrong == ()
    assert any("names no store that holds any" in line for line in ledger.unread)
    assert "data.nc: area" in ledger.unread
    path.write_text(json.dumps({**said, "study": "scaling"}))
    (folder / "summary.json").write_text(
        json.dumps({"study": "scaling", "options": said["options"], "findings": ["x"]})
    )
    unread = audit(folder).unread
    assert any(line.startswith("the numbers of the study scaling") for line in unread)
    assert "sentence: x" in unread


_SCENE = small_scene()


def test_a_study_on_a_scene_is_listed_not_taken_for_the_one_on_its_own_surfaces(tmp_path):
    (tmp_path / "mine.toml").write_text(_SCENE)
    study, folder = find_study("area"), tmp_path / "area"
    folder.mkdir()
    options = study.options(
        scene=load_scene(str(tmp_path / "mine.toml")), reduced_pressures=(0.1, 0.2), surfaces=2
    )
    run_study(study, options, folder, bench=Bench.at(tmp_path / "solves"), report=False)
    ledger = audit(folder)
    assert [str(entry) for entry in ledger.wrong] == []
    assert any(line.startswith("the numbers of the study area") for line in ledger.unread)
    sentences = [one["text"] for one in json.loads((folder / "summary.json").read_text())["findings"]]
    assert sentences
    assert {f"sentence: {sentence}" for sentence in sentences} <= set(ledger.unread)


def test_the_command_audits_a_study_and_exits_with_one_where_a_number_disagrees(copied):
    folder = copied("pressure")
    sound = CliRunner().invoke(app, ["audit", str(folder)])
    assert sound.exit_code == 0
    assert "table.csv: 70 agree" in sound.output
    assert "not judged: theory of gap and energy" in sound.output
    _edited(folder, "table.csv", "kappa", 1.01)
    assert CliRunner().invoke(app, ["audit", str(folder)]).exit_code == 1
