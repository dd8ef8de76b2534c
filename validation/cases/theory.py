"""What the theory says by itself: spectra and surfaces made from them, asperities, limits, P(sigma)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable

import numpy as np

from fem_contact.surface import HeightField, random_surface
from persson import elastic, spheres
from persson.asperities import bush_gibson_thomas, nayak_asperities, ring_asperities
from persson.capillary import CapillaryWaves, maximum_height
from persson.spectrum import Moments, SelfAffine, Spectrum
from persson.stretched import Stretched
from validation.arrays import Array, Grid
from validation.cases import Checks, below, case, near, relative
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
    sums = [np.sum(cell * _power(q[waves]) * q[waves] ** (2 * k)) for k in range(3)]
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


_RADIUS, _MODULUS, _WORK = 2e-3, 3e6, 0.05


@case("spheres-adhesive", source="[johnson1971]; [maugis1992]")
def _jkr() -> Checks:
    """An adhesive sphere comes off at 3/2 pi w R if soft, at 2 pi w R if stiff."""

    def load(a: float | Array) -> Array:
        return spheres.jkr_load(a, radius=_RADIUS, contact_modulus=_MODULUS, work_of_adhesion=_WORK)

    # Without load a^3 = 9 pi w R^2 / (2 E*); at pull-off it is a quarter of that.
    free = math.cbrt(4.5 * math.pi * _WORK * _RADIUS**2 / _MODULUS)
    around = free * np.linspace(0.2, 1.0, 4001)
    unit, reach = math.pi * _WORK * _RADIUS, 4e-9
    tabor = spheres.tabor_parameter(_RADIUS, contact_modulus=_MODULUS, work_of_adhesion=_WORK, range_=reach)
    exact = (_RADIUS * _WORK**2 / _MODULUS**2 / reach**3) ** (1 / 3)
    soft = spheres.jkr_pull_off(_RADIUS, work_of_adhesion=_WORK)
    stiff = spheres.derjaguin_pull_off(_RADIUS, work_of_adhesion=_WORK)
    yield below("F at the radius of no load, over pull-off", load(free) / (1.5 * unit), 1e-12)
    yield relative("smallest F [N]", np.min(load(around)), -1.5 * unit, 1e-6)
    yield relative("pull-off force [N]", soft, 1.5 * unit, 1e-12)
    yield relative("pull-off of stiff spheres over pi w R", stiff / unit, 2.0, 1e-12)
    yield relative("Tabor parameter", tabor, exact, 1e-12)
    # Maugis's transition, to the fourth digit of its limits.
    yield relative("pull-off of Maugis at mu = 1e-3", spheres.maugis_pull_off(1e-3), 2.0, 2e-3)
    yield relative("pull-off of Maugis at mu = 50", spheres.maugis_pull_off(50.0), 1.5, 2e-3)


#: Moments of a surface with a Nayak parameter of 12.
_MOMENTS = Moments(m0=4e-12, m2=1e-2, m4=1e-2**2 * 8 / 4e-12)


@case("asperities-summits", source="[nayak1971]; [mccool1987]")
def _summits() -> Checks:
    """Summits of a random surface have Nayak's density, curvature and heights.

    Statistics of summits in the moments of a profile: mu0 = m0, mu2 = m2 / 2, mu4 = 3 m4 / 8.
    """
    mu2, mu4 = _MOMENTS.m2 / 2, 3 * _MOMENTS.m4 / 8
    alpha = _MOMENTS.m0 * mu4 / mu2**2
    asperities = nayak_asperities(_MOMENTS)
    density = mu4 / mu2 / (6 * math.pi * math.sqrt(3))
    mean = 4 * math.sqrt(_MOMENTS.m0 / (math.pi * alpha))
    deviation = math.sqrt(_MOMENTS.m0 * (1 - 0.8968 / alpha))
    # How many summits stand above a plane tells where they are: mean and scatter of their heights.
    d = np.linspace(-8, 8, 401) * math.sqrt(_MOMENTS.m0)
    contact = bush_gibson_thomas(d, moments=_MOMENTS, contact_modulus=1.0)
    share = contact.density / density
    under = (d < 0).astype(float)
    under[d == 0] = 0.5
    first = np.trapezoid(share - under, d)
    second = 2 * np.trapezoid(d * (share - under), d)
    ring = ring_asperities(1e5, rms_height=1e-6)
    yield relative("Nayak parameter", _MOMENTS.nayak, alpha, 1e-12)
    yield relative("density [1/m^2]", asperities.density, density, 1e-12)
    yield relative("mean curvature [1/m]", 1 / asperities.radius, 8 / 3 * math.sqrt(mu4 / math.pi), 1e-12)
    yield relative("scatter of heights [m]", asperities.rms_height, deviation, 1e-4)
    yield relative("mean height, counted above planes [m]", first, mean, 1e-4)
    scatter = math.sqrt(second - first**2)
    yield relative("scatter of heights, counted above planes [m]", scatter, deviation, 1e-3)
    yield near("n_0 / q^2 of one wavelength", ring.density / 1e10, 0.029, 5e-4)
    yield relative("1/R of one wavelength [1/m]", 1 / ring.radius, math.sqrt(2) * 1e10 * 1e-6, 1e-12)
    yield relative("h* of one wavelength [m]", ring.rms_height, 0.6e-6, 1e-12)


@case("theory-light-load", source="[bush1975]", tolerance="estimate")
def _light_load() -> Checks:
    """At light load kappa of independent asperities is sqrt(2 pi)."""
    moments = SelfAffine.from_rms_gradient(1.0, hurst=0.8, q_long=1.0, q_short=2.0).moments()
    asperities = []
    for deviations in (6, 12):
        contact = bush_gibson_thomas(deviations * moments.rms_height, moments=moments, contact_modulus=1.0)
        asperities.append(float(contact.area) / float(contact.pressure))
    limit = math.sqrt(2 * math.pi)
    # The first correction is of the order of one over the square of the separation in standard deviations.
    approach = (limit - asperities[0]) / (limit - asperities[1])
    words = "kappa of independent asperities at 12 standard deviations"
    yield relative(words, asperities[1], limit, 0.5 / 144)
    yield relative("its distance to sqrt(2 pi) at 6 over that at 12", approach, 4.0, 0.1)


@case("theory-distribution", source="Persson 2006, Eqs. 16-20")
def _distribution() -> Checks:
    """P(sigma) integrates to A/A0 = erf(p0 / sqrt(2 V)) and carries the load."""
    variance = 0.25
    for pressure in (0.01, 0.3, 1.0):

        def density(stress: float, pressure: float = pressure) -> float:
            return float(elastic.pressure_distribution(stress, pressure=pressure, stress_variance=variance))

        top = pressure + 12 * math.sqrt(variance)
        area = integral(density, 0, top)
        load = integral(lambda stress: stress * density(stress), 0, top)
        exact = math.erf(pressure / math.sqrt(2 * variance))
        closed = elastic.contact_area(pressure, stress_variance=variance)
        yield relative(f"A/A0 at p0 = {pressure}", closed, exact, 1e-14)
        yield relative(f"integral of P at p0 = {pressure}", area, exact, 1e-9)
        yield relative(f"first moment of P at p0 = {pressure}", load, pressure, 1e-9)


@case("theory-variance", source="Persson 2006, Eq. 21")
def _variance() -> Checks:
    """V is twice G p0^2, with G by quadrature over C(q)."""
    spectrum = SelfAffine.from_rms_height(1e-6, hurst=0.8, q_long=1e5, q_short=1e8)
    modulus, pressure = 2e6, 1e4
    # Eq. 21: G(q) = (pi/4) (E* / p0)^2 int q^3 C dq, and V = 2 G p0^2.
    ends = math.log(1e5), math.log(1e8)
    third_moment = integral(lambda x: math.exp(4 * x) * float(spectrum(math.exp(x))), *ends)
    g = math.pi / 4 * (modulus / pressure) ** 2 * third_moment
    variance = elastic.stress_variance(spectrum.m2(), contact_modulus=modulus)
    yield relative("V = 2 G p0^2 [Pa^2]", variance, 2 * g * pressure**2, 1e-9)
