"""The block by CalculiX beside our own full finite elements, on one mesh."""

import os

import numpy as np
import pytest
from small_scene import scene_in, square_scene

from fem_contact import HeightField, NotConverged, Solid
from validation.effects.base import ContactModel
from validation.errors import UsageError
from validation.scenes.problem import realise
from validation.solvers import find_solver
from validation.solvers.base import Job, example_field
from validation.solvers.calculix import _YOUNG, _deck

CALCULIX, FEM = find_solver("calculix"), find_solver("fem")
present = pytest.mark.skipif(CALCULIX.available() is not None, reason=str(CALCULIX.available()))


def pressed(solver, field, load, solid, **settings):
    load = {"mean_pressure": load * solid.young}
    return solver.solve(
        Job(field=field, load=load, model=ContactModel(solid=solid), settings=settings)
    ).contact


@present
@pytest.mark.parametrize(
    ("shape", "lengths", "poisson", "load"),
    [
        ((12, 12), (1e-4, 1e-4), 0.3, 0.02),
        ((8, 12), (1e-4, 2e-4), 0.0, 0.01),
        ((12, 12), (1.0, 1.0), 0.3, 1e-4),
    ],
)
def test_calculix_and_our_full_block_agree_in_nodal_forces(shape, lengths, poisson, load):
    unit = example_field(32).resampled(shape)
    field = HeightField(heights=unit.heights * lengths[0], lengths=lengths)
    solid = Solid(young=2e9, poisson=poisson)
    theirs = pressed(CALCULIX, field, load, solid).checked()
    ours = pressed(FEM, field, load, solid, tolerance=1e-10).checked()
    # A closed gap gives by F / K, with K a million times the stiffness of a cell; 7 digits are printed.
    assert np.linalg.norm(theirs.pressure - ours.pressure) < 5e-6 * np.linalg.norm(ours.pressure)
    assert np.array_equal(theirs.in_contact, ours.in_contact)
    assert theirs.cost.cpu_seconds > 0
    assert theirs.offset == pytest.approx(ours.offset, abs=1e-6 * np.abs(ours.displacement).max())


def test_a_solid_on_which_its_cells_lock_is_refused(tmp_path):
    text = square_scene("[methods.calculix]\ngrids = [12]\n").replace("poisson = 0.3", "poisson = 0.45")
    scene = scene_in(tmp_path, text)
    options = scene.methods.options("calculix")
    with pytest.raises(UsageError, match=r"poisson = 0\.45: elements of method 'calculix' lock above 0\.4"):
        CALCULIX.check(options, realise(scene), scene.effects)


def test_each_node_of_the_deck_is_one_and_each_that_is_named_is_there():
    heights, planes = np.random.default_rng(5).random((3, 4)), np.array([0.0, -0.2, -0.5])
    lines = list(_deck(heights, (0.75, 1.0), planes, poisson=0.3, load=0.1))
    blocks = dict[str, list[list[str]]]()
    for line in lines:
        if line.startswith("*"):
            blocks.setdefault(key := line.split(",ELSET=G")[0], [])
        else:
            blocks[key].append(line.split(","))
    nodes = {int(row[0]): tuple(map(float, row[1:])) for row in blocks["*NODE,NSET=ALL"]}
    assert len(nodes) == len(blocks["*NODE,NSET=ALL"]) == 4 * 5 * 3 + 3 * 4
    cells = [list(map(int, row)) for row in blocks["*ELEMENT,TYPE=C3D8,ELSET=BLOCK"]]
    gaps = [list(map(int, row)) for row in blocks["*ELEMENT,TYPE=GAPUNI"]]
    assert sorted(number for number, *_ in (*cells, *gaps)) == list(range(1, 2 * 12 + 12 + 1))
    volume = 0.0
    for _, *around in cells:
        corners = np.array([nodes[node] for node in around])
        edges = corners[1] - corners[0], corners[3] - corners[0], corners[4] - corners[0]
        assert np.linalg.det(edges) > 0
        np.testing.assert_allclose(corners[6] - corners[0], sum(edges), atol=1e-12)
        volume += np.linalg.det(edges)
    assert volume == pytest.approx(0.75 * 1.0 * 0.5)
    for _, top, above in gaps:  # a node of the rigid body stands above each of the surface
        np.testing.assert_allclose(np.subtract(nodes[above], nodes[top]), (0, 0, 0.25), atol=1e-12)
    # Each node of a far side goes with the one a period before it, and all of the rigid body sink alike.
    ties = [row for row in blocks["*EQUATION"] if len(row) > 1]
    moved = {
        (axis, *np.subtract(nodes[int(far)], nodes[int(near)]))
        for far, axis, _, near, *_ in ties
        if nodes[int(far)][2] <= 0
    }
    assert moved == {(axis, x, y, 0.0) for axis in "123" for x in (0, 0.75) for y in (0, 1) if x or y}
    assert len(ties) == 2 * 3 * (4 * 5 - 3 * 4) + 3 * 4 - 1
    # Load and solid are those that were asked for.
    assert [list(map(float, row)) for row in blocks["*ELASTIC"]] == [[_YOUNG, 0.3]]
    ((_, axis, force),) = blocks["*CLOAD"]
    assert (axis, float(force)) == ("3", pytest.approx(-0.1 * 0.75 * 1.0))


@present
def test_time_that_is_over_is_said():
    solid = Solid(young=1.0, poisson=0.3)
    with pytest.raises(NotConverged, match=r"took more than 0\.01 s"):
        pressed(CALCULIX, example_field(16), 0.01, solid, seconds=0.01)


def test_a_missing_program_is_named(monkeypatch):
    monkeypatch.setattr("shutil.which", lambda name: None)
    assert "apt install calculix-ccx" in str(CALCULIX.available())


@pytest.mark.skipif(os.name == "nt", reason="a shell script stands in for the program")
def test_a_program_that_fails_is_quoted(tmp_path, monkeypatch):
    program = tmp_path / "ccx"
    program.write_text("#!/bin/sh\necho ' *ERROR in something: no'\nexit 201\n", encoding="utf-8")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    with pytest.raises(NotConverged, match=r"\*ERROR in something: no"):
        pressed(CALCULIX, example_field(16), 0.01, Solid(young=1.0, poisson=0.3))
