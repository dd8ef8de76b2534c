"""The sine expansion of the stress distribution between two walls (Persson 2006, Sec. 9): a second method.

Exact for walls that stand still, slow and of algebraic accuracy for walls that move; use `persson.diffusion`
for work and this module to check it.
"""

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace

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
from persson._window import FALLING
from persson.errors import InvalidInput, NotConverged, OutsideTheory

#: A stress limit [Pa] against V [Pa^2].
_Limit = Callable[[float], float]


@dataclass(frozen=True, kw_only=True)
class SineExpansion:
    """P(sigma) = P_Y (1 - s) + sum A_n sin(n pi s), s = (sigma_Y - sigma) / (sigma_Y + sigma_a), at one V.

    Attributes
    ----------
    amplitudes : (n,) array
        A_1 ... A_n [1/Pa].
    density_at_yield : float
        P_Y = P(sigma_Y) [1/Pa]: 0 for a constant hardness, Persson 2006, Eq. 34 for one that rises.
    area_plastic : float
        Yielded area over the nominal area (Eq. 33).
    tensile_limit, yield_stress : float
        sigma_a and sigma_Y [Pa] at this V.
    error_estimate : float
        Of both areas, absolute: between walls that stand, twice the largest that the first term left out can
        be; between walls that move, twice the change from half as many terms, which is the error where that
        falls like one over the terms, as it does at the slowest, and what half as many leave out of the
        distribution that meets the walls first.
    """

    amplitudes: Array
    density_at_yield: float
    area_plastic: float
    tensile_limit: float
    yield_stress: float
    error_estimate: float

    @property
    def area_elastic(self) -> float:
        """Integral of P between the walls."""
        n = np.arange(1, self.amplitudes.size + 1)
        weights = np.where(n % 2 == 1, 2 / (np.pi * n), 0.0)
        mean = float(weights @ self.amplitudes) + self.density_at_yield / 2
        return (self.tensile_limit + self.yield_stress) * mean

    def distribution(self, stress: Array) -> Array:
        """P(sigma) [1/Pa] for stresses [Pa]."""
        width = self.tensile_limit + self.yield_stress
        s = (self.yield_stress - real("stress", stress)) / width
        n = np.arange(1, self.amplitudes.size + 1)
        inside = (s > 0) & (s < 1)
        series = np.sin(np.pi * s[..., None] * n) @ self.amplitudes
        return np.where(inside, series + self.density_at_yield * (1 - s), 0.0)


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
        sigma_a and sigma_Y [Pa], constant or functions of V; the hardness must not fall.
    modes : int
        Terms of the expansion.
    tolerance : float
        Relative tolerance of the integration in V.

    Raises
    ------
    InvalidInput
        For a nominal pressure that does not lie between the walls.
    OutsideTheory
        For a hardness that falls with V.

    Notes
    -----
    Persson 2006, Eq. 52, with the term for a moving sigma_Y that the paper leaves out. Where sigma_Y rises
    the density at the wall is not zero but P(sigma_Y) = 2 A_pl dsigma_Y/dV, which is Eq. 34; the yielded area
    of Eq. 33 is then one more unknown.
    """
    below, above = _wall("tensile_limit", tensile_limit), _wall("yield_stress", yield_stress)
    end = positive("variance", variance, power=2)
    whole("modes", modes, least=1, most=2000)
    within("tolerance", tolerance, "[1e-13, 0.1]")
    pressure = scalar("pressure", pressure)
    start_width = below(0.0) + above(0.0)
    s0 = (above(0.0) - pressure) / start_width if start_width > 0 else math.nan
    if not 0 < s0 < 1:
        raise InvalidInput(f"pressure = {pressure!r}: must lie between the walls")
    if not (callable(tensile_limit) or callable(yield_stress)):
        with in_proportion():
            return _still(s0, modes=modes, variance=end, walls=(below(end), above(end)))
    values = np.array([above(float(v)) for v in np.linspace(0.0, end, 65)])
    if np.any(np.diff(values) < -1e-12 * np.abs(values[1:])):
        raise OutsideTheory(FALLING)
    with in_proportion():
        start = _free(below, above, pressure, end)
        coarse, fine = (
            _moving(below, above, pressure, (start, end), modes=n, tolerance=tolerance)
            for n in (max(modes // 2, 1), modes)
        )
    changes = (fine.area_elastic - coarse.area_elastic, fine.area_plastic - coarse.area_plastic)
    omitted = _omitted(coarse.amplitudes.size, start, below(start) + above(start))
    return replace(fine, error_estimate=2 * max(map(abs, changes)) + omitted + tolerance)


def _omitted(modes: int, variance: float, width: float) -> float:
    first = modes + 1
    return 4 / (math.pi * first) * math.exp(-0.5 * variance * (math.pi * first / width) ** 2)


def _still(s0: float, *, modes: int, variance: float, walls: tuple[float, float]) -> SineExpansion:
    """Let the amplitudes decay between walls that stand.

    As V grows without end the share 1 - s_0 yields; from it is taken what has yet to.
    """
    n, width = np.arange(1, modes + 1), walls[0] + walls[1]
    now = 2 / width * np.sin(np.pi * n * s0) * np.exp(-0.5 * variance * (np.pi * n / width) ** 2)
    return SineExpansion(
        amplitudes=now,
        density_at_yield=0.0,
        area_plastic=float(1 - s0 - width * np.sum(now / (np.pi * n))),
        tensile_limit=walls[0],
        yield_stress=walls[1],
        error_estimate=_omitted(modes, variance, width) + np.finfo(float).eps,
    )


def _free(below: _Limit, above: _Limit, pressure: float, end: float) -> float:
    """Find how long the distribution is a Gaussian whose tails beyond 8 deviations no wall has cut."""
    start = end
    for _ in range(200):
        gap = min(pressure + below(start), above(start) - pressure)
        if start <= (max(gap, 0.0) / 8) ** 2:
            break
        start /= 2
    return start


def _moving(
    below: _Limit, above: _Limit, pressure: float, span: tuple[float, float], *, modes: int, tolerance: float
) -> SineExpansion:
    """Integrate the sine coefficients of P, and the yielded area, between moving walls up to V = end.

    P does not vanish at s = 0, so its series may not be differentiated term by term there: what this leaves
    of the second derivative is n pi P_Y / sigma_b^2, and the flux is taken from P less its ramp.
    """
    n, (start, end) = np.arange(1, modes + 1), span
    width = below(start) + above(start)
    middle = np.sin(np.pi * n * (above(start) - pressure) / width)
    gaussian = 2 / width * middle * np.exp(-0.5 * start * (np.pi * n / width) ** 2)
    stretch, shift = _coupling(modes)
    # Of a ramp the truncated matrices are poor: s d/ds and d/ds of 1 - s, less what they make of it.
    ramp, alternate = 2 / (np.pi * n), (-1.0) ** n
    ramp_moved = (alternate * ramp - stretch @ ramp, (alternate - 1) * ramp - shift @ ramp)
    h = 1e-6 * end

    def slope(wall: _Limit, v: float) -> float:
        low, high = max(v - h, 0.0), v + h
        return (wall(high) - wall(low)) / (high - low)

    # Each iteration of Radau's method asks again at the three places of its step.
    @functools.lru_cache(maxsize=4)
    def matrix(v: float) -> Array:
        width, upper = below(v) + above(v), max(slope(above, v), 0.0)
        both = upper + slope(below, v)
        result = np.zeros((modes + 1, modes + 1))
        result[:modes, :modes] = both / width * stretch - upper / width * shift
        diagonal = np.arange(modes)
        result[diagonal, diagonal] -= 0.5 * (np.pi * n / width) ** 2
        # P_Y = 2 sigma_Y' A_pl, and dA_pl/dV = -sigma_Y' P_Y + P_s(0) / (2 sigma_b).
        moved = ramp_moved[0] * both / width - ramp_moved[1] * upper / width
        result[:modes, modes] = 2 * upper * (moved + np.pi * n / width / width)
        result[modes, :modes] = np.pi * n / (2 * width)
        result[modes, modes] = -2 * upper * (upper + (2 * modes + 1) / (2 * width))
        return result

    scale = np.append(np.full(modes, 2 / width), 1.0)
    state = np.append(gaussian, 0.0)
    if start < end:
        solution = solve_ivp(
            lambda v, a: matrix(v) @ a,
            span,
            state,
            method="Radau",
            jac=lambda v, a: matrix(v),
            t_eval=[end],
            rtol=tolerance,
            atol=tolerance * 1e-3 * scale,
        )
        if not solution.success:
            raise NotConverged(f"sine expansion: {solution.message}")
        state = solution.y[:, -1]
    plastic = float(state[-1])
    density = 2 * max(slope(above, end), 0.0) * plastic
    return SineExpansion(
        amplitudes=state[:-1] - density * ramp,
        density_at_yield=density,
        area_plastic=plastic,
        tensile_limit=below(end),
        yield_stress=above(end),
        error_estimate=math.nan,
    )


def _wall(name: str, wall: float | _Limit) -> _Limit:
    if not callable(wall):
        value = float(non_negative(name, within(name, wall, "[0, inf)")))
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
