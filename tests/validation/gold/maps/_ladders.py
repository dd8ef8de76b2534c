"""Ladders of bandwidth and sample on the kit, with the errors they had: grids by two standard errors."""

from __future__ import annotations

import numpy as np
import xarray as xr

from gold.maps import Look
from gold.maps._estimates import Numbers
from validation.report.estimates import NORMAL

__all__ = ["LADDERS", "budget", "grid_two", "part"]


def part(name: str, source: str) -> Numbers:
    """Half of the 95 % interval by one source."""
    return lambda d: d[f"{name}_error"].sel(source=source, drop=True)


def grid_two(name: str) -> Numbers:
    """What grids leave on a mean, with two standard errors of the limits and not 1.96."""

    def found(d: xr.Dataset) -> xr.DataArray:
        errors = d[f"{name}_each_error"].sel(source="grid", drop=True) * 2 / NORMAL
        random = (errors**2).mean("surface") / errors.sizes["surface"]
        drift = d[f"{name}_each_drift"].mean("surface") if f"{name}_each_drift" in d else 0.0
        return (random + drift**2) ** 0.5

    return found


def budget(
    name: str, *, grid: Numbers | None = None, ladders: bool = False, depth: bool = False
) -> dict[str, Numbers]:
    """Parts of a budget in per cent of the value, by the title they had."""
    own: dict[str, Numbers] = {source: part(name, source) for source in ("surfaces", "solver")}
    own["grid"] = grid or grid_two(name)
    own |= {"depth": part(name, "depth")} if depth else {}
    more = {"finite size": part(name, "size"), "bandwidth": part(name, "bandwidth")} if ladders else {}

    def percent(of: Numbers) -> Numbers:
        return lambda d: 100 * of(d) / d[name]

    def total(parts: dict[str, Numbers]) -> Numbers:
        return lambda d: 100 * sum(of(d) ** 2 for of in parts.values()) ** 0.5 / d[name]

    return {
        **{title: percent(of) for title, of in (own | more).items()},
        "for this spectrum and period": total(own),
        "for any": total(own | more),
    }


def _mean_error(kind: str, rung: str) -> Numbers:
    """Every rung had what the grids leave on the rung where they leave most."""
    name = f"kappa_{kind}"
    return lambda d: np.hypot(part(name, "surfaces")(d), 2 / NORMAL * part(name, "grid")(d).max(rung))


def _limit(kind: str, rung: str) -> Numbers:
    """Where the line is at 0, however far off that is: rungs of common surfaces have one weight."""
    name, step = f"kappa_{kind}", f"step_{kind}"
    return lambda d: d[f"{name}_limit"].fillna(d[name].mean(rung) - d[f"{name}_slope"] * d[step].mean(rung))


def _limit_error(kind: str, source: str) -> Numbers:
    """Scatter, drift, and the grids of the rung where they leave most, with two standard errors."""
    name = f"kappa_{kind}_limit"
    return lambda d: (
        (
            part(name, "surfaces")(d) ** 2
            + part(name, source)(d) ** 2
            + (2 / NORMAL * part(name, "grid")(d)) ** 2
        )
        ** 0.5
    )


def _slope_error(kind: str, source: str) -> Numbers:
    name = f"kappa_{kind}_slope"
    return lambda d: np.hypot(part(name, "surfaces")(d), part(name, source)(d))


def _of(old: str, rung: str) -> dict[str, Look]:
    kind = f"by_{old}"
    return {
        f"data.{old}_kappa": f"kappa_{kind}",
        f"data.{old}_half_width": _mean_error(kind, rung),
        f"data.{old}_limit": _limit(kind, rung),
        f"data.{old}_limit_half_width": _limit_error(kind, old),
        f"data.{old}_slope": f"kappa_{kind}_slope",
        f"data.{old}_slope_half_width": _slope_error(kind, old),
        f"data.{old}_order": f"order_{kind}",
        f"data.{old}_reach": f"kappa_{kind}_reach",
        f"data.{old}_step": lambda d: 1 / d[rung],
    }


LADDERS: dict[str, Look] = {
    **_of("bandwidth", "bandwidth_rung"),
    **_of("size", "periods_rung"),
    "data.bandwidth_nayak": "nayak_by_bandwidth",
    "data.ladder_hurst": "hurst_ladder",
    "data@ladder_reduced_pressure": "reduced_pressure_ladder",
}
