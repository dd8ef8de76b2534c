"""As those of hurst."""

from gold.maps import Look
from gold.maps.hurst import CHANGED, first_two
from gold.maps.hurst import NAMES as PUBLISHED

__all__ = ["CASES", "CHANGED", "NAMES"]

NAMES: dict[str, Look] = {
    **PUBLISHED,
    **{f"data.{n}": first_two(n) for n in ("kappa_comparable", "kappa_difference", "kappa_difference_error")},
}
#: Written when there were three.
CASES = {"refinement with ladders": ({place: place for place in NAMES}, {})}
