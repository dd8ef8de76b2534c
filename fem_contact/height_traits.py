"""What heights are like on their grid, from their waves: what errors of contact areas depend on."""

from dataclasses import dataclass

import numpy as np
import scipy.fft

from fem_contact._types import Array, Complex, Lengths, Shape

#: Rows of waves that are added up at once.
_BAND = 128


@dataclass(frozen=True, kw_only=True)
class HeightTraits:
    """The attributes of these names of `fem_contact.area.ContactAreas`."""

    anisotropy: float = 0.0
    unresolved: float = 0.0
    wavenumber: float = 0.0


def height_traits(heights: Array, spacing: Lengths, *, patch: bool) -> HeightTraits:
    """Find what periodic heights are like, or those of a patch whose sides do not continue each other."""
    nx, ny = heights.shape
    deviation = heights - np.mean(heights)
    largest = float(np.max(np.abs(deviation)))
    if are_level(largest, float(np.max(np.abs(heights)))):
        return HeightTraits()
    deviation /= largest
    if patch:
        deviation *= np.multiply.outer(*(np.hanning(n) if n > 2 else np.ones(n) for n in (nx, ny)))
    return traits_of(wave_sums(scipy.fft.rfft2(deviation), (nx, ny), spacing))


def are_level(deviation: float, height: float) -> bool:
    """Whether heights differ from their mean by no more than rounding leaves of the largest."""
    return deviation <= 8 * float(np.finfo(float).eps) * height


def wave_sums(spectrum: Complex, shape: Shape, spacing: Lengths, first: int = 0) -> Array:
    """Add up what `traits_of` needs over waves: columns of a half spectrum from the first one given on."""
    (nx, ny), (dx, dy) = shape, spacing
    column = np.arange(first, first + spectrum.shape[1])
    # Half of the waves stand for both halves.
    halves = np.where((column > 0) & (2 * column < ny), 2.0, 1.0)
    rows, columns = 2 * scipy.fft.fftfreq(nx)[:, None], 2 * column / ny
    sums = np.zeros(6)
    for top in range(0, nx, _BAND):
        band = slice(top, top + _BAND)
        beyond = np.hypot(rows[band], columns) > 0.5 * (1 + 1e-9)
        x, y = rows[band] * np.sqrt(dy / dx), columns * np.sqrt(dx / dy)
        power, squares = halves * np.abs(spectrum[band]) ** 2, x * x + y * y
        curvature = power * squares**2
        # A wave of two points runs either way: its slopes along and across do not go together.
        mixed = (power * x * y)[rows[band, 0] > -1]
        parts = power * x * x, power * y * y, mixed, curvature, curvature[beyond], curvature * squares
        sums += [np.sum(part) for part in parts]
    return sums


def traits_of(sums: Array) -> HeightTraits:
    """Make the traits from the sums over all waves."""
    along, across, mixed, curvature, unresolved, third = (float(part) for part in sums)
    if curvature == 0:
        return HeightTraits()
    uneven = float(np.hypot(along - across, 2 * mixed)) / (along + across)
    peklenik = float(np.sqrt(max(1 - uneven, 0.0) / (1 + uneven)))
    return HeightTraits(
        anisotropy=1 - peklenik,
        unresolved=unresolved / curvature,
        wavenumber=np.pi * float(np.sqrt(third / curvature)),
    )
