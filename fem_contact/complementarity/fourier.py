"""Responses applied by Fourier transform on a periodic grid, and fields carried between grids."""

import copy
import importlib.util
from collections.abc import Callable, Sequence
from typing import Self

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from fem_contact._checks import LEAST, array
from fem_contact._types import AnyArray, Array, Lengths, Numbers, Shape, Single
from fem_contact.complementarity.rows import Rows
from fem_contact.errors import InvalidInput
from fem_contact.response import Response
from fem_contact.settings import available_processors
from fem_contact.surface.heights import wavevectors


class FourierOperator:
    """The response of a solid on one grid, and its inverse, by real FFTs.

    Transforms are ducc0's where it is installed: it works in place, so that no array is allocated per
    application, and is about twice as fast on large grids as scipy's, which is used otherwise.

    Raises
    ------
    InvalidInput
        For a compliance that is not positive and finite at every q but 0, or negative there.
    """

    pairs = 1.0

    def __init__(
        self, response: Response, shape: Shape, lengths: Lengths, *, threads: int | None = None
    ) -> None:
        self.shape = shape
        self.threads = available_processors() if threads is None else threads
        self._evaluate(response, lengths)
        self._in_place = importlib.util.find_spec("ducc0") is not None
        self._rows = Rows(shape[0], threads=self.threads)
        # Rows of single precision a power of two apart compete for the same lines of the cache.
        self._spectrum = np.empty((shape[0], self.compliance.shape[1] + 7), dtype=complex)

    def _evaluate(
        self,
        response: Response,
        lengths: Lengths,
        *,
        columns: slice = slice(None),
        gathered: Callable[..., Array] = lambda *values: np.array([values], dtype=float),
    ) -> None:
        """Evaluate the compliance at columns of the spectrum, and what depends on all of them."""
        qx, qy = wavevectors(self.shape, lengths)
        qy = qy[columns]
        self.compliance = np.array(array("compliance", response.compliance(*np.ix_(qx, qy)), power=2))
        if self.compliance.shape != (shape := (qx.size, qy.size)):
            self.compliance = np.full(shape, -1.0 if self.compliance.ndim else self.compliance)
        # All but q = 0, which the first column has.
        positive = self.compliance.ravel()[int(not columns.start) :]
        valid = bool(np.all(positive > LEAST**2) and self.compliance[0, 0] >= 0)
        top = np.unravel_index(int(np.argmax(self.compliance)), self.compliance.shape)
        parts = gathered(
            valid,
            float(np.sum(1 / positive)) if valid else 0.0,
            positive.size,
            float(np.min(positive, initial=np.inf)),
            float(self.compliance[top]),
            float(np.hypot(qx[top[0]], qy[top[1]])),
            float(np.max(positive, initial=0.0)),
        )
        if not parts[:, 0].all():
            raise InvalidInput(
                "the compliance is not one positive, finite number at every wavevector but q = 0"
            )
        count = float(parts[:, 2].sum())
        self.stiffness = float(parts[:, 1].sum()) / max(count, 1.0)
        self.extremes = (float(parts[:, 3].min()), float(parts[:, 6].max())) if count else (1.0, 1.0)
        peak = parts[int(np.argmax(parts[:, 4]))]
        longest = *self.compliance[1:2, 0], *self.compliance[0, 1:2]
        if columns != slice(None):
            axes = 2 * np.pi / np.array(lengths)
            longest = tuple(response.compliance(np.array([axes[0], 0]), np.array([0, axes[1]])))
        self.long_waves = long_waves(
            self.compliance, qx=qx, qy=qy, peak=(float(peak[4]), float(peak[5])), longest=longest
        )

    @property
    def nbytes(self) -> int:
        """Memory of the arrays held."""
        return self.compliance.nbytes + self._spectrum.nbytes

    def single(self, factor: float) -> Self:
        """Return `factor` times this response in single precision; both share the room for a spectrum."""
        twin = copy.copy(self)
        twin.compliance = (self.compliance * factor).astype(np.float32)
        twin.stiffness = self.stiffness / factor
        return twin

    def apply(self, force: Array, out: Array) -> None:
        """Write the displacement [m] under the pressure ``force`` [Pa] into ``out``."""
        self._filter(force, out)

    def invert(self, displacement: Array, out: Array) -> None:
        """Write the full-contact pressure [Pa] under a displacement [m], without its mean, into ``out``."""
        self._filter(displacement, out, inverse=True)

    def precondition(self, residual: Array | Single, out: Array | Single) -> None:
        """Do as `invert`, but with long waves no stiffer than contacts feel them: see `long_waves`."""
        self._filter(residual, out, inverse=True, weaken=True)

    def _filter(
        self, field: Array | Single, out: Array | Single, *, inverse: bool = False, weaken: bool = False
    ) -> None:
        from fem_contact.complementarity.kernels import divide, multiply

        threads, kernel = self.threads, divide if inverse else multiply
        if not self._in_place:
            spectrum = scipy.fft.rfft2(field, workers=threads)
            self._rows.run(kernel, spectrum, self.compliance)
            self._weaken(spectrum, weaken)
            out[...] = scipy.fft.irfft2(spectrum, s=self.shape, workers=threads, overwrite_x=True)
            return
        import ducc0.fft

        room = self._room_for(field)
        spectrum = room[:, : self.compliance.shape[1]]
        # One axis at a time and in place: a call for both allocates a second spectrum, and takes up to twice
        # as long where rows are a power of two apart.
        ducc0.fft.r2c(field, axes=(1,), out=spectrum, nthreads=threads)
        ducc0.fft.c2c(spectrum, axes=(0,), out=spectrum, nthreads=threads)
        self._rows.run(kernel, room, self.compliance)
        self._weaken(spectrum, weaken)
        ducc0.fft.c2c(spectrum, axes=(0,), forward=False, inorm=2, out=spectrum, nthreads=threads)
        self._along_rows(spectrum, out)

    def _room_for(self, field: AnyArray) -> AnyArray:
        """Return the room for a spectrum, in the precision of a field."""
        room = self._spectrum if field.dtype == np.float64 else self._spectrum.view(np.complex64)
        return room.reshape(-1)[: self._spectrum.size].reshape(self._spectrum.shape)

    def _weaken(self, spectrum: AnyArray, wanted: bool) -> None:
        if wanted and self.long_waves is not None:
            rows, factor = self.long_waves
            spectrum[rows, : factor.shape[1]] *= factor

    def _along_rows(self, spectrum: AnyArray, out: Array | Single) -> None:
        """Transform back along rows."""
        import ducc0.fft

        columns = out.shape[1]
        options = {"axes": (1,), "lastsize": columns, "forward": False, "inorm": 2, "nthreads": self.threads}
        if out.dtype == np.float64:
            ducc0.fft.c2r(spectrum, out=out, **options)
            return
        # Sixteen rows are written at a time: apart by a power of two they push each other out of the cache.
        apart = np.empty((min(_BLOCK * self.threads, len(out)), columns + 16), dtype=np.float32)[:, :columns]
        for first in range(0, len(out), len(apart)):
            rows = out[first : first + len(apart)]
            ducc0.fft.c2r(spectrum[first : first + len(apart)], out=apart[: len(rows)], **options)
            rows[...] = apart[: len(rows)]


#: Share of the largest compliance below which longer waves than that one are weakened.
_WEAKENED = 0.3


def long_waves(
    compliance: Array, *, qx: Array, qy: Array, peak: tuple[float, float], longest: Sequence[float]
) -> tuple[NDArray[np.intp], Array] | None:
    """Return rows of the spectrum, and factors of their first columns, that weaken long stiff waves.

    A thin incompressible layer answers waves longer than its thickness with C ~ q^2. Their inverse is that of
    the whole period; within contacts that are smaller they do not exist, and left as stiff they spoil the
    direction: 500 pairs where 100 do. They are taken to be `_WEAKENED` times as compliant as the most
    compliant wave, whose compliance and wavevector `peak` has. None where there are none, as on a half-space:
    the longest waves, whose compliances are given, are the stiffest, if any is.
    """
    least = _WEAKENED * peak[0]
    if all(float(compliance) >= least for compliance in longest):
        return None
    q = np.hypot(qx[:, None], qy[None, :])
    stiff = (q < peak[1]) & (compliance < least) & (q > 0)
    if not stiff.any():
        return None
    rows = np.flatnonzero(stiff.any(axis=1))
    columns = int(np.flatnonzero(stiff.any(axis=0))[-1]) + 1
    block = compliance[rows, :columns]
    return rows, np.where(stiff[rows, :columns], block / least, 1.0)


#: Rows of single precision transformed back at once: their room stays in the cache.
_BLOCK = 64


def carried(old: int, new: int) -> Numbers:
    """Wave numbers below the Nyquist limit of both grids, negative ones counted from the end."""
    top = (min(old, new) - 1) // 2
    return np.arange(-top, top + 1)


def refined_along(field: Array, axis: int, places: AnyArray) -> Array:
    """Interpolate a periodic field at places between its points of one axis."""
    old, below = field.shape[axis], places.astype(int)
    share = np.expand_dims(places - below, 1 - axis)
    fine, above = (np.take(field, (below + k) % old, axis) for k in (0, 1))
    fine *= 1 - share
    above *= share
    fine += above
    return np.asarray(fine)


def doubled(field: Array) -> Array:
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
