"""`fem-contact run --mpi` with threads in place of processes: its numbers, its file, its refusals."""

import json
import re
import sys
import threading
from dataclasses import asdict

import pytest
from commanding import answer_of, invoke, output_of
from small_scene import ONE_BODY, SQUARE_CELLS
from thread_processes import ThreadComm, run_threads

from fem_contact import contact_areas
from fem_contact.bem import parallel
from validation.cli.parallel import run_parallel
from validation.errors import UsageError
from validation.execution.press import solves_of
from validation.scenes.problem import realise
from validation.scenes.scene import load_scene


def alone():
    return ThreadComm(0, [None], threading.Barrier(1))


EFFECTS = {
    "": "",
    "hardness": 'hardness = "25 kPa"',
    "thickness": 'thickness = "2 um"',
    "coating": 'young = "8 MPa"\nthickness = "0.3 um"',
}


@pytest.mark.parametrize("kind", EFFECTS)
def test_the_command_presses_the_surface_of_the_scene_and_uses_finished_grids_again(
    tmp_path, write_scene, monkeypatch, kind
):
    effect = f'[[effects]]\nkind = "{kind}"\n{EFFECTS[kind]}\n' if kind else ""
    one_body = [ONE_BODY] if "thickness" in effect else []
    effects = ("[methods.bem]", f"{effect}[methods.bem]"), ("[methods.theory]", "")
    path = write_scene(*effects, SQUARE_CELLS, *one_body, fem=False)
    monkeypatch.setattr(parallel, "communicator", alone)
    command, results = f"run {path} --mpi -o {tmp_path / 'out'}", tmp_path / "out" / "mpi"
    found, scene = answer_of(command), load_scene(str(path))
    solves = [solve for solve in solves_of(scene, realise(scene)) if solve.method == "bem" and solve.is_own]
    for row, solve in zip(found["grids"], solves, strict=True):
        expected = contact_areas(solve.do(threads=1).contact, subcell=not effect)
        assert row["grid"] == list(solve.grid)
        for name, value in asdict(expected).items():
            same = value if value is None else pytest.approx(value, rel=1e-9)
            assert row["areas"][name] == same, name
        assert (results / f"{solve.key}.h5").exists()
    record = results / f"{solve.key}.json"
    whole = record.read_bytes()
    record.write_bytes(whole.replace(b'"pixel": 0.', b'"pixel": 7.'))
    outcome = invoke(command, "--json")
    assert f"{record.name}: damaged" in outcome.stderr
    assert json.loads(outcome.stdout)["limit"] == found["limit"]
    record.write_bytes(whole)
    monkeypatch.setattr("fem_contact.bem.solve", None)
    assert answer_of(command) == found
    said = output_of(command)
    assert f"{found['limit']['value']:.6g}" in said
    assert re.search(r"A/A0 counted.*located.*pairs.*seconds.*MiB of a process", said)


def test_all_threads_write_one_file_and_the_first_speaks(tmp_path, read_scene, monkeypatch, capsys):
    scene = read_scene(fem=False)
    # Threads share their modules: each asks for its own communicator by its name.
    own = threading.local()
    monkeypatch.setattr(parallel, "communicator", lambda: own.comm)

    def work(comm):
        own.comm = comm
        run_parallel(scene, tmp_path / "out", as_json=True, unfit={})

    run_threads(3, work)
    assert json.loads(capsys.readouterr().out)["processes"] == 3


def test_what_does_not_go_with_mpi_is_refused_in_one_line(tmp_path, read_scene, monkeypatch):
    def refused(words, *changes, **unfit):
        with pytest.raises(UsageError, match=words):
            run_parallel(read_scene(*changes, fem=False), tmp_path, as_json=True, unfit=unfit)

    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "mpi4py", None)
        refused("--mpi: MPI: needs pip install")
    monkeypatch.setattr(parallel, "communicator", alone)
    refused("--workers: does not go with --mpi", **{"--workers": 2})
    refused("mean_gap: --mpi presses with a load", ("reduced_pressure = 0.1", 'mean_gap = "50 nm"'))
    coarse = ("[12, 8], [24, 16], [48, 32]", "4, 48"), ("shifts = 2", "under_resolved = true")
    refused("under_resolved: not with --mpi", *coarse)
