"""Where gold numbers are now: kept by whoever renames, moves or changes one.

An entry is a study ("hurst") for all its cases, or one case ("hurst of equal Nayak parameter"). A place is
"data.kappa", "table.+- (95 %)", "budget.grid [%]", "figure.kappa-against-hurst.kappa", or a pattern of such.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import xarray as xr

__all__ = ["CHANGED", "NAMES", "REWORDED", "Look"]

#: Another place, a variable of the new dataset, or a function of that dataset.
Look = str | Callable[[xr.Dataset], Any]

#: New names, by entry and gold place. A figure's number that is gone is looked up like that of the dataset.
#:
#:     "area": {
#:         "data.kappa_error": "kappa_surfaces_error",
#:         "table.+- (95 %)": lambda d: 1.96 * d.kappa_error,
#:         "figure.*.persson": "theory",
#:     },
NAMES: dict[str, dict[str, Look]] = {}

#: Numbers that changed on purpose or went, by entry and gold place, with the reason, which stands under
#: *Numbers changed* in CHANGELOG.md, too.
CHANGED: dict[str, dict[str, str]] = {}

#: Entries whose sentences, cards and words in tables were rewritten: the old ones are kept to be read.
REWORDED: frozenset[str] = frozenset()
