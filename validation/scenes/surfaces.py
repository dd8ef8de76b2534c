"""From the surface table of a scene to heights and spectra: theory and solvers get the same C(q) here."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from fem_contact.surface import HeightField, RandomWaves, random_waves
from validation.arrays import Grid, Pair
from validation.errors import UsageError
from validation.files import available_memory
from validation.report.quantities import as_length
from validation.scenes.tables import (
    CapillarySurface,
    FileSurface,
    RandomSurface,
    SelfAffineSurface,
    SpectrumSurface,
    Surface,
)
from validation.scenes.topography.formats import bytes_of, one_line
from validation.scenes.topography.measured import Measured
from validation.scenes.topography.text import read_columns

if TYPE_CHECKING:
    from persson.capillary import CapillaryWaves
    from persson.spectrum import SelfAffine
    from persson.stretched import Stretched
    from persson.tabulated import Tabulated

    AnySpectrum: TypeAlias = SelfAffine | Stretched | CapillaryWaves | Tabulated


def spectrum_of(surface: RandomSurface) -> AnySpectrum:
    """C(q) of a random surface, as its scene says; with a lay, averaged over directions."""
    if isinstance(surface, SpectrumSurface):
        return spectrum_between(surface)
    q_long, q_short = 2 * math.pi / surface.lambda_long, 2 * math.pi / surface.lambda_short
    if isinstance(surface, CapillarySurface):
        from persson.capillary import CapillaryWaves

        return CapillaryWaves(
            temperature=surface.temperature,
            surface_tension=surface.surface_tension,
            q_bend=2 * math.pi / surface.lambda_bend,
            q_min=q_long,
            q_short=q_short,
            multiple=float(surface.surfaces**2),
        )
    assert isinstance(surface, SelfAffineSurface)
    from persson.spectrum import SelfAffine

    by_height = surface.rms_height is not None
    build = SelfAffine.from_rms_height if by_height else SelfAffine.from_rms_gradient
    straight = build(
        surface.rms_height or surface.rms_gradient or math.nan,  # of which there is one
        hurst=surface.hurst,
        q_long=q_long,
        q_short=q_short,
        rolloff=surface.rolloff,
        q_min=None if surface.rolloff == "sharp" else 2 * math.pi / max(surface.length),
    )
    if surface.stretch is None:
        return straight
    from persson.stretched import Stretched

    stretched = Stretched(spectrum=straight, factor=surface.stretch)
    # The height keeps its variance when it is stretched, the slope does not.
    return stretched if by_height else stretched.scaled(float(straight.m2() / stretched.m2()))


def band_of(surface: Surface) -> Pair | None:
    """Least and largest |q| [1/m] of the waves that a surface is made of; None if it was measured."""
    if isinstance(surface, FileSurface):
        return None
    sharp = getattr(surface, "rolloff", "sharp") == "sharp"
    q_long = 2 * math.pi / (surface.lambda_long * surface.elongation)
    return q_long if sharp else 0.0, 2 * math.pi / surface.lambda_short


def read_spectrum(path: Path, *, units: Pair | None = None, power: str = "C") -> tuple[Tabulated, str]:
    """Return C(q) of a file where it is above 0, and the SHA-256 of its bytes.

    A UsageError for a file that holds no C(q).
    """
    from persson.tabulated import Tabulated

    name = f"surface.path = {str(path)!r}"
    try:
        data = bytes_of(str(path))
        table = read_columns(data)
    except OSError as error:
        raise UsageError(f"{name}: cannot be read: {one_line(error.strerror or error)}") from None
    except (UsageError, ValueError) as error:
        raise UsageError(f"{name}: is no table of q and C ({one_line(error)})") from None
    if table.shape[1] != 2:
        raise UsageError(f"{name}: must have two columns, q and C; it has {table.shape[1]}")
    for bad, words in (
        (~np.isfinite(table).all(axis=1), "must be finite"),
        (table[:, 0] <= 0, "q must be positive"),
        (np.diff(table[:, 0], prepend=-np.inf) <= 0, "q must rise from row to row"),
        (table[:, 1] < 0, "C must not be negative"),
    ):
        if bad.any():
            row = int(np.argmax(bad))
            q, c = table[row]
            raise UsageError(f"{name}: row {row + 1} has q, C = {q:g}, {c:g}; {words}")
    rough = np.flatnonzero(table[:, 1])
    if rough.size < 2 or rough.size <= rough[-1] - rough[0]:
        raise UsageError(f"{name}: C must be above 0 in two rows or more, without a gap between them")
    q, c = (table[rough] * (units or (1.0, 1.0))).T
    made = Tabulated if power == "C" else Tabulated.from_areal_psd
    return made(wavevectors=q, power=c), hashlib.sha256(data).hexdigest()


def spectrum_between(surface: SpectrumSurface) -> Tabulated:
    """Return C(q) of a surface from lambda_long to lambda_short; a UsageError beyond its table."""
    from persson.tabulated import Tabulated

    whole, _ = read_spectrum(surface.path, units=surface.units, power=surface.power)
    q, edge = whole.wavevectors, 1e-9
    low, high = 2 * math.pi / surface.lambda_long, 2 * math.pi / surface.lambda_short
    if low < q[0] * (1 - edge) or high > q[-1] * (1 + edge):
        raise UsageError(
            f"surface: waves of {as_length(surface.lambda_short)} to {as_length(surface.lambda_long)}; "
            f"the table has those of {as_length(2 * math.pi / q[-1])} to {as_length(2 * math.pi / q[0])}"
        )
    q = np.concatenate([[low], q[(q > low * (1 + edge)) & (q < high * (1 - edge))], [high]])
    return Tabulated(wavevectors=q, power=whole(np.clip(q, whole.q_min, whole.q_short)))


def waves_of(surface: RandomSurface, realisation: int) -> RandomWaves:
    """Draw the waves of one realisation; realisation k is the surface of seed + k."""
    return random_waves(**waves_drawn(surface, realisation))


def waves_drawn(surface: RandomSurface, realisation: int) -> dict[str, Any]:
    """Return what the waves of one realisation are drawn by."""
    spectrum = spectrum_of(surface)
    directional = getattr(spectrum, "directional", None)
    return {
        "spectrum": directional or spectrum,
        "q_short": spectrum.q_short,
        "lengths": surface.length,
        "seed": surface.seed_of(realisation),
        "amplitudes": surface.amplitudes,
        "isotropic": directional is None,
    }


def sampled(waves: RandomWaves, surface: RandomSurface, grid: Grid, shift: Pair = (0.0, 0.0)) -> HeightField:
    """Sample a surface on a grid, moved by parts of a cell.

    A grid that does not resolve the surface gets its point values; the scene has already been asked whether
    that is wanted. Such a field is shifted on a resolving grid, then sampled.
    """
    field = waves.on(grid, under_resolved=True)
    if shift == (0.0, 0.0):
        return field
    factors = [-(-least // n) for n, least in zip(grid, surface.resolving_grid, strict=True)]
    if factors == [1, 1]:
        return field.shifted(shift)
    fine = waves.on((grid[0] * factors[0], grid[1] * factors[1]), under_resolved=True)
    moved = fine.shifted((shift[0] * factors[0], shift[1] * factors[1]))
    return HeightField(heights=moved.heights[:: factors[0], :: factors[1]], lengths=field.lengths)


def height_field(surface: Surface, grid: Grid | None = None, *, realisation: int = 0) -> HeightField:
    """Heights of a realisation, or of the first map of a file; `ContactProblem` makes them for many grids.

    Without a grid on the smallest that resolves it, so that its moments are its own; a map on its own points.
    """
    if isinstance(surface, FileSurface):
        field = Measured.read(surface).field
        return field if grid is None else field.resampled(grid)
    if grid is None:
        check_memory(surface)
    return sampled(waves_of(surface, realisation), surface, grid or surface.resolving_grid)


#: Memory that making a random surface takes for each of its points at its peak [bytes], measured.
_BYTES_PER_POINT = 60
#: Points of a surface that is made only to be looked at; a gigabyte.
SURVEYED_POINTS = 2**24


def check_memory(surface: RandomSurface) -> None:
    """Refuse to resolve a surface that does not fit into memory, before anything of it is made."""
    grid = surface.resolving_grid
    least = surface.lambda_short * math.sqrt(_BYTES_PER_POINT * math.prod(grid) / available_memory())
    check_fits(
        grid,
        f"surface.lambda_short = {as_length(surface.lambda_short)}: resolving it",
        remedy=f"take a lambda_short above {as_length(least, 3)}, or a smaller length",
    )


def check_fits(grid: Grid, what: str, *, remedy: str) -> None:
    """Refuse a grid whose heights alone do not fit into memory."""
    needed, free = _BYTES_PER_POINT * math.prod(grid), available_memory()
    if needed > free:
        raise UsageError(
            f"{what} takes {grid[0]} x {grid[1]} points and {needed / 2**30:.3g} GiB, of which "
            f"{free / 2**30:.3g} are free; {remedy}"
        )


@dataclass(frozen=True, kw_only=True)
class Expected:
    """What C(q) gives for a random surface that is not made: for the theory alone, or only to be looked at.

    `moments` (m0 [m^2], m2 [1], m4 [m^-2]) are integrals over C(q); to the `first_moment`, 2 pi int q^2 C dq
    [m], the energy of full contact is proportional; `shape` would resolve it.
    """

    moments: tuple[float, float, float]
    rms_height: float  # [m]
    rms_gradient: float
    nayak: float
    first_moment: float
    shape: Grid


def expected(surface: RandomSurface) -> Expected:
    """Return what C(q) gives in place of a surface."""
    spectrum = spectrum_of(surface)
    moments = spectrum.moments()
    q = np.geomspace(spectrum.q_min, spectrum.q_short, 4001)
    first = 2 * math.pi * float(np.trapezoid(q**3 * spectrum(q), np.log(q)))
    return Expected(
        moments=(moments.m0, moments.m2, moments.m4),
        rms_height=moments.rms_height,
        rms_gradient=moments.rms_gradient,
        nayak=moments.nayak,
        first_moment=first,
        shape=surface.resolving_grid,
    )
