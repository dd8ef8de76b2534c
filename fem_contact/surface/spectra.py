"""Power spectra of given surfaces: of periodic ones, and of measured patches that are not."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from fem_contact._checks import choice, instance, non_negative, pair, within
from fem_contact._types import Array, Lengths, Numbers, Shape
from fem_contact.errors import InvalidInput
from fem_contact.surface.heights import HeightField, Patch, checked_shape, interpolant

Window = Literal["none", "hann", "tukey"]


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
    count: Numbers


@dataclass(frozen=True, kw_only=True)
class Lay:
    """The direction that a surface is smoothest along, and by how much.

    Attributes
    ----------
    along, across : float
        Root mean square slopes along the lay and across it [-].
    direction : float
        Angle of the lay with the x axis [rad], in (-pi/2, pi/2]; without meaning where both slopes are equal.
    """

    along: float
    across: float
    direction: float

    @property
    def ratio(self) -> float:
        """Slope across over slope along: Peklenik's number of a stretched surface; 1 if isotropic."""
        return self.across / self.along if self.along > 0 else np.inf


def measured_lay(surface: HeightField) -> Lay:
    r"""Measure the anisotropy of a surface from the tensor of its mean square slopes.

    .. math:: G_{ij} = \langle \partial_i h\, \partial_j h \rangle
              = \sum_{\mathbf q} q_i q_j |h(\mathbf q)|^2

    Its trace is <|grad h|^2>; its eigenvectors lie along the lay and across it.

    Parameters
    ----------
    surface : HeightField
        Periodic, or a `Patch` with edges, whose slopes are differences.

    Raises
    ------
    InvalidInput
        For a flat surface, which has no lay.

    Examples
    --------
    >>> x = np.arange(16) / 16
    >>> grooves = HeightField(heights=np.cos(2 * np.pi * x)[None, :] * np.ones((16, 1)), lengths=(1.0, 1.0))
    >>> lay = measured_lay(grooves)
    >>> round(lay.direction, 12), round(lay.along, 12), round(lay.across / (2 * np.pi), 6)
    (0.0, 0.0, 0.707107)
    """
    instance("surface", surface, HeightField)
    if isinstance(surface, Patch):
        along, across = (np.diff(surface.heights, axis=k) / surface.spacing[k] for k in (0, 1))
        # In the middle of four points both are known.
        both = (along[:, 1:] + along[:, :-1]) * (across[1:] + across[:-1]) / 4
        xx, yy, xy = (float(np.mean(part)) if part.size else 0.0 for part in (along**2, across**2, both))
    else:
        qx, qy, coefficients = interpolant(surface)
        power = np.abs(coefficients) ** 2
        xx, yy, xy = power.sum(axis=1) @ qx**2, power.sum(axis=0) @ qy**2, qx @ power @ qy
    if not xx + yy > 0:
        raise InvalidInput("a flat surface has no lay")
    values, vectors = np.linalg.eigh([[xx, xy], [xy, yy]])
    x, y = vectors[:, 0] * (1 if vectors[0, 0] > 0 or (vectors[0, 0] == 0 and vectors[1, 0] > 0) else -1)
    smooth, steep = np.sqrt(np.maximum(values, 0))
    return Lay(along=float(smooth), across=float(steep), direction=float(np.arctan2(y, x)))


def radial_spectrum(surface: HeightField, *, band: tuple[float, float] | None = None) -> RadialSpectrum:
    """Measure C(q) averaged over rings one fundamental wavevector wide, of a patch under a Hann window.

    Convention as in Persson 2006, <h^2> = 2 pi int q C dq; multiply by (2 pi)^2 for the areal PSD of other
    communities.

    Parameters
    ----------
    surface : HeightField
    band : tuple of float, optional
        Least and largest |q| [1/m] of the waves that count, if not all. Rings at the cut-offs of a surface
        that is made of such waves hold others, too, which carry nothing.

    Raises
    ------
    InvalidInput
        For a band that is no pair of wavevectors.
    """
    instance("surface", surface, HeightField)
    what = "a pair of wavevectors (least, largest) in 1/m"
    low, high = (0.0, np.inf) if band is None else pair("band", band, non_negative, what=what)
    qx, qy, coefficients = interpolant(surface.windowed() if isinstance(surface, Patch) else surface)
    q = np.hypot(qx[:, None], qy[None, :])
    unit = 2 * np.pi / min(surface.lengths)
    # A wave at a cut-off is in the band, whatever its last digit.
    inside = (q > 0) & (q >= low * (1 - 1e-9)) & (q <= high * (1 + 1e-9))
    ring = np.rint(q[inside] / unit).astype(np.int64)
    count = np.bincount(ring)
    cell = (2 * np.pi) ** 2 / (surface.lengths[0] * surface.lengths[1])
    power = np.bincount(ring, weights=np.abs(coefficients[inside]) ** 2) / cell
    mean_q = np.bincount(ring, weights=q[inside])
    filled = count > 0  # on an oblong period waves along its longer side lie in the ring below the first, too
    return RadialSpectrum(
        q=mean_q[filled] / count[filled], power=power[filled] / count[filled], count=count[filled]
    )


def window_weights(shape: Shape, *, window: Window, margin: float = 0.1) -> Array:
    r"""Weights of a separable window on a grid of cell centres.

    .. math:: w(x) = \tfrac12[1 - \cos(\pi x / b)] \text{ for } x < b,\quad 1 \text{ inside},\quad
              b = L/2 \text{ (Hann)},\ b = \text{margin}\cdot L \text{ (Tukey)}

    Parameters
    ----------
    shape : tuple of int
        Points (nx, ny).
    window : {"none", "hann", "tukey"}
    margin : float
        Share of each side over which a Tukey window rises, in (0, 1/2].

    Returns
    -------
    (nx, ny) array
        Between 0 and 1.

    Examples
    --------
    >>> window_weights((4, 1), window="tukey", margin=0.25).ravel().round(3).tolist()
    [0.5, 1.0, 1.0, 0.5]
    """
    shape = checked_shape(shape)
    choice("window", window, ("none", "hann", "tukey"))
    margin = within("margin", margin, "[1e-9, 0.5]")
    if window == "none":
        return np.ones(shape)
    width = 0.5 if window == "hann" else margin
    sides = []
    for n in shape:
        centres = (np.arange(n) + 0.5) / n
        inwards = np.minimum(np.minimum(centres, 1 - centres) / width, 1.0)
        sides.append((1 - np.cos(np.pi * inwards)) / 2 if n > 1 else np.ones(1))
    return np.multiply.outer(sides[0], sides[1])


def estimate_spectrum(heights: ArrayLike, lengths: Lengths, *, window: Window = "hann") -> RadialSpectrum:
    r"""Estimate C(q) of a measured patch whose opposite edges do not match.

    .. math:: C(q) = \frac{L_x L_y}{(2\pi)^2}\,
              \frac{\langle |\widehat{w (h - \bar h)}|^2 \rangle_{|\mathbf q| = q}}{\langle w^2 \rangle}

    Parameters
    ----------
    heights : (nx, ny) array
        Heights [m], without tilt and without missing points.
    lengths : tuple of float
        Size of the patch (Lx, Ly) [m].
    window : {"hann", "none", "tukey"}
        What brings the edges down. Without one the jump between opposite edges fills the spectrum with
        a tail like q^-3 that is not the surface's; "none" is for periodic surfaces.

    Returns
    -------
    RadialSpectrum
        Rings one wavevector 2 pi / min(L) wide, from the second up to the Nyquist wavevector of the coarser
        axis: a window blurs C(q) over two rings, and nothing is known of longer waves than the patch.

    Raises
    ------
    InvalidInput
        For heights that are not a finite two-dimensional array, or a patch too small for a single ring.

    Notes
    -----
    Convention of Persson 2006, <h^2> = 2 pi int q C dq; times (2 pi)^2 it is the areal power spectral density
    of other communities. The estimate scatters by 1/sqrt(count) per ring.
    """
    patch = HeightField(heights=heights, lengths=lengths)  # type: ignore[arg-type]
    weights = window_weights(patch.shape, window=window)
    power = float(np.mean(weights**2))
    mean = float(np.mean(weights * patch.heights)) / float(np.mean(weights))
    windowed = HeightField(heights=weights * (patch.heights - mean), lengths=lengths)
    rings = radial_spectrum(windowed)
    nyquist = np.pi / max(patch.spacing)
    first = 2 * np.pi / min(lengths) * (0.5 if window == "none" else 1.5)
    keep = (rings.q <= nyquist * (1 + 1e-12)) & (rings.q >= first)
    if not keep.any():
        raise InvalidInput(f"heights of shape {patch.shape}: too few points for a spectrum")
    return RadialSpectrum(q=rings.q[keep], power=rings.power[keep] / power, count=rings.count[keep])
