"""Two papers of kappa were known; a third stands behind them."""

from collections.abc import Callable

import xarray as xr

from gold.maps import Look


def first_two(name: str) -> Callable[[xr.Dataset], xr.DataArray]:
    """Return the look at the first two papers."""
    return lambda data: data[name].isel(paper_kappa=slice(0, 2))


NAMES: dict[str, Look] = {
    f"data.{name}": first_two(name) for name in ("kappa_published", "kappa_published_high", "hurst_published")
}
CHANGED: dict[str, str] = {}
