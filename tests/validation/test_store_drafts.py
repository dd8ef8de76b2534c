"""Files on their way into a store: drafts of the living and the dead, and two processes at once."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from processes import ROOT, environment_of
from solving import Numbers, solve_all

from validation import files
from validation.execution.store import Sealed, Store, check_store
from validation.files import atomic_path, prepare_folder, read_whole, remove_drafts, write_whole


def test_drafts_of_the_dead_are_cleared_and_those_of_the_living_are_not(tmp_path):
    with subprocess.Popen(["true"]) as process:
        process.wait()
    place = files._place()
    dead = f".{place}-{process.pid}-0123456789ab-a.nc"
    alive = f".{place}-{os.getpid()}-0123456789ab-a.nc"
    other = f".00000000-{process.pid}-0123456789ab-a.nc"
    old = f".00000000-{process.pid}-ba9876543210-a.nc"
    for folder in (tmp_path, tmp_path / "figures"):
        folder.mkdir(exist_ok=True)
        for name in (dead, alive, other, old):
            (folder / name).write_text("")
        os.utime(folder / old, (0, 0))
    folder_like_a_draft = tmp_path / f".{place}-{process.pid}-ffffffffffff-a.nc"
    folder_like_a_draft.mkdir()
    prepare_folder(tmp_path)
    assert {path.name for path in tmp_path.glob(".*")} == {alive, other, folder_like_a_draft.name}
    assert {path.name for path in (tmp_path / "figures").glob(".*")} == {alive, other}


def test_no_two_drafts_have_one_name(tmp_path, monkeypatch):
    monkeypatch.setattr(files.os, "getpid", lambda: 7)  # as in two containers
    assert len({files._draft_of(tmp_path / "a.nc") for _ in range(1000)}) == 1000
    remove_drafts(tmp_path / "not there")


def test_a_long_name_keeps_its_suffix(tmp_path):
    with atomic_path(tmp_path / f"{'n' * 200}.nc") as draft:
        assert draft.suffix == ".nc"
        draft.write_text("")


def _race(folder, first):
    store = Store(folder=Path(folder))
    order = [Numbers(k) for k in range(40)]
    done = solve_all(order if first else order[::-1], store)
    assert len({done[solve].attrs["recipe"] for solve in order}) == 40


@pytest.mark.parametrize("races", [1, pytest.param(20, marks=pytest.mark.slow)])
def test_two_processes_on_one_store_do_not_harm_each_other(tmp_path, races):
    code = "import sys; sys.path.insert(0, 'tests/validation'); from test_store_drafts import _race\n"
    code += "_race(sys.argv[1], sys.argv[2] == '0')"
    for race in range(races):
        folder = tmp_path / str(race)
        command = [sys.executable, "-c", code, str(folder)]
        team = [subprocess.Popen([*command, str(k)], cwd=ROOT, env=environment_of()) for k in range(2)]
        assert [process.wait(timeout=120) for process in team] == [0, 0]
        assert len(list(folder.iterdir())) == 40
        assert all(isinstance(found, Sealed) for *_, found in check_store(folder, set_aside=False))


def test_a_file_written_again_is_the_later_one_unless_the_first_is_to_stay(tmp_path):
    for first, last in ((False, b"later"), (True, b"earlier")):
        path = tmp_path / last.decode()
        for content in (b"earlier", b"later"):
            write_whole(path, (content,), **({"first": True} if first else {}))
        assert read_whole(path) == last
