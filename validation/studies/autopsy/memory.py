"""Whether the flow over p = 0 forgets: what a point's past says about its return to contact."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from validation.studies.autopsy.books import BINS, Pressed, bins_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Memory", "composed_inflow"]


class Memory:
    """What became of every point along a chain of steps, told one state after the other.

    Attributes
    ----------
    out, returned : (steps,) arrays
        Points that were out of contact when a step began, and those of them that it brought back, by the number of steps since
        they had left; index 0 is those that were never in contact.
    two_step, composed : lists of float
        Share of the nominal area that was out before two steps and in contact after, and the same by the laws of single steps.
    """

    def __init__(self, first: Pressed, *, steps: int) -> None:
        self.out, self.returned = np.zeros(steps + 1), np.zeros(steps + 1)
        self.two_step: list[float] = []
        self.composed: list[float] = []
        self._since = np.zeros(first.in_contact.shape, dtype=np.int16)
        self._ever_left = np.zeros(first.in_contact.shape, dtype=bool)
        self._contacts = [first.in_contact]
        self._last = (first, first)

    def add(self, state: Pressed, *, unit: float) -> None:
        """Tell the state after the next step; `unit` is sqrt(V) [Pa] before that step."""
        earlier, before = self._last
        out = ~before.in_contact
        size = self.out.size
        self.out += np.bincount(self._since[out], minlength=size)
        self.returned += np.bincount(self._since[out & state.in_contact], minlength=size)
        if len(self._contacts) > 1:
            was_out = ~earlier.in_contact
            self.two_step.append(float(np.mean(was_out & state.in_contact)))
            self.composed.append(composed_inflow(was_out, before, state, unit=unit))
        # Those never in contact stay at 0; the others count the steps from the one that took them out.
        left = before.in_contact & ~state.in_contact
        self._since[(self._since > 0) & ~state.in_contact] += 1
        self._since[state.in_contact] = 0
        self._since[left] = 1
        self._ever_left |= left
        self._contacts.append(state.in_contact)
        self._last = (before, state)

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
    """Share of the nominal area that comes in over two steps, if the second step knows no more than the state before it.

    Parameters
    ----------
    was_out : array of bool
        Points that were out of contact before the first step.
    before, after : Pressed
        States before and after the second step. Its law is the chance of a point in contact to stay, by its pressure, and that of a
        point out of contact to enter.
    unit : float
        Unit of pressure [Pa] of the bins.
    """
    touching = before.in_contact
    where = bins_of(before.pressure[touching] / unit)
    points = np.bincount(where, minlength=BINS)
    stayed = np.bincount(where, weights=after.in_contact[touching], minlength=BINS)
    came = np.bincount(where, weights=was_out[touching], minlength=BINS)
    by_contact = float(np.sum(came * stayed / np.maximum(points, 1)))
    out = np.count_nonzero(~touching)
    entered = np.count_nonzero(after.in_contact & ~touching)
    still_out = np.count_nonzero(was_out & ~touching)
    by_gap = still_out * entered / out if out else 0.0
    return (by_contact + by_gap) / was_out.size
