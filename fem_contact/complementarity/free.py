"""A half-space that is pressed on one patch alone: no period, by transforms on a doubled grid."""

import numpy as np
import scipy.fft

from fem_contact._types import Array, Lengths, Shape, Single
from fem_contact.complementarity.fourier import FourierOperator
from fem_contact.response import FreeHalfSpace, Response
from fem_contact.settings import available_processors


class FreeOperator:
    r"""The response of a half-space to pressures that are constant on each cell of a patch, and zero outside.

    .. math:: u_{ij} = \frac{1}{\pi E^*} \sum_{kl} p_{kl}\,
              [F]_{x_i - x_k \pm dx/2,\, y_j - y_l \pm dy/2}, \qquad
              F(x, y) = x \operatorname{arsinh}\frac{y}{|x|} + y \operatorname{arsinh}\frac{x}{|y|}

    with the sum of F over the corners of the cell, signs alternating. The convolution is done by FFT on twice
    the points along both axes, so that no image acts on the patch. The inverse response of cosine waves
    preconditions it: unlike periodic ones they do not tie the edges of the patch to each other.

    Notes
    -----
    A. E. H. Love, Phil. Trans. R. Soc. A 228, 377 (1929); K. L. Johnson, Contact Mechanics (1985), Eq. 3.25.
    Doubling: R. W. Hockney, J. W. Eastwood, Computer Simulation Using Particles (1988), Sec. 6-5-4.
    """

    #: Along rows half of the doubled grid is zero or not asked for, along columns all of it is transformed.
    pairs = 3.0

    def __init__(
        self, response: FreeHalfSpace, shape: Shape, lengths: Lengths, *, threads: int | None
    ) -> None:
        self.shape = shape
        self.threads = available_processors() if threads is None else threads
        # Displacement at 0 to n cells from a cell under unit pressure.
        (nx, ny), (dx, dy) = shape, (length / n for length, n in zip(lengths, shape, strict=True))
        x, y = (np.arange(nx + 2) - 0.5) * dx, (np.arange(ny + 2) - 0.5) * dy
        x, y = x[:, None], y[None, :]
        corners = x * np.arcsinh(y / np.abs(x)) + y * np.arcsinh(x / np.abs(y))
        cells = np.diff(np.diff(corners, axis=0), axis=1) / (np.pi * response.contact_modulus)
        qx, qy = (np.pi * np.arange(n) / length for n, length in zip(shape, lengths, strict=True))
        stiffness = 0.5 * response.contact_modulus * np.hypot(qx[:, None], qy[None, :])
        self.stiffness = float(np.mean(stiffness))
        # A uniform pressure sinks the middle of the patch by this.
        middle = 4 * cells[: (shape[0] + 1) // 2, : (shape[1] + 1) // 2].sum()
        stiffness[0, 0] = 1 / middle
        self.compliance: Array = 1 / stiffness
        # Even along both axes, so that the transform is real; distances of n cells never occur.
        rows, columns = (np.minimum(np.arange(2 * n), 2 * n - np.arange(2 * n)) for n in shape)
        doubled = cells[np.ix_(rows, columns)]
        self._kernel = np.ascontiguousarray(scipy.fft.rfft2(doubled, workers=self.threads).real)

    @property
    def nbytes(self) -> int:
        """Memory of the arrays held, and of one transform."""
        return self.compliance.nbytes + 3 * self._kernel.nbytes

    def apply(self, force: Array, out: Array) -> None:
        """Write the displacement [m] under the pressure ``force`` [Pa] into ``out``."""
        (nx, ny), workers = self.shape, self.threads
        along = scipy.fft.rfft(force, n=2 * ny, axis=1, workers=workers)
        spectrum = scipy.fft.fft(along, n=2 * nx, axis=0, workers=workers)
        spectrum *= self._kernel
        along = scipy.fft.ifft(spectrum, axis=0, workers=workers, overwrite_x=True)[:nx]
        out[...] = scipy.fft.irfft(along, n=2 * ny, axis=1, workers=workers)[:, :ny]

    def precondition(self, residual: Array | Single, out: Array | Single) -> None:
        """Write the pressure [Pa] of cosine waves under a displacement [m] into ``out``."""
        waves = scipy.fft.dctn(residual, workers=self.threads)
        waves /= self.compliance
        out[...] = scipy.fft.idctn(waves, workers=self.threads, overwrite_x=True)


def operator_of(
    response: Response | FreeHalfSpace, shape: Shape, lengths: Lengths, *, threads: int | None = None
) -> FourierOperator | FreeOperator:
    """Return a response on one grid: periodic, or on a patch alone."""
    if isinstance(response, FreeHalfSpace):
        return FreeOperator(response, shape, lengths, threads=threads)
    return FourierOperator(response, shape, lengths, threads=threads)
