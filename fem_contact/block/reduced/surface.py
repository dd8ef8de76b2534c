"""The block as its surface nodes see it: the discrete compliance, applied by FFT."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.fft

from fem_contact._checks import instance, positive, samples, shown
from fem_contact._types import Array, Mask, Shape
from fem_contact.block.mesh import BlockMesh, node_weights
from fem_contact.block.problem import Answer, Problem
from fem_contact.block.reduced.column import FoldedLayers, fold, surface_compliance
from fem_contact.complementarity import solve_nested, surely_partial
from fem_contact.complementarity.direct import all_at_bound, touching
from fem_contact.complementarity.fourier import FourierOperator
from fem_contact.contact import Status
from fem_contact.errors import InvalidInput
from fem_contact.response import BondedLayer, checked_waves
from fem_contact.settings import Settings
from fem_contact.solid import Solid

#: Share of the force of a proposed contact node that the others start with.
_SPREAD = 0.01


@dataclass(frozen=True, kw_only=True)
class BlockResponse:
    """The block of one mesh as a response: displacement of its surface nodes from pressures, per wavevector.

    It holds for the grid of that mesh only. Trilinear elements have one kind of surface node and satisfy the
    `Response` protocol; for triquadratic ones `SurfaceOperator` is the response.

    Attributes
    ----------
    width : float
        Width of a cell along x [m].
    layer_modulus : (nz,) array or None
        Young's modulus of each layer over `solid.young`, from the bottom upwards; None where it is 1.
    """

    mesh: BlockMesh
    solid: Solid
    width: float
    layer_modulus: Array | None = None

    def __post_init__(self) -> None:
        instance("mesh", self.mesh, BlockMesh)
        instance("solid", self.solid, Solid)
        positive("width", self.width)
        if self.layer_modulus is not None:
            values = samples("layer_modulus", self.layer_modulus)
            if values.size != self.mesh.nz or not np.all(values > 0):
                raise InvalidInput(
                    f"layer_modulus = {shown(self.layer_modulus)}: must be {self.mesh.nz} positive numbers"
                )

    @property
    def contact_modulus(self) -> float:
        """E* [Pa] of the top layer."""
        top = 1.0 if self.layer_modulus is None else float(self.layer_modulus[-1])
        return self.solid.contact_modulus * top

    @cached_property
    def folded(self) -> FoldedLayers:
        """Folded element matrices of the column."""
        return fold(self.mesh, poisson=self.solid.poisson, modulus=self.layer_modulus)

    def compliance(self, qx: Array, qy: Array) -> Array:
        """Surface displacement over pressure [m/Pa] at wavevectors (qx, qy) [1/m], broadcast together.

        Pressure is nodal force over cell area.

        Raises
        ------
        InvalidInput
            For triquadratic elements, whose response is a matrix over four kinds of nodes.
        """
        if self.folded.types != 1:
            raise InvalidInput(
                f"{self.mesh.element.name}: has four kinds of surface nodes; use SurfaceOperator"
            )
        qx, qy = checked_waves(qx, qy)
        # The response is even in both components: each size of a component is computed once.
        (x, from_x), (y, from_y) = (np.unique(np.abs(q), return_inverse=True) for q in (qx, qy))
        x, y = x * self.width, y * (self.width * self.mesh.aspect)
        if self.mesh.aspect == 1 and np.array_equal(x, y):
            # Square cells do not tell x from y, either.
            upper = np.triu_indices(x.size)
            table = np.empty((x.size, x.size))
            phases = np.stack([x[upper[0]], x[upper[1]]], axis=1)
            table[upper] = table.T[upper] = surface_compliance(self.folded, phases)[:, 0, 0]
        else:
            table = surface_compliance(self.folded, phase_pairs(x, y)).reshape(x.size, y.size)
        return (table * (self.mesh.aspect * self.width / self.solid.young))[from_x, from_y]


def phase_pairs(x: Array, y: Array) -> Array:
    """All pairs (x_i, y_j), one per row."""
    return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)


class SurfaceOperator:
    """Response of the four kinds of surface nodes of triquadratic cells, and its inverse, by real FFTs.

    Forces are in units of the mean node area, force / (dx dy) over E; lengths are in cell widths. Arrays run
    over the surface nodes (nx, ny), which are four interleaved lattices.
    """

    pairs = 1.0

    def __init__(self, response: BlockResponse, *, threads: int = 1) -> None:
        mesh = response.mesh
        self.shape, self.cells, self.threads = mesh.shape, mesh.cells, threads
        x, y = 2 * np.pi * scipy.fft.fftfreq(self.cells[0]), 2 * np.pi * scipy.fft.rfftfreq(self.cells[1])
        half = np.abs(x[: self.cells[0] // 2 + 1])
        mirror = np.minimum(np.arange(x.size), x.size - np.arange(x.size))
        scale = mesh.aspect * response.width / response.solid.young / mesh.element.types
        table = surface_compliance(response.folded, phase_pairs(half, y))
        table = scale * table.reshape(half.size, y.size, 4, 4)
        padded, uniform = table.copy(), table[0, 0]
        # At zero phase, singular for the incompressible solid: from displacements to the forces of zero sum
        # that cause them, up to a constant.
        padded[0, 0] = np.eye(4)
        inverse: Array = np.linalg.inv(padded).astype(float)
        basis = np.linalg.svd(np.ones((1, 4)))[2][1:].T
        inverse[0, 0] = basis @ np.linalg.solve(basis.T @ uniform @ basis, basis.T)
        self.compliance = np.moveaxis(table, (2, 3), (0, 1))[:, :, mirror].copy()
        self.inverse = np.moveaxis(inverse, (2, 3), (0, 1))[:, :, mirror].copy()
        self.stiffness = float(np.mean(np.trace(self.inverse)) / 4)
        # Positions differ by half a cell between the lattices; the tables refer to one origin.
        self.turns = np.stack([np.exp(0.5j * (x[:, None] * a + y * b)) for a, b in np.ndindex(2, 2)])

    @property
    def nbytes(self) -> int:
        """Memory of the arrays held, and of the spectra that come and go."""
        return self.compliance.nbytes + self.inverse.nbytes + 3 * self.turns.nbytes

    def apply(self, force: Array, out: Array) -> None:
        """Write the displacement under ``force`` into ``out``."""
        self._transform(force, out, self.compliance)

    def precondition(self, residual: Array, out: Array) -> None:
        """Write the full-contact force under a displacement, without its mean, into ``out``."""
        self._transform(residual, out, self.inverse)

    #: The inverse is exact.
    invert = precondition

    def _transform(self, values: Array, out: Array, table: Array) -> None:
        lattices = [(slice(a, None, 2), slice(b, None, 2)) for a, b in np.ndindex(2, 2)]
        waves = np.stack([scipy.fft.rfft2(values[lattice], workers=self.threads) for lattice in lattices])
        waves /= self.turns
        answer = np.einsum("abxy,bxy->axy", table, waves)
        answer *= self.turns
        for lattice, wave in zip(lattices, answer, strict=True):
            out[lattice] = scipy.fft.irfft2(wave, s=self.cells, workers=self.threads)


def surface_operator(response: BlockResponse, *, threads: int = 1) -> FourierOperator | SurfaceOperator:
    """Return the operator of the block's surface nodes: forces in units of the mean node area."""
    mesh = response.mesh
    if mesh.element.order == 2:
        return SurfaceOperator(response, threads=threads)
    lengths = mesh.cells[0] * response.width, mesh.cells[1] * response.width * mesh.aspect
    return FourierOperator(response, mesh.shape, lengths, threads=threads)


def solve_reduced(
    problem: Problem,
    response: BlockResponse,
    operator: FourierOperator | SurfaceOperator,
    *,
    start: Mask | Answer | None,
) -> Answer:
    """Solve the contact of the surface nodes at a mean pressure."""
    mesh, threads = problem.mesh, operator.threads
    assert problem.pressure is not None
    if isinstance(start, Answer):
        first: Array | None = start.force
    else:
        # Some force everywhere: one loaded node alone leaves no direction to search.
        first = None if start is None else np.where(start, 1.0, _SPREAD)
    weights, bound, heights, gap = node_weights(mesh), problem.bound, problem.heights, None
    share = 1.0 if weights is None else weights
    known: dict[str, Any] = {"bound": None if bound is None else bound * share}
    lengths = float(mesh.cells[0]), mesh.cells[1] * mesh.aspect
    # Coarser grids only lead to a first guess, for which the homogeneous layer is near enough.
    layer = BondedLayer(solid=response.solid, thickness=float(-mesh.planes[0]))

    def coarse(shape: Shape) -> FourierOperator:
        return FourierOperator(layer, shape, lengths, threads=threads)

    solution = all_at_bound(operator, heights, mean_force=problem.pressure, **known)
    if solution is None and not surely_partial(heights, coarse=coarse, mean_force=problem.pressure):
        rough = np.empty(mesh.shape)
        operator.invert(heights, rough)
        uniform = (problem.pressure - rough.mean()) * share
        solution = touching(operator, heights, rough, uniform, pairs=3 * operator.pairs, **known)
        if solution is not None:
            # The uniform compression may be many times larger, and no gap be read off the sum of both.
            gap = np.empty(mesh.shape)
            operator.apply(rough, gap)
            gap -= heights
            gap -= gap.mean()
    exact = solution is not None
    if solution is None:
        solution = solve_nested(
            operator,
            heights,
            coarse=coarse,
            mean_force=problem.pressure,
            length_scale=problem.roughness,
            settings=Settings(tolerance=problem.tolerance, max_iterations=problem.steps, threads=threads),
            start=first,
            weights=weights,
            **known,
        )
    force = solution.force * (mesh.aspect / mesh.element.types)
    gap = solution.displacement - heights + solution.offset if gap is None else gap
    at_bound, status = None if bound is None else solution.at_bound, solution.status
    if exact and not problem.violation(force, gap, at_bound) <= problem.tolerance:
        # Rounding left no answer; a NaN is not below the tolerance.
        status = Status.STAGNATED
    return Answer(
        force=force,
        gap=gap,
        displacement=solution.displacement,
        in_contact=solution.in_contact,
        offset=solution.offset,
        status=status,
        iterations=solution.iterations,
        fft_pairs=solution.fft_pairs,
        bytes=max(solution.peak_bytes + operator.nbytes, 4 * solution.force.nbytes + operator.nbytes),
        method="reduced",
        note=f"{solution.iterations} iterations",
        at_bound=at_bound,
    )


def solve_reduced_offset(
    problem: Problem, response: BlockResponse, operator: FourierOperator | SurfaceOperator
) -> Answer:
    """Seek the mean pressure that belongs to a prescribed offset; the offset falls as the load rises."""
    from scipy.optimize import brentq

    assert problem.offset is not None
    target, answer = problem.offset, None
    # Of a rigid profile driven in by its full height the block would bear less than this.
    high = 2 * -target / (1 - problem.poisson**2) / min(-float(problem.mesh.planes[0]), 1.0)
    tight = replace(problem, tolerance=min(problem.tolerance, 1e-10), offset=None)

    def excess(logarithm: float) -> float:
        nonlocal answer
        pressure = high * math.exp(logarithm)
        answer = solve_reduced(replace(tight, pressure=pressure), response, operator, start=answer)
        return answer.offset - target

    low, top = -1.0, 0.0
    while excess(top) > 0:
        low, top = top, top + 3.0
    while excess(low) < 0:
        low, top = 2 * low - 1.0, low
    root = brentq(excess, low, top, xtol=1e-14, rtol=4 * np.finfo(float).eps)
    excess(root)
    assert answer is not None
    return answer
