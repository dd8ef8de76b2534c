"""A surface and a block, checked and ready to be solved at any load."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, cached_property
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, Literal, Unpack, get_args

import numpy as np

from fem_contact._checks import bound as bound_of
from fem_contact._checks import choice, doubles, finite, function, instance, room_for, shown, whole, within
from fem_contact._types import Array, Lengths, Mask, Shape
from fem_contact.block.elements import element_for
from fem_contact.block.mesh import BlockMesh, MeshOptions, nodal_pressure, node_weights, plan_mesh
from fem_contact.block.problem import Answer, Problem
from fem_contact.block.reduced.fields import FourierSource
from fem_contact.block.reduced.surface import (
    BlockResponse,
    SurfaceOperator,
    solve_reduced,
    solve_reduced_offset,
    surface_operator,
)
from fem_contact.block.solution import ArraySource, BlockSolution, FieldSource
from fem_contact.complementarity.direct import SLACK
from fem_contact.complementarity.fourier import FourierOperator
from fem_contact.contact import Clock, ContactResult, Status, measure_residuals
from fem_contact.errors import InvalidInput
from fem_contact.settings import available_processors
from fem_contact.solid import Solid
from fem_contact.surface import HeightField

if TYPE_CHECKING:
    from fem_contact.block.full.block import Block

Method = Literal["full", "reduced"]
Modulus = Callable[[Array, Array, Array], Array]

_METHODS = {
    "multigrid": "finite elements, full system: active set, conjugate gradients with geometric multigrid",
    "refined": "finite elements, full system: active set, conjugate gradients with multigrid of the "
    "trilinear cells between the nodes",
    "reduced": "finite elements, reduced exactly to the surface nodes by Fourier transform",
    "apart": "finite elements, nothing to solve: no node touches",
}

#: Peak bytes per unknown of the full system: some nineteen fields; where the modulus varies sideways, nine
#: more for the factors of every column.
_BYTES_PER_UNKNOWN, _BYTES_OF_FACTORS = 158, 80
#: Libraries, and what does not grow with the block.
_BASE_BYTES = 250_000_000
#: Peak bytes per surface node of the reduced system, by order: some 14 arrays, or 4 x 4 tables.
_BYTES_PER_NODE = {1: 120, 2: 400}


#: Largest ratio of mean pressure and Young's modulus, and the reciprocal of the least.
_STIFFEST = 1e60
#: Largest ratio of a cell's Young's modulus and the solid's, and the reciprocal of the least.
_HARDEST = 1e30

#: Reading the records of a package takes milliseconds.
_version = cache(version)

#: Least tolerance: rounding leaves more.
_FINEST = 1e-16
#: Active sets, and steps of the surface iteration, allowed by default.
_SETS, _STEPS = 60, 10_000


def planned_mesh(shape: Shape, lengths: Lengths, *, poisson: float, options: MeshOptions) -> BlockMesh:
    """Plan the mesh that options of the public functions describe."""
    for name, value in options.items():
        if name not in MeshOptions.__annotations__:
            allowed = ", ".join(MeshOptions.__annotations__)
            raise InvalidInput(f"{name} = {shown(value)}: is no option; those of the mesh are {allowed}")
    given: dict[str, Any] = dict(options)
    element = element_for(given.pop("element", None), poisson=poisson)
    return plan_mesh(shape, lengths, element=element, **given)


def needed_bytes(mesh: BlockMesh, method: Method, *, lateral: bool = False) -> int:
    """Estimate the memory of a solve."""
    if method == "full":
        return _BASE_BYTES + (_BYTES_PER_UNKNOWN + lateral * _BYTES_OF_FACTORS) * mesh.unknowns
    return _BYTES_PER_NODE[mesh.element.order] * mesh.shape[0] * mesh.shape[1]


class Session:
    """What all solves of one surface on one block share: the block's grids or its surface's operator."""

    def __init__(
        self,
        surface: HeightField,
        solid: Solid,
        *,
        method: Method = "reduced",
        modulus: Modulus | None = None,
        tolerance: float = 1e-8,
        max_iterations: int | None = None,
        pressure_bound: float | Array | None = None,
        **options: Unpack[MeshOptions],
    ) -> None:
        self.clock = Clock()
        instance("surface", surface, HeightField)
        instance("solid", solid, Solid)
        choice("method", method, get_args(Method))
        tolerance = within("tolerance", tolerance, f"[{_FINEST:g}, 1)")
        if max_iterations is not None:
            whole("max_iterations", max_iterations, least=1, most=10**7)
        mesh = planned_mesh(surface.shape, surface.lengths, poisson=solid.poisson, options=options)
        self.width, self.top = surface.lengths[0] / mesh.cells[0], float(np.max(surface.heights))
        moduli = _cell_moduli(modulus, mesh, self.width)
        lateral = moduli is not None and moduli.shape[:2] != (1, 1)
        if lateral:
            # Columns that differ have no waves of their own: nothing can be eliminated.
            method = "full"
        if method == "full" and solid.poisson == 0.5:
            remedy = "a modulus that varies in depth only" if lateral else "method = 'reduced'"
            raise InvalidInput(
                f"poisson = 0.5: the full system has no finite stiffness there; take {remedy}, or "
                "poisson below 0.5"
            )
        others = ", a larger growth, or method = 'reduced'" if method == "full" else ""
        needed = needed_bytes(mesh, method, lateral=lateral)
        room_for(f"{mesh.unknowns} unknowns", needed=needed, remedy=f"take a coarser grid{others}")
        if pressure_bound is not None:
            pressure_bound = bound_of("pressure_bound", pressure_bound, surface.shape) / solid.young
            pressure_bound = np.array(np.broadcast_to(pressure_bound, surface.shape))
        self.surface, self.solid, self.method = surface, solid, method
        self._latest: Answer | None = None
        self.problem = Problem(
            mesh=mesh,
            heights=(surface.heights - self.top) / self.width,
            poisson=solid.poisson,
            pressure=None,
            offset=None,
            gradient=surface.rms_gradient,
            modulus=moduli,
            tolerance=tolerance,
            steps=max_iterations or (_SETS if method == "full" else _STEPS),
            bound=pressure_bound,
        )

    def at_pressure(
        self, mean_pressure: float, start: Mask | None = None, *, continued: bool = False
    ) -> BlockSolution:
        """Solve at a mean pressure [Pa], from a first set of nodes, or `continued` from the last answer."""
        pressure = mean_pressure / self.solid.young
        if not 1 / _STIFFEST < pressure < _STIFFEST:
            raise InvalidInput(
                f"mean_pressure = {mean_pressure!r}: over Young's modulus it must lie in (1e-60, 1e60), or "
                "its products leave the range of the arithmetic"
            )
        problem = replace(self.problem, pressure=pressure)
        if problem.mean_bound < pressure * (1 - SLACK):
            raise InvalidInput(
                f"pressure_bound with mean {problem.mean_bound * self.solid.young:.6g} Pa: must not be below "
                f"mean_pressure = {mean_pressure:.6g} Pa, or nothing carries the load"
            )
        first: Mask | Answer | None = self._latest if continued else None
        if start is not None:
            shape = self.surface.shape
            if start.shape != shape or start.dtype != np.bool_:
                raise InvalidInput(f"start = {shown(start)}: must be an array of bool of shape {shape}")
            first = start.copy() if start.any() else None
        return self._dressed(self._find(problem, first), target=mean_pressure)

    def at_offset(self, offset: float) -> BlockSolution:
        """Solve at an offset [m]."""
        offset = (finite("offset", offset) - self.top) / self.width
        problem = replace(self.problem, offset=offset)
        if offset >= 0:
            answer = _apart(problem)
        elif self.method == "full":
            answer = self._find(problem, None)
        else:
            answer = solve_reduced_offset(problem, self.response, self.operator)
        return self._dressed(answer, target=None)

    def _find(self, problem: Problem, start: Mask | Answer | None) -> Answer:
        if self.method == "full":
            from fem_contact.block.full.system import solve_full

            answer = solve_full(problem, start, self.shared)
        else:
            answer = solve_reduced(problem, self.response, self.operator, start=start)
        self._latest = answer
        return answer

    @cached_property
    def shared(self) -> Block:
        """What all full solves share: the block with the grids of its multigrid."""
        from fem_contact.block.full.system import prepared

        return prepared(self.problem)

    @cached_property
    def response(self) -> BlockResponse:
        """The reduced block, in cell widths and E."""
        modulus = self.problem.modulus
        return BlockResponse(
            mesh=self.problem.mesh,
            solid=Solid(young=1.0, poisson=self.problem.poisson),
            width=1.0,
            layer_modulus=None if modulus is None else modulus[0, 0],
        )

    @cached_property
    def operator(self) -> FourierOperator | SurfaceOperator:
        """The operator of its surface."""
        return surface_operator(self.response, threads=available_processors())

    def _dressed(self, answer: Answer, *, target: float | None) -> BlockSolution:
        surface, mesh, width = self.surface, self.problem.mesh, self.width
        weights = node_weights(mesh)
        pressure = nodal_pressure(answer.force, mesh) * self.solid.young
        gap = answer.gap * width
        nowhere = np.zeros(surface.shape, dtype=bool)
        contact = ContactResult(
            pressure=pressure,
            gap=gap,
            displacement=answer.displacement * width,
            in_contact=answer.in_contact,
            at_bound=nowhere if answer.at_bound is None else answer.at_bound,
            heights=surface.heights,
            lengths=surface.lengths,
            contact_modulus=self.solid.contact_modulus,
            offset=answer.offset * width + self.top,
            mean_pressure=float(np.mean(pressure if weights is None else pressure * weights)),
            status=answer.status,
            residuals=measure_residuals(
                pressure=pressure,
                gap=gap,
                heights=surface.heights,
                lengths=surface.lengths,
                contact_modulus=self.solid.contact_modulus,
                rms_gradient=surface.rms_gradient,
                target_pressure=target,
                at_bound=answer.at_bound,
                weights=weights,
            ),
            cost=self.clock.cost(
                iterations=answer.iterations,
                fft_pairs=answer.fft_pairs,
                linear_iterations=answer.linear_iterations,
                unknowns=mesh.unknowns,
                peak_bytes=answer.bytes,
            ),
            weights=weights,
            provenance=_provenance(self.problem, width=width, answer=answer),
        )
        self.clock = Clock()
        if answer.field is not None:
            source: FieldSource = ArraySource(field=answer.field * width, order=mesh.element.order)
        else:
            source = FourierSource(
                response=self.response, force=answer.force, width=width, threads=available_processors()
            )
        return BlockSolution(
            contact=contact, solid=self.solid, mesh=mesh, source=source, modulus=self.problem.modulus
        )


def _apart(problem: Problem) -> Answer:
    """Nothing touches."""
    shape, zero = problem.mesh.shape, np.zeros(problem.mesh.shape)
    assert problem.offset is not None
    return Answer(
        force=zero,
        gap=problem.offset - problem.heights,
        displacement=zero,
        in_contact=np.zeros(shape, dtype=bool),
        offset=problem.offset,
        status=Status.CONVERGED,
        iterations=0,
        bytes=3 * zero.nbytes,
        method="apart",
        note="no contact",
        field=np.zeros((*shape, problem.mesh.planes.size, 3)),
    )


def _provenance(problem: Problem, *, width: float, answer: Answer) -> dict[str, str]:
    mesh = problem.mesh
    growth = float(np.max(mesh.layers[:-1] / mesh.layers[1:])) if mesh.nz > 1 else 1.0
    share = "cell area" if mesh.element.order == 1 else "node area (corner : edge : centre = 1 : 2 : 4)"
    return {
        "method": _METHODS[answer.method],
        "element": mesh.element.name,
        "mesh": f"{mesh.cells[0]} x {mesh.cells[1]} x {mesh.nz} cells, {mesh.unknowns} unknowns",
        "layers": f"first {mesh.layers[-1]:.4g} cell widths, growth {growth:.4g}",
        "depth": f"{float(-mesh.planes[0]) * width:.6g} m, clamped",
        "pressure": f"nodal force over {share}; contact area counts the same areas",
        "tolerance": f"{problem.tolerance:.3g} (reached: {answer.note})",
        "scikit-fem": _version("scikit-fem"),
    }


def _cell_moduli(modulus: Modulus | None, mesh: BlockMesh, width: float) -> Array | None:
    """Evaluate the modulus at the cells' centres: (nx, ny, nz), or (1, 1, nz) where only z counts."""
    if modulus is None:
        return None
    function("modulus", modulus)
    (nx, ny), edges = mesh.cells, mesh.edges * width
    x: Array = (np.arange(nx, dtype=float) + 0.5) * width
    y: Array = (np.arange(ny, dtype=float) + 0.5) * (width * mesh.aspect)
    z = 0.5 * (edges[1:] + edges[:-1])
    values = doubles("modulus", modulus(x[:, None, None], y[None, :, None], z[None, None, :]))
    try:
        full = np.broadcast_to(values, (nx, ny, mesh.nz))
    except ValueError as error:
        raise InvalidInput(
            f"modulus: gave an array of shape {values.shape} that does not fit the cells {(nx, ny, mesh.nz)}"
        ) from error
    bad = int(np.count_nonzero(~((full >= 1 / _HARDEST) & (full <= _HARDEST))))
    if bad:
        raise InvalidInput(
            f"modulus: {bad} of {full.size} cells are not positive numbers "
            f"from {1 / _HARDEST:g} to {_HARDEST:g}"
        )
    deep = full[:1, :1]
    return deep.copy() if np.array_equal(full, np.broadcast_to(deep, full.shape)) else full.copy()
