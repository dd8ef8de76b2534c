"""Damage to any file that a command opens is told in a line, or changes no number; runs at once end well."""

import contextlib
import json
import os
import random
import re
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from commanding import invoke
from small_scene import small_scene

import validation
from validation import files, reference
from validation.cases.scorecard import challenge
from validation.effects import effect_kinds
from validation.errors import RunFailed, UsageError
from validation.execution import calibration
from validation.files import locked
from validation.solvers import find_solver

#: Of each file: by chance a bit, a digit, the end, or a block.
NIGHTLY = pytest.mark.nightly
COUNTS = [1, pytest.param(200, marks=NIGHTLY)]
#: What makes results of each kind; the same command takes up what is finished.
MADE = {
    "run": "run scene.toml",
    "sweep": "run sweep.toml",
    "accuracy": "run scene.toml --accuracy 20%",
    "study": "study stress-near-zero --surfaces 2 --points-per-wave 4,8,12 --periods 2 --bandwidth 2",
    "sliding": "study sliding --velocities 0.01,1 --surfaces 2 --points-per-wave 4,8 --periods 1",
    "conductance": "study conductance --reduced-pressures 0.02,0.1 --surfaces 2 --periods 1 --bandwidth 2",
    "validate": "validate units",
    "reproduce": "reproduce",
}
#: What reads them, and what else reads numbers.
COMMANDS = {
    **{f"{name} again": f"{MADE[name]} -o {name} --no-report" for name in list(MADE)[:-2]},
    **{f"report of {name}": f"report {name}" for name in MADE},
    **{f"compare of {name}": f"compare {name} other -o compared --no-report" for name in MADE},
    **{f"audit of {name}": f"audit {name}" for name in MADE},
    "challenge": "challenge score challenge",
    "inspect": "surface inspect rough.nc",
    "calibration": "explain scene.toml --set hardness=20kPa",
    "reference": "reference --hurst 0.8 --bandwidth 16 --reduced-pressure 0.05",
    "wide reference": "reference --hurst 0.8 --bandwidth 64 --reduced-pressure 0.05",
    "score": "reference --theory persson --csv areas.csv -o scored",
}
#: Written by a user, who alone knows the numbers; they are read or refused.
_BY_HAND = {"scene.toml", "sweep.toml", "pressure.npy", "answer.json", "areas.csv"}
#: Text of the program, which nothing verifies but who installs it.
_SOURCES = {".py", ".pyc", ".toml", ".j2", ".js"}
#: Opened here: in a child process, where nobody watches.
_BY_A_CHILD = {"inspect": {"rough.nc"}}
#: Long to make, or read by what reads the others, too.
_LONG = re.compile("reproduce|sliding|conductance|sweep|accuracy|study|of validate|wide")
_TIMES = re.compile("second|bytes|date|when|host|cost|made|version")
#: What is opened goes to the last of these.
_watched: list[tuple[list[Path], set[Path]]] = []


def _watch(event, arguments):
    if _watched and event == "os.rename":
        _watched[-1][1].add(Path(os.path.realpath(os.fsdecode(arguments[1]))))
    if _watched and event == "open" and isinstance(arguments[0], str | bytes | os.PathLike):
        mode, flags = arguments[1:]
        if not ("w" in str(mode) or int(flags or 0) & (os.O_WRONLY | os.O_RDWR | os.O_DIRECTORY)):
            opened, written = _watched[-1]
            path = Path(os.path.realpath(os.fsdecode(arguments[0])))
            opened += [path] if path not in written else []


sys.addaudithook(_watch)


def _do(command):
    shutil.rmtree("compared", ignore_errors=True)
    return invoke(command)


def opened_by(command):
    """Files that a command opens to read, which it has not written itself; its numbers."""
    _watched.append(([], set()))
    try:
        outcome = _do(command)
        assert outcome.exit_code == 0, outcome.output or outcome.exception
        return {path for path in _watched[-1][0] if path.is_file()}, _numbers(outcome)
    finally:
        _watched.pop()


def _numbers(outcome):
    """What a command prints, without times, costs and names of machines."""

    def kept(value):
        if isinstance(value, dict):
            return {k: kept(v) for k, v in value.items() if not _TIMES.search(k)}
        if isinstance(value, list):
            return [kept(v) for v in value if not (isinstance(v, dict) and v.get("kind") == "cost")]
        return None if isinstance(value, str) and _TIMES.search(value) else value

    return json.dumps(kept(json.loads(outcome.stdout)), sort_keys=True)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A folder in which each kind of results is made once, when a command first asks for it."""
    place = tmp_path_factory.mktemp("opened")
    scene = small_scene(grids="[12, 24]")
    for name in ("table.nc", "wide.nc"):
        shutil.copy(Path(reference.__file__).with_name(name), place)
    (place / "scene.toml").write_text(scene)
    (place / "areas.csv").write_text("hurst,bandwidth,reduced_pressure,area\n0.8,16,0.05,0.1\n")
    (place / "sweep.toml").write_text(scene + '[sweep]\n"load.reduced_pressure" = [0.1, 0.2]\n')
    return place


def _made(place, name):
    kind = next((kind for kind in MADE if kind in name.split()), "")
    if kind and not (place / kind).exists():
        bare = {"run": "-q", "reproduce": "--no-figures"}.get(kind, "--no-report")
        assert _do(f"{MADE[kind]} -o {kind} {bare}").exit_code == 0
    if name.startswith("compare"):
        shutil.rmtree(place / "other", ignore_errors=True)
        shutil.copytree(place / kind, place / "other")
    if name == "inspect":
        assert _do("surface generate scene.toml rough.nc --force").exit_code == 0
    if name == "calibration":
        measured = {n for n, kind in effect_kinds().items() if find_solver("bem").handles(kind)}
        factors = dict.fromkeys(sorted(measured), 1.5)
        files.write_record(place / "costs.json", {"date": "2026-01-01", "points": 32, "factors": factors})
    if name == "challenge":
        assert _do("challenge export challenge").exit_code == 0
        for folder, job in challenge._problems(place / "challenge", 16, 1e-6).items():
            np.save(folder / "pressure.npy", find_solver("bem").claim(job).pressure)
            (folder / "answer.json").write_text('{"seconds": 0.25, "iterations": 12}')


def _damaged(whole, chance):
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


def _alike(changed, whole):
    """Whether a record says the same all the same, as 1E-08 does for 1e-08."""
    with contextlib.suppress(ValueError):
        return json.dumps(json.loads(changed)) == json.dumps(json.loads(whole))
    return changed.strip() == whole.strip()


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("name", [pytest.param(n, marks=[NIGHTLY] * bool(_LONG.search(n))) for n in COMMANDS])
def test_no_file_that_a_command_opens_is_believed_once_changed(results, name, count, monkeypatch, tmp_path):
    monkeypatch.chdir(results)
    _made(results, name)
    place = Path(shutil.copytree(results, tmp_path / "place"))
    monkeypatch.chdir(place)
    monkeypatch.setattr(calibration, "cache_file", lambda: place / "costs.json")
    shipped = SimpleNamespace(**{**vars(reference.resources), "files": lambda _: place})
    monkeypatch.setattr(reference, "resources", shipped)
    command = f"{COMMANDS[name]} --json"
    opened, numbers = opened_by(command)
    opened |= {place / path for path in _BY_A_CHILD.get(name, ())}
    inside = {path for path in opened if path.is_relative_to(place) and "compared" not in path.parts}
    assert inside - {place / path for path in _BY_HAND}, "the trace sees what is read"
    shipped = {path.suffix for path in opened if path.is_relative_to(Path(validation.__file__).parent)}
    assert shipped <= _SOURCES, "shipped numbers are damaged, too"
    chance, told = random.Random(17), dict.fromkeys(("refused", "the same numbers", "by hand"), 0)
    once = {path.name if path.name in _BY_HAND else path: path for path in sorted(inside)}
    for path in once.values():
        whole = path.read_bytes()
        for _ in range(count):
            changed = _damaged(whole, chance)
            path.write_bytes(changed)
            outcome = _do(command)
            seen = f"{command}: {path}: {outcome.output[-500:]!r}: {outcome.exception!r}"
            if outcome.exit_code:
                told["refused"] += 1
                assert isinstance(outcome.exception, UsageError | RunFailed), seen
                line = rf"[^\n]*{re.escape(path.name)}\b[^\n]*[;:][^\n]*"
                assert path.name in _BY_HAND or re.fullmatch(line, str(outcome.exception)), seen
            elif path.name in _BY_HAND or _alike(changed, whole):
                told["by hand"] += 1
            else:
                told["the same numbers"] += 1
                assert _numbers(outcome) == numbers, seen
                assert path.name in outcome.output or path.read_bytes() != changed, seen
            path.write_bytes(whole)
    print(name, len(once), "files", told)


def test_while_one_process_writes_into_a_folder_others_wait_or_say_so(tmp_path, monkeypatch):
    script = "import sys; from pathlib import Path; from validation.files import locked\n"
    script += f"with locked(Path({str(tmp_path)!r})):\n    print('in', flush=True)\n    sys.stdin.read()"
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    other = subprocess.Popen([sys.executable, "-c", script], **pipes)
    assert other.stdout.readline() == "in\n"
    monkeypatch.setattr("validation.files._PATIENCE", 0.2)
    for shared in (False, True):
        with pytest.raises(RunFailed, match="another run is writing there"), locked(tmp_path, shared=shared):
            pass
    other.communicate()
    with locked(tmp_path), locked(tmp_path, shared=True):
        pass


def test_a_system_without_locks_says_so_once(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("validation.files.fcntl", None)
    for _ in range(2):
        with locked(tmp_path):
            pass
    words = "fem-contact: no locks on this system: start one run at a time into a folder\n"
    assert capsys.readouterr().err == words


@pytest.mark.nightly
def test_runs_at_once_in_one_folder_each_end_well(tmp_path):
    for k in range(3):
        (tmp_path / f"{k}.toml").write_text(small_scene(grids="[12, 24]").replace("seed = 77", f"seed = {k}"))
    for _ in range(20):
        shutil.rmtree(tmp_path / "out", ignore_errors=True)  # so that they solve, and the same ones at once
        command = [sys.executable, "-m", "validation.cli", "run", "-o", "out", "-q"]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True, "cwd": tmp_path}
        runs = [subprocess.Popen([*command, f"{k % 3}.toml"], **pipes) for k in range(10)]
        for run in runs:
            said = run.communicate(timeout=600)[0]
            assert run.returncode == 0 or "another run is writing there" in said, said
        outcome = invoke("audit", tmp_path / "out")
        assert outcome.exit_code == 0, outcome.output or outcome.exception
        assert not [path for path in (tmp_path / "out").rglob("*") if path.name.startswith(".")], "drafts"
