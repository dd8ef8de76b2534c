"""A measured patch of a surface: levelled, filled, made periodic; every step is written down."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from fem_contact.surface import HeightField
from fem_contact.surface.spectra import window_weights
from validation.arrays import Array, Pair
from validation.errors import UsageError
from validation.report.quantities import as_length

Tilt = Literal["keep", "plane", "quadratic"]
Missing = Literal["refuse", "nearest", "harmonic"]
Edges = Literal["periodic", "tukey", "hann", "free"]
#: What keeps a map from being pressed, and a remedy, by the key of the scene that mends it.
Faults = dict[str, tuple[str, str]]

#: A step between opposite edges of more than this many typical steps between neighbours is no period.
_JUMP = 4.0
#: Share of the variance that a plane holds from which on it is taken for the tilt of the instrument.
REMOVABLE = 0.2
#: Standard deviations beyond which heights are clipped, and the quartiles' distance in them.
_CLIPPED, _QUARTILES = 6.0, 1.349
#: Points of a block of rows that a plane is fitted to at a time.
_BLOCK_POINTS = 2**18
#: Most missing points that a membrane is stretched over; their equations are solved directly.
MOST_HOLES = 2**20


@dataclass(frozen=True, kw_only=True, eq=False)
class Topography:
    """A measured patch: heights [m], NaN where there are none; size [m], number of points times spacing.

    Beside it what was done to it, in words, the unit [m] of its heights in the file, and the SHA-256 of the
    file and of that of the other body.
    """

    heights: Array
    lengths: Pair
    history: tuple[str, ...] = ()
    unit: float = 1.0
    digest: str = ""
    second_digest: str = ""

    def facing(self, other: Topography) -> Topography:
        """Add the heights of another body that was turned over along x to face this one."""
        if other.heights.shape != self.heights.shape or other.lengths != self.lengths:
            (nx, ny), (mx, my) = self.heights.shape, other.heights.shape
            raise UsageError(f"has {mx} x {my} points, the first body {nx} x {ny}: they must be alike")
        words = f"facing {other.history[0]}, turned over along x" if other.history else "facing another"
        return replace(
            self,
            heights=self.heights + other.heights[::-1],
            history=(*self.history, words, *other.history[1:]),
            second_digest=other.digest,
        )

    @property
    def missing(self) -> int:
        """Number of points without a height."""
        return int(np.count_nonzero(~np.isfinite(self.heights)))

    @property
    def slope(self) -> Pair:
        """Slope of the least-squares plane along x and y [-]."""
        coefficients = _fitted(self.heights, "plane")
        nx, ny = self.heights.shape
        return float(coefficients[1]) * nx / self.lengths[0], float(coefficients[2]) * ny / self.lengths[1]

    @property
    def plane_share(self) -> float:
        """Share of the variance of the heights that their least-squares plane holds."""
        known = self.heights[np.isfinite(self.heights)]
        before = float(np.var(known)) if known.size else 0.0
        return 1 - rms(self.levelled("plane").heights) ** 2 / before if before else 0.0

    @property
    def edge_jump(self) -> float:
        """Root mean square step between opposite edges over that between neighbours; about 1 if periodic."""
        both = (rows for rows in (self.heights, self.heights.T) if rows.shape[0] > 2)
        steps = ((rms(rows[0] - rows[-1]), rms(np.diff(rows, axis=0))) for rows in both)
        return max((jump / step for jump, step in steps if step > 0), default=0.0)

    def levelled(self, tilt: Tilt) -> Topography:
        """Take the least-squares plane or quadratic of the known points out."""
        if tilt == "keep":
            return self
        heights = self.heights.copy()
        for coefficient, term in zip(_fitted(heights, tilt), _terms(heights.shape, tilt), strict=True):
            heights -= coefficient * term
        sx, sy = self.slope
        return self._with(f"{tilt} taken out (slope {sx:.3g} along x, {sy:.3g} along y)", heights=heights)

    def faults(self, *, tilt: Tilt | None, missing: Missing, edges: Edges | None, **others: object) -> Faults:
        """Return what keeps it from being pressed: why, and a remedy, by the key of the scene that mends it.

        A plane is looked for first: it makes edges differ that match without it. Where the table names a tilt
        or edges, the choice was made.
        """
        faults: Faults = {}
        count, level = self.missing, self
        if count == self.heights.size:
            raise UsageError("the topography has no known point")
        if edges is None and tilt is None and self.edge_jump > _JUMP and self.plane_share > REMOVABLE:
            words = f"a plane holds {100 * self.plane_share:.3g} % of the variance of its heights"
            faults["tilt"], tilt = (words, "plane"), "plane"
        if tilt is not None:
            level = self.levelled(tilt)
        if count and (missing == "refuse" or (missing == "harmonic" and count > MOST_HOLES)):
            words, remedy = f"{count} of {self.heights.size} heights are NaN or infinite", "harmonic"
            if count > MOST_HOLES:
                words, remedy = f"{words}, and 'harmonic' fills at most {MOST_HOLES}", "nearest"
            faults["missing"] = words, remedy
        if edges is None and level.edge_jump > _JUMP:
            without = " without that plane" if "tilt" in faults else ""
            words = f"{level.edge_jump:.3g} typical steps between neighbours{without}, so this is no period"
            faults["edges"] = f"opposite edges differ by {words}", "tukey"
        return faults

    def filled(self, missing: Missing) -> Topography:
        """Give missing points a height, by choice; with "refuse" they stay, as `faults` has said."""
        count, heights = self.missing, self.heights
        if count == 0 or missing == "refuse":
            return self
        words = f"{count} missing points ({100 * count / heights.size:.2g} %) filled: {missing}"
        if missing == "harmonic":
            return self._with(words, heights=_harmonic(heights))
        from scipy.ndimage import distance_transform_edt

        nearest = distance_transform_edt(~np.isfinite(heights), return_distances=False, return_indices=True)
        return self._with(words, heights=np.asarray(heights[tuple(nearest)]))

    def clipped(self) -> Topography:
        """Bring heights far from all others back to that distance, and single points to their neighbours.

        Far is beyond six standard deviations of the middle half: of all heights, and, above the highest or
        below the lowest of the eight neighbours, of the steps from point to point.
        """
        known = self.heights[np.isfinite(self.heights)]
        most, heights = _far(known), self.heights
        # Where half of all heights are one, as between pillars, no distance is a measure.
        if most > 0:
            heights = np.clip(heights, np.median(known) - most, np.median(known) + most)
        padded = np.pad(heights, 1, constant_values=np.nan)
        nx, ny = heights.shape
        around = [padded[i : i + nx, j : j + ny] for i in range(3) for j in range(3) if (i, j) != (1, 1)]
        steps = np.concatenate([np.diff(heights, axis=axis).ravel() for axis in (0, 1)])
        step = _far(steps[np.isfinite(steps)])
        above, below = np.fmax.reduce(around), np.fmin.reduce(around)
        # Where half of all steps are none, in a map of few digits, no step is a measure.
        if step > 0:
            heights = np.where(heights > above + step, above, heights)
            heights = np.where(heights < below - step, below, heights)
        count = int(np.count_nonzero(np.abs(heights - self.heights) > 0))
        words = f"{count} heights more than {_CLIPPED:g} standard deviations away clipped"
        return self._with(words, heights=heights) if count else self

    def smoothed(self, shortest: float | None) -> Topography:
        """Take waves shorter than this [m] out of one period."""
        if shortest is None:
            return self
        q = [np.fft.fftfreq(n, side / n) for n, side in zip(self.heights.shape, self.lengths, strict=True)]
        waves = np.fft.fft2(self.heights)
        waves[np.hypot(q[0][:, None], q[1]) * shortest > 1 + 1e-9] = 0
        words = f"waves shorter than {as_length(shortest, 4)} taken out"
        return self._with(words, heights=np.fft.ifft2(waves).real)

    def made_periodic(self, edges: Edges | None, *, margin: float) -> Topography:
        """Bring opposite edges together by a taper, or take the patch as one period, or with its edges."""
        if edges is None:
            return self
        if edges == "periodic":
            return self._with(f"taken as periodic (edges differ by {self.edge_jump:.3g} typical steps)")
        if edges == "free":
            return self._with("pressed as one patch, with its edges")
        nx, ny = self.heights.shape
        level = self.heights - float(np.mean(self.heights))
        tapered = window_weights((nx, ny), window=edges, margin=margin) * level
        share = f" over {100 * margin:.3g} % of each side" if edges == "tukey" else ""
        before, after = (as_length(rms(heights), 4) for heights in (level, tapered))
        words = f"made periodic: {edges} taper{share} (h_rms {before} before, {after} after)"
        return self._with(words, heights=tapered)

    def _with(self, words: str, **done: Any) -> Topography:
        """Write down what was done."""
        return replace(self, history=(*self.history, words), **done)

    def height_field(self) -> HeightField:
        """Return the heights as one period of a surface."""
        return HeightField(heights=self.heights, lengths=self.lengths)


def rms(values: Array) -> float:
    """Root mean square of the values that are known."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else 0.0


def _terms(shape: tuple[int, ...], tilt: Tilt) -> list[Array]:
    """Terms of a plane or quadratic at positions in points from the centre; they broadcast to the shape."""
    nx, ny = shape
    x = np.asarray(np.arange(nx) - (nx - 1) / 2, dtype=float)[:, None]
    y = np.asarray(np.arange(ny) - (ny - 1) / 2, dtype=float)[None, :]
    plane: list[Array] = [np.ones((1, 1)), x, y]
    return plane if tilt == "plane" else [*plane, x * x, x * y, y * y]


def _fitted(heights: Array, tilt: Tilt) -> Array:
    """Return the least-squares coefficients over the known points, from blocks of rows brought to triangles.

    The matrix of a whole map, and the copies that a solver makes of it, would take twenty times the map.
    """
    terms = _terms(heights.shape, tilt)
    # Columns of like size: a constant beside squares of thousands would lose digits.
    scale = np.array([max(float(np.abs(term).max()), 1.0) for term in terms])
    triangle = np.zeros((0, len(terms) + 1))
    rows = max(1, _BLOCK_POINTS // heights.shape[1])
    for start in range(0, heights.shape[0], rows):
        part = slice(start, start + rows)
        known = np.isfinite(heights[part])
        columns = [np.broadcast_to(t[part] if t.shape[0] > 1 else t, known.shape)[known] for t in terms]
        block = np.column_stack([*(c / s for c, s in zip(columns, scale, strict=True)), heights[part][known]])
        triangle = np.asarray(np.linalg.qr(np.vstack([triangle, block]), mode="r"))
    return np.asarray(np.linalg.lstsq(triangle[:, :-1], triangle[:, -1], rcond=None)[0] / scale)


def _far(values: Array) -> float:
    low, high = np.percentile(values, (25, 75)) if values.size else (0.0, 0.0)
    return float(_CLIPPED * (high - low) / _QUARTILES)


def _harmonic(heights: Array) -> Array:
    """Fill holes with the discrete harmonic function that continues their rims: a stretched membrane."""
    from scipy.sparse import coo_array
    from scipy.sparse.linalg import spsolve

    hole = ~np.isfinite(heights)
    count = int(np.count_nonzero(hole))
    # Numbers of holes within a frame of -2, which stands for what lies outside the map.
    number = np.pad(np.where(hole, np.cumsum(hole).reshape(hole.shape) - 1, -1), 1, constant_values=-2)
    level = np.pad(heights, 1)
    here = np.flatnonzero(number >= 0)
    there = here[:, None] + np.array([-1, 1, -number.shape[1], number.shape[1]])
    neighbours = number.ravel()[there]
    right = np.sum(level.ravel()[there], axis=1, where=neighbours == -1)
    row, column = np.nonzero(neighbours >= 0)
    rows, columns = np.append(row, np.arange(count)), np.append(neighbours[row, column], np.arange(count))
    values = np.append(np.full(row.size, -1.0), np.count_nonzero(neighbours > -2, axis=1))
    filled = heights.copy()
    filled[hole] = spsolve(coo_array((values, (rows, columns)), shape=(count, count)).tocsr(), right)
    return filled
