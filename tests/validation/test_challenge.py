"""The scorecard by files: a solver in plain C goes round, in whole and in part."""

import json
import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from commanding import answer_of, invoke

from validation.cases.scorecard import challenge, ladder
from validation.cases.scorecard.challenge import export, score_folder
from validation.cases.scorecard.subject import Subject
from validation.errors import UsageError

#: Rows that ask for more than a pressure under a load on the half-space.
BEYOND = {"layer", "yielding-wave", "offset", "offset-near-full", "cut-short"}
SOURCE = Path(__file__).with_name("polonsky_keer.c")


@pytest.fixture(scope="module")
def problems(tmp_path_factory):
    folder = tmp_path_factory.mktemp("challenge")
    export(folder, points=16, tolerance=1e-6)
    return folder


@pytest.fixture
def folder(problems, tmp_path):
    """A copy that may be answered."""
    return Path(shutil.copytree(problems, tmp_path / "mine"))


@pytest.fixture(scope="module")
def answered(problems, tmp_path_factory):
    """Answers of the solver in C to every problem."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler")
    place = tmp_path_factory.mktemp("solver")
    solver, folder = place / "solver", Path(shutil.copytree(problems, place / "answered"))
    subprocess.run([compiler, "-O2", "-o", solver, SOURCE, "-lm"], check=True)
    for problem in sorted(folder.glob("problem-*")):
        subprocess.run([solver], cwd=problem, check=True, timeout=120)
        (problem / "answer.json").write_text('{"seconds": 0.25, "iterations": 12}')
    return folder


def test_a_solver_in_plain_c_passes_every_row(answered):
    (card,) = answer_of("challenge score", answered)["scorecards"]
    assert card["passed"]
    assert set(card["left_out"]) == BEYOND
    assert {"hertz", "westergaard", "honesty", "rough-4"} <= {row["case"] for row in card["rows"]}
    # The memory was not measured.
    costs = [(row["seconds"], row["iterations"], row["peak_bytes"]) for row in card["cost"]]
    assert costs == [(0.25, 12, 0)] * 2
    (place,) = answered.glob("problem-004")
    shape = tuple(json.loads((place / "problem.json").read_text(encoding="utf-8"))["shape"])
    cost = challenge._claim(place, shape).cost
    assert (cost.wall_seconds, cost.cpu_seconds, cost.unknowns) == (0.25, 0.25, math.prod(shape))


def test_answers_that_are_wrong_by_a_factor_are_named(answered, tmp_path):
    folder = Path(shutil.copytree(answered, tmp_path / "doubled"))
    for file in folder.glob("problem-*/pressure.txt"):
        pressure = np.loadtxt(file)
        np.savetxt(file, 2 * (pressure - pressure.mean()) + pressure.mean())
    outcome = invoke("challenge score", folder, "--json")
    assert outcome.exit_code == 1
    (card,) = json.loads(outcome.stdout.partition("\nfem-contact:")[0])["scorecards"]
    failed = {row["case"] for row in card["rows"] if not row["passed"]}
    assert {"tension", "full-contact", "honesty"} <= failed


def test_what_is_not_answered_is_left_out_and_said_so(answered, tmp_path):
    folder = Path(shutil.copytree(answered, tmp_path / "part"))
    for place in folder.glob("problem-*"):
        said = json.loads((place / "problem.json").read_text(encoding="utf-8"))
        if said["shape"][0] % 2:
            (place / "pressure.txt").unlink()
    card = score_folder(folder)
    assert set(card.left_out) == {"odd-axes"} | BEYOND
    assert "has no answer" in card.left_out["odd-axes"]
    assert not card.failed


def test_each_grid_whose_cost_is_told_is_a_problem(tmp_path):
    problems = challenge._problems(tmp_path, 32, 1e-6)
    recorder = challenge._Recorder(32)
    costs = ladder.cost(Subject(name="recorder", solver=recorder, settings={}, seconds=math.inf))
    assert len(costs) == len(recorder.jobs) == 3
    asked = {job.field.heights.tobytes() for job in recorder.jobs.values()}
    assert asked <= {job.field.heights.tobytes() for job in problems.values()}


def test_problems_say_everything_but_what_they_are(problems):
    folders = sorted(problems.glob("problem-*"))
    assert len(folders) > 30
    for place in folders:
        names = {file.name for file in place.iterdir()}
        assert names == {"heights.npy", "heights.txt", "parameters.txt", "problem.json"}
        said = json.loads((place / "problem.json").read_text(encoding="utf-8"))
        heights = np.load(place / "heights.npy")
        np.testing.assert_array_equal(np.loadtxt(place / "heights.txt"), heights)
        assert list(heights.shape) == said["shape"]
        physical = (said[name] for name in ("contact_modulus_Pa", "mean_pressure_Pa", "tolerance"))
        numbers = [*said["shape"], *said["lengths_m"], *physical]
        assert np.loadtxt(place / "parameters.txt").tolist() == numbers
        words = json.dumps(said).lower()
        assert not any(name in words for name in ("hertz", "westergaard", "honesty", "symmetry", "rough-"))


def test_an_answer_of_another_shape_is_refused_by_name(folder):
    np.save(folder / "problem-004" / "pressure.npy", np.zeros((3, 3)))
    with pytest.raises(UsageError, match=r"problem-004.*shape \(3, 3\): must be that of the heights"):
        score_folder(folder)


def test_an_answer_whose_header_is_damaged_is_refused_by_name(folder):
    file = folder / "problem-004" / "pressure.npy"
    np.save(file, np.zeros((3, 3)))
    file.write_bytes(file.read_bytes().replace(b"}", b" "))  # NumPy raises what its tokenizer does
    with pytest.raises(UsageError, match=r"problem-004.*cannot be read"):
        score_folder(folder)


def test_what_is_no_answered_challenge_is_refused_and_none_is_exported_over(folder, tmp_path):
    with pytest.raises(UsageError, match="no answer"):
        score_folder(folder)
    with pytest.raises(UsageError, match="fem-contact challenge export"):
        score_folder(tmp_path)
    with pytest.raises(UsageError, match="holds a challenge already"):
        export(folder, points=16, tolerance=1e-6)
