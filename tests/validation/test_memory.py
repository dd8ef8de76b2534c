"""Memory that runs out wherever it does: a result or one line, and what was finished stays intact."""

import os
import random
import resource
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from processes import run_python
from solving import Numbers, fields

from validation.execution.attempt import attempt
from validation.execution.store import Sealed, Store, check_store

LINUX = pytest.mark.skipif(sys.platform != "linux", reason="RLIMIT_AS is held on Linux alone")
pytestmark = [pytest.mark.nightly, LINUX]

#: Exit statuses of a trial.
SOLVED, REFUSED, TRACEBACK = 0, 3, 4


def _are_intact(folder):
    assert all(isinstance(found, Sealed) for *_, found in check_store(folder, set_aside=False))


def solves():
    return {"fields": fields(points=64), "numbers": Numbers(5)}


def trials(folder, count, seed):
    """Solve `count` times in forks of this process, each with a random rest of memory; print what came.

    In a process of its own: forks share what is imported and compiled, so that a trial takes milliseconds.
    """
    rng, store = random.Random(seed), Store(folder=Path(folder))
    for solve in solves().values():
        assert attempt(solve, store, threads=1).error is None
    whole = {path.name: path.read_bytes() for path in store.folder.iterdir()}
    ends = Counter()
    for trial in range(count):
        name = rng.choice(sorted(solves()))
        extra = int(2 ** rng.uniform(12, 27))
        child = os.fork()
        if child == 0:
            _one_trial(solves()[name], Store(folder=store.folder / "trial"), extra)
        _, status = os.waitpid(child, 0)
        code = os.waitstatus_to_exitcode(status)
        ends[code] += 1
        if code not in (SOLVED, REFUSED):
            print(f"trial {trial}: {name} with {extra} bytes ended with {code}", file=sys.stderr)
    assert whole == {path.name: path.read_bytes() for path in store.folder.iterdir() if path.is_file()}
    _are_intact(store.folder / "trial")
    assert not list((store.folder / "trial").glob("*.corrupt"))
    print(ends[SOLVED], ends[REFUSED], sum(ends.values()))


def _one_trial(solve, store, extra):
    code = TRACEBACK
    try:
        store.folder.mkdir(exist_ok=True)
        with open("/proc/self/statm") as file:
            used = int(file.read().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + extra, used + extra))
        outcome = attempt(solve, store, threads=1)
        if outcome.error is None:
            code = SOLVED
        elif "\n" not in outcome.error:
            code = REFUSED
    except MemoryError:
        # The few lines around `attempt` in a worker, which the command tells in a line.
        code = REFUSED
    finally:
        os._exit(code)


@pytest.mark.parametrize("count", [20, pytest.param(1000, marks=pytest.mark.slow)])
def test_a_solve_that_meets_the_end_of_memory_anywhere_ends_in_a_line(tmp_path, count):
    code = "import sys; sys.path.insert(0, 'tests/validation'); import test_memory as m\n"
    code += "m.trials(sys.argv[1], int(sys.argv[2]), 2026)"
    done = run_python("-c", code, tmp_path, count, OPENBLAS_NUM_THREADS="1")
    assert done.returncode == 0, done.stderr
    solved, refused, tried = map(int, done.stdout.split())
    assert tried == count
    assert solved + refused == tried, done.stderr
    assert solved >= count // 10
    assert refused >= count // 10


@pytest.mark.slow
def test_the_command_under_any_limit_of_memory_ends_in_a_result_or_in_a_line(tmp_path, write_scene):
    scene = write_scene(fem=False)
    rng, ends = np.random.default_rng(11), Counter()
    limits = np.exp(rng.uniform(np.log(2e5), np.log(4e6), 40)).astype(int)  # kilobytes
    for limit in limits:
        arguments = ("run", str(scene), "-q", "--no-report", "-o", str(tmp_path / "out"))
        code = "from validation.cli import main; main()"
        done = run_python("-c", code, *arguments, shell=f"ulimit -v {limit};", OPENBLAS_NUM_THREADS="1")
        last = done.stderr.strip().splitlines()[-1:] or [""]
        told = "Traceback" not in done.stderr and last[0].startswith("fem-contact: ")
        good = done.returncode == 0 or (done.returncode in (1, 2) and told)
        ends["good" if good else f"{limit}: {done.returncode} {done.stderr[-300:]}"] += 1
    assert dict(ends) == {"good": len(limits)}
    _are_intact(tmp_path / "out" / "solves")
