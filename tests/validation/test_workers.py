"""Workers, local and on a cluster: what dies is told, waited for, and charged to whom it belongs."""

from __future__ import annotations

import contextlib
import itertools
import os
import pickle
import re
import shutil
import subprocess
import sys
import threading
import time
import types
from pathlib import Path

import psutil
import pytest

sys.path.insert(0, str(Path(__file__).parent))
from solving import Deadly, DiesAtStart, Held, Killing, Notes, Numbers, Slow, dask_cluster

from validation.errors import RunFailed, UsageError
from validation.files import prepare_folder
from validation.solves import pool
from validation.solves.running import Execution, solve_all
from validation.solves.store import Store

ROOT = Path(__file__).parents[2]


@pytest.fixture
def tally(tmp_path):
    def write(count):
        path = tmp_path / "tally"
        path.write_text(str(count))
        return str(path)

    return write


@pytest.mark.nightly
def test_a_solve_whose_workers_are_killed_three_times_by_chance_is_done_at_the_end(tmp_path, tally):
    progress, unlucky = Notes(), Deadly(1, tally(3))
    others = [Slow(k) for k in range(2, 8)]
    done = solve_all(
        [unlucky, *others], Store(folder=tmp_path / "s"), progress=progress, execution=Execution(workers=2)
    )
    assert done.solved == 7
    assert progress.finished[-1] == unlucky.key
    (note,) = progress.notes
    assert "its worker died 3 times" in note
    assert "tried once more when the others are done" in note


@pytest.mark.nightly
def test_a_solve_that_kills_its_workers_is_given_up_and_the_others_are_stored(tmp_path, tally):
    deadly, others = Deadly(1, tally(99)), [Slow(k) for k in range(2, 5)]
    store = Store(folder=tmp_path / "s")
    with pytest.raises(
        RunFailed, match=r"seed 1: its worker died 3 times, and once more when nothing else ran"
    ):
        solve_all([deadly, *others], store, execution=Execution(workers=2))
    assert all(store.holds(solve) for solve in others)
    assert int(Path(deadly.tally).read_text()) == 99 - 4


@pytest.mark.nightly
def test_deaths_while_a_worker_makes_itself_ready_are_not_charged_to_the_solve(tmp_path, tally):
    progress = Notes()
    solves = [DiesAtStart(1, tally(4)), Slow(2)]
    done = solve_all(solves, Store(folder=tmp_path / "s"), progress=progress, execution=Execution(workers=2))
    assert done.solved == 2
    assert progress.notes == []


@pytest.mark.nightly
def test_workers_that_never_come_up_end_the_run_with_their_last_words(tmp_path, tally):
    with pytest.raises(RunFailed, match=r"die before they begin to solve \(no room for this library\)"):
        solve_all([DiesAtStart(1, tally(99))], Store(folder=tmp_path / "s"), execution=Execution(workers=2))


def test_workers_that_cannot_be_started_are_told_and_those_there_are_go_on(tmp_path, monkeypatch):
    real, started = pool._start, []

    def start():
        if started:
            raise RunFailed("no worker process can be started (Too many open files)")
        started.append(1)
        return real()

    monkeypatch.setattr(pool, "_start", start)
    progress = Notes()
    done = solve_all(
        [Slow(1), Slow(2)], Store(folder=tmp_path / "s"), progress=progress, execution=Execution(workers=4)
    )
    assert done.solved == 2
    assert "1 workers go on" in progress.notes[0]


def test_workers_end_within_two_seconds_of_their_parent(tmp_path):
    code = (
        "import sys; sys.path.insert(0, 'tests/validation')\n"
        "from solving import Endless\n"
        "from test_workers import Execution, Path, Store, solve_all\n"
        "solve_all([Endless(1), Endless(2)], Store(folder=Path(sys.argv[1])), execution=Execution(workers=2))"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *filter(None, sys.path)])}
    parent = subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], cwd=ROOT, env=environment)
    deadline = time.monotonic() + 300
    workers = []
    while len(workers) < 2 or any(child.cpu_times().user < 0.2 for child in workers):
        assert time.monotonic() < deadline
        time.sleep(0.05)
        workers = psutil.Process(parent.pid).children()
    parent.kill()
    parent.wait()
    _, alive = psutil.wait_procs(workers, timeout=2)
    assert not alive


# On a cluster


@pytest.fixture
def cluster(tmp_path):
    distributed = pytest.importorskip("distributed", reason="LOUD: no Dask installed, no cluster is tested")
    from validation.solves.plain_answers import plain_answers

    with dask_cluster(prepare_folder(tmp_path / "cluster"), paths=[str(Path(__file__).parent)]) as made:
        with plain_answers(), distributed.Client(made[0], set_as_default=False) as client:
            client.wait_for_workers(2, timeout=120)
        yield made


def test_a_look_longer_than_the_patience_is_told_and_followed_by_another(tmp_path, monkeypatch):
    from validation.solves import cluster as module

    minutes, progress, looks = itertools.count(0, 60), Notes(), []
    clock = types.SimpleNamespace(monotonic=lambda: next(minutes), sleep=lambda _: None)
    monkeypatch.setattr(module, "time", clock)
    monkeypatch.setattr(module._Cluster, "_answering", lambda self: looks.append(self) or {})
    waiting = module._Cluster(
        client=None,
        address="tcp://a",
        store=Store(folder=tmp_path),
        progress=progress,
        patience=4.0,
        waiting=[],
    )
    with pytest.raises(RunFailed, match="no workers for 120 s; what is finished is stored"):
        list(waiting.outcomes())
    assert len(looks) == 2
    assert ["waiting for one for up to 4 s" in note for note in progress.notes] == [True]


@pytest.mark.filterwarnings("default")  # of dask's own threads and sockets when a worker is killed
@pytest.mark.nightly
def test_without_workers_a_cluster_is_waited_for_within_bounds_and_told(tmp_path, cluster, monkeypatch):
    from validation.solves import cluster as module

    monkeypatch.setattr(module, "_TOLD_AFTER", 0.5)
    (address, team, _), store, gate = cluster, Store(folder=tmp_path / "s"), tmp_path / "gate"
    solves = [Held(k, gate) for k in range(6)]
    progress = Killing(3, lambda: [process.kill() for process in team])
    with pytest.raises(RunFailed, match=r"no workers for \d+ s; what is finished is stored") as told:
        solve_all(solves, store, progress=progress, execution=Execution(scheduler=address, patience=4.0))
    assert "\n" not in str(told.value)
    assert any(re.search(r"no workers for \d+ s; waiting", note) for note in progress.notes)
    assert [store.holds(solve) for solve in solves] == [True] * 3 + [False] * 3
    gate.touch()
    assert solve_all(solves, store).solved == 3


@pytest.mark.filterwarnings("default")
@pytest.mark.nightly
def test_a_lost_scheduler_is_one_line_and_what_is_stored_stays(tmp_path, cluster, monkeypatch):
    from validation.solves import cluster as module

    monkeypatch.setattr(module, "_LOST_AFTER", 3.0)
    (address, _, scheduler), store = cluster, Store(folder=tmp_path / "s")
    solves = [Held(k, tmp_path / "gate") for k in range(6)]
    progress = Killing(3, scheduler.kill)
    with pytest.raises(RunFailed, match=r"the scheduler is lost .* is stored: start it again") as told:
        solve_all(solves, store, progress=progress, execution=Execution(scheduler=address))
    assert "\n" not in str(told.value)
    assert [store.holds(solve) for solve in solves] == [True] * 3 + [False] * 3


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
        done = solve_all([unlucky, *others], store, progress=progress, execution=Execution(scheduler=address))
    finally:
        stop.set()
        thread.join()
    assert done.solved == 9
    assert progress.finished[-1] == unlucky.key
    assert any("its workers died again and again" in note for note in progress.notes)


def openssl(*arguments, folder):
    subprocess.run(["openssl", *arguments], cwd=folder, check=True, capture_output=True)


def certified(folder, name):
    """An authority of that name, and a certificate and key that it signed; files in PEM."""
    openssl(
        *("req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", f"/CN={name}"),
        *("-keyout", f"{name}-ca.key", "-out", f"{name}-ca.pem"),
        folder=folder,
    )
    openssl(
        *("req", "-newkey", "rsa:2048", "-nodes", "-subj", f"/CN={name}-node"),
        *("-keyout", f"{name}.key", "-out", f"{name}.csr"),
        folder=folder,
    )
    openssl(
        *("x509", "-req", "-days", "2", "-in", f"{name}.csr", "-out", f"{name}.pem"),
        *("-CA", f"{name}-ca.pem", "-CAkey", f"{name}-ca.key", "-CAcreateserial"),
        folder=folder,
    )
    return tuple(str(folder / f"{name}{end}") for end in ("-ca.pem", ".pem", ".key"))


def with_certificates(authority, certificate, key):
    """Name a client's certificates to Dask, as its environment variables do."""
    import dask

    tls = "distributed.comm.tls"
    return dask.config.set(
        {f"{tls}.ca-file": authority, f"{tls}.client.cert": certificate, f"{tls}.client.key": key}
    )


@pytest.mark.slow  # handshakes that fail are waited for
@pytest.mark.filterwarnings("default")
def test_a_cluster_with_tls_works_for_who_holds_a_certificate_of_its_authority(tmp_path, monkeypatch):
    pytest.importorskip("distributed", reason="LOUD: no Dask installed, TLS is not tested")
    if shutil.which("openssl") is None:
        pytest.skip("LOUD: no openssl to make certificates with, TLS is not tested")
    from validation.solves import cluster as module

    connected = module._connected
    monkeypatch.setattr(module, "_connected", lambda address: connected(address, timeout=2))
    own, stranger = certified(tmp_path, "own"), certified(tmp_path, "stranger")
    options = [*("--tls-ca-file", own[0], "--tls-cert", own[1], "--tls-key", own[2]), "--protocol", "tls"]
    store, folder = Store(folder=tmp_path / "s"), prepare_folder(tmp_path / "cluster")
    with dask_cluster(folder, 1, [str(Path(__file__).parent)], options) as (address, _, _):
        assert address.startswith("tls://")
        with pytest.raises(UsageError, match=r"TLS needs certificates: name them to Dask"):
            solve_all([Numbers(1)], store, execution=Execution(scheduler=address))
        with (
            with_certificates(*stranger),
            pytest.raises(UsageError, match=r"signed by the authority") as told,
        ):
            solve_all([Numbers(1)], store, execution=Execution(scheduler=address))
        assert "\n" not in str(told.value)
        assert not store.folder.exists() or not list(store.folder.iterdir())
        monkeypatch.setattr(module, "_connected", connected)
        with with_certificates(*own):
            done = solve_all([Numbers(1), Numbers(2)], store, execution=Execution(scheduler=address))
        assert done.solved == 2
        assert all(store.holds(Numbers(seed)) for seed in (1, 2))


def test_where_encryption_is_asked_for_an_address_without_it_is_refused(tmp_path):
    dask = pytest.importorskip("dask")
    with (
        dask.config.set({"distributed.comm.require-encryption": True}),
        pytest.raises(UsageError, match=r"asks for encryption; name it as tls://host:port"),
    ):
        solve_all(
            [Numbers(1)], Store(folder=tmp_path / "s"), execution=Execution(scheduler="tcp://127.0.0.1:9")
        )


class Evil:
    """A pickle that leaves a file where it is opened."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return (os.system, (f"touch {self.path}",))


def test_a_client_opens_no_program_that_a_scheduler_sends(tmp_path):
    distributed = pytest.importorskip("distributed")
    from distributed.core import clean_exception
    from distributed.protocol import Serialize, ToPickle, dumps, loads

    from validation.solves.plain_answers import Refused, plain_answers, plain_loads

    evil = Evil(tmp_path / "opened")
    pickled = pickle.dumps(evil)
    messages = [dumps({"x": wrapped(evil)}) for wrapped in (ToPickle, Serialize)]
    with plain_answers():
        for message in messages:
            loads(message)
        distributed.client.loads(pickled)
        distributed.client.pickle.loads(pickled)
        with contextlib.suppress(AssertionError):  # it asks for an exception, and gets none
            clean_exception(pickled)
        assert not (tmp_path / "opened").exists()
        assert plain_loads(pickle.dumps({"error": None, "n": [1, 2.5]})) == {"error": None, "n": [1, 2.5]}
        assert isinstance(plain_loads(pickled), Refused)
        assert type(plain_loads(b"cbuiltins\nValueError\n(S'x'\ntR.")) is ValueError
        for allowed in (eval, exec, open, getattr, __import__):
            assert plain_loads(pickle.dumps(allowed)) is not allowed
    loads(messages[0])
    assert (tmp_path / "opened").exists(), "the test would show it"


def test_dask_workers_are_warm_before_a_solve_is_timed(tmp_path, monkeypatch):
    from validation.solves import cluster as module

    order = []
    monkeypatch.setattr(DiesAtStart, "warm_up", lambda self: order.append("warm"))
    monkeypatch.setattr(
        DiesAtStart, "measure", lambda self: (order.append("solve"), Numbers.measure(self))[1]
    )
    monkeypatch.setattr(module, "_WARM", set())
    for seed in (1, 2):
        assert '"error": null' in module._remote(DiesAtStart(seed, ""), tmp_path)
    assert order == ["warm", "solve", "solve"]
    assert "shared" not in module._remote(Numbers(1), tmp_path)
    assert "on a file system that they share" in module._remote(Numbers(1), tmp_path / "elsewhere")
