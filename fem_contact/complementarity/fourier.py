"""Responses applied by Fourier transform on a periodic grid, and fields carried between grids."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from fem_contact._checks import LEAST, array
from fem_contact.complementarity.rows import Rows
from fem_contact.errors import InvalidInput
from fem_contact.response import Response
from fem_contact.settings import available_processors

__all__ = ["FourierOperator", "coarsened", "refined"]

Array = NDArray[np.float64]
Single = NDArray[np.float32]
Shape = tuple[int, int]


class FourierOperator:
    """The response of a solid on one grid, and its inverse, by real FFTs.

    Transforms are ducc0's where it is installed: it works in place, so that no array is allocated per
    application, and is about twice as fast on large grids as scipy's, which is used otherwise.

    Parameters
    ----------
    response : Response
    shape : tuple of int
        Grid points (nx, ny).
    lengths : tuple of float
        Periods (Lx, Ly) [m].
    threads : int, optional
        Threads of each transform; all available processors if not given.

    Raises
    ------
    InvalidInput
        For a compliance that is not positive and finite at every q but 0, or negative there.
    """

    pairs = 1.0

    def __init__(
        self, response: Response, shape: Shape, lengths: tuple[float, float], *, threads: int | None = None
    ) -> None:
        qx = 2 * np.pi * scipy.fft.fftfreq(shape[0], lengths[0] / shape[0])
        qy = 2 * np.pi * scipy.fft.rfftfreq(shape[1], lengths[1] / shape[1])
        self.compliance = np.array(
            array("compliance", response.compliance(qx[:, None], qy[None, :]), power=2)
        )
        positive = self.compliance.ravel()[1:]
        valid = self.compliance.shape == (shape[0], shape[1] // 2 + 1) and np.all(
            np.isfinite(self.compliance)
        )
        if not (valid and np.all(positive > LEAST**2) and self.compliance[0, 0] >= 0):
            raise InvalidInput("the compliance is not positive and finite at every wavevector but q = 0")
        self.shape = shape
        self.threads = available_processors() if threads is None else threads
        self.stiffness = float(np.mean(1 / positive)) if positive.size else 0.0
        self._in_place = importlib.util.find_spec("ducc0") is not None
        self._rows = Rows(shape[0], threads=self.threads)
        self._spectrum = np.empty(self.compliance.shape, dtype=complex)

    @property
    def nbytes(self) -> int:
        """Memory of the arrays held."""
        return self.compliance.nbytes + self._spectrum.nbytes

    def apply(self, force: Array, out: Array) -> None:
        """Write the displacement [m] under the pressure ``force`` [Pa] into ``out``."""
        from fem_contact.complementarity.kernels import multiply

        self._filter(force, out, multiply)

    def precondition(self, residual: Array | Single, out: Array | Single) -> None:
        """Write the full-contact pressure [Pa] under a displacement [m], without its mean, into ``out``.

        Both may be of single precision, and the transforms then are.
        """
        from fem_contact.complementarity.kernels import divide

        self._filter(residual, out, divide)

    def _filter(self, field: Array | Single, out: Array | Single, kernel: Callable[..., Any]) -> None:
        threads = self.threads
        if not self._in_place:
            spectrum = scipy.fft.rfft2(field, workers=threads)
            self._rows.run(kernel, spectrum, self.compliance)
            out[...] = scipy.fft.irfft2(spectrum, s=self.shape, workers=threads, overwrite_x=True)
            return
        import ducc0.fft

        spectrum = self._buffer(field)
        ducc0.fft.r2c(field, axes=(0, 1), out=spectrum, nthreads=threads)
        self._rows.run(kernel, spectrum, self.compliance)
        # Along x first and in place: a single backward call would allocate a second spectrum.
        ducc0.fft.c2c(spectrum, axes=(0,), forward=False, inorm=2, out=spectrum, nthreads=threads)
        columns = field.shape[1]
        ducc0.fft.c2r(
            spectrum, axes=(1,), lastsize=columns, forward=False, inorm=2, out=out, nthreads=threads
        )

    def _buffer(self, field: Array | Single) -> NDArray[Any]:
        """Room for a spectrum; that of single precision is part of the one of double."""
        if field.dtype == np.float64:
            return self._spectrum
        return (
            self._spectrum.view(np.complex64).reshape(-1)[: self._spectrum.size].reshape(self._spectrum.shape)
        )


def coarsened(heights: Array, shape: Shape, *, threads: int = 1) -> Array:
    """Heights on a coarser grid of the same period, freed of the waves that it cannot carry."""
    spectrum = scipy.fft.rfft2(heights, norm="forward", workers=threads)
    coarse = np.zeros((shape[0], shape[1] // 2 + 1), dtype=complex)
    rows = _carried(heights.shape[0], shape[0])
    columns = np.arange((min(heights.shape[1], shape[1]) - 1) // 2 + 1)
    coarse[np.ix_(rows % shape[0], columns)] = spectrum[np.ix_(rows, columns)]
    return np.ascontiguousarray(scipy.fft.irfft2(coarse, s=shape, norm="forward", workers=threads))


def _carried(old: int, new: int) -> NDArray[np.int64]:
    """Wave numbers below the Nyquist limit of both grids, negative ones counted from the end."""
    top = (min(old, new) - 1) // 2
    return np.arange(-top, top + 1)


def refined(field: Array, shape: Shape) -> Array:
    """Carry a field to a finer grid of the same period, bilinearly: positive fields stay so."""
    if all(new == 2 * old for new, old in zip(shape, field.shape, strict=True)):
        return _doubled(field)
    for axis, points in enumerate(shape):
        old = field.shape[axis]
        place = np.arange(points) * (old / points)
        below = place.astype(int)
        share = np.expand_dims(place - below, 1 - axis)
        field = (1 - share) * np.take(field, below % old, axis) + share * np.take(
            field, (below + 1) % old, axis
        )
    return np.ascontiguousarray(field)


def _doubled(field: Array) -> Array:
    """Bilinear interpolation to twice the points along both axes."""
    fine = np.empty((2 * field.shape[0], 2 * field.shape[1]))
    even, odd = fine[::2], fine[1::2]
    even[:, ::2] = field
    np.add(field[:, :-1], field[:, 1:], out=even[:, 1:-1:2])
    np.add(field[:, -1], field[:, 0], out=even[:, -1])
    even[:, 1::2] *= 0.5
    np.add(even[:-1], even[1:], out=odd[:-1])
    np.add(even[-1], even[0], out=odd[-1])
    odd *= 0.5
    return fine
