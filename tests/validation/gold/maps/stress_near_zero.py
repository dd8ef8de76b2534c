"""`stress-near-zero` on the kit: the mean slope in a window has a name of its own."""

from __future__ import annotations

from gold.maps import Look

NAMES: dict[str, Look] = {
    "*.density_at_zero": "density_at_zero_each",
    "*.slope": "window_slope_each",
    "*.contour_slope": "contour_slope_each",
    "data.patches": "patches_each",
    "*.density": "small_density",
    "table.lambda_short/dx": lambda d: 1 / d.spacing,
    "table.P(0+) E[*]h'": "density_at_zero",
    "table.+- (95 %)": lambda d: d.contour_slope_error.sel(source="surfaces"),
    "table.mean slope in the window": "window_slope",
    "table.slope from the contour": "contour_slope",
    "*@reduced_pressure": "reduced_pressure",
    "*@persson_slope": "initial_slope_persson",
    "*@window": lambda d: d.attrs["window"],
    "*@slope_window": lambda d: d.attrs["slope_window"],
    "*@surfaces": lambda d: d.sizes["surface"],
}
CHANGED: dict[str, str] = {}
