"""`depth` on the kit."""

from __future__ import annotations

from gold.maps import Look

NAMES: dict[str, Look] = {
    "data.pressure_half_space": "pressure_difference",
    "data.pressure_layer": "pressure_difference_layer",
    "data.area": "area_difference",
    "table.depth/L": "depth",
    "table.nu": "poisson",
    "table.p - half-space [[]%]": lambda d: 100 * d.pressure_difference,
    "table.p - layer [[]%]": lambda d: 100 * d.pressure_difference_layer,
    "table.A - half-space [[]%]": lambda d: 100 * d.area_difference,
}
CHANGED: dict[str, str] = {}
