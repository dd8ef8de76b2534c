"""Power spectra and surfaces made from them: moments by quadrature, waves by their own sums."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np

from fem_contact.surface import HeightField, random_surface
from persson.capillary import CapillaryWaves, maximum_height
from persson.spectrum import SelfAffine, Spectrum
from persson.stretched import Stretched
from validation.arrays import Array, Grid
from validation.cases import Checks, below, case, relative
from validation.cases._closed_forms import integral


def _compared(
    name: str, spectrum: Spectrum, power: Callable[[float], float], edges: tuple[float, ...]
) -> Checks:
    """Compare a spectrum and its moments with C(q) as its definition has it."""
    middle, bounds = math.sqrt(edges[-2] * edges[-1]), [math.log(edge) for edge in edges]
    yield relative(f"C(q), {name}", spectrum(middle), power(middle), 1e-12)
    for k, moment in enumerate((spectrum.m0(), spectrum.m2(), spectrum.m4())):
        # 2 pi int q^(2k+1) C dq between edges, in ln q.
        def density(x: float, k: int = k) -> float:
            return 2 * math.pi * math.exp((2 * k + 2) * x) * power(math.exp(x))

        exact = sum(integral(density, *pair) for pair in itertools.pairwise(bounds))
        yield relative(f"m{2 * k}, {name}", moment, exact, 1e-9)


_HURST, _LONG, _SHORT, _LEAST = 0.7, 3.0, 200.0, 0.5


@case("spectra-self-affine", source="Persson 2006, Sec. 2; quadrature over ln q")
def _self_affine() -> Checks:
    """Self-affine spectra have the moments of their C(q), with each roll-off."""
    exponent = -2 * (1 + _HURST)
    shapes: dict[str, tuple[Callable[[float], float], tuple[float, ...]]] = {
        "sharp": (lambda q: (q / _LONG) ** exponent, (_LONG, _SHORT)),
        "plateau": (lambda q: max(q / _LONG, 1.0) ** exponent, (_LEAST, _LONG, _SHORT)),
        "smooth": (lambda q: ((1 + (q / _LONG) ** 2) / 2) ** (exponent / 2), (_LEAST, _LONG, _SHORT)),
    }
    for rolloff, (power, edges) in shapes.items():
        waves = {"q_long": _LONG, "q_short": _SHORT, "q_min": edges[0]}
        spectrum = SelfAffine(hurst=_HURST, amplitude=1.0, rolloff=rolloff, **waves)  # type: ignore[arg-type]
        yield from _compared(f"{rolloff} roll-off", spectrum, power, edges)


@case("spectra-capillary", source="Persson 2006, Eqs. 2 and 3, App. A")
def _capillary() -> Checks:
    """Frozen capillary waves have the C(q) of equipartition with gravity, tension and bending.

    Freeze a polymer of .04 J/m^2 at 370 K, with gravity strong enough to matter.
    """
    temperature, tension, bend, gravity = 370.0, 0.04, 1.7e9, 3e6
    edges = (6.28e5, 1e7, 1e9, 7e9)

    def power(q: float) -> float:
        stiffness = tension * (gravity**2 + q**2 + q**4 / bend**2)
        return 1.380649e-23 * temperature / (2 * math.pi) ** 2 / stiffness

    waves = CapillaryWaves(
        temperature=temperature,
        surface_tension=tension,
        q_bend=bend,
        q_gravity=gravity,
        q_min=edges[0],
        q_short=edges[-1],
    )
    yield from _compared("capillary waves", waves, power, edges)
    low = 2e6
    yield relative("C(q) where gravity acts", waves(low), power(low), 1e-12)
    for points in (1e4, 1e8):
        ratio = maximum_height(points)
        exact = math.sqrt(2 * math.log(points / ratio / math.sqrt(2 * math.pi)))
        yield relative(f"h_1 / h_rms of {points:g} points", ratio, exact, 1e-12)


_STRAIGHT = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=16 * math.pi, q_short=128 * math.pi)


@case("stretched-moments", source="Integrals of (cos^2/gamma^2 + sin^2)^k over the directions")
def _lay() -> Checks:
    """The average over directions of a stretched spectrum has its closed moments."""
    for factor in (2.0, 5.0, 20.0):
        lay, inverse = Stretched(spectrum=_STRAIGHT, factor=factor), factor**-2
        for name, ratio, exact in (
            ("m0", float(lay.m0() / _STRAIGHT.m0()), 1.0),
            ("m2", float(lay.m2() / _STRAIGHT.m2()), (1 + inverse) / 2),
            ("m4", float(lay.m4() / _STRAIGHT.m4()), (3 + 2 * inverse + 3 * inverse**2) / 8),
        ):
            yield relative(f"{name} over the isotropic, gamma = {factor:g}", ratio, exact, 1e-9)


_LENGTHS = (1.0, 0.625)


def _drawn(shape: Grid) -> HeightField:
    return random_surface(_power, q_short=80.0, lengths=_LENGTHS, shape=shape, seed=7_919)


def _power(q: Array) -> Array:
    return np.asarray(1e-6 * (1 + q * q / 400) ** -1.8)


@case("surface-waves", source="Persson 2006, Eq. 1; exact")
def _generator() -> Checks:
    """A random surface carries |h(q)|^2 = (2 pi)^2 C(q) / A0 in each wave, whatever the grid."""
    surface = _drawn((40, 32))
    (lx, ly), cell = _LENGTHS, (2 * math.pi) ** 2 / (_LENGTHS[0] * _LENGTHS[1])
    m, n = np.meshgrid(np.arange(-20, 21), np.arange(-20, 21), indexing="ij")
    q = 2 * math.pi * np.hypot(m / lx, n / ly)
    waves = (q > 0) & (q <= 80.0)
    sums = [float(np.sum(cell * _power(q[waves]) * q[waves] ** (2 * k))) for k in range(3)]
    for k, moment in enumerate(surface.moments):
        yield relative(f"m{2 * k} over the waves of the period", moment, sums[k], 1e-12)
    alpha = 1.5 * sums[0] * sums[2] / sums[1] ** 2
    yield relative("Nayak parameter of the surface", surface.nayak, alpha, 1e-12)
    # One wave of each pair +-q stands in the transform of a real field.
    power = np.abs(np.fft.fft2(surface.heights)[3, 2] / surface.heights.size) ** 2
    one = cell * float(_power(np.array(2 * math.pi * math.hypot(3 / lx, 2 / ly))))
    yield relative("|h(q)|^2 of one wave", power, one, 1e-10)
    off = (_drawn((80, 64)).heights[::2, ::2] - surface.heights) / surface.rms_height
    yield below("difference of two grids at their common points", off, 1e-12)
