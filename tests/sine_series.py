"""P(sigma) between two walls as a sine series (Persson 2006, Sec. 9): what the diffusion solver is held to.

Exact for walls that stand still, slow and of algebraic accuracy for walls that move. Eq. 52 has here the term
of a moving sigma_Y that the paper leaves out; where sigma_Y rises P(sigma_Y) = 2 A_pl dsigma_Y/dV (Eq. 34),
and the yielded area of Eq. 33 is one more unknown.
"""

import numpy as np
from scipy.integrate import solve_ivp


class SineSeries:
    """P(sigma) = P_Y (1 - s) + sum A_n sin(n pi s), s = (sigma_Y - sigma) / (sigma_Y + sigma_a), at one V."""

    def __init__(self, amplitudes, walls, *, plastic, at_yield=0.0):
        self.amplitudes, self.walls = amplitudes, walls
        self.area_plastic, self.density_at_yield = float(plastic), at_yield
        n = np.arange(1, amplitudes.size + 1)
        mean = np.where(n % 2 == 1, 2 / (np.pi * n), 0.0) @ amplitudes + at_yield / 2
        self.area_elastic = float(sum(walls) * mean)

    def distribution(self, stress):
        s = (self.walls[1] - stress) / sum(self.walls)
        n = np.arange(1, self.amplitudes.size + 1)
        series = np.sin(np.pi * s[..., None] * n) @ self.amplitudes + self.density_at_yield * (1 - s)
        return np.where((s > 0) & (s < 1), series, 0.0)


def between_still_walls(variance, *, pressure, below, above, modes):
    n, width, s0 = np.arange(1, modes + 1), below + above, (above - pressure) / (below + above)
    now = 2 / width * np.sin(np.pi * n * s0) * np.exp(-0.5 * variance * (np.pi * n / width) ** 2)
    plastic = 1 - s0 - width * np.sum(now / (np.pi * n))
    return SineSeries(now, (below, above), plastic=plastic)


def between_moving_walls(variance, *, pressure, below, above, modes, tolerance=1e-9):
    """Integrate the coefficients of P, and the yielded area, from a Gaussian that no wall has cut.

    P does not vanish at s = 0, so its series may not be differentiated term by term there: what this leaves
    of the second derivative is n pi P_Y / sigma_b^2, and the flux is taken from P less its ramp.
    """
    n, start, h = np.arange(1, modes + 1), variance, 1e-6 * variance
    while start > (min(pressure + below(start), above(start) - pressure) / 8) ** 2:
        start /= 2
    width = below(start) + above(start)
    middle = np.sin(np.pi * n * (above(start) - pressure) / width)
    gaussian = 2 / width * middle * np.exp(-0.5 * start * (np.pi * n / width) ** 2)
    # Matrices of s d/ds and d/ds in the basis; of a ramp they are poor, and told what they miss of it.
    plus, minus = n[:, None] + n, n[:, None] - n
    apart, sign = np.where(minus == 0, 1, minus), (-1.0) ** plus
    stretch = -n * (sign / plus + np.where(minus == 0, 0.0, sign / apart))
    shift = n * ((1 - sign) / plus + np.where(minus == 0, 0.0, (1 - sign) / apart))
    ramp, alternate = 2 / (np.pi * n), (-1.0) ** n
    missed = alternate * ramp - stretch @ ramp, (alternate - 1) * ramp - shift @ ramp

    def rise(wall, v):
        low, high = max(v - h, 0.0), v + h
        return (wall(high) - wall(low)) / (high - low)

    def matrix(v):
        width, upper = below(v) + above(v), rise(above, v)
        both = upper + rise(below, v)
        result = np.zeros((modes + 1, modes + 1))
        result[:modes, :modes] = both / width * stretch - upper / width * shift
        result[n - 1, n - 1] -= 0.5 * (np.pi * n / width) ** 2
        moved = missed[0] * both / width - missed[1] * upper / width
        result[:modes, modes] = 2 * upper * (moved + np.pi * n / width / width)
        result[modes, :modes] = np.pi * n / (2 * width)
        result[modes, modes] = -2 * upper * (upper + (2 * modes + 1) / (2 * width))
        return result

    solution = solve_ivp(
        lambda v, a: matrix(v) @ a,
        (start, variance),
        np.append(gaussian, 0.0),
        method="Radau",
        jac=lambda v, a: matrix(v),
        t_eval=[variance],
        rtol=tolerance,
        atol=tolerance * 1e-3 * np.append(np.full(modes, 2 / width), 1.0),
    )
    *amplitudes, plastic = solution.y[:, -1]
    density = 2 * rise(above, variance) * plastic
    walls = below(variance), above(variance)
    return SineSeries(amplitudes - density * ramp, walls, plastic=plastic, at_yield=density)
