"""One surface pressed with its waves up to rising magnifications: patches, what joins up, what carries in the end."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.contact import ContactResult
from fem_contact.patches import find_patches
from validation.measures.flow import contact_is_apart, gap_is_open, located_area
from validation.measures.measurement import without_waves_beyond
from validation.measures.single_solve import SingleSolve, Takes

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["QUANTITIES", "Magnified"]

#: What is read off every state: meaning.
QUANTITIES = {
    "area": "A/A0, edge located inside the cells",
    "patches": "contact patches on an area of the longest wave squared",
    "patch_size": "mean patch size, sum A_i^2 / sum A_i, over the longest wave squared",
    "largest": "largest patch over the contact area",
    "area_inside": "share of the contact with all waves that lies in the contact seen here",
    "load_inside": "share of the load that it carries",
}
#: Both thresholds: what joins up, and whether it does so below or above.
_THRESHOLDS = ("contact", "gap")
#: Located area, and magnification, up to which a threshold is bracketed.
_AREA, _ZETA = 2e-3, 1.002


@dataclass(frozen=True, kw_only=True)
class Magnified(SingleSolve):
    """One surface at given loads, with its waves up to each magnification.

    Attributes
    ----------
    realised : Realised
        Surface and solid; its longest wave is that of zeta = 1.
    grid : tuple of int
    reduced_pressures : tuple of float
        p* with the gradient of all waves.
    magnifications : tuple of float
        zeta = q/q_long of the last wave there is, rising.
    percolating : tuple of float
        p* at which the magnifications are sought where contact and gap join up.
    """

    kind, words = "magnified", "magnified"
    located, version = True, 1
    takes = Takes(seconds=2e-3, each_point=8e-7, bytes=500)

    reduced_pressures: tuple[float, ...]
    magnifications: tuple[float, ...]
    percolating: tuple[float, ...] = ()

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers; the loads are its own."""
        return {name: value for name, value in super().recipe.items() if name != "load"}

    @property
    def problems(self) -> int:
        """One for each load and magnification, some twenty for each pair of thresholds."""
        return len(self.reduced_pressures) * len(self.magnifications) + 20 * len(self.percolating)

    def measure(self) -> xr.Dataset:
        """Press everything and keep the numbers; dimensions (load, magnification) and (percolating, axis)."""
        import xarray as xr

        values = {name: np.empty(self.shape) for name in QUANTITIES}
        for j, load in enumerate(self.reduced_pressures):
            states = _States(self, load)
            last = states.at(self.magnifications[-1])
            for i in reversed(range(len(self.magnifications))):
                for name, value in self._read_off(states.at(self.magnifications[i]), last).items():
                    values[name][j, i] = value
        found = np.array([self._thresholds(load) for load in self.percolating]).reshape(-1, 2, 2, 2)
        data: dict[str, Any] = {name: (("load", "magnification"), values[name]) for name in QUANTITIES}
        for i, name in enumerate(_THRESHOLDS):
            data[f"{name}_threshold"] = (("percolating", "axis"), found[:, :, i, 0])
            data[f"{name}_zeta"] = (("percolating", "axis"), found[:, :, i, 1])
        whole, q_long = self.realised.field, 2 * np.pi / self.realised.longest
        gradients = [without_waves_beyond(whole, z * q_long).rms_gradient for z in self.magnifications]
        data["gradient"] = ("magnification", np.array(gradients) / whole.rms_gradient)
        return xr.Dataset(data, coords={"axis": ["x", "y"]})

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of loads and of magnifications."""
        return len(self.reduced_pressures), len(self.magnifications)

    def _read_off(self, state: ContactResult, last: ContactResult) -> dict[str, float]:
        """Return every one of `QUANTITIES` of one state; `last` has all waves."""
        patches, unit = find_patches(state.in_contact, state.spacing), self.realised.longest**2
        nominal = state.lengths[0] * state.lengths[1]
        inside = last.in_contact & state.in_contact
        return {
            "area": located_area(state),
            "patches": patches.count * unit / nominal,
            "patch_size": patches.mean_size / unit,
            "largest": float(patches.areas.max() / patches.areas.sum()),
            "area_inside": float(inside.sum() / last.in_contact.sum()),
            "load_inside": float(last.pressure[inside].sum() / last.pressure.sum()),
        }

    def _thresholds(self, load: float) -> list[list[tuple[float, float]]]:
        """For each axis: located area and magnification at which the contact comes apart, and the gap opens."""
        states = _States(self, load)
        ends = self.magnifications[0], self.magnifications[-1]
        return [
            [states.threshold(contact_is_apart(axis), ends), states.threshold(gap_is_open(axis), ends)]
            for axis in ("x", "y")
        ]


class _States:
    """One surface under one load, with more or fewer of its waves."""

    def __init__(self, asked: Magnified, load: float) -> None:
        self.asked, self.load = asked, load
        self.whole = asked.heights()
        self.known: dict[float, ContactResult] = {}

    def at(self, zeta: float) -> ContactResult:
        """Solve with the waves up to q = zeta q_long, from the nearest state that is known."""
        from fem_contact import bem

        if zeta not in self.known:
            near = min(self.known, key=lambda other: abs(np.log(other / zeta)), default=None)
            realised = self.asked.realised
            solved = bem.solve(
                without_waves_beyond(self.whole, zeta * 2 * np.pi / realised.longest),
                self.asked.half_space,
                mean_pressure=self.load * realised.pressure_scale,
                start=None if near is None else self.known[near].pressure,
                threads=1,
            )
            self.known[zeta] = solved.checked()
        return self.known[zeta]

    def threshold(
        self, passed: Callable[[ContactResult], bool], ends: Sequence[float]
    ) -> tuple[float, float]:
        """Return located area and magnification where something is passed; NaN where not between the ends."""
        low, high = ends
        if passed(self.at(low)) or not passed(self.at(high)):
            return np.nan, np.nan
        while located_area(self.at(low)) - located_area(self.at(high)) > _AREA and high / low > _ZETA:
            middle = float(np.sqrt(low * high))
            low, high = (low, middle) if passed(self.at(middle)) else (middle, high)
        return (located_area(self.at(low)) + located_area(self.at(high))) / 2, float(np.sqrt(low * high))
