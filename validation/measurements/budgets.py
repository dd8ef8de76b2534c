r"""What a ring of waves does to the pressure of every point: budgets of area, load and mean square pressure, and memory.

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

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from persson import elastic
from validation.arrays import Array

#: Bins of p/sqrt(V) and their edges, crowded near zero; what lies above counts in the last.
BINS = 40
PROFILE_EDGES = 6.0 * np.linspace(0.0, 1.0, BINS + 1) ** 2


@dataclass(frozen=True, kw_only=True, eq=False)
class Pressed:
    """Pressures [Pa] of all points, zero where there is no contact, and which points are in contact."""

    pressure: Array
    in_contact: NDArray[np.bool_]


def budget(before: Pressed, after: Sequence[Pressed], *, unit: float) -> dict[str, Array]:
    """Return the sums of one step per nominal area, and by the bins of the pressure before, by their names in the registry.

    They are means over the states `after` a ring and after its negative: what is odd in the ring drops out.
    Pressures in `unit` [Pa], sqrt(V) before the step; the points are the same without and with the ring.
    """
    sums, points = [_sums(before, state, unit=unit) for state in after], before.pressure.size
    return {name: np.mean([s[name] / points for s in sums], axis=0) for name in sums[0]}


def _sums(before: Pressed, after: Pressed, *, unit: float) -> dict[str, Any]:
    lost, entered = before.in_contact & ~after.in_contact, after.in_contact & ~before.in_contact
    p = before.pressure[before.in_contact] / unit
    delta = np.where(after.in_contact, after.pressure, 0.0)[before.in_contact] / unit - p
    new = after.pressure[entered] / unit
    total = [state.pressure[state.in_contact] / unit for state in (before, after)]
    binned = partial(np.bincount, bins_of(p), minlength=BINS)
    return {
        "area_lost": np.count_nonzero(lost),
        "area_entered": new.size,
        "load_entered": new.sum(),
        "square_entered": new @ new,
        "pressure_change": delta.sum(),
        "pressure_cross_change": p @ delta,
        "pressure_change_square": delta @ delta,
        "square_change": total[1] @ total[1] - total[0] @ total[0],
        "bin_contact": binned(),
        "bin_lost": binned(lost[before.in_contact]),
        "bin_pressure": binned(p),
        "bin_change": binned(delta),
        "bin_change_square": binned(delta * delta),
    }


def bins_of(pressure: Array) -> NDArray[np.int64]:
    """Return the bin of each reduced pressure."""
    return np.clip(np.searchsorted(PROFILE_EDGES, pressure, side="right") - 1, 0, BINS - 1)


def diffused_area(state: Pressed, added: float) -> float:
    r"""Contact area that absorbing diffusion makes of given pressures, over A_0, by Delta V [Pa^2].

    .. math:: \frac{A}{A_0} = \frac{1}{N} \sum_\text{contact} \operatorname{erf}\frac{p}{\sqrt{2 \Delta V}}

    The equation is linear: a point with pressure p before is a surface under the nominal pressure p, whose
    waves so far are none (Persson 2006, Eqs. 17, 19 and 20).
    """
    pressure = state.pressure[state.in_contact]
    areas = elastic.contact_area(pressure[pressure > 0], stress_variance=added)
    return float(np.sum(areas)) / state.pressure.size


class Memory:
    """What became of every point along a chain of steps, told one state after the other.

    ``out`` and ``returned`` (steps,) count points that were out of contact when a step began, and those of
    them that it brought back, by the steps since they had left; index 0 is those that were never in
    contact. ``two_step`` and ``composed``: share of the nominal area out before two steps and in contact
    after, and by the laws of single steps.
    """

    def __init__(self, first: Pressed, *, steps: int) -> None:
        self.out, self.returned = np.zeros(steps + 1), np.zeros(steps + 1)
        self.two_step: list[float] = []
        self.composed: list[float] = []
        self._since = np.zeros(first.in_contact.shape, dtype=np.int16)
        self._ever_left = np.zeros(first.in_contact.shape, dtype=bool)
        self._contacts = [first.in_contact]
        self._last = first

    def add(self, state: Pressed, *, unit: float) -> None:
        """Tell the state after the next step; `unit` is sqrt(V) [Pa] before that step."""
        before, out = self._last, ~self._last.in_contact
        self.out += np.bincount(self._since[out], minlength=self.out.size)
        self.returned += np.bincount(self._since[out & state.in_contact], minlength=self.out.size)
        if len(self._contacts) > 1:
            was_out = ~self._contacts[-2]
            self.two_step.append(float(np.mean(was_out & state.in_contact)))
            self.composed.append(composed_inflow(was_out, before, state, unit=unit))
        # Those never in contact stay at 0; the others count the steps from the one that took them out.
        left = before.in_contact & ~state.in_contact
        self._since[(self._since > 0) & ~state.in_contact] += 1
        self._since[state.in_contact] = 0
        self._since[left] = 1
        self._ever_left |= left
        self._contacts.append(state.in_contact)
        self._last = state

    @property
    def crossed(self) -> float:
        """Share of the contact at the end that had left it at least once."""
        return _share(self._ever_left, self._contacts[-1])

    @property
    def out_at(self) -> NDArray[np.float64]:
        """Share of the contact at the end that was out of contact in each state."""
        return np.array([_share(~contact, self._contacts[-1]) for contact in self._contacts])


def _share(flags: NDArray[np.bool_], among: NDArray[np.bool_]) -> float:
    return float(np.mean(flags[among])) if among.any() else float("nan")


def composed_inflow(was_out: NDArray[np.bool_], before: Pressed, after: Pressed, *, unit: float) -> float:
    """Share of the nominal area that comes in over two steps, if the second knows the state before it alone.

    `was_out` are the points out of contact before the first step. The law of the second is the chance of a
    point in contact to stay, by the bin of its pressure over `unit` [Pa], and that of a point out of
    contact to enter.
    """
    touching = before.in_contact
    binned = partial(np.bincount, bins_of(before.pressure[touching] / unit), minlength=BINS)
    stayed, came = binned(after.in_contact[touching]), binned(was_out[touching])
    by_contact = float(np.sum(came * stayed / np.maximum(binned(), 1)))
    out, entered, still_out = (
        np.count_nonzero(points & ~touching) for points in (~touching, after.in_contact, was_out)
    )
    return (by_contact + still_out * entered / (out or 1)) / was_out.size
