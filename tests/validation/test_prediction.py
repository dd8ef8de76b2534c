"""Predicted time and memory, within a factor of two over a committed list of cases."""

import itertools
import json
from dataclasses import replace

import pytest
from processes import run_python

from validation.execution.press import Press
from validation.sandbox import ONE_THREAD
from validation.scenes.problem import ContactProblem
from validation.scenes.tables import Load, SelfAffineSurface, SolidSpec

#: method, points along a side, p*, settings
LIST = [
    ("bem", 64, 0.05, {}),
    ("bem", 256, 0.005, {}),
    ("bem", 256, 0.5, {}),
    ("bem", 512, 0.05, {}),
    ("bem", 1024, 0.05, {}),
    ("fem", 32, 0.05, {"method": "full", "growth": 1.2}),
    ("fem", 48, 0.05, {"method": "full", "growth": 1.2}),
    ("fem", 256, 0.05, {"method": "reduced", "growth": 1.2}),
    ("fem", 512, 0.05, {"method": "reduced", "growth": 1.2}),
]


def job_of(number, *, small=False):
    method, n, pressure, settings = LIST[number]
    waves = {"length": (1e-4, 1e-4), "lambda_long": 5e-5, "hurst": 0.8, "rms_gradient": 0.1, "seed": 12}
    shortest = 2.5e-5 if small or n < 64 else 1e-4 / 16
    surface = SelfAffineSurface(kind="self-affine", lambda_short=shortest, **waves)
    solid, load = SolidSpec(young=1e9, poisson=0.3), Load(reduced_pressure=pressure)
    grid, problem = (16 if small else n,) * 2, ContactProblem(surface=surface, solid=solid, load=load)
    return Press(method=method, grid=grid, problem=problem, settings=tuple(settings.items()))


MEASURE = """
import importlib.util, json, pathlib, resource, sys, tempfile, time
spec = importlib.util.spec_from_file_location("listed", sys.argv[1])
listed = importlib.util.module_from_spec(spec)
spec.loader.exec_module(listed)
from validation.execution.solve import transform_seconds
from validation.execution.attempt import attempt
from validation.execution.store import Store
number = int(sys.argv[2])
with tempfile.TemporaryDirectory() as folder:
    store = Store(folder=pathlib.Path(folder))
    attempt(listed.job_of(number, small=True), store, threads=1)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    pair, began = transform_seconds(), time.process_time()
    attempt(listed.job_of(number), store, threads=1)
    seconds = time.process_time() - began
memory = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
predicted = listed.job_of(number).predict(pair_seconds=pair)
print(json.dumps([seconds / predicted.seconds, memory / predicted.peak_bytes]))
"""


@pytest.mark.benchmark
@pytest.mark.parametrize("number", range(len(LIST)), ids=["-".join(map(str, case[:3])) for case in LIST])
def test_prediction_is_right_within_a_factor_of_two(number):
    # Processor time, because the prediction is for a machine that does nothing else; the better of two
    # trials.
    ratios = []
    for _ in range(2):
        done = run_python("-c", MEASURE, __file__, number, **ONE_THREAD)
        assert done.returncode == 0, done.stderr
        ratios.append(json.loads(done.stdout))
    time, memory = (min((r[k] for r in ratios), key=lambda x: abs(x - 1)) for k in (0, 1))
    print(f"{LIST[number]}: measured over predicted: time {time:.2f}, memory {memory:.2f}")
    assert 0.5 < time < 2
    assert 0.5 < memory < 2


def test_prediction_grows_with_the_grid_and_knows_the_reduction():
    bem = [job_of(k).predict() for k in (0, 1, 3, 4)]
    for smaller, larger in itertools.pairwise(bem):
        assert larger.seconds > smaller.seconds
        assert larger.peak_bytes > smaller.peak_bytes
    full, reduced = job_of(6).predict(), job_of(7).predict()
    assert reduced.unknowns > full.unknowns
    assert reduced.seconds < full.seconds
    assert job_of(0).predict(pair_seconds=2e-3).seconds == pytest.approx(4 * bem[0].seconds)


@pytest.mark.parametrize("number", [0, 5, 7], ids=["bem", "full", "reduced"])
def test_prediction_of_a_turned_grid_is_the_same(number):
    job = job_of(number)

    def predicted(*grid):
        surface = job.problem.surface.model_copy(update={"length": tuple(1e-6 * n for n in grid)})
        return replace(job, grid=grid, problem=replace(job.problem, surface=surface)).predict()

    assert predicted(24, 60) == predicted(60, 24)
    assert predicted(24, 24).seconds < predicted(24, 60).seconds < predicted(60, 60).seconds
    assert predicted(24, 24).peak_bytes < predicted(24, 60).peak_bytes < predicted(60, 60).peak_bytes
