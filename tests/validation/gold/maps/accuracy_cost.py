"""`accuracy-cost` on the kit."""

from __future__ import annotations

from gold.maps import Look
from validation.report.estimates import NORMAL

NAMES: dict[str, Look] = {
    "data.error": "area_deviation_each",
    "data.label": "way",
    "data.process": "process",
    "data.claimed": lambda d: 2 / NORMAL * d.claimed_each,
    "data.missed": "missed_each",
    "data.reference_error": lambda d: d.reference_each_error.sel(source="grid") / NORMAL,
    "table.accuracy of A/A0": lambda d: [f"{100 * a:g} %" for a in d.accuracy.values],
}
CHANGED: dict[str, str] = {
    "data@absent": "names are told apart by commas",
    "table.its *": "they follow from seconds",
}
