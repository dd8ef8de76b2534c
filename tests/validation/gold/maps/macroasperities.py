"""`macroasperities` on the kit."""

from __future__ import annotations

import numpy as np

from gold.maps import Look


def _phase(name: str, phase: str) -> Look:
    return lambda d: d[f"percolation_{name}_axis_each"].sel(phase=phase)


def _both(name: str) -> Look:
    """What theory and simulation say, in this order, along a dimension behind the surfaces."""
    return lambda d: np.stack([d[f"{name}_persson_each"].values, d[f"{name}_each"].values], axis=1)


def _row(name: str) -> Look:
    return lambda d: d[name].transpose("load", "magnification")


def _width(name: str) -> Look:
    return lambda d: d[f"{name}_error"].sel(source="surfaces").transpose("load", "magnification")


NAMES: dict[str, Look] = {
    "data.area": "area_each",
    "data.area_inside": "area_inside_each",
    "data.load_inside": "load_inside_each",
    "data.patches": "patch_density_each",
    "data.patch_size": "relative_patch_size_each",
    "data.largest": "largest_patch_each",
    "data.gradient": "gradient_share_each",
    "data.theory": "area_persson_each",
    "data.contact_threshold": _phase("area", "contact"),
    "data.contact_zeta": _phase("magnification", "contact"),
    "data.gap_threshold": _phase("area", "gap"),
    "data.gap_zeta": _phase("magnification", "gap"),
    "data.zeta": "magnification",
    "data.macro_zeta": lambda d: np.stack(
        [d.macro_magnification_persson.values, d.macro_magnification.values]
    ),
    "data.macro_area": _both("macro_area"),
    "data.macro_pressure": _both("macro_pressure"),
    "table.p* (all waves)": lambda d: [p for p in d.reduced_pressure.values for _ in d.magnification],
    "table.zeta": lambda d: [z for _ in d.reduced_pressure for z in d.magnification.values],
    "table.A/A0": _row("area"),
    "table.+- (95 %)": _width("area"),
    "table.Persson": _row("area_persson"),
    "table.p0 A0/A / (E* h'_rms)": _row("contact_pressure"),
    "table.patches on lambda_0^2": _row("patch_density"),
    "table.mean patch / lambda_0^2": _row("relative_patch_size"),
    "table.largest patch / A": _row("largest_patch"),
    "table.load inside, all waves": _row("load_inside"),
    "table.+- (95 %) of it": _width("load_inside"),
}
CHANGED: dict[str, str] = {
    "*.source": "theory and simulation are variables, since sources are those of errors",
}
