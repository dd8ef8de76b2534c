"""Hard cases for every method: each turns one dial; what is right was written down before it was turned."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fem_contact import bem
from fem_contact.contact import ContactResult, Status
from fem_contact.response import BondedLayer, HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface

__all__ = ["HARD_CASES", "HardCase", "Measured"]

Array = NDArray[np.float64]
_UNIT = Solid(young=1.0, poisson=0.0)
_HALF = HalfSpace(solid=_UNIT)


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What one turn of a dial gave.

    Attributes
    ----------
    error : float
        Distance to the reference, as the case defines it.
    residual : float
        The solver's own, dimensionless; NaN where a method has none.
    status : Status
    """

    error: float
    residual: float = math.nan
    status: Status = Status.CONVERGED


@dataclass(frozen=True, kw_only=True)
class HardCase:
    """One difficulty with its dial.

    Attributes
    ----------
    name, method : str
    dial : str
        What is turned, in words with its unit.
    values : tuple of float
        Where it is turned to, from easy to hard.
    reference : str
        What is right, in words.
    bound : float
        Largest error that counts as right.
    limit : str
        Where a refusal is allowed, in words; empty where every value must be right.
    refusable : callable
        Whether a refusal is allowed at a value.
    measure : callable
    """

    name: str
    method: str
    dial: str
    values: tuple[float, ...]
    reference: str
    bound: float
    measure: Callable[[float], Measured]
    limit: str = ""
    refusable: Callable[[float], bool] = lambda value: False


def _wave(points: int = 64, *, amplitude: float = 0.01, rows: int = 4) -> HeightField:
    x = np.arange(points) / points
    heights = amplitude * np.cos(2 * np.pi * x)[:, None] * np.ones(rows)
    return HeightField(heights=heights, lengths=(1.0, rows / points))


def _rough(points: int = 64, *, hurst: float = 0.8, gradient: float = 0.1, waves: int = 8) -> HeightField:
    surface = random_surface(
        lambda q: q ** (-2 - 2 * hurst),
        q_short=waves * 2 * np.pi,
        lengths=(1.0, 1.0),
        shape=(points, points),
        seed=41,
    )
    return HeightField(heights=surface.heights * (gradient / surface.rms_gradient), lengths=(1.0, 1.0))


def _area(result: ContactResult) -> float:
    return float(np.mean(result.in_contact))


def _judged(result: ContactResult, error: float) -> Measured:
    return Measured(error=error, residual=result.residuals.worst, status=result.status)


def _westergaard(load: float) -> Measured:
    """Contact width of a wave under p0/p*, in cells off the exact (2/pi) asin(sqrt(p0/p*))."""
    points = 512
    surface = _wave(points)
    result = bem.solve(surface, _HALF, mean_pressure=load * math.pi * 0.01, threads=1)
    exact = 1.0 if load >= 1 else 2 / math.pi * math.asin(math.sqrt(load))
    return _judged(result, abs(_area(result) - exact) * points)


def _steepness(gradient: float) -> Measured:
    """Relative change of the pressure, over its scale, against the surface of gradient 0.1."""
    pressures = []
    for value in (0.1, gradient):
        result = bem.solve(_rough(gradient=value), _HALF, mean_pressure=0.05 * value, threads=1)
        pressures.append(result.pressure / value)
    return _judged(result, float(np.linalg.norm(pressures[1] - pressures[0]) / np.linalg.norm(pressures[0])))


def _against_plain(surface: HeightField, load: float) -> Measured:
    """Against Polonsky and Keer's method, whose convergence theory is simple."""
    result = bem.solve(surface, _HALF, mean_pressure=load, threads=1)
    plain = bem.solve(
        surface, _HALF, mean_pressure=load, max_iterations=20_000, method="polonsky-keer", threads=1
    )
    return _judged(
        result, float(np.linalg.norm(result.pressure - plain.pressure) / np.linalg.norm(plain.pressure))
    )


def _hurst(hurst: float) -> Measured:
    return _against_plain(_rough(hurst=hurst, waves=16), 0.005)


def _scales(points: float) -> Measured:
    n = int(points)
    return _against_plain(_rough(n, waves=n // 4), 0.005)


def _quantised(levels: float) -> Measured:
    """Heights rounded to so many levels: the load must balance and nothing may penetrate."""
    smooth = _rough()
    step = np.ptp(smooth.heights) / levels
    surface = HeightField(heights=np.round(smooth.heights / step) * step, lengths=(1.0, 1.0))
    return _against_plain(surface, 0.005)


def _single(bits: float) -> Measured:
    """Heights rounded to a mantissa of so many bits, against those in double precision."""
    exact = _rough()
    mantissa, exponent = np.frexp(exact.heights)
    rounded = np.ldexp(np.round(mantissa * 2.0**bits) / 2.0**bits, exponent)
    results = [
        bem.solve(HeightField(heights=h, lengths=(1.0, 1.0)), _HALF, mean_pressure=0.005, threads=1)
        for h in (exact.heights, rounded)
    ]
    # Contact is monotone: no offset moves by more than the heights did, nor by more than the solver leaves.
    allowed = float(np.max(np.abs(rounded - exact.heights))) + 1e-7 * exact.rms_height
    return _judged(results[1], abs(results[1].offset - results[0].offset) / allowed)


def _path(factor: float) -> Measured:
    """Up from a thousandth of E* h' by this factor and down again: the way back must be the way there."""
    loads = 1e-4 * factor ** np.arange(max(2, round(math.log(1e3) / math.log(factor)) + 1))
    there_and_back = [*loads, *loads[-2::-1]]
    results = bem.solve_path(_rough(), _HALF, mean_pressures=there_and_back, threads=1)
    pairs = zip(results, results[::-1], strict=True)
    errors = [np.linalg.norm(a.pressure - b.pressure) / np.linalg.norm(b.pressure) for a, b in pairs]
    worst = max(results, key=lambda result: result.residuals.worst)
    failed = [result for result in results if result.status is not Status.CONVERGED]
    return _judged(failed[0] if failed else worst, float(max(errors)))


def _hard(ratio: float) -> Measured:
    """Hardness over the mean pressure: plastic load is hardness times plastic area, and loads add up."""
    from fem_contact.hardness import Hardness, press, yielded

    load = 0.01
    result = press(_rough(), _HALF, hardness=Hardness(pressure=ratio * load), mean_pressure=load, threads=1)
    found = yielded(result)
    books = abs(found.elastic_load + found.plastic_load - load) / load
    books = max(books, abs(found.plastic_load - ratio * load * found.plastic_area) / load)
    above = float(np.max(result.pressure)) / (ratio * load) - 1
    return _judged(result, max(books, above, 0.0))


def _sticky(maugis: float) -> Measured:
    """Pull-off force of a sphere with a Dugdale law, relative to Maugis's."""
    from fem_contact.adhesion import path as adhesion_path
    from fem_contact.adhesion.laws import Dugdale
    from persson.spheres import maugis_pull_off

    points, length, radius, stiffness = 96, 12.0, 100.0, 4 / 3
    work = stiffness / (math.pi * radius**2)
    strength = maugis / 2 * (math.pi * work * stiffness**2 / radius) ** (1 / 3)
    x = (np.arange(points) - points // 2) * length / points
    surface = HeightField(
        heights=-(x[:, None] ** 2 + x[None, :] ** 2) / (2 * radius), lengths=(length, length)
    )
    path = adhesion_path.follow(
        surface,
        _HALF,
        law=Dugdale(work=work, reach=work / strength),
        offsets=np.arange(-0.3, 1.0, 0.05) / radius,
        threads=1,
    )
    force = path.greatest_tension * length**2 / (math.pi * work * radius)
    contact = path.last.contact
    return _judged(contact, abs(force / maugis_pull_off(maugis / 1.157) - 1))


def _contrast(ratio: float) -> Measured:
    """Compare a coating of this modulus (over that of the base) with the same coating cut in three."""
    from fem_contact.graded import LayeredSolid

    coating, q = Solid(young=ratio, poisson=0.3), np.geomspace(1e-2, 1e3, 200)
    base = Solid(young=1.0, poisson=0.3)
    whole = LayeredSolid(layers=[coating], thicknesses=[0.1], base=base)
    cut = LayeredSolid(layers=[coating] * 3, thicknesses=[0.02, 0.05, 0.03], base=base)
    one, two = whole.compliance(q, 0 * q), cut.compliance(q, 0 * q)
    result = bem.solve(_rough(), whole, mean_pressure=1e-4 * min(ratio, 1.0), threads=1)
    return _judged(result, float(np.max(np.abs(two / one - 1))))


def _block_error(*, poisson: float = 0.3, depth: float = 1.0, first: float | None = None) -> Measured:
    """Pressure of full contact on a wave of 32 nodes, against the bonded layer of the same depth."""
    from fem_contact import block

    surface = _wave(32, rows=32)
    solid = Solid(young=1.0, poisson=poisson)
    exact = 0.01 / float(
        BondedLayer(solid=solid, thickness=depth).compliance(np.array([2 * np.pi]), np.zeros(1))[0]
    )
    contact = block.solve(
        surface, solid, mean_pressure=1.5 * exact, depth=depth, growth=1.1, first_layer=first
    ).contact
    found = 2 * float(np.mean(contact.pressure[:, 0] * np.cos(2 * np.pi * np.arange(32) / 32)))
    return _judged(contact, abs(found / exact - 1))


def _diffusion(ratio: float) -> Measured:
    """Elastic area of a yielding solid by the diffusion equation, against its closed form."""
    from persson.diffusion import solve_diffusion
    from persson.hardness import constant_hardness

    pressure, hardness = 0.1, 1.0
    variance = np.array([ratio * hardness**2])
    found = solve_diffusion(variance, pressure=pressure, yield_stress=hardness)
    exact = constant_hardness(pressure, stress_variance=variance, yield_stress=hardness)
    error = abs(float(found.area_plastic[0] - exact.plastic[0]))
    return Measured(error=error, residual=float(found.load_residual[0]))


def _decades(low: float, high: float, steps: int) -> tuple[float, ...]:
    return tuple(float(value) for value in np.geomspace(low, high, steps))


HARD_CASES = (
    HardCase(
        name="load",
        method="bem",
        dial="p0 / p* of a wave, 1 is full contact",
        values=(2.0, 1.0, 0.9999, 0.999, 0.99, 0.9, 0.5, 0.1, 0.01, 1e-3, 1e-4, 1e-6, 1e-9),
        reference="Westergaard's contact width; error in cells of 512",
        bound=2.5,
        measure=_westergaard,
    ),
    HardCase(
        name="gradient",
        method="bem",
        dial="h'_rms",
        values=(0.1, 1.0, 10.0, 1e4, 1e-3, 1e-6, 1e-12, 1e-100),
        reference="the same pressure over E* h'_rms as at 0.1; relative L2",
        bound=1e-5,
        measure=_steepness,
    ),
    HardCase(
        name="hurst",
        method="bem",
        dial="H",
        values=(0.0, 0.1, 0.3, 0.5, 0.8, 0.95, 1.0),
        reference="Polonsky-Keer on the same grid; relative L2 of the pressure",
        bound=1e-4,
        measure=_hurst,
    ),
    HardCase(
        name="scales",
        method="bem",
        dial="points along a side, lambda_short = 4 dx",
        values=(16.0, 32.0, 64.0, 128.0, 256.0, 512.0),
        reference="Polonsky-Keer on the same grid; relative L2 of the pressure",
        bound=1e-4,
        measure=_scales,
    ),
    HardCase(
        name="ties",
        method="bem",
        dial="levels of quantised heights, from many to few",
        values=(1e6, 1e3, 100.0, 20.0, 5.0, 2.0),
        reference="Polonsky-Keer on the same heights; relative L2 of the pressure",
        bound=1e-4,
        measure=_quantised,
    ),
    HardCase(
        name="precision",
        method="bem",
        dial="bits of the heights' mantissa, from double to a few",
        values=(52.0, 23.0, 16.0, 11.0, 8.0, 6.0),
        reference="offset of the heights in double; change over that of the heights",
        bound=1.0,
        measure=_single,
    ),
    HardCase(
        name="path",
        method="bem",
        dial="factor between successive loads, up and down over three decades",
        values=(1.5, 3.0, 10.0, 30.0, 1000.0),
        reference="the same pressures on the way down as on the way up; relative L2",
        bound=1e-4,
        measure=_path,
    ),
    HardCase(
        name="hardness",
        method="bem",
        dial="H / p0, from hard to barely carrying",
        values=(1e4, 100.0, 10.0, 3.0, 1.5, 1.1, 1.01, 1.001, 1.0, 0.99),
        reference="loads add up, none above the bound; relative to the load",
        bound=1e-9,
        limit="below 1 nothing carries the load",
        refusable=lambda value: value < 1,
        measure=_hard,
    ),
    HardCase(
        name="adhesion",
        method="bem",
        dial="Maugis's lambda of a sphere, from weak and far to sticky and near",
        values=(0.1, 0.3, 1.0, 1.5, 1.9, 3.0),
        reference="Maugis's pull-off force; relative",
        bound=0.02,
        limit="above 1.9 the process zone is below 2 cells",
        refusable=lambda value: value > 1.9,
        measure=_sticky,
    ),
    HardCase(
        name="contrast",
        method="bem",
        dial="modulus of a coating over the base's",
        values=(1.0, 0.1, 10.0, 0.01, 100.0, 1e-3, 1e3, 1e-4, 1e4, 1e-8, 1e8),
        reference="the same coating cut in three; relative change of the compliance",
        bound=1e-7,
        measure=_contrast,
    ),
    HardCase(
        name="poisson",
        method="fem",
        dial="nu",
        values=(-0.5, 0.0, 0.3, 0.45, 0.49, 0.499, 0.4999, 0.499999, 0.5, 0.51),
        limit="above 1/2 there is no such solid",
        refusable=lambda value: value > 0.5,
        reference="bonded layer, wave of 32 nodes in full contact; relative",
        bound=0.02,
        measure=lambda nu: _block_error(poisson=nu),
    ),
    HardCase(
        name="aspect",
        method="fem",
        dial="width of a surface cell over its height",
        values=(1.0, 3.0, 10.0, 100.0, 1000.0, 1e4),
        reference="bonded layer, wave of 32 nodes in full contact; relative",
        bound=0.02,
        measure=lambda aspect: _block_error(first=1 / 32 / aspect),
    ),
    HardCase(
        name="depth",
        method="fem",
        dial="depth of the block over its period",
        values=(10.0, 3.0, 1.0, 0.3, 0.1, 0.03, 0.01),
        reference="bonded layer of that depth, wave of 32 nodes in full contact; relative",
        bound=0.02,
        measure=lambda depth: _block_error(depth=depth),
    ),
    HardCase(
        name="decades",
        method="theory",
        dial="V / sigma_Y^2",
        values=_decades(1e-20, 1e20, 11),
        reference="closed form of constant hardness; A_pl/A0",
        bound=1e-5,
        measure=_diffusion,
    ),
)

assert len({case.name for case in HARD_CASES}) == len(HARD_CASES)
assert all(a != b for case in HARD_CASES for a, b in itertools.pairwise(case.values))
