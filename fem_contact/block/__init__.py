"""The finite-element block: an elastic slab of hexahedra, pressed by a rigid rough surface."""

from fem_contact.block.accuracy import WaveError, wave_errors
from fem_contact.block.elements import ELEMENTS, Element
from fem_contact.block.equilibrium import Equilibrium
from fem_contact.block.full.assembled import assembled_field
from fem_contact.block.hyperelastic.solver import FiniteStrain, solve_finite_strain, solve_slopes
from fem_contact.block.mesh import BlockMesh, MeshOptions, graded_layers, plan_mesh
from fem_contact.block.reduced.surface import BlockResponse
from fem_contact.block.solution import BlockSolution, CellStress
from fem_contact.block.solver import Estimate, estimate, solve, solve_displacement, solve_path

__all__ = [
    "ELEMENTS",
    "BlockMesh",
    "BlockResponse",
    "BlockSolution",
    "CellStress",
    "Element",
    "Equilibrium",
    "Estimate",
    "FiniteStrain",
    "MeshOptions",
    "WaveError",
    "assembled_field",
    "estimate",
    "graded_layers",
    "plan_mesh",
    "solve",
    "solve_displacement",
    "solve_finite_strain",
    "solve_path",
    "solve_slopes",
    "wave_errors",
]
