"""Results on disk for other programs: the deformed block as a VTU file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fem_contact.errors import InvalidInput

if TYPE_CHECKING:
    from fem_contact.block import BlockSolution

__all__ = ["write_block"]

Array = NDArray[np.float64]

#: Corners of a hexahedron in VTK's order.
_CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))

#: Nodes of a triquadratic hexahedron in VTK's order: corners, edges, faces, centre; in half cells.
_NODES27 = (
    *((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)),
    *((1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2)),
    *((0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)),
    *((0, 1, 1), (2, 1, 1), (1, 0, 1), (1, 2, 1), (1, 1, 0), (1, 1, 2), (1, 1, 1)),
)


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
    import meshio

    path = Path(path)
    if path.suffix not in (".vtu", ".xdmf"):
        raise InvalidInput(f"path = {path}: the suffix must be .vtu or .xdmf")
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
        points=(_nodes(solution) + deformation * displacement).reshape(-1, 3),
        cells=[(kind, _cells(displacement.shape[:3], corners, step=solution.mesh.element.order))],
        point_data=point_data,
        cell_data={"stress": [stress.tensor.reshape(-1, 6)], "von_mises": [stress.von_mises.ravel()]},
    )
    partial = path.with_name(f".partial-{os.getpid()}-{path.name}")
    try:
        meshio.write(partial, mesh, **({"data_format": "XML"} if path.suffix == ".xdmf" else {}))
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def _unfolded(field: Array) -> Array:
    """Repeat the first row and column of a periodic field behind the last."""
    return np.pad(field, [(0, 1), (0, 1)] + [(0, 0)] * (field.ndim - 2), mode="wrap")


def _nodes(solution: BlockSolution) -> Array:
    (nx, ny), (dx, dy) = solution.contact.shape, solution.contact.spacing
    grid = np.meshgrid(np.arange(nx + 1) * dx, np.arange(ny + 1) * dy, solution.planes, indexing="ij")
    return np.stack(grid, axis=-1)


def _cells(
    nodes: tuple[int, ...], corners: tuple[tuple[int, int, int], ...], *, step: int
) -> NDArray[np.int64]:
    number = np.arange(int(np.prod(nodes))).reshape(nodes)
    nx, ny, nz = (n - 1 for n in nodes)
    columns = [number[i : i + nx : step, j : j + ny : step, k : k + nz : step].ravel() for i, j, k in corners]
    return np.stack(columns, axis=1)
