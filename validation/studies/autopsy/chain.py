"""One surface from its longest waves to all of them, ring by ring: every book of every step."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from persson import elastic
from validation.arrays import Array
from validation.studies.autopsy.books import Pressed, flows, mean_of, profile
from validation.studies.autopsy.memory import Memory
from validation.studies.autopsy.rings import RingSolve, areas_of, book_dataset, pressed

if TYPE_CHECKING:
    import xarray as xr

    from fem_contact.contact import ContactResult

__all__ = ["Chain", "diffused_area"]


def diffused_area(state: Pressed, added: Array) -> Array:
    r"""Contact area that absorbing diffusion makes of given pressures, over the nominal area.

    .. math:: \frac{A}{A_0} = \frac{1}{N} \sum_\text{contact} \operatorname{erf}\frac{p}{\sqrt{2 \Delta V}}

    The equation is linear: a point with pressure p before is a surface under the nominal pressure p, whose waves so far are none
    (Persson 2006, Eqs. 17, 19 and 20).

    Parameters
    ----------
    state : Pressed
        The truth at which the diffusion starts.
    added : (n,) array
        Delta V [Pa^2], positive.
    """
    pressure = state.pressure[state.in_contact]
    pressure = pressure[pressure > 0]
    sums = [np.sum(elastic.contact_area(pressure, stress_variance=float(v))) for v in added]
    return np.asarray(np.array(sums) / state.pressure.size)


@dataclass(frozen=True, kw_only=True)
class Chain(RingSolve):
    """A surface pressed with its waves up to rising magnifications, each ring with both signs.

    Attributes
    ----------
    ends : tuple of float
        Magnifications q/q_long at which the rings end, rising.
    restarts : tuple of float
        Those among them at which absorbing diffusion is started from the truth.
    """

    ends: tuple[float, ...]
    restarts: tuple[float, ...] = ()

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return {**super().recipe, "ends": list(self.ends), "restarts": list(self.restarts)}

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"rings-{self.points}"

    @property
    def solves(self) -> int:
        """Two for each ring."""
        return 2 * len(self.ends) - 1

    def states(self) -> Iterator[tuple[float, ContactResult, ContactResult]]:
        """Yield V [Pa^2], the result with the ring just added, and that with its negative, from coarse to fine."""
        heights, load = self.heights(0.0, self.ends[0]), self.realised.pressure
        state = self.press(heights, load=load)
        yield self.variance(heights), state, state
        for above, until in itertools.pairwise(self.ends):
            ring = self.heights(above, until)
            other = self.press(heights - ring, load=load, start=state.pressure)
            heights = heights + ring
            state = self.press(heights, load=load, start=state.pressure)
            yield self.variance(heights), state, other

    def measure(self) -> xr.Dataset:
        """Press everything and keep the books; dimensions (sign, level), (step), (step, bin), (restart, level)."""
        variance: list[float] = []
        areas: list[list[tuple[float, ...]]] = []
        square: list[float] = []
        sums: list[dict[str, Array]] = []
        bins: list[dict[str, Array]] = []
        starts: dict[float, tuple[float, Pressed]] = {}
        diffused = np.full((len(self.restarts), len(self.ends)), np.nan)
        before, memory = None, None
        for zeta, (v, result, other) in zip(self.ends, self.states(), strict=True):
            state = pressed(result)
            areas.append([areas_of(result), areas_of(other)])
            square.append(float(np.mean(state.pressure**2)) / v)
            if before is None or memory is None:
                memory = Memory(state, steps=len(self.ends))
            else:
                unit = float(np.sqrt(variance[-1]))
                pair = (state, pressed(other))
                sums.append(mean_of([flows(before, after, unit=unit) for after in pair]))
                bins.append(mean_of([profile(before, after, unit=unit) for after in pair]))
                memory.add(state, unit=unit)
            for row, (began, start) in enumerate(starts.values()):
                diffused[row, len(variance)] = diffused_area(start, np.array([v - began]))[0]
            if zeta in self.restarts:
                starts[zeta] = v, state
                diffused[len(starts) - 1, len(variance)] = areas[-1][0][0]
            before = state
            variance.append(v)
        assert memory is not None
        data: dict[str, Any] = {
            "variance": ("level", np.array(variance) / variance[-1]),
            "square": ("level", square),
            "diffused": (("restart", "level"), diffused),
            "two_step": ("pair", memory.two_step),
            "composed": ("pair", memory.composed),
            "out_points": ("age", memory.out),
            "returned": ("age", memory.returned),
            "out_at": ("level", memory.out_at),
            "crossed_once": ((), memory.crossed),
            "nominal": ((), self.realised.pressure / np.sqrt(variance[-1])),
        }
        return book_dataset(data, areas=areas, sums=sums, bins=bins)
