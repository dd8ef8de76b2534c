"""Workers, local and on a cluster: what dies is told, waited for, and charged to whom it belongs."""

import contextlib
import errno
import itertools
import math
import re
import shutil
import socket
import subprocess
import sys
import threading
import time
import types
from pathlib import Path

import psutil
import pytest
from processes import ROOT, environment_of, run_python
from refusing import refused
from solving import (
    Deadly,
    DiesAtStart,
    Foretold,
    Held,
    Killing,
    Notes,
    Numbers,
    Slow,
    dask_cluster,
    solve_all,
    still_running,
)

from validation.errors import RunFailed, UsageError
from validation.execution.attempt import Outcome
from validation.execution.store import Store
from validation.files import prepare_folder
from validation.sandbox import Child


@pytest.fixture
def tally(tmp_path):
    def write(count):
        path = tmp_path / "tally"
        path.write_text(str(count))
        return str(path)

    return write


def test_the_longest_solves_are_begun_first(tmp_path):
    solves, beside = {seconds: Foretold(seconds) for seconds in (2, 5, 3)}, []
    progress = Killing(1, lambda: beside.extend(progress.begun))
    solve_all(solves.values(), tmp_path / "s", progress=progress, workers=2)
    assert progress.begun == [solves[seconds].key for seconds in (5, 3, 2)]
    assert len(beside) == 2


@pytest.mark.nightly
def test_a_solve_whose_worker_is_killed_by_chance_is_done_at_the_end(tmp_path, tally):
    progress, unlucky = Notes(), Deadly(1, tally(1))
    others = [Slow(k) for k in range(2, 8)]
    done = solve_all([unlucky, *others], tmp_path / "s", progress=progress, workers=2)
    assert done.solved == 7
    assert progress.finished[-1] == unlucky.key
    (note,) = progress.notes
    assert "its worker died" in note
    assert "tried once more when the others are done" in note


@pytest.mark.nightly
def test_a_solve_that_kills_its_workers_is_given_up_and_the_others_are_stored(tmp_path, tally):
    deadly, others = Deadly(1, tally(99)), [Slow(k) for k in range(2, 5)]
    store = Store(folder=tmp_path / "s")
    with pytest.raises(RunFailed, match=r"seed 1: its worker died, and once more when nothing else ran"):
        solve_all([deadly, *others], store, workers=2)
    assert all(store.read(solve) for solve in others)
    assert int(Path(deadly.tally).read_text()) == 99 - 2


@pytest.mark.nightly
def test_deaths_while_a_worker_makes_itself_ready_are_not_charged_to_the_solve(tmp_path, tally):
    progress = Notes()
    solves = [DiesAtStart(1, tally(4)), Slow(2)]
    done = solve_all(solves, tmp_path / "s", progress=progress, workers=2)
    assert done.solved == 2
    assert progress.notes == []


@pytest.mark.nightly
def test_workers_that_never_come_up_end_the_run_with_their_last_words(tmp_path, tally):
    with pytest.raises(RunFailed, match=r"die before they begin to solve \(no room for this library\)"):
        solve_all([DiesAtStart(1, tally(99))], tmp_path / "s", workers=2)


def test_a_worker_that_cannot_be_started_is_one_line(tmp_path, monkeypatch):
    def refused(child):
        raise OSError(errno.EMFILE, "Too many open files")

    monkeypatch.setattr(Child, "start", refused)
    with pytest.raises(RunFailed, match=r"no worker process can be started \(Too many open files\); name"):
        solve_all([Slow(1), Slow(2)], tmp_path / "s", workers=2)


def test_what_a_script_itself_defines_is_refused_to_workers_with_the_remedy(tmp_path, monkeypatch):
    lonely = type("Lonely", (Slow,), {"__module__": "__main__", "__qualname__": "Lonely"})
    monkeypatch.setattr(sys.modules["__main__"], "Lonely", lonely, raising=False)
    with pytest.raises(RunFailed, match=r"Can't get attribute 'Lonely'.*; define that in a module"):
        solve_all([lonely(1)], tmp_path / "s", workers=2)


def test_workers_end_within_two_seconds_of_their_parent(tmp_path):
    code = "import sys; sys.path.insert(0, 'tests/validation'); from solving import Endless, solve_all\n"
    code += "solve_all([Endless(1), Endless(2)], sys.argv[1], workers=2)"
    parent = subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], cwd=ROOT, env=environment_of())
    deadline = time.monotonic() + 300
    workers = []
    while len(workers) < 2 or any(child.cpu_times().user < 0.2 for child in workers):
        assert time.monotonic() < deadline
        time.sleep(0.05)
        workers = psutil.Process(parent.pid).children()
    parent.kill()
    parent.wait()
    assert not still_running(workers, seconds=2)


# On a cluster


@pytest.fixture
def cluster(tmp_path):
    distributed = pytest.importorskip("distributed", reason="LOUD: no Dask installed, no cluster is tested")
    with dask_cluster(prepare_folder(tmp_path / "cluster"), paths=[str(Path(__file__).parent)]) as made:
        with distributed.Client(made[0], set_as_default=False) as client:
            client.wait_for_workers(2, timeout=120)
        yield made


def test_workers_of_a_cluster_have_their_own_memory_and_one_thread():
    from validation.execution.cluster import _memory_limits

    def asked(*threads):
        limits = ({"nthreads": count, "memory_limit": 2**30 * k} for k, count in enumerate(threads))
        told = {"workers": dict(zip("ab", limits, strict=False))}
        client = types.SimpleNamespace(status="running", scheduler_info=lambda n_workers: told)
        return _memory_limits(client, "tcp://a")

    assert asked(1, 1) == {"a": math.inf, "b": 2**30}
    with refused(UsageError, "worker b has 2 threads"):
        asked(1, 2)


def test_a_file_of_a_worker_is_waited_for(tmp_path, monkeypatch):
    from validation.execution import cluster as module

    path, waits = tmp_path / "solve.nc", []

    def sleep(seconds):
        waits.append(seconds)
        if len(waits) == 3:
            path.touch()

    monkeypatch.setattr(module, "time", types.SimpleNamespace(sleep=sleep))
    assert module._visible(path)
    assert len(waits) == 3
    assert not module._visible(tmp_path / "other.nc")


def test_a_look_longer_than_the_patience_is_told_and_followed_by_another(tmp_path, monkeypatch):
    from validation.execution import cluster as module

    minutes, progress, looks = itertools.count(0, 60), Notes(), []
    clock = types.SimpleNamespace(monotonic=lambda: next(minutes), sleep=lambda _: None)
    monkeypatch.setattr(module, "time", clock)
    monkeypatch.setattr(module, "_memory_limits", lambda *_: looks.append(1) or {})
    with pytest.raises(RunFailed, match="no workers for 120 s; what is finished is stored"):
        module._Cluster(None, "tcp://a", Store(folder=tmp_path), progress, 4.0)
    assert len(looks) == 2
    assert ["waiting for up to 4 s" in note for note in progress.notes] == [True]


def test_a_scheduler_is_lost_once_it_was_silent_whatever_was_waited_for_before(tmp_path, monkeypatch):
    from validation.execution import cluster as module

    seconds, progress = itertools.count(0, 20), Notes()
    looks = iter(
        [{}, {}, {}, {}, OSError(), {}, {"a": 1e9}, OSError(), TimeoutError(), OSError(), TimeoutError()]
    )

    def look(*_):
        if isinstance(found := next(looks), Exception):
            raise found
        return found

    clock = types.SimpleNamespace(monotonic=lambda: next(seconds), sleep=lambda _: None)
    monkeypatch.setattr(module, "time", clock)
    monkeypatch.setattr(module, "_memory_limits", look)
    client = types.SimpleNamespace(status="running")
    asked = module._Cluster(client, "tcp://a", Store(folder=tmp_path), progress, 600.0)
    assert asked.limits == {"a": 1e9}
    # What is raised varies while it is one scheduler that is lost.
    with pytest.raises(RunFailed, match="the scheduler is lost"):
        asked.awaited_workers()


@pytest.mark.filterwarnings("default")  # of dask's own threads and sockets
def test_what_a_scheduler_hands_out_is_solved_and_stored(tmp_path):
    distributed = pytest.importorskip("distributed", reason="LOUD: no Dask installed, no cluster is tested")
    store, solves = Store(folder=tmp_path / "s"), [Numbers(k) for k in range(3)]
    inside = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    with distributed.LocalCluster(**inside) as made:
        done = solve_all(solves, store, scheduler=made.scheduler_address)
    assert (done.solved, done.failures) == (3, {})
    assert all(store.read(solve) is not None for solve in solves)


@pytest.mark.filterwarnings("default")  # of dask's own threads and sockets when a worker is killed
@pytest.mark.nightly
def test_without_workers_a_cluster_is_waited_for_within_bounds_and_told(tmp_path, cluster, monkeypatch):
    from validation.execution import cluster as module

    monkeypatch.setattr(module, "_TOLD_AFTER", 0.5)
    (address, team, _), store, gate = cluster, Store(folder=tmp_path / "s"), tmp_path / "gate"
    solves = [Held(k, gate) for k in range(6)]
    progress = Killing(3, lambda: [process.kill() for process in team])
    with refused(RunFailed, r"no workers for \d+ s; what is finished is stored"):
        solve_all(solves, store, progress=progress, scheduler=address, patience=4.0)
    assert any(re.search(r"no workers for \d+ s; waiting", note) for note in progress.notes)
    assert [store.read(solve) is not None for solve in solves] == [True] * 3 + [False] * 3
    gate.touch()
    assert solve_all(solves, store).solved == 3


@pytest.mark.filterwarnings("default")
@pytest.mark.nightly
def test_a_lost_scheduler_is_one_line_and_what_is_stored_stays(tmp_path, cluster, monkeypatch):
    from validation.execution import cluster as module

    monkeypatch.setattr(module, "_LOST_AFTER", 3.0)
    (address, _, scheduler), store = cluster, Store(folder=tmp_path / "s")
    solves = [Held(k, tmp_path / "gate") for k in range(6)]
    progress = Killing(3, scheduler.kill)
    with refused(RunFailed, r"the scheduler is lost .* is stored: start it again"):
        solve_all(solves, store, progress=progress, scheduler=address)
    assert [store.read(solve) is not None for solve in solves] == [True] * 3 + [False] * 3


@pytest.mark.filterwarnings("default")
@pytest.mark.slow
def test_a_solve_that_loses_its_dask_workers_is_tried_once_more_alone(tmp_path, cluster, tally):
    # With nannies, or jobs that are queued again, workers come back; here new ones are started by hand.
    (address, team, _), store, progress = cluster, Store(folder=tmp_path / "s"), Notes()
    unlucky, others = Deadly(1, tally(4)), [Slow(k) for k in range(2, 10)]
    stop = threading.Event()

    def restart():
        while not stop.is_set():
            if any(process.poll() is not None for process in team[-2:]):
                team.append(team.start())
            time.sleep(0.2)

    thread = threading.Thread(target=restart, daemon=True)
    thread.start()
    try:
        done = solve_all([unlucky, *others], store, progress=progress, scheduler=address)
    finally:
        stop.set()
        thread.join()
    assert done.solved == 9
    assert progress.finished[-1] == unlucky.key
    assert any("its worker died" in note for note in progress.notes)


def openssl(*arguments, folder):
    subprocess.run(["openssl", *arguments], cwd=folder, check=True, capture_output=True)


def certified(folder, name):
    """An authority of that name, and a certificate and key that it signed; files in PEM."""
    openssl(
        *("req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", f"/CN={name}"),
        *("-keyout", f"{name}-ca.key", "-out", f"{name}-ca.pem"),
        folder=folder,
    )
    node = ("-subj", f"/CN={name}-node", "-keyout", f"{name}.key", "-out", f"{name}.csr")
    openssl(*("req", "-newkey", "rsa:2048", "-nodes"), *node, folder=folder)
    openssl(
        *("x509", "-req", "-days", "2", "-in", f"{name}.csr", "-out", f"{name}.pem"),
        *("-CA", f"{name}-ca.pem", "-CAkey", f"{name}-ca.key", "-CAcreateserial"),
        folder=folder,
    )
    return tuple(str(folder / f"{name}{end}") for end in ("-ca.pem", ".pem", ".key"))


def with_certificates(authority, certificate, key):
    """Name a client's certificates to Dask, as its environment variables do."""
    import dask

    files = {"ca-file": authority, "client.cert": certificate, "client.key": key}
    return dask.config.set({f"distributed.comm.tls.{name}": file for name, file in files.items()})


@pytest.mark.nightly  # handshakes that fail are waited for
@pytest.mark.filterwarnings("default")
def test_a_cluster_with_tls_works_for_who_holds_a_certificate_of_its_authority(tmp_path, monkeypatch):
    pytest.importorskip("distributed", reason="LOUD: no Dask installed, TLS is not tested")
    if shutil.which("openssl") is None:
        pytest.skip("LOUD: no openssl to make certificates with, TLS is not tested")
    from validation.execution import cluster as module

    monkeypatch.setattr(module, "_CONNECTS_WITHIN", 15.0)
    own, stranger = certified(tmp_path, "own"), certified(tmp_path, "stranger")
    options = [*("--tls-ca-file", own[0], "--tls-cert", own[1], "--tls-key", own[2]), "--protocol", "tls"]
    store, folder = Store(folder=tmp_path / "s"), prepare_folder(tmp_path / "cluster")
    with dask_cluster(folder, 1, [str(Path(__file__).parent)], options) as (address, _, _):
        assert address.startswith("tls://")
        with pytest.raises(UsageError, match=r"no scheduler answers .*names both certificates"):
            solve_all([Numbers(1)], store, scheduler=address)
        with with_certificates(*stranger), refused(UsageError, r"no scheduler answers .*names both cert"):
            solve_all([Numbers(1)], store, scheduler=address)
        assert not store.folder.exists() or not list(store.folder.iterdir())
        monkeypatch.undo()
        with with_certificates(*own):
            done = solve_all([Numbers(1), Numbers(2)], store, scheduler=address)
        assert done.solved == 2
        assert all(store.read(Numbers(seed)) for seed in (1, 2))


@pytest.mark.parametrize("says", [b"", b"HTTP/1.1 400 Bad Request\r\n\r\n", bytes(64)])
def test_what_is_no_scheduler_is_given_up_in_time_and_in_one_line(tmp_path, monkeypatch, says):
    pytest.importorskip("distributed")
    from validation.execution import cluster as module

    monkeypatch.setattr(module, "_CONNECTS_WITHIN", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer():
            with contextlib.suppress(OSError):
                while connection := server.accept()[0]:
                    held.append(connection)
                    connection.sendall(says)

        held = []
        threading.Thread(target=answer, daemon=True).start()
        address, began = f"tcp://127.0.0.1:{server.getsockname()[1]}", time.monotonic()
        with refused(UsageError, r"no scheduler answers there .*start one with"):
            solve_all([Numbers(1)], tmp_path / "s", scheduler=address)
        assert time.monotonic() - began < 20
        for connection in held:
            connection.close()


def test_dask_workers_are_warm_before_a_solve_is_timed(tmp_path, monkeypatch):
    from validation.execution import cluster

    order, store = [], Store(folder=tmp_path)
    monkeypatch.setattr(DiesAtStart, "warm_up", lambda self, warm: order.append("warm"))
    monkeypatch.setattr(DiesAtStart, "do", lambda self, **_: (order.append("solve"), Numbers.do(self))[1])
    for seed in (1, 2):
        assert cluster._remote(DiesAtStart(seed, ""), store) == Outcome()
    assert order == 2 * ["warm", "solve"]
    outcome = cluster._remote(Numbers(1), Store(folder=tmp_path / "elsewhere"))
    assert "on a file system that they share" in str(outcome.error)
    assert outcome.fatal


def test_after_the_warm_up_a_first_dataset_imports_nothing():
    code = """
import sys
from validation.execution.attempt import warm_up
warm_up([])
import xarray as xr
before = set(sys.modules)
xr.Dataset({"pressure": ("x", [1.0])}, coords={"x": [0.0]})
print(sorted({name.partition(".")[0] for name in set(sys.modules) - before}))
"""
    done = run_python("-c", code)
    assert done.stdout.strip() == "[]", done.stderr
