r"""What a ring of waves does to the pressure of every point, and the books in which nothing may be missing.

A point in contact before the ring either stays or is *lost*, its pressure p then falling to zero; others *enter*. With the change
delta of the pressure, and sums per nominal area over the points that are in contact before (c) or enter (e),

.. math::
    \Delta A &= \text{entered} - \text{lost}, \\
    \Delta\langle p \rangle = 0 &= \sum_c \delta + \sum_e p', \\
    \Delta\langle p^2 \rangle &= \sum_c \delta^2 + 2 \sum_c p\,\delta + \sum_e p'^2 .

Drift and diffusivity are the means of delta and delta^2 over the points in contact before, by Delta V. In the theory a pressure
diffuses until it is absorbed at zero: its drift is zero at any step, since a stopped walk is a martingale, its diffusivity tends to
1, and nothing enters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from validation.arrays import Array

__all__ = ["BINS", "FLOWS", "PROFILES", "PROFILE_EDGES", "Pressed", "bins_of", "flows", "mean_of", "profile"]

#: What is read off a step, per nominal area, with pressures in units of sqrt(V) before it.
FLOWS = {
    "lost": "area that leaves contact",
    "entered": "area that enters contact",
    "entered_load": "load that the entering points carry",
    "entered_square": "sum of p^2 of the entering points",
    "moved": "sum of delta over the points in contact before",
    "crossed": "sum of p delta over them",
    "spread": "sum of delta^2 over them",
    "square_change": "change of the sum of p^2 over all points",
}

#: The same of the points in contact before, by their pressure then.
PROFILES = {
    "touching": "share of the nominal area in contact before",
    "leaving": "share of the nominal area that is lost",
    "pressure": "sum of p",
    "drifted": "sum of delta",
    "diffused_square": "sum of delta^2",
}

#: Bins of p/sqrt(V) and their edges, crowded near zero; what lies above counts in the last.
BINS = 40
PROFILE_EDGES = 6.0 * np.linspace(0.0, 1.0, BINS + 1) ** 2


@dataclass(frozen=True, kw_only=True, eq=False)
class Pressed:
    """Pressures [Pa] of all points, zero where there is no contact, and which points are in contact."""

    pressure: Array
    in_contact: NDArray[np.bool_]


def flows(before: Pressed, after: Pressed, *, unit: float) -> dict[str, float]:
    """Return the sums of one step by their names in `FLOWS`.

    Parameters
    ----------
    before, after : Pressed
        The same points without and with the ring.
    unit : float
        Unit of pressure [Pa], sqrt(V) before the step.
    """
    lost, entered = before.in_contact & ~after.in_contact, after.in_contact & ~before.in_contact
    p, delta = _changes(before, after, unit=unit)
    new = after.pressure[entered] / unit
    total = [state.pressure[state.in_contact] / unit for state in (before, after)]
    sums = {
        "lost": np.count_nonzero(lost),
        "entered": new.size,
        "entered_load": new.sum(),
        "entered_square": new @ new,
        "moved": delta.sum(),
        "crossed": p @ delta,
        "spread": delta @ delta,
        "square_change": total[1] @ total[1] - total[0] @ total[0],
    }
    return {name: float(value) / before.pressure.size for name, value in sums.items()}


def profile(before: Pressed, after: Pressed, *, unit: float) -> dict[str, Array]:
    """Return the sums of one step over the bins of the pressure before, by their names in `PROFILES`."""
    p, delta = _changes(before, after, unit=unit)
    leaving = ~after.in_contact[before.in_contact]
    where = bins_of(p)

    def binned(weights: Array | None = None) -> Array:
        return np.bincount(where, weights=weights, minlength=BINS) / before.pressure.size

    return {
        "touching": binned(),
        "leaving": binned(leaving.astype(float)),
        "pressure": binned(p),
        "drifted": binned(delta),
        "diffused_square": binned(delta * delta),
    }


def _changes(before: Pressed, after: Pressed, *, unit: float) -> tuple[Array, Array]:
    """Pressures of the points in contact before, and their changes; one that is lost ends at zero."""
    p = before.pressure[before.in_contact] / unit
    later = np.where(after.in_contact, after.pressure, 0.0)[before.in_contact]
    return p, later / unit - p


def bins_of(pressure: Array) -> NDArray[np.int64]:
    """Return the bin of each reduced pressure."""
    return np.clip(np.searchsorted(PROFILE_EDGES, pressure, side="right") - 1, 0, BINS - 1)


def mean_of(readings: Sequence[Mapping[str, Array | float]]) -> dict[str, Array]:
    """Average the readings of a ring and of its negative: what is odd in the ring drops out."""
    return {name: np.mean([np.asarray(one[name]) for one in readings], axis=0) for name in readings[0]}
