"""`cross` on the kit: legs and grids are dimensions of their own."""

from __future__ import annotations

import numpy as np

from gold.maps import Look


def _each(name: str) -> Look:
    def flat(d):
        values = d[f"{name}_each"].values.reshape(-1, d.sizes["surface"])
        return values[np.isfinite(d.pressure_difference_each.values).any(axis=2).ravel()]

    return flat


def _mean(name: str) -> Look:
    return lambda d: np.mean(_each(name)(d), axis=1)


def _places(name: str) -> Look:
    def flat(d):
        there = d.pressure_difference_each.notnull().any("surface")
        return d[name].broadcast_like(there).transpose(*there.dims).values[there.values]

    return flat


_NEW = {
    "pressure_half_space": "pressure_difference",
    "pressure_inside": "pressure_difference_inside",
    "area": "area_difference",
    "area_corrected": "area_difference_perimeter",
    "gap": "gap_difference",
    "residual": "residual",
    "converged": "converged",
}
NAMES: dict[str, Look] = {
    **{f"data.{old}": _each(new) for old, new in _NEW.items()},
    "data.leg": _places("leg"),
    "data.points_per_wave": _places("points_per_wave"),
    "table.leg": _places("leg"),
    "table.lambda_short/dx": _places("points_per_wave"),
    "table.||p - p_bem|| / ||p_bem||": _mean("pressure_difference"),
    "table.the same*": _mean("pressure_difference_inside"),
    "table.A/A_bem - 1, points counted": _mean("area_difference"),
    "table.A/A_bem - 1, each*": _mean("area_difference_perimeter"),
    "table.(mean gap*": _mean("gap_difference"),
    "table.largest contact residual*": _mean("residual"),
}
CHANGED: dict[str, str] = {}
