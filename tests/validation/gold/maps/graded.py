"""`graded` on the kit: what a modulus is felt by stands in its name."""

from __future__ import annotations

from gold.maps import Look

NAMES: dict[str, Look] = {
    "data.profile": "felt_modulus_profile",
    "data.coating": "felt_modulus_coating",
    "data.wave": "reduced_wave",
    "data.ratio": "modulus_ratio",
}
CHANGED: dict[str, str] = {}
