"""As those of hurst."""

from gold.maps import Look
from gold.maps.hurst import CHANGED, first_two
from gold.maps.hurst import NAMES as PUBLISHED

__all__ = ["CHANGED", "NAMES"]

NAMES: dict[str, Look] = {
    **PUBLISHED,
    **{f"data.{n}": first_two(n) for n in ("kappa_comparable", "kappa_difference", "kappa_difference_error")},
}
