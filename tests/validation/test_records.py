"""What a results folder is read back from: changed by a bit or by hand, too long, a link: never believed."""

import json
import os
import random

import pytest
from solving import Numbers

from validation import files
from validation.errors import RunFailed, UsageError
from validation.execution import store as store_module
from validation.execution.attempt import attempt
from validation.execution.bench import Bench
from validation.execution.results import read_results, show, write_results
from validation.execution.store import Store, read_numbers, write_numbers
from validation.files import prepare_folder, read_record, write_record
from validation.studies import area, find_study
from validation.studies._outputs import run_study, study_page

VALUES = {"format": "x 1", "scene": {"a": 0.1, "b": [1, 2.5e-300, None]}, "store": "solves"}


@pytest.mark.parametrize("count", [500, pytest.param(20_000, marks=pytest.mark.slow)])
def test_no_damage_to_a_record_passes_in_silence(tmp_path, count):
    path = write_record(tmp_path / "x.json", VALUES)
    whole, rng = path.read_bytes(), random.Random(6)
    assert json.loads(whole)["scene"] == read_record(path)["scene"] == VALUES["scene"]
    for _ in range(count):
        data = bytearray(whole)
        if rng.random() < 0.7:
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        else:
            start = rng.randrange(len(data))
            data[start : start + rng.choice((1, 16, 64))] = b"\0" * rng.randrange(3)
        path.write_bytes(data)
        try:
            found = read_record(path)
        except ValueError:
            continue
        assert found == VALUES, "other blanks, the same values"


def test_what_is_no_record_is_a_value_error(tmp_path):
    others = {b"": "Expecting value", b"[" * 200_000: "nested too deep", b"{\xff}": "decode"}
    for content, words in (others | dict.fromkeys((b"[]", b'{"sha256": 3}'), "not what was written")).items():
        (tmp_path / "x.json").write_bytes(content)
        with pytest.raises(ValueError, match=words):
            read_record(tmp_path / "x.json")


def test_a_record_of_gigabytes_a_link_and_a_pipe_are_not_read(tmp_path):
    path = tmp_path / "result.json"
    with path.open("wb") as file:
        file.truncate(2**36)
    with pytest.raises(UsageError, match=r"68719476736 bytes long; at most 16777216 are read"):
        read_results(tmp_path)
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(UsageError, match="not a regular file"):
        read_results(tmp_path)
    path.unlink()
    path.symlink_to("/dev/zero")
    with pytest.raises(UsageError, match="holds no finished results"):
        read_results(tmp_path)


def test_a_stored_file_larger_than_memory_is_refused_unread_and_stays(tmp_path, monkeypatch):
    monkeypatch.setattr(store_module, "available_memory", lambda: 2**20)
    monkeypatch.setattr(store_module, "_SURELY_FITS", 2**20)
    store, solve = Store(folder=tmp_path), Numbers(3)
    assert attempt(solve, store).error is None
    with store.path(solve).open("r+b") as file:
        file.truncate(2**40)
    with pytest.raises(RunFailed, match="larger than the memory that is free"):
        store.read(solve)
    assert store.path(solve).stat().st_size == 2**40


def _kept(folder, **asked):
    data = Numbers(2).do()
    write_results(folder, data, kind="run", name="x", settings=asked, store=folder / "s", words=["a word"])
    return data


def test_what_was_written_comes_back(tmp_path):
    kept = _kept(tmp_path, scene={"hurst": 0.8})
    found = read_results(tmp_path)
    assert found.data.equals(kept)
    assert (found.kind, found.name, found.words) == ("run", "x", ("a word",))
    assert found.settings == {"scene": {"hurst": 0.8}}
    assert found.store == (tmp_path / "s").resolve()


def test_a_record_or_dataset_changed_by_hand_or_swapped_is_refused(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    _kept(tmp_path / "a", scene={"hurst": 0.8})
    _kept(tmp_path / "b", scene={"hurst": 0.7})
    path = tmp_path / "a" / "result.json"
    text = path.read_text()
    path.write_text(text.replace("0.8", "0.7"))
    with pytest.raises(UsageError, match=r"result\.json is not what was written \(SHA-256\).*run it again"):
        read_results(tmp_path / "a")
    path.write_text(text)
    (tmp_path / "a" / "data.nc").write_bytes((tmp_path / "b" / "data.nc").read_bytes())
    with pytest.raises(UsageError, match=r"data\.nc: damaged"):
        read_results(tmp_path / "a")


@pytest.mark.parametrize("name", ["run.json", "sweep.json", "study.json"])
def test_a_record_of_an_earlier_version_is_refused_by_name_with_the_remedy(tmp_path, name):
    (tmp_path / name).write_text("{}")
    with pytest.raises(UsageError, match=rf"{name} is of an earlier version\); run it again"):
        read_results(tmp_path)


def test_a_study_says_how_its_solves_were_made_and_a_changed_one_is_not_reported(tmp_path):
    study = find_study("area")
    options = area.Options(grids=(12, 16), periods=1.6, bandwidth=2.5, hurst=0.7, surfaces=2, seed=21)
    prepare_folder(tmp_path / "out")
    first = run_study(study, options, tmp_path / "out", bench=Bench.at(tmp_path / "s"), report=False)
    made = first.data.attrs["solves_made"].splitlines()
    assert made[0].startswith(f"{len(list((tmp_path / 's').glob('*.nc')))} solves, done ")
    again = run_study(study, options, tmp_path / "out", bench=Bench.at(tmp_path / "s"), report=False)
    assert again.page.facts == first.page.facts == tuple(made), "of the solves, not of this run"
    data = bytearray((tmp_path / "out" / "data.nc").read_bytes())
    data[300] ^= 2
    (tmp_path / "out" / "data.nc").write_bytes(data)
    with pytest.raises(UsageError, match=r"data\.nc: damaged: .*run it again"):
        show(tmp_path / "out", study_page)
    (tmp_path / "out" / "result.json").write_text("{}")
    with pytest.raises(UsageError, match=r"holds no finished results \(result\.json is not what was written"):
        show(tmp_path / "out", study_page)
    assert files.read_whole(tmp_path / "out" / "data.nc") == bytes(data)


def _mark(path):
    """Make a file older than all code, so that one sees whether it is written again."""
    os.utime(path, (1e9, 1e9))


def test_a_page_of_the_same_numbers_stands_until_it_or_its_code_changes(tmp_path):
    study, bench = find_study("area"), Bench.at(tmp_path / "s")
    few = {"grids": (12, 16), "periods": 1.6, "bandwidth": 2.5, "hurst": 0.7, "surfaces": 2}
    out = prepare_folder(tmp_path / "out")

    def again(seed=21, **how):
        return run_study(study, study.options(seed=seed, **few), out, bench=bench, **how)

    def kept(*names):
        return {name for name in names if (out / name).stat().st_mtime == 1e9}

    names = ("result.json", "data.nc", "report.html", "figures/area.svg", "table.csv")
    first = again()
    for name in names:
        _mark(out / name)
    assert again().files == first.files
    assert kept(*names) == set(names)
    # The reader asks for it, or for tables alone.
    show(out, study_page)
    assert kept(*names) == {"result.json", "data.nc"}
    again(report=False)
    assert not (out / "report.html").exists()
    assert again().files == first.files
    # A file that is gone, one that is not what was written, code that is younger: all is written again.
    for spoil in (
        (out / "figures/area.svg").unlink,
        lambda: (out / "table.csv").write_text("0"),
        lambda: _mark(out / "shown.json"),
    ):
        _mark(out / "report.html")
        spoil()
        assert again().files == first.files
        assert kept("report.html", "result.json") == {"result.json"}
        assert (out / "figures/area.svg").exists()
        assert (out / "table.csv").read_text() != "0"
    again(seed=22)
    assert not kept("result.json", "data.nc")


def test_numbers_of_a_sweep_or_study_are_sealed(tmp_path):
    data = Numbers(2).do()
    write_numbers(tmp_path / "data.nc", data, recipe={"a": 1})
    assert read_numbers(tmp_path / "data.nc").equals(data)
    with pytest.raises(RunFailed, match="is not there; run it again"):
        read_numbers(tmp_path / "other.nc")
