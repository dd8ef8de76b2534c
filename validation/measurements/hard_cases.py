"""Hard cases with known answers: what is varied, what is right, what may be refused."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from fem_contact import adhesion, bem
from fem_contact.adhesion import path as adhesion_path
from fem_contact.contact import ContactResult, Status
from fem_contact.graded import LayeredSolid
from fem_contact.hardness import Hardness, press_yielding, yielded
from fem_contact.response import BondedLayer, HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField, random_surface
from persson.diffusion import solve_diffusion
from persson.hardness import constant_hardness
from persson.spheres import maugis_pull_off
from validation.arrays import Array
from validation.effects.base import ContactModel
from validation.measurements.statistics import relative_distance
from validation.solvers import chosen_solver

_SOLID = Solid(young=1.0, poisson=0.3)
_HALF_SPACE = HalfSpace(solid=Solid(young=1.0, poisson=0.0))
#: Mean pressures: over E* h'_rms where the gradient is turned, of roughness, and under a hardness.
_STEEP, _LIGHT, _LOAD = 0.05, 0.005, 0.01


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What one value of the parameter gave."""

    error: float  # Distance to the reference, as the case defines it
    residual: float = math.nan  # The solver's own, dimensionless; NaN where a method has none
    status: Status = Status.CONVERGED


@dataclass(frozen=True)
class HardCase:
    """One difficulty with the parameter that is varied."""

    name: str
    varied: str  # Which parameter, in words with its unit
    reference: str  # What is right, in words
    _: KW_ONLY
    method: str = "bem"
    values: tuple[float, ...]  # Its values, from easy to hard
    bound: float  # Largest error that counts as right
    measure: Callable[[float], Measured]
    refusable: tuple[float, ...] = ()  # Those at which a refusal is allowed


def _wave(points: int, *, rows: int = 4) -> HeightField:
    x = np.arange(points) / points
    heights = 0.01 * np.cos(2 * np.pi * x)[:, None] * np.ones(rows)
    return HeightField(heights=heights, lengths=(1.0, rows / points))


def _rough(points: int = 64, *, hurst: float = 0.8, gradient: float = 0.1, waves: int = 8) -> HeightField:
    size: dict[str, Any] = {"q_short": waves * 2 * np.pi, "lengths": (1.0, 1.0), "shape": (points, points)}
    surface = random_surface(lambda q: q ** (-2 - 2 * hurst), seed=41, **size)
    return _square(surface.heights * (gradient / surface.rms_gradient))


def _square(heights: Array) -> HeightField:
    return HeightField(heights=heights, lengths=(1.0, 1.0))


def _measured(result: ContactResult, error: float) -> Measured:
    return Measured(error=error, residual=result.residuals.worst, status=result.status)


# ---- the elastic half-space ----------------------------------------------------------------------


#: How a solver is asked: a surface and a mean pressure on the half-space.
_Press = Callable[[HeightField, float], ContactResult]


def _bem(surface: HeightField, load: float, **more: Any) -> ContactResult:
    result: ContactResult = bem.solve(surface, _HALF_SPACE, mean_pressure=load, threads=1, **more)
    return result


def _westergaard(press: _Press, load: float) -> Measured:
    points = 512
    result = press(_wave(points), load * math.pi * 0.01)
    exact = 1.0 if load >= 1 else 2 / math.pi * math.asin(math.sqrt(load))
    return _measured(result, abs(float(np.mean(result.in_contact)) - exact) * points)


def _steepness(press: _Press, gradient: float) -> Measured:
    usual, steep = (press(_rough(gradient=value), _STEEP * value) for value in (0.1, gradient))
    return _measured(steep, relative_distance(steep.pressure / gradient, usual.pressure / 0.1))


def _against_plain(press: _Press, surface: HeightField) -> Measured:
    result = press(surface, _LIGHT)
    plain = _bem(surface, _LIGHT, max_iterations=20_000, method="polonsky-keer")
    return _measured(result, relative_distance(result.pressure, plain.pressure))


def _quantised(press: _Press, levels: float) -> Measured:
    smooth = _rough()
    step = np.ptp(smooth.heights) / levels
    return _against_plain(press, _square(np.round(smooth.heights / step) * step))


def _offset_of(press: _Press, rounded: Array, *, mean: float = 0.0) -> Measured:
    """How far rounded heights, raised by `mean`, move the offset, over the most that their rounding can.

    Contact is monotone: the offset moves by no more than the highest change of a height, and the residual.
    """
    exact = _rough()
    reference, perturbed = (press(_square(heights), _LIGHT) for heights in (exact.heights, rounded))
    allowed = np.max(np.abs(rounded - exact.heights - mean)) + 1e-7 * exact.rms_height
    return _measured(perturbed, abs(perturbed.offset - mean - reference.offset) / allowed)


def _few_bits(press: _Press, bits: float) -> Measured:
    mantissa, exponent = np.frexp(_rough().heights)
    return _offset_of(press, np.ldexp(np.round(mantissa * 2.0**bits) / 2.0**bits, exponent))


def _single_precision(height: float) -> Measured:
    exact = _rough()
    mean = height * exact.rms_height
    return _offset_of(_bem, (exact.heights + mean).astype(np.float32).astype(float), mean=mean)


def _path(factor: float) -> Measured:
    """Up from a thousandth of E* h' by this factor and down again: the way back must be the way there."""
    loads = 1e-4 * factor ** np.arange(max(2, round(math.log(1e3) / math.log(factor)) + 1))
    results = bem.solve_path(_rough(), _HALF_SPACE, mean_pressures=[*loads, *loads[-2::-1]], threads=1)
    errors = [relative_distance(a.pressure, b.pressure) for a, b in zip(results, results[::-1], strict=True)]
    worst = max(results, key=lambda one: (one.status is not Status.CONVERGED, one.residuals.worst))
    return _measured(worst, max(errors))


def elastic_cases(method: str) -> tuple[HardCase, ...]:
    """Return the hard cases of the half-space that any solver can be put through, by name or ``module:function``."""
    press: _Press
    press, ending = _bem, ""
    if method != "bem":
        ending = f"-{re.sub('[^A-Za-z0-9]+', '-', method)}"
        solver, options = chosen_solver(method)

        def by_name(surface: HeightField, load: float) -> ContactResult:
            return solver.pressed(surface, ContactModel(solid=_HALF_SPACE.solid), load, **options)

        press = by_name

    plain = "Polonsky-Keer on the same {}; relative L2 of the pressure"
    cases = (
        HardCase(
            "load",
            "p0 / p* of a wave, 1 is full contact",
            "Westergaard's contact width; error in cells of 512",
            values=(2.0, 1.0, 0.9999, 0.999, 0.99, 0.9, 0.5, 0.1, 0.01, 1e-3, 1e-4, 1e-6, 1e-9),
            bound=2.5,
            measure=partial(_westergaard, press),
        ),
        HardCase(
            "gradient",
            "h'_rms",
            "the same pressure over E* h'_rms as at 0.1; relative L2",
            values=(0.1, 1.0, 10.0, 1e4, 1e-3, 1e-6, 1e-12, 1e-100),
            bound=1e-5,
            refusable=(1e-100,),  # pressures below 1e-30 Pa; here E* is 1 Pa
            measure=partial(_steepness, press),
        ),
        HardCase(
            "hurst",
            "H",
            plain.format("grid"),
            values=(0.0, 0.1, 0.3, 0.5, 0.8, 0.95, 1.0),
            bound=1e-4,
            measure=lambda hurst: _against_plain(press, _rough(hurst=hurst, waves=16)),
        ),
        HardCase(
            "scales",
            "points along a side, lambda_short = 4 dx",
            plain.format("grid"),
            values=(16.0, 32.0, 64.0, 128.0, 256.0, 512.0),
            bound=1e-4,
            measure=lambda points: _against_plain(press, _rough(int(points), waves=int(points) // 4)),
        ),
        HardCase(
            "ties",
            "levels of quantised heights, from many to few",
            plain.format("heights"),
            values=(1e6, 1e3, 100.0, 20.0, 5.0, 2.0),
            bound=1e-4,
            measure=partial(_quantised, press),
        ),
        HardCase(
            "precision",
            "bits of the heights' mantissa, from double to a few",
            "offset of the heights in double; change over that of the heights",
            values=(52.0, 23.0, 16.0, 11.0, 8.0, 6.0),
            bound=1.0,
            measure=partial(_few_bits, press),
        ),
    )
    return tuple(replace(case, name=case.name + ending, method=method) for case in cases)


# ---- effects -------------------------------------------------------------------------------------


def _yielding(result: ContactResult, ratio: float, difference: float = 0.0) -> Measured:
    """By how much loads and bound are missed, relative to the load and the hardness."""
    unloaded, hardness = yielded(result), ratio * _LOAD
    load = abs(unloaded.elastic_load + unloaded.plastic_load - _LOAD) / _LOAD
    plastic = abs(unloaded.plastic_load - hardness * unloaded.plastic_area) / _LOAD
    errors = [load, plastic, np.max(result.pressure) / hardness - 1, difference]
    return _measured(result, np.max(errors))


def _hard(ratio: float) -> Measured:
    hardness = Hardness(pressure=ratio * _LOAD)
    result = press_yielding(_rough(), _HALF_SPACE, hardness=hardness, mean_pressure=_LOAD, threads=1)
    return _yielding(result, ratio)


def _yielding_block(ratio: float) -> Measured:
    from fem_contact import block

    options: dict[str, Any] = {"mean_pressure": _LOAD, "pressure_bound": ratio * _LOAD, "tolerance": 1e-9}
    full, reduced = (
        block.solve(_rough(16, waves=4), _SOLID, method=method, depth=0.3, growth=1.5, **options).contact
        for method in ("full", "reduced")
    )
    return _yielding(full, ratio, relative_distance(full.pressure, reduced.pressure))


def _yielding_under_adhesion(ratio: float) -> Measured:
    """Under a law of the gap as strong as the contact's own stresses."""
    work = 1e-4
    law = adhesion.Exponential(work=work, reach=math.sqrt(3 / 64 * work))
    options: dict[str, Any] = {"hardness": ratio * _LOAD, "mean_pressure": _LOAD, "tolerance": 1e-10}
    return _yielding(adhesion.solve(_rough(), _HALF_SPACE, law=law, threads=1, **options).contact, ratio)


def _sticky(maugis: float) -> Measured:
    points, length, radius, stiffness = 96, 12.0, 100.0, 4 / 3
    work = stiffness / (math.pi * radius**2)
    strength = maugis / 2 * (math.pi * work * stiffness**2 / radius) ** (1 / 3)
    x = (np.arange(points) - points // 2) * length / points
    heights = -(x[:, None] ** 2 + x[None, :] ** 2) / (2 * radius)
    ball = HeightField(heights=heights, lengths=(length, length))
    law, offsets = adhesion.Dugdale(work=work, reach=work / strength), np.arange(-0.3, 1.0, 0.05) / radius
    path = adhesion_path.follow(ball, _HALF_SPACE, law=law, offsets=offsets, threads=1)
    force = path.greatest_tension * length**2 / (math.pi * work * radius)
    return _measured(path.last.contact, abs(force / maugis_pull_off(maugis / 1.157) - 1))


def _contrast(ratio: float) -> Measured:
    coating, q = Solid(young=ratio, poisson=0.3), np.geomspace(1e-2, 1e3, 200)
    layered, cut = (
        LayeredSolid(layers=[coating] * len(thicknesses), thicknesses=thicknesses, base=_SOLID)
        for thicknesses in ([0.1], [0.02, 0.05, 0.03])
    )
    change = cut.compliance(q, 0 * q) / layered.compliance(q, 0 * q) - 1
    result = bem.solve(_rough(), layered, mean_pressure=1e-4 * min(ratio, 1.0), threads=1)
    return _measured(result, np.max(np.abs(change)))


def _full_contact(points: int, *, poisson: float = 0.3, depth: float = 1.0, **settings: Any) -> Measured:
    from fem_contact import block

    solid = Solid(young=1.0, poisson=poisson)
    layer = BondedLayer(solid=solid, thickness=depth)
    exact = 0.01 / layer.compliance(np.array([2 * np.pi]), np.zeros(1))[0]
    options: dict[str, Any] = {"mean_pressure": 1.5 * exact, "depth": depth, "growth": 1.1, **settings}
    contact = block.solve(_wave(points, rows=points), solid, **options).contact
    cosine = np.cos(2 * np.pi * np.arange(points) / points)
    amplitude = 2 * np.mean(contact.pressure[:, 0] * cosine)
    return _measured(contact, abs(amplitude / exact - 1))


def _large_block(points: float) -> Measured:
    """Trilinear cells err with the square of the spacing, by 2 % at 32."""
    amplitude = _full_contact(int(points), depth=0.3, method="full")
    return replace(amplitude, error=amplitude.error / (0.02 * (32 / points) ** 2))


def _diffusion(ratio: float) -> Measured:
    case: dict[str, Any] = {"pressure": 0.1, "yield_stress": 1.0}
    diffused = solve_diffusion(np.array([ratio]), **case)
    exact = constant_hardness(stress_variance=np.array([ratio]), **case)
    error = abs(diffused.area_plastic[0] - exact.plastic[0])
    return Measured(error=error, residual=diffused.load_residual[0])


_YIELDING = HardCase(
    "hardness",
    "H / p0, from hard to barely carrying",
    "loads add up, none above the bound; relative to the load",
    values=(1e4, 100.0, 10.0, 3.0, 1.5, 1.1, 1.01, 1.001, 1.0, 0.99),
    bound=1e-9,
    refusable=(0.99,),  # nothing carries the load
    measure=_hard,
)
_BLOCK = HardCase(
    "poisson",
    "nu",
    "bonded layer, wave of 32 nodes in full contact; relative",
    method="fem",
    values=(-0.5, 0.0, 0.3, 0.45, 0.49, 0.499, 0.4999, 0.499999, 0.5, 0.51),
    bound=0.02,
    refusable=(0.51,),  # there is no such solid
    measure=lambda nu: _full_contact(32, poisson=nu),
)

CASES: tuple[HardCase, ...] = (
    *elastic_cases("bem"),
    HardCase(
        "path",
        "factor between successive loads, up and down over three decades",
        "the same pressures on the way down as on the way up; relative L2",
        values=(1.5, 3.0, 10.0, 30.0, 1000.0),
        bound=1e-4,
        measure=_path,
    ),
    _YIELDING,
    HardCase(
        "adhesion",
        "Maugis's lambda of a sphere, from weak and far to sticky and near",
        "Maugis's pull-off force; relative",
        values=(0.1, 0.3, 1.0, 1.5, 1.9, 3.0),
        bound=0.02,
        refusable=(3.0,),  # the process zone is below 2 cells
        measure=_sticky,
    ),
    HardCase(
        "contrast",
        "modulus of a coating over the base's",
        "the same coating cut in three; relative change of the compliance",
        values=(1.0, 0.1, 10.0, 0.01, 100.0, 1e-3, 1e3, 1e-4, 1e4, 1e-8, 1e8),
        bound=1e-7,
        measure=_contrast,
    ),
    _BLOCK,
    replace(
        _BLOCK,
        name="aspect",
        varied="width of a surface cell over its height",
        values=(1.0, 3.0, 10.0, 100.0, 1000.0, 1e4),
        refusable=(),
        measure=lambda aspect: _full_contact(32, first_layer=1 / 32 / aspect),
    ),
    replace(
        _BLOCK,
        name="depth",
        varied="depth of the block over its period",
        values=(10.0, 3.0, 1.0, 0.3, 0.1, 0.03, 0.01),
        reference="bonded layer of that depth, wave of 32 nodes in full contact; relative",
        refusable=(),
        measure=lambda depth: _full_contact(32, depth=depth),
    ),
    HardCase(
        "decades",
        "V / sigma_Y^2",
        "closed form of constant hardness; A_pl/A0",
        method="theory",
        values=tuple(np.geomspace(1e-20, 1e20, 11).tolist()),
        bound=1e-5,
        measure=_diffusion,
    ),
    HardCase(
        "single",
        "mean height over h_rms, heights in single precision",
        "offset of the heights in double; change over that of the heights",
        values=(0.0, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6),
        bound=1.0,
        measure=_single_precision,
    ),
    replace(
        _YIELDING,
        name="yielding-block",
        method="fem",
        reference="active set against reduction, relative L2 of the pressure; loads add up",
        bound=1e-6,
        measure=_yielding_block,
    ),
    replace(
        _YIELDING,
        name="yielding-adhesion",
        varied="H / p0 under adhesion, from hard to barely carrying",
        reference="loads add up, none above the bound; relative to load and bound",
        # The imbalance asked for is 1e-10 of the law's strength, which is some seven times the load.
        bound=1e-8,
        refusable=(1.0, 0.99),
        measure=_yielding_under_adhesion,
    ),
    HardCase(
        "memory",
        "points along a side of the full system",
        "bonded layer, one wave in full contact; error over 2 % (32/n)^2",
        method="fem",
        values=(8.0, 16.0, 32.0, 4096.0, 8192.0),
        bound=1.0,
        refusable=(4096.0, 8192.0),  # the block takes hundreds of gigabytes
        measure=_large_block,
    ),
)
