"""From the surface table of a scene to heights and spectra: theory and solvers get the same C(q) here."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, overload

from fem_contact.surface import HeightField, RandomWaves, random_waves
from validation.errors import UsageError
from validation.scenes.tables import CapillarySurface, FileSurface, RandomSurface, SelfAffineSurface, Surface
from validation.scenes.topography import Topography, read_topography

if TYPE_CHECKING:
    from persson.capillary import CapillaryWaves
    from persson.spectrum import SelfAffine
    from persson.tabulated import Tabulated

__all__ = [
    "file_digest",
    "height_field",
    "measured_field",
    "measured_spectrum",
    "reference_field",
    "resolving_grid",
    "sampled",
    "spectrum_of",
    "topography_of",
    "waves_of",
]


@overload
def spectrum_of(surface: SelfAffineSurface) -> SelfAffine: ...
@overload
def spectrum_of(surface: RandomSurface) -> SelfAffine | CapillaryWaves: ...
def spectrum_of(surface: RandomSurface) -> SelfAffine | CapillaryWaves:
    """C(q) of a random surface, as its scene says."""
    if isinstance(surface, CapillarySurface):
        return _capillary(surface)
    assert isinstance(surface, SelfAffineSurface)
    from persson.spectrum import SelfAffine

    build: Callable[..., SelfAffine]
    if surface.rms_gradient is not None:
        build, size = SelfAffine.from_rms_gradient, surface.rms_gradient
    else:
        assert surface.rms_height is not None
        build, size = SelfAffine.from_rms_height, surface.rms_height
    return build(
        size,
        hurst=surface.hurst,
        q_long=2 * math.pi / surface.lambda_long,
        q_short=2 * math.pi / surface.lambda_short,
        rolloff=surface.rolloff,
        q_min=None if surface.rolloff == "sharp" else 2 * math.pi / max(surface.length),
    )


def _capillary(surface: CapillarySurface) -> CapillaryWaves:
    from persson.capillary import CapillaryWaves

    return CapillaryWaves(
        temperature=surface.temperature,
        surface_tension=surface.surface_tension,
        q_bend=2 * math.pi / surface.lambda_bend,
        q_min=2 * math.pi / surface.lambda_long,
        q_short=2 * math.pi / surface.lambda_short,
        multiple=float(surface.surfaces**2),
    )


def waves_of(surface: RandomSurface, realisation: int = 0) -> RandomWaves:
    """Draw the waves of one realisation; realisation k is the surface of seed + k."""
    spectrum = spectrum_of(surface)
    return random_waves(
        spectrum,
        q_short=spectrum.q_short,
        lengths=surface.length,
        seed=surface.seed_of(realisation),
        amplitudes=surface.amplitudes,
    )


def sampled(
    waves: RandomWaves,
    surface: RandomSurface,
    grid: tuple[int, int],
    shift: tuple[float, float] = (0.0, 0.0),
) -> HeightField:
    """Sample a surface on a grid, moved by parts of a cell.

    A grid that does not resolve the surface gets its point values; the scene has already been asked whether
    that is wanted. Such a field is shifted on a resolving grid, then sampled.
    """
    field = waves.on(grid, under_resolved=True)
    if shift == (0.0, 0.0):
        return field
    resolving = resolving_grid(surface)
    if all(n >= least for n, least in zip(grid, resolving, strict=True)):
        return field.shifted(shift)
    factors = tuple(-(-least // n) for n, least in zip(grid, resolving, strict=True))
    fine = waves.on((grid[0] * factors[0], grid[1] * factors[1]), under_resolved=True)
    moved = fine.shifted((shift[0] * factors[0], shift[1] * factors[1]))
    return HeightField(heights=moved.heights[:: factors[0], :: factors[1]], lengths=field.lengths)


def height_field(
    surface: Surface,
    grid: tuple[int, int],
    *,
    realisation: int = 0,
    shift: tuple[float, float] = (0.0, 0.0),
) -> HeightField:
    """Heights of one realisation on one grid, moved by parts of a cell; `Realised` does it for many grids."""
    if isinstance(surface, FileSurface):
        field = measured_field(surface, topography_of(surface)).resampled(grid)
        return field if shift == (0.0, 0.0) else field.shifted(shift)
    return sampled(waves_of(surface, realisation), surface, grid, shift)


def resolving_grid(surface: RandomSurface) -> tuple[int, int]:
    """Fewest points that resolve the surface on each axis."""
    nx, ny = (math.floor(2 * length / surface.lambda_short * (1 + 1e-12)) + 1 for length in surface.length)
    return nx, ny


def reference_field(surface: Surface, *, realisation: int = 0) -> HeightField:
    """Return the realisation on the smallest grid that resolves it; its moments are the surface's own."""
    if isinstance(surface, FileSurface):
        return measured_field(surface, topography_of(surface))
    return height_field(surface, resolving_grid(surface), realisation=realisation)


def file_digest(surface: FileSurface) -> str:
    """Hash of the file's content, so that a changed file is another surface.

    Raises
    ------
    UsageError
        For a file that cannot be read.
    """
    try:
        return hashlib.sha256(surface.path.read_bytes()).hexdigest()
    except OSError as error:
        reason = error.strerror or error
        raise UsageError(f"surface.path = {str(surface.path)!r}: cannot be read: {reason}") from None


def topography_of(surface: FileSurface, *, edges: bool = True) -> Topography:
    """Read, level and fill a measured surface as its scene says.

    It is made periodic, too, unless `edges` is False.

    Raises
    ------
    UsageError
        For a file or treatment that gives no surface, naming the key.
    """
    try:
        patch = read_topography(surface.path, lengths=surface.length, unit=surface.unit)
        patch = patch.levelled(surface.tilt).filled(surface.missing)
        return patch.made_periodic(surface.edges, margin=surface.margin) if edges else patch
    except UsageError as error:
        raise UsageError(f"surface.path = {str(surface.path)!r}: {error}") from None


def measured_spectrum(surface: FileSurface) -> Tabulated:
    """C(q) of a measured surface, estimated from the patch before its edges were tapered.

    A patch that is one period needs no window; any other gets a Hann window, with its loss made up for.
    """
    from fem_contact.surface.spectra import estimate_spectrum
    from persson.tabulated import Tabulated

    patch = topography_of(surface, edges=False)
    periodic = surface.edges in (None, "periodic")
    rings = estimate_spectrum(patch.heights, patch.lengths, window="none" if periodic else "hann")
    rough = rings.power > 0
    return Tabulated(wavevectors=rings.q[rough], power=rings.power[rough])


def measured_field(surface: FileSurface, topography: Topography) -> HeightField:
    """Heights of a measured surface as one period; they must be rough, since every p* divides by h'_rms."""
    field = topography.height_field()
    if not field.rms_gradient > 0:
        raise UsageError(
            f"surface.path = {str(surface.path)!r}: is flat (h'_rms = 0); a scene needs a rough surface"
        )
    return field
