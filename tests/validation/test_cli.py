"""The command line: exit codes, one-line errors, output for people and for scripts."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest


def fem_contact(*arguments: str, cwd) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "validation.cli", *arguments],
        capture_output=True,
        text=True,
        cwd=cwd,
        timeout=300,
        check=False,
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("run", "nowhere"), "no such scene"),
        (("explain", "missing.toml"), "cannot be read"),
        (("scenes", "show", "nothing"), "no such scene"),
    ],
)
def test_a_mistake_is_one_line_on_stderr_and_exit_code_2(tmp_path, arguments, words):
    done = fem_contact(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert words in done.stderr
    assert done.stderr.count("\n") == 1


def test_an_unknown_option_is_exit_code_2_without_a_traceback(tmp_path):
    done = fem_contact("run", "--frobnicate", cwd=tmp_path)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr


def test_run_prints_the_table_and_json_on_request(tmp_path, write_scene):
    path = write_scene(fem=False)
    done = fem_contact("run", str(path), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for column in ("method", "grid", "A/A0, counted", "kappa"):
        assert column in done.stdout
    assert (tmp_path / "results" / "small" / "report.html").exists()
    again = fem_contact("run", str(path), "--json", cwd=tmp_path)
    said = json.loads(again.stdout)
    assert said["kind"] == "run"
    assert said["findings"][0]["values"]


def test_explain_says_what_runs_and_what_is_left_out_and_solves_nothing(tmp_path):
    done = fem_contact("explain", "quickstart", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for words in ("512 x 512", "unknowns", "seconds", "MiB", "adhesion", "hardness", "unknown without"):
        assert words in done.stdout
    assert list(tmp_path.iterdir()) == []
    data = json.loads(fem_contact("explain", "quickstart", "--json", cwd=tmp_path).stdout)
    assert {grid["method"] for grid in data["grids"]} == {"bem", "fem"}


def test_scenes_are_listed_and_copied(tmp_path):
    assert "quickstart" in fem_contact("scenes", "list", cwd=tmp_path).stdout
    assert fem_contact("scenes", "copy", "quickstart", "mine.toml", cwd=tmp_path).returncode == 0
    shown = fem_contact("scenes", "show", "quickstart", cwd=tmp_path).stdout
    # Its file names it: with the name of the original it would write over that one's results.
    assert (tmp_path / "mine.toml").read_text() == shown.replace('name = "quickstart"\n', "")
    refused = fem_contact("scenes", "copy", "quickstart", "mine.toml", cwd=tmp_path)
    assert refused.returncode == 2
    assert "File exists" in refused.stderr
