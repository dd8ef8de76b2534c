"""Limits in what a grid does not refine: kappa as the sample grows, and as the bandwidth of the roughness grows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.special
from numpy.typing import ArrayLike, NDArray

from validation.errors import RunFailed
from validation.measures.common import SHIFTS, base_case, base_surface, named
from validation.measures.measurement import Measurement, area_limits, grid_for, grid_tolerance
from validation.measures.statistics import combined, mean_over_surfaces, pair_means
from validation.scenes.realised import Realised

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "LADDERS",
    "SIZE_ORDER",
    "Ladders",
    "Rungs",
    "bandwidth_order",
    "rungs_limit",
    "rungs_of",
    "spectral_share",
    "usual_ladders",
]

#: Order in lambda_long/L: the number of long waves on a period grows like (L/lambda_long)^2, and corrections to the
#: mean of anything that depends on them fall with that number.
SIZE_ORDER = 2.0

#: A limit further from the last rung than this many times the span of all rungs is not determinable.
_REACH = 2.0


def bandwidth_order(hurst: float) -> float:
    """Order in lambda_short/lambda_long: 2 (1 - H).

    The long waves matter by their share in the mean square gradient, and an octave at lambda_long carries a share that
    falls like (lambda_short/lambda_long)^(2 (1 - H)) as shorter waves are added.

    Examples
    --------
    >>> round(bandwidth_order(0.8), 12)
    0.4
    """
    return 2 * (1 - hurst)


@dataclass(frozen=True, kw_only=True)
class Rungs:
    """A straight line in step^order through the rungs of a ladder.

    Attributes
    ----------
    limit : float
        Value at step -> 0.
    half_width : float
        Of its 95 % interval: scatter of the samples, and by how much it moves without the coarsest rung.
    slope, slope_half_width : float
        Of the line against step^order.
    order : float
    reach : float
        Distance of the limit from the finest rung, over the span of all rungs, along step^order.
    """

    limit: float
    half_width: float
    slope: float
    slope_half_width: float
    order: float
    reach: float

    @property
    def determinable(self) -> bool:
        """Whether the rungs come near enough to their limit."""
        return self.reach <= _REACH

    def shift(self, step: float) -> float:
        """By how much the value at a step exceeds the limit."""
        return float(self.slope * step**self.order)

    def shift_half_width(self, step: float) -> float:
        """Half of the 95 % interval of `shift`."""
        return float(self.slope_half_width * step**self.order)


def rungs_limit(
    rungs: Sequence[ArrayLike], steps: Sequence[float], *, order: float, common: bool = False
) -> Rungs:
    """Extrapolate the rungs of a ladder with a fixed order.

    Parameters
    ----------
    rungs : sequence of (n_i,) arrays
        Independent samples on each rung.
    steps : sequence of float
        What goes to zero, falling.
    order : float
        Fixed: an order fitted to a few rungs would make any limit possible.
    common : bool
        Whether sample k is the same surface on every rung, whose scatter then cancels in differences.

    Examples
    --------
    >>> found = rungs_limit([[2.4, 2.6], [2.2, 2.4], [2.1, 2.3]], (0.4, 0.2, 0.1), order=1.0, common=True)
    >>> round(found.limit, 12), round(found.slope, 12)
    (2.1, 1.0)
    """
    samples = [np.asarray(rung, dtype=float) for rung in rungs]
    x = np.asarray(steps, dtype=float) ** order
    line = _line(samples, x, common=common)
    (limit, slope), (limit_error, slope_error) = line
    drift = slope_drift = 0.0
    if x.size > 2:
        (shorter_limit, shorter_slope), _ = _line(samples[1:], x[1:], common=common)
        drift, slope_drift = abs(shorter_limit - limit), abs(shorter_slope - slope)
    return Rungs(
        limit=limit,
        half_width=combined(limit_error, drift),
        slope=slope,
        slope_half_width=combined(slope_error, slope_drift),
        order=order,
        reach=float(x[-1] / (x[0] - x[-1])),
    )


def _line(
    samples: Sequence[NDArray[np.float64]], x: NDArray[np.float64], *, common: bool
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Intercept and slope, and the half widths of their 95 % intervals."""
    errors = np.array([rung.std(ddof=1) / np.sqrt(rung.size) for rung in samples])
    # Rungs of common surfaces scatter together: there equal weights lose nothing.
    weight = np.ones_like(x) if common else 1 / np.maximum(errors, 1e-3 * errors.max() + 1e-300)
    solve = np.linalg.pinv(np.stack([np.ones_like(x), x], axis=1) * weight[:, None]) * weight
    values = solve @ np.array([rung.mean() for rung in samples])
    freedom = min(rung.size for rung in samples) - 1
    factor = float(scipy.special.stdtrit(freedom, 0.975))
    if common:
        spread = (solve @ np.stack(samples)).std(axis=1, ddof=1) / np.sqrt(samples[0].size)
    else:
        spread = np.sqrt(solve**2 @ errors**2)
    return (float(values[0]), float(values[1])), (float(factor * spread[0]), float(factor * spread[1]))


#: What goes to zero along each ladder.
LADDERS = {"bandwidth": "lambda_short / lambda_long", "size": "lambda_long / L"}

#: A rung: which ladder, H, and the step.
_Rung = tuple[str, float, float]


@dataclass(frozen=True, kw_only=True)
class Ladders:
    """Which spectra are measured.

    Attributes
    ----------
    hursts : tuple of float
    bandwidths : tuple of float
        lambda_long/lambda_short of the bandwidth ladder, rising, on `periods`.
    sizes : tuple of float
        L/lambda_long of the size ladder, rising, with the smallest of `bandwidths`.
    periods : float
        L/lambda_long of the bandwidth ladder.
    pairs : int
        Pairs +h, -h on the rungs of the bandwidth ladder and on the largest sample; smaller samples get more of them,
        so that each rung covers the same area.
    reduced_pressure : float
    points_per_wave : tuple of float
    shifts : int
    seed : int
    """

    hursts: tuple[float, ...]
    bandwidths: tuple[float, ...]
    sizes: tuple[float, ...]
    periods: float
    pairs: int
    reduced_pressure: float
    points_per_wave: tuple[float, ...]
    shifts: int = SHIFTS
    seed: int

    @property
    def cases(self) -> list[Measurement]:
        """All solves in order."""
        return [solve for solves in self.rungs.values() for solve in solves]

    @cached_property
    def rungs(self) -> Mapping[_Rung, tuple[Measurement, ...]]:
        """The solves of every rung, +h and -h of each pair after each other."""
        found: dict[_Rung, tuple[Measurement, ...]] = {}
        for hurst in self.hursts:
            for bandwidth in self.bandwidths:
                case = self._case(hurst, periods=self.periods, bandwidth=bandwidth)
                found["bandwidth", hurst, 1 / bandwidth] = self._pressed(case, self.pairs)
            for size in self.sizes:
                case = self._case(hurst, periods=size, bandwidth=self.bandwidths[0])
                pairs = max(2, round(self.pairs * (self.sizes[-1] / size) ** 2))
                found["size", hurst, 1 / size] = self._pressed(case, pairs)
        return found

    def _case(self, hurst: float, *, periods: float, bandwidth: float) -> Realised:
        surface = base_surface(hurst=hurst, periods=periods, bandwidth=bandwidth, seed=self.seed)
        return base_case(surface, reduced_pressure=self.reduced_pressure)

    def _pressed(self, case: Realised, pairs: int) -> tuple[Measurement, ...]:
        grids = tuple(grid_for(case, points) for points in self.points_per_wave)
        return tuple(
            Measurement(
                realised=replace(case.further(pair), inverted=inverted),
                grids=grids,
                shifts=self.shifts,
                tolerance=grid_tolerance(case, grids),
            )
            for pair in range(pairs)
            for inverted in (False, True)
        )

    def dataset(self, solved: Mapping[Any, xr.Dataset]) -> xr.Dataset:
        """Reduce the results of `cases`, by solve: kappa on every rung, and the line through the rungs.

        Raises
        ------
        RunFailed
            For contacts too small for a limit of their area.
        """
        import xarray as xr

        kappas = {
            rung: self._kappas(rung, [solved[s] for s in solves]) for rung, solves in self.rungs.items()
        }
        data: dict[str, Any] = {}
        for kind in self._steps:
            rows = [self._line(kind, hurst, kappas) for hurst in self.hursts]
            for name in rows[0]:
                dims = ("ladder", f"{kind}_rung") if name in ("kappa", "half_width") else ("ladder",)
                data[f"{kind}_{name}"] = (dims, np.array([row[name] for row in rows]))
        nayak = [
            [self._case(h, periods=self.periods, bandwidth=b).field.nayak for b in self.bandwidths]
            for h in self.hursts
        ]
        data["bandwidth_nayak"] = named(
            ("ladder", "bandwidth_rung"),
            np.array(nayak).reshape(len(self.hursts), len(self.bandwidths)),
            "Nayak parameter of the realised surfaces",
        )
        steps_of = {f"{kind}_step": (f"{kind}_rung", steps) for kind, steps in self._steps.items()}
        return xr.Dataset(data, coords={"ladder_hurst": ("ladder", list(self.hursts)), **steps_of})

    @property
    def _steps(self) -> dict[str, list[float]]:
        return {"bandwidth": [1 / b for b in self.bandwidths], "size": [1 / s for s in self.sizes]}

    def _kappas(self, rung: _Rung, measured: Sequence[xr.Dataset]) -> tuple[NDArray[np.float64], float]:
        """Kappa of each pair on one rung, and the 95 % half width that the grids leave on their mean."""
        limits = [area_limits(data) for data in measured]
        if not np.all(np.isfinite([value for value, _ in limits])):
            raise RunFailed(
                f"ladder of {LADDERS[rung[0]]}: contacts are too small for a limit of their area: raise the load or "
                "the points per wave of the ladder; all solves are stored"
            )
        kappa = pair_means([float(value[0]) / self.reduced_pressure for value, _ in limits])
        squares = [float(error[0]) ** 2 / self.reduced_pressure**2 for _, error in limits]
        return kappa, 2 * float(np.sqrt(np.mean(squares) / len(squares)))

    def _line(
        self, kind: str, hurst: float, kappas: Mapping[_Rung, tuple[NDArray[np.float64], float]]
    ) -> dict[str, Any]:
        """Means on the rungs of one ladder, and the line through them."""
        steps = self._steps[kind]
        samples = [kappas[kind, hurst, step][0] for step in steps]
        common = kind == "bandwidth"
        order = bandwidth_order(hurst) if common else SIZE_ORDER
        line = rungs_limit(samples, steps, order=order, common=common)
        grid = max(kappas[kind, hurst, step][1] for step in steps)
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


def usual_ladders(*, hurst: float, periods: float, reduced_pressure: float, seed: int) -> Ladders:
    """Return the ladders of one Hurst exponent as `hurst` climbs them by default, whose stored solves they then share."""
    return Ladders(
        hursts=(hurst,),
        bandwidths=(4.0, 8.0, 16.0, 32.0),
        sizes=(2.0, 4.0, 8.0),
        periods=periods,
        pairs=4,
        reduced_pressure=reduced_pressure,
        points_per_wave=(4.0, 6.0),
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
