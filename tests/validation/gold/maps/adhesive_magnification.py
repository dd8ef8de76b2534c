"""`adhesive-magnification` on the kit: readings of the theory are names in place of a dimension."""

from __future__ import annotations

import numpy as np

from gold.maps import Look
from validation.measures.adhesive import STRESS_EDGES

__all__ = ["CHANGED", "NAMES"]

_NEW = {
    "contact": "area",
    "force": "force_inside",
    "energy": "energy_ratio",
    "tension": "tension",
    "plain": "area_plain",
    "parted": "area_parted",
}
_READINGS = ("improved", "old")


def _theory(name: str) -> Look:
    """Both readings, in the order of the dimensions there were."""

    def found(d):
        both = np.stack([d[f"{name}_{reading}_each"].values for reading in _READINGS])
        return both if name == "energy_share" else np.moveaxis(both, 0, 3)

    return found


def _row(name: str) -> Look:
    """Where every surface was solved, by work."""
    return lambda d: [
        d[name].isel(told=t, magnification=z).item()
        for t in range(d.sizes["told"])
        for z in range(d.sizes["magnification"])
        if np.isfinite(d.area.isel(told=t, magnification=z))
    ]


def _half_width(name: str) -> Look:
    """Student's of the surfaces with 1.96 times the root mean square of their steps."""

    def found(d):
        steps = (d[f"{name}_each_drift"] ** 2).mean("surface") ** 0.5
        half = np.hypot(d[f"{name}_error"].sel(source="surfaces"), 1.96 * steps)
        return half.values[np.isfinite(d.area.values)]

    return found


_TITLES = {
    "area": "A/A0",
    "force_inside": "F/F_load",
    "energy_ratio": "U_el/U_full",
    "tension": "share in tension",
}
NAMES: dict[str, Look] = {
    **{f"data.{old}": f"{new}_each" for old, new in _NEW.items()},
    **{f"data.{old}_error": lambda d, new=new: abs(d[f"{new}_each_drift"]) for old, new in _NEW.items()},
    **{f"data.theory_{old}": _theory(new) for old, new in list(_NEW.items())[:4]},
    "data.theory_plain": "area_plain_persson_each",
    "data.stress": "stress_share_each",
    "data.theory_stress": _theory("stress_share"),
    "data.share": "energy_share_each",
    "data.theory_share": _theory("energy_share"),
    "data.beyond": "energy_beyond_each",
    "data.half_area": "area_half_range",
    "data.half_force": "force_inside_half_range",
    "data.reading": lambda d: list(_READINGS),
    "data.told": lambda d: ["own", "effective"],
    "data.stress_lower": lambda d: STRESS_EDGES[:-1],
    "data.shell_end": "wave",
    "data@surfaces": lambda d: d.sizes["surface"],
    "table.zeta": lambda d: [
        z
        for t in range(d.sizes["told"])
        for z in d.magnification.values
        if np.isfinite(d.area.isel(told=t).sel(magnification=z))
    ],
    "table.A/A0 without adhesion": _row("area_plain"),
    "table.A/A0 parted from full contact": _row("area_parted"),
    "table.distance of P(sigma) A0/A (Eqs. 44-49)": _row("stress_distance_improved"),
    "table.distance of P(sigma) A0/A (Eq. 43)": _row("stress_distance_old"),
    **{f"table.{title}": _row(name) for name, title in _TITLES.items()},
    **{f"table.+- {title} (95 %)": _half_width(name) for name, title in _TITLES.items()},
    **{f"table.{title}, theory (Eqs. 44-49)": _row(f"{name}_improved") for name, title in _TITLES.items()},
    **{f"table.{title}, theory (Eq. 43)": _row(f"{name}_old") for name, title in _TITLES.items()},
}
#: Names of old numbers that others have now.
NAMES |= {
    f"figure.*.{name.removeprefix('data.')}": look for name, look in NAMES.items() if name.startswith("data.")
}
CHANGED: dict[str, str] = {}
