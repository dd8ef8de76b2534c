"""The finite-element block pressed by a rigid rough surface: what users call."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Unpack, get_args

import numpy as np

from fem_contact._checks import choice, instance, poisson_ratio, positive, positives
from fem_contact._types import Array, Lengths, Mask, Shape
from fem_contact.block.mesh import MeshOptions
from fem_contact.block.session import Method, Modulus, Session, needed_bytes, planned_mesh
from fem_contact.block.solution import BlockSolution
from fem_contact.solid import Solid
from fem_contact.surface import HeightField


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
    shape: Shape,
    lengths: Lengths = (1.0, 1.0),
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
    choice("method", method, get_args(Method))
    poisson = poisson_ratio(poisson)
    planned = planned_mesh(shape, lengths, poisson=poisson, options=mesh)
    return Estimate(unknowns=planned.unknowns, bytes=needed_bytes(planned, method), layers=planned.nz)


class Options(MeshOptions, total=False):
    """Options of `solve` that `solve_displacement` and `solve_path` have, too."""

    method: Method
    modulus: Modulus | None
    tolerance: float
    max_iterations: int | None


def solve(
    surface: HeightField,
    solid: Solid,
    *,
    mean_pressure: float,
    method: Method = "reduced",
    modulus: Modulus | None = None,
    pressure_bound: float | Array | None = None,
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
        "full" solves for all unknowns of the block: an active set, conjugate gradients with geometric
        multigrid and no matrix. "reduced" eliminates the inside exactly, wavevector by wavevector, and solves
        for the surface by FFT: the same discrete solution at a small part of the cost.
    modulus : callable, optional
        Young's modulus of the block over `solid.young`, evaluated at the cells' centres x (nx, 1, 1), y (1,
        ny, 1), z (1, 1, nz) [m]. Where it varies sideways, nothing can be eliminated and either method is
        "full".
    pressure_bound : float or (nx, ny) array, optional
        Hardness H [Pa]: the pressure obeys 0 <= p <= H, and where p = H the gap may be negative, which is
        plastic indentation (`fem_contact.hardness.yielded` reads it). Its mean must not be below
        `mean_pressure`.
    tolerance : float
        "full": bound on the linear residual over the norm of the contact forces. "reduced": bound on the
        complementarity over h_rms.
    max_iterations : int, optional
        Active sets (60 by default) or steps of the surface iteration (10 000).
    start : (nx, ny) array of bool, optional
        First contact set, for instance of a neighbouring load.
    depth, growth, first_layer : float, optional
        Thickness of the block [m], the longest period by default; largest ratio of neighbouring layers (1.2);
        thickness of the layer below the surface [m], the longer side of a cell by default.
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
    mean_pressure = positive("mean_pressure", mean_pressure)
    if start is not None:
        instance("start", start, np.ndarray, what="an array of bool with the surface's shape")
    session = Session(
        surface,
        solid,
        method=method,
        modulus=modulus,
        tolerance=tolerance,
        max_iterations=max_iterations,
        pressure_bound=pressure_bound,
        **mesh,
    )
    return session.at_pressure(mean_pressure, start)


def solve_displacement(
    surface: HeightField, solid: Solid, *, offset: float, **options: Unpack[Options]
) -> BlockSolution:
    """Press a rigid surface into an elastic block to a given approach.

    Parameters
    ----------
    offset : float
        Distance of the mean planes before deformation, -approach [m]. Without contact the answer is zero
        pressure.
    surface, solid, method, modulus, tolerance, max_iterations, **mesh
        As in `solve`.

    Raises
    ------
    InvalidInput, InsufficientMemory
        As in `solve`.
    """
    return Session(surface, solid, **options).at_offset(offset)


def solve_path(
    surface: HeightField, solid: Solid, *, mean_pressures: Iterable[float], **options: Unpack[Options]
) -> Iterator[BlockSolution]:
    """Solve a sequence of loads, up or down, each started from the one before; assembly is shared.

    Parameters
    ----------
    mean_pressures : iterable of float
        Nominal pressures [Pa]. The problem is elastic, so an answer does not depend on the path.
    surface, solid, method, modulus, tolerance, max_iterations, **mesh
        As in `solve`.

    Yields
    ------
    BlockSolution
        One per load, as soon as it is found.
    """
    loads = positives("mean_pressures", mean_pressures)
    session = Session(surface, solid, **options)
    return (session.at_pressure(load, continued=True) for load in loads)
