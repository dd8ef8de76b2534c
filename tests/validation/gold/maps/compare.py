"""Results side by side: the same variables along `result`, and their differences from the first."""

from __future__ import annotations

from gold.maps import Look

__all__ = ["CHANGED", "NAMES"]

NAMES: dict[str, Look] = {}
_LAID_OUT = "datasets are concatenated and subtracted, variable by variable; test_compare.py has planted ones"
CHANGED: dict[str, str] = {
    "summary.*": _LAID_OUT,
    "data.*": _LAID_OUT,
    "data@*": _LAID_OUT,
    "table.*": _LAID_OUT,
    "figure.*": _LAID_OUT,
    "shown.*": _LAID_OUT,
    "answers": "cards are made of values",
    "findings": "findings are data",
}
