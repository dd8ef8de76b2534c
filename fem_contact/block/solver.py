"""The finite-element block pressed by a rigid rough surface."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray

from fem_contact.block.active_set import ActiveSetSolution, Block, Settings, solve_contact
from fem_contact.block.assembly import assemble, lame
from fem_contact.block.mesh import BlockMesh, plan_mesh
from fem_contact.block.solution import BlockSolution
from fem_contact.contact import ContactResult, Cost, measure_residuals
from fem_contact.errors import InsufficientMemory, InvalidInput
from fem_contact.solid import Solid
from fem_contact.surface import HeightField

__all__ = ["Estimate", "estimate", "solve"]

Array = NDArray[np.float64]

#: Peak bytes per unknown: stiffness, its reduced copy, hierarchy, element matrices while assembling.
_BYTES_PER_UNKNOWN = 4800

#: Below this many cells along an axis no coarser grid looks for the first active set.
_COARSEST = 16

#: A coarser grid only proposes a set.
_COARSE_TOLERANCE = 1e-3

#: Conjugate-gradient steps allowed for one set.
_LINEAR_STEPS = 1000


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """What a solve will take.

    Attributes
    ----------
    unknowns : int
        Displacement components of the block.
    bytes : int
        Memory at the peak.
    layers : int
        Planes of cells.
    """

    unknowns: int
    bytes: int
    layers: int


def estimate(
    shape: tuple[int, int],
    lengths: tuple[float, float] = (1.0, 1.0),
    *,
    depth: float | None = None,
    growth: float = 1.2,
    first_layer: float | None = None,
) -> Estimate:
    """Count the unknowns and the memory of a solve before it starts; arguments as in `solve`.

    Examples
    --------
    >>> estimate((64, 64)).unknowns
    184320
    """
    mesh = plan_mesh(shape, lengths, depth=depth, growth=growth, first_layer=first_layer)
    return Estimate(unknowns=mesh.unknowns, bytes=_BYTES_PER_UNKNOWN * mesh.unknowns, layers=mesh.nz)


def solve(
    surface: HeightField,
    solid: Solid,
    *,
    mean_pressure: float,
    depth: float | None = None,
    growth: float = 1.2,
    first_layer: float | None = None,
    tolerance: float = 1e-8,
    max_iterations: int = 60,
    start: NDArray[np.bool_] | None = None,
) -> BlockSolution:
    """Press a rigid surface into an elastic block at a given mean pressure, without friction.

    The block has the periods of the surface, is clamped at its bottom, and carries one surface node per point
    of the height field. All its unknowns are solved for (method "full"): trilinear hexahedra of scikit-fem, a
    primal-dual active set, conjugate gradients with pyamg's smoothed aggregation.

    Parameters
    ----------
    surface : HeightField
        Heights of the rigid body, positive towards the block.
    solid : Solid
        Poisson ratio below 1/2.
    mean_pressure : float
        p0 [Pa], positive.
    depth : float, optional
        Thickness of the block [m]; the longest period by default.
    growth : float
        Largest ratio of neighbouring layer thicknesses.
    first_layer : float, optional
        Thickness of the layer below the surface [m]; the spacing dx by default.
    tolerance : float
        Bound on the residual of the linear systems over the norm of the contact forces.
    max_iterations : int
        Active sets tried at most.
    start : (nx, ny) array of bool, optional
        First active set, for instance of a neighbouring load. By default a coarser grid is asked.

    Returns
    -------
    BlockSolution
        Its `contact` holds pressure, gap, residuals and status.

    Raises
    ------
    InvalidInput
        For a pressure, tolerance or start that cannot be used, or an incompressible solid.
    InsufficientMemory
        If the estimate exceeds the memory available.
    """
    began, processor = time.perf_counter(), time.process_time()
    if not (np.isfinite(mean_pressure) and mean_pressure > 0):
        raise InvalidInput(f"mean_pressure = {mean_pressure!r}: must be a positive, finite pressure in Pa")
    if not (np.isfinite(tolerance) and 0 < tolerance < 1):
        raise InvalidInput(f"tolerance = {tolerance!r}: must lie in (0, 1)")
    if max_iterations < 1:
        raise InvalidInput(f"max_iterations = {max_iterations!r}: must be at least 1")
    lame(solid.poisson)
    mesh = plan_mesh(surface.shape, surface.lengths, depth=depth, growth=growth, first_layer=first_layer)
    _refuse_beyond_memory(mesh)
    nodes = _checked_start(start, surface.shape)
    highest, dx = float(np.max(surface.heights)), surface.spacing[0]
    task = _Task(
        heights=(surface.heights - highest) / dx,
        mesh=mesh,
        growth=growth,
        poisson=solid.poisson,
        pressure=mean_pressure / solid.young,
        gradient=surface.rms_gradient,
        settings=Settings(
            tolerance=tolerance, max_iterations=max_iterations, max_linear_iterations=_LINEAR_STEPS
        ),
    )
    found = task.find(nodes)
    pressure = found.force * (solid.young / mesh.aspect)
    gap, offset = found.gap * dx, found.offset * dx + highest
    contact = ContactResult(
        pressure=pressure,
        gap=gap,
        displacement=-found.displacement[:, :, -1, 2] * dx,
        in_contact=found.in_contact,
        at_bound=np.zeros(surface.shape, dtype=bool),
        heights=surface.heights,
        lengths=surface.lengths,
        contact_modulus=solid.contact_modulus,
        offset=offset,
        mean_pressure=float(np.mean(pressure)),
        status=found.status,
        residuals=measure_residuals(
            pressure=pressure,
            gap=gap,
            heights=surface.heights,
            lengths=surface.lengths,
            contact_modulus=solid.contact_modulus,
            rms_gradient=surface.rms_gradient,
            target_pressure=mean_pressure,
        ),
        cost=Cost(
            wall_seconds=time.perf_counter() - began,
            cpu_seconds=time.process_time() - processor,
            iterations=found.sets,
            linear_iterations=found.linear_iterations,
            unknowns=mesh.unknowns,
            peak_bytes=found.matrix_bytes,
        ),
        provenance=_provenance(mesh, dx=dx, found=found, tolerance=tolerance),
    )
    field = np.zeros((*surface.shape, mesh.nz + 1, 3))
    field[:, :, 1:] = found.displacement * dx
    return BlockSolution(contact=contact, solid=solid, planes=mesh.planes * dx, field=field)


def _provenance(mesh: BlockMesh, *, dx: float, found: ActiveSetSolution, tolerance: float) -> dict[str, str]:
    depth = float(-mesh.planes[0])
    widest = float(np.max(mesh.layers[:-1] / mesh.layers[1:])) if mesh.nz > 1 else 1.0
    return {
        "method": "finite elements, full system: active set, conjugate gradients with smoothed aggregation",
        "element": "Hex1 (trilinear hexahedron, 2 x 2 x 2 quadrature)",
        "mesh": f"{mesh.shape[0]} x {mesh.shape[1]} x {mesh.nz} cells, {mesh.unknowns} unknowns",
        "layers": f"first {mesh.layers[-1]:.4g} dx, growth {widest:.4g}",
        "depth": f"{depth * dx:.6g} m, clamped",
        "pressure": "nodal force over cell area",
        "tolerance": f"{tolerance:.3g} (linear residual reached {found.linear_residual:.3g})",
        "scikit-fem": version("scikit-fem"),
        "pyamg": version("pyamg"),
    }


def _checked_start(start: NDArray[np.bool_] | None, shape: tuple[int, int]) -> NDArray[np.bool_] | None:
    if start is None:
        return None
    if start.shape != shape or start.dtype != np.bool_:
        raise InvalidInput(
            f"start: must be a boolean array of shape {shape}, not {start.dtype} {start.shape}"
        )
    return start.copy() if start.any() else None


def _refuse_beyond_memory(mesh: BlockMesh) -> None:
    import psutil

    needed, available = _BYTES_PER_UNKNOWN * mesh.unknowns, int(psutil.virtual_memory().available)
    if needed > available:
        raise InsufficientMemory(
            f"{mesh.unknowns} unknowns need about {needed / 2**30:.2g} GiB, "
            f"{available / 2**30:.2g} GiB are available: take a coarser grid or a larger growth"
        )


@dataclass(frozen=True, kw_only=True)
class _Task:
    """One contact problem in units of dx and E; no height is above 0."""

    heights: Array
    mesh: BlockMesh
    growth: float
    poisson: float
    pressure: float
    gradient: float
    settings: Settings

    def find(self, start: NDArray[np.bool_] | None) -> ActiveSetSolution:
        """Assemble and iterate from `start`, from a coarser grid's set, or from the highest points."""
        offset = 0.0
        even = not any(n % 2 for n in self.mesh.shape)
        if start is None and even and min(self.mesh.shape) >= _COARSEST:
            start, offset = self._from_coarser()
        if start is None or not start.any():
            start = self._highest()
        return solve_contact(
            Block(
                matrix=assemble(self.mesh, poisson=self.poisson).free(), mesh=self.mesh, heights=self.heights
            ),
            load=self.pressure * self.heights.size * self.mesh.aspect,
            offset=offset,
            start=start,
            settings=self.settings,
            violation=self._violation,
        )

    def _violation(self, force: Array, gap: Array) -> float:
        nx, ny = self.mesh.shape
        residuals = measure_residuals(
            pressure=force / self.mesh.aspect,
            gap=gap,
            heights=self.heights,
            lengths=(float(nx), ny * self.mesh.aspect),
            contact_modulus=1 / (1 - self.poisson**2),
            rms_gradient=self.gradient,
            target_pressure=self.pressure,
        )
        return residuals.worst

    def _highest(self) -> NDArray[np.bool_]:
        """Take the highest points, about as many as will touch."""
        relative = self.pressure / self.gradient if self.gradient > 0 else 1.0
        share = min(1.0, max(2 * relative, 1 / self.heights.size))
        nodes: NDArray[np.bool_] = self.heights >= np.quantile(self.heights, 1 - share, method="lower")
        return nodes

    def _from_coarser(self) -> tuple[NDArray[np.bool_], float]:
        """First active set and offset from every second point along both axes: one eighth of the unknowns."""
        (nx, ny), aspect = (n // 2 for n in self.mesh.shape), self.mesh.aspect
        lengths, depth = (float(nx), ny * aspect), float(-self.mesh.planes[0]) / 2
        coarse = replace(
            self,
            heights=self.heights[::2, ::2] / 2,
            mesh=plan_mesh((nx, ny), lengths, depth=depth, growth=self.growth),
            settings=replace(self.settings, tolerance=max(_COARSE_TOLERANCE, self.settings.tolerance)),
        )
        found = coarse.find(None)
        offset = 2 * found.offset
        touching = offset - self.heights - _refined(2 * found.displacement[:, :, -1, 2]) < 0
        touching[::2, ::2] |= found.in_contact
        return touching, offset


def _refined(values: Array) -> Array:
    """Bilinear interpolation of a periodic array to twice its points along both axes."""
    nx, ny = values.shape
    fine = np.empty((2 * nx, 2 * ny))
    fine[::2, ::2] = values
    fine[1::2, ::2] = 0.5 * (values + np.roll(values, -1, axis=0))
    fine[:, 1::2] = 0.5 * (fine[:, ::2] + np.roll(fine[:, ::2], -1, axis=1))
    return fine
