import subprocess
import sys
from dataclasses import replace
from unittest.mock import MagicMock

import meshio
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fem_contact import HeightField, InvalidInput, Solid, render_section, render_surface, write_block
from fem_contact.block import solve

LENGTHS = (2e-6, 3e-6)


@pytest.fixture(scope="module")
def solution():
    x, y = np.arange(6)[:, None] / 6, np.arange(9)[None, :] / 9
    heights = 1e-8 * (np.cos(2 * np.pi * x) + 0.3 * np.sin(2 * np.pi * y))
    surface = HeightField(heights=heights, lengths=LENGTHS)
    return solve(surface, Solid(young=2e9, poisson=0.25), mean_pressure=1e6)


@pytest.mark.parametrize("suffix", [".vtu", ".xdmf"])
def test_written_block_gives_back_fields_and_periodic_copies(solution, tmp_path, suffix):
    path = tmp_path / f"block{suffix}"
    write_block(path, solution, deformation=0.0)
    mesh = meshio.read(path)
    nodes = (7, 10, solution.planes.size)
    points = mesh.points.reshape(*nodes, 3)
    assert_allclose(points[-1, -1, :, :2], np.broadcast_to(LENGTHS, (nodes[2], 2)), rtol=1e-12)
    displacement = mesh.point_data["displacement"].reshape(*nodes, 3)
    assert_array_equal(displacement[:-1, :-1], solution.field)
    assert_array_equal(displacement[-1, :-1], solution.field[0])
    pressure = mesh.point_data["pressure"].reshape(nodes)
    assert_array_equal(pressure[:-1, :-1, -1], solution.contact.pressure)
    assert not pressure[:, :, :-1].any()
    flag = mesh.point_data["contact"].reshape(nodes)[:-1, :-1, -1]
    assert_array_equal(flag == 1, solution.contact.in_contact)
    von_mises = np.asarray(mesh.cell_data["von_mises"][0]).reshape(solution.stress().von_mises.shape)
    assert_array_equal(von_mises, solution.stress().von_mises)
    assert [entry.name for entry in tmp_path.iterdir() if entry.name.startswith(".partial")] == []


def check_boxes(corner, volume):
    """Cells are boxes with their corners in VTK's order, and fill a volume."""
    size = corner[:, 6] - corner[:, 0]
    assert size.min() > 0
    assert_allclose(size.prod(axis=1).sum(), volume, rtol=1e-12)
    around = ((0, 0), (1, 0), (1, 1), (0, 1))
    for k, place in enumerate((*((i, j, 0) for i, j in around), *((i, j, 1) for i, j in around))):
        assert_allclose(corner[:, k], corner[:, 0] + place * size, atol=1e-12 * LENGTHS[1])


def test_hexahedra_fill_the_block_and_deformed_nodes_move_by_their_displacement(solution, tmp_path):
    write_block(tmp_path / "a.vtu", solution, deformation=0.0)
    write_block(tmp_path / "b.vtu", solution)
    rest, deformed = meshio.read(tmp_path / "a.vtu"), meshio.read(tmp_path / "b.vtu")
    check_boxes(rest.points[rest.cells_dict["hexahedron"]], LENGTHS[0] * LENGTHS[1] * solution.depth)
    moved = deformed.points - rest.points
    assert_allclose(moved, deformed.point_data["displacement"], atol=1e-15 * LENGTHS[1])


def test_unknown_suffix_is_refused_by_name(solution, tmp_path):
    with pytest.raises(InvalidInput, match=r"\.vtu or \.xdmf"):
        write_block(tmp_path / "block.stl", solution)


@pytest.mark.parametrize("element", ["Hex2", "Hex2/P1disc"])
def test_quadratic_cells_are_written_with_all_their_nodes(element, tmp_path):
    x, y = np.arange(8)[:, None] / 8, np.arange(6)[None, :] / 6
    surface = HeightField(heights=1e-8 * np.cos(2 * np.pi * (x + y)), lengths=LENGTHS)
    solution = solve(surface, Solid(young=2e9, poisson=0.25), mean_pressure=1e6, element=element)
    write_block(tmp_path / "block.vtu", solution, deformation=0.0)
    mesh = meshio.read(tmp_path / "block.vtu")
    nodes = mesh.points[mesh.cells_dict["hexahedron27"]]
    assert nodes.shape[0] == 4 * 3 * solution.layers.size
    check_boxes(nodes, LENGTHS[0] * LENGTHS[1] * solution.depth)
    # Edge, face and centre nodes lie in the middle of the corners that VTK puts around them.
    lower, upper = [(k, (k + 1) % 4) for k in range(4)], [(4 + k, 4 + (k + 1) % 4) for k in range(4)]
    sides = [(0, 7), (1, 6), (0, 5), (2, 7), (0, 2), (4, 6), (0, 6)]
    for node, corners in enumerate([*lower, *upper, *((k, k + 4) for k in range(4)), *sides], start=8):
        assert_allclose(nodes[:, node], nodes[:, corners].mean(axis=1), atol=1e-12 * LENGTHS[1])


@pytest.mark.slow
def test_pictures_show_pressure_where_the_contact_is(solution, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    # Without a graphics library the renderer does not fail but kills its process.
    probe = "import pyvista; p = pyvista.Plotter(off_screen=True); p.add_mesh(pyvista.Cube()); p.show()"
    if subprocess.run([sys.executable, "-c", probe], capture_output=True, check=False).returncode:
        pytest.skip("no renderer works here (install libgl1)")
    render_surface(tmp_path / "surface.png", solution)
    render_section(tmp_path / "section.png", solution, axis="x")
    for name in ("surface.png", "section.png"):
        pixels = np.asarray(pyvista.read(tmp_path / name).active_scalars).reshape(-1, 3)
        assert len(np.unique(pixels, axis=0)) > 20
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["section.png", "surface.png"]


@pytest.mark.parametrize("drawn", ["pressure", "von Mises"])
def test_a_picture_has_the_stress_in_mpa_at_its_places(solution, tmp_path, monkeypatch, drawn):
    pyvista = pytest.importorskip("pyvista")
    plotter = MagicMock(**{"screenshot.side_effect": lambda path: path.write_bytes(b"")})
    monkeypatch.setattr(pyvista, "Plotter", lambda **_: plotter)
    render = render_surface if drawn == "pressure" else render_section
    render(tmp_path / "picture.png", solution)
    (mesh,), named = plotter.add_mesh.call_args
    pressure, values = solution.contact.pressure, 1e6 * mesh[named["scalars"]]
    if drawn == "pressure":
        assert_allclose(values.reshape(mesh.dimensions[:2], order="F")[:-1, :-1], pressure)
    else:
        # Through the highest pressure, across y.
        row = np.unravel_index(pressure.argmax(), pressure.shape)[1]
        layers = dict(solution.stress_layers())
        cut = [layers[k].von_mises[:, row] for k in sorted(layers)]
        assert_allclose(values, np.concatenate(cut))
    assert mesh.bounds.x_max == pytest.approx(LENGTHS[0] / max(LENGTHS))


def test_a_picture_of_a_patch_ends_at_its_last_points(solution, tmp_path, monkeypatch):
    plotter = MagicMock(**{"screenshot.side_effect": lambda path: path.write_bytes(b"")})
    monkeypatch.setattr(pytest.importorskip("pyvista"), "Plotter", lambda **_: plotter)
    patch = replace(solution.contact, provenance={"method": "free surroundings"})
    render_surface(tmp_path / "picture.png", patch)
    (mesh,), named = plotter.add_mesh.call_args
    values = 1e6 * mesh[named["scalars"]].reshape(mesh.dimensions[:2], order="F")
    assert_allclose(values, patch.pressure)
    assert mesh.bounds.x_max == pytest.approx((LENGTHS[0] - patch.spacing[0]) / max(LENGTHS))


@pytest.mark.parametrize(("axis", "other"), [("x", 1), ("y", 0)])
def test_a_cut_spans_the_other_side_of_the_period(solution, tmp_path, monkeypatch, axis, other):
    drawn = MagicMock()
    monkeypatch.setattr("fem_contact.export._drawn", drawn)
    render_section(tmp_path / "cut.png", solution, axis=axis)
    _, (s, _, z), _, stress = drawn.call_args.args
    assert (s.min(), s.max()) == (0.0, pytest.approx(LENGTHS[other] / max(LENGTHS)))
    assert z.max() == 0.0
    assert stress.shape == (solution.mesh.cells[other], solution.mesh.nz)
    assert s.shape == z.shape == tuple(n + 1 for n in stress.shape)


@pytest.mark.parametrize("position", [1.0, "middle", np.nan])
def test_cut_outside_the_period_is_refused(solution, tmp_path, position):
    with pytest.raises(InvalidInput, match=r"^position"):
        render_section(tmp_path / "cut.png", solution, position=position)


@pytest.mark.parametrize("path", [None, 7, b"block.vtu", "", ".", "with\0zero.vtu"])
@pytest.mark.parametrize("write", [write_block, render_surface, render_section])
def test_what_is_no_name_of_a_file_is_refused(write, path, solution):
    with pytest.raises(InvalidInput, match="path"):
        write(path, solution)


@pytest.mark.parametrize("write", [write_block, render_surface, render_section])
def test_what_is_no_solution_of_a_block_is_refused(write, tmp_path):
    with pytest.raises(InvalidInput, match="solution = 'x': must be a `BlockSolution`"):
        write(tmp_path / "block.vtu", "x")
