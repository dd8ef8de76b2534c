r"""Hardness: a solid that yields where the pressure reaches H, and what yielding leaves behind.

The pressure obeys 0 <= p <= H; where p = H the gap may be negative, and -g is the depth by which the surfaces
have moved into each other for good (Persson 2006, Sec. 6).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from fem_contact import bem
from fem_contact._checks import bound, instance, positives
from fem_contact._types import Array
from fem_contact.contact import ContactResult
from fem_contact.errors import InvalidInput
from fem_contact.response import Response
from fem_contact.settings import Settings
from fem_contact.surface import HeightField

__all__ = ["Hardness", "YieldedContact", "press_yielding", "unload", "yielded"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Hardness:
    """The effect: a solid cannot bear more than this pressure.

    Parameters
    ----------
    pressure : float or (nx, ny) array
        Indentation hardness H [Pa], positive; a field where it differs from place to place.

    Raises
    ------
    InvalidInput
        For a hardness that is not positive and finite.
    """

    pressure: float | Array

    def __post_init__(self) -> None:
        bound("pressure", self.pressure)


@dataclass(frozen=True, kw_only=True, eq=False)
class YieldedContact:
    """Areas, loads and plastic indentation of a contact with a pressure bound; all per nominal area.

    Attributes
    ----------
    elastic_area, plastic_area, open_area : float
        Shares of the nominal area in contact below the bound, at the bound, and not in contact; their sum
        is 1.
    elastic_load, plastic_load : float
        Mean pressure [Pa] carried by either; their sum is the load.
    indentation : (nx, ny) array
        Depth [m] by which the surfaces have moved into each other for good, 0 where nothing yielded.
    surface : HeightField
        The smoothed surface: the heights that are left after unloading, h less the indentation.
    """

    elastic_area: float
    plastic_area: float
    open_area: float
    elastic_load: float
    plastic_load: float
    indentation: Array = field(repr=False)
    surface: HeightField = field(repr=False)

    @property
    def volume(self) -> float:
        """Indented volume per nominal area [m]."""
        return float(np.mean(self.indentation))


def yielded(contact: ContactResult) -> YieldedContact:
    """Read areas, loads and the smoothed surface off a result of any solver that knows a pressure bound.

    Pressing the smoothed surface again, against the solid without a bound, gives the same pressure at the
    same load: what has yielded answers elastically up to the load it yielded under. It does not depend on
    which of the two bodies took the indentation.

    Examples
    --------
    >>> from fem_contact.response import HalfSpace
    >>> from fem_contact.solid import Solid
    >>> x = np.arange(16) / 16
    >>> wave = HeightField(heights=0.1 * np.cos(2 * np.pi * x)[:, None] * np.ones(4), lengths=(1.0, 0.25))
    >>> solid = HalfSpace(solid=Solid(young=1.0, poisson=0.0))
    >>> found = yielded(press_yielding(wave, solid, hardness=Hardness(pressure=0.2), mean_pressure=0.1))
    >>> f"{found.elastic_area + found.plastic_area + found.open_area:.12g}"
    '1'
    >>> f"{found.elastic_load + found.plastic_load:.12g}"
    '0.1'
    """
    instance("contact", contact, ContactResult, what="a `ContactResult`")
    # A point between two nodes of different area counts by its own.
    weights = np.ones(contact.shape) if contact.weights is None else contact.weights
    load = weights * contact.pressure
    plastic = contact.at_bound
    elastic = contact.in_contact & ~plastic
    indentation = np.where(plastic, np.maximum(-contact.gap, 0.0), 0.0)
    plastic_area, elastic_area = (float(np.mean(weights * part)) for part in (plastic, elastic))
    return YieldedContact(
        elastic_area=elastic_area,
        plastic_area=plastic_area,
        open_area=float(np.mean(weights * ~(plastic | elastic))),
        elastic_load=float(np.mean(load * ~plastic)),
        plastic_load=float(np.mean(load * plastic)),
        indentation=indentation,
        surface=HeightField(heights=contact.heights - indentation, lengths=contact.lengths),
    )


def press_yielding(
    surface: HeightField,
    response: Response,
    *,
    hardness: Hardness,
    mean_pressure: float,
    tolerance: float = 1e-8,
    max_iterations: int = 1000,
    time_limit: float | None = None,
    threads: int | None = None,
) -> ContactResult:
    """Press a rigid rough surface against a solid that yields; boundary elements.

    Parameters
    ----------
    surface, response, mean_pressure, tolerance, max_iterations, time_limit, threads
        As in `fem_contact.bem.solve`.
    hardness : Hardness

    Raises
    ------
    InvalidInput
        For a mean pressure above the mean hardness, or a hardness field of another shape.
    """
    instance("hardness", hardness, Hardness, what="a `Hardness`")
    return bem.solve(
        surface,
        response,
        mean_pressure=mean_pressure,
        pressure_bound=hardness.pressure,
        tolerance=tolerance,
        max_iterations=max_iterations,
        time_limit=time_limit,
        threads=threads,
    )


def unload(
    contact: ContactResult,
    response: Response,
    *,
    mean_pressures: Iterable[float],
    tolerance: float = 1e-8,
    time_limit: float | None = None,
    threads: int | None = None,
) -> list[ContactResult]:
    """Follow a yielded contact to lower loads, elastically.

    Parameters
    ----------
    contact : ContactResult
        State under the largest load so far.
    response : Response
        The solid.
    mean_pressures : iterable of float
        Loads [Pa], none above that of `contact`: beyond it more would yield.
    tolerance, time_limit, threads
        As in `fem_contact.bem.solve`.

    Raises
    ------
    InvalidInput
        For a load above that of `contact`.
    """
    instance("contact", contact, ContactResult, what="a `ContactResult`")
    Settings(tolerance=tolerance)
    loads = positives("mean_pressures", mean_pressures, unit="Pa")
    for load in loads:
        if not load <= contact.mean_pressure * (1 + tolerance):
            raise InvalidInput(
                f"mean_pressures: {load!r} Pa is above the {contact.mean_pressure!r} Pa that the surface "
                "yielded under; press further with `press_yielding`"
            )
    return bem.solve_path(
        yielded(contact).surface,
        response,
        mean_pressures=loads,
        tolerance=tolerance,
        time_limit=time_limit,
        threads=threads,
    )
