"""What schedulers and containers leave behind, and what the machine refuses: a line, not a traceback."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from processes import ROOT, run_python

from fem_contact import _environment as environment


@pytest.fixture(autouse=True)
def environment_restored():
    """What is settled in one test is not left to the next."""
    before = dict(os.environ)
    yield
    os.environ.clear()
    os.environ.update(before)


def command(line, shell="", **extra):
    """Run `fem-contact`, after commands of the shell."""
    return run_python("-m", "validation.cli", *line.split(), shell=shell, **extra)


@pytest.mark.parametrize(
    ("said", "kept"), [("", None), ("2,1", "2"), (" 4 ", "4"), ("0", None), ("-1", None), ("many", None)]
)
def test_numbers_of_threads_are_put_right(monkeypatch, said, kept):
    monkeypatch.setenv("OMP_NUM_THREADS", said)
    environment.settle()
    assert os.environ.get("OMP_NUM_THREADS") == kept


def test_the_solvers_alone_press_whatever_omp_num_threads_says():
    code = (
        "from fem_contact import bem, HalfSpace, Solid, HeightField; import numpy as np\n"
        "field = HeightField(heights=np.random.default_rng(3).random((16, 16)), lengths=(1.0, 1.0))\n"
        "solid = Solid(young=1.0, poisson=0.0)\n"
        "print(bem.solve(field, HalfSpace(solid=solid), mean_pressure=0.1).status.name)"
    )
    done = run_python("-c", code, OMP_NUM_THREADS="2,1")
    assert done.stdout.strip() == "CONVERGED", done.stderr


def test_compiled_passes_are_kept_in_a_private_folder_where_nothing_else_can_be_written(
    monkeypatch, tmp_path
):
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setattr(environment, "_writable", lambda folder: str(folder).startswith(str(tmp_path)))
    monkeypatch.setattr(environment.tempfile, "gettempdir", lambda: str(tmp_path))
    environment.settle()
    folder = Path(os.environ["NUMBA_CACHE_DIR"])
    assert folder.parent == tmp_path
    assert folder.stat().st_mode & 0o777 == 0o700
    folder.chmod(0o777)  # somebody else may have put there what we would run
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setattr(environment.tempfile, "tempdir", str(tmp_path))
    environment.settle()
    assert Path(os.environ["NUMBA_CACHE_DIR"]) != folder


@pytest.mark.parametrize("shut", ["fem_contact", "persson"])
def test_both_packages_need_a_cache_of_their_own(monkeypatch, tmp_path, shut):
    def writable(folder):
        return f"/{shut}/__pycache__" not in str(folder) and not str(folder).startswith("/nowhere")

    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", "/nowhere")
    monkeypatch.setattr(environment.tempfile, "gettempdir", lambda: str(tmp_path))
    monkeypatch.setattr(environment, "_writable", writable)
    environment.settle()
    assert Path(os.environ["NUMBA_CACHE_DIR"]).parent == tmp_path


def test_a_cache_that_can_be_written_is_left_alone(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    environment.settle()
    assert os.environ["NUMBA_CACHE_DIR"] == str(tmp_path)
    monkeypatch.setenv("NUMBA_CACHE_DIR", "/proc/nowhere")
    monkeypatch.setattr(environment.os, "access", lambda place, mode: not str(place).startswith("/proc"))
    environment.settle()
    assert os.environ.get("NUMBA_CACHE_DIR") != "/proc/nowhere"


@pytest.mark.parametrize(
    ("package", "kernels"),
    [
        ("validation", "fem_contact.complementarity.kernels"),
        pytest.param("fem_contact", "fem_contact.complementarity.kernels", marks=pytest.mark.nightly),
        pytest.param("persson", "persson._galerkin", marks=pytest.mark.nightly),
    ],
)
def test_kernels_compile_with_a_read_only_home_and_package(tmp_path, package, kernels):
    """Both on a file system that nobody can write to, as in a container; solvers and theory alone, too."""
    inside, mount = tmp_path / "image", shutil.which("mount")
    inside.mkdir()
    for name in ("contact_checks", "persson", "fem_contact", "validation"):
        shutil.copytree(ROOT / name, inside / name, ignore=shutil.ignore_patterns("__pycache__"))
    bound = mount and subprocess.run([mount, "--bind", inside, inside], capture_output=True, check=False)
    if not bound or bound.returncode:
        pytest.skip("LOUD: a read-only package folder is not tested: nothing can be mounted here")
    try:
        subprocess.run([mount, "-o", "remount,ro,bind", inside], check=True)
        code = f"import {package}, os, {kernels}; print(os.environ.get('NUMBA_CACHE_DIR', ''))"
        other = {"HOME": str(inside), "TMPDIR": str(tmp_path), "PYTHONPATH": str(inside)}
        kept = {k: v for k, v in os.environ.items() if k not in ("XDG_CACHE_HOME", "NUMBA_CACHE_DIR")} | other
        command = [sys.executable, "-c", code]
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=kept, cwd=tmp_path)
    finally:
        subprocess.run(["umount", "-l", inside], check=True)
    assert done.returncode == 0, done.stderr
    if package != "persson":  # which compiles anew instead
        assert Path(done.stdout.strip()).parent == tmp_path


@pytest.mark.parametrize(
    "line",
    [
        "scenes list",
        pytest.param("--help", marks=pytest.mark.nightly),
        pytest.param("scenes show quickstart", marks=pytest.mark.nightly),
    ],
)
def test_an_output_that_is_full_is_one_line(line):
    done = command(line, shell="exec > /dev/full;")
    assert done.returncode == 1
    assert done.stderr == "fem-contact: the output cannot be written (No space left on device)\n"


@pytest.mark.nightly
@pytest.mark.parametrize("line", ["scenes list", "run quickstart --dry-run --json"])
def test_an_output_that_is_closed_is_no_traceback(line):
    done = command(line, shell="exec >&-;")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.nightly
@pytest.mark.parametrize("line", ["run quickstart -q", "study heights", "reproduce"])
def test_an_output_folder_that_is_a_link_to_itself_is_one_line(line, tmp_path):
    (tmp_path / "loop").symlink_to("loop")
    done = command(f"{line} -o {tmp_path / 'loop'}")
    assert done.returncode == 2
    assert done.stderr.endswith("loop': cannot be written to (File exists); name another folder\n")
    assert done.stderr.count("\n") == 1


def test_too_little_memory_is_one_line(tmp_path):
    done = command(f"run quickstart -q -o {tmp_path}", shell="ulimit -v 600000;")
    assert done.returncode == 2
    assert done.stderr == (
        "fem-contact: ulimit -v = 600000: the libraries alone take more; allow 1048576 or more\n"
    )
