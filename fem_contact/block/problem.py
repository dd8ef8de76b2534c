"""One contact problem of the block and its answer: lengths in cell widths, stresses in Young's modulus."""

from dataclasses import dataclass

import numpy as np

from fem_contact._types import Array, Mask
from fem_contact.block.mesh import BlockMesh, nodal_force, nodal_pressure, node_weights
from fem_contact.contact import Residuals, Status, measure_residuals


@dataclass(frozen=True, kw_only=True)
class Answer:
    """Answer of any of the block's methods."""

    # (nx, ny): Downward nodal force on the contact nodes over E times the cell width squared; 0
    # elsewhere.
    force: Array
    # (nx, ny): g, and u into the block, over the cell width.
    gap: Array
    displacement: Array
    in_contact: Mask  # (nx, ny)
    offset: float  # Over the cell width
    status: Status
    iterations: int
    linear_iterations: int = 0
    fft_pairs: float = 0.0
    bytes: int  # Memory of the arrays that were held
    method: str  # {"multigrid", "refined", "reduced", "apart"}
    note: str  # What the solver reached, in words
    # (nx, ny, planes, 3): Displacement of all nodes over the cell width, where it was solved for.
    field: Array | None = None
    at_bound: Mask | None = None  # (nx, ny): Nodes at the pressure bound; None where there is none


@dataclass(frozen=True, kw_only=True)
class Problem:
    """A rigid profile to be pressed into a block."""

    mesh: BlockMesh
    heights: Array  # (nx, ny): Profile over the cell width, nowhere above 0
    poisson: float
    pressure: float | None  # p0 / E, where it is prescribed
    offset: float | None  # Offset over the cell width, where it is prescribed instead
    gradient: float  # h'_rms
    modulus: Array | None  # (nx or 1, ny or 1, nz): Young's modulus of the cells over E
    tolerance: float
    steps: int  # Iterations allowed
    bound: Array | None = None  # (nx, ny): Largest pressure at the surface nodes over E

    @property
    def load(self) -> float | None:
        """Total force over E times the cell width squared, where it is prescribed."""
        if self.pressure is None:
            return None
        return self.pressure * self.mesh.cells[0] * self.mesh.cells[1] * self.mesh.aspect

    @property
    def force_bound(self) -> Array | None:
        """Largest nodal forces over E times the cell width squared."""
        return None if self.bound is None else nodal_force(self.bound, self.mesh)

    @property
    def mean_bound(self) -> float:
        """Largest mean pressure over E that can be carried."""
        if self.bound is None:
            return np.inf
        weights = node_weights(self.mesh)
        return float(np.mean(self.bound if weights is None else self.bound * weights))

    @property
    def lateral(self) -> bool:
        """Whether the material varies sideways."""
        return self.modulus is not None and self.modulus.shape[:2] != (1, 1)

    @property
    def roughness(self) -> float:
        """Length that residuals are measured in: h_rms; p0 L / E* or the approach of a flat surface."""
        rms, (nx, ny) = float(np.std(self.heights)), self.mesh.cells
        if rms > 8 * np.finfo(float).eps * float(np.max(np.abs(self.heights))):
            return rms
        if self.pressure is None:
            return abs(self.offset or 0.0)
        return self.pressure * (1 - self.poisson**2) * max(nx, ny * self.mesh.aspect)

    def residuals(self, force: Array, gap: Array, at_bound: Mask | None = None) -> Residuals:
        """Measure what nodal forces and gaps violate."""
        nx, ny = self.mesh.cells
        return measure_residuals(
            pressure=nodal_pressure(force, self.mesh),
            gap=gap,
            heights=self.heights,
            lengths=(float(nx), ny * self.mesh.aspect),
            contact_modulus=1 / (1 - self.poisson**2),
            rms_gradient=self.gradient,
            target_pressure=self.pressure,
            at_bound=at_bound,
            weights=node_weights(self.mesh),
        )

    def violation(self, force: Array, gap: Array, at_bound: Mask | None) -> float:
        """Largest of what nodal forces and gaps violate, bounds included."""
        worst = self.residuals(force, gap, at_bound).worst
        if self.bound is None or at_bound is None:
            return worst
        beyond = float(np.max(nodal_pressure(force, self.mesh) / self.bound)) - 1
        opening = float(np.max(gap[at_bound], initial=0.0)) / self.roughness
        return float(np.max((worst, beyond, opening)))
