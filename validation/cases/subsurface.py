"""Stress below a contact: Hertz's and Westergaard's fields, finite elements, equilibrium in layers."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from scipy.optimize import minimize_scalar

from fem_contact import bem, block
from fem_contact.contact import ContactResult
from fem_contact.graded import LayeredSolid
from fem_contact.response import BondedLayer, FrictionlessLayer, HalfSpace, Response
from fem_contact.solid import Solid
from fem_contact.stress import von_mises
from fem_contact.subsurface import fields_below, planes_below, strongest_point
from validation.arrays import Array
from validation.cases import Case, Checks, below, case, order, relative
from validation.cases._closed_forms import HertzInPeriod, Westergaard, periodic, places

_NU = 0.3
_HALF_SPACE = HalfSpace(solid=Solid(young=1.0, poisson=_NU))


@case("subsurface-hertz", tolerance="estimate", source="[huber1904]; [johnson_book], Sec. 3.4")
def _hertz() -> Checks:
    """The stress below a paraboloid is Huber's within .1 % of the peak, and yields first at .48 a."""
    n, a = 256, 0.1  # nodes across the period, 1, and radius of the contact
    hertz = HertzInPeriod(radius=a, contact_modulus=_HALF_SPACE.contact_modulus)
    result = bem.solve(hertz.surface(n), _HALF_SPACE, mean_pressure=hertz.load).checked()
    x = places(n, 0.0)
    inside = hertz.distance(n) < 2 * a
    # The images are known up to (a/L)^3 of the peak; a cell is a/26.
    for plane in planes_below(result, _HALF_SPACE, depths=[0.3 * a, 0.5 * a, a]):
        exact = hertz.stress(x[:, None], x[None, :], plane.depth, poisson=_NU)
        worst = (plane.stress - exact)[inside] / hertz.peak
        yield below(f"largest error over the peak, depth {plane.depth / a:g} a", worst, a**3)

    def on_axis(depth: float) -> float:
        return float(von_mises(hertz.stress(np.zeros(()), np.zeros(()), depth, poisson=_NU))) / hertz.peak

    strongest = strongest_point(result, _HALF_SPACE)
    exact_depth = minimize_scalar(lambda z: -on_axis(z), bounds=(0.3 * a, 0.7 * a), method="bounded").x
    largest = strongest.von_mises / hertz.peak
    yield relative("largest von Mises stress over the peak", largest, on_axis(exact_depth), 1e-3)
    yield relative("its depth over a", strongest.depth / a, exact_depth / a, 0.01)


@case("subsurface-westergaard", tolerance="grid", source="[westergaard1939]")
def _wave() -> Checks:
    """The stress below a wave in partial contact converges to Westergaard's."""
    exact, errors, sizes = Westergaard(contact_modulus=_HALF_SPACE.contact_modulus), [], (64, 128, 256, 512)
    for n in sizes:
        # The edge of the contact lies midway between two points on every grid.
        result = bem.solve(exact.surface(n), _HALF_SPACE, mean_pressure=exact.load).checked()
        (plane,) = planes_below(result, _HALF_SPACE, depths=[0.05])
        off = np.abs(plane.stress[:, 1] - exact.stress(places(n), 0.05, poisson=_NU))
        errors.append(np.max(off) / exact.load)
    yield order("observed order of the stress at depth .05", sizes, errors, expected=2, tolerance=0.7)
    yield below(f"largest error over p0 at n = {sizes[-1]}", errors[-1], 1e-4)


@case(
    "subsurface-fem",
    tolerance="grid",
    source="fem_contact.block, which shares nothing with it but the pressures",
)
def _finite_elements() -> Checks:
    """The stress below a contact is that of the finite elements under the same pressures.

    Compare the block's own stress on its mesh with that of a bonded layer, away from the surface.
    """
    solid, n, depth = Solid(young=1.0, poisson=_NU), 32, 0.5
    x = np.arange(n) / n
    surface = periodic(0.02 * np.cos(2 * np.pi * x)[:, None] * np.cos(2 * np.pi * x)[None, :])
    solution = block.solve(surface, solid, mean_pressure=0.01, depth=depth, growth=1.1)
    # At the centres of the cells between the points.
    phase = np.exp(1j * np.pi * (np.fft.fftfreq(n)[:, None] + np.fft.rfftfreq(n)[None, :]))
    phase[n // 2], phase[:, -1] = 0, 0
    pressure = np.fft.irfft2(np.fft.rfft2(solution.contact.pressure) * phase, s=(n, n))
    centred = replace(solution.contact, pressure=pressure)
    middles = -(solution.planes[1:] + solution.planes[:-1]) / 2
    beneath = fields_below(centred, BondedLayer(solid=solid, thickness=depth), depths=middles[::-1])
    stress = solution.stress().tensor
    missed = np.max(np.abs(beneath.stress[:, :, ::-1] - stress), axis=(0, 1, 3)) / np.max(np.abs(stress))
    deep = missed[middles > 0.1].max()
    yield below("largest difference over the largest stress, deeper than .1 L", deep, 0.005)
    yield below("the same, in the layers of cells up to the surface", missed.max(), 0.02)


def _balance(response: Response, depth: float) -> Checks:
    """Divergence of the stress and tractions at the surface, of a smooth pressure on a layered solid."""
    n = 16
    x = np.arange(n) / n
    waves = np.cos(2 * np.pi * x)[:, None] * (1 + 0.5 * np.sin(4 * np.pi * x + 0.3))[None, :]
    result: ContactResult = bem.solve(periodic(1e-3 * waves), response, mean_pressure=1.0).checked()
    errors, steps = [], (8, 16, 32)
    for count in steps:
        step = 0.02 / count
        stress = fields_below(result, response, depths=depth + step * np.array([-1, 0, 1])).stress
        errors.append(_divergence(stress, step) * result.lengths[0] / np.ptp(result.pressure))
    (top,) = planes_below(result, response, depths=[0.0])
    scale = np.max(result.pressure)
    yield order("observed order of div sigma in the step of depth", steps, errors, expected=2, tolerance=0.1)
    yield below("div sigma L over the range of pressure", errors[-1], 1e-3)
    yield below("s_zz + p at the surface", (top.stress[..., 2] + result.pressure) / scale, 1e-12)
    yield below("shear at the surface", top.stress[..., 3:5] / scale, 1e-12)


def _divergence(stress: Array, step: float) -> float:
    """Largest component of div sigma on the middle of three planes."""
    middle, upwards = stress[:, :, 1], (stress[:, :, 0] - stress[:, :, 2]) / (2 * step)
    q = 2j * np.pi * np.fft.fftfreq(len(stress), 1 / len(stress))
    along_x = np.fft.ifft(q[:, None, None] * np.fft.fft(middle, axis=0), axis=0).real
    along_y = np.fft.ifft(q[None, :, None] * np.fft.fft(middle, axis=1), axis=1).real
    balance = along_x[..., [0, 5, 4]] + along_y[..., [5, 1, 3]] + upwards[..., [4, 3, 2]]
    return float(np.max(np.abs(balance)))


_SOFT, _HARD = Solid(young=1.0, poisson=0.3), Solid(young=8.0, poisson=0.45)
_BODIES: dict[str, tuple[Response, float]] = {
    "bonded": (BondedLayer(solid=_SOFT, thickness=0.3), 0.1),
    "frictionless": (FrictionlessLayer(solid=_SOFT, thickness=0.3), 0.1),
    "layered": (LayeredSolid(layers=[_SOFT, _HARD], thicknesses=[0.05, 0.1], base=_SOFT), 0.1),
}

CASES = tuple(
    Case(
        name=f"subsurface-{name}",
        claim=f"The stress in a {name} solid is in equilibrium and meets the pressure at its surface.",
        run=partial(_balance, response, depth),
        tolerance="grid",
        source="div sigma = 0; sigma n = -p n",
    )
    for name, (response, depth) in _BODIES.items()
)
