"""`heights` on the kit."""

from __future__ import annotations

import numpy as np

from gold.maps import Look

_DEVIATIONS = ("skewness", "excess_kurtosis", "height_distance", "highest")


def _widths(d):
    """The last of the columns that have the same title."""
    return d[f"{_DEVIATIONS[-1]}_error"].sel(source="surfaces")


NAMES: dict[str, Look] = {
    "data.density": "height_density_each",
    "data.skewness": "skewness_each",
    "data.excess": "excess_kurtosis_each",
    "data.distance": "height_distance_each",
    "data.highest": "highest_each",
    "data.area": "area_each",
    "data.theory": "area_persson_each",
    "data.rms_height": "rms_height_each",
    "data.rms_gradient": "rms_gradient_each",
    "table.L/lambda_0": lambda d: np.asarray(d.periods),
    "table.<h^3> / h_rms^3": "skewness",
    "table.<h^4> / h_rms^4 - 3": "excess_kurtosis",
    "table.largest distance of the cumulated heights from the Gaussian": "height_distance",
    "table.highest point / h_rms": "highest",
    "table.+- (95 %)": _widths,
}
CHANGED: dict[str, str] = {}
