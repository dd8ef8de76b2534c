"""Solves, progress and clusters that the tests of the bench share; imported by worker processes, too."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import psutil
import xarray as xr
from scipy.special import erf

from validation.execution.attempt import Progress
from validation.execution.bench import Bench, Execution
from validation.execution.solve import Prediction, Solve
from validation.execution.store import Store
from validation.sandbox import ONE_THREAD


def persson_area(reduced_pressure):
    """A/A0 of Persson's theory at p*."""
    return erf(2**0.5 * np.asarray(reduced_pressure))


class Notes(Progress):
    """Progress that remembers."""

    def __init__(self):
        self.notes, self.begun, self.finished, self.missing = [], [], [], None

    def start(self, missing, stored):
        self.missing = len(missing)

    def begin(self, solve):
        self.begun.append(solve.key)

    def done(self, solve):
        self.finished.append(solve.key)

    def note(self, text):
        self.notes.append(text)


class Killing(Notes):
    """Progress that does something once so many solves are done: kill a process, as a rule."""

    def __init__(self, count, act):
        super().__init__()
        self.count, self.act = count, act

    def done(self, solve):
        super().done(solve)
        if len(self.finished) == self.count:
            self.act()


def solve_all(solves, store, *, progress=None, **execution):
    """Solve on a bench of a store, or of a folder."""
    store = store if isinstance(store, Store) else Store(folder=Path(store))
    bench = Bench(store=store, execution=Execution(**execution), progress=progress or Progress())
    return bench.solve(solves)


class Numbers(Solve):
    """A solve of a study: some numbers made from a seed."""

    def __init__(self, seed=7):
        self.seed = seed

    @property
    def recipe(self):
        return {"seed": self.seed}

    prefix = "numbers"

    def describe(self):
        return f"numbers of seed {self.seed}"

    def predict(self, *, pair_seconds=0.5e-3):
        return Prediction(seconds=0.1, peak_bytes=1, unknowns=1)

    def do(self, *, threads=None):
        rng = np.random.default_rng(self.seed)
        return xr.Dataset(
            {
                "area": ("grid", rng.random(40), {"units": "1"}),
                "counted": ("grid", rng.integers(0, 9, 40)),
                "resolved": ("grid", rng.random(40) > 0.5),
                "zeros": ("grid", np.zeros(40)),
            },
            coords={"grid": np.arange(40), "name": ("kind", ["fine", "coarse"])},
            attrs={"note": "for a test"},
        )


def fields(points=12, load=0.1):
    """A small solve of a scene."""
    from validation.studies import area  # which takes the workers of other solves a second

    told = area.Options(grids=(12, 16), periods=1.6, bandwidth=2.5, hurst=0.7, surfaces=2, seed=21)
    return told.press(surface=0, reduced_pressure=load, grid=(points, points))


class Foretold(Numbers):
    """Numbers that are foretold to take as many seconds as their seed says."""

    def predict(self, *, pair_seconds=0.5e-3):
        return Prediction(seconds=self.seed, peak_bytes=1, unknowns=1)


class Slow(Numbers):
    """Numbers that take their time."""

    seconds = 0.4

    def do(self, *, threads=None):
        time.sleep(self.seconds)
        return super().do()


class Endless(Slow):
    seconds = 600


class Held(Numbers):
    """Numbers that are done only once a file is there; the first three without waiting."""

    def __init__(self, seed, gate):
        super().__init__(seed)
        self.gate = str(gate)

    def do(self, *, threads=None):
        while self.seed >= 3 and not Path(self.gate).exists():
            time.sleep(0.02)
        return super().do()


class Deadly(Numbers):
    """A solve that kills its worker as often as a file says."""

    def __init__(self, seed, tally):
        super().__init__(seed)
        self.tally = tally

    def do(self, *, threads=None):
        _die_of(self.tally)
        return super().do()


def _die_of(tally, last_words=""):
    left = int(Path(tally).read_text())
    if left:
        Path(tally).write_text(str(left - 1))
        print(last_words, file=sys.stderr, flush=True)
        os.kill(os.getpid(), signal.SIGKILL)


class DiesAtStart(Numbers):
    """A worker that dies while it makes itself ready, as often as a file says."""

    def __init__(self, seed, tally):
        super().__init__(seed)
        self.tally = tally

    def warm_up(self, warm):
        _die_of(self.tally, "no room for this library")


def still_running(processes, *, seconds):
    """Processes that run after so many seconds; what waits for init to be collected has ended."""
    deadline = time.monotonic() + seconds
    while processes and time.monotonic() < deadline:
        time.sleep(0.05)
        processes = [one for one in processes if _runs(one)]
    return processes


def _runs(process):
    try:
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


class Team(list):
    """Processes of Dask workers, and how to start one more."""

    def __init__(self, start):
        super().__init__()
        self.start = start


@contextmanager
def dask_cluster(folder, workers=2, paths=(), options=()):
    """A scheduler and workers of one thread, each a process of its own."""
    address = folder / "scheduler.json"
    path = os.pathsep.join(entry for entry in (*sys.path, *paths) if entry)
    environment = {**os.environ, **ONE_THREAD, "PYTHONPATH": path}
    quiet = {"env": environment, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder}
    here = ("--host", "127.0.0.1", "--no-dashboard", *options)
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0", *here]
    scheduler = subprocess.Popen([*command, "--scheduler-file", str(address)], **quiet)
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file", str(address), *here]
    worker += ["--nthreads", "1", "--no-nanny", "--memory-limit", "1GiB"]
    team = Team(lambda: subprocess.Popen(worker, **quiet))
    try:
        for _ in range(600):
            if address.exists():
                break
            time.sleep(0.05)
        team += [team.start() for _ in range(workers)]
        yield json.loads(address.read_text())["address"], team, scheduler
    finally:
        for process in (*team, scheduler):
            process.kill()
            process.wait()
