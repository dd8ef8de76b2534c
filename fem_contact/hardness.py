r"""Hardness: a solid that yields where the pressure reaches H, and what yielding leaves behind.

The pressure obeys 0 <= p <= H; where p = H the gap may be negative, and -g is the depth by which the surfaces
have moved into each other for good (Persson 2006, Sec. 6).
"""

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import partial
from typing import Unpack

import numpy as np

from fem_contact import bem
from fem_contact._checks import bound, instance, non_negative
from fem_contact._types import Array, Lengths, Mask
from fem_contact.contact import ContactResult, Cost, Status, weights_of
from fem_contact.patches import find_patches
from fem_contact.response import Response
from fem_contact.settings import Limits
from fem_contact.surface import HeightField, Patch

#: Solves after which the patches are given up on.
_ROUNDS = 100


@dataclass(frozen=True, kw_only=True, eq=False)
class Hardness:
    r"""The effect: a solid cannot bear more than this pressure.

    Parameters
    ----------
    pressure : float or (nx, ny) array
        Indentation hardness H [Pa], positive; a field where it differs from place to place.
    length, exponent : float
        l [m] and n, where small patches of contact are harder: one of area a bears at most

        .. math:: H \, (1 + l/d)^n, \qquad d = 2\sqrt{a/\pi}

    Raises
    ------
    InvalidInput
        For a hardness that is not positive and finite, a length or exponent that is negative.

    Notes
    -----
    The diameter of a patch stands for the wavelength of the theory (Persson 2006, Eq. 33): a convention.
    """

    pressure: float | Array
    length: float = 0.0
    exponent: float = 0.0

    def __post_init__(self) -> None:
        bound("pressure", self.pressure)
        non_negative("length", self.length)
        non_negative("exponent", self.exponent)

    @property
    def sized(self) -> bool:
        """Whether it depends on the size of a patch."""
        return self.length > 0 and self.exponent > 0

    def of_patches(self, in_contact: Mask, spacing: Lengths, *, periodic: bool = True) -> Array:
        """Return what each point bears [Pa], (nx, ny); out of contact, what a patch of one cell would."""
        patches = find_patches(in_contact, spacing, periodic=periodic)
        areas = np.append(spacing[0] * spacing[1], patches.areas)
        factor = (1 + self.length / (2 * np.sqrt(areas / np.pi))) ** self.exponent
        return bound("pressure", self.pressure, patches.labels.shape) * factor[patches.labels]


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
    volume : float
        Indented volume per nominal area [m].
    """

    elastic_area: float
    plastic_area: float
    open_area: float
    elastic_load: float
    plastic_load: float
    indentation: Array = field(repr=False)
    surface: HeightField = field(repr=False)
    volume: float


def yielded(contact: ContactResult) -> YieldedContact:
    """Read areas, loads and the smoothed surface off a result of any solver that knows a pressure bound.

    Pressing the smoothed surface again, against the solid without a bound, gives the same pressure at the
    same load: what has yielded answers elastically up to the load it yielded under, and `bem.solve_path` of
    falling loads unloads it. It does not depend on which of the two bodies took the indentation.

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
    instance("contact", contact, ContactResult)
    # A point between two nodes of different area counts by its own.
    weights = weights_of(contact)
    load = weights * contact.pressure
    plastic = contact.at_bound
    elastic, kind = contact.in_contact & ~plastic, HeightField if contact.periodic else Patch
    indentation = np.where(plastic, np.maximum(-contact.gap, 0.0), 0.0)
    plastic_area, elastic_area = (float(np.mean(weights * part)) for part in (plastic, elastic))
    return YieldedContact(
        elastic_area=elastic_area,
        plastic_area=plastic_area,
        open_area=float(np.mean(weights * ~(plastic | elastic))),
        elastic_load=float(np.mean(load * ~plastic)),
        plastic_load=float(np.mean(load * plastic)),
        indentation=indentation,
        surface=kind(heights=contact.heights - indentation, lengths=contact.lengths),
        volume=float(np.mean(weights * indentation)),
    )


def press_yielding(
    surface: HeightField,
    response: Response,
    *,
    hardness: Hardness,
    mean_pressure: float,
    **limits: Unpack[Limits],
) -> ContactResult:
    """Press a rigid rough surface against a solid that yields; boundary elements.

    Parameters
    ----------
    surface, response, mean_pressure, tolerance, max_iterations, time_limit, threads
        As in `fem_contact.bem.solve`; with a hardness that depends on size, for each of up to 100 solves.
    hardness : Hardness

    Raises
    ------
    InvalidInput
        For a mean pressure above the mean hardness, or a hardness field of another shape.
    """
    instance("hardness", hardness, Hardness)
    press = partial(bem.solve, surface, response, mean_pressure=mean_pressure, **limits)
    if hardness.sized:
        return press_by_patches(surface, hardness, lambda limit: press(pressure_bound=limit))
    return press(pressure_bound=hardness.pressure)


def press_by_patches(
    surface: HeightField, hardness: Hardness, press: Callable[[Array], ContactResult]
) -> ContactResult:
    """Press until every patch of contact bears no more than its size allows, by any solver.

    The hardness begins as that of single cells. Each solve lowers it to that of the patches there are, which
    lets them grow; it is never raised, so that this ends. `press` solves with a pressure bound (nx, ny) [Pa].
    Returned is the last result, with the cost of all; ITERATION_LIMIT where the patches do not settle.
    """
    instance("surface", surface, HeightField)
    instance("hardness", hardness, Hardness)
    limits = hardness.of_patches(np.zeros(surface.shape, dtype=np.bool_), surface.spacing)
    costs: list[Cost] = []
    for _ in range(_ROUNDS):
        result = press(limits)
        costs.append(result.cost)
        there, periodic = result.in_contact, result.periodic
        lower = np.minimum(limits, hardness.of_patches(there, surface.spacing, periodic=periodic))
        if np.all(lower >= limits) or result.status is not Status.CONVERGED:
            break
        limits = lower
    else:
        result = replace(result, status=Status.ITERATION_LIMIT)
    names = {entry.name for entry in fields(Cost)} - {"unknowns", "peak_bytes"}
    cost = replace(result.cost, **{name: sum(getattr(c, name) for c in costs) for name in names})
    return replace(result, cost=cost)
