"""`archard` on the kit."""

from __future__ import annotations

from gold.maps import Look

NAMES: dict[str, Look] = {
    "data.area": "area_each",
    "data.exponent": "load_exponent_grid_each",
    "data.theory": "area_archard",
    "data.theory_exponent": "load_exponent_archard",
    "data.reduced_pressure": "relative_load",
    "table.p0 L / (E* H_0)": lambda d: [p for _ in d.levels for p in d.relative_load.values],
    "table.A/A0": "area_finest",
    "table.+- (95 %)": lambda d: d.area_finest_error.sel(source="surfaces"),
    "table.A/A0 Archard": "area_archard",
    "table.ratio": "area_over_archard",
}
CHANGED: dict[str, str] = {}
