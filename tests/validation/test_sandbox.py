"""A call in a child ends within its time and memory, whatever it does, and the next one is answered."""

import importlib
import math
import os
import signal
import time

import numpy as np
import pytest

from validation.errors import UsageError
from validation.sandbox import Child, OutOfBounds, _limited
from validation.scenes.topography.formats import read_plain


@pytest.fixture(scope="module")
def child():
    with Child() as started:
        yield started


def test_values_and_arrays_come_back_as_they_are(child):
    assert child.call(math.gcd, 12, 18, seconds=20) == 6
    found = child.call(os.path.splitext, "heights.nc", seconds=20)
    assert found == ("heights", ".nc")
    table = child.call(np.geomspace, 1.0, 8.0, 4, seconds=20)
    np.testing.assert_array_equal(table, np.geomspace(1.0, 8.0, 4))
    assert not table.flags.writeable


def test_a_module_in_the_folder_of_a_notebook_is_found(tmp_path, monkeypatch):
    (tmp_path / "beside_the_notebook.py").write_text("def double(x):\n    return 2 * x\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend("")
    double = importlib.import_module("beside_the_notebook").double
    with Child() as child:
        assert child.call(double, 21, seconds=60) == 42


def test_a_function_that_cannot_be_imported_is_one_answer_and_the_next_call_has_its_own(child, monkeypatch):
    monkeypatch.setattr(math, "nowhere", lambda: 1, raising=False)
    math.nowhere.__module__, math.nowhere.__qualname__ = "math", "nowhere"
    for _ in range(2):
        with pytest.raises(AttributeError, match="nowhere"):
            child.call(math.nowhere, seconds=20)
        asked = child.pid
        assert child.call(math.gcd, 12, 18, seconds=20) == 6
        assert child.pid == asked


def test_what_a_function_raises_is_raised_here(child):
    with pytest.raises(ValueError, match=r"math domain error|nonnegative"):
        child.call(math.sqrt, -1.0, seconds=20)
    with pytest.raises(FileNotFoundError) as caught:
        child.call(os.listdir, "/no/such/folder", seconds=20)
    assert caught.value.errno == 2
    with pytest.raises(UsageError, match="cannot be read: No such file"):
        child.call(read_plain, "/no/such/file.npy", seconds=20)


def test_a_call_that_does_not_end_is_ended_and_the_next_one_answered():
    with Child() as child:
        start = time.monotonic()
        with pytest.raises(OutOfBounds, match=r"took more than 0\.5 s"):
            child.call(time.sleep, 3600, seconds=0.5)
        # The interpreter's start is not counted, but happens.
        assert time.monotonic() - start < 60
        assert child.call(math.gcd, 4, 6, seconds=20) == 2


def test_a_call_that_takes_all_memory_is_refused_it():
    with Child() as child:
        with pytest.raises(OutOfBounds, match="took more than 64 MiB of memory"):
            child.call(np.ones, 2**27, seconds=60, memory=2**26)
        assert child.call(np.ones, 2**20, seconds=60, memory=2**26).sum() == 2**20


def test_an_array_larger_than_is_taken_back_is_not_read():
    with Child() as child, pytest.raises(OutOfBounds, match="gave back more than 1 MiB"):
        child.call(np.ones, 2**20, seconds=60, most_bytes=2**20)


def test_a_call_may_use_the_processor_for_all_its_time():
    resource = pytest.importorskip("resource")
    used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    before = resource.getrlimit(resource.RLIMIT_CPU)
    if before[1] != resource.RLIM_INFINITY:
        pytest.skip("the system bounds the time of all processes")
    with _limited(1000.0, None):
        assert used + 1000 < resource.getrlimit(resource.RLIMIT_CPU)[0] < used + 1020
    assert resource.getrlimit(resource.RLIMIT_CPU) == before


def test_a_crash_is_said_with_its_signal():
    with Child() as child:
        assert not child.imported
        with pytest.raises(OutOfBounds, match=r"crashed its process \(SIGSEGV\)"):
            child.call(signal.raise_signal, int(signal.SIGSEGV), seconds=20)
        assert child.imported
        assert child.call(math.gcd, 4, 6, seconds=20) == 2


def test_a_child_ends_with_the_one_that_asked():
    child = Child()
    process_id = child.call(os.getpid, seconds=20)
    assert process_id != os.getpid()
    child.close()
    with pytest.raises(ProcessLookupError):
        os.kill(process_id, 0)
