"""Random surfaces that are the same on every grid.

A random surface is a sum of waves (Eq. 1 of Persson 2006). Its random numbers belong to the wavevectors, not
to array positions, so that one seed gives one surface, whatever grid it is sampled on and wherever its
spectrum is cut.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy.fft

from fem_contact._checks import array, choice, function, positive, room_for, shown, truth
from fem_contact._types import Array, Complex, Lengths, Numbers, Shape
from fem_contact.errors import InvalidInput
from fem_contact.surface.heights import HeightField, checked_lengths, checked_shape

#: Relative slack when a wavevector is compared with a limit it may equal up to rounding.
_EDGE = 1e-12


def resolves(shape: Shape, lengths: Lengths, *, q_short: float) -> bool:
    """Whether a grid resolves waves up to q_short: lambda_short > 2 dx on both axes.

    Examples
    --------
    >>> [resolves((64, 64), (1.0, 1.0), q_short=2 * np.pi * waves) for waves in (31, 32)]
    [True, False]
    """
    counts, (lx, ly) = checked_shape(shape), checked_lengths(lengths)
    positive("q_short", q_short)
    return all(
        2 * np.pi / q_short > 2 * length / n * (1 + _EDGE) for n, length in zip(counts, (lx, ly), strict=True)
    )


def random_surface(
    spectrum: Callable[..., Array],
    *,
    q_short: float,
    lengths: Lengths,
    shape: Shape,
    seed: int | np.random.Generator,
    amplitudes: Literal["exact", "gaussian"] = "exact",
    isotropic: bool = True,
    under_resolved: bool = False,
) -> HeightField:
    r"""One realisation of a periodic random surface with power spectrum C(q).

    .. math:: h(\mathbf x) = \sum_{\mathbf q} B(\mathbf q)\,
              e^{i[\mathbf q\cdot\mathbf x + \phi(\mathbf q)]},\qquad
              B = \frac{2\pi}{\sqrt{L_x L_y}} \sqrt{C(q)},\quad \phi(-\mathbf q) = -\phi(\mathbf q)

    Parameters
    ----------
    spectrum : callable
        C(q) [m^4] for an array of q [1/m], in the convention <h^2> = 2 pi int q C dq; or C(qx, qy), see
        `isotropic`.
    q_short : float
        Cut-off wavevector [1/m]: no wave beyond it is generated, in any direction.
    lengths : tuple of float
        Periods (Lx, Ly) [m].
    shape : tuple of int
        Grid points (nx, ny), odd or even. The same seed gives the same surface on every grid.
    seed : int or numpy.random.Generator
        Source of the phases (and amplitudes).
    amplitudes : {"exact", "gaussian"}
        "exact": every wave carries sqrt(C(q)) exactly, only phases are random. "gaussian": each coefficient
        is a complex Gaussian of that variance, as in a sample of a Gaussian process.
    isotropic : bool
        Whether the spectrum is a function of |q|; if not, of the components (qx, qy), the same for -q.
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
    checked_grid(shape, lengths, q_short, under_resolved)
    waves = random_waves(
        spectrum, q_short=q_short, lengths=lengths, seed=seed, amplitudes=amplitudes, isotropic=isotropic
    )
    return waves.on(shape, under_resolved=under_resolved)


@dataclass(frozen=True, kw_only=True, eq=False)
class RandomWaves:
    """The waves of one realisation of a random surface, drawn once and sampled on any grid."""

    # (count,): Wave numbers, one of each pair +-q.
    m: Numbers
    n: Numbers
    amplitudes: Complex  # (count,): Fourier coefficients of half the surface [m]
    q_short: float  # Cut-off wavevector [1/m]
    lengths: Lengths  # Periods (Lx, Ly) [m]

    def on(self, shape: Shape, *, under_resolved: bool = False) -> HeightField:
        """Sample the surface on a grid; parameters and errors as of `random_surface`."""
        shape = checked_grid(shape, self.lengths, self.q_short, under_resolved)
        half = np.zeros(shape, dtype=complex)
        np.add.at(half, (self.m % shape[0], self.n % shape[1]), self.amplitudes)
        heights = 2 * scipy.fft.ifft2(half, norm="forward").real
        return HeightField(heights=heights, lengths=self.lengths)


def random_waves(
    spectrum: Callable[..., Array],
    *,
    q_short: float,
    lengths: Lengths,
    seed: int | np.random.Generator,
    amplitudes: Literal["exact", "gaussian"] = "exact",
    isotropic: bool = True,
    columns: tuple[int, int] | None = None,
) -> RandomWaves:
    """Draw the waves of one realisation; parameters and errors as of `random_surface`.

    With `columns` only those whose wave number n is at least the first and below the second of them.
    """
    lengths = checked_lengths(lengths)
    q_short = positive("q_short", q_short)
    truth("isotropic", isotropic)
    function("spectrum", spectrum, of=("q",) if isotropic else ("qx", "qy"))
    choice("amplitudes", amplitudes, ("exact", "gaussian"))
    m, n, q = _half_plane(lengths, q_short, columns)
    if isotropic:
        power = array("spectrum(q)", spectrum(q), power=4)
    else:
        qx, qy = (2 * np.pi / length * number for length, number in zip(lengths, (m, n), strict=True))
        power = array("spectrum(qx, qy)", spectrum(qx, qy), power=4)
        opposite = array("spectrum(-qx, -qy)", spectrum(-qx, -qy), power=4)
        if not np.allclose(power, opposite, rtol=1e-9, atol=0.0):
            raise InvalidInput("the spectrum C(qx, qy) differs between a wavevector and its opposite")
    if power.shape not in ((), q.shape):
        raise InvalidInput(
            f"spectrum of shape {power.shape}: must be of the shape {q.shape} of what it is told"
        )
    if np.any(power < 0):
        raise InvalidInput("the spectrum C(q) is negative at a wavevector of the surface")
    waves = _random_waves(m, n, seed=seed, gaussian=amplitudes == "gaussian")
    waves *= 2 * np.pi * np.sqrt(power / (lengths[0] * lengths[1]))
    return RandomWaves(m=m, n=n, amplitudes=waves, q_short=q_short, lengths=lengths)


def checked_grid(shape: Shape, lengths: Lengths, q_short: float, under_resolved: bool) -> Shape:
    """Return the points of a grid that resolves the waves, or need not."""
    shape = checked_shape(shape)
    truth("under_resolved", under_resolved)
    if resolves(shape, lengths, q_short=q_short) or under_resolved:
        return shape
    needed = tuple(int(np.floor(length * q_short / np.pi * (1 + _EDGE))) + 1 for length in lengths)
    raise InvalidInput(
        f"shape = {shape}: does not resolve lambda_short = {2 * np.pi / q_short:.6g} m; "
        f"at least {needed} points are needed (or ask for an under-resolved grid)"
    )


def _half_plane(lengths: Lengths, q_short: float, columns: Shape | None) -> tuple[Numbers, Numbers, Array]:
    """Wave numbers (m, n) with 0 < |q| <= q_short, one of each pair +-q, and |q| [1/m]."""
    unit_x, unit_y = (2 * np.pi / length for length in lengths)
    limit = q_short * (1 + _EDGE)
    top_x, top_y = int(limit / unit_x), int(limit / unit_y)
    first, last = (0, top_y + 1) if columns is None else (columns[0], min(columns[1], top_y + 1))
    room_for(f"q_short = {q_short!r}", needed=80.0 * (2 * top_x + 1) * max(last - first, 0))
    m, n = np.meshgrid(np.arange(-top_x, top_x + 1), np.arange(first, last), indexing="ij")
    q = np.hypot(m * unit_x, n * unit_y)
    keep = (q <= limit) & ((n > 0) | (m > 0))
    if columns is None and not keep.any():
        raise InvalidInput(
            f"no wave fits: lambda_short = {2 * np.pi / q_short:.6g} m exceeds the periods {lengths} m"
        )
    return m[keep], n[keep], q[keep]


def _random_waves(m: Numbers, n: Numbers, *, seed: int | np.random.Generator, gaussian: bool) -> Complex:
    """Unit-variance complex random numbers, a function of the seed and of each wave number alone."""
    ring = np.maximum(np.abs(m), n)
    along = np.where(m == ring, n, np.where(n == ring, 2 * ring - m, 4 * ring - n))
    position = 2 * ring * (ring - 1) + along
    if not isinstance(seed, np.random.Generator):
        # None is refused because nobody could draw that surface again.
        if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
            whole = "a whole number that is not negative"
            raise InvalidInput(f"seed = {shown(seed)}: must be {whole}, or a numpy.random.Generator")
        seed = np.random.default_rng(int(seed))
    phases, sizes = seed.spawn(2)
    waves: Complex = np.exp(2j * np.pi * _drawn(phases, position))
    if gaussian:
        waves *= np.sqrt(-np.log1p(-_drawn(sizes, position)))
    return waves


#: Random numbers drawn at once, whether they are wanted or not.
_DRAWN = 2**20


def _drawn(generator: np.random.Generator, position: Numbers) -> Array:
    """Return the random numbers at these positions of the sequence, of which little is held at once."""
    order, out = np.argsort(position), np.empty(position.shape)
    ordered = position[order]
    count = int(position.max(initial=-1)) + 1
    for first in range(0, count, _DRAWN):
        drawn = generator.random(min(_DRAWN, count - first))
        part = slice(*np.searchsorted(ordered, (first, first + _DRAWN)))
        out[order[part]] = drawn[ordered[part] - first]
    return out
