"""Flow of a thin fluid film through the gap: percolation, and the conductance of a seal."""

from bisect import bisect
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fem_contact._checks import array, choice, mask
from fem_contact._types import Array, Lengths, Mask
from fem_contact.contact import ContactResult, check_result
from fem_contact.errors import InvalidInput, NotConverged
from fem_contact.patches import find_patches
from fem_contact.surface.heights import checked_lengths

Axis = Literal["x", "y"]

#: By how much the flux through the cross-sections may differ, relative to the flux.
_BALANCE = 1e-10
#: Times that the direct solve is applied to what is left over; each gains some ten digits.
_MOST_TERMS = 8


@dataclass(frozen=True, kw_only=True, eq=False)
class GapFlow:
    """Flow through the gap under a mean pressure gradient of one, periodic in both directions.

    Attributes
    ----------
    conductance : float
        K [m^3]: flux per width = -(K / viscosity) dP/dx. A gap of constant width w has w^3 / 12.
    closed : bool
        No connected path leads through the period: K is 0 exactly.
    pressure : (nx, ny) array
        Fluid pressure beside the mean gradient [m, per unit gradient]; NaN where no fluid flows.
    balance : float
        Largest deviation of the flux through a cross-section from the mean, relative to it.
    """

    conductance: float
    closed: bool
    pressure: Array
    balance: float


def open_gap(result: ContactResult) -> Array:
    """Gap [m] that a fluid finds: exactly 0 at the contact points, where a solver leaves its last digits."""
    check_result("result", result)
    return np.where(result.in_contact, 0.0, np.maximum(result.gap, 0.0))


def percolates(open_cells: Mask, axis: Axis) -> bool:
    """Whether a 4-connected path of open cells winds around the period along an axis.

    Examples
    --------
    >>> channel = np.zeros((4, 4), dtype=bool)
    >>> channel[:, 1] = True
    >>> percolates(channel, "x"), percolates(channel, "y")
    (True, False)
    """
    mask("open_cells", open_cells)
    return bool(_winding(open_cells, axis).any())


def _winding(open_cells: Mask, axis: Axis) -> Mask:
    """Return the open cells of the clusters that wind around the period along an axis."""
    choice("axis", axis, ("x", "y"))
    labels = find_patches(open_cells, (1.0, 1.0)).labels
    cells = labels if axis == "x" else labels.T
    # No other can wind than those with cells in every row.
    spanning = np.unique(cells[0])
    for row in cells[1:]:
        spanning = np.intersect1d(spanning, row)
    return np.isin(labels, [label for label in spanning if label > 0 and _winds(cells == label)])


def _winds(cluster: Mask) -> bool:
    """Whether one cluster, connected over the period, winds along the first axis."""
    import scipy.ndimage
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order

    pieces, count = scipy.ndimage.label(cluster)
    # Each seam between pieces is an edge that says by how many periods its end lies further along x.
    along = np.stack([pieces[-1], pieces[0]])
    across = np.stack([pieces[:, -1], pieces[:, 0]])
    along, across = (seam[:, (seam > 0).all(axis=0)] - 1 for seam in (along, across))
    start, end = np.concatenate([along, across], axis=1)
    shift = np.concatenate([np.ones(along.shape[1]), np.zeros(across.shape[1])])
    graph = coo_array((np.ones(start.size), (start, end)), shape=(count, count)).tocsr()
    order, before = breadth_first_order(graph, 0, directed=False)
    steps: dict[tuple[int, int], float] = {}
    for one, other, far in zip(start.tolist(), end.tolist(), shift.tolist(), strict=True):
        steps.setdefault((one, other), far)
        steps.setdefault((other, one), -far)
    place = np.zeros(count)
    for piece in order[1:].tolist():
        place[piece] = place[before[piece]] + steps[int(before[piece]), piece]
    # Placed along a tree, an edge that does not fit closes a loop around the period.
    return bool(np.any(place[start] + shift != place[end]))


def critical_gap(gap: ArrayLike, axis: Axis) -> float:
    """Widest gap u [m] such that the cells with a gap of at least u still percolate along an axis.

    It is the narrowest place of the widest path, 0 where none leads through.

    Examples
    --------
    >>> gap = np.full((4, 4), 2.0)
    >>> gap[1] = [0.0, 0.5, 0.0, 0.2]
    >>> critical_gap(gap, "x"), critical_gap(gap, "y")
    (0.5, 2.0)
    """
    values = _checked_gap(gap)
    levels = np.unique(values[values > 0])
    closed = bisect(levels, False, key=lambda level: not percolates(values >= level, axis))
    return float(levels[closed - 1]) if closed else 0.0


def flow_conductance(gap: ArrayLike, lengths: Lengths, *, axis: Axis = "x") -> GapFlow:
    r"""Conductance of the gap for a thin viscous film, by Reynolds' equation.

    .. math:: \nabla\cdot\bigl(u^3 \nabla P\bigr) = 0, \qquad
              K = \frac{1}{12}\,\frac{\overline{u^3\, \partial_x P}}{\overline{\partial_x P}}

    Finite volumes, one cell a grid point, with the harmonic mean of u^3 between neighbours; cells whose gap
    is 0 hold no fluid. The cells that percolate are solved for by a sparse direct method: iterations on
    coefficients that vary by many decades stop early with a wrong flux.

    Parameters
    ----------
    gap : (nx, ny) array
        u [m]; 0 or less in contact, as `open_gap` makes it of a result.
    lengths : tuple of float
        Periods (Lx, Ly) [m].
    axis : {"x", "y"}
        Direction of the mean gradient.

    Raises
    ------
    InvalidInput
        For a gap or periods that are none.
    NotConverged
        Where the flux through the cross-sections differs by more than 1e-10 of it: the gap varies by more
        decades than double precision resolves.

    Notes
    -----
    O. Reynolds (1886); seals: W. B. Dapp, A. Luecke, B. N. J. Persson and M. H. Mueser, Phys. Rev. Lett. 108,
    244301 (2012).

    Examples
    --------
    >>> flow_conductance(np.full((6, 4), 2.0), (1.0, 1.0)).conductance * 12
    8.0
    """
    choice("axis", axis, ("x", "y"))
    values = _checked_gap(gap)
    sizes = checked_lengths(lengths)
    if axis == "y":
        turned = flow_conductance(values.T, (sizes[1], sizes[0]))
        return replace(turned, pressure=turned.pressure.T)
    open_cells = _winding(values > 0, "x")
    if not open_cells.any():
        nowhere = np.full(values.shape, np.nan)
        return GapFlow(conductance=0.0, closed=True, pressure=nowhere, balance=0.0)
    return _flow(values, open_cells, spacing=(sizes[0] / values.shape[0], sizes[1] / values.shape[1]))


def _flow(gap: Array, open_cells: Mask, *, spacing: Lengths) -> GapFlow:
    """Solve for the pressure beside a mean gradient of one along x on the cells that are open."""
    dx, dy = spacing
    widest = float(gap[open_cells].max())
    cubed = np.where(open_cells, gap / widest, 0.0) ** 3
    along, across = _between(cubed, 0) * (dy / dx), _between(cubed, 1) * (dx / dy)
    solve = _factorised(open_cells, along, across)
    # In wide places the pressure hardly falls: a single number for it would lose the fall. So it is kept as
    # terms that are never added, only their differences are; each corrects what those before it leave over.
    terms: list[Array] = []
    balance = np.inf
    while balance > _BALANCE and len(terms) < _MOST_TERMS:
        flux_x, flux_y = along * _fall(terms, 0, dx), across * _fall(terms, 1, 0.0)
        sections = flux_x.sum(axis=1)
        through = sections.mean()
        if terms:
            balance = float(np.max(np.abs(sections - through)) / np.abs(through))
        left = flux_x - np.roll(flux_x, 1, axis=0) + flux_y - np.roll(flux_y, 1, axis=1)
        terms.append(np.zeros(gap.shape))
        terms[-1][open_cells] = -solve(left[open_cells].astype(float))
    if not balance <= _BALANCE:
        raise NotConverged(
            f"flow: the flux through the sections differs by {balance:.1e} of it, more than {_BALANCE:g}: "
            "the gap varies by more decades than the arithmetic resolves; use a finer grid or a smaller load"
        )
    return GapFlow(
        conductance=widest**3 / 12 * float(through) / (gap.shape[1] * dy),
        closed=False,
        pressure=np.where(open_cells, sum(terms), np.nan),
        balance=balance,
    )


def _fall(terms: list[Array], axis: int, mean: float) -> NDArray[np.longdouble]:
    """Fall of the pressure to the next cell along an axis: the mean, what nearly cancels it, the rest."""
    fall = np.full(terms[0].shape if terms else (1, 1), mean, dtype=np.longdouble)
    for term in terms:
        fall = fall + (term - np.roll(term, -1, axis=axis))
    return fall


def _between(cubed: Array, axis: int) -> Array:
    """Harmonic mean of u^3 of each cell and the next along an axis; 0 beside a cell without fluid."""
    after = np.roll(cubed, -1, axis=axis)
    total = cubed + after
    return np.divide(2 * cubed * after, total, out=np.zeros_like(cubed), where=total > 0)


def _factorised(open_cells: Mask, along: Array, across: Array) -> Callable[[Array], Array]:
    """Return the solver for the pressure of the open cells from what each of them gives."""
    from scipy.sparse import coo_array, diags_array
    from scipy.sparse.csgraph import connected_components
    from scipy.sparse.linalg import splu

    size = int(np.count_nonzero(open_cells))
    number = np.full(open_cells.shape, -1)
    number[open_cells] = np.arange(size)
    pairs = []
    for weight, axis in ((along, 0), (across, 1)):
        flows = weight > 0
        pairs.append((number[flows], np.roll(number, -1, axis=axis)[flows], weight[flows]))
    first, second, weight = (np.concatenate(part) for part in zip(*pairs, strict=True))
    links = coo_array((weight, (first, second)), shape=(size, size)).tocsr()
    links = links + links.T
    total = links.sum(axis=1)
    # One pressure of each connected cluster is free; it is 0 at its widest cell.
    count, cluster = connected_components(links, directed=False)
    free = np.ones(size, dtype=bool)
    for one in range(count):
        inside = np.flatnonzero(cluster == one)
        free[inside[np.argmax(total[inside])]] = False
    scale = 1 / np.sqrt(total[free])
    matrix = (diags_array(total) - links).tocsr()[free][:, free]
    scaled = (diags_array(scale) @ matrix @ diags_array(scale)).tocsc()
    factors = splu(scaled, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def solve(given: Array) -> Array:
        pressure = np.zeros(size)
        pressure[free] = scale * factors.solve(scale * given[free])
        return pressure

    return solve


def _checked_gap(gap: ArrayLike) -> Array:
    values = array("gap", gap)
    if values.ndim != 2 or min(values.shape, default=0) < 2:
        raise InvalidInput(f"gap of shape {values.shape}: must be a map (nx, ny) of at least 2 x 2 points")
    return np.maximum(values, 0.0)
