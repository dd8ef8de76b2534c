"""The processes of MPI themselves, skipped where there is none; test_slabs.py has threads in their place."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time

import h5py
import pytest
from small_scene import small_scene

pytest.importorskip("mpi4py", exc_type=ImportError)
MPIEXEC = shutil.which("mpiexec")
pytestmark = pytest.mark.skipif(MPIEXEC is None, reason="no mpiexec")

EQUAL = """
import sys
import numpy as np
from fem_contact import BondedLayer, HalfSpace, Solid, bem, contact_areas, random_surface
from fem_contact.bem.parallel import communicator

comm, solid = communicator(), Solid(young=1.0, poisson=0.5)
for shape, response, bound in (
    ((64, 64), HalfSpace(solid=solid), None),
    ((45, 61), HalfSpace(solid=solid), 0.2),
    ((300, 257), HalfSpace(solid=solid), None),
    ((48, 33), BondedLayer(solid=solid, thickness=0.05), None),
):
    options = {
        "q_short": 60.0, "lengths": (1.0, shape[1] / shape[0]), "shape": shape, "seed": 7, "isotropic": True
    }
    spectrum = lambda q: 1e-3 * q**-3.6
    slabs = bem.SlabSurface.random(spectrum, comm=comm, **options)
    pressed = {"mean_pressure": 0.02, "pressure_bound": bound, "tolerance": 1e-11}
    result = bem.solve(slabs, response, comm=comm, **pressed).checked()
    areas, whole = result.areas(), result.whole()
    alone = bem.solve(random_surface(spectrum, **options), response, threads=1, **pressed).checked()
    assert np.abs(whole.pressure - alone.pressure).max() < 1e-9 * alone.pressure.max(), shape
    assert np.array_equal(whole.in_contact, alone.in_contact), shape
    assert abs(areas.subcell - contact_areas(alone, subcell=True).subcell) < 1e-9, shape
if all(comm.allgather(True)) and comm.rank == 0:
    print("equal", comm.size)
"""

SCENE = small_scene(grids="[32, 48]")


def mpiexec(count, *arguments):
    assert MPIEXEC is not None
    return [MPIEXEC, "--oversubscribe", "-n", str(count), sys.executable, *arguments]


def surroundings():
    """Return what Open MPI asks for in containers, and on fewer processors than processes."""
    names = ("OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "OMPI_MCA_mpi_yield_when_idle")
    return os.environ | dict.fromkeys(names, "1") | {"OMP_NUM_THREADS": "1"}


def run(count, *arguments):
    command = mpiexec(count, *arguments)
    told = {"capture_output": True, "text": True, "timeout": 300}
    return subprocess.run(command, env=surroundings(), check=False, **told)


def told(text):
    """Return the JSON in what all processes have printed; Open MPI adds codes for terminals."""
    return json.loads(text[text.index("{") : text.rindex("}") + 1])


@pytest.mark.parametrize("count", [1, 3])
def test_any_number_of_processes_gives_the_answer_of_one(count):
    done = run(count, "-c", EQUAL)
    assert done.returncode == 0, done.stderr
    assert f"equal {count}" in done.stdout


def test_the_command_writes_the_same_with_one_process_and_with_three(tmp_path):
    scene = tmp_path / "small.toml"
    scene.write_text(SCENE)
    found = []
    for count in (1, 3):
        folder = tmp_path / str(count)
        command = ("-m", "validation.cli", "run", str(scene), "--mpi", "--json", "-o", str(folder))
        done = run(count, *command)
        assert done.returncode == 0, done.stderr
        found.append(told(done.stdout))
        assert len(list((folder / "mpi").glob("*.h5"))) == 2
    assert told(run(3, *command).stdout) == found[-1], "finished grids are used again"
    one, three = found
    assert (one["processes"], three["processes"]) == (1, 3)
    assert three["limit"]["value"] == pytest.approx(one["limit"]["value"], rel=1e-8)
    refused = run(3, *command, "--accuracy", "1%")
    assert refused.returncode == 2
    assert refused.stderr.count("--accuracy: does not go with --mpi") == 1


def test_a_killed_process_ends_the_run_and_what_was_stored_stays(tmp_path):
    scene = tmp_path / "large.toml"
    scene.write_text(SCENE.replace("[32, 48]", "[32, 2048]"))
    command = mpiexec(3, "-m", "validation.cli", "run", str(scene), "--mpi", "-o", str(tmp_path / "out"))
    process = subprocess.Popen(command, env=surroundings(), stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    began = time.monotonic()
    while not (stored := list(tmp_path.glob("out/mpi/bem-32x32-*.h5"))):
        assert time.monotonic() - began < 200
        time.sleep(0.2)
    listed = subprocess.check_output(["ps", "-o", "pid=", "--ppid", str(process.pid)], text=True)
    os.kill(int(listed.split()[-1]), signal.SIGKILL)
    killed = time.monotonic()
    process.communicate(timeout=60)
    assert time.monotonic() - killed < 60
    assert process.returncode != 0
    with h5py.File(stored[0]) as file:
        assert file["pressure"].shape == (32, 32)
    assert not list(tmp_path.glob("out/mpi/bem-2048*.h5"))
