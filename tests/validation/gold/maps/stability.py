"""`stability` on the kit."""

from __future__ import annotations

from gold.maps import Look

NAMES: dict[str, Look] = {
    "data.dial": "varied",
    "data.error": "deviation",
    "data.words": "message",
    "figure.stability-*.error": lambda d: d.deviation,
}
CHANGED: dict[str, str] = {"figure.*": "figures show the variables of the dataset"}
