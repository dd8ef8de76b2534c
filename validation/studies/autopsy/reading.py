"""What the books say: limits over grids, octave by octave, with the scatter between surfaces.

Every function takes the dataset of the study and returns arrays over its own dimensions; "surface" is always kept, so that means
and intervals are taken last.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.stats

from persson import elastic
from validation.arrays import Array

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "TERMS",
    "Spread",
    "area_book",
    "at_share",
    "edge_book",
    "exponents",
    "flux",
    "limit",
    "loss_ratio",
    "net_flux",
    "over_persson",
    "persson_area",
    "profiles",
    "restarts",
    "returns",
    "square_book",
    "two_steps",
    "within",
]

#: Terms of the book of the mean square: words, and how each is made of what is stored.
TERMS: dict[str, tuple[str, str, float]] = {
    "diffusion": ("D", "spread", 1.0),
    "drift": ("2 <mu p>", "crossed", 2.0),
    "re_entry": ("re-entry", "entered_square", 1.0),
}


@dataclass(frozen=True, kw_only=True)
class Spread:
    """Mean over surfaces of numbers that have other dimensions, and the half width of Student's 95 % interval."""

    value: xr.DataArray
    half_width: xr.DataArray

    @classmethod
    def of(cls, values: xr.DataArray) -> Spread:
        """Take the mean over the surfaces, those of the chains or those of the probes."""
        (surface,) = {"surface", "probe_surface"} & set(values.dims)
        n = values.sizes[surface]
        factor = float(scipy.stats.t.ppf(0.975, n - 1)) / np.sqrt(n)
        return cls(value=values.mean(surface, skipna=False), half_width=factor * values.std(surface, ddof=1))


def limit(values: xr.DataArray, spacing: xr.DataArray) -> xr.DataArray:
    """Value at dx -> 0 of what is counted, by a straight line in dx through the two finest grids.

    Counting is off in first order of the spacing, as the counted area is.
    """
    (grid,) = spacing.dims
    coarse, fine = (spacing.isel({grid: k}) for k in (-2, -1))
    low, high = (values.isel({grid: k}) for k in (-2, -1))
    return high + (high - low) * fine / (coarse - fine)


def _ln(values: xr.DataArray) -> xr.DataArray:
    return values.copy(data=np.log(values.values))


def _along(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Something of every ring: its limit over the grids."""
    return limit(dataset[name], dataset.spacing)


def _levels(dataset: xr.Dataset, name: str) -> tuple[xr.DataArray, xr.DataArray]:
    """Something of the states before and after every ring."""
    values = dataset[name]
    last = values.sizes["level"]
    before, after = (
        values.isel(level=slice(*ends)).drop_vars("zeta", errors="ignore")
        for ends in ((0, last - 1), (1, last))
    )
    return before.rename(level="step"), after.rename(level="step")


def _octave_of(dataset: xr.Dataset) -> Array:
    """Return the number of the octave that every ring is in."""
    ends = np.asarray(dataset.attrs["octaves"], dtype=float)
    return np.asarray(np.searchsorted(ends, dataset.zeta.values[:-1] * (1 + 1e-9)) - 1)


def _by_octave(dataset: xr.Dataset, values: xr.DataArray) -> xr.DataArray:
    """Sum over the rings of each octave."""
    import xarray as xr

    number = _octave_of(dataset)
    parts = [values.isel(step=np.flatnonzero(number == k)).sum("step") for k in range(int(number.max()) + 1)]
    return xr.concat(parts, dim="octave")


def square_book(dataset: xr.Dataset) -> xr.Dataset:
    """Mean square pressure by octave, over A dV: its change S, the terms, and what the binned D(p) and mu(p) make of it.

    Returns
    -------
    xarray.Dataset
        With dimensions (hurst, load, surface, octave): `change`, one variable for each of `TERMS`, `told` (the sum of the terms, drift
        and diffusivity taken as functions of p), `path` (the change of the surface that goes on, without that of the negative rings).
    """
    import xarray as xr

    before, after = _levels(dataset, "variance")
    own, other = _levels(dataset, "area")
    scale = before.isel(grid=-1)
    area = 0.5 * (own.isel(sign=0) + other.mean("sign"))
    unit = _by_octave(dataset, area * (after - before).isel(grid=-1))

    def over_unit(values: xr.DataArray) -> xr.DataArray:
        return _by_octave(dataset, values * scale) / unit

    found = {"change": over_unit(_along(dataset, "square_change"))}
    found |= {name: over_unit(sign * _along(dataset, of)) for name, (_, of, sign) in TERMS.items()}
    touching = dataset.touching.where(dataset.touching > 0)
    crossed = (dataset.pressure * dataset.drifted / touching).sum("bin")
    told = dataset.diffused_square.sum("bin") + 2 * crossed + dataset.entered_square
    found["told"] = over_unit(limit(told, dataset.spacing))
    square = limit(dataset.square * dataset.variance, dataset.spacing)
    first, last = _levels(dataset.assign(total=square), "total")
    found["path"] = _by_octave(dataset, last - first) / unit
    return xr.Dataset(found)


def area_book(dataset: xr.Dataset) -> xr.Dataset:
    """Return d ln A / d ln V by octave: located, counted as entering less leaving area, and Persson's."""
    import xarray as xr

    before, after = _levels(dataset, "area")
    own = before.isel(sign=0)
    variance = [part.isel(grid=-1) for part in _levels(dataset, "variance")]
    steps = _by_octave(dataset, _ln(variance[1] / variance[0]))
    theory = [_erf(dataset.nominal.isel(grid=-1) / np.sqrt(part)) for part in variance]
    net = _along(dataset, "entered") - _along(dataset, "lost")
    return xr.Dataset(
        {
            "located": _by_octave(dataset, _ln(after.mean("sign") / own)) / steps,
            "counted": _by_octave(dataset, _ln(1 + net / own)) / steps,
            "persson": _by_octave(dataset, _ln(theory[1] / theory[0])) / steps,
        }
    )


def _erf(ratio: xr.DataArray) -> xr.DataArray:
    flat = elastic.contact_area(ratio.values.ravel(), stress_variance=1.0)
    return ratio.copy(data=np.asarray(flat).reshape(ratio.shape))


def persson_area(dataset: xr.Dataset) -> xr.DataArray:
    """A/A0 of the theory at every magnification, told the realised V."""
    return _erf(dataset.nominal.isel(grid=-1) / np.sqrt(dataset.variance.isel(grid=-1)))


def over_persson(dataset: xr.Dataset) -> xr.DataArray:
    """Return the simulated area (limit) over that of the theory at every magnification."""
    ratio: xr.DataArray = dataset.area.isel(sign=0) / persson_area(dataset)
    return ratio


def at_share(dataset: xr.Dataset, share: float) -> xr.DataArray:
    """Mean area over Persson's where his own has a value, (hurst, load); NaN where it never has."""
    ratio = over_persson(dataset).mean("surface").transpose("hurst", "load", "level")
    own = persson_area(dataset).mean("surface").transpose("hurst", "load", "level")
    found = np.full(ratio.shape[:2], np.nan)
    for case in np.ndindex(found.shape):
        # His area falls along zeta.
        falling, values = own.values[case][::-1], ratio.values[case][::-1]
        found[case] = np.interp(share, falling, values, left=np.nan, right=np.nan)
    return ratio.isel(level=0).copy(data=found)


def restarts(dataset: xr.Dataset) -> xr.DataArray:
    """Area of absorbing diffusion started from the truth over the true area, (restart, level); 1 where it starts."""
    import xarray as xr

    ratios: list[xr.DataArray] = []
    for row, zeta in enumerate(dataset.restart_zeta.values):
        start = int(np.argmin(np.abs(dataset.zeta.values - zeta)))
        diffused = dataset.diffused.isel(restart=row)
        share = limit(diffused / diffused.isel(level=start), dataset.spacing)
        area = dataset.area.isel(sign=0)
        ratios.append(share / (area / area.isel(level=start)))
    return xr.concat(ratios, dim="restart")


def loss_ratio(dataset: xr.Dataset) -> xr.DataArray:
    """How much faster restarted diffusion loses area than the truth, ln against ln, over half an octave: (restart)."""
    import xarray as xr

    found: list[xr.DataArray] = []
    ratio, area = restarts(dataset), dataset.area.isel(sign=0)
    for row, zeta in enumerate(dataset.restart_zeta.values):
        start, end = (int(np.argmin(np.abs(dataset.zeta.values - z))) for z in (zeta, zeta * 2**0.5))
        true = _ln(area.isel(level=end) / area.isel(level=start))
        found.append(1 + _ln(ratio.isel(restart=row, level=end)) / true.where(true < -_NO_LOSS))
    return xr.concat(found, dim="restart")


#: A relative change of the area too small to be compared with another.
_NO_LOSS = 1e-3


def flux(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Something that the probes counted over the contact area before the ring, limit over grids: (probe, variance_step)."""
    area = dataset.probe_area.isel(sign=0, probe_level=0)
    share: xr.DataArray = _probed(dataset, dataset[f"probe_{name}"]) / area
    return share


def _probed(dataset: xr.Dataset, values: xr.DataArray) -> xr.DataArray:
    """Limit over grids at every probe, each of which has its own."""
    import xarray as xr

    spacing = dataset.probe_spacing
    parts = [limit(values.isel(probe=z), spacing.isel(probe=z)) for z in range(spacing.sizes["probe"])]
    return xr.concat(parts, dim="probe")


def exponents(values: xr.DataArray, steps: Array) -> xr.DataArray:
    """Exponent of Delta V between neighbouring steps, and over all of them (last): (..., pair)."""
    import xarray as xr

    logarithm = _ln(values.where(values > 0))
    pairs = [*itertools.pairwise(range(steps.size)), (0, steps.size - 1)]
    found: list[xr.DataArray] = [
        (logarithm.isel(variance_step=b) - logarithm.isel(variance_step=a)) / np.log(steps[b] / steps[a])
        for a, b in pairs
    ]
    return xr.concat(found, dim="pair")


def net_flux(dataset: xr.Dataset) -> xr.DataArray:
    """D ln A / d ln V of every probe and step, from the located area: (probe, variance_step)."""
    area = dataset.probe_area
    after = area.isel(probe_level=slice(1, None)).mean("sign").rename(probe_level="variance_step")
    return _ln(after / area.isel(sign=0, probe_level=0)) / _ln(1 + dataset.relative_step)


def edge_book(dataset: xr.Dataset) -> dict[str, Spread]:
    """Return -d ln A / d ln V at every probe: the truth, and what Eq. 26 makes of the true slope and of Persson's, V P'(0) / 2 A.

    The truth is that of the largest step, which is the surest; its limit is not told from it.
    """
    area = Spread.of(dataset.probe_area.isel(sign=0, probe_level=0))
    # Of every surface the same, since p* counts in its own gradient.
    nominal = dataset.probe_nominal.isel(probe_grid=-1).mean("probe_surface")
    own = elastic.initial_slope(nominal.values.ravel(), stress_variance=1.0)
    persson = 0.5 * nominal.copy(data=np.asarray(own).reshape(nominal.shape))
    flow = dataset.slope * persson / area.value
    width = flow * np.hypot(dataset.slope_half_width / dataset.slope, area.half_width / area.value)
    theory = persson / _erf(nominal)
    return {
        "true": Spread.of(-net_flux(dataset).isel(variance_step=-1)),
        "of the true slope": Spread(value=flow, half_width=width),
        "Persson": Spread(value=theory, half_width=0.0 * theory),
    }


def profiles(
    dataset: xr.Dataset, *, probe: int, step: int
) -> tuple[xr.DataArray, xr.DataArray, xr.DataArray]:
    """Mean pressure [sqrt V], drift [Delta V / sqrt V] and diffusivity [Delta V] by pressure, surfaces pooled, on the finest grid."""
    at = dataset.isel(probe=probe, variance_step=step, probe_grid=-1)
    relative = float(dataset.relative_step[step])
    names = ("touching", "pressure", "drifted", "diffused_square")
    points, pressure, drift, square = (at[f"probe_{name}"].sum("probe_surface") for name in names)
    points = points.where(points > 0)
    return pressure / points, drift / points / relative, square / points / relative


def within(dataset: xr.Dataset, low: float, high: float) -> tuple[Spread, Spread]:
    """Drift and diffusivity between two pressures [sqrt V] on the finest grid: (hurst, load, probe, variance_step)."""
    lower = np.concatenate([[0.0], dataset.upper.values[:-1]])
    keep = np.flatnonzero((lower >= low * (1 - 1e-9)) & (dataset.upper.values <= high * (1 + 1e-9)))
    at = dataset.isel(probe_grid=-1, bin=keep)
    names = ("touching", "drifted", "diffused_square")
    points, drift, square = (at[f"probe_{name}"].sum("bin") for name in names)
    points = points.where(points > 0) * dataset.relative_step
    return Spread.of(drift / points), Spread.of(square / points)


def two_steps(dataset: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Inflow over two rings over the area before them, mean over the pairs of rings: true, and composed of single steps."""
    at = dataset.isel(grid=-1)
    area = dataset.area.isel(sign=0)
    before = (
        area.isel(level=slice(0, area.sizes["level"] - 2))
        .drop_vars("zeta", errors="ignore")
        .rename(level="pair")
    )
    true, composed = ((at[name] / before).mean("pair") for name in ("two_step", "composed"))
    return true, composed


def returns(dataset: xr.Dataset) -> xr.DataArray:
    """Chance that a ring brings a point back into contact, by rings since it left (0: never in contact)."""
    at = dataset.isel(grid=-1)
    chance: xr.DataArray = at.returned / at.out_points.where(at.out_points > 0)
    return chance
