"""The sine expansion of the stress distribution between two walls (Persson 2006, Sec. 9): a second method.

Exact for walls that stand still, slow and of algebraic accuracy for walls that move; use `persson.diffusion`
for work and this module to check it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from persson._checks import (
    Array,
    in_proportion,
    non_negative,
    positive,
    real,
    returned,
    scalar,
    whole,
    within,
)
from persson.errors import InvalidInput, NotConverged

__all__ = ["SineExpansion", "sine_expansion"]


@dataclass(frozen=True, kw_only=True)
class SineExpansion:
    """P(sigma) = sum A_n sin(n pi s), s = (sigma_Y - sigma) / (sigma_Y + sigma_a), at one V.

    Attributes
    ----------
    amplitudes : (n,) array
        A_1 ... A_n [1/Pa].
    tensile_limit, yield_stress : float
        sigma_a and sigma_Y [Pa] at this V.
    """

    amplitudes: Array
    tensile_limit: float
    yield_stress: float

    @property
    def area_elastic(self) -> float:
        """Integral of P between the walls."""
        n = np.arange(1, self.amplitudes.size + 1)
        weights = np.where(n % 2 == 1, 2 / (np.pi * n), 0.0)
        return float((self.tensile_limit + self.yield_stress) * (weights @ self.amplitudes))

    def distribution(self, stress: Array) -> Array:
        """P(sigma) [1/Pa] for stresses [Pa]."""
        width = self.tensile_limit + self.yield_stress
        s = (self.yield_stress - real("stress", stress, unit="Pa")) / width
        n = np.arange(1, self.amplitudes.size + 1)
        inside = (s > 0) & (s < 1)
        return np.where(inside, np.sin(np.pi * s[..., None] * n) @ self.amplitudes, 0.0)


def sine_expansion(
    variance: float,
    *,
    pressure: float,
    tensile_limit: float | Callable[[float], float],
    yield_stress: float | Callable[[float], float],
    modes: int = 200,
    tolerance: float = 1e-9,
) -> SineExpansion:
    r"""Expand the stress distribution at variance V in sines between -sigma_a(V) and sigma_Y(V).

    .. math:: \frac{\partial P}{\partial V} =
              \left(s \frac{\sigma_b'}{\sigma_b} - \frac{\sigma_Y'}{\sigma_b}\right)
              \frac{\partial P}{\partial s} + \frac{1}{2\sigma_b^2}\frac{\partial^2 P}{\partial s^2},
              \qquad \sigma_b = \sigma_a + \sigma_Y

    Parameters
    ----------
    variance : float
        V [Pa^2].
    pressure : float
        sigma_0 [Pa], between the walls.
    tensile_limit, yield_stress : float or callable
        sigma_a and sigma_Y [Pa], constant or functions of V.
    modes : int
        Terms of the expansion.
    tolerance : float
        Relative tolerance of the integration in V.

    Notes
    -----
    Persson 2006, Eq. 52, with the term for a moving sigma_Y that the paper leaves out.
    """
    below, above = _wall("tensile_limit", tensile_limit), _wall("yield_stress", yield_stress)
    end = positive("variance", variance, unit="Pa^2", power=2)
    whole("modes", modes, least=1, most=2000)
    within("tolerance", tolerance, 1e-13, 0.1, interval="[1e-13, 0.1]")
    pressure = scalar("pressure", pressure, unit="Pa")
    start_width = below(0.0) + above(0.0)
    s0 = (above(0.0) - pressure) / start_width if start_width > 0 else math.nan
    if not 0 < s0 < 1:
        raise InvalidInput(f"pressure = {pressure!r}: must lie between the walls")
    n = np.arange(1, modes + 1)
    with in_proportion():
        amplitudes = 2 / start_width * np.sin(np.pi * n * s0)
    if not (callable(tensile_limit) or callable(yield_stress)):
        amplitudes = amplitudes * np.exp(-0.5 * end * (np.pi * n / start_width) ** 2)
        return SineExpansion(amplitudes=amplitudes, tensile_limit=below(end), yield_stress=above(end))
    with in_proportion():
        return _moving(below, above, amplitudes, end=end, tolerance=tolerance)


def _moving(
    below: Callable[[float], float],
    above: Callable[[float], float],
    amplitudes: Array,
    *,
    end: float,
    tolerance: float,
) -> SineExpansion:
    """Integrate the amplitudes between moving walls up to V = end."""
    modes = amplitudes.size
    n, start_width = np.arange(1, modes + 1), below(0.0) + above(0.0)
    stretch, shift = _coupling(modes)
    h = 1e-6 * end

    def matrix(v: float) -> Array:
        width = below(v) + above(v)
        low, high = max(v - h, 0.0), v + h
        upper = (above(high) - above(low)) / (high - low)
        both = upper + (below(high) - below(low)) / (high - low)
        result = both / width * stretch - upper / width * shift
        result[np.diag_indices(modes)] -= 0.5 * (np.pi * n / width) ** 2
        return np.asarray(result)

    solution = solve_ivp(
        lambda v, a: matrix(v) @ a,
        (0.0, end),
        amplitudes,
        method="Radau",
        jac=lambda v, a: matrix(v),
        t_eval=[end],
        rtol=tolerance,
        atol=tolerance * 2 / start_width * 1e-3,
    )
    if not solution.success:
        raise NotConverged(f"sine expansion: {solution.message}")
    return SineExpansion(amplitudes=solution.y[:, -1], tensile_limit=below(end), yield_stress=above(end))


def _wall(name: str, wall: float | Callable[[float], float]) -> Callable[[float], float]:
    if not callable(wall):
        value = float(non_negative(name, within(name, wall, 0, math.inf, interval="[0, inf)"), unit="Pa"))
        return lambda variance: value
    return lambda variance: float(returned(f"{name}(V)", wall(variance), (), unit="Pa"))


def _coupling(modes: int) -> tuple[Array, Array]:
    """Matrices of s d/ds and d/ds in the sine basis."""
    n = np.arange(1, modes + 1, dtype=float)
    m = n[:, None]
    plus, minus = m + n, m - n
    np.fill_diagonal(minus, 1.0)
    sign = (-1.0) ** plus
    stretch = -n * (sign / plus + np.where(m == n, 0.0, sign / minus))
    shift = n * ((1 - sign) / plus + np.where(m == n, 0.0, (1 - sign) / minus))
    return stretch, shift
