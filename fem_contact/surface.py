"""Periodic height fields, and random ones that are the same surface on every grid.

A random surface is a sum of waves (Eq. 1 of Persson 2006). Its random numbers belong to the wavevectors, not
to array positions, so that one seed gives one surface, whatever grid it is sampled on and wherever its
spectrum is cut.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from fem_contact.errors import InvalidInput

__all__ = ["HeightField", "RadialSpectrum", "radial_spectrum", "random_surface", "resolves"]

Array = NDArray[np.float64]
Shape = tuple[int, int]
Lengths = tuple[float, float]

#: Relative slack when a wavevector is compared with a limit it may equal up to rounding.
_EDGE = 1e-12


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
        try:
            heights = np.asarray(self.heights).astype(float, casting="same_kind", copy=True)
        except (TypeError, ValueError) as error:
            raise InvalidInput("heights: must be a two-dimensional array of real numbers") from error
        if heights.ndim != 2 or heights.size == 0:
            raise InvalidInput(f"heights of shape {heights.shape}: must be a two-dimensional array (nx, ny)")
        bad = np.count_nonzero(~np.isfinite(heights))
        if bad:
            raise InvalidInput(
                f"{bad} of {heights.size} heights are NaN or infinite: fill or remove them first"
            )
        lengths = _checked_lengths(self.lengths)
        heights.setflags(write=False)
        object.__setattr__(self, "heights", heights)
        object.__setattr__(self, "lengths", lengths)

    def __reduce__(self) -> tuple[object, ...]:
        # Unpickled arrays are writable: build the copy anew.
        return _height_field, (self.heights, self.lengths)

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
        """
        (nx, ny), (lx, ly) = self.shape, self.lengths
        power = np.abs(scipy.fft.rfft2(self.heights, norm="forward")) ** 2
        # The half spectrum stands for both signs of q_y; the Nyquist waves of the interpolant are split in
        # two halves.
        power[:, 1 : (ny + 1) // 2] *= 2
        if ny % 2 == 0 and ny > 1:
            power[:, -1] *= 0.5
        if nx % 2 == 0 and nx > 1:
            power[nx // 2] *= 0.5
        power[0, 0] = 0
        qx2 = (2 * np.pi * scipy.fft.fftfreq(nx, lx / nx)) ** 2
        qy2 = (2 * np.pi * scipy.fft.rfftfreq(ny, ly / ny)) ** 2
        rows, columns = power.sum(axis=1), power.sum(axis=0)
        m4 = rows @ qx2**2 + 2 * (qx2 @ power @ qy2) + columns @ qy2**2
        return float(rows.sum()), float(rows @ qx2 + columns @ qy2), float(m4)

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
        return self._sampled(_checked_shape(shape), (0.0, 0.0))

    def shifted(self, fraction: tuple[float, float]) -> HeightField:
        """Return h(x + fraction * spacing) on the same grid: what a grid moved by parts of a cell sees."""
        if len(fraction) != 2 or not all(np.isfinite(part) for part in fraction):
            raise InvalidInput(f"fraction = {fraction!r}: must be two finite parts of a cell (x, y)")
        return self._sampled(self.shape, (float(fraction[0]), float(fraction[1])))

    def _sampled(self, shape: Shape, fraction: tuple[float, float]) -> HeightField:
        spectrum = scipy.fft.fft2(self.heights, norm="forward")
        for axis in (0, 1):
            spectrum = _refold(spectrum, shape[axis], fraction[axis], axis)
        heights = scipy.fft.ifft2(spectrum, norm="forward").real
        return HeightField(heights=heights, lengths=self.lengths)


def _height_field(heights: Array, lengths: Lengths) -> HeightField:
    return HeightField(heights=heights, lengths=lengths)


def _checked_shape(shape: Shape) -> Shape:
    if len(shape) != 2 or not all(n >= 1 and n % 1 == 0 for n in shape):
        raise InvalidInput(f"shape = {shape!r}: must be two positive whole numbers (nx, ny)")
    return int(shape[0]), int(shape[1])


def _checked_lengths(lengths: Lengths) -> Lengths:
    if len(lengths) != 2 or not all(np.isfinite(length) and length > 0 for length in lengths):
        raise InvalidInput(f"lengths = {lengths!r}: must be two positive periods (Lx, Ly) in m")
    return float(lengths[0]), float(lengths[1])


def _wave_numbers(n: int) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Integer wave numbers of n points, their FFT slots and weights; the Nyquist wave is split into +-n/2."""
    numbers = np.arange(n) - n // 2
    weights = np.ones(n)
    if n % 2 == 0:
        numbers = np.append(numbers, n // 2)
        weights = np.append(weights, 0.5)
        weights[0] = 0.5
    return numbers, numbers % n, weights


def _refold(spectrum: NDArray[np.complex128], n: int, fraction: float, axis: int) -> NDArray[np.complex128]:
    """Sample the interpolant of one axis at n points: waves beyond the new Nyquist limit fold back."""
    old = spectrum.shape[axis]
    numbers, slots, weights = _wave_numbers(old)
    factors = weights * np.exp(2j * np.pi * numbers * fraction / old)
    waves = np.moveaxis(spectrum, axis, 0)[slots] * factors[:, None]
    folded = np.zeros((n, waves.shape[1]), dtype=complex)
    np.add.at(folded, numbers % n, waves)
    return np.moveaxis(folded, 0, axis)


def _interpolant(surface: HeightField) -> tuple[Array, Array, NDArray[np.complex128]]:
    """Wavevectors [1/m] along both axes and Fourier coefficients [m] of the trigonometric interpolant."""
    spectrum = scipy.fft.fft2(surface.heights, norm="forward")
    (mx, sx, wx), (my, sy, wy) = (_wave_numbers(n) for n in surface.shape)
    coefficients = spectrum[np.ix_(sx, sy)] * wx[:, None] * wy[None, :]
    unit_x, unit_y = (2 * np.pi / length for length in surface.lengths)
    qx, qy = (np.multiply(numbers, unit, dtype=np.float64) for numbers, unit in ((mx, unit_x), (my, unit_y)))
    return qx, qy, coefficients


def resolves(shape: Shape, lengths: Lengths, *, q_short: float) -> bool:
    """Whether a grid resolves waves up to q_short: lambda_short > 2 dx on both axes.

    Examples
    --------
    >>> [resolves((64, 64), (1.0, 1.0), q_short=2 * np.pi * waves) for waves in (31, 32)]
    [True, False]
    """
    return all(
        2 * np.pi / q_short > 2 * length / n * (1 + _EDGE) for n, length in zip(shape, lengths, strict=True)
    )


def random_surface(
    spectrum: Callable[[Array], Array],
    *,
    q_short: float,
    lengths: Lengths,
    shape: Shape,
    seed: int | np.random.Generator,
    amplitudes: Literal["exact", "gaussian"] = "exact",
    under_resolved: bool = False,
) -> HeightField:
    r"""One realisation of a periodic random surface with power spectrum C(q).

    .. math:: h(\mathbf x) = \sum_{\mathbf q} B(\mathbf q)\,
              e^{i[\mathbf q\cdot\mathbf x + \phi(\mathbf q)]},\qquad
              B = \frac{2\pi}{\sqrt{L_x L_y}} \sqrt{C(q)},\quad \phi(-\mathbf q) = -\phi(\mathbf q)

    Parameters
    ----------
    spectrum : callable
        C(q) [m^4] for an array of q [1/m], in the convention <h^2> = 2 pi int q C dq.
    q_short : float
        Cut-off wavevector [1/m]: no wave beyond it is generated.
    lengths : tuple of float
        Periods (Lx, Ly) [m].
    shape : tuple of int
        Grid points (nx, ny), odd or even. The same seed gives the same surface on every grid.
    seed : int or numpy.random.Generator
        Source of the phases (and amplitudes).
    amplitudes : {"exact", "gaussian"}
        "exact": every wave carries sqrt(C(q)) exactly, only phases are random. "gaussian": each coefficient
        is a complex Gaussian of that variance, as in a sample of a Gaussian process.
    under_resolved : bool
        Accept a grid with lambda_short <= 2 dx. It gets the true point values, from which the surface cannot
        be recovered.

    Raises
    ------
    InvalidInput
        For a grid that does not resolve q_short (unless asked for), no wave below q_short, a spectrum that is
        negative or not finite, or a seed that is none.

    Notes
    -----
    Eq. 1 of Persson 2006 with the Hermitian condition. Random numbers are drawn along square rings of wave
    numbers outwards, so they depend neither on the grid nor on q_short: cutting the spectrum elsewhere keeps
    the remaining waves.
    """
    waves = random_waves(spectrum, q_short=q_short, lengths=lengths, seed=seed, amplitudes=amplitudes)
    return waves.on(shape, under_resolved=under_resolved)


@dataclass(frozen=True, kw_only=True, eq=False)
class RandomWaves:
    """The waves of one realisation of a random surface, drawn once and sampled on any grid.

    Attributes
    ----------
    m, n : (count,) arrays of int
        Wave numbers, one of each pair +-q.
    amplitudes : (count,) array of complex
        Fourier coefficients of half the surface [m].
    q_short : float
        Cut-off wavevector [1/m].
    lengths : tuple of float
        Periods (Lx, Ly) [m].
    """

    m: NDArray[np.int64]
    n: NDArray[np.int64]
    amplitudes: NDArray[np.complex128]
    q_short: float
    lengths: Lengths

    def on(self, shape: Shape, *, under_resolved: bool = False) -> HeightField:
        """Sample the surface on a grid.

        Parameters
        ----------
        shape : tuple of int
            Grid points (nx, ny), odd or even.
        under_resolved : bool
            Accept a grid with lambda_short <= 2 dx. It gets the true point values, from which the surface
            cannot be recovered.

        Raises
        ------
        InvalidInput
            For a grid that does not resolve q_short, unless asked for.
        """
        shape = _checked_shape(shape)
        if not (under_resolved or resolves(shape, self.lengths, q_short=self.q_short)):
            needed = tuple(
                int(np.floor(length * self.q_short / np.pi * (1 + _EDGE))) + 1 for length in self.lengths
            )
            raise InvalidInput(
                f"shape = {shape}: does not resolve lambda_short = {2 * np.pi / self.q_short:.6g} m; "
                f"at least {needed} points are needed (or ask for an under-resolved grid)"
            )
        half = np.zeros((shape[0], shape[1]), dtype=complex)
        np.add.at(half, (self.m % shape[0], self.n % shape[1]), self.amplitudes)
        heights = 2 * scipy.fft.ifft2(half, norm="forward").real
        return HeightField(heights=heights, lengths=self.lengths)


def random_waves(
    spectrum: Callable[[Array], Array],
    *,
    q_short: float,
    lengths: Lengths,
    seed: int | np.random.Generator,
    amplitudes: Literal["exact", "gaussian"] = "exact",
) -> RandomWaves:
    """Draw the waves of one realisation; parameters and errors as of `random_surface`."""
    lengths = _checked_lengths(lengths)
    if not (np.isfinite(q_short) and q_short > 0):
        raise InvalidInput(f"q_short = {q_short!r}: must be a positive, finite wavevector in 1/m")
    if amplitudes not in ("exact", "gaussian"):
        raise InvalidInput(f"amplitudes = {amplitudes!r}: must be 'exact' or 'gaussian'")
    m, n, q = _half_plane(lengths, q_short)
    power = np.asarray(spectrum(q), dtype=float)
    if not np.all(np.isfinite(power)) or np.any(power < 0):
        raise InvalidInput("the spectrum C(q) is negative or not finite at a wavevector of the surface")
    waves = _random_waves(m, n, seed=seed, gaussian=amplitudes == "gaussian")
    waves *= 2 * np.pi * np.sqrt(power / (lengths[0] * lengths[1]))
    return RandomWaves(m=m, n=n, amplitudes=waves, q_short=q_short, lengths=lengths)


def _checked_generator(seed: int | np.random.Generator) -> np.random.Generator:
    """Return the generator of a seed; None is refused because nobody could draw that surface again."""
    if isinstance(seed, np.random.Generator):
        return seed
    if not isinstance(seed, (int, np.integer)) or seed < 0:
        raise InvalidInput(
            f"seed = {seed!r}: must be a whole number that is not negative, or a numpy.random.Generator"
        )
    return np.random.default_rng(int(seed))


def _half_plane(lengths: Lengths, q_short: float) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Wave numbers (m, n) with 0 < |q| <= q_short, one of each pair +-q, and |q| [1/m]."""
    unit_x, unit_y = (2 * np.pi / length for length in lengths)
    limit = q_short * (1 + _EDGE)
    top_x, top_y = int(limit / unit_x), int(limit / unit_y)
    m, n = np.meshgrid(np.arange(-top_x, top_x + 1), np.arange(top_y + 1), indexing="ij")
    q = np.hypot(m * unit_x, n * unit_y)
    keep = (q <= limit) & ((n > 0) | (m > 0))
    if not keep.any():
        raise InvalidInput(
            f"no wave fits: lambda_short = {2 * np.pi / q_short:.6g} m exceeds the periods {lengths} m"
        )
    return m[keep], n[keep], q[keep]


def _random_waves(
    m: NDArray[np.int64], n: NDArray[np.int64], *, seed: int | np.random.Generator, gaussian: bool
) -> NDArray[np.complex128]:
    """Unit-variance complex random numbers, a function of the seed and of each wave number alone."""
    ring = np.maximum(np.abs(m), n)
    along = np.where(m == ring, n, np.where(n == ring, 2 * ring - m, 4 * ring - n))
    position = 2 * ring * (ring - 1) + along
    count = int(position.max()) + 1
    phases, sizes = _checked_generator(seed).spawn(2)
    waves: NDArray[np.complex128] = np.exp(2j * np.pi * phases.random(count)[position])
    if gaussian:
        waves *= np.sqrt(-np.log1p(-sizes.random(count)[position]))
    return waves


@dataclass(frozen=True, kw_only=True, eq=False)
class RadialSpectrum:
    """A power spectrum averaged over rings of wavevectors.

    Attributes
    ----------
    q : (n,) array
        Mean |q| of the waves in each ring [1/m].
    power : (n,) array
        C(q) [m^4]: ring average of |h(q)|^2 Lx Ly / (2 pi)^2.
    count : (n,) array
        Number of waves in the ring.
    """

    q: Array
    power: Array
    count: NDArray[np.int64]


def radial_spectrum(surface: HeightField) -> RadialSpectrum:
    """Measure C(q) of a periodic surface, averaged over rings one fundamental wavevector wide.

    Convention as in Persson 2006, <h^2> = 2 pi int q C dq; multiply by (2 pi)^2 for the areal PSD of other
    communities.
    """
    qx, qy, coefficients = _interpolant(surface)
    q = np.hypot(qx[:, None], qy[None, :])
    unit = 2 * np.pi / min(surface.lengths)
    ring = np.rint(q / unit).astype(np.int64).ravel()
    count = np.bincount(ring)
    cell = (2 * np.pi) ** 2 / (surface.lengths[0] * surface.lengths[1])
    power = np.bincount(ring, weights=(np.abs(coefficients) ** 2).ravel()) / cell
    mean_q = np.bincount(ring, weights=q.ravel())
    filled = (count > 0) & (np.arange(count.size) > 0)
    return RadialSpectrum(
        q=mean_q[filled] / count[filled], power=power[filled] / count[filled], count=count[filled]
    )
