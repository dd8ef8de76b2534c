"""Closed forms of effects, a second time."""

from __future__ import annotations

import math

#: Terms of a series whose n-th is exp(-(n pi)^2 v / 2), v not below `_LEAST`.
_TERMS, _LEAST = 400, 1e-3


def yielded_areas(pressure: float, *, variance: float, hardness: float) -> tuple[float, float]:
    """A_pl/A0 and A_el/A0 of Persson's theory for one hardness: diffusion between walls at 0 and H.

    Eigenfunctions sin(n pi sigma / H) decay like exp(-(n pi)^2 V / 2 H^2); where V is so small that they do
    not decay, images of the two nearest walls are all there is.
    """
    x, v = pressure / hardness, variance / hardness**2
    if v < _LEAST:
        near, far = x / math.sqrt(2 * v), (1 - x) / math.sqrt(2 * v)
        return math.erfc(far), 1 - math.erfc(near) - math.erfc(far)
    plastic, staying = x, 0.0
    for n in range(1, _TERMS):
        decay = math.exp(-((n * math.pi) ** 2) * v / 2)
        wave = math.sin(n * math.pi * x) * decay / (n * math.pi)
        plastic += 2 * (-1) ** n * wave
        staying += 4 * wave if n % 2 else 0.0
        if decay < 1e-18:
            break
    return plastic, staying
