"""Every file that a command opens is refused in a line once it was changed; runs at once end well."""

from __future__ import annotations

import os
import random
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from small_scene import small_scene
from typer.testing import CliRunner

from validation import reference
from validation.cli.commands import app
from validation.errors import RunFailed, UsageError
from validation.files import locked

#: Of each file: by chance a bit, a digit, the end, or a block.
COUNTS = [3, pytest.param(200, marks=pytest.mark.nightly)]
#: Files of the results whose numbers a command takes; figures and pages are written, and read by nobody else.
READ = {
    "report": {"result.json", "data.nc"},
    "compare": {"result.json", "data.nc"},
    "audit": {"result.json", "data.nc", "shown.json", "summary.json", "report.html"},
}
#: What is opened goes to the last of these.
_watched: list[list[Path]] = []


def _watch(event, arguments):
    if _watched and event == "open" and isinstance(arguments[0], str | bytes | os.PathLike):
        mode, flags = arguments[1:]
        if not ("w" in str(mode) or int(flags or 0) & (os.O_WRONLY | os.O_RDWR | os.O_DIRECTORY)):
            _watched[-1].append(Path(os.fsdecode(arguments[0])))


sys.addaudithook(_watch)


def opened_by(*arguments: str) -> set[Path]:
    """Files that a command opens to read."""
    _watched.append([])
    try:
        outcome = CliRunner().invoke(app, list(arguments))
        assert outcome.exit_code == 0, outcome.output or outcome.exception
        return {path for path in _watched[-1] if path.is_file()}
    finally:
        _watched.pop()


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Two runs of the small scene, and what it takes to run each command on the first."""
    place = tmp_path_factory.mktemp("opened")
    for name in ("a", "b"):
        (place / f"{name}.toml").write_text(small_scene(grids="[12, 24]"))
        arguments = ["run", str(place / f"{name}.toml"), "-o", str(place / name), "-q"]
        assert CliRunner().invoke(app, arguments).exit_code == 0
    return place


def _command(name: str, place: Path) -> list[str]:
    more = {"compare": [str(place / "b"), "-o", str(place / "c"), "--no-report"], "report": ["--no-pictures"]}
    return [name, str(place / "a"), *more.get(name, [])]


def _damaged(whole: bytes, chance: random.Random) -> bytes:
    data, at = bytearray(whole), chance.randrange(len(whole))
    match chance.randrange(4):
        case 0:
            data[at] ^= 1 << chance.randrange(8)
        case 1:
            digits = [k for k, byte in enumerate(data) if 48 <= byte <= 57]
            k = chance.choice(digits or [at])
            data[k] = 48 + (data[k] - 47) % 10
        case 2:
            del data[at:]
        case _:
            data[at : at + 64] = bytes(len(data[at : at + 64]))
    return bytes(data)


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("name", sorted(READ))
def test_no_file_that_a_command_opens_is_believed_once_it_was_changed(results, name, count, tmp_path):
    place = shutil.copytree(results, tmp_path / "place")
    files = {path for path in opened_by(*_command(name, place)) if path.is_relative_to(place / "a")}
    numbers = {path for path in files if path.parent.name != "figures" or path.suffix == ".nc"}
    written = {path for path in numbers if name == "report" and path.name not in READ[name]}
    numbers -= written  # what it has just made is read for the page and its digests
    assert {path.name for path in numbers} >= READ[name], "the trace sees what is read"
    chance = random.Random(17)
    for path in sorted(numbers):
        whole = path.read_bytes()
        for _ in range(count):
            changed = _damaged(whole, chance)
            if changed.strip() == whole.strip():
                continue
            path.write_bytes(changed)
            outcome = CliRunner().invoke(app, _command(name, place))
            assert outcome.exit_code != 0, f"{path}: silent"
            assert isinstance(outcome.exception, UsageError | RunFailed), (path, repr(outcome.exception))
            assert path.name in str(outcome.exception), (path, outcome.exception)
            assert "\n" not in str(outcome.exception)
        path.write_bytes(whole)


@pytest.mark.parametrize("count", COUNTS)
def test_the_table_that_is_shipped_is_not_believed_once_it_was_changed(count, tmp_path, monkeypatch):
    whole = Path(reference.__file__).with_name("table.nc").read_bytes()
    monkeypatch.setattr(reference.resources, "files", lambda package: tmp_path)
    chance = random.Random(18)
    for _ in range(10 * count):
        (tmp_path / "table.nc").write_bytes(_damaged(whole, chance))
        if (tmp_path / "table.nc").read_bytes() == whole:
            continue
        with pytest.raises(RunFailed, match=r"table\.nc: damaged: .*; install fem-contact again$"):
            reference.table()


def test_while_one_process_writes_into_a_folder_others_wait_or_say_so(tmp_path, monkeypatch):
    words = f"import sys; from validation.files import locked\nwith locked({str(tmp_path)!r}):\n"
    script = words.replace("import sys;", "import sys; from pathlib import Path;").replace(
        repr(str(tmp_path)), f"Path({str(tmp_path)!r})"
    )
    script += "    print('in', flush=True)\n    sys.stdin.read()"
    other = subprocess.Popen(
        [sys.executable, "-c", script], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert other.stdout.readline() == "in\n"
    monkeypatch.setattr("validation.files._PATIENCE", 0.2)
    for shared in (False, True):
        with pytest.raises(RunFailed, match="another run is writing there"), locked(tmp_path, shared=shared):
            pass
    other.communicate()
    with locked(tmp_path), locked(tmp_path, shared=True):
        pass


@pytest.mark.parametrize(("at_once", "rounds"), [(2, 1), pytest.param(10, 20, marks=pytest.mark.nightly)])
def test_runs_at_once_in_one_folder_each_end_well(tmp_path, at_once, rounds):
    for k in range(2):
        (tmp_path / f"{k}.toml").write_text(small_scene(grids="[12, 24]").replace("seed = 77", f"seed = {k}"))
    for _ in range(rounds):
        runs = [
            subprocess.Popen(
                [sys.executable, "-m", "validation.cli", "run", f"{k % 2}.toml", "-o", "out", "-q"],
                cwd=tmp_path,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            )
            for k in range(at_once)
        ]
        for run in runs:
            said = run.communicate(timeout=600)[0]
            assert run.returncode == 0 or "another run is writing there" in said, said
        outcome = CliRunner().invoke(app, ["audit", str(tmp_path / "out")])
        assert outcome.exit_code == 0, outcome.output or outcome.exception
