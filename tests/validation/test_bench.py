"""Many independent solves: the same tables wherever they run, whatever is killed, full or damaged."""

import contextlib
import importlib.util
import itertools
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import psutil
import pytest
from gold.asked import STUDIES
from solving import Killing, Notes, Slow, dask_cluster, solve_all

from fem_contact.errors import NotConverged
from validation.audit import audit
from validation.errors import RunFailed, UsageError
from validation.execution import pool
from validation.execution.attempt import Progress
from validation.execution.bench import Bench, Execution, PlannedOnly
from validation.execution.press import Press
from validation.execution.store import Store
from validation.files import available_memory, prepare_folder
from validation.studies import Study, area, find_study, studies
from validation.studies._outputs import run_study

#: 5 loads x 4 surfaces x 4 grids: 80 solves of milliseconds.
CASES = {
    "reduced_pressures": tuple(np.geomspace(0.01, 1.0, 5).tolist()),
    "seed": 21,
    "surfaces": 4,
    "grids": (12, 14, 16, 20),
    "periods": 1.6,
    "bandwidth": 2.5,
    "hurst": 0.7,
}
FEW = {**CASES, "reduced_pressures": (0.05, 0.2), "surfaces": 2}


def run_area(*, bench, **options):
    return area.run(area.Options(**options), bench=bench)


def solves_of(**options):
    """The solves of the study, one surface allowed."""
    told = area.Options.model_construct(**options)
    places = itertools.product(told.reduced_pressures, range(told.surfaces), told.grids)
    return tuple(told.press(surface=k, reduced_pressure=p, grid=(n, n)) for p, k, n in places)


def bench_at(folder, progress=None, **execution):
    return Bench.at(folder, execution=Execution(**execution), progress=progress or Progress())


@pytest.fixture(scope="module")
def serial(tmp_path_factory):
    """The 80 cases, one after the other in this process."""
    folder = tmp_path_factory.mktemp("serial")
    return folder, run_area(bench=bench_at(folder), **CASES)


def workers_of(parent):
    return [one for one in psutil.Process(parent).children() if "validation.sandbox" in one.cmdline()]


def test_two_workers_give_the_same_bits_although_one_is_killed(serial, tmp_path):
    progress = Killing(20, lambda: max(workers_of(os.getpid()), key=lambda worker: worker.pid).kill())
    data = run_area(bench=bench_at(tmp_path, progress, workers=2), **CASES)
    assert data.identical(serial[1])
    assert len(progress.finished) == len(set(progress.finished)) == 80
    # Whoever was killed was at one solve at most; only that one was begun twice.
    assert len(progress.begun) - 80 in (0, 1)
    assert not list(tmp_path.glob(".*")), "drafts of the dead"


@pytest.mark.nightly
@pytest.mark.filterwarnings("default")  # of dask's own threads and sockets when a worker is killed
def test_a_dask_cluster_gives_the_same_bits_although_a_worker_is_killed(serial, tmp_path):
    pytest.importorskip("distributed", reason="LOUD: no Dask installed, the cluster is not tested")
    store = tmp_path / "store"
    with dask_cluster(prepare_folder(tmp_path / "cluster")) as (address, team, _):
        progress = Killing(20, team[0].kill)
        bench = bench_at(store, progress, scheduler=address)
        data = run_area(bench=bench, **CASES)
        assert team[0].wait() == -signal.SIGKILL
        assert team[1].poll() is None
        too_large = solves_of(**{**FEW, "grids": (8192,), "surfaces": 1, "reduced_pressures": (0.1,)})
        with pytest.raises(UsageError, match=r"8192x8192: needs about .* on the smallest worker 1 GiB"):
            bench.solve(too_large)
    assert data.identical(serial[1])
    assert sorted(progress.finished) == sorted(set(progress.finished))
    assert len(progress.finished) == 80


def test_without_an_answering_scheduler_nothing_is_computed(tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    from validation.execution import cluster

    monkeypatch.setattr(cluster, "_CONNECTS_WITHIN", 0.5)
    with pytest.raises(UsageError, match=r"--scheduler = 'tcp://127.0.0.1:9': no scheduler answers"):
        run_area(bench=bench_at(tmp_path, scheduler="tcp://127.0.0.1:9"), **FEW)
    assert list(tmp_path.iterdir()) == []


def test_a_damaged_case_is_named_set_aside_and_computed_again(tmp_path):
    before = run_area(bench=bench_at(tmp_path), **FEW)
    path = sorted(tmp_path.glob("bem-*.nc"))[3]
    path.write_bytes(path.read_bytes()[:-2000])
    progress = Notes()
    after = run_area(bench=bench_at(tmp_path, progress), **FEW)
    (note,) = progress.notes
    assert str(path) in note
    assert "damaged" in note
    assert path.with_suffix(".nc.corrupt").exists()
    assert progress.begun == [path.stem]
    assert after.identical(before)


@contextmanager
def small_disk(folder, kilobytes, *, inodes=0):
    """A real file system of its own size; skipped where it cannot be mounted."""
    folder.mkdir()
    mount = shutil.which("mount")
    command = [str(mount), "-t", "tmpfs", "-o", f"size={kilobytes}k,nr_inodes={inodes}", "tmpfs", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False) if mount else None
    if done is None or done.returncode:
        why = "no mount" if done is None else done.stderr.strip()
        pytest.skip(f"LOUD: a full disk is not tested: no small file system can be mounted here ({why})")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


@pytest.mark.parametrize(
    ("size", "words"),
    [
        ({"kilobytes": 600}, r"the disk is full: .*finished solves are intact"),
        ({"kilobytes": 100_000, "inodes": 20}, r"inodes are used up: .* was not written; finished"),
    ],
)
@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_full_disk_is_a_clear_error_and_leaves_finished_cases_intact(tmp_path, workers, size, words):
    with small_disk(tmp_path / "disk", **size) as disk:
        with pytest.raises(RunFailed, match=words):
            run_area(bench=bench_at(disk, workers=workers), **CASES)
        store, solves = Store(folder=disk), solves_of(**CASES)
        kept = [solve for solve in solves if store.path(solve).exists()]
        assert 3 <= len(kept) < 80
        assert all(store.read(solve) for solve in kept)
        names = {path.name for path in disk.iterdir()}
        assert names == {store.path(solve).name for solve in kept}, "half-written files"


def test_a_case_that_fails_does_not_keep_the_others_from_being_done(tmp_path, monkeypatch):
    solves, does = solves_of(**FEW), Press.do

    def fails_once(solve, **options):
        if solve == solves[2]:
            raise NotConverged("stopped at the iteration limit")
        return does(solve, **options)

    monkeypatch.setattr(Press, "do", fails_once)
    store = Store(folder=prepare_folder(tmp_path / "store"))
    with pytest.raises(RunFailed, match=r"1 of 16 solves failed, the others are stored:\n.*BEM 16x16"):
        solve_all(solves, store)
    assert [solve for solve in solves if store.read(solve) is None] == [solves[2]]


def test_cases_that_do_not_fit_together_wait_and_one_that_never_fits_is_refused(tmp_path, monkeypatch):
    solves = solves_of(**FEW)
    largest = max(solve.predict().peak_bytes for solve in solves)
    running, most = set(), []
    monkeypatch.setattr(pool, "_IDLE_BYTES", 0)

    class Watch(Notes):
        def begin(self, solve):
            running.add(solve.key)
            most.append(sum(j.predict().peak_bytes for j in solves if j.key in running))

        def done(self, solve):
            running.discard(solve.key)

    bench = bench_at(tmp_path / "narrow", Watch(), workers=2, memory=int(1.2 * largest))
    bench.solve(solves)
    assert max(most) <= 1.2 * largest
    # Of the memory, workers without a solve take their part.
    monkeypatch.setattr(pool, "_IDLE_BYTES", largest)
    for memory, beside in ((3.9 * largest, False), (4.1 * largest, True)):
        with contextlib.closing(pool._Processes(bench.store, 2, memory=int(memory))) as processes:
            biggest = max(solves, key=lambda solve: solve.predict().peak_bytes)
            assert processes.room(biggest, [biggest]) == beside
            assert not processes.room(biggest, [biggest] * 2)
            assert processes.room(biggest, [])
    with pytest.raises(UsageError, match=r"BEM 20x20: needs about .* raise the limit with --memory"):
        bench_at(tmp_path / "refused", memory=largest // 2).solve(solves)
    assert not (tmp_path / "refused").exists()
    monkeypatch.setattr("psutil.virtual_memory", lambda: SimpleNamespace(available=1000))
    assert available_memory() == 900


@pytest.mark.parametrize(
    "name", [name for name, asked in STUDIES.items() if asked and not {"scene", "theory"} & set(asked)]
)
def test_each_planned_solve_of_a_study_takes_time_and_room_for_its_unknowns(name, tmp_path):
    study = find_study(name.partition(" ")[0])
    bench = Bench(store=Store(folder=tmp_path), plan_only=True)
    with pytest.raises(PlannedOnly) as planned:
        study.compute(study.options(**STUDIES[name]), bench=bench)
    for solve in planned.value.args:
        cost = solve.predict()
        assert cost.unknowns >= 1
        assert cost.peak_bytes >= 8 * cost.unknowns
        assert 1e-9 < cost.seconds / cost.unknowns < 1e-2
    assert not list(tmp_path.iterdir())


def test_every_study_has_a_question_and_options_with_defaults():
    assert "area" in studies()
    for study in studies().values():
        assert study.question.endswith("?")
        for flag, field in study.options.flags().items():
            default = field.default
            text = ",".join(map(str, default)) if isinstance(default, tuple) else str(default)
            if default is not None and default != ():
                name = flag.removeprefix("--").replace("-", "_")
                words = [flag, text] if default is not True else [flag]
                assert getattr(study.parse(words), name) == default
    assert find_study("refinement").parse(["--elements", "none"]).elements == ()
    with pytest.raises(UsageError, match=r"--grids = 'x': must be a valid integer"):
        find_study("area").parse(["--grids", "x"])


@pytest.mark.parametrize(("points", "relative"), [(200, 2e-16 * 200 * 30), (300, 1e-7)])
def test_the_number_of_threads_changes_nothing_but_rounding(points, relative):
    solve = solves_of(**{**FEW, "grids": (points,), "surfaces": 1, "reduced_pressures": (0.05,)})[0]
    one, two = (solve.do(threads=threads).contact for threads in (1, 2))
    # The transforms group their sums by the number of threads: rounding of 2e-16, times the condition of the
    # response (about the number of points along a side) and some 30 steps. From 256 points on the draft in
    # single precision ends elsewhere within its rounding, and the last steps within the tolerance of 1e-8.
    assert np.abs(one.pressure - two.pressure).max() < relative * one.pressure.max()
    assert np.array_equal(one.in_contact, two.in_contact)
    assert one.offset == pytest.approx(two.offset, rel=relative)


@pytest.mark.slow
def test_ctrl_c_ends_the_workers_and_keeps_what_is_finished(tmp_path):
    store = tmp_path / "store"
    command = [sys.executable, "-m", "validation.cli", "study", "area", "-q", "--workers", "2"]
    command += ["--store", str(store), "--output", str(tmp_path / "out"), "--grids", "128,160,192"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
    while len(list(store.glob("bem-*.nc"))) < 5:
        assert process.poll() is None
        time.sleep(0.01)
    # As a terminal does it: the whole group gets the signal.
    os.killpg(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert said.count("\n") == 1
    assert "every finished solve is stored" in said
    assert not list(store.glob(".*")), "half-written files"
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, 0)


@pytest.mark.parametrize("where", ["done", "do"])
def test_an_interruption_anywhere_ends_the_workers_and_keeps_what_is_finished(tmp_path, monkeypatch, where):
    store, progress, calls = Store(folder=tmp_path), Notes(), itertools.count(1)
    others = workers_of(os.getpid())  # of the tests before, in which files are read
    place = Slow if where == "do" else progress
    real = getattr(place, where)

    def interrupted(*arguments, **named):
        if next(calls) == 3:
            raise KeyboardInterrupt
        return real(*arguments, **named)

    monkeypatch.setattr(place, where, interrupted)
    solves, began = [Slow(k) for k in range(8)], time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        solve_all(solves, store, progress=progress, workers=1 if where == "do" else 2)
    assert time.monotonic() - began < 120
    assert workers_of(os.getpid()) == others
    assert len(progress.finished) >= 1
    assert set(progress.finished) <= {solve.key for solve in solves if store.read(solve)}
    assert not list(tmp_path.glob(".*")), "half-written files"


def test_results_are_held_in_no_more_memory_than_allowed(serial, monkeypatch):
    solves = solves_of(**CASES)[:3]
    sizes = [Store(folder=serial[0]).read(solve).size for solve in solves]
    for room, held in ((3 * sizes[0] - 1, 0), (3 * sum(sizes[:2]), 2), (3 * sum(sizes), 3)):
        monkeypatch.setattr("validation.execution.bench._HELD_BYTES", room)
        results = bench_at(serial[0]).solve(solves)
        for _ in range(2):
            assert all(results.read(solve) for solve in solves)
        assert len(results._held) == held


@pytest.mark.parametrize("grids", [(8,), (8, 16)])
def test_study_area_asks_for_two_resolved_grids(tmp_path, grids):
    with pytest.raises(UsageError, match="two grids of at least 3 points per shortest wave; here that is 12"):
        run_area(bench=bench_at(tmp_path), **{**FEW, "grids": grids})
    assert list(tmp_path.iterdir()) == []


def test_study_area_leaves_coarse_grids_out_and_adds_the_error_of_the_grids(tmp_path):
    few = {**FEW, "reduced_pressures": (1e-4, 0.2)}
    data = run_area(bench=bench_at(tmp_path), **{**few, "grids": (8, 16, 20)})
    without = run_area(bench=bench_at(tmp_path), **{**few, "grids": (16, 20)})
    assert data.drop_vars("solve").equals(without.drop_vars("solve"))
    assert (data.area_error.sel(source=["grid", "surfaces"])[1] > 0).all()
    found, coarse = area.views(data).findings
    assert found.outcomes[0] == "?"
    assert math.isnan(found.rows[0]["kappa"].value)
    assert found.rows[-1]["kappa"].value > 1
    assert coarse.values["grids"].value == "8 x 8"


ARCHITECTURE = (Path(__file__).parents[2] / "ARCHITECTURE.md").read_text(encoding="utf-8")


def test_the_study_of_the_documentation_runs_and_leaves_what_is_said(tmp_path, monkeypatch):
    code = next(c for c in re.findall(r"```python\n(.*?)```", ARCHITECTURE, re.DOTALL) if "counts" in c)
    (tmp_path / "counted_area.py").write_text(code)
    spec = importlib.util.spec_from_file_location("counted_area", tmp_path / "counted_area.py")
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "counted_area", module)  # where its annotations are looked up
    spec.loader.exec_module(module)
    study = Study(name="counted-area", module=module)
    monkeypatch.setattr("validation.studies._outputs.find_study", lambda name: study)
    options = study.parse(["--points-per-wave", "4,8", "--surfaces", "2"])
    assert study.question.endswith("converges to?")
    assert study.options.model_fields["hursts"].description == "Hurst exponents"
    bench = Bench.at(tmp_path / "solves", execution=Execution(workers=1))
    outputs = run_study(study, options, prepare_folder(tmp_path / "out"), bench=bench)
    data = outputs.data
    coarse, fine = data.overestimate_pixel.mean("hurst").values.ravel()
    # Counting errs by an edge times the spacing: half as much on a grid twice as fine.
    assert 1.6 < coarse / fine < 2.4
    again = data.area_pixel_each / data.area_each - 1
    np.testing.assert_allclose(again - data.overestimate_pixel_each, 0.0, atol=1e-12)
    names = {path.name for path in outputs.files}
    assert {"report.html", "table.csv", "budget.csv", "data.nc", "summary.json"} <= names
    assert audit(tmp_path / "out").wrong == ()
