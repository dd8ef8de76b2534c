"""The finite-element block pressed by a rigid rough surface."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from typing import Literal, Unpack

import numpy as np
from numpy.typing import NDArray

from fem_contact.block.elements import element_for
from fem_contact.block.fields import ArraySource, FieldSource, FourierSource
from fem_contact.block.mesh import BlockMesh, MeshOptions, nodal_pressure, node_weights, plan_mesh
from fem_contact.block.problem import Found, Problem
from fem_contact.block.solution import BlockSolution
from fem_contact.contact import ContactResult, Cost, measure_residuals
from fem_contact.errors import InsufficientMemory, InvalidInput
from fem_contact.solid import Solid
from fem_contact.surface import HeightField

__all__ = ["Estimate", "estimate", "solve"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Method = Literal["full", "reduced"]

_METHODS = {
    "full": "finite elements, full system: active set, conjugate gradients with smoothed aggregation",
    "reduced": "finite elements, reduced exactly to the surface nodes by Fourier transform",
    "heterogeneous": "finite elements, all unknowns: active set, matrix-free conjugate gradients, "
    "preconditioned by Fourier solves of a layered block",
}

#: Peak bytes per unknown of the full system, by order: stiffness, its reduced copy, hierarchy, assembly.
_BYTES_PER_UNKNOWN = {1: 4800, 2: 14000}

#: Peak bytes per surface node of the reduced system, by order: some 14 arrays, or 4 x 4 tables.
_BYTES_PER_NODE = {1: 120, 2: 400}


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """What a solve will take.

    Attributes
    ----------
    unknowns : int
        Displacement components of the block.
    bytes : int
        Memory at the peak, without the field inside.
    layers : int
        Layers of cells.
    """

    unknowns: int
    bytes: int
    layers: int


def estimate(
    shape: tuple[int, int],
    lengths: tuple[float, float] = (1.0, 1.0),
    *,
    method: Method = "reduced",
    poisson: float = 0.3,
    **mesh: Unpack[MeshOptions],
) -> Estimate:
    """Count the unknowns and the memory of a solve before it starts; arguments as in `solve`.

    Examples
    --------
    >>> estimate((64, 64)).unknowns
    184320
    """
    planned = _planned(shape, lengths, poisson=poisson, options=mesh)
    return Estimate(unknowns=planned.unknowns, bytes=_needed(planned, method), layers=planned.nz)


def _planned(
    shape: tuple[int, int], lengths: tuple[float, float], *, poisson: float, options: MeshOptions
) -> BlockMesh:
    return plan_mesh(
        shape,
        lengths,
        depth=options.get("depth"),
        growth=options.get("growth", 1.2),
        first_layer=options.get("first_layer"),
        element=element_for(options.get("element"), poisson=poisson),
    )


def _needed(mesh: BlockMesh, method: Method) -> int:
    order = mesh.element.order
    if method == "full":
        return _BYTES_PER_UNKNOWN[order] * mesh.unknowns
    return _BYTES_PER_NODE[order] * mesh.shape[0] * mesh.shape[1]


def solve(
    surface: HeightField,
    solid: Solid,
    *,
    mean_pressure: float,
    method: Method = "reduced",
    modulus: Callable[[Array, Array, Array], Array] | None = None,
    tolerance: float = 1e-8,
    max_iterations: int | None = None,
    start: Mask | None = None,
    **mesh: Unpack[MeshOptions],
) -> BlockSolution:
    """Press a rigid surface into an elastic block at a given mean pressure, without friction.

    The block has the periods of the surface, is clamped at its bottom, and carries one surface node per point
    of the height field.

    Parameters
    ----------
    surface : HeightField
        Heights of the rigid body, positive towards the block.
    solid : Solid
    mean_pressure : float
        p0 [Pa], positive.
    method : {"reduced", "full"}
        "full" solves for all unknowns of the assembled block: an active set, conjugate gradients with pyamg's
        smoothed aggregation. "reduced" eliminates the inside exactly, wavevector by wavevector, and solves
        for the surface by FFT: the same discrete solution at a small part of the cost.
    modulus : callable, optional
        Young's modulus of the block over `solid.young`, evaluated at the cells' centres x (nx, 1, 1), y (1,
        ny, 1), z (1, 1, nz) [m]. Where it varies sideways, the reduced method keeps the whole block, with a
        layered one as preconditioner.
    tolerance : float
        "full": bound on the linear residual over the norm of the contact forces. "reduced": bound on the
        complementarity over h_rms.
    max_iterations : int, optional
        Active sets (60 by default) or steps of the surface iteration (10 000).
    start : (nx, ny) array of bool, optional
        First contact set, for instance of a neighbouring load.
    depth, growth, first_layer : float, optional
        Thickness of the block [m], the longest period by default; largest ratio of neighbouring layers (1.2);
        thickness of the layer below the surface [m], the cell width by default.
    element : {"Hex1", "Hex1/P0", "Hex2", "Hex2/P1disc"}, optional
        By default the cheapest that does not lock at this Poisson ratio.

    Returns
    -------
    BlockSolution
        Its `contact` holds pressure, gap, residuals and status.

    Raises
    ------
    InvalidInput
        For arguments that cannot be used, or an element or method that cannot represent the solid.
    InsufficientMemory
        If the estimate exceeds the memory available.
    """
    began = time.perf_counter(), time.process_time()
    steps = max_iterations if max_iterations is not None else 60 if method == "full" else 10_000
    _check(mean_pressure=mean_pressure, method=method, tolerance=tolerance, steps=steps)
    planned = _planned(surface.shape, surface.lengths, poisson=solid.poisson, options=mesh)
    _refuse_beyond_memory(planned, method)
    width, top = surface.lengths[0] / planned.cells[0], float(np.max(surface.heights))
    problem = Problem(
        mesh=planned,
        heights=(surface.heights - top) / width,
        poisson=solid.poisson,
        pressure=mean_pressure / solid.young,
        gradient=surface.rms_gradient,
        modulus=_cell_moduli(modulus, planned, width),
        tolerance=tolerance,
        steps=steps,
        growth=mesh.get("growth", 1.2),
    )
    nodes = _checked_start(start, surface.shape)
    found, source = _found(problem, method=method, start=nodes, width=width)
    scale = _Scale(width=width, top=top, pressure=mean_pressure)
    seconds = time.perf_counter() - began[0], time.process_time() - began[1]
    contact = _result(surface, solid, problem=problem, found=found, scale=scale, seconds=seconds)
    return BlockSolution(contact=contact, solid=solid, mesh=planned, source=source, modulus=problem.modulus)


def _found(
    problem: Problem, *, method: Method, start: Mask | None, width: float
) -> tuple[Found, FieldSource]:
    if method == "full":
        from fem_contact.block.full import solve_full

        found = solve_full(problem, start)
        assert found.field is not None
        return found, ArraySource(field=found.field * width, order=problem.mesh.element.order)
    if problem.lateral:
        from fem_contact.block.heterogeneous import solve_heterogeneous

        found = solve_heterogeneous(problem, start)
        assert found.field is not None
        return found, ArraySource(field=found.field * width)
    from fem_contact.block.reduced import BlockResponse, solve_reduced

    unit = Solid(young=1.0, poisson=problem.poisson)
    layers = None if problem.modulus is None else problem.modulus[0, 0]
    response = BlockResponse(mesh=problem.mesh, solid=unit, width=1.0, layer_modulus=layers)
    found = solve_reduced(problem, response, start)
    return found, FourierSource(response=response, force=found.force, width=width)


@dataclass(frozen=True, kw_only=True)
class _Scale:
    """What turns a dimensionless answer into metres and pascals."""

    width: float
    top: float
    pressure: float


def _result(
    surface: HeightField,
    solid: Solid,
    *,
    problem: Problem,
    found: Found,
    scale: _Scale,
    seconds: tuple[float, float],
) -> ContactResult:
    weights = node_weights(problem.mesh)
    pressure = nodal_pressure(found.force, problem.mesh) * solid.young
    gap = found.gap * scale.width
    return ContactResult(
        pressure=pressure,
        gap=gap,
        displacement=found.displacement * scale.width,
        in_contact=found.in_contact,
        at_bound=np.zeros(surface.shape, dtype=bool),
        heights=surface.heights,
        lengths=surface.lengths,
        contact_modulus=solid.contact_modulus,
        offset=found.offset * scale.width + scale.top,
        mean_pressure=float(np.mean(pressure if weights is None else pressure * weights)),
        status=found.status,
        residuals=measure_residuals(
            pressure=pressure,
            gap=gap,
            heights=surface.heights,
            lengths=surface.lengths,
            contact_modulus=solid.contact_modulus,
            rms_gradient=surface.rms_gradient,
            target_pressure=scale.pressure,
            weights=weights,
        ),
        cost=Cost(
            wall_seconds=seconds[0],
            cpu_seconds=seconds[1],
            iterations=found.iterations,
            fft_pairs=found.fft_pairs,
            linear_iterations=found.linear_iterations,
            unknowns=problem.mesh.unknowns,
            peak_bytes=found.bytes,
        ),
        weights=weights,
        provenance=_provenance(problem, width=scale.width, found=found),
    )


def _provenance(problem: Problem, *, width: float, found: Found) -> dict[str, str]:
    mesh = problem.mesh
    widest = float(np.max(mesh.layers[:-1] / mesh.layers[1:])) if mesh.nz > 1 else 1.0
    share = "cell area" if mesh.element.order == 1 else "node area (corner : edge : centre = 1 : 2 : 4)"
    text = {
        "method": _METHODS[found.method],
        "element": mesh.element.name,
        "mesh": f"{mesh.cells[0]} x {mesh.cells[1]} x {mesh.nz} cells, {mesh.unknowns} unknowns",
        "layers": f"first {mesh.layers[-1]:.4g} cell widths, growth {widest:.4g}",
        "depth": f"{float(-mesh.planes[0]) * width:.6g} m, clamped",
        "pressure": f"nodal force over {share}; contact area counts the same areas",
        "tolerance": f"{problem.tolerance:.3g} (reached: {found.note})",
        "scikit-fem": version("scikit-fem"),
    }
    if found.method == "full":
        text["pyamg"] = version("pyamg")
    return text


def _check(*, mean_pressure: float, method: str, tolerance: float, steps: int) -> None:
    if not (np.isfinite(mean_pressure) and mean_pressure > 0):
        raise InvalidInput(f"mean_pressure = {mean_pressure!r}: must be a positive, finite pressure in Pa")
    if method not in ("full", "reduced"):
        raise InvalidInput(f"method = {method!r}: must be 'full' or 'reduced'")
    if not (np.isfinite(tolerance) and 0 < tolerance < 1):
        raise InvalidInput(f"tolerance = {tolerance!r}: must lie in (0, 1)")
    if steps < 1:
        raise InvalidInput(f"max_iterations = {steps!r}: must be at least 1")


def _cell_moduli(
    modulus: Callable[[Array, Array, Array], Array] | None, mesh: BlockMesh, width: float
) -> Array | None:
    """Evaluate the modulus at the cells' centres: (nx, ny, nz), or (1, 1, nz) where only z counts."""
    if modulus is None:
        return None
    (nx, ny), edges = mesh.cells, mesh.edges * width
    x = np.asarray((np.arange(nx) + 0.5) * width, dtype=float)[:, None, None]
    y = np.asarray((np.arange(ny) + 0.5) * (width * mesh.aspect), dtype=float)[None, :, None]
    z: Array = np.asarray(0.5 * (edges[1:] + edges[:-1]), dtype=float)[None, None, :]
    values: Array = np.asarray(modulus(x, y, z), dtype=float)
    try:
        full = np.broadcast_to(values, (nx, ny, mesh.nz))
    except ValueError as error:
        raise InvalidInput(
            f"modulus: gave an array of shape {values.shape} that does not fit the cells {(nx, ny, mesh.nz)}"
        ) from error
    bad = int(np.count_nonzero(~(np.isfinite(full) & (full > 0))))
    if bad:
        raise InvalidInput(f"modulus: {bad} of {full.size} cells are not positive and finite")
    deep = full[:1, :1]
    return deep.copy() if np.array_equal(full, np.broadcast_to(deep, full.shape)) else full.copy()


def _checked_start(start: Mask | None, shape: tuple[int, int]) -> Mask | None:
    if start is None:
        return None
    if start.shape != shape or start.dtype != np.bool_:
        raise InvalidInput(
            f"start: must be a boolean array of shape {shape}, not {start.dtype} {start.shape}"
        )
    return start.copy() if start.any() else None


def _refuse_beyond_memory(mesh: BlockMesh, method: Method) -> None:
    import psutil

    needed, available = _needed(mesh, method), int(psutil.virtual_memory().available)
    if needed > available:
        raise InsufficientMemory(
            f"{mesh.unknowns} unknowns need about {needed / 2**30:.2g} GiB, "
            f"{available / 2**30:.2g} GiB are available: take a coarser grid"
            + (", a larger growth, or method = 'reduced'" if method == "full" else "")
        )
