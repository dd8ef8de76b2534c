"""Heights of a periodic surface, and the trigonometric interpolant between them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
import scipy.fft
from numpy.typing import ArrayLike

from fem_contact._checks import (
    GREATEST,
    array,
    doubles,
    function,
    pair,
    positive,
    room_for,
    shown,
    whole,
    within,
)
from fem_contact._types import Array, Complex, Lengths, Numbers, Shape
from fem_contact.errors import InvalidInput


@dataclass(frozen=True, kw_only=True, eq=False)
class HeightField:
    """Heights of a periodic surface on a grid, positive towards the elastic body.

    Between its points the surface is the trigonometric interpolant of the heights; `resampled`, `shifted` and
    the moments refer to that interpolant, so none of them depends on a difference formula.

    Parameters
    ----------
    heights : (nx, ny) array
        Heights [m] at x = i Lx/nx, y = j Ly/ny. Copied and made read-only.
    lengths : tuple of float
        Periods (Lx, Ly) [m].

    Raises
    ------
    InvalidInput
        For heights that are not a finite two-dimensional array, or periods that are not positive.

    Examples
    --------
    >>> x = np.arange(8) / 8
    >>> wave = HeightField(heights=np.cos(2 * np.pi * x)[:, None] * np.ones(6), lengths=(1.0, 1.0))
    >>> round(wave.rms_gradient / (2 * np.pi * wave.rms_height), 12)
    1.0
    """

    heights: Array
    lengths: Lengths

    def __post_init__(self) -> None:
        heights = np.array(doubles("heights", self.heights))
        if heights.ndim != 2 or heights.size == 0:
            raise InvalidInput(f"heights of shape {heights.shape}: must be a two-dimensional array (nx, ny)")
        bad = np.count_nonzero(~np.isfinite(heights))
        if bad:
            raise InvalidInput(
                f"{bad} of {heights.size} heights are NaN or infinite: fill or remove them first"
            )
        highest = float(np.max(np.abs(heights)))
        if highest > GREATEST:
            raise InvalidInput(
                f"heights: {highest:.6g} m is no height; at most {GREATEST:g} m can be computed with"
            )
        lengths = checked_lengths(self.lengths)
        heights.setflags(write=False)
        object.__setattr__(self, "heights", heights)
        object.__setattr__(self, "lengths", lengths)

    def __reduce__(self) -> tuple[object, ...]:
        # Unpickled arrays are writable: build the copy anew.
        return partial(type(self), heights=self.heights, lengths=self.lengths), ()

    @property
    def shape(self) -> Shape:
        """Number of grid points (nx, ny)."""
        nx, ny = self.heights.shape
        return nx, ny

    @property
    def spacing(self) -> Lengths:
        """Grid spacing (dx, dy) [m]."""
        return self.lengths[0] / self.shape[0], self.lengths[1] / self.shape[1]

    @cached_property
    def rms_height(self) -> float:
        """Root mean square height about the mean plane, over the grid points [m]."""
        return float(np.std(self.heights))

    @cached_property
    def moments(self) -> tuple[float, float, float]:
        """Discrete spectral moments (m0 [m^2], m2 [1], m4 [m^-2]): sums over the wavevectors of the period.

        They are the moments of this one realisation, to be told from the integrals over C(q).

        Raises
        ------
        InvalidInput
            For heights so large over periods so short that m4 leaves the range of the arithmetic.
        """
        power, qx, qy = self._power()
        # q^4 alone leaves the range of the arithmetic below 1e-77 m. A power of two changes no digit.
        exponent = int(np.frexp(max(np.abs(qx).max(), np.abs(qy).max()))[1])
        qx2, qy2 = np.ldexp(qx, -exponent) ** 2, np.ldexp(qy, -exponent) ** 2
        rows, columns = power.sum(axis=1), power.sum(axis=0)
        m2 = rows @ qx2 + columns @ qy2
        m4 = rows @ qx2**2 + 2 * (qx2 @ power @ qy2) + columns @ qy2**2
        try:
            return float(rows.sum()), math.ldexp(m2, 2 * exponent), math.ldexp(m4, 4 * exponent)
        except OverflowError:
            raise InvalidInput(
                f"heights up to {np.abs(self.heights).max():.3g} m over periods of {shown(self.lengths)} m: "
                "their curvatures leave the range of the arithmetic: choose another unit, or check the file's"
            ) from None

    def spectral_sum(self, weight: Callable[[Array], ArrayLike]) -> float:
        r"""Sum over the wavevectors of the period of |h(q)|^2 f(|q|), the mean height left out.

        .. math:: \sum_{\mathbf q \ne 0} |h(\mathbf q)|^2 f(|\mathbf q|),\qquad
                  h(\mathbf x) = \sum_{\mathbf q} h(\mathbf q)\, e^{i \mathbf q \cdot \mathbf x}

        Parameters
        ----------
        weight : callable
            f for an array of positive q [1/m]. With f = 1 the sum is m0, with q^2 the mean square gradient,
            with (E*/4) q the elastic energy per area of a half-space in full contact.

        Raises
        ------
        InvalidInput
            If f does not give one finite real number for every q.

        Examples
        --------
        >>> x = np.arange(16) / 16
        >>> wave = HeightField(heights=np.cos(2 * np.pi * x)[:, None] * np.ones(4), lengths=(1.0, 0.25))
        >>> round(wave.spectral_sum(lambda q: q) / (2 * np.pi), 12)
        0.5
        """
        function("weight", weight)
        power, qx, qy = self._power()
        q = np.hypot(qx[:, None], qy[None, :]).ravel()[1:]
        values = array("weight(q)", weight(q), power=6)
        if values.shape not in ((), q.shape):
            raise InvalidInput(f"weight(q) of shape {values.shape}: must be of shape {q.shape}")
        return float(np.sum(values * power.ravel()[1:]))

    def _power(self) -> tuple[Array, Array, Array]:
        """|h(q)|^2 [m^2] of half of the wavevectors, counted for both signs, and both components [1/m]."""
        nx, ny = self.shape
        power = np.abs(scipy.fft.rfft2(self.heights, norm="forward")) ** 2
        # The half spectrum stands for both signs of q_y; the Nyquist waves of the interpolant are split in
        # two halves.
        power[:, 1 : (ny + 1) // 2] *= 2
        if ny % 2 == 0 and ny > 1:
            power[:, -1] *= 0.5
        if nx % 2 == 0 and nx > 1:
            power[nx // 2] *= 0.5
        power[0, 0] = 0
        return power, *wavevectors(self.shape, self.lengths)

    @property
    def rms_gradient(self) -> float:
        """Root mean square gradient h'_rms, both directions together, by spectral differentiation [-]."""
        return float(np.sqrt(self.moments[1]))

    @property
    def nayak(self) -> float:
        """Nayak parameter alpha = (3/2) m0 m4 / m2^2 of this realisation."""
        m0, m2, m4 = self.moments
        if m2 == 0:
            raise InvalidInput("the Nayak parameter of a flat surface is undefined")
        return 1.5 * m0 * m4 / m2**2

    def resampled(self, shape: Shape) -> HeightField:
        """Return this surface's trigonometric interpolant sampled on another grid: exact, finer or coarser.

        A coarser grid that does not resolve the surface gets its true point values, short waves included.
        """
        return self._sampled(checked_shape(shape), (0.0, 0.0))

    def shifted(self, fraction: tuple[float, float]) -> HeightField:
        """Return h(x + fraction * spacing) on the same grid: what a grid moved by parts of a cell sees."""
        part = partial(within, interval="[-1e9, 1e9]")
        parts = pair("fraction", fraction, part, what="two finite parts of a cell (x, y)")
        return self._sampled(self.shape, parts)

    def _sampled(self, shape: Shape, fraction: tuple[float, float]) -> HeightField:
        spectrum = scipy.fft.fft2(self.heights, norm="forward")
        for axis, (n, old) in enumerate(zip(shape, self.shape, strict=True)):
            # Waves beyond the new Nyquist limit fold back.
            numbers, slots, weights = _wave_numbers(old)
            factors = weights * np.exp(2j * np.pi * numbers * fraction[axis] / old)
            waves = np.moveaxis(spectrum, axis, 0)[slots] * factors[:, None]
            folded = np.zeros((n, waves.shape[1]), dtype=complex)
            np.add.at(folded, numbers % n, waves)
            spectrum = np.moveaxis(folded, 0, axis)
        heights = scipy.fft.ifft2(spectrum, norm="forward").real
        return HeightField(heights=heights, lengths=self.lengths)


@dataclass(frozen=True, kw_only=True, eq=False)
class Patch(HeightField):
    """Heights of one patch of a surface with its edges: opposite ones need not match, nothing is periodic.

    Points are the centres of nx x ny cells that fill the patch. Slopes are differences between neighbours;
    between the points the surface is a cubic spline; `spectral_sum` is that under a Hann window.

    Parameters
    ----------
    heights : (nx, ny) array
        Heights [m] at x = (i + 1/2) Lx/nx, y = (j + 1/2) Ly/ny.
    lengths : tuple of float
        Sides (Lx, Ly) [m].

    Examples
    --------
    >>> slope = Patch(heights=np.arange(6.0)[:, None] * np.ones(4), lengths=(12.0, 4.0))
    >>> slope.rms_gradient
    0.5
    """

    @cached_property
    def moments(self) -> tuple[float, float, float]:
        """Mean squares of height [m^2], gradient [1] and Laplacian [m^-2], the latter two by differences."""
        (nx, ny), (dx, dy) = self.shape, self.spacing
        gradient, bent = 0.0, np.zeros((max(nx - 2, 0), max(ny - 2, 0)))
        for axis, step in ((0, dx), (1, dy)):
            slopes = np.diff(self.heights, axis=axis) / step
            gradient += float(np.mean(slopes**2)) if slopes.size else 0.0
            inner = (slice(None), slice(1, -1)) if axis == 0 else (slice(1, -1), slice(None))
            bent += np.diff(slopes, axis=axis)[inner] / step if bent.size else 0.0
        return self.rms_height**2, gradient, float(np.mean(bent**2)) if bent.size else 0.0

    def _power(self) -> tuple[Array, Array, Array]:
        return self.windowed()._power()

    def windowed(self) -> HeightField:
        """Return the heights under a Hann window of mean square 1, which may be repeated."""
        sides = (
            np.sqrt(8 / 3) * np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2 if n > 1 else np.ones(1)
            for n in self.shape
        )
        weights = np.multiply.outer(*sides)
        mean = float(np.mean(weights * self.heights) / np.mean(weights))
        return HeightField(heights=weights * (self.heights - mean), lengths=self.lengths)

    def _sampled(self, shape: Shape, fraction: tuple[float, float]) -> HeightField:
        if fraction != (0.0, 0.0):
            raise InvalidInput("a patch with edges cannot be moved under the grid: resample it")
        if shape == self.shape:
            return self
        from scipy.interpolate import make_interp_spline

        heights = self.heights
        for axis, (new, old) in enumerate(zip(shape, self.shape, strict=True)):
            if new != old:
                spline = make_interp_spline(np.arange(old) + 0.5, heights, k=min(3, old - 1), axis=axis)
                heights = spline((np.arange(new) + 0.5) * (old / new))
        return Patch(heights=heights, lengths=self.lengths)


def checked_shape(shape: object) -> Shape:
    """Return two positive whole numbers (nx, ny) of points that fit into memory, or refuse."""
    points = checked_counts(shape)
    room_for(f"shape = {points}", needed=48.0 * points[0] * points[1])
    return points


def checked_counts(counts: object, name: str = "shape") -> Shape:
    """Return two positive whole numbers (nx, ny), or refuse."""

    def count(name: str, value: object) -> int:
        given = int(value) if isinstance(value, float) and value % 1 == 0 else value
        return whole(name, given, least=1, most=2**24)

    return pair(name, counts, count, what="two positive whole numbers (nx, ny), at most 2^24 each")


def checked_lengths(lengths: object) -> Lengths:
    """Return two positive, finite periods [m], or refuse."""
    return pair("lengths", lengths, positive, what="two positive periods (Lx, Ly) in m")


def wavevectors(shape: Shape, lengths: Lengths) -> tuple[Array, Array]:
    """Components [1/m] along both axes of the waves of a half spectrum, as `scipy.fft.rfft2` has them."""
    (nx, ny), (lx, ly) = shape, lengths
    return 2 * np.pi * scipy.fft.fftfreq(nx, lx / nx), 2 * np.pi * scipy.fft.rfftfreq(ny, ly / ny)


def _wave_numbers(n: int) -> tuple[Numbers, Numbers, Array]:
    """Integer wave numbers of n points, their FFT slots and weights; the Nyquist wave is split into +-n/2."""
    numbers = np.arange(n) - n // 2
    weights = np.ones(n)
    if n % 2 == 0:
        numbers = np.append(numbers, n // 2)
        weights = np.append(weights, 0.5)
        weights[0] = 0.5
    return numbers, numbers % n, weights


def interpolant(surface: HeightField) -> tuple[Array, Array, Complex]:
    """Wavevectors [1/m] along both axes and Fourier coefficients [m] of the trigonometric interpolant."""
    spectrum = scipy.fft.fft2(surface.heights, norm="forward")
    (mx, sx, wx), (my, sy, wy) = (_wave_numbers(n) for n in surface.shape)
    coefficients = spectrum[np.ix_(sx, sy)] * wx[:, None] * wy[None, :]
    unit_x, unit_y = (2 * np.pi / length for length in surface.lengths)
    qx, qy = (np.multiply(numbers, unit, dtype=np.float64) for numbers, unit in ((mx, unit_x), (my, unit_y)))
    return qx, qy, coefficients
