"""`magnification` on the kit."""

from __future__ import annotations

from gold.maps import Look
from validation.report.estimates import NORMAL


def _row(name: str) -> Look:
    return lambda d: d[name].transpose("load", "magnification")


NAMES: dict[str, Look] = {
    "data.area": "area_each",
    "data.area_error": lambda d: d.area_each_error.sel(source="grid") / NORMAL,
    "data.theory": "area_persson_each",
    "data.theory_ensemble": "area_ensemble_each",
    "table.p* (all waves)": lambda d: [p for p in d.reduced_pressure.values for _ in d.magnification],
    "table.A/A0 limit": _row("area"),
    "table.+- (95 %)": lambda d: d.area_error.sel(source="surfaces").transpose("load", "magnification"),
    "table.A/A0 Persson, conditional": _row("area_persson"),
    "table.A/A0 Persson, ensemble": _row("area_ensemble"),
    "table.ratio to the first": lambda d: (d.area / d.area_persson).transpose("load", "magnification"),
}
CHANGED: dict[str, str] = {}
