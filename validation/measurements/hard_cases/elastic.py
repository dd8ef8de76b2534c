"""Hard cases of the elastic half-space: load, gradient, exponent, scales, ties, precision, paths."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from functools import partial

import numpy as np

from fem_contact import bem
from fem_contact.contact import ContactResult, Status
from fem_contact.surface import HeightField
from validation.effects.base import ContactModel
from validation.measurements.hard_cases.cases import HALF_SPACE, HardCase, Measured, judged, rough, wave
from validation.solvers import chosen_solver
from validation.solvers.base import Job

#: Mean pressure over E* h'_rms where the gradient is turned.
_LIGHT = 0.05


#: How a solver is asked: a surface and a mean pressure on `HALF_SPACE`.
Pressing = Callable[[HeightField, float], ContactResult]


def _boundary_elements(surface: HeightField, load: float) -> ContactResult:
    return bem.solve(surface, HALF_SPACE, mean_pressure=load, threads=1)


def _westergaard(press: Pressing, load: float) -> Measured:
    points = 512
    surface = wave(points)
    result = press(surface, load * math.pi * 0.01)
    exact = 1.0 if load >= 1 else 2 / math.pi * math.asin(math.sqrt(load))
    return judged(result, abs(float(np.mean(result.in_contact)) - exact) * points)


def _steepness(press: Pressing, gradient: float) -> Measured:
    pressures = []
    for value in (0.1, gradient):
        result = press(rough(gradient=value), _LIGHT * value)
        pressures.append(result.pressure / value)
    return judged(result, float(np.linalg.norm(pressures[1] - pressures[0]) / np.linalg.norm(pressures[0])))


def _against_plain(press: Pressing, surface: HeightField, load: float) -> Measured:
    result = press(surface, load)
    plain = bem.solve(
        surface, HALF_SPACE, mean_pressure=load, max_iterations=20_000, method="polonsky-keer", threads=1
    )
    return judged(
        result, float(np.linalg.norm(result.pressure - plain.pressure) / np.linalg.norm(plain.pressure))
    )


def _hurst(press: Pressing, hurst: float) -> Measured:
    return _against_plain(press, rough(hurst=hurst, waves=16), 0.005)


def _scales(press: Pressing, points: float) -> Measured:
    n = int(points)
    return _against_plain(press, rough(n, waves=n // 4), 0.005)


def _quantised(press: Pressing, levels: float) -> Measured:
    smooth = rough()
    step = np.ptp(smooth.heights) / levels
    surface = HeightField(heights=np.round(smooth.heights / step) * step, lengths=(1.0, 1.0))
    return _against_plain(press, surface, 0.005)


def _few_bits(press: Pressing, bits: float) -> Measured:
    exact = rough()
    mantissa, exponent = np.frexp(exact.heights)
    rounded = np.ldexp(np.round(mantissa * 2.0**bits) / 2.0**bits, exponent)
    results = [press(HeightField(heights=h, lengths=(1.0, 1.0)), 0.005) for h in (exact.heights, rounded)]
    # Contact is monotone: no offset moves by more than the heights did, nor by more than the solver leaves.
    allowed = float(np.max(np.abs(rounded - exact.heights))) + 1e-7 * exact.rms_height
    return judged(results[1], abs(results[1].offset - results[0].offset) / allowed)


def _path(factor: float) -> Measured:
    loads = 1e-4 * factor ** np.arange(max(2, round(math.log(1e3) / math.log(factor)) + 1))
    there_and_back = [*loads, *loads[-2::-1]]
    results = bem.solve_path(rough(), HALF_SPACE, mean_pressures=there_and_back, threads=1)
    pairs = zip(results, results[::-1], strict=True)
    errors = [np.linalg.norm(a.pressure - b.pressure) / np.linalg.norm(b.pressure) for a, b in pairs]
    worst = max(results, key=lambda result: result.residuals.worst)
    failed = [result for result in results if result.status is not Status.CONVERGED]
    return judged(failed[0] if failed else worst, float(max(errors)))


def _single_precision(height: float) -> Measured:
    exact = rough()
    mean = height * exact.rms_height
    stored = (exact.heights + mean).astype(np.float32).astype(float)
    double = bem.solve(exact, HALF_SPACE, mean_pressure=0.005, threads=1)
    single = bem.solve(
        HeightField(heights=stored, lengths=(1.0, 1.0)), HALF_SPACE, mean_pressure=0.005, threads=1
    )
    # Contact is monotone: no offset moves by more than the heights did, nor by more than the solver leaves.
    allowed = float(np.max(np.abs(stored - exact.heights - mean))) + 1e-7 * exact.rms_height
    return judged(single, abs(single.offset - mean - double.offset) / allowed)


def elastic_cases(method: str, press: Pressing) -> tuple[HardCase, ...]:
    """Return the hard cases of the half-space that any solver can be put through, by one of them."""
    ending = "" if method == "bem" else f"-{re.sub('[^A-Za-z0-9]+', '-', method)}"
    return (
        HardCase(
            name=f"load{ending}",
            method=method,
            varied="p0 / p* of a wave, 1 is full contact",
            values=(2.0, 1.0, 0.9999, 0.999, 0.99, 0.9, 0.5, 0.1, 0.01, 1e-3, 1e-4, 1e-6, 1e-9),
            reference="Westergaard's contact width; error in cells of 512",
            bound=2.5,
            measure=partial(_westergaard, press),
        ),
        HardCase(
            name=f"gradient{ending}",
            method=method,
            varied="h'_rms",
            values=(0.1, 1.0, 10.0, 1e4, 1e-3, 1e-6, 1e-12, 1e-100),
            reference="the same pressure over E* h'_rms as at 0.1; relative L2",
            bound=1e-5,
            limit="pressures below 1e-30 Pa are refused; here E* is 1 Pa",
            refusable=lambda value: _LIGHT * value < 1e-30,
            measure=partial(_steepness, press),
        ),
        HardCase(
            name=f"hurst{ending}",
            method=method,
            varied="H",
            values=(0.0, 0.1, 0.3, 0.5, 0.8, 0.95, 1.0),
            reference="Polonsky-Keer on the same grid; relative L2 of the pressure",
            bound=1e-4,
            measure=partial(_hurst, press),
        ),
        HardCase(
            name=f"scales{ending}",
            method=method,
            varied="points along a side, lambda_short = 4 dx",
            values=(16.0, 32.0, 64.0, 128.0, 256.0, 512.0),
            reference="Polonsky-Keer on the same grid; relative L2 of the pressure",
            bound=1e-4,
            measure=partial(_scales, press),
        ),
        HardCase(
            name=f"ties{ending}",
            method=method,
            varied="levels of quantised heights, from many to few",
            values=(1e6, 1e3, 100.0, 20.0, 5.0, 2.0),
            reference="Polonsky-Keer on the same heights; relative L2 of the pressure",
            bound=1e-4,
            measure=partial(_quantised, press),
        ),
        HardCase(
            name=f"precision{ending}",
            method=method,
            varied="bits of the heights' mantissa, from double to a few",
            values=(52.0, 23.0, 16.0, 11.0, 8.0, 6.0),
            reference="offset of the heights in double; change over that of the heights",
            bound=1.0,
            measure=partial(_few_bits, press),
        ),
    )


def by_method(name: str) -> tuple[HardCase, ...]:
    """Return the same for a solver by name, or a function of the user's."""
    solver, options = chosen_solver(name)

    def press(surface: HeightField, load: float) -> ContactResult:
        model = ContactModel(solid=HALF_SPACE.solid)
        job = Job(field=surface, load={"mean_pressure": load}, model=model, settings=options, threads=1)
        return solver.solve(job).contact

    return elastic_cases(name, press)


ELASTIC = (
    *elastic_cases("bem", _boundary_elements),
    HardCase(
        name="path",
        method="bem",
        varied="factor between successive loads, up and down over three decades",
        values=(1.5, 3.0, 10.0, 30.0, 1000.0),
        reference="the same pressures on the way down as on the way up; relative L2",
        bound=1e-4,
        measure=_path,
    ),
)

SINGLE_PRECISION = HardCase(
    name="single",
    method="bem",
    varied="mean height over h_rms, heights in single precision",
    values=(0.0, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6),
    reference="offset of the heights in double; change over that of the heights",
    bound=1.0,
    measure=_single_precision,
)
