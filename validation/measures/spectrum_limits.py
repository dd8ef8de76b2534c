"""kappa as the sample grows and as the bandwidth grows: the ladders of the study `hurst`, as solves and as numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.errors import RunFailed
from validation.measures.common import base_surface
from validation.measures.ladders import SIZE_ORDER, Rungs, bandwidth_order, rungs_limit
from validation.measures.measurement import Measurement, area_limits, grid_for
from validation.measures.statistics import combined, mean_over_surfaces, pair_means
from validation.scenes.scene import SolidSpec
from validation.scenes.surfaces import reference_field

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["LADDERS", "Ladders", "rungs_of", "spectral_share", "usual_ladders"]

#: What goes to zero along each ladder.
LADDERS = {"bandwidth": "lambda_short / lambda_long", "size": "lambda_long / L"}


@dataclass(frozen=True, kw_only=True)
class Ladders:
    """Which spectra are measured.

    Attributes
    ----------
    hursts : tuple of float
    ratios : tuple of float
        lambda_long/lambda_short of the bandwidth ladder, rising, on `size`.
    sizes : tuple of float
        L/lambda_long of the size ladder, rising, with the smallest of `ratios`.
    size : float
        L/lambda_long of the bandwidth ladder.
    pairs : int
        Pairs +h, -h on the rungs of the bandwidth ladder and on the largest sample; smaller samples get more of them,
        so that each rung covers the same area.
    reduced_pressure : float
    points_per_wave : tuple of float
    shifts : int
    solid : SolidSpec
    seed : int
    """

    hursts: tuple[float, ...]
    ratios: tuple[float, ...]
    sizes: tuple[float, ...]
    size: float
    pairs: int
    reduced_pressure: float
    points_per_wave: tuple[float, ...]
    shifts: int
    solid: SolidSpec
    seed: int
    solves: tuple[tuple[tuple[str, float, float], tuple[Measurement, ...]], ...] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "solves", tuple(self._jobs()))

    @property
    def cases(self) -> list[Measurement]:
        """All solves in order."""
        return [solve for _, solves in self.solves for solve in solves]

    def _jobs(self) -> Iterator[tuple[tuple[str, float, float], tuple[Measurement, ...]]]:
        for hurst in self.hursts:
            for ratio in self.ratios:
                yield ("bandwidth", hurst, 1 / ratio), self._rung(hurst, self.size, ratio, self.pairs)
            for size in self.sizes:
                pairs = max(2, round(self.pairs * (self.sizes[-1] / size) ** 2))
                yield ("size", hurst, 1 / size), self._rung(hurst, size, self.ratios[0], pairs)

    def _rung(self, hurst: float, size: float, ratio: float, pairs: int) -> tuple[Measurement, ...]:
        surface = base_surface(hurst=hurst, size=size, ratio=ratio, seed=self.seed)
        return tuple(
            Measurement(
                surface=surface,
                realisation=pair,
                inverted=inverted,
                solid=self.solid,
                reduced_pressures=(self.reduced_pressure,),
                grids=tuple(grid_for(surface, points) for points in self.points_per_wave),
                shifts=self.shifts,
            )
            for pair in range(pairs)
            for inverted in (False, True)
        )

    def dataset(self, measured: Sequence[xr.Dataset]) -> xr.Dataset:
        """Reduce the results of `cases`: kappa on every rung, and the line through the rungs."""
        import xarray as xr

        waiting, values, errors = iter(measured), {}, {}
        for key, solves in self.solves:
            limits = [area_limits(next(waiting)) for _ in solves]
            if not np.all(np.isfinite([value for value, _ in limits])):
                raise RunFailed(
                    f"ladder of {LADDERS[key[0]]}: contacts are too small for a limit of their area: raise the load or "
                    "the points per wave of the ladder; all solves are stored"
                )
            values[key] = pair_means([float(value[0]) / self.reduced_pressure for value, _ in limits])
            squares = [float(error[0]) ** 2 / self.reduced_pressure**2 for _, error in limits]
            errors[key] = 2 * float(np.sqrt(np.mean(squares) / len(squares)))
        data: dict[str, Any] = {}
        for kind in LADDERS:
            steps = [1 / step for step in (self.ratios if kind == "bandwidth" else self.sizes)]
            rows = [self._rows(kind, hurst, steps, values, errors) for hurst in self.hursts]
            for name in rows[0]:
                dims = ("ladder", f"{kind}_rung") if name in ("kappa", "half_width") else ("ladder",)
                data[f"{kind}_{name}"] = (dims, np.array([row[name] for row in rows]))
        nayak = [[self._nayak(hurst, ratio) for ratio in self.ratios] for hurst in self.hursts]
        data["bandwidth_nayak"] = (
            ("ladder", "bandwidth_rung"),
            np.array(nayak).reshape(len(self.hursts), len(self.ratios)),
            {"long_name": "Nayak parameter of the realised surfaces"},
        )
        return xr.Dataset(
            data,
            coords={
                "ladder_hurst": ("ladder", list(self.hursts)),
                "bandwidth_step": ("bandwidth_rung", [1 / r for r in self.ratios]),
                "size_step": ("size_rung", [1 / s for s in self.sizes]),
            },
        )

    def _nayak(self, hurst: float, ratio: float) -> float:
        surface = base_surface(hurst=hurst, size=self.size, ratio=ratio, seed=self.seed)
        return reference_field(surface).nayak

    @staticmethod
    def _rows(
        kind: str, hurst: float, steps: Sequence[float], values: dict[Any, Any], errors: dict[Any, float]
    ) -> dict[str, Any]:
        samples = [values[kind, hurst, step] for step in steps]
        common = kind == "bandwidth"
        order = bandwidth_order(hurst) if common else SIZE_ORDER
        line = rungs_limit(samples, steps, order=order, common=common)
        grid = max(errors[kind, hurst, step] for step in steps)
        means = [mean_over_surfaces(sample) for sample in samples]
        return {
            "kappa": [mean.value for mean in means],
            "half_width": [combined(mean.half_width, grid) for mean in means],
            "limit": line.limit,
            "limit_half_width": combined(line.half_width, grid),
            "slope": line.slope,
            "slope_half_width": line.slope_half_width,
            "order": order,
            "reach": line.reach,
        }


def rungs_of(dataset: xr.Dataset, kind: str, ladder: int) -> Rungs:
    """Return the line through one ladder, from the stored numbers."""
    words = ("limit", "slope", "slope_half_width", "order", "reach")
    numbers = {name: float(dataset[f"{kind}_{name}"][ladder]) for name in words}
    return Rungs(half_width=float(dataset[f"{kind}_limit_half_width"][ladder]), **numbers)


def usual_ladders(
    *, hurst: float, size: float, reduced_pressure: float, solid: SolidSpec, seed: int
) -> Ladders:
    """Return the ladders of one Hurst exponent as `hurst` climbs them by default, whose stored solves they then share."""
    return Ladders(
        hursts=(hurst,),
        ratios=(4.0, 8.0, 16.0, 32.0),
        sizes=(2.0, 4.0, 8.0),
        size=size,
        pairs=4,
        reduced_pressure=reduced_pressure,
        points_per_wave=(4.0, 6.0),
        shifts=2,
        solid=solid,
        seed=seed,
    )


def spectral_share(dataset: xr.Dataset, kind: str, *, hurst: float, step: float) -> float:
    """How far kappa at a step may be from its limit, relative: the shift along the ladder and its uncertainty.

    NaN where there is no such ladder, or where its limit is not determinable.
    """
    found = np.flatnonzero(np.isclose(dataset.ladder_hurst.values, hurst))
    if not found.size:
        return float("nan")
    line = rungs_of(dataset, kind, int(found[0]))
    if not line.determinable:
        return float("nan")
    return (abs(line.shift(step)) + line.shift_half_width(step)) / line.limit
