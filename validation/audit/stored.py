"""One stored solve: its fields, and what they say by definition."""

from __future__ import annotations

import json
import math
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial.polynomial import polyval2d
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from validation.netcdf import read_dataset

Array = NDArray[Any]
Grid = tuple[int, int]
Pair = tuple[float, float]
#: (m0, m2, m4) of heights.
Moments = tuple[float, float, float]

#: Excess of the counted area per edge and cell, by the element that the result names.
EDGE_CONSTANTS = {
    **{"bem": 0.103, "bem free": 0.090},
    **{"Hex1": 0.198, "Hex1/P0": 0.260, "Hex2": 0.137, "Hex2/P1disc": 0.205},
}
#: Methods of point values, by which an edge is located.
_LOCATING = {"bem", "tamaas", "contact_mechanics", "aspher"}
#: The edge map of boundary elements: powers of v in rows, of the squared cosine in columns.
EDGE_MAP = np.array(
    [
        [-0.57804, 1.22766, -0.82019],
        [1.27074, -2.94378, 1.77380],
        [4.62251, -4.40885, 3.91618],
        [-7.25598, 13.76495, -10.79373],
        [0.11590, -1.55225, 1.97152],
        [2.48050, -5.54267, 3.60049],
    ]
)
#: Its second part, by powers of p^2 over that of the next cell inside, and g^(2/3) over that outside.
EDGE_BEND = {
    (0, 0): [[2.10991, -1.80106], [-3.88063, 2.65368], [1.23854, -0.25162]],
    (1, 0): [[2.49617, -3.74519], [-5.24840, 9.41387], [3.91695, -7.03929]],
    (0, 1): [[-4.54312, 3.54819], [5.82276, -1.00854], [0.03129, -4.91374]],
    (2, 0): [[-1.22142, 1.87669], [3.41495, -5.69656], [-2.64113, 4.33557]],
    (0, 2): [[1.42208, -0.76705], [-0.81988, -2.89520], [-1.04937, 4.65555]],
    (1, 1): [[-1.83037, 2.96412], [2.64263, -5.25835], [-4.54529, 6.66232]],
}


def wavevectors(shape: tuple[int, ...], lengths: Pair) -> Array:
    """|q| [1/m] of each term of a discrete Fourier transform."""
    qx, qy = (2 * np.pi * np.fft.fftfreq(n, length / n) for n, length in zip(shape, lengths, strict=True))
    return np.sqrt(qx[:, None] ** 2 + qy[None, :] ** 2)


def moments(heights: Array, lengths: Pair) -> Moments:
    """(m0, m2, m4): sums of q^0, q^2, q^4 times the power of each wave of the interpolant but the mean."""
    power = np.abs(np.fft.fft2(heights)) ** 2 / heights.size**2
    power[0, 0] = 0.0
    nx, ny = heights.shape
    # A wave of two points is +-1 on them, and between them a cosine: half the mean square.
    if nx % 2 == 0:
        power[nx // 2, :] /= 2
    if ny % 2 == 0:
        power[:, ny // 2] /= 2
    q = wavevectors(heights.shape, lengths)
    m0, m2, m4 = (np.sum(q**k * power) for k in (0, 2, 4))
    return m0, m2, m4


#: Mean of cos 8 theta that contours of rough contacts have, too.
_ROUGH = 0.4


class Stored:
    """Fields of one solve, from the content of its netCDF file."""

    def __init__(self, content: memoryview) -> None:
        data = read_dataset(content)
        fields, attrs = {str(name): values.values for name, values in data.variables.items()}, data.attrs
        self.recipe: dict[str, Any] = json.loads(attrs["recipe"])
        self.provenance: dict[str, str] = json.loads(attrs["provenance"])
        self.cost: dict[str, float] = json.loads(attrs["cost"])
        self.stored_residuals: dict[str, float] = json.loads(attrs["residuals"])
        self.attrs = attrs
        self.effects: dict[str, dict[str, Any]] = {
            effect["kind"]: effect for effect in self.recipe["effects"]
        }
        self.lengths: Pair = (float(attrs["lengths"][0]), float(attrs["lengths"][1]))
        self.modulus = float(attrs["contact_modulus"])
        self.p, self.gap = fields["pressure"], fields["gap"]
        self.u, self.h = fields["displacement"], fields["heights"]
        self.contact = fields["contacting_points"] == 1
        self.bound = fields["at_bound"] == 1
        self.weights = fields.get("weights", np.ones(self.p.shape))
        self.method = str(self.recipe["method"])
        #: Shares of the nominal area in contact, and at the pressure bound.
        self.pixel, self.plastic = self.mean(self.contact), self.mean(self.bound)
        #: Whether its surroundings are free, not periodic.
        self.free = self.provenance.get("method", "").endswith("free surroundings")
        #: Points along x and y, their number, the spacing [m], and the shift in parts of a cell.
        self.grid: Grid = (self.p.shape[0], self.p.shape[1])
        self.cells = int(self.p.size)
        self.spacing = (self.lengths[0] / self.grid[0], self.lengths[1] / self.grid[1])
        self.shift: Pair = (float(self.recipe["shift"][0]), float(self.recipe["shift"][1]))

    def mean(self, values: Array) -> float:
        """Mean over the nominal area, of points by their weight."""
        return float(np.sum(self.weights * values) / self.p.size)

    @cached_property
    def moments(self) -> Moments:
        """(m0, m2, m4) of the heights."""
        return moments(self.h, self.lengths)

    @cached_property
    def roughness(self) -> Moments:
        """(m0, m2, m4) of the heights without the ball they lie on."""
        radius = self.effects.get("free-boundary", {}).get("radius")
        if not radius:
            return self.moments
        x, y = ((np.arange(n) - n / 2) * d for n, d in zip(self.grid, self.spacing, strict=True))
        return moments(self.h + (x[:, None] ** 2 + y[None, :] ** 2) / (2 * radius), self.lengths)

    @cached_property
    def edges(self) -> float:
        """Cell edges between contact and none, over the number of cells."""
        c = self.contact
        rows = (np.moveaxis(c != np.roll(c, 1, axis), axis, 0)[self.free :] for axis in (0, 1))
        return float(sum(map(np.sum, rows)) / c.size)

    @property
    def perimeter(self) -> float:
        """Counted area less the edge constant for each edge."""
        constant = EDGE_CONSTANTS[self.provenance.get("element", "bem free" if self.free else "bem")]
        return self.pixel - constant * self.edges

    @property
    def located(self) -> bool:
        """Whether its area is the one whose edge is located inside square cells of an elastic half-space."""
        square = abs(self.spacing[0] / self.spacing[1] - 1) <= 0.05
        return square and self.method in _LOCATING and not self.effects

    @cached_property
    def density_at_zero(self) -> float:
        """Share below eps = 0.2 E* h' sqrt(dx / l), l = 2 pi sqrt(m2 / m4), over eps; times E* h'."""
        if self.free:
            return math.nan
        _, m2, m4 = self.moments
        stress = self.modulus * math.sqrt(m2)
        step = math.sqrt(math.prod(self.spacing))
        eps = 0.2 * stress * math.sqrt(step / (2 * math.pi * math.sqrt(m2 / m4)))
        if np.any(self.bound & (self.p < eps)):
            return math.nan
        return self.mean(self.contact & (self.p < eps)) / eps * stress

    def residuals(self, pressure: float) -> dict[str, float] | None:
        """Return the residuals, dimensionless, at a load [Pa]; None under a law that is not read here.

        Under attraction the wall alone must push, p + attraction(g) >= 0, and only where the gap is closed;
        what has yielded carries H.
        """
        if "adhesion" in self.effects:
            return self._adhesive_residuals(pressure)
        height, stress = np.std(self.h), self.modulus * math.sqrt(self.moments[1])
        force, closed = self.weights * self.p, np.where(self.bound, 0.0, self.gap)
        return {
            "penetration": max(0.0, -closed.min()) / height,
            "tension": max(0.0, -self.p.min()) / stress,
            "complementarity": float(np.sum(np.abs(force * closed)) / (np.sum(np.abs(force)) * height)),
        }

    def _adhesive_residuals(self, pressure: float) -> dict[str, float] | None:
        adhesion = self.effects["adhesion"]
        if adhesion.get("law", "exponential") != "exponential" or math.isnan(pressure):
            return None
        strength = adhesion["work"] / adhesion["reach"]
        wall = self.p + strength * np.exp(-np.maximum(self.gap, 0.0) / adhesion["reach"])
        hardness = self.effects.get("hardness", {}).get("hardness", math.inf)
        yielded = (self.gap < 0) & (hardness < math.inf)
        off = np.where(yielded, self.p - hardness, wall)
        height = math.sqrt(self.moments[0])
        stress = max(strength, math.sqrt(np.mean(self.p**2)))
        return {
            "penetration": max(0.0, -self.gap[~yielded].min(initial=0.0)) / height,
            "tension": max(0.0, -wall.min()) / (self.modulus * math.sqrt(self.moments[1])),
            "complementarity": np.mean(np.abs(off * self.gap)) / (stress * height),
            "load": abs(self.mean_pressure - pressure) / stress,
        }

    @cached_property
    def mean_pressure(self) -> float:
        """Force over nominal area [Pa]."""
        return self.mean(self.p)

    @cached_property
    def _edge_directions(self) -> list[tuple[int, int, Array, Array]]:
        """(axis, sign, contact cells, cosine) of the edges on each side, by the smoothed map."""
        inside, d = self.contact, self.spacing
        smooth = gaussian_filter(inside.astype(float), 1.5, mode="wrap", truncate=4.0)
        slope = [(np.roll(smooth, 1, k) - np.roll(smooth, -1, k)) / d[k] for k in (0, 1)]
        found = []
        for axis, sign in ((0, 1), (0, -1), (1, 1), (1, -1)):
            edge = inside & ~np.roll(inside, -sign, axis)
            normal = [(s + np.roll(s, -sign, axis))[edge] for s in slope]
            length = np.hypot(*normal)
            cosine = sign * normal[axis] / np.where(length == 0, 1.0, length)
            found.append((axis, sign, edge, np.clip(cosine, 0.05, 1.0)))
        return found

    @cached_property
    def subcell(self) -> float:
        """A/A0 with the edge located inside its cells.

        Towards the edge the pressure vanishes as s^(1/2) of the distance s, the gap behind it as s^(3/2).
        With rho = E* g / (p dx cos), v = 1 / (1 + rho^(2/3)) says where between two points the edge lies.
        EDGE_MAP turns it into cells, EDGE_BEND adds what the points next to these two say. Counting puts
        it at 1/2.
        """
        moved = 0.0
        for axis, sign, edge, cosine in self._edge_directions:
            gap = np.maximum(np.roll(self.gap, -sign, axis)[edge], 0.0)
            with np.errstate(divide="ignore", invalid="ignore"):
                rho = self.modulus * gap / (self.p[edge] * self.spacing[axis] * cosine)
            rho = np.where(self.p[edge] > 0, rho, np.inf)
            v = 1 / (1 + np.cbrt(rho) ** 2)
            place = np.clip(polyval2d(v, cosine**2, EDGE_MAP), -0.6, 1.2)
            within = _bounded_power(self.p[edge], np.roll(self.p, sign, axis)[edge], 2)
            without = _bounded_power(gap, np.roll(self.gap, -2 * sign, axis)[edge], 2 / 3)
            for (a, b), rows in EDGE_BEND.items():
                place = place + polyval2d(v, cosine**2, np.array(rows)) * within**a * without**b
            moved += np.sum((place - 0.5) * cosine**2)
        return float((np.sum(self.contact) + moved) / self.contact.size)

    @cached_property
    def alignment(self) -> float:
        """0 for a contour of all directions, 1 for a line: from the mean of cos 8 theta.

        Rough contacts have a mean of up to `_ROUGH`, which counts as none: limits are calibrated so.
        """
        angle = np.arccos(np.concatenate([cosine for *_, cosine in self._edge_directions]))
        if not angle.size:
            return 0.0
        weight = np.cos(angle) ** 2
        uneven = abs(np.sum(weight * np.cos(8 * angle))) / weight.sum()
        return float(np.clip((uneven - _ROUGH) / (1 - _ROUGH), 0.0, 1.0))

    @cached_property
    def _waves(self) -> tuple[Array, Array, Array, Array]:
        """Power of the heights, wavevectors along x and y, and which of them have less than four points."""
        window = np.outer(*map(np.hanning, self.grid)) if self.free else 1.0
        power = np.abs(np.fft.fft2((self.h - np.mean(self.h)) * window)) ** 2
        each = (2 * np.pi * np.fft.fftfreq(n, dx) for n, dx in zip(self.grid, self.spacing, strict=True))
        x, y = np.meshgrid(*each, indexing="ij")
        dx, dy = self.spacing
        return power, x, y, np.hypot(x * dx, y * dy) > np.pi / 2 * (1 + 1e-9)

    @cached_property
    def anisotropy(self) -> float:
        """1 less the root of the ratio of least and largest mean square slope."""
        power, x, y, _ = self._waves
        # A wave of two points runs either way.
        mixed = np.sum((power * x * y)[np.fft.fftfreq(self.grid[0]) > -0.5])
        least, largest = np.linalg.eigvalsh([[np.sum(power * x * x), mixed], [mixed, np.sum(power * y * y)]])
        return 1 - math.sqrt(max(least, 0.0) / largest) if largest > 0 else 0.0

    @cached_property
    def unresolved(self) -> float:
        """Share of the mean square curvature in waves of less than four points."""
        power, x, y, beyond = self._waves
        curvature = power * (x**2 + y**2) ** 2
        return float(np.sum(curvature[beyond]) / np.sum(curvature)) if np.any(curvature) else 0.0

    @cached_property
    def wavenumber(self) -> float:
        """Root of the sixth over the fourth moment, times the spacing."""
        power, x, y, _ = self._waves
        fourth, sixth = (np.sum(power * (x**2 + y**2) ** k) for k in (2, 3))
        step = math.sqrt(math.prod(self.spacing))
        return math.sqrt(sixth / fourth) * step if fourth > 0 else 0.0


def _bounded_power(one: Array, other: Array, power: float) -> Array:
    """(one / other)^power, at most 1.5, as where the other is nothing."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(other > 0, np.maximum(one, 0.0) / other, np.inf)
    return np.minimum(ratio**power, 1.5)
