r"""What a ring of waves does to the pressure of every point, and the books in which nothing may be missing.

A point is in contact before the ring, after it, both or neither: it *stays*, is *lost*, *enters* or is out. With the pressure p
before, its change delta, and sums over points per nominal area,

.. math::
    \Delta A &= \text{entered} - \text{lost}, \\
    \Delta\langle p \rangle = 0 &= \sum_\text{stay} \delta - \sum_\text{lost} p + \sum_\text{enter} (p + \delta), \\
    \Delta\langle p^2 \rangle &= \sum_\text{stay} \delta^2 + 2 \sum_\text{stay} p\,\delta
        - \sum_\text{lost} p^2 + \sum_\text{enter} (p + \delta)^2 .

In the theory the first sum of the last line is A dV, and it and the loss are all there is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["FLOWS", "PROFILES", "PROFILE_EDGES", "Pressed", "flows", "mean_of", "profile"]

Array = NDArray[np.float64]

#: What is read off a step, per nominal area, with pressures in units of sqrt(V) before it.
FLOWS = {
    "lost": "area that leaves contact",
    "entered": "area that enters contact",
    "lost_load": "load that the leaving points carried",
    "entered_load": "load that the entering points carry",
    "lost_square": "sum of p^2 of the leaving points",
    "entered_square": "sum of p^2 of the entering points",
    "moved": "sum of delta of the staying points",
    "crossed": "sum of p delta of the staying points",
    "spread": "sum of delta^2 of the staying points",
    "square_change": "change of the sum of p^2 over all points",
    "load_change": "change of the sum of p over all points",
}

#: The same of the staying points by their pressure before: share of the nominal area, and sums.
PROFILES = {
    "staying": "share of the nominal area that stays in contact",
    "leaving": "share of the nominal area that is lost",
    "pressure": "sum of p of the staying points",
    "drifted": "sum of delta of the staying points",
    "diffused_square": "sum of delta^2 of the staying points",
}

#: Edges of the bins of p/sqrt(V), crowded near zero; what lies above counts in the last.
PROFILE_EDGES = 6.0 * np.linspace(0.0, 1.0, 41) ** 2


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
    points = before.pressure.size
    stay = before.in_contact & after.in_contact
    lost, entered = before.in_contact & ~after.in_contact, after.in_contact & ~before.in_contact
    p, gone, new = before.pressure[stay] / unit, before.pressure[lost] / unit, after.pressure[entered] / unit
    delta = after.pressure[stay] / unit - p
    total = [state.pressure[state.in_contact] / unit for state in (before, after)]
    sums = {
        "lost": gone.size,
        "entered": new.size,
        "lost_load": gone.sum(),
        "entered_load": new.sum(),
        "lost_square": gone @ gone,
        "entered_square": new @ new,
        "moved": delta.sum(),
        "crossed": p @ delta,
        "spread": delta @ delta,
        "square_change": total[1] @ total[1] - total[0] @ total[0],
        "load_change": total[1].sum() - total[0].sum(),
    }
    return {name: float(value) / points for name, value in sums.items()}


def profile(before: Pressed, after: Pressed, *, unit: float) -> dict[str, Array]:
    """Return the sums of one step over the bins of the pressure before, by their names in `PROFILES`."""
    stay, lost = before.in_contact & after.in_contact, before.in_contact & ~after.in_contact
    p, gone = before.pressure[stay] / unit, before.pressure[lost] / unit
    delta = after.pressure[stay] / unit - p

    def binned(values: Array, weights: Array | None = None) -> Array:
        where = np.clip(np.searchsorted(PROFILE_EDGES, values, side="right") - 1, 0, PROFILE_EDGES.size - 2)
        sums = np.bincount(where, weights=weights, minlength=PROFILE_EDGES.size - 1)
        return np.asarray(sums / before.pressure.size)

    return {
        "staying": binned(p),
        "leaving": binned(gone),
        "pressure": binned(p, p),
        "drifted": binned(p, delta),
        "diffused_square": binned(p, delta * delta),
    }


def mean_of(readings: Sequence[Mapping[str, Array | float]]) -> dict[str, Array]:
    """Average the readings of a ring and of its negative: what is odd in the ring drops out."""
    return {name: np.mean([reading[name] for reading in readings], axis=0) for name in readings[0]}
