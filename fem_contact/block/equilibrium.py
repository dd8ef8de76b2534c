"""Whether a displacement field balances the forces on it: an independent check, element by element."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from fem_contact._types import Array, Numbers
from fem_contact.block.mesh import BlockMesh, element_matrices, nodal_force


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """What the element matrices say about a field.

    Attributes
    ----------
    residual : float
        Norm of the nodal forces that nothing balances, over the norm of the contact forces.
    energy : float
        Elastic energy per nominal area, summed over the cells [J/m^2].
    """

    residual: float
    energy: float


def measure_equilibrium(
    layers: Iterable[tuple[int, Array]],
    *,
    mesh: BlockMesh,
    poisson: float,
    pressure: Array,
    modulus: Array | None,
) -> tuple[float, float]:
    """Apply the element matrices to a field, layer by layer from the surface down.

    Displacements are over the cell width, pressure and modulus over E. Nothing of the Fourier reduction
    enters but the field it produced. Returned are residual and energy as in `Equilibrium`, the energy over E
    times the cell width; the incompressible solid, whose element matrices are not finite, is refused.
    """
    matrices, offsets = element_matrices(mesh, poisson, condensed=True)
    applied = nodal_force(pressure, mesh)
    squared, energy = 0.0, 0.0
    # Forces on the upper plane of the layer at hand from what lies above it; on the surface, the contact's.
    above = np.zeros((*mesh.shape, 3))
    above[..., 2] = applied
    for index, nodes in layers:
        stiffness = 1.0 if modulus is None else modulus[:, :, index].reshape(-1, 1)
        forces, stored = _layer_forces(mesh, nodes, matrices[index], offsets=offsets, modulus=stiffness)
        energy += stored
        forces[-1] += above
        squared += float(np.sum(forces[1:] ** 2))
        above = forces[0]
    residual = float(np.sqrt(squared)) / (float(np.linalg.norm(applied)) or 1.0)
    return residual, energy / (mesh.cells[0] * mesh.cells[1] * mesh.aspect)


def _layer_forces(
    mesh: BlockMesh, nodes: Array, matrix: Array, *, offsets: Numbers, modulus: Array | float
) -> tuple[Array, float]:
    """Nodal forces of one layer of cells, and the energy it stores."""
    order, step = mesh.element.order, 2 // mesh.element.order
    places = offsets // step
    local = [np.roll(nodes[c], (-a, -b), axis=(0, 1))[::order, ::order].reshape(-1, 3) for a, b, c in places]
    gathered = np.concatenate(local, axis=1)
    answer = (gathered @ matrix) * modulus
    forces = np.zeros_like(nodes)
    for number, (a, b, c) in enumerate(places):
        part = np.zeros(nodes.shape[1:])
        part[::order, ::order] = answer[:, 3 * number : 3 * number + 3].reshape(*mesh.cells, 3)
        forces[c] += np.roll(part, (a, b), axis=(0, 1))
    return forces, 0.5 * float(np.sum(gathered * answer))
