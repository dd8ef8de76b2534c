"""Stress below a contact: Hertz's and Westergaard's fields, finite elements, equilibrium in layers."""

from __future__ import annotations

from collections.abc import Iterator
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
from fem_contact.surface import HeightField
from validation.arrays import Array
from validation.cases import Case, Check, below, order, relative
from validation.cases._closed_forms import (
    HertzInPeriod,
    huber_stress,
    westergaard_mean_pressure,
    westergaard_stress,
)

__all__ = ["CASES"]

_NU = 0.3
_HALF_SPACE = HalfSpace(solid=Solid(young=1.0, poisson=_NU))


def _hertz() -> Iterator[Check]:
    """Six components below a paraboloid, and the point that yields first."""
    n, a = 256, 0.1
    case = HertzInPeriod(radius=a, contact_modulus=_HALF_SPACE.contact_modulus)
    result = bem.solve(case.surface(n, (0.0, 0.0)), _HALF_SPACE, mean_pressure=case.load).checked()
    x = np.arange(n) / n - 0.5
    inside = case.distance(n, (0.0, 0.0)) < 2 * a
    # The images are known up to (a/L)^3 of the peak; a cell is a/26.
    for plane in planes_below(result, _HALF_SPACE, depths=[0.3 * a, 0.5 * a, a]):
        exact = case.stress(x[:, None], x[None, :], plane.depth, poisson=_NU)
        worst = float(np.max(np.abs(plane.stress - exact)[inside])) / case.peak
        yield below(f"largest error over the peak, depth {plane.depth / a:g} a", worst, a**3)
    strongest = strongest_point(result, _HALF_SPACE)
    exact_depth = minimize_scalar(
        lambda depth: -_on_axis(case, depth), bounds=(0.3 * a, 0.7 * a), method="bounded"
    ).x
    top = _on_axis(case, exact_depth) / case.peak
    # What the images press sideways is known; without it the sphere stands alone.
    (plane,) = planes_below(result, _HALF_SPACE, depths=[0.48 * a])
    origin, depth = np.zeros(()), 0.48 * a
    images = case.stress(origin, origin, depth, poisson=_NU) - huber_stress(
        origin, origin, depth, radius=a, peak=case.peak, poisson=_NU
    )
    alone = (plane.stress[n // 2, n // 2] - images) / case.peak
    yield relative("largest von Mises stress over the peak", strongest.von_mises / case.peak, top, 1e-3)
    yield relative("its depth over a", strongest.depth / a, exact_depth / a, 0.01)
    yield relative(
        "shear stress at .48 a of a sphere alone, over the peak", (alone[0] - alone[2]) / 2, 0.31, 0.005
    )


def _on_axis(case: HertzInPeriod, depth: float) -> float:
    return float(von_mises(case.stress(np.zeros(()), np.zeros(()), depth, poisson=_NU)))


def _wave() -> Iterator[Check]:
    """Plane strain below a wave in partial contact, converging."""
    half_width, amplitude, sizes = 0.3, 0.01, (64, 128, 256, 512)
    load = westergaard_mean_pressure(
        amplitude, half_width=half_width, contact_modulus=_HALF_SPACE.contact_modulus
    )
    errors = []
    for n in sizes:
        # The edge of the contact lies midway between two points on every grid.
        x = (np.arange(n) + 0.5) / n - 0.5
        heights = amplitude * np.cos(2 * np.pi * x)[:, None] * np.ones(4)
        surface = HeightField(heights=heights, lengths=(1.0, 4 / n))
        result = bem.solve(surface, _HALF_SPACE, mean_pressure=load).checked()
        (plane,) = planes_below(result, _HALF_SPACE, depths=[0.05])
        exact = westergaard_stress(x, 0.05, half_width=half_width, mean_pressure=load, poisson=_NU)
        errors.append(float(np.max(np.abs(plane.stress[:, 1] - exact))) / load)
    yield order("observed order of the stress at depth .05", sizes, errors, expected=2, tolerance=0.7)
    yield below(f"largest error over p0 at n = {sizes[-1]}", errors[-1], 1e-4)


def _finite_elements() -> Iterator[Check]:
    """Compare the block's own stress on its mesh with that of a bonded layer, away from the surface."""
    solid, n, depth = Solid(young=1.0, poisson=_NU), 32, 0.5
    x = np.arange(n) / n
    wave = 0.02 * np.cos(2 * np.pi * x)[:, None] * np.cos(2 * np.pi * x)[None, :]
    surface = HeightField(heights=wave, lengths=(1.0, 1.0))
    solution = block.solve(surface, solid, mean_pressure=0.01, depth=depth, growth=1.1)
    centred = replace(solution.contact, pressure=_half_a_cell_on(solution.contact.pressure))
    middles = -(solution.planes[1:] + solution.planes[:-1]) / 2
    beneath = fields_below(centred, BondedLayer(solid=solid, thickness=depth), depths=middles[::-1])
    stress = solution.stress().tensor
    missed = np.max(np.abs(beneath.stress[:, :, ::-1] - stress), axis=(0, 1, 3)) / np.max(np.abs(stress))
    deep, close = middles > 0.1, middles > 1.0 / n
    yield below("largest difference over the largest stress, deeper than .1 L", missed[deep].max(), 0.005)
    yield below("the same, from the second layer of cells on", missed[close].max(), 0.02)


def _half_a_cell_on(field: Array) -> Array:
    """Return a field at the centres of the cells between its points."""
    nx, ny = field.shape
    phase = np.exp(1j * np.pi * (np.fft.fftfreq(nx)[:, None] + np.fft.rfftfreq(ny)[None, :]))
    phase[nx // 2], phase[:, -1] = 0, 0
    return np.fft.irfft2(np.fft.rfft2(field) * phase, s=field.shape)


def _balance(response: Response, depth: float) -> Iterator[Check]:
    """Divergence of the stress and tractions at the surface, of a smooth pressure on a layered solid."""
    n = 16
    x = np.arange(n) / n
    waves = np.cos(2 * np.pi * x)[:, None] * (1 + 0.5 * np.sin(4 * np.pi * x + 0.3))[None, :]
    surface = HeightField(heights=1e-3 * waves, lengths=(1.0, 1.0))
    result: ContactResult = bem.solve(surface, response, mean_pressure=1.0).checked()
    errors, steps = [], (8, 16, 32)
    for count in steps:
        step = 0.02 / count
        z = depth + step * np.array([-1, 0, 1])
        stress = fields_below(result, response, depths=z).stress
        errors.append(_divergence(stress, step) * result.lengths[0] / float(np.ptp(result.pressure)))
    (top,) = planes_below(result, response, depths=[0.0])
    scale = float(np.max(result.pressure))
    yield order("observed order of div sigma in the step of depth", steps, errors, expected=2, tolerance=0.1)
    yield below("div sigma L over the range of pressure", errors[-1], 1e-3)
    yield below(
        "s_zz + p at the surface", np.max(np.abs(top.stress[..., 2] + result.pressure)) / scale, 1e-12
    )
    yield below("shear at the surface", np.max(np.abs(top.stress[..., 3:5])) / scale, 1e-12)


def _divergence(stress: Array, step: float) -> float:
    """Largest component of div sigma on the middle of three planes."""
    n = stress.shape[0]
    q = 2j * np.pi * np.fft.fftfreq(n, 1 / n)

    def along(axis: int, component: int) -> Array:
        shape = (-1, 1) if axis == 0 else (1, -1)
        waves = np.fft.fft(stress[:, :, 1, component], axis=axis) * q.reshape(shape)
        return np.fft.ifft(waves, axis=axis).real

    def upwards(component: int) -> Array:
        return np.asarray((stress[:, :, 0, component] - stress[:, :, 2, component]) / (2 * step))

    balance = (
        along(0, 0) + along(1, 5) + upwards(4),
        along(0, 5) + along(1, 1) + upwards(3),
        along(0, 4) + along(1, 3) + upwards(2),
    )
    return float(np.max(np.abs(balance)))


_SOFT, _HARD = Solid(young=1.0, poisson=0.3), Solid(young=8.0, poisson=0.45)
_BODIES: dict[str, tuple[Response, float]] = {
    "bonded": (BondedLayer(solid=_SOFT, thickness=0.3), 0.1),
    "frictionless": (FrictionlessLayer(solid=_SOFT, thickness=0.3), 0.1),
    "layered": (LayeredSolid(layers=[_SOFT, _HARD], thicknesses=[0.05, 0.1], base=_SOFT), 0.1),
}

CASES = (
    Case(
        name="subsurface-hertz",
        claim="The stress below a paraboloid is Huber's within .1 % of the peak, and yields first at .48 a.",
        run=_hertz,
        tolerance="estimate",
        source="M. T. Huber, Ann. Phys. 14, 153 (1904); K. L. Johnson, Contact Mechanics, Sec. 3.4",
    ),
    Case(
        name="subsurface-westergaard",
        claim="The stress below a wave in partial contact converges to Westergaard's.",
        run=_wave,
        tolerance="grid",
        source="H. M. Westergaard, J. Appl. Mech. 6, 49 (1939)",
    ),
    Case(
        name="subsurface-fem",
        claim="The stress below a contact is that of the finite elements under the same pressures.",
        run=_finite_elements,
        tolerance="grid",
        source="fem_contact.block, which shares nothing with it but the pressures",
    ),
    *(
        Case(
            name=f"subsurface-{name}",
            claim=f"The stress in a {name} solid is in equilibrium and meets the pressure at its surface.",
            run=partial(_balance, response, depth),
            tolerance="grid",
            source="div sigma = 0; sigma n = -p n",
        )
        for name, (response, depth) in _BODIES.items()
    ),
)
