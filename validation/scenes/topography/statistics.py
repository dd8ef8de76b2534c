"""How far heights are from what the theory assumes of them, and what their summits are like."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from validation.arrays import Array

#: Share of the points that are called the steepest.
_STEEPEST = 1e-3
#: Share f (1 - ln f) of the mean square slope in them where slopes are Gaussian and know no direction.
GAUSSIAN_STEEP_SHARE = _STEEPEST * (1 - float(np.log(_STEEPEST)))
#: Kurtosis of the slopes, and share over the Gaussian one, from which on the premise does not hold.
_PEAKED, _STEEP = 4.0, 2.0


@dataclass(frozen=True, kw_only=True)
class HeightStatistics:
    """What decides whether heights are as a theory of Gaussian roughness assumes.

    Slopes and curvatures are by differences of neighbours.
    """

    kurtosis: float  # <h^4>/<h^2>^2 of heights about their mean, and of slopes; 3 for Gaussian ones
    slope_kurtosis: float
    #: Share of the mean square slope in the steepest 0.1 % of the points; 0.0079 for Gaussian slopes.
    steep_share: float
    summit_density: float  # Points above their eight neighbours per nominal area [1/m^2]
    summit_curvature: float  # Mean of -(h_xx + h_yy)/2 at them [1/m]
    summit_height: float  # Root mean square height of them about their mean [m]

    @property
    def is_gaussian(self) -> bool:
        """Whether slopes are near enough to Gaussian ones for the theory, not its premise, to be compared."""
        return self.slope_kurtosis <= _PEAKED and self.steep_share <= _STEEP * GAUSSIAN_STEEP_SHARE


def height_statistics(heights: Array, spacing: tuple[float, float]) -> HeightStatistics:
    """Return the statistics of heights [m] on a grid of a spacing [m]; NaN where they are flat or too few."""
    (dx, dy), level = spacing, heights - np.mean(heights)
    slope_x, slope_y = np.diff(level, axis=0) / dx, np.diff(level, axis=1) / dy
    # At all four corners of a cell: no direction is preferred.
    ends = slice(None, -1), slice(1, None)
    square = np.sort([slope_x[:, j] ** 2 + slope_y[i] ** 2 for i in ends for j in ends], axis=None)
    steepest = square[-max(1, round(_STEEPEST * square.size)) :]
    middle = level[1:-1, 1:-1]
    nx, ny = middle.shape
    around = [level[i : i + nx, j : j + ny] for i in range(3) for j in range(3) if (i, j) != (1, 1)]
    summit = np.all([middle > neighbour for neighbour in around], axis=0)
    _, left, _, below, above, _, right, _ = around
    curvature = ((2 * middle - left - right) / dx**2 + (2 * middle - below - above) / dy**2)[summit] / 2
    with np.errstate(invalid="ignore", divide="ignore"):
        return HeightStatistics(
            kurtosis=_kurtosis(level),
            slope_kurtosis=(_kurtosis(slope_x) + _kurtosis(slope_y)) / 2,
            steep_share=float(steepest.sum() / square.sum()),
            summit_density=float(summit.sum() / (middle.size * dx * dy)) if middle.size else np.nan,
            summit_curvature=float(curvature.mean()) if curvature.size else np.nan,
            summit_height=float(middle[summit].std()) if curvature.size else np.nan,
        )


def _kurtosis(values: Array) -> float:
    squares = (values - values.mean()) ** 2
    return float(np.mean(squares**2) / np.mean(squares) ** 2)
