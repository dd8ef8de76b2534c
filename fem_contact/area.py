r"""Real contact area: counted, corrected at its edge, and extrapolated over grids.

Counting contact cells overestimates the area in first order of the spacing, because a cell enters contact as
soon as its centre does and the discrete edge lies on average a fixed fraction of a cell outside the true one.
The excess is proportional to the edge length, with a constant that belongs to the discretisation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from fem_contact.contact import ContactResult
from fem_contact.errors import InvalidInput

__all__ = ["EDGE_CONSTANTS", "ContactAreas", "Limit", "contact_areas", "limit_area"]

#: Excess of the counted area over the true one, per counted edge length and spacing: "bem" for pressures
#: collocated at the points of a Fourier grid, "fem" for nodal forces on linear hexahedra.
EDGE_CONSTANTS = MappingProxyType({"bem": 0.100, "fem": 0.159})


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
    """

    pixel: float
    perimeter: float
    edge_length: float
    edge_fraction: float
    edge_constant: float
    spacing: tuple[float, float]


def contact_areas(result: ContactResult, *, edge_constant: float = EDGE_CONSTANTS["bem"]) -> ContactAreas:
    r"""Contact area of a result: counted, and with the perimeter correction.

    .. math:: A_\text{perimeter} = A_\text{pixel} - c\, P_\text{edge}\, \Delta x

    Parameters
    ----------
    result : ContactResult
        Contact is its `in_contact`, each point with its weight.
    edge_constant : float
        c, for the discretisation that made the result; see `EDGE_CONSTANTS`.

    Notes
    -----
    On rectangular cells each edge is corrected by c dx dy, whichever way it runs. V. A. Yastrebov, G.
    Anciaux, J.-F. Molinari, Tribology International 114 (2017) 161, with their constant, .118, replaced by
    the caller's.
    """
    contact = result.in_contact
    dx, dy = result.spacing
    across_x = int(np.count_nonzero(contact != np.roll(contact, 1, axis=0)))
    across_y = int(np.count_nonzero(contact != np.roll(contact, 1, axis=1)))
    pixel = float(np.mean(contact if result.weights is None else contact * result.weights))
    fraction = (across_x + across_y) / contact.size
    return ContactAreas(
        pixel=pixel,
        perimeter=pixel - edge_constant * fraction,
        edge_length=(across_x / dx + across_y / dy) / contact.size,
        edge_fraction=fraction,
        edge_constant=edge_constant,
        spacing=(dx, dy),
    )


@dataclass(frozen=True, kw_only=True)
class Limit:
    """An area extrapolated to vanishing spacing.

    Attributes
    ----------
    value : float
        A/A0 in the limit.
    uncertainty : float
        Its standard error, from the scatter of the grids about the fit.
    edge_constant : float
        Fitted excess per edge fraction.
    grids : int
        Number of areas that went into the fit.
    """

    value: float
    uncertainty: float
    edge_constant: float
    grids: int


def limit_area(areas: Sequence[ContactAreas]) -> Limit:
    """Limit of the contact area of one surface over its grids, by regression of fixed order.

    The pixel area is fitted as ``A + c * (P_edge dx)``; the order is not fitted, since the order observed on
    a few grids scatters too much to extrapolate with. Where a contact edge falls between grid points is
    random, so the area of one grid scatters like (number of edge cells)^(1/2) dx dy, and each grid is
    weighted accordingly.

    Parameters
    ----------
    areas : sequence of ContactAreas
        Of one surface at one load, on at least three grids, not all of one spacing; several shifts of a grid
        may appear.

    Raises
    ------
    InvalidInput
        For fewer than three areas, or areas of a single spacing.
    """
    sizes = {area.spacing for area in areas}
    if len(areas) < 3 or len(sizes) < 2:
        raise InvalidInput(
            f"{len(areas)} areas on {len(sizes)} spacings: a limit needs three areas on at least two spacings"
        )
    excess = np.array([area.edge_fraction for area in areas])
    pixel = np.array([area.pixel for area in areas])
    if not np.any(excess):
        return Limit(value=float(pixel.mean()), uncertainty=0.0, edge_constant=0.0, grids=len(areas))
    cell = np.array([area.spacing[0] * area.spacing[1] for area in areas])
    deviation = np.sqrt(excess * cell)
    deviation = np.maximum(deviation / deviation.max(), 1e-3)
    value, constant, error = _weighted_line(excess, pixel, deviation)
    return Limit(value=value, uncertainty=error, edge_constant=constant, grids=len(areas))


def _weighted_line(
    x: NDArray[np.float64], y: NDArray[np.float64], deviation: NDArray[np.float64]
) -> tuple[float, float, float]:
    """Intercept and slope of y = a + b x, errors proportional to `deviation`; and the standard error of a."""
    design = np.stack([np.ones_like(x), x], axis=1) / deviation[:, None]
    (intercept, slope), *_ = np.linalg.lstsq(design, y / deviation)
    rest = y / deviation - design @ np.array([intercept, slope])
    variance = float(rest @ rest) / (x.size - 2)
    covariance = variance * np.linalg.pinv(design.T @ design)
    return float(intercept), float(slope), float(np.sqrt(covariance[0, 0]))
