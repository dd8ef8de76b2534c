r"""Real contact area: counted, corrected at its edge, and with its edge located inside the cells.

Counting contact cells overestimates the area in first order of the spacing, because a cell enters contact as
soon as its centre does and the discrete edge lies on average a fixed fraction of a cell outside the true one.
The excess is proportional to the edge length, with a constant that belongs to the discretisation.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from fem_contact._checks import finite, listed, samples, truth, whole
from fem_contact._types import AnyArray, Array, Lengths, Numbers
from fem_contact.contact import ContactResult, check_result, weights_of
from fem_contact.errors import InvalidInput
from fem_contact.height_traits import height_traits

_T = TypeVar("_T")

#: Excess of the counted area over the true one, per counted edge length and spacing: "bem" for pressures
#: collocated at the points of a Fourier grid, from Hertzian contacts 18 to 38 cells in radius (standard error
#: .0015); "bem free" for pressures constant on each cell of a patch with free surroundings (10 to 38 cells,
#: .002); "fem" for nodal forces on trilinear hexahedra as deep as wide at nu = .3 (.002; .17 at nu = 0); and
#: for each element of the block by its name, twenty nodes in radius at nu = .3, .45, .3 and .5 (.003).
EDGE_CONSTANTS = MappingProxyType(
    {
        **{"bem": 0.103, "bem free": 0.090, "fem": 0.198},
        **{"Hex1": 0.198, "Hex1/P0": 0.260, "Hex2": 0.137, "Hex2/P1disc": 0.205},
    }
)


#: Width [cells] over which the contact map is smoothed to find the direction of an edge.
_SMOOTHING = 1.5
#: Unevenness of the directions of a contour: below the first, rough contacts of a few tens of edges lie, too;
#: the second is that of lines.
_UNEVEN = (0.4, 1.0)
#: Degrees of the edge map in v = 1 / (1 + rho^(2/3)) and in the squared cosine of the edge's direction.
_DEGREES = (5, 2)
#: Degrees of its second part in v and the squared cosine, and powers of the ratios further in and out.
_BEND_DEGREES = (2, 1)
_BEND_POWERS = ((0, 0), (1, 0), (0, 1), (2, 0), (0, 2), (1, 1))
#: Largest ratio of fields beside the edge: beyond it, as on patches of one cell, it says nothing more.
_STEEPEST = 1.5

#: Coefficients of the second part of the edge map of boundary elements, by power of the fields and then by
#: degree in v and cos^2: least squares on 140 rough surfaces (`FITTED` of tests/benchmarks/area_law.py).
_BEND = (
    *(2.10991, -1.80106, -3.88063, 2.65368, 1.23854, -0.25162),
    *(2.49617, -3.74519, -5.24840, 9.41387, 3.91695, -7.03929),
    *(-4.54312, 3.54819, 5.82276, -1.00854, 0.03129, -4.91374),
    *(-1.22142, 1.87669, 3.41495, -5.69656, -2.64113, 4.33557),
    *(1.42208, -0.76705, -0.81988, -2.89520, -1.04937, 4.65555),
    *(-1.83037, 2.96412, 2.64263, -5.25835, -4.54529, 6.66232),
)

#: Coefficients of the first part for boundary elements, after that of degree 0.
_PERIODIC = (
    *(1.22766, -0.82019),
    *(1.27074, -2.94378, 1.77380),
    *(4.62251, -4.40885, 3.91618),
    *(-7.25598, 13.76495, -10.79373),
    *(0.11590, -1.55225, 1.97152),
    *(2.48050, -5.54267, 3.60049),
)

#: Coefficients of the edge map of trilinear hexahedra as deep as wide at nu = .3.
_TRILINEAR = (
    *(-0.94792, 1.43228, -0.73378),
    *(2.08013, -5.52714, 3.83788),
    *(4.03418, 17.14346, -17.40214),
    *(-12.68666, -30.84094, 39.37498),
    *(9.89611, 33.39751, -43.12207),
    *(-1.98161, -15.19323, 18.02973),
)

#: Number of coefficients of the first part; and a second part that changes nothing.
_FIRST = (_DEGREES[0] + 1) * (_DEGREES[1] + 1)
_STRAIGHT = (0.0,) * len(_BEND)

#: Coefficients of the edge map per discretisation, by degree in v and then in cos^2; see `subcell_area`.
EDGE_MAPS = MappingProxyType(
    {
        "bem": (-0.57804, *_PERIODIC, *_BEND),
        # On paraboloids of 5 to 38 cells in radius edges lie .0191 +- .0006 cells further out at any radius.
        "bem free": (-0.57804 + 0.0191, *_PERIODIC, *_BEND),
        "fem": _TRILINEAR + _STRAIGHT,
        "Hex1": _TRILINEAR + _STRAIGHT,
    }
)


#: Attributes of `ContactAreas` that say what contour and heights are like.
TRAITS = ("alignment", "anisotropy", "unresolved", "wavenumber")


@dataclass(frozen=True, kw_only=True)
class ContactAreas:
    """Relative contact area A/A0 of one result in several definitions.

    Attributes
    ----------
    pixel : float
        Contact cells times their area.
    perimeter : float
        `pixel` minus `edge_constant` times the edge fraction.
    edge_length : float
        P_edge [1/m]: length of the cell edges between contact and non-contact per nominal area, along both
        directions together; on average 4/pi times the true contour.
    edge_fraction : float
        Number of such edges over the number of cells; P_edge dx on square cells.
    edge_constant : float
        The constant used.
    spacing : tuple of float
        (dx, dy) [m].
    subcell : float or None
        Area with the edge located inside the cells (`subcell_area`), where that was asked for.
    cells : int
        Number of cells of the nominal area.
    alignment : float
        0 where the contour runs in all directions, as that of a rough surface does; 1 where it runs in one,
        so that its edges all lie alike between the grid points.
    anisotropy : float
        Of the slopes of the heights: 0 where they are alike along x, y and between, 1 where they run in one
        direction; 1 less Peklenik's number.
    unresolved : float
        Share of the mean square curvature of the heights in waves of less than four grid points: 0 where the
        grid resolves them, about half at kinks and nearly all at steps, however fine the grid.
    wavenumber : float
        Root mean square wavenumber of the curvature of the heights, times the spacing, whatever their size:
        some 5 over the points per shortest wave.
    """

    pixel: float
    perimeter: float
    edge_length: float
    edge_fraction: float
    edge_constant: float
    spacing: Lengths
    subcell: float | None = None
    cells: int = 1
    alignment: float = 0.0
    anisotropy: float = 0.0
    unresolved: float = 0.0
    wavenumber: float = 0.0

    @property
    def cell_share(self) -> float:
        """Share of one cell in the nominal area."""
        return 1 / self.cells


def contact_areas(
    result: ContactResult,
    *,
    edge_constant: float | None = None,
    subcell: bool = False,
    edge_map: Sequence[float] | None = None,
) -> ContactAreas:
    r"""Contact area of a result: counted, and with the perimeter correction.

    .. math:: A_\text{perimeter} = A_\text{pixel} - c\, P_\text{edge}\, \Delta x

    Parameters
    ----------
    result : ContactResult
        Contact is its `in_contact`, each point with its weight.
    edge_constant : float, optional
        c, for the discretisation that made the result; without it that of `EDGE_CONSTANTS` which belongs to
        the element or method that the result names as its provenance.
    subcell : bool
        Also locate the edge inside the cells.
    edge_map : sequence of float, optional
        For the discretisation that made the result, if the edge is located; likewise one of `EDGE_MAPS`.

    Raises
    ------
    InvalidInput
        For a result whose discretisation is unknown, or has no map, where the constant or map is not given.

    Notes
    -----
    On rectangular cells each edge is corrected by c dx dy, whichever way it runs. V. A. Yastrebov, G.
    Anciaux, J.-F. Molinari, Tribology International 114 (2017) 161, with their constant, .118, replaced by
    the caller's.
    """
    check_result("result", result)
    if edge_constant is None:
        edge_constant = _known(result, EDGE_CONSTANTS, "edge_constant")
    edge_constant = finite("edge_constant", edge_constant)
    truth("subcell", subcell)
    contact = result.in_contact
    dx, dy = result.spacing
    # At the sides of a patch that does not repeat the cells end where the body does.
    first = 0 if result.periodic else 1
    across_x = int(np.count_nonzero((contact != np.roll(contact, 1, axis=0))[first:]))
    across_y = int(np.count_nonzero((contact != np.roll(contact, 1, axis=1))[:, first:]))
    pixel = float(np.mean(contact * weights_of(result)))
    fraction = (across_x + across_y) / contact.size
    edges = contact_edges(result)
    return ContactAreas(
        pixel=pixel,
        perimeter=pixel - edge_constant * fraction,
        edge_length=(across_x / dx + across_y / dy) / contact.size,
        edge_fraction=fraction,
        edge_constant=edge_constant,
        spacing=(dx, dy),
        subcell=_located(result, edges, edge_map) if subcell else None,
        cells=contact.size,
        alignment=alignment(edges.harmonics()),
        # The sides of a patch do not continue each other.
        **vars(height_traits(result.heights, result.spacing, patch=discretisation(result) == "bem free")),
    )


def discretisation(result: ContactResult) -> str:
    """Name of the discretisation of a result in `EDGE_CONSTANTS`; empty where the result does not say."""
    check_result("result", result)
    element, method = (result.provenance.get(key, "") for key in ("element", "method"))
    if element or not method.startswith("boundary elements"):
        return element
    return "bem" if result.periodic else "bem free"


def _known(result: ContactResult, known: Mapping[str, _T], name: str) -> _T:
    """Return what is known for the discretisation of a result, refused where nothing is."""
    method = discretisation(result)
    if method not in known:
        named = repr(method) if method else "the result does not say"
        raise InvalidInput(
            f"{name}: none is known for the discretisation ({named}): give one, "
            f"or take a result of {', '.join(known)}"
        )
    return known[method]


def subgrid_shifts(per_axis: int) -> list[tuple[float, float]]:
    """Shifts of a grid, in parts of a cell, that fill the cell evenly.

    The same surface seen by shifted grids, ``surface.shifted(fraction)``, has the same contact; the places of
    its edges in the cells differ, so that averages over shifts lose the noise of the lattice.

    Examples
    --------
    >>> subgrid_shifts(2)
    [(0.0, 0.0), (0.0, 0.5), (0.5, 0.0), (0.5, 0.5)]
    """
    whole("per_axis", per_axis, least=1, most=100)
    return [(i / per_axis, j / per_axis) for i in range(per_axis) for j in range(per_axis)]


def mean_areas(areas: Sequence[ContactAreas]) -> ContactAreas:
    """Average the areas of one surface over shifts of one grid.

    Raises
    ------
    InvalidInput
        For no area, or areas of different spacing or edge constant.
    """
    listed("areas", areas, ContactAreas, what="`ContactAreas`")
    if len({(area.spacing, area.edge_constant) for area in areas}) != 1:
        raise InvalidInput("areas: must all be of one grid and one edge constant")
    located = [area.subcell for area in areas if area.subcell is not None]
    names = ("pixel", "perimeter", "edge_length", "edge_fraction", *TRAITS)
    means: dict[str, Any] = {name: float(np.mean([getattr(area, name) for area in areas])) for name in names}
    subcell = float(np.mean(located)) if len(located) == len(areas) else None
    return replace(areas[0], **means, subcell=subcell)


@dataclass(frozen=True, kw_only=True)
class Edges:
    """Pairs of neighbouring cells with contact in the first and none in the second."""

    inside: Numbers  # (n,): Flat index of the contact cell
    axis: Numbers  # (n,): 0 where the neighbour lies along x, 1 along y
    sign: Numbers  # (n,): +1 or -1: on which side it lies
    # (n,): Between the outward normal of the edge and the direction to the neighbour.
    cosine: Array
    # (n,): rho = E* g / (p d cosine), with the gap of the neighbour, the pressure of the contact cell
    # and their distance d.
    ratio: Array
    # (n,): p^2 of the contact cell over that of the cell behind it, and g^(2/3) of the neighbour over
    # that of the cell beyond: both grow linearly from a straight edge, and how they bend is what the
    # edge is off by in second order. At most 1.5.
    inner: Array
    outer: Array

    def bends(self) -> Array:
        """Monomials of the second part of the edge map, as columns."""
        first = self._monomials(_BEND_DEGREES)
        fields = [self.inner**a * self.outer**b for a, b in _BEND_POWERS]
        return np.concatenate([first * field[:, None] for field in fields], axis=1)

    def shift(self, coefficients: Array) -> float:
        """Cells by which an edge map moves these edges, all together."""
        first, second = np.split(coefficients, [_FIRST])
        place = np.clip(self._monomials(_DEGREES) @ first, -0.6, 1.2) + self.bends() @ second
        return float(np.sum((place - 0.5) * self.cosine**2))

    def harmonics(self) -> Array:
        """Sum of the weights cos^2 of these edges, and of these times cos 8 theta of their direction."""
        fourth = 8 * self.cosine**4 - 8 * self.cosine**2 + 1
        return np.array([np.sum(part * self.cosine**2) for part in (1.0, 2 * fourth**2 - 1)])

    def _monomials(self, degrees: tuple[int, int]) -> Array:
        v = 1 / (1 + self.ratio ** (2 / 3))
        powers = [v**k * self.cosine ** (2 * m) for k in range(degrees[0] + 1) for m in range(degrees[1] + 1)]
        return np.stack(powers, axis=1)


def contact_edges(result: ContactResult) -> Edges:
    """Find the edges of contact between grid cells, with what the fields say about their place."""
    import scipy.ndimage

    check_result("result", result)
    contact, spacing = result.in_contact, result.spacing
    mode: Any = "wrap" if result.periodic else "nearest"
    smooth = scipy.ndimage.gaussian_filter(contact.astype(float), _SMOOTHING, mode=mode)

    def moved(field: AnyArray, by: int, axis: int) -> AnyArray:
        places = np.arange(field.shape[axis]) - by
        return np.take(field, places, axis, mode="wrap" if result.periodic else "clip")

    slopes = [(moved(smooth, 1, k) - moved(smooth, -1, k)) / spacing[k] for k in (0, 1)]
    parts = []
    for axis, sign in ((0, 1), (0, -1), (1, 1), (1, -1)):
        inside = contact & ~moved(contact, -sign, axis)
        normal = [(slope + moved(slope, -sign, axis))[inside] for slope in slopes]
        length = np.hypot(normal[0], normal[1])
        cosine = sign * normal[axis] / np.where(length > 0, length, 1.0)
        cosine = np.clip(cosine, 0.05, 1.0)
        scale = result.pressure[inside] * spacing[axis] * cosine
        gap = result.contact_modulus * np.maximum(moved(result.gap, -sign, axis)[inside], 0.0)
        ratio = _over(gap, scale)
        behind = moved(result.pressure, sign, axis)[inside]
        inner = np.minimum(_over(result.pressure[inside], behind), _STEEPEST**0.5) ** 2
        beyond = result.contact_modulus * moved(result.gap, -2 * sign, axis)[inside]
        outer = np.minimum(_over(gap, beyond), _STEEPEST**1.5) ** (2 / 3)
        index = np.flatnonzero(inside)
        sides = np.full(index.shape, axis), np.full(index.shape, sign)
        parts.append((index, *sides, cosine, ratio, inner, outer))
    names = ("inside", "axis", "sign", "cosine", "ratio", "inner", "outer")
    columns = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Edges(**dict(zip(names, columns, strict=True)))


def _over(above: Array, below: Array) -> Array:
    """Ratio of fields that are not negative; infinite where nothing is below."""
    held = below > 0
    return np.where(held, np.maximum(above, 0.0) / np.where(held, below, 1.0), np.inf)


def subcell_area(result: ContactResult, *, edge_map: Sequence[float] | None = None) -> float:
    r"""Relative contact area with the edge located inside the cells.

    Near an edge p = K sqrt(s) inside and g = (4 K / 3 E*) s^(3/2) outside, at distance s. The ratio of gap
    and pressure on both sides of the edge between two neighbours therefore tells its place between them,
    whatever K is:

    .. math:: \rho = \frac{E^* g_j}{p_i\, d \cos\theta} \;\to\; \frac43 \frac{(1-s)^{3/2}}{s^{1/2}}

    with s in units of their distance d. The discrete fields follow another curve, which depends on the
    discretisation and a little on the direction; it was fitted as a polynomial to contacts whose edge is
    known. Each piece of edge is seen by pairs along x and along y, which are weighted with cos^2 of their
    directions: together by 1.

    Parameters
    ----------
    result : ContactResult
        On cells that are square within 5 %, of equal weight.
    edge_map : sequence of float, optional
        Coefficients of the fitted curve, for the discretisation that made the result; without it the one of
        `EDGE_MAPS` that belongs to it.

    Raises
    ------
    InvalidInput
        For cells that are not square or nodes of unequal weight, for which there is no such map, and for a
        result of a discretisation that has none, unless it is given.

    Notes
    -----
    Needs a few cells per patch; at the edge of a plastic or adhesive contact the law of the edge is another,
    and the estimate means nothing.
    """
    return _located(result, contact_edges(result), edge_map)


def _located(result: ContactResult, edges: Edges, edge_map: Sequence[float] | None) -> float:
    """Area with its edge located."""
    dx, dy = result.spacing
    if abs(dx / dy - 1) > 0.05:
        raise InvalidInput(f"cells of {dx:.6g} m x {dy:.6g} m: the edge is located on square cells only")
    if result.weights is not None:
        raise InvalidInput("nodes of unequal weight: the edge is located on uniform nodes only")
    given = _known(result, EDGE_MAPS, "edge_map") if edge_map is None else edge_map
    coefficients = samples("edge_map", given)
    if coefficients.size != len(EDGE_MAPS["bem"]):
        raise InvalidInput(
            f"edge_map of {coefficients.size} numbers: must have {len(EDGE_MAPS['bem'])}, as in `EDGE_MAPS`"
        )
    return float(np.mean(result.in_contact)) + edges.shift(coefficients) / result.in_contact.size


def alignment(harmonics: Sequence[float] | Array) -> float:
    """How far the directions of a contour are from even: 0 within what rough contacts show, 1 for a line.

    The errors of the edge map repeat every quarter turn. The mean of cos 8 theta vanishes where directions
    are even; it is 1 for lines along the grid and its diagonals and .8 to 1 for other short steps, and falls
    soon where lines wander, as those that grinding leaves.
    """
    weight, eighth = harmonics
    low, high = _UNEVEN
    return float(np.clip((abs(eighth) / weight - low) / (high - low), 0, 1)) if weight > 0 else 0.0
