"""The finite-element block: an elastic slab of hexahedra, pressed by a rigid rough surface."""

from fem_contact.block.mesh import BlockMesh, graded_layers, plan_mesh
from fem_contact.block.solution import BlockSolution, CellStress
from fem_contact.block.solver import Estimate, estimate, solve

__all__ = [
    "BlockMesh",
    "BlockSolution",
    "CellStress",
    "Estimate",
    "estimate",
    "graded_layers",
    "plan_mesh",
    "solve",
]
