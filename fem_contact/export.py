"""Results for other programs and for the eye: blocks, and what lies below a contact, as files; pictures."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from fem_contact._checks import choice, finite, instance, shown
from fem_contact._types import Array, Numbers
from fem_contact.contact import ContactResult
from fem_contact.errors import InvalidInput
from fem_contact.stress import von_mises

if TYPE_CHECKING:
    from fem_contact.block import BlockSolution
    from fem_contact.subsurface import Subsurface

#: Nodes of a triquadratic hexahedron in VTK's order: corners, edges, faces, centre; in half cells.
_NODES27 = (
    *((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)),
    *((1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2)),
    *((0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)),
    *((0, 1, 1), (2, 1, 1), (1, 0, 1), (1, 2, 1), (1, 1, 0), (1, 1, 2), (1, 1, 1)),
)
#: Corners of a trilinear one.
_CORNERS = tuple((x // 2, y // 2, z // 2) for x, y, z in _NODES27[:8])


def write_block(path: Path, solution: BlockSolution, *, deformation: float = 1.0) -> None:
    """Write the deformed block with its stress for ParaView and the like (``.vtu`` or ``.xdmf``).

    Point data: displacement [m], pressure [Pa] and contact flag (0 or 1) on the surface nodes, 0 below. Cell
    data: stress (xx, yy, zz, yz, xz, xy) [Pa] and von Mises stress [Pa] at the centres. The periodic images
    at x = Lx and y = Ly are written as nodes of their own.

    Parameters
    ----------
    path : Path
        File to write; it appears under this name only once complete.
    solution : BlockSolution
    deformation : float
        Factor on the displacement of the written nodes; 0 gives the undeformed block.

    Raises
    ------
    InvalidInput
        For a suffix other than ``.vtu`` and ``.xdmf``.
    """
    path = _mesh_path(path)
    _check_solution(solution)
    deformation = finite("deformation", deformation)
    import meshio

    displacement = _unfolded(solution.field)
    surface = {"pressure": solution.contact.pressure, "contact": solution.contact.in_contact.astype(float)}
    point_data: dict[str, Array] = {"displacement": displacement.reshape(-1, 3)}
    for name, values in surface.items():
        on_top = np.zeros(displacement.shape[:3])
        on_top[:, :, -1] = _unfolded(values)
        point_data[name] = on_top.ravel()
    stress = solution.stress()
    kind, corners = (
        ("hexahedron", _CORNERS) if solution.mesh.element.order == 1 else ("hexahedron27", _NODES27)
    )
    mesh = meshio.Mesh(
        points=(_grid_points(solution.contact, solution.planes) + deformation * displacement).reshape(-1, 3),
        cells=[(kind, _cells(displacement.shape[:3], corners, step=solution.mesh.element.order))],
        point_data=point_data,
        cell_data={"stress": [stress.tensor.reshape(-1, 6)], "von_mises": [stress.von_mises.ravel()]},
    )
    _write_mesh(path, mesh)


def write_subsurface(path: Path, below: Subsurface) -> None:
    """Write displacement and stress below a contact for ParaView and the like (``.vtu`` or ``.xdmf``).

    Point data, in single precision: displacement [m], stress (xx, yy, zz, yz, xz, xy) [Pa] and von Mises
    stress [Pa]. Points lie at z = -depth; the periodic images at x = Lx and y = Ly are points of their own.

    Parameters
    ----------
    path : Path
        File to write; it appears under this name only once complete.
    below : Subsurface
        On at least two depths.

    Raises
    ------
    InvalidInput
        For a suffix other than ``.vtu`` and ``.xdmf``, or fields of a single depth.
    """
    from fem_contact.subsurface import Subsurface

    path = _mesh_path(path)
    instance("below", below, Subsurface)
    if below.depths.size < 2:
        raise InvalidInput(f"below: has {below.depths.size} depth; a file of cells needs at least two")
    import meshio

    # Cells count their corners upwards, depths count down.
    upwards = slice(None, None, -1)
    displacement, stress = (
        _unfolded(field[:, :, upwards].astype(np.float32)) for field in (below.displacement, below.stress)
    )
    points = _grid_points(below.contact, -below.depths[upwards])
    mesh = meshio.Mesh(
        points=points.reshape(-1, 3),
        cells=[("hexahedron", _cells(points.shape[:3], _CORNERS, step=1))],
        point_data={
            "displacement": displacement.reshape(-1, 3),
            "stress": stress.reshape(-1, 6),
            "von_mises": von_mises(stress).astype(np.float32).ravel(),
        },
    )
    _write_mesh(path, mesh)


def _mesh_path(path: Path) -> Path:
    path = _checked_path(path)
    if path.suffix not in (".vtu", ".xdmf"):
        raise InvalidInput(f"path = {path}: the suffix must be .vtu or .xdmf")
    return path


def _write_mesh(path: Path, mesh: Any) -> None:
    import meshio

    with _complete(path) as partial:
        meshio.write(partial, mesh, **({"data_format": "XML"} if path.suffix == ".xdmf" else {}))


@contextmanager
def _complete(path: Path) -> Iterator[Path]:
    """Give a file its name only once it is complete."""
    partial = path.with_name(f".partial-{os.getpid()}-{path.name}")
    try:
        yield partial
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def _checked_path(path: Path) -> Path:
    instance("path", path, (str, os.PathLike), what="the name of a file")
    if "\0" in str(path) or not Path(path).name:
        raise InvalidInput(f"path = {shown(path)}: must be the name of a file")
    path = Path(path)
    if not path.parent.is_dir():
        raise InvalidInput(f"path = {path}: there is no folder {path.parent}; make it first")
    return path


def _check_solution(solution: BlockSolution) -> None:
    from fem_contact.block import BlockSolution

    instance("solution", solution, BlockSolution)


def _unfolded(field: Array) -> Array:
    """Repeat the first row and column of a periodic field behind the last."""
    return np.pad(field, [(0, 1), (0, 1)] + [(0, 0)] * (field.ndim - 2), mode="wrap")


def _grid_points(contact: ContactResult, planes: Array) -> Array:
    """Points of the grid on planes z, the periodic images included, (nx + 1, ny + 1, planes, 3)."""
    (nx, ny), (dx, dy) = contact.shape, contact.spacing
    grid = np.meshgrid(np.arange(nx + 1) * dx, np.arange(ny + 1) * dy, planes, indexing="ij")
    return np.stack(grid, axis=-1)


def _cells(nodes: tuple[int, ...], corners: tuple[tuple[int, int, int], ...], *, step: int) -> Numbers:
    number = np.arange(int(np.prod(nodes))).reshape(nodes)
    nx, ny, nz = (n - 1 for n in nodes)
    columns = [number[i : i + nx : step, j : j + ny : step, k : k + nz : step].ravel() for i, j, k in corners]
    return np.stack(columns, axis=1)


def render_surface(path: Path, solution: ContactResult | BlockSolution) -> None:
    """Draw the deformed surface, coloured by the contact pressure (dark is high), into a picture, off screen.

    The deepest dent is drawn a tenth of the period deep.

    Parameters
    ----------
    path : Path
        File to write, ``.png`` for instance.
    solution : ContactResult or BlockSolution
        Of whichever solver: the contact alone is drawn.
    """
    path = _checked_path(path)
    if not isinstance(solution, ContactResult):
        _check_solution(solution)
    contact = solution if isinstance(solution, ContactResult) else solution.contact
    rise = -(contact.displacement - contact.displacement.min())
    depth = float(np.ptp(rise))
    magnification = 0.1 * max(contact.lengths) / depth if depth > 0 else 1.0
    # Lengths in periods: the drawing library's tolerances are absolute.
    x, y, _ = np.moveaxis(_grid_points(contact, np.zeros(1))[:, :, 0] / max(contact.lengths), -1, 0)
    z = magnification * _unfolded(rise) / max(contact.lengths)
    values = [x, y, z, _unfolded(contact.pressure)]
    if not contact.periodic:  # a patch with free surroundings ends at its last points
        values = [of[:-1, :-1] for of in values]
    *places, pressure = values
    with _drawn(path, tuple(places), "pressure [MPa]", pressure) as plotter:
        plotter.view_vector((-0.6, -1.0, 0.9), viewup=(0, 0, 1))
        plotter.camera.zoom(1.3)


def render_section(
    path: Path, solution: BlockSolution, *, axis: Literal["x", "y"] = "y", position: float | None = None
) -> None:
    """Draw a vertical cut through the von Mises stress into a picture, off screen.

    The stress is found layer by layer, so that blocks too large for memory can be drawn.

    Parameters
    ----------
    path : Path
    solution : BlockSolution
    axis : {"x", "y"}
        Direction that the cut is perpendicular to.
    position : float, optional
        Where the cut lies along it [m]; through the highest pressure by default.

    Raises
    ------
    InvalidInput
        For another axis, or a position outside the period.
    """
    path = _checked_path(path)
    _check_solution(solution)
    choice("axis", axis, ("x", "y"))
    across = 0 if axis == "x" else 1
    width, cells = solution.cell_size, solution.mesh.cells
    if position is None:
        peak = np.unravel_index(int(np.argmax(solution.contact.pressure)), solution.contact.shape)
        position = float(peak[across]) * solution.contact.spacing[across]
    position = finite("position", position)
    if not 0 <= position <= solution.contact.lengths[across]:
        raise InvalidInput(
            f"position = {position!r}: must lie in the period, 0 to {solution.contact.lengths[across]:.6g} m"
        )
    row = min(int(position / width[across]), cells[across] - 1)
    cut = np.empty((cells[1 - across], solution.mesh.nz))
    for index, stress in solution.stress_layers():
        cut[:, index] = np.take(stress.von_mises, row, axis=across)
    unit = max(solution.contact.lengths)
    edges = solution.mesh.edges * solution.cell_size[0]
    along = np.arange(cells[1 - across] + 1) * width[1 - across]
    s, z = np.meshgrid(along / unit, edges / unit, indexing="ij")
    with _drawn(path, (s, np.zeros_like(s), z), "von Mises [MPa]", cut) as plotter:
        plotter.view_xz()


@contextmanager
def _drawn(path: Path, places: tuple[Array, Array, Array], name: str, stress: Array) -> Iterator[Any]:
    """Draw a stress [Pa] at points or in cells, dark where it is high; the picture is taken at the end."""
    import pyvista
    import vtk

    # It complains on the error stream where there is no display.
    vtk.vtkLogger.SetStderrVerbosity(vtk.vtkLogger.VERBOSITY_OFF)
    grid = pyvista.StructuredGrid(*places)
    of_points = stress.shape == places[0].shape
    (grid.point_data if of_points else grid.cell_data)[name] = stress.ravel(order="F") / 1e6
    with closing(pyvista.Plotter(off_screen=True, window_size=(1200, 900))) as plotter:
        plotter.add_mesh(grid, scalars=name, cmap="viridis_r", smooth_shading=of_points)
        yield plotter
        with _complete(path) as partial:
            plotter.screenshot(partial)
