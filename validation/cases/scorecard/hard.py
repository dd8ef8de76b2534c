"""Problems at which solvers are known to break."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fem_contact.surface import HeightField
from validation.cases import Check
from validation.cases._closed_forms import HertzInPeriod
from validation.cases.scorecard.known import strip, strip_error
from validation.cases.scorecard.subject import Subject, rough

__all__ = ["elongated", "near_full", "odd_axes", "one_cell"]

_DEPTH = 0.01
#: Mean pressure at which D cos(2 pi x) cos(2 pi y) is pressed flat: E* q D / 2 with q = 2 pi sqrt 2.
_FLAT = math.sqrt(2) * math.pi * _DEPTH


def _egg_box(n: int) -> HeightField:
    x = np.cos(2 * np.pi * (np.arange(n) + 0.5) / n)
    return HeightField(heights=_DEPTH * x[:, None] * x[None, :], lengths=(1.0, 1.0))


def near_full(subject: Subject) -> Sequence[Check]:
    """Press an egg box flat at its flattening load; just below it is open at the valleys."""
    n, miss = subject.ladder[-1], 0.02
    found = subject.press(_egg_box(n), 1.0001 * _FLAT)
    exact = 1.0001 * _FLAT + _FLAT * _egg_box(n).heights / _DEPTH
    # A discretisation of second order errs by (q dx)^2 / 4, and by the tolerance.
    allowed = (2 * math.pi * math.sqrt(2) / n) ** 2 / 4 + subject.pressure_error
    below = subject.press(_egg_box(n), (1 - miss) * _FLAT).result.in_contact.mean()
    open_share = 3 / (2 * math.pi) * miss
    # Two gaps in a period, counted to half a cell along their edges.
    edge = 2 * 2 * math.pi * math.sqrt(open_share / 2 / math.pi) * 0.5 / n
    return [
        Check.below(
            "error of the pressure over the mean, at 1.0001 of the flattening load",
            float(np.abs(found.claim.pressure - exact).max()) / _FLAT,
            allowed,
        ),
        Check.near(f"A/A0 at {1 - miss:g} of it", below, 1 - open_share, edge + miss * open_share),
    ]


def one_cell(subject: Subject) -> Sequence[Check]:
    """Press a paraboloid so lightly that one point carries the load."""
    n = 2 * subject.points
    mean = 0.02 / n / n**2
    found = subject.press(HertzInPeriod(radius=1e-3).surface(n, (0.0, 0.0)), mean)
    return [
        Check.relative(
            "largest pressure over the load",
            found.claim.pressure.max() / (mean * n**2),
            1.0,
            10 * subject.tolerance,
        ),
        Check.near("points that touch", float(np.count_nonzero(found.result.in_contact)), 1.0, 0.0),
    ]


def elongated(subject: Subject) -> Sequence[Check]:
    """Press a wave that is uniform over a period four times as long, on cells four times as long."""
    n = 2 * subject.points
    # Cells are four times as long as wide: of second order where they are coarse.
    allowed = 0.02 * max(1.0, (32 / n) ** 2)
    return [
        Check.below(
            f"mean error of p over the peak, period {words}",
            strip_error(*strip(subject, n, across=(n, 4.0), axis=axis)),
            allowed,
        )
        for axis, words in ((0, "1 x 4"), (1, "4 x 1"))
    ]


def odd_axes(subject: Subject) -> Sequence[Check]:
    """Check that grids with an odd number of points are solved as well as even ones."""
    n = 2 * subject.points
    checks = []
    odd = n - n // 4 - 3
    for shape in ((odd, n), (n, odd), (odd, odd)):
        surface = rough(n).resampled(shape)
        residuals = subject.press(surface, 0.05).result.residuals
        words = f"complementarity, recomputed, on {shape[0]} x {shape[1]} points"
        checks.append(Check.below(words, residuals.complementarity, subject.tolerance))
    return checks
