"""Power spectra and surfaces made from them: moments by quadrature, waves by their own sums."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator

import numpy as np
from scipy.integrate import quad

from fem_contact.surface import HeightField, estimate_spectrum, radial_spectrum, random_surface
from persson.capillary import CapillaryWaves, maximum_height
from persson.spectrum import SelfAffine, Spectrum
from persson.tabulated import Tabulated
from validation.arrays import Array
from validation.cases import Check, below, case, relative


def _moment(power: Callable[[float], float], k: int, edges: tuple[float, ...]) -> float:
    """2 pi int q^(2k+1) C dq between edges, in ln q, by a quadrature that knows no panel."""
    return sum(
        quad(
            lambda x: 2 * math.pi * math.exp((2 * k + 2) * x) * power(math.exp(x)),
            math.log(low),
            math.log(high),
            epsabs=0,
            epsrel=1e-11,
        )[0]
        for low, high in itertools.pairwise(edges)
    )


def _judged(
    name: str, spectrum: Spectrum, power: Callable[[float], float], edges: tuple[float, ...]
) -> Iterator[Check]:
    """Compare a spectrum and its moments with C(q) as its definition has it."""
    middle = math.sqrt(edges[-2] * edges[-1])
    found = (spectrum.m0(), spectrum.m2(), spectrum.m4())
    yield relative(f"C(q), {name}", spectrum(middle), power(middle), 1e-12)
    for k, m in enumerate(found):
        yield relative(f"m{2 * k}, {name}", m, _moment(power, k, edges), 1e-9)


_HURST, _LONG, _SHORT, _LEAST = 0.7, 3.0, 200.0, 0.5


@case(
    "spectra-self-affine",
    "Self-affine spectra have the moments of their C(q), with each roll-off.",
    source="Persson 2006, Sec. 2; quadrature over ln q",
)
def _self_affine() -> Iterator[Check]:
    exponent = -2 * (1 + _HURST)
    shapes: dict[str, tuple[Callable[[float], float], tuple[float, ...]]] = {
        "sharp": (lambda q: (q / _LONG) ** exponent, (_LONG, _SHORT)),
        "plateau": (lambda q: max(q / _LONG, 1.0) ** exponent, (_LEAST, _LONG, _SHORT)),
        "smooth": (lambda q: ((1 + (q / _LONG) ** 2) / 2) ** (exponent / 2), (_LEAST, _LONG, _SHORT)),
    }
    for rolloff, (power, edges) in shapes.items():
        spectrum = SelfAffine(
            hurst=_HURST,
            q_long=_LONG,
            q_short=_SHORT,
            amplitude=1.0,
            rolloff=rolloff,  # type: ignore[arg-type]
            q_min=edges[0],
        )
        yield from _judged(f"{rolloff} roll-off", spectrum, power, edges)
        m0, m2, m4 = (_moment(power, k, edges) for k in range(3))
        moments = spectrum.moments()
        yield relative(f"h_rms, {rolloff}", moments.rms_height, math.sqrt(m0), 1e-9)
        yield relative(f"h'_rms, {rolloff}", moments.rms_gradient, math.sqrt(m2), 1e-9)
        yield relative(f"Nayak parameter, {rolloff}", moments.nayak, 1.5 * m0 * m4 / m2**2, 1e-9)


@case(
    "spectra-capillary",
    "Frozen capillary waves have the C(q) of equipartition with gravity, tension and bending.",
    source="Persson 2006, Eqs. 2 and 3, App. A",
)
def _capillary() -> Iterator[Check]:
    """Freeze a polymer of .04 J/m^2 at 370 K, with gravity strong enough to matter."""
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
    yield from _judged("capillary waves", waves, power, edges)
    low = 2e6
    yield relative("C(q) where gravity acts", waves(low), power(low), 1e-12)
    for points in (1e4, 1e8):
        ratio = maximum_height(points)
        argument = 2 * math.log(points / ratio / math.sqrt(2 * math.pi))
        name = f"h_1 / h_rms of {points:g} points"
        yield relative(name, ratio, math.sqrt(argument), 1e-12)


@case(
    "spectra-table",
    "A table of a power law is that power law, and areal PSDs are (2 pi)^2 C.",
    source="quadrature over ln q",
)
def _tables() -> Iterator[Check]:
    """Give a power law by its points; the areal PSD of others is (2 pi)^2 C."""
    q = np.geomspace(2.0, 300.0, 9)

    def power(wave: float) -> float:
        return float(1e-3 * wave**-3.4)

    table = Tabulated(wavevectors=q, power=np.array([power(wave) for wave in q]))
    areal = Tabulated.from_areal_psd(q, (2 * math.pi) ** 2 * table.power)
    off = float(np.max(np.abs(areal.power / table.power - 1)))
    back = float(np.max(np.abs(areal.areal_psd() / table.power / (2 * math.pi) ** 2 - 1)))
    yield from _judged("table", table, power, (2.0, 300.0))
    yield below("error of C read from an areal PSD", off, 1e-14)
    yield below("error of the areal PSD written from C", back, 1e-14)


_LENGTHS = (1.0, 0.625)


def _drawn(shape: tuple[int, int]) -> HeightField:
    return random_surface(_power, q_short=80.0, lengths=_LENGTHS, shape=shape, seed=7_919)


def _power(q: Array) -> Array:
    return np.asarray(1e-6 * (1 + q * q / 400) ** -1.8)


@case(
    "surface-waves",
    "A random surface carries |h(q)|^2 = (2 pi)^2 C(q) / A0 in each wave, whatever the grid.",
    source="Persson 2006, Eq. 1; exact",
)
def _generator() -> Iterator[Check]:
    """Draw a surface on an oblong period, and sum its waves as Eq. 1 has them."""
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
    found = np.abs(np.fft.fft2(surface.heights)[3, 2] / surface.heights.size) ** 2
    one = cell * float(_power(np.array(2 * math.pi * math.hypot(3 / lx, 2 / ly))))
    yield relative("|h(q)|^2 of one wave", found, one, 1e-10)
    finer = _drawn((80, 64))
    off = float(np.max(np.abs(finer.heights[::2, ::2] - surface.heights)) / surface.rms_height)
    yield below("difference of two grids at their common points", off, 1e-12)
    other = random_surface(_power, q_short=80.0, lengths=_LENGTHS, shape=(40, 32), seed=7_920)
    likeness = float(np.mean(surface.heights * other.heights)) / surface.rms_height / other.rms_height
    # Of m waves with independent phases the correlation has the deviation (2 / m)^(1/2): .15 or less here.
    yield below("correlation of two seeds", likeness, 4 * math.sqrt(2 / np.sum(waves)))


@case(
    "surface-shift",
    "A surface seen by a shifted grid is the same surface.",
    source="trigonometric interpolation; exact",
)
def _between() -> Iterator[Check]:
    surface = _drawn((40, 32))
    finer = surface.resampled((160, 128)).heights
    miss = surface.shifted((0.25, 0.75)).heights - finer[1::4, 3::4]
    yield below("shifted against resampled", float(np.max(np.abs(miss))) / surface.rms_height, 1e-12)
    # The shortest wave of an even grid is cos(pi i): moved by a quarter of a cell, cos(pi (i + 1/4)).
    i = np.arange(8)
    short = HeightField(heights=np.cos(math.pi * i)[:, None] * np.ones(3), lengths=(1.0, 1.0))
    moved = short.shifted((0.25, 0.0)).heights[:, 0]
    exact = np.cos(math.pi * i) * math.cos(math.pi / 4)
    yield below("shortest wave, moved", moved - exact, 1e-12)
    # Between its points it is a cosine, of mean square 1/2.
    rings = radial_spectrum(short)
    power = float(np.sum(rings.power * rings.count)) * (2 * math.pi) ** 2
    yield relative("mean square of the shortest wave", power, 0.5, 1e-12)
    # A ramp of phase tells the direction.
    wave = HeightField(heights=np.cos(2 * math.pi * i / 8)[:, None] * np.ones(3), lengths=(1.0, 1.0))
    found = wave.shifted((0.3, 0.0)).heights[:, 1]
    exact = np.cos(2 * math.pi * (i + 0.3) / 8)
    yield below("long wave, moved", found - exact, 1e-12)


@case(
    "surface-measured",
    "The spectrum measured of a surface is the one it was made with.",
    source="Parseval's theorem; F. J. Harris, Proc. IEEE 66, 51 (1978)",
    tolerance="estimate",
)
def _measured() -> Iterator[Check]:
    """Measure the spectrum of a surface whose C(q) is the same for all waves."""
    lengths = (1.0, 0.5)

    def flat(q: Array) -> Array:
        return np.full(q.shape, 2e-5)

    exact = random_surface(flat, q_short=200.0, lengths=lengths, shape=(80, 40), seed=6_007)
    rings = radial_spectrum(exact)
    whole = (rings.q > 30) & (rings.q < 180)
    worst = float(np.max(np.abs(rings.power[whole] / 2e-5 - 1)))
    sample = random_surface(
        flat, q_short=200.0, lengths=lengths, shape=(80, 40), seed=6_011, amplitudes="gaussian"
    )
    found = estimate_spectrum(sample.heights, lengths, window="hann")
    inside = (found.q > 30) & (found.q < 160)
    mean = float(np.average(found.power[inside], weights=found.count[inside]))
    # Half of the waves are independent, and a Hann window spreads each over 9/4 waves.
    error = math.sqrt(2 * 9 / 4 / float(np.sum(found.count[inside])))
    yield below("error of C(q) of a periodic surface", worst, 1e-9)
    yield relative("mean C(q) of a patch seen through a window [m^4]", mean, 2e-5, 4 * error)
